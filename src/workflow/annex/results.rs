//! Drives held to a requirement: what is found of each, and what all of them come to.

use std::collections::BTreeMap;

use nearmiss_drive::driver::{DRIVERS, DriverOutcome, PreventabilityRecord};
use nearmiss_drive::generation::PlannerIdentity;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::Entry;
use nearmiss_record::Record;
use nearmiss_render::{Figure, FigureOptions, MapExtent, PIXEL, Subject, svg};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::identity::family;
use nearmiss_settings::Planning;
use nearmiss_study::evaluation::Provenance;
use nearmiss_study::evaluation::statistics::{Interval, scenario_interval};
use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::SafetyRequirement;
use crate::drive::{
    BeyondBaselines, BeyondVehicleRecord, DriveFigures, DriveRecord, DrivenScenario, PlannerChoice,
    Standing, StandingRecord, beyond_baselines, drive_each, standings, thousandths,
};
use crate::{
    EventFilter, INDEX_RADIUS, IndexedEvents, OpenedScene, Overview, PlanError, RateLike,
    ScenarioEvent, VariantOrigin, Verdicts, country_code, prepare_beside, rates_like,
    scenario_events,
};

/// Why a planner, driver or baseline drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Role {
    /// It is held to the requirement.
    Planner,
    /// A driver, for comparison.
    Driver,
    /// A baseline, for comparison.
    Baseline,
}

nearmiss_record::named!(Role, "role");

/// What is found of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Finding {
    /// A contact that the driver avoids in the same seat.
    Preventable,
    /// A contact that the driver does not avoid either, at least 0.5 m/s harder than its own.
    Harder,
    /// Nothing can be said: why stands beside it.
    Open,
    /// A contact that the driver does not avoid either, and no harder than its own.
    Unpreventable,
    /// No contact, until the goal or the end of the time.
    NoContact,
}

nearmiss_record::named!(Finding, "finding");

impl Finding {
    /// Whether the requirement is met; nothing where that is open.
    #[must_use]
    pub fn is_met(self) -> Option<bool> {
        match self {
            Self::NoContact | Self::Unpreventable => Some(true),
            Self::Preventable | Self::Harder => Some(false),
            Self::Open => None,
        }
    }

    /// Of a drive, by the driver with this id, and why it is open.
    fn of(
        driven: &DrivenScenario,
        drivers: Option<&PreventabilityRecord>,
        id: &str,
    ) -> (Self, String) {
        let (finding, why) = Self::of_ending(driven, drivers, id);
        // A drive that no vehicle can do proves nothing; its contact stays one.
        match driven.beyond_vehicle().map(BeyondVehicleRecord::from) {
            Some(beyond) if finding.is_met() == Some(true) => (Self::Open, beyond.to_string()),
            _ => (finding, why),
        }
    }

    fn of_ending(
        driven: &DrivenScenario,
        drivers: Option<&PreventabilityRecord>,
        id: &str,
    ) -> (Self, String) {
        if driven.unharmed() {
            return match driven.cut_off() {
                Some(why) => (Self::Open, why),
                None => (Self::NoContact, String::new()),
            };
        }
        if driven.collision().is_none() {
            let why = driven.planner_words();
            return (
                Self::Open,
                why.unwrap_or_else(|| driven.outcome().name().into()),
            );
        }
        let Some(verdict) = drivers.and_then(|all| all.by(id)) else {
            return (Self::Open, "contact at the start".into());
        };
        if verdict.avoids() {
            return (Self::Preventable, String::new());
        }
        match (verdict.why_undecided(), verdict.result) {
            (Some(why), _) => (Self::Open, why),
            // The driver's is slower.
            (None, DriverOutcome::Mitigated) => (Self::Harder, String::new()),
            (None, _) => (Self::Unpreventable, String::new()),
        }
    }
}

