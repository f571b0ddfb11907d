//! How often the egos of a corpus meet a manoeuvre: rates of the events of an index, per hour and per kilometre.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use nearmiss_drive::driver::PreventabilityRecord;
use nearmiss_formats::Entry;
use nearmiss_record::Record;
use nearmiss_scene::corpus::{
    Egos, Event, EventKind, Exposure, IndexError, Part, ScenarioDriven, events,
};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Scene;
use nearmiss_scene::scenario::identity::family;
use nearmiss_study::evaluation::statistics::{FEWEST, Interval, rate_interval};
use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::scenario_filter::event_terms::{EventFilter, Fit};
use super::tables::encounters;
use super::{VariantOrigin, index_parts};

/// The events of an index, and how far its egos drove.
#[derive(Debug, Clone, Default)]
pub struct IndexedEvents {
    /// By scenario; copies of a file count once.
    pub scenarios: Vec<ScenarioDriven>,
    /// Copies that do not count: with the same content or name, the same way and the same events.
    pub copies: usize,
    /// Others farther away were not looked at, metres.
    pub radius: f64,
}

/// Reads the events of an index.
///
/// # Errors
/// It cannot be read, or is one without events.
pub fn read_events(folder: &Path) -> Result<IndexedEvents, IndexError> {
    let mut found = IndexedEvents::default();
    for path in index_parts(folder)? {
        let part = Part::open(&path)?;
        found.radius = part.radius().unwrap_or(f64::INFINITY);
        found.scenarios.extend(part.driven()?);
    }
    let all = found.scenarios.len();
    let mut seen = HashSet::new();
    found.scenarios.retain(|one| {
        let driven = serde_json::to_string(&one.driven);
        let file = match &one.sha256[..] {
            "" => &one.scenario,
            sha256 => sha256,
        };
        driven.map_or(true, |driven| seen.insert((file.to_owned(), driven)))
    });
    found.copies = all - found.scenarios.len();
    Ok(found)
}

/// How often egos meet a manoeuvre.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Rate {
    /// What happens: cut_in, merging, cut_out, braking; null of several.
    #[schemars(title = "manoeuvre")]
    pub manoeuvre: Option<EventKind>,
    /// The terms that events fit; empty where all count.
    pub terms: String,
    /// Whose events: recorded, the ego beside the scenario; obstacle, its other motor vehicles.
    #[schemars(title = "ego")]
    pub ego_source: Egos,
    /// Recordings: scenarios on the same map are one.
    #[schemars(title = "recordings")]
    pub recordings: usize,
    /// Egos that drove.
    #[schemars(title = "egos")]
    pub egos: u64,
    /// How long they drove, standing in traffic included.
    #[schemars(title = "driven", extend("unit" = "h", "decimals" = 2))]
    pub hours: f64,
    /// How far.
    #[schemars(title = "", extend("unit" = "km", "decimals" = 1))]
    pub kilometres: f64,
    /// Events.
    #[schemars(title = "events")]
    pub events: u64,
    /// Recordings with one.
    #[schemars(title = "in recordings")]
    pub recordings_with: usize,
    /// Events that lack a parameter that is compared; they do not count.
    #[schemars(title = "unmeasured", extend("rare" = true))]
    pub unmeasured: u64,
    /// Events an hour; null where nothing was driven.
    #[schemars(title = "per hour", extend("decimals" = 3))]
    pub per_hour: Option<f64>,
    /// Its interval of 95 %: exact for independent events, or that of the bootstrap over recordings where it is wider.
    pub per_hour_ci: Option<Interval>,
    /// Events a thousand kilometres; null where nothing was driven.
    #[schemars(title = "per 1000 km", extend("decimals" = 2))]
    pub per_1000_km: Option<f64>,
    /// Its interval of 95 %, in the same way.
    pub per_1000_km_ci: Option<Interval>,
    /// Whether the intervals take events as independent: there are fewer than 10 recordings.
    pub independent: bool,
}

