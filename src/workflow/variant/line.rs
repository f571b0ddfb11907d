//! What is known of one scenario's variant: the JSON line, from which table and report are made, too.
//!
//! Both read only the line, so one reused from an earlier run counts like a new one.

use std::collections::BTreeMap;

use nearmiss_drive::driver::PreventabilityRecord;
use nearmiss_drive::generation::{
    Attack, AttackerRecord, Avoidability, ClosedLoop, Effect, LogLikelihoods, MotionSamples,
    OutcomeName, Plausibility, Refusal, RefusalRecord, RequestedMotion, VariantFiles, attacker,
};
use nearmiss_drive::simulation::CollisionKind;
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::ImpactRecord;
use nearmiss_study::evaluation::generating::AuthoredRecord;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Generated;
use crate::drive::PlannerFaultRecord;
use crate::tables::short_hash;

/// One scenario and its variant.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct VariantLine {
    /// Name of the scenario: its file name without the ending.
    pub scenario: String,
    /// File of the scenario.
    pub file: String,
    /// First 12 digits of the SHA-256 of the scenario's content.
    pub hash: String,
    /// Id of the variant.
    pub id: Option<String>,
    /// File of the variant.
    pub variant: Option<String>,
    /// File of the ego's drive in it.
    pub ego: Option<String>,
    /// search with its settings, or the model.
    pub by: String,
    /// How it ends.
    pub outcome: OutcomeName,
    /// Id of the attacker; of several, the one that the ego touches or that comes nearest.
    pub attacker: Option<i64>,
    /// All attackers.
    pub attackers: Option<Vec<AttackerRecord>>,
    /// Manoeuvre of the attacker.
    pub manoeuvre: Option<String>,
    /// The motion that was requested of it.
    pub asked: Option<RequestedMotion>,
    /// The last step before the motion is another one.
    pub from_step: Option<i64>,
    /// Last changed step.
    pub until_step: Option<i64>,
    /// Lowest risk score of an attacker as recorded.
    pub min_risk_before: Option<u8>,
    /// Lowest risk score of an attacker in the variant.
    pub min_risk_after: Option<u8>,
    /// Lowest risk score of all obstacles as recorded.
    pub min_risk_of_anyone_before: Option<u8>,
    /// Lowest risk score of all obstacles in the variant.
    pub min_risk_of_anyone_after: Option<u8>,
    /// Smallest distance to an attacker, metres.
    pub min_distance: Option<f64>,
    /// Id of the obstacle that the ego collides with.
    pub collision_with: Option<i64>,
    /// Step of the collision.
    pub collision_step: Option<i64>,
    /// ran_into (the ego's front), rear_ended (the obstacle's front, the ego's rear) or side; also where it is no effect.
    pub collision_kind: Option<String>,
    /// Side of the ego that is hit.
    pub ego_side: Option<String>,
    /// Side of the other body that is hit.
    pub other_side: Option<String>,
    /// How hard the collision is.
    pub impact: Option<ImpactRecord>,
    /// Step before a contact that is only between two steps.
    pub touched_after_step: Option<i64>,
    /// Whether an ideal driver avoids it, by reaction time in seconds.
    pub avoidable: Option<BTreeMap<String, bool>>,
    /// The ideal driver with the longest reaction time who survives.
    pub good_driver: Option<GoodDriver>,
    /// Which drivers avoid its contact or near miss.
    pub preventability: Option<PreventabilityRecord>,
    /// Limits of attackers: human or limit.
    pub style: String,
    /// Log-likelihood of the attackers' motions under the recorded ones of the scenario, and theirs on average.
    pub plausibility: Option<LogLikelihoods>,
    /// Histograms of acceleration, jerk, yaw rate and lane offset.
    pub motion_samples: Option<ComparedSamples>,
    /// Remark for people.
    pub note: Option<String>,
    /// Whether the original is safe.
    pub safe_before: bool,
    /// Outcome of the drive in the original.
    pub baseline: String,
    /// Outcome of the drive in the variant.
    pub drive: Option<String>,
    /// The planner that is attacked, as it was named; nearmiss is the built-in one.
    pub planner: String,
    /// Of a planner that is a process.
    pub external_planner: Option<ExternalPlannerRecord>,
    /// Possible attackers, the one with the least change first.
    pub reference_ranking: Vec<attacker::Candidate>,
    /// Number of motions tried.
    pub candidates: usize,
    /// Motions that passed the gate.
    pub passed: usize,
    /// Motions that were simulated.
    pub driven: usize,
    /// Rejected motions by reason.
    pub refused: BTreeMap<String, usize>,
    /// Rejected motions.
    pub rejected: Option<Vec<RefusalRecord>>,
    /// Choice, votes, motions, grades and consumption of the model.
    pub model: Option<AuthoredRecord>,
    /// Whether it comes from an earlier run.
    pub taken_over: bool,
    /// Duration in seconds.
    pub seconds: f64,
}