/// One drive.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AnnexDrive {
    /// The scenario.
    #[schemars(title = "scenario")]
    pub scenario: String,
    /// Who drives.
    #[schemars(title = "planner")]
    pub planner: String,
    /// Why: planner, driver or baseline.
    pub role: Role,
    /// How it ended.
    #[schemars(title = "outcome")]
    pub outcome: String,
    /// no_contact, unpreventable, harder, preventable or open.
    #[schemars(title = "finding")]
    pub finding: Finding,
    /// Why it is open.
    #[schemars(title = "why open")]
    pub why_open: String,
    /// Id of the obstacle that it touches.
    #[schemars(title = "with")]
    pub obstacle: Option<i64>,
    /// Closing speed at the contact.
    #[schemars(title = "contact", extend("unit" = "m/s", "decimals" = 1))]
    pub closing_speed: Option<f64>,
    /// The same with the driver of the requirement in its seat.
    #[schemars(title = "driver's", extend("unit" = "m/s", "decimals" = 1))]
    pub driver_closing_speed: Option<f64>,
    /// Risk of a serious injury (MAIS3+) of the contact; 0 without one, null where no published curve tells it.
    #[schemars(title = "p serious", extend("decimals" = 3))]
    pub p_serious: Option<f64>,
    /// How many drivers avoid the contact in its seat, and who disagrees.
    #[schemars(title = "in its seat")]
    pub preventable_by: String,
    /// The last moment at which the driver of the requirement could have taken over, before the contact.
    #[schemars(title = "last moment", extend("unit" = "s", "decimals" = 1))]
    pub last_moment: Option<f64>,
}

impl Record for AnnexDrive {
    const NAME: &'static str = "annex-drive";
    const TITLE: &'static str = "`annex`: a drive of a scenario";
}

/// A scenario of the requirement; words are tags after ISO 34504.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct AnnexScenario {
    /// The scenario.
    #[schemars(title = "scenario")]
    pub scenario: String,
    /// Path as it was found.
    pub file: String,
    /// SHA-256 of its content.
    pub sha256: String,
    /// Seconds between its time steps.
    pub time_step: f64,
    /// Its source, as the file says.
    #[schemars(title = "source", extend("rare" = true))]
    pub source: Option<String>,
    /// Scenery: kind of road under the ego at the moment that matters, and the country.
    #[schemars(title = "scenery")]
    pub scenery: String,
    /// Environmental conditions: time of day and weather, as the file says.
    #[schemars(title = "environment", extend("rare" = true))]
    pub environment: Option<String>,
    /// Dynamic elements: what others do to the recorded ego, at the moment that matters and as events ahead of it.
    #[schemars(title = "dynamic elements")]
    pub dynamic_elements: String,
    /// Of a generated variant, the planner that its attack was searched against.
    #[schemars(title = "made against", extend("rare" = true))]
    pub made_against: Option<String>,
    /// Whether the index has it.
    pub in_index: bool,
}

impl Record for AnnexScenario {
    const NAME: &'static str = "annex-scenario";
    const TITLE: &'static str = "`annex`: a scenario";
}

/// A scenario with its drives.
#[derive(Debug, Clone)]
pub struct HeldScenario {
    /// The scenario.
    pub scenario: AnnexScenario,
    /// How often the index holds what is at least as extreme as its events, and who avoids these.
    pub rates: Vec<RateLike>,
    /// Its drives, in the order of who drives.
    pub drives: Vec<AnnexDrive>,
    /// What each says of itself, where it is a process.
    identities: Vec<Option<String>>,
    figures: Vec<DriveFigures>,
    /// By driver, what it makes of each drive's contact.
    contacts: Vec<Option<PreventabilityRecord>>,
    /// Maps of contacts of planners that speak against them or are open, with captions.
    pictures: Vec<(String, String)>,
}