impl Record for Rate {
    const NAME: &'static str = "corpus-rate";
    const TITLE: &'static str =
        "`corpus rate --format json`: how often egos meet a manoeuvre, one kind a line";
}

/// How often these egos meet what fits a filter.
///
/// ```
/// use nearmiss_scene::corpus::Egos;
/// use nearmiss_workflow::{EventFilter, IndexedEvents, foreseeability};
///
/// let near = EventFilter::read("manoeuvre:cut_in gap<12 closing>5")?;
/// let rate = foreseeability(&IndexedEvents::default(), &near, Egos::Recorded);
/// assert_eq!((rate.events, rate.per_hour), (0, None));
/// # Ok::<(), String>(())
/// ```
#[must_use]
pub fn foreseeability(index: &IndexedEvents, filter: &EventFilter, egos: Egos) -> Rate {
    let mut recordings: BTreeMap<&str, (u64, Exposure)> = BTreeMap::new();
    let (mut all, mut unmeasured) = (Exposure::default(), 0);
    for scenario in &index.scenarios {
        let driven = scenario.driven.exposure(egos);
        if driven.egos == 0 {
            continue;
        }
        all.add(driven);
        let recording = recordings.entry(family(&scenario.scenario)).or_default();
        recording.1.add(driven);
        let all = scenario.driven.events.iter();
        let own = all.filter(|event| event.ego_source == egos);
        for event in own {
            match filter.fit(event) {
                Fit::Fits => recording.0 += 1,
                Fit::Unmeasured => unmeasured += 1,
                Fit::FitsNot => {}
            }
        }
    }
    let mut kinds = EventKind::ALL
        .into_iter()
        .filter(|kind| filter.asks_for(*kind));
    let kind = kinds.next().filter(|_| kinds.next().is_none());
    let events: u64 = recordings.values().map(|(events, _)| events).sum();
    let (hours, kilometres) = (all.seconds / 3600.0, all.metres / 1000.0);
    let over = |whole: f64, of: &dyn Fn(&Exposure) -> f64| {
        let each = recordings
            .values()
            .map(|(events, driven)| (*events, of(driven)));
        let interval = rate_interval(&each.collect::<Vec<_>>());
        (interval.map(|_| events as f64 / whole), interval)
    };
    let (per_hour, per_hour_ci) = over(hours, &|driven| driven.seconds / 3600.0);
    let (per_1000_km, per_1000_km_ci) = over(kilometres / 1000.0, &|driven| driven.metres / 1e6);
    Rate {
        manoeuvre: kind,
        terms: filter.words(),
        ego_source: egos,
        recordings: recordings.len(),
        egos: all.egos,
        hours,
        kilometres,
        events,
        recordings_with: recordings
            .values()
            .filter(|(events, _)| *events > 0)
            .count(),
        unmeasured,
        per_hour,
        per_hour_ci,
        per_1000_km,
        per_1000_km_ci,
        independent: recordings.len() < FEWEST as usize,
    }
}

/// The rates of each kind of event that a filter asks for, of recorded egos and of obstacles, as far as there are any.
#[must_use]
pub fn rates(index: &IndexedEvents, filter: &EventFilter) -> Vec<Rate> {
    let kinds = EventKind::ALL
        .into_iter()
        .filter(|kind| filter.asks_for(*kind));
    let each = kinds.flat_map(|kind| {
        let filter = EventFilter::of_kind(kind).and(filter);
        Egos::ALL.map(|egos| Rate {
            manoeuvre: Some(kind),
            ..foreseeability(index, &filter, egos)
        })
    });
    each.filter(|rate| rate.egos > 0).collect()
}

/// An event of an index.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EventLine {
    /// The scenario's name.
    pub scenario: String,
    /// Path as it was found.
    #[schemars(title = "file")]
    pub file: String,
    /// What happened.
    #[serde(flatten)]
    pub event: Event,
}