/// The driver of the longest reaction time who survives.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct GoodDriver {
    /// Seconds.
    pub reaction_time: f64,
    /// How its drive ends.
    pub drive: String,
    /// What found it.
    pub found_by: String,
    /// The largest acceleration along and across, m/s².
    pub max_acceleration: Option<f64>,
    /// Traffic rules that it breaks.
    pub rules_broken: Vec<String>,
    /// Traffic rules that cannot be decided of it.
    pub rules_undecided: Vec<String>,
    /// The step at which it leaves the lanelets of cars.
    pub leaves_roadway_step: Option<i64>,
}

/// What a planner's process says of itself, and how it failed.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct ExternalPlannerRecord {
    /// Its name.
    #[serde(default)]
    pub name: String,
    /// Its version.
    #[serde(default)]
    pub version: String,
    /// Where it failed: the fault.
    #[serde(flatten)]
    pub failure: Option<PlannerFaultRecord>,
}

/// Samples of the attacker's motion and of the recorded ones.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ComparedSamples {
    /// Of the attackers.
    pub attacker: MotionSamples,
    /// Of all recorded motions.
    pub recorded: MotionSamples,
}

impl VariantLine {
    /// The ids of all attackers.
    #[must_use]
    pub fn ids(&self) -> Vec<i64> {
        let all = self.attackers.iter().flatten();
        all.map(|one| one.id).collect()
    }

    /// The planner that is attacked: as it was named, and as its process names itself.
    #[must_use]
    pub fn attacked(&self) -> String {
        match &self.external_planner {
            Some(process) if !process.name.is_empty() => {
                let identity = format!("{} {}", process.name, process.version);
                format!("{} ({})", identity.trim(), self.planner)
            }
            _ => self.planner.clone(),
        }
    }

    /// Whether its drive ended with a hit from behind, which is no effect.
    #[must_use]
    pub fn is_hit_from_behind(&self) -> bool {
        let kind = self.collision_kind.as_deref();
        kind == Some(CollisionKind::RearEnded.name()) && self.outcome != OutcomeName::Collision
    }

    /// What the attackers do: the names of their manoeuvres.
    #[must_use]
    pub fn manoeuvres(&self) -> Option<String> {
        let all = self.attackers.as_ref().filter(|all| !all.is_empty())?;
        let names: Vec<&str> = all.iter().map(|one| one.manoeuvre.as_str()).collect();
        Some(names.join(" + "))
    }

    /// What the ideal driver who survives does that is to be noted: broken rules, leaving the roadway.
    #[must_use]
    pub fn good_driver_note(&self) -> Option<String> {
        let driver = self.good_driver.as_ref()?;
        let rules = (!driver.rules_broken.is_empty())
            .then(|| format!("breaks {}", driver.rules_broken.join(", ")));
        let leaves = driver
            .leaves_roadway_step
            .map(|step| format!("leaves the lanelets of cars at step {step}"));
        let both: Vec<String> = rules.into_iter().chain(leaves).collect();
        (!both.is_empty()).then(|| format!("the ideal driver {}", both.join(" and ")))
    }