/// What planners, drivers and baselines come to.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PlannerFindings {
    /// Who drives.
    #[schemars(title = "planner")]
    pub planner: String,
    /// Why: planner, driver or baseline.
    #[schemars(title = "role")]
    pub role: Role,
    /// Its name and version as its process says, and how it is asked; null for rules and the built-in planner.
    pub identity: Option<String>,
    /// Whether the requirement is met; null where nothing speaks against it, but something is open.
    pub met: Option<bool>,
    /// Drives.
    #[schemars(title = "drives")]
    pub drives: usize,
    /// Drives that reach the goal: standing still avoids contact, too.
    #[schemars(title = "goal")]
    pub goal: usize,
    /// Drives of which nothing can be said.
    #[schemars(title = "open")]
    pub open: usize,
    /// Drives without contact, to the goal or the end of the time.
    #[schemars(title = "no contact")]
    pub no_contact: usize,
    /// Contacts that the driver does not avoid either, no harder than its own.
    #[schemars(title = "unpreventable")]
    pub unpreventable: usize,
    /// Such contacts at least 0.5 m/s harder than the driver's.
    #[schemars(title = "harder")]
    pub harder: usize,
    /// Contacts that the driver avoids.
    #[schemars(title = "preventable")]
    pub preventable: usize,
    /// Share of drives that meet the requirement, of those that are not open.
    #[schemars(title = "met of decided", extend("decimals" = 2))]
    pub share_met: Option<f64>,
    /// Its interval of 95 %, scenarios on the same map drawn together; from 10 scenarios on.
    pub share_met_ci: Option<Interval>,
    /// Serious injuries (MAIS3+) expected of its contacts, a sum over the drives.
    #[schemars(title = "serious injuries (sum)", extend("decimals" = 3))]
    pub serious_injuries: f64,
    /// Contacts without a published curve, left out of the sum.
    #[schemars(title = "not in the sum", extend("rare" = true))]
    pub without_curve: usize,
}

impl Record for PlannerFindings {
    const NAME: &'static str = "annex-planner";
    const TITLE: &'static str = "`annex`: what a planner, driver or baseline comes to";
}

/// What a driver makes of a planner's contacts.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ContactsByDriver {
    /// Whose contacts.
    #[schemars(title = "contacts of")]
    pub planner: String,
    /// The driver in the same seat.
    #[schemars(title = "driver")]
    pub driver: &'static str,
    /// Contacts that it avoids.
    #[schemars(title = "avoided")]
    pub avoided: usize,
    /// Contacts that it makes slower by 0.5 m/s or more.
    #[schemars(title = "mitigated")]
    pub mitigated: usize,
    /// Contacts that it does not avoid.
    #[schemars(title = "not avoided")]
    pub not_avoided: usize,
    /// Contacts in which traffic that follows its recording runs into it.
    #[schemars(title = "hit from behind")]
    pub hit_from_behind: usize,
    /// Contacts that it is not made for.
    #[schemars(title = "not made for")]
    pub not_made_for: usize,
}

impl Record for ContactsByDriver {
    const NAME: &'static str = "annex-contacts";
    const TITLE: &'static str = "`annex`: what a driver makes of a planner's contacts";
}

/// A requirement with all that was driven for it.
#[derive(Debug, Clone)]
pub struct Annex {
    /// The requirement.
    pub requirement: SafetyRequirement,
    /// SHA-256 of its file.
    pub file_sha256: String,
    /// SHA-256 of the program.
    pub program_sha256: String,
    /// The day on which was driven, UTC.
    pub day: String,
    /// Who drives.
    pub who: Vec<(String, Role)>,
    /// Scenarios that were found, before some were selected.
    pub listed: usize,
    /// The scenarios that were driven.
    pub held: Vec<HeldScenario>,
    /// Scenarios with the content of another one, which do not count.
    pub copies: Vec<String>,
    /// Scenarios that could not be driven, and why.
    pub missed: Vec<(String, String)>,
}