impl Record for EventLine {
    const NAME: &'static str = "corpus-event";
    const TITLE: &'static str = "`corpus rate --events --format json`: an event a line";
}

/// The events of an index that fit a filter.
#[must_use]
pub fn events_that_fit(index: &IndexedEvents, filter: &EventFilter) -> Vec<EventLine> {
    let scenarios = index.scenarios.iter();
    let all = scenarios.flat_map(|one| one.driven.events.iter().map(move |event| (one, event)));
    let fitting = all.filter(|(_, event)| filter.fit(event) == Fit::Fits);
    let line = |(of, event): (&ScenarioDriven, &Event)| EventLine {
        scenario: of.scenario.clone(),
        file: of.file.clone(),
        event: event.clone(),
    };
    fitting.map(line).collect()
}

/// Where it is known from who avoids an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum JudgedFrom {
    /// The manifest of the variant.
    Manifest,
    /// Drivers were judged now, in the most severe encounter with the road user.
    Encounter,
}

nearmiss_record::named!(JudgedFrom);

/// What a road user does to the ego of a scenario, and who avoids what comes of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioEvent {
    /// What it does.
    pub event: Event,
    /// Which drivers avoid contact; nothing where it comes to no contact, conflict or near miss that begins after the
    /// recording.
    pub drivers: Option<(JudgedFrom, PreventabilityRecord)>,
}

/// How often egos meet something at least as extreme as an event of a scenario, and which drivers avoid that event.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RateLike {
    /// The scenario's name.
    #[schemars(title = "like")]
    pub scenario: String,
    /// How often.
    #[serde(flatten)]
    pub rate: Rate,
    /// Drivers that avoid contact; null where none was judged.
    #[schemars(title = "avoided")]
    pub avoided: Option<usize>,
    /// Drivers that decide.
    #[schemars(title = "decided")]
    pub decided: Option<usize>,
    /// Where that is from: manifest, of the variant; encounter, judged now.
    #[schemars(title = "from")]
    pub judged_from: Option<JudgedFrom>,
}

impl Record for RateLike {
    const NAME: &'static str = "corpus-rate-like";
    const TITLE: &'static str = "`corpus rate --like SCENARIO --format json`: how often egos meet what is at least as extreme, and who avoids it; an event and kind of ego a line";
}

/// The rates of what is at least as extreme as an event of the scenario `name`, and fits `filter`.
#[must_use]
pub fn rates_like(
    index: &IndexedEvents,
    name: &str,
    like: &ScenarioEvent,
    filter: &EventFilter,
) -> Vec<RateLike> {
    let drivers = like.drivers.as_ref();
    let row = |rate| RateLike {
        scenario: visible(name).into_owned(),
        rate,
        avoided: drivers.map(|(_, found)| found.avoided),
        decided: drivers.map(|(_, found)| found.decided),
        judged_from: drivers.map(|(from, _)| *from),
    };
    let filter = EventFilter::like(&like.event).and(filter);
    rates(index, &filter).into_iter().map(row).collect()
}