    /// The longest reaction time (s) with which an ideal driver avoids it.
    #[must_use]
    pub fn latest(&self) -> Option<&str> {
        let all = self.avoidable.iter().flatten();
        let avoided = all.filter(|(_, avoided)| **avoided);
        avoided.map(|(delay, _)| delay.as_str()).next_back()
    }
}

impl VariantLine {
    /// The same with its rejected motions.
    #[must_use]
    pub fn with_rejected(self, generated: &Generated) -> Self {
        Self {
            rejected: Some(generated.refusals().iter().map(Into::into).collect()),
            ..self
        }
    }

    /// The same, saved in these files.
    #[must_use]
    pub fn saved_as(mut self, saved: &VariantFiles) -> Self {
        let path = |path: &std::path::Path| Some(visible(&path.display().to_string()).into_owned());
        self.variant = path(&saved.scenario);
        self.ego = path(&saved.ego);
        self.id = Some(saved.id.clone());
        self
    }

    /// That of a variant that is not saved yet, without its rejected motions.
    #[must_use]
    pub fn new(generated: &Generated, by: &str) -> Self {
        let made = &generated.made;
        let workshop = &generated.workshop;
        let chosen = made.chosen.as_ref();
        let effect = chosen.and_then(|c| c.attack.effect.as_ref());
        let contact = effect.and_then(|e| e.contact);
        let main = chosen.zip(effect);
        let main = main.and_then(|(c, effect)| c.attack.asked.get(effect.main));
        let baseline = workshop.closed.baseline();
        let driver = workshop.closed.driver();
        let planner = match (driver.settings().policy, driver.external()) {
            (Some(policy), _) => policy.name(),
            (None, planner) => planner.map_or("nearmiss", |planner| planner.name()),
        };
        let plausible = chosen.and_then(|c| workshop.plausibility(&c.attack.change));
        let driven = made.found.attacks.iter().filter(|a| a.effect.is_some());
        let process = baseline.drive().external.as_ref();
        let broken = effect.filter(|effect| effect.breaks_planner());
        let broken = broken.and_then(|effect| effect.drive.external.as_ref());
        let preventability = { chosen.zip(effect) }
            .and_then(|(c, effect)| effect.preventability(&workshop.closed, &c.avoidability));
        let unmet = preventability
            .as_ref()
            .and_then(|found| generated.unmet(found));
        let notes: Vec<String> = unmet.into_iter().chain(generated.note()).collect();
        Self {
            scenario: generated.name.clone(),
            file: generated.file.clone(),
            hash: short_hash(&workshop.closed.scenario().hash),
            by: by.into(),
            outcome: effect.map_or(OutcomeName::None, |e| (&e.consequence).into()),
            attacker: effect.map(|e| e.main().obstacle),
            attackers: chosen.map(|c| attackers(generated, &c.attack)),
            manoeuvre: main.map(|motion| motion.name().into()),
            asked: main.map(Into::into),
            from_step: effect.map(|e| e.from),
            until_step: chosen.and_then(|c| c.attack.change.until_step()),
            min_risk_before: effect.map_or(baseline.lowest(), |e| e.lowest_before()),
            min_risk_after: effect.map_or(baseline.lowest(), |e| e.lowest_after()),
            min_risk_of_anyone_before: baseline.lowest(),
            min_risk_of_anyone_after: effect.map_or(baseline.lowest(), |e| e.anyone_after),
            min_distance: effect.and_then(Effect::distance),
            collision_with: contact.map(|c| c.with),
            collision_step: contact.map(|c| c.step),
            collision_kind: contact.map(|c| c.kind().name().into()),
            ego_side: contact.map(|c| c.ego.name().into()),
            other_side: contact.map(|c| c.other.name().into()),
            impact: { effect.and_then(|e| e.impact.as_ref()) }.map(Into::into),
            touched_after_step: effect.and_then(Effect::touched_after_step),
            avoidable: { chosen.filter(|c| c.avoidability.is_looked_for()) }
                .map(|c| avoidable(&c.avoidability)),
            good_driver: { chosen.zip(effect) }
                .and_then(|(c, effect)| GoodDriver::new(&workshop.closed, &c.avoidability, effect)),
            preventability,
            style: workshop.style().name().into(),
            plausibility: plausible.as_ref().map(|(own, _)| likelihoods(own)),
            motion_samples: plausible.as_ref().map(|(own, recorded)| ComparedSamples {
                attacker: own.samples.clone(),
                recorded: recorded.samples().clone(),
            }),
            note: (!notes.is_empty()).then(|| notes.join("; ")),
            safe_before: workshop.is_safe(),
            baseline: baseline.drive().outcome.name().into(),
            drive: effect.map(|e| e.drive.outcome.name().into()),
            planner: visible(planner).into_owned(),
            external_planner: process.map(|report| ExternalPlannerRecord {
                name: visible(&report.name).into_owned(),
                version: visible(&report.version).into_owned(),
                failure: broken.and_then(|report| {
                    let fault = report.fault?;
                    Some(PlannerFaultRecord::new(
                        fault,
                        report.fault_step,
                        &report.stderr,
                    ))
                }),
            }),
            reference_ranking: { generated.workshop.on(|ground| attacker::rank(ground.stage)) }
                .unwrap_or_default(),
            candidates: made.found.candidates,
            passed: made.found.attacks.len(),
            driven: driven.count(),
            refused: refused(&made.found.refused),
            model: generated.author(),
            seconds: (generated.took.as_secs_f64() * 1e3).round() / 1e3,
            ..Self::default()
        }
    }
}