/// An annex for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct AnnexRecord {
    /// The requirement, by the keys of its file.
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub requirement: SafetyRequirement,
    /// SHA-256 of its file.
    pub file_sha256: String,
    /// SHA-256 of the program.
    pub program_sha256: String,
    /// The day on which was driven, UTC.
    pub day: String,
    /// How was planned, by the keys of `[planner]` in config.toml.
    pub planning: BTreeMap<String, serde_json::Value>,
    /// All planners, drivers and baselines.
    pub planners: Vec<PlannerFindings>,
    /// Outcomes, harm, and paired differences to the first planner.
    pub standings: Vec<StandingRecord>,
    /// By planner and driver.
    pub contacts: Vec<ContactsByDriver>,
    /// The scenarios.
    pub scenarios: Vec<AnnexScenario>,
    /// How often the index holds manoeuvres that are at least as extreme as those of the scenarios.
    pub rates: Vec<RateLike>,
    /// Every drive.
    pub drives: Vec<AnnexDrive>,
    /// Scenarios that were found, before some were selected.
    pub listed: usize,
    /// Scenarios with the content of another one, which do not count.
    pub copies: Vec<String>,
    /// Scenarios that could not be driven, and why.
    pub missed: Vec<(String, String)>,
    /// What the figures are of.
    pub provenance: Provenance,
}

/// Width and height of a picture, points, and the metres that it shows.
const PICTURE: (f64, f64) = (480.0 * PIXEL, 300.0 * PIXEL);
const SEEN: MapExtent = MapExtent::Ego { width: 70.0 };

/// Drives a scenario with all planners, drivers and baselines, and holds each drive to the requirement; nothing where `cancel` asked for an end.
///
/// # Errors
/// It cannot be driven, or the manifest beside it cannot be read.
pub fn held(
    requirement: &SafetyRequirement,
    who: &[(PlannerChoice, Role)],
    entry: &Entry,
    (index, thresholds): (Option<&IndexedEvents>, &Thresholds),
    cancel: &Cancel,
) -> Result<Option<HeldScenario>, PlanError> {
    let settings = Settings::from(&requirement.planning);
    let planners: Vec<PlannerChoice> = who.iter().map(|(planner, _)| planner.clone()).collect();
    let prepared = prepare_beside(entry, None, &settings)?;
    let Some(drives) = drive_each(entry, &prepared, &planners, cancel)? else {
        return Ok(None);
    };
    let radius = index.map_or(INDEX_RADIUS, |index| index.radius);
    // There are none without an ego, and where no one ahead cuts in or out or brakes.
    let events = scenario_events(entry, radius, thresholds).unwrap_or_default();
    let rates = |event| {
        let all = EventFilter::default();
        index.map_or_else(Vec::new, |index| {
            rates_like(index, &entry.name, event, &all)
        })
    };
    let mut held = HeldScenario {
        scenario: AnnexScenario {
            in_index: index.is_some_and(|index| {
                index.scenarios.iter().any(|one| {
                    one.scenario == entry.name || one.sha256 == prepared.scenario.hash.to_string()
                })
            }),
            ..described(entry, &prepared.opened(), &events, thresholds)?
        },
        rates: events.iter().flat_map(rates).collect(),
        drives: Vec::new(),
        identities: Vec::new(),
        figures: drives.iter().map(DriveFigures::from).collect(),
        contacts: Vec::new(),
        pictures: Vec::new(),
    };
    let id = requirement.driver.as_str();
    for (driven, (planner, role)) in drives.iter().zip(who) {
        let record = DriveRecord::new(driven);
        let seat = record.preventability.clone();
        let (finding, why_open) = Finding::of(driven, seat.as_ref(), id);
        let verdict = seat.as_ref().and_then(|seat| seat.by(id));
        let last_moment = verdict.and_then(|verdict| verdict.last_moment_step);
        let dt = driven.scenario.dt();
        held.drives.push(AnnexDrive {
            scenario: driven.name.clone(),
            planner: planner.name.clone(),
            role: *role,
            outcome: record.outcome.clone(),
            finding,
            why_open,
            obstacle: record.collision_with,
            closing_speed: record
                .impact
                .as_ref()
                .map(|impact| thousandths(impact.closing_speed)),
            driver_closing_speed: verdict
                .and_then(|verdict| verdict.closing_speed)
                .map(thousandths),
            p_serious: driven.p_serious(),
            preventable_by: seat
                .as_ref()
                .map_or_else(String::new, PreventabilityRecord::words),
            last_moment: { last_moment.zip(record.collision_step) }
                .map(|(last, contact)| thousandths((contact - last) as f64 * dt)),
        });
        if *role == Role::Planner && finding.is_met() != Some(true) {
            held.pictures
                .extend(picture(driven, &planner.name, finding));
        }
        held.identities.push(record.planner_summary());
        held.contacts.push(seat);
    }
    held.doubt(who, id, prepared.scenario.dt());
    Ok(Some(held))
}