/// What the attackers of a variant do to its ego, from their attack on; of a scenario that is none, what all ahead do. Drivers
/// are judged in encounters under `thresholds` where no manifest has them.
///
/// # Errors
/// The scenario or its ego cannot be read, it has no ego, or nobody ahead cuts in or out or brakes.
pub fn scenario_events(
    entry: &Entry,
    radius: f64,
    thresholds: &Thresholds,
) -> Result<Vec<ScenarioEvent>, String> {
    let scenario = entry.read().map_err(|why| why.to_string())?;
    let ego = entry
        .recorded_ego(&scenario)
        .map_err(|why| why.to_string())?;
    let ego = ego.ok_or_else(|| format!("{}: no ego drives beside it", entry.display()))?;
    let scene = Scene::new(scenario, ego);
    let mut found = events(&scene, radius);
    let origin = VariantOrigin::read(entry)?;
    if let Some(origin) = &origin {
        let attackers = &origin.manifest.attackers;
        found.retain(|event| {
            let is_by = |id, from| event.obstacle == id && event.last_step >= from;
            attackers
                .iter()
                .any(|attacker| is_by(attacker.id, attacker.from_step))
        });
    }
    if found.is_empty() {
        return Err(format!(
            "{}: nobody ahead of the ego cuts in or out or brakes: no rate to look for",
            entry.display()
        ));
    }
    let told = origin.and_then(|origin| origin.manifest.preventability);
    let judged = match &told {
        Some(_) => Vec::new(),
        None => encounters(entry, &scene, thresholds)?.0,
    };
    let with_drivers = |event: Event| {
        let told = told.clone().map(|told| (JudgedFrom::Manifest, told));
        // The most severe one comes first.
        let own = { judged.iter() }.find(|one| one.drivers.obstacle == event.obstacle);
        let judged = own.map(|own| (JudgedFrom::Encounter, own.drivers.clone()));
        ScenarioEvent {
            event,
            drivers: told.or(judged),
        }
    };
    Ok(found.into_iter().map(with_drivers).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::tests::copied;
    use nearmiss_drive::generation::{AttackerRecord, Manifest, OriginalRecord};
    use nearmiss_scene::corpus::{Driven, RoadType};
    use nearmiss_scene::scenario::ObstacleType;

    /// A cut-in.
    fn cut_in(gap: f64, closing: f64, lateral_speed: f64) -> Event {
        Event {
            ego_source: Egos::Recorded,
            ego_id: 1,
            obstacle: 2,
            obstacle_type: ObstacleType::Truck,
            manoeuvre: EventKind::CutIn,
            road: RoadType::Highway,
            first_step: 10,
            last_step: 20,
            gap: Some(gap),
            closing: Some(closing),
            lateral_speed: Some(lateral_speed),
            deceleration: None,
            mean_deceleration: None,
            ego_speed: Some(25.0),
        }
    }

    /// Twelve recordings of an hour and 50 km each of the recorded ego; every second one has the events.
    fn index(events: &[Event]) -> IndexedEvents {
        let scenario = |i: usize| ScenarioDriven {
            scenario: format!("DEU_A-{}_1_T-1", i + 1),
            file: format!("{i}.xml"),
            sha256: i.to_string(),
            is_window: false,
            driven: Driven {
                recorded: Exposure {
                    egos: 1,
                    seconds: 3600.0,
                    metres: 50_000.0,
                },
                obstacles: Exposure::default(),
                events: events
                    .iter()
                    .filter(|_| i.is_multiple_of(2))
                    .cloned()
                    .collect(),
            },
        };
        IndexedEvents {
            scenarios: (0..12).map(scenario).collect(),
            copies: 0,
            radius: 50.0,
        }
    }

    #[test]
    fn events_over_hours_and_kilometres() {
        let braking = Event {
            manoeuvre: EventKind::Braking,
            lateral_speed: None,
            ..cut_in(9.0, 1.0, 0.0)
        };
        let index = index(&[cut_in(10.0, 5.0, 1.0), cut_in(30.0, 2.0, 0.5), braking]);
        let all = rates(&index, &EventFilter::default());
        let counts: Vec<u64> = all.iter().map(|rate| rate.events).collect();
        // Obstacles drove nothing: they have no rows.
        assert_eq!(counts, [12, 0, 0, 6]);
        let of = |terms: &str| {
            foreseeability(&index, &EventFilter::read(terms).unwrap(), Egos::Recorded)
        };
        let near = of("manoeuvre:cut_in gap<12 closing>=5 actor:truck");
        assert_eq!(
            (near.events, near.recordings, near.recordings_with),
            (6, 12, 6)
        );
        assert_eq!((near.per_hour, near.per_1000_km), (Some(0.5), Some(10.0)));
        assert_eq!(
            (near.hours, near.kilometres, near.independent),
            (12.0, 600.0, false)
        );
        // Garwood: 6 events are 2.2019 to 13.0595.
        let interval = near.per_hour_ci.unwrap();
        assert!(
            interval.low <= 2.202 / 12.0 && interval.high >= 13.059 / 12.0,
            "{interval:?}"
        );
        let none = of("manoeuvre:cut_in gap<1").per_hour_ci.unwrap();
        assert!(none.low == 0.0 && (none.high - 3.688_879 / 12.0).abs() < 1e-6);
        assert_eq!(of("manoeuvre:cut_in deceleration>3").unmeasured, 12);
        assert_eq!(of("!manoeuvre:cut_in").events, 6);
        assert_eq!(of("road:urban").events, 0);
    }

    #[test]
    fn who_avoids_an_event_is_told_by_the_manifest_or_the_encounter() {
        let folder = tempfile::tempdir().unwrap();
        let entry = copied(folder.path(), "ZAM_HardBraking-1_1_T-1");
        let thresholds = Thresholds::shipped();
        let found = scenario_events(&entry, 50.0, thresholds).unwrap();
        let of = |events: &[ScenarioEvent]| {
            let first = events.first().and_then(|one| one.drivers.clone()).unwrap();
            (first.0, first.1.avoided, first.1.decided)
        };
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        let judged = encounters(&entry, &Scene::new(scenario, ego), thresholds)
            .unwrap()
            .0;
        let by = found[0].event.obstacle;
        let own = judged.iter().find(|one| one.drivers.obstacle == by);
        let own = &own.unwrap().drivers;
        assert_eq!(
            of(&found),
            (JudgedFrom::Encounter, own.avoided, own.decided)
        );
        let rows = rates_like(&index(&[]), &entry.name, &found[0], &EventFilter::default());
        assert_eq!(
            (rows[0].scenario.as_str(), rows[0].avoided),
            ("v", Some(own.avoided))
        );

        let manifest = Manifest {
            variant: "v.xml".into(),
            original: OriginalRecord {
                sha256: "00".into(),
                ..OriginalRecord::default()
            },
            attackers: vec![AttackerRecord {
                id: by,
                ..AttackerRecord::default()
            }],
            preventability: Some(PreventabilityRecord {
                avoided: 2,
                decided: 5,
                ..PreventabilityRecord::default()
            }),
            ..Manifest::default()
        };
        let text = serde_json::to_string(&manifest).unwrap();
        std::fs::write(folder.path().join("v.json"), text).unwrap();
        let found = scenario_events(&entry, 50.0, thresholds).unwrap();
        assert!(found.iter().all(|one| one.event.obstacle == by));
        assert_eq!(of(&found), (JudgedFrom::Manifest, 2, 5));
    }

    #[test]
    fn at_least_as_extreme() {
        let like = EventFilter::like(&cut_in(10.0, 5.0, 1.0));
        assert_eq!(
            like.words(),
            "manoeuvre:cut_in gap<=10 closing>=5 lateral_speed>=1"
        );
        assert_eq!(
            EventFilter::read(&like.words()).unwrap().words(),
            like.words()
        );
        let with = |gap, closing, lateral| {
            foreseeability(
                &index(&[cut_in(gap, closing, lateral)]),
                &like,
                Egos::Recorded,
            )
            .events
        };
        assert_eq!(with(10.0, 5.0, 1.0), 6, "itself");
        assert_eq!(with(-1.0, 9.0, 2.0), 6);
        for less in [
            with(10.1, 9.0, 2.0),
            with(5.0, 4.9, 2.0),
            with(5.0, 9.0, 0.9),
        ] {
            assert_eq!(less, 0);
        }
        let odd = EventFilter::like(&cut_in(10.001, -0.001, 1.009));
        assert_eq!(
            odd.words(),
            "manoeuvre:cut_in gap<=10.01 closing>=-0.01 lateral_speed>=1"
        );
    }
}