/// Log-likelihood of the attackers' motions, and that of recorded ones on average.
fn likelihoods(own: &Plausibility) -> LogLikelihoods {
    LogLikelihoods {
        attacker: own.log_likelihood,
        recorded: own.recorded,
    }
}

/// What each attacker does, how near it comes, and how plausible it is.
fn attackers(generated: &Generated, attack: &Attack) -> Vec<AttackerRecord> {
    let effects = attack.effect.iter().flat_map(|effect| &effect.attackers);
    let all = effects.zip(attack.acts()).map(|(effect, (asked, change))| {
        let own = generated
            .workshop
            .plausibility_of(std::slice::from_ref(change));
        AttackerRecord {
            plausibility: own.map(|(own, _)| likelihoods(&own)),
            ..AttackerRecord::new(effect, asked)
        }
    });
    all.collect()
}

impl GoodDriver {
    /// The one with the longest reaction time who survives.
    fn new(closed: &ClosedLoop, avoidability: &Avoidability, effect: &Effect) -> Option<Self> {
        let (delay, way) = avoidability.latest()?;
        let review = way.review(closed, effect);
        let names = |rules: Vec<&'static str>| rules.into_iter().map(String::from).collect();
        Some(Self {
            reaction_time: delay,
            drive: way.drive.outcome.name().into(),
            found_by: way.found.to_string(),
            max_acceleration: Some(review.acceleration),
            rules_broken: names(review.broken()),
            rules_undecided: names(review.undecided()),
            leaves_roadway_step: review.leaves_roadway,
        })
    }
}

fn avoidable(avoidability: &Avoidability) -> BTreeMap<String, bool> {
    let all = avoidability.certificates.iter();
    all.map(|(delay, certificate)| (format!("{delay:.1}"), certificate.avoidance().is_some()))
        .collect()
}

/// How many motions were refused for each reason; of each motion the first counts.
fn refused(refusals: &[Refusal]) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for refusal in refusals {
        *counts.entry(refusal.reason.name().into()).or_default() += 1;
    }
    counts
}