impl HeldScenario {
    /// Leaves contacts open that the driver does not avoid in the planner's seat, unless it comes to a contact with the same
    /// road user, no more than [`SAME_CONTACT`] earlier or later, that it does not avoid itself when it drives from the start:
    /// whether the planner drove into it, or the attack was made for its timing, is not known.
    fn doubt(&mut self, who: &[(PlannerChoice, Role)], driver: &str, dt: f64) {
        let from_start = who.iter().position(|(planner, _)| {
            { planner.policy }.is_some_and(|policy| policy.name() == driver)
        });
        let Some(place) = from_start else {
            return;
        };
        let own = self.contacts[place].clone();
        let own = own.filter(|_| self.drives[place].finding == Finding::Unpreventable);
        let is_same = |contact: &Option<PreventabilityRecord>| {
            own.as_ref().zip(contact.as_ref()).is_some_and(|(own, it)| {
                let apart = (own.step - it.step).abs() as f64 * dt;
                own.obstacle == it.obstacle && apart <= SAME_CONTACT
            })
        };
        let unpreventable =
            { self.drives.iter_mut().zip(&self.contacts) }.filter(|(drive, contact)| {
                drive.finding == Finding::Unpreventable && !is_same(contact)
            });
        for (drive, _) in unpreventable {
            drive.finding = Finding::Open;
            drive.why_open = format!(
                "not avoided by {driver} in its seat, but {driver} has no such contact from the start"
            );
        }
    }
}

/// Contacts with the same road user that are farther apart are two, seconds.
const SAME_CONTACT: f64 = 1.0;

/// The map at the contact, and what it is.
fn picture(driven: &DrivenScenario, planner: &str, finding: Finding) -> Option<(String, String)> {
    let (scene, collision) = (driven.scene()?, driven.collision()?);
    let look = FigureOptions {
        seen: SEEN,
        obstacles: vec![collision.with],
        size: (PICTURE.0, Some(PICTURE.1)),
        ..FigureOptions::default()
    };
    let subject = Subject::with_ego(&scene);
    let figure = Figure::new(subject, &driven.name, look, Thresholds::shipped()).ok()?;
    let at = collision.step as f64 * driven.scenario.dt();
    let caption = format!(
        "{}, {planner}: contact with {} at {at:.1} s, {}",
        driven.name,
        collision.with,
        finding.name()
    );
    Some((caption, svg(&figure.at(collision.step))))
}

/// What a scenario is, in tags.
fn described(
    entry: &Entry,
    opened: &OpenedScene,
    events: &[ScenarioEvent],
    thresholds: &Thresholds,
) -> Result<AnnexScenario, PlanError> {
    let origin = VariantOrigin::read(entry).map_err(PlanError::Unreadable)?;
    let row = Overview::new(entry, opened, thresholds, &Verdicts::default(), None).row;
    let scenario = &opened.scenario;
    let environment = { scenario.location.as_ref() }.and_then(|place| place.environment.as_ref());
    let words = |words: &[Option<String>]| -> String {
        let said: Vec<&str> = words.iter().flatten().map(String::as_str).collect();
        said.join(", ")
    };
    let of_moment = { row.with.clone().zip(row.manoeuvre) };
    let mut dynamic: Vec<String> = { of_moment.into_iter() }
        .map(|(with, manoeuvre)| format!("{with}: {manoeuvre}"))
        .collect();
    for ScenarioEvent { event, .. } in events {
        let (kind, id) = (event.obstacle_type.name(), event.obstacle);
        dynamic.push(format!("{kind} {id}: {}", event.manoeuvre.name()));
    }
    dynamic.dedup();
    Ok(AnnexScenario {
        scenario: row.scenario,
        file: row.file,
        sha256: scenario.hash.to_string(),
        time_step: scenario.dt(),
        source: scenario.header.attributes.get("source").cloned(),
        scenery: words(&[
            row.road.map(|road| format!("road {road}")),
            Some(country_code(&entry.name).to_string())
                .filter(|code| !code.is_empty() && code != "ZAM"),
        ]),
        environment: environment
            .map(|said| words(&[said.time_of_day.clone(), said.weather.clone()]))
            .filter(|words| !words.is_empty()),
        made_against: origin.map(|origin| match origin.manifest.planning.planner {
            PlannerIdentity::BuiltIn(name) => name,
            PlannerIdentity::External { named, .. } => named,
        }),
        dynamic_elements: dynamic.join(", "),
        in_index: false,
    })
}

impl Annex {
    /// What planners, drivers and baselines come to.
    #[must_use]
    pub fn planners(&self) -> Vec<PlannerFindings> {
        let of = |(place, (planner, role)): (usize, &(String, Role))| {
            let drives: Vec<&AnnexDrive> = { self.held.iter() }
                .map(|held| &held.drives[place])
                .collect();
            let count = |finding: Finding| drives.iter().filter(|d| d.finding == finding).count();
            let [no_contact, unpreventable, harder, preventable, open] = [
                Finding::NoContact,
                Finding::Unpreventable,
                Finding::Harder,
                Finding::Preventable,
                Finding::Open,
            ]
            .map(count);
            let mut maps: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
            for drive in &drives {
                let Some(is_met) = drive.finding.is_met() else {
                    continue;
                };
                let map = maps.entry(family(&drive.scenario)).or_default();
                *map = (map.0 + u32::from(is_met), map.1 + 1);
            }
            let maps: Vec<(u32, u32)> = maps.into_values().collect();
            let decided = drives.len() - open;
            let good = no_contact + unpreventable;
            PlannerFindings {
                planner: planner.clone(),
                role: *role,
                identity: self
                    .held
                    .iter()
                    .find_map(|held| held.identities[place].clone()),
                met: match (decided - good, open + self.missed.len(), good) {
                    (0, 0, 1..) => Some(true),
                    (0, ..) => None,
                    _ => Some(false),
                },
                drives: drives.len(),
                goal: drives
                    .iter()
                    .filter(|drive| drive.outcome == "goal")
                    .count(),
                no_contact,
                unpreventable,
                harder,
                preventable,
                open,
                share_met: (decided > 0).then(|| good as f64 / decided as f64),
                share_met_ci: scenario_interval(&maps),
                // An empty sum is -0.
                serious_injuries: drives
                    .iter()
                    .filter_map(|drive| drive.p_serious)
                    .sum::<f64>()
                    + 0.0,
                without_curve: drives
                    .iter()
                    .filter(|drive| drive.p_serious.is_none())
                    .count(),
            }
        };
        self.who.iter().enumerate().map(of).collect()
    }

    /// Outcomes, harm, and paired differences to the first planner.
    #[must_use]
    pub fn standings(&self) -> Vec<StandingRecord> {
        standings(&self.all_standings())
    }

    /// A scenario that was driven already and has the same content.
    #[must_use]
    pub fn with_content_of(&self, held: &HeldScenario) -> Option<&AnnexScenario> {
        let mut all = self.held.iter().map(|held| &held.scenario);
        all.find(|one| one.sha256 == held.scenario.sha256)
    }

    /// Scenarios that no baseline solves.
    #[must_use]
    pub fn beyond_baselines(&self) -> BeyondBaselines {
        let names = { self.held.iter() }.map(|held| held.scenario.scenario.clone());
        beyond_baselines(&self.all_standings(), &names.collect::<Vec<_>>())
    }

    fn all_standings(&self) -> Vec<Standing> {
        let standing = |(place, (name, role)): (usize, &(String, Role))| Standing {
            name: name.clone(),
            is_baseline: *role == Role::Baseline,
            drives: self.held.iter().map(|held| held.figures[place]).collect(),
        };
        self.who.iter().enumerate().map(standing).collect()
    }

    /// What drivers make of the contacts of planners and baselines.
    #[must_use]
    pub fn contacts(&self) -> Vec<ContactsByDriver> {
        let mut rows = Vec::new();
        let with_contact = |(place, (planner, role)): (usize, &(String, Role))| {
            let seats: Vec<&PreventabilityRecord> = { self.held.iter() }
                .filter_map(|held| held.contacts[place].as_ref())
                .collect();
            (*role != Role::Driver && !seats.is_empty()).then(|| (planner.clone(), seats))
        };
        for (planner, seats) in self.who.iter().enumerate().filter_map(with_contact) {
            for driver in DRIVERS {
                let count = |result: DriverOutcome| {
                    let verdicts = seats.iter().filter_map(|seat| seat.by(driver.id));
                    verdicts.filter(|verdict| verdict.result == result).count()
                };
                rows.push(ContactsByDriver {
                    planner: planner.clone(),
                    driver: driver.id,
                    avoided: count(DriverOutcome::Avoided),
                    mitigated: count(DriverOutcome::Mitigated),
                    not_avoided: count(DriverOutcome::NotAvoided),
                    hit_from_behind: count(DriverOutcome::HitFromBehind),
                    not_made_for: count(DriverOutcome::NotMadeFor),
                });
            }
        }
        rows
    }

    /// Maps of contacts of planners that speak against them or are open, with captions.
    pub(super) fn pictures(&self) -> impl Iterator<Item = &(String, String)> {
        self.held.iter().flat_map(|held| &held.pictures)
    }

    /// What the figures are of.
    #[must_use]
    pub fn provenance(&self) -> Provenance {
        let mut provenance = Provenance::of_program();
        let hashes = self.held.iter().map(|held| held.scenario.sha256.clone());
        provenance.set_scenarios(&hashes.collect());
        provenance
    }

    /// How was planned.
    #[must_use]
    pub fn planning(&self) -> Vec<(String, toml::Value)> {
        Planning::values(&Settings::from(&self.requirement.planning))
    }

    /// The annex for programs.
    #[must_use]
    pub fn record(&self) -> AnnexRecord {
        let planning = self.planning().into_iter();
        AnnexRecord {
            requirement: self.requirement.clone(),
            file_sha256: self.file_sha256.clone(),
            program_sha256: self.program_sha256.clone(),
            day: self.day.clone(),
            // Values of TOML are values of JSON, too.
            planning: planning
                .map(|(key, value)| (key, serde_json::to_value(value).unwrap_or_default()))
                .collect(),
            planners: self.planners(),
            standings: self.standings(),
            contacts: self.contacts(),
            scenarios: self.held.iter().map(|held| held.scenario.clone()).collect(),
            rates: self
                .held
                .iter()
                .flat_map(|held| held.rates.clone())
                .collect(),
            drives: self
                .held
                .iter()
                .flat_map(|held| held.drives.clone())
                .collect(),
            listed: self.listed,
            copies: self.copies.clone(),
            missed: self.missed.clone(),
            provenance: self.provenance(),
        }
    }
}

impl Record for AnnexRecord {
    const NAME: &'static str = "annex";
    const TITLE: &'static str = "`annex --format json`: planners held to a requirement";
}
