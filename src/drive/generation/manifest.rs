//! The manifest of a variant, the JSON beside its files: attack, outcome and certificates.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use strum::{IntoStaticStr, VariantArray};

use super::variant::{OTHERS, PROGRAM};
use super::{
    AttackerEffect, Certificate, Consequence, Effect, EvasiveReview, EvasiveTrajectory, Finder,
    Refusal, RiskCurve, SearchEffort, Variant, VariantFiles,
};
use crate::driver::PreventabilityRecord;
use crate::simulation::{Collision, PlannerFault, Rollout};
use nearmiss_scene::metrics::ImpactRecord;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_scene::verdict::{Manoeuvre, Motion, NewMotion, TrajectoryAnswer, WaypointAnswer};

/// All that is recorded of a variant.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Manifest {
    /// Name of the file of the changed scenario.
    pub variant: String,
    /// SHA-256 of each of its files, hexadecimal, by name.
    pub sha256: BTreeMap<String, String>,
    /// Its benchmark id.
    pub benchmark_id: String,
    /// Name of the file of the ego's drive.
    pub ego: String,
    /// Name of the file with the same as a CommonRoad solution.
    pub solution: String,
    /// The program that made it.
    pub program: String,
    /// The author of the attack: a search with its settings, or a model.
    pub by: String,
    /// The recorded scenario.
    pub original: OriginalRecord,
    /// What all participants but ego and attackers do.
    pub other_traffic: String,
    /// The attacker that the ego touches or that comes nearest to it.
    pub attacker: i64,
    /// All of them.
    pub attackers: Vec<AttackerRecord>,
    /// The motion that was requested of the main attacker.
    pub asked: Option<RequestedMotion>,
    /// Where the changed motions lie.
    pub change: ChangedSteps,
    /// The ego's drive.
    pub planning: PlanningRecord,
    /// What the attack leads to.
    pub outcome: OutcomeName,
    /// The contact of the ego, if there is one.
    pub collision: Option<ContactRecord>,
    /// Whether the drive ends with a hit from behind, which is no effect of the attack.
    pub hit_from_behind: bool,
    /// How the planner's process fails under the attack.
    pub planner_error: Option<PlannerFailureRecord>,
    /// The ego's drive in the variant.
    pub drive: DriveEnd,
    /// The ego's drive in the original.
    pub baseline: DriveEnd,
    /// Lowest risk score of an attacker as recorded.
    pub min_risk_before: Option<u8>,
    /// Lowest risk score of an attacker in the variant.
    pub min_risk_after: Option<u8>,
    /// Lowest risk score of all obstacles as recorded.
    pub min_risk_of_anyone_before: Option<u8>,
    /// Lowest risk score of all obstacles in the variant.
    pub min_risk_of_anyone_after: Option<u8>,
    /// Smallest distance of the ego to an attacker, metres.
    pub min_distance: Option<f64>,
    /// Step before a contact that is only between two steps.
    pub touched_after_step: Option<i64>,
    /// Risk scores of the main attacker as recorded: step and score.
    pub risk_before: RiskCurve,
    /// Risk scores of the main attacker in the variant.
    pub risk_after: RiskCurve,
    /// Certificates of ideal drivers by reaction time in seconds; `None` where none was looked for.
    pub avoidable: Option<BTreeMap<String, CertificateRecord>>,
    /// Which drivers avoid its contact or near miss; missing in variants that were saved before this was told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preventability: Option<PreventabilityRecord>,
    /// What was refused on the way to it.
    pub rejected: Vec<RefusalRecord>,
    /// A model's choice and output, if a model is the author.
    pub model: Option<Value>,
    /// What a run over many files needs to reuse the variant.
    pub made: Option<Value>,
}

/// A recorded scenario that was changed.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct OriginalRecord {
    /// Its benchmark id.
    pub benchmark_id: String,
    /// SHA-256 of its file, hexadecimal.
    pub sha256: String,
    /// Its file as it was named.
    pub file: Option<String>,
}

/// What one attacker does, and how near it comes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct AttackerRecord {
    /// Its id.
    pub id: i64,
    /// The kind of motion.
    pub manoeuvre: String,
    /// The motion as data.
    pub asked: RequestedMotion,
    /// The last step before the motion is another one.
    pub from_step: i64,
    /// Last changed step.
    pub until_step: i64,
    /// Its lowest risk score as recorded.
    pub min_risk_before: Option<u8>,
    /// Its lowest risk score in the variant.
    pub min_risk_after: Option<u8>,
    /// Its smallest distance to the ego, metres.
    pub min_distance: Option<f64>,
    /// What the others come to without it.
    pub outcome_without: Option<String>,
    /// Risk scores as recorded: step and score.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub risk_before: RiskCurve,
    /// Risk scores in the variant: step and score.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub risk_after: RiskCurve,
    /// How plausible its motion is beside the recorded ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plausibility: Option<LogLikelihoods>,
}

/// Log-likelihoods of motions, nats per second.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct LogLikelihoods {
    /// Of the attackers' motions.
    #[serde(rename = "log_likelihood_per_second")]
    pub attacker: f64,
    /// Of recorded ones on average.
    #[serde(rename = "recorded_log_likelihood_per_second")]
    pub recorded: f64,
}

/// A requested motion, as a model would write it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct RequestedMotion {
    /// What it does; null if waypoints are given.
    pub manoeuvre: Option<Manoeuvre>,
    /// Its positions in time; null if a manoeuvre is given.
    pub waypoints: Option<Vec<WaypointAnswer>>,
}

/// Where changed motions lie.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ChangedSteps {
    /// The last step before a motion is another one.
    pub from_step: i64,
    /// Last changed step.
    pub until_step: Option<i64>,
    /// Duration of a step, seconds.
    pub seconds_per_step: f64,
}

/// How the ego's drive was planned.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PlanningRecord {
    /// Id of the planning problem.
    pub problem: i64,
    /// Number of the vehicle.
    pub vehicle: u8,
    /// Prediction of other road users.
    pub prediction: String,
    /// Steps driven of each plan.
    pub replan: usize,
    /// Horizon, seconds.
    pub horizon: f64,
    /// What the built-in planner makes of the traffic rules.
    pub rules: String,
    /// The planner that is attacked.
    pub planner: PlannerIdentity,
}

/// A planner: the built-in one by its name, or a process with what it says of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PlannerIdentity {
    /// The built-in one.
    BuiltIn(String),
    /// A process.
    External {
        /// As it was named.
        named: String,
        /// Its name as it says.
        name: String,
        /// Its version as it says.
        version: String,
        /// What its time is.
        clock: String,
        /// Whether obstacles came with predictions.
        predictions: bool,
        /// Earlier states that each obstacle came with, at most.
        history: usize,
    },
}

impl Default for PlannerIdentity {
    fn default() -> Self {
        Self::BuiltIn("nearmiss".into())
    }
}

/// How a planner's process fails.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct PlannerFailureRecord {
    /// Name of the fault.
    pub error: Option<String>,
    /// Time step.
    pub error_step: Option<i64>,
    /// What it says.
    pub message: Option<String>,
    /// Last lines of standard error.
    pub stderr: Vec<String>,
}

/// How a drive ends.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct DriveEnd {
    /// Name of its outcome.
    pub ended_with: String,
    /// First step.
    pub first_step: Option<i64>,
    /// Last step.
    pub last_step: Option<i64>,
}

/// A contact of the ego.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ContactRecord {
    /// Id of the obstacle.
    pub with: i64,
    /// Whether it attacks.
    pub with_attacker: bool,
    /// Step.
    pub step: i64,
    /// Side of the ego that is hit.
    pub ego_side: String,
    /// Side of the obstacle that is hit.
    pub other_side: String,
    /// How hard it is; missing in variants that were saved before it was told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impact: Option<ImpactRecord>,
}

/// Whether an ideal driver with a reaction time avoids a variant, and how or why not.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CertificateRecord {
    /// Whether.
    pub avoided: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// The drive that does. A wrong type in it is a mistake of the file, not the absence of a drive.
    #[serde(flatten, deserialize_with = "read_evasion")]
    pub evasion: Option<EvasionRecord>,
    /// Extent of the search.
    pub searched: SearchRecord,
}

fn read_evasion<'de, D: Deserializer<'de>>(fields: D) -> Result<Option<EvasionRecord>, D::Error> {
    EvasionRecord::deserialize(fields).map(Some)
}

/// A drive that avoids a variant.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EvasionRecord {
    /// Name of its file.
    pub trajectory: Option<String>,
    /// Last step before it is another drive than the attacked one; who drives on as if nothing had changed departs from
    /// nothing.
    pub departs_after_step: Option<i64>,
    /// What found it.
    pub found_by: String,
    /// What it does, where it is one manoeuvre.
    pub manoeuvre: Option<EvasiveManoeuvreRecord>,
    /// How it ends.
    pub ends: DriveEnd,
    /// The largest acceleration along and across, m/s².
    pub max_acceleration: Option<f64>,
    /// Traffic rules that it breaks.
    pub rules_broken: Vec<String>,
    /// Traffic rules that cannot be decided of it.
    pub rules_undecided: Vec<String>,
    /// The step at which it leaves the lanelets of cars.
    pub leaves_roadway_step: Option<i64>,
}

/// One evasive manoeuvre.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EvasiveManoeuvreRecord {
    /// m/s².
    pub acceleration: f64,
    /// The speed up to which it is kept, m/s.
    pub until_speed: f64,
    /// Metres to the left.
    pub offset: f64,
    /// Share of the friction that it uses.
    pub grip: f64,
}

/// Extent of a search.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct SearchRecord {
    #[serde(flatten)]
    effort: SearchEffort,
    /// The same in words.
    words: String,
}

/// A refused motion.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct RefusalRecord {
    /// Name of the reason.
    pub reason: String,
    /// Time step.
    pub step: Option<i64>,
    /// The most that is allowed.
    pub limit: Option<f64>,
    /// The value that was found.
    pub value: Option<f64>,
    /// Of both.
    pub unit: String,
    /// The same in words.
    pub words: String,
    /// The obstacle, where known.
    pub attacker: Option<i64>,
    /// The kind of motion, where known.
    pub manoeuvre: Option<String>,
}

/// The names of outcomes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum OutcomeName {
    /// Contact.
    Collision,
    /// The planner's process fails.
    PlannerError,
    /// The worst risk score of an attacker is 0 or 1.
    NearMiss,
    /// None of these.
    NoEffect,
    /// There is no variant.
    #[default]
    None,
}

nearmiss_record::named!(OutcomeName, "outcome");

impl OutcomeName {
    /// Whether the ego comes to harm, or nearly.
    #[must_use]
    pub fn is_effective(self) -> bool {
        matches!(self, Self::Collision | Self::NearMiss)
    }
}

impl From<&Consequence> for OutcomeName {
    fn from(consequence: &Consequence) -> Self {
        match consequence {
            Consequence::Collision(_) => Self::Collision,
            Consequence::PlannerError(_) => Self::PlannerError,
            Consequence::NearMiss => Self::NearMiss,
            Consequence::NoEffect => Self::NoEffect,
        }
    }
}

impl Manifest {
    /// That of a variant which is saved in these files, with their contents.
    pub(super) fn new(
        variant: &Variant<'_>,
        saved: &VariantFiles,
        files: &[(&PathBuf, Vec<u8>)],
    ) -> Self {
        let effect = variant.effect;
        let original = variant.closed.scenario();
        let driver = variant.closed.driver();
        let settings = driver.settings();
        let baseline = variant.closed.baseline().drive();
        let hashes = files.iter().map(|(path, bytes)| {
            let hash = ContentHash::digest(bytes).to_string();
            (file_name(path), hash)
        });
        Self {
            variant: file_name(&saved.scenario),
            sha256: hashes.collect(),
            benchmark_id: saved.id.clone(),
            ego: file_name(&saved.ego),
            solution: file_name(&saved.solution),
            program: PROGRAM.into(),
            by: variant.by.into(),
            original: OriginalRecord {
                benchmark_id: original.header.benchmark_id.clone(),
                sha256: original.hash.to_string(),
                file: Some(variant.file.into()),
            },
            other_traffic: OTHERS.into(),
            attacker: effect.main().obstacle,
            attackers: attackers(variant),
            asked: variant.asked.get(effect.main).map(RequestedMotion::from),
            change: ChangedSteps {
                from_step: effect.from,
                until_step: variant.change.until_step(),
                seconds_per_step: driver.dt(),
            },
            planning: PlanningRecord {
                problem: driver.problem().id,
                vehicle: settings.planner.vehicle.number(),
                prediction: settings.forecast.name().into(),
                replan: settings.replan,
                horizon: settings.planner.horizon,
                rules: settings.planner.rules.name().into(),
                planner: match settings.policy {
                    Some(policy) => PlannerIdentity::BuiltIn(policy.name().into()),
                    None => planner(baseline),
                },
            },
            outcome: OutcomeName::from(&effect.consequence),
            collision: effect.contact.map(|c| contact(&c, effect)),
            hit_from_behind: effect.is_hit_from_behind(),
            planner_error: { effect.breaks_planner() }
                .then(|| failure(&effect.drive))
                .flatten(),
            drive: DriveEnd::from(&effect.drive),
            baseline: DriveEnd::from(baseline),
            min_risk_before: effect.lowest_before(),
            min_risk_after: effect.lowest_after(),
            min_risk_of_anyone_before: effect.anyone_before,
            min_risk_of_anyone_after: effect.anyone_after,
            min_distance: effect.distance(),
            touched_after_step: effect.touched_after_step(),
            risk_before: effect.main().before.clone(),
            risk_after: effect.main().after.clone(),
            avoidable: variant.certificates(saved),
            preventability: effect.preventability(variant.closed, variant.avoidability),
            rejected: variant.refusals.iter().map(RefusalRecord::from).collect(),
            model: variant.author.cloned(),
            made: variant.made.cloned(),
        }
    }
}

/// The planner that is attacked: the built-in one, or a process with what it was told.
fn planner(baseline: &Rollout) -> PlannerIdentity {
    let Some(report) = &baseline.external else {
        return PlannerIdentity::default();
    };
    PlannerIdentity::External {
        named: report.planner.clone(),
        name: report.name.clone(),
        version: report.version.clone(),
        clock: report.clock.name().into(),
        predictions: report.predictions,
        history: report.history,
    }
}

/// How the planner's process failed.
fn failure(drive: &Rollout) -> Option<PlannerFailureRecord> {
    let report = drive.external.as_ref()?;
    Some(PlannerFailureRecord {
        error: report.fault.map(|fault| PlannerFault::name(fault).into()),
        error_step: report.fault_step,
        message: report.message.clone(),
        stderr: report.stderr.clone(),
    })
}

/// What each attacker does, and how near it comes, step by step.
fn attackers(variant: &Variant<'_>) -> Vec<AttackerRecord> {
    let effects = variant.effect.attackers.iter();
    let all = effects
        .zip(variant.asked)
        .map(|(effect, motion)| AttackerRecord {
            risk_before: effect.before.clone(),
            risk_after: effect.after.clone(),
            ..AttackerRecord::new(effect, motion)
        });
    all.collect()
}

impl AttackerRecord {
    /// What it does, and how near it comes at its nearest.
    #[must_use]
    pub fn new(effect: &AttackerEffect, motion: &Motion) -> Self {
        Self {
            id: effect.obstacle,
            manoeuvre: motion.name().into(),
            asked: motion.into(),
            from_step: effect.from,
            until_step: effect.until,
            min_risk_before: effect.lowest_before(),
            min_risk_after: effect.lowest_after(),
            min_distance: effect.distance,
            outcome_without: effect.without.as_ref().map(|without| without.name().into()),
            ..Self::default()
        }
    }
}

impl From<&Motion> for RequestedMotion {
    fn from(motion: &Motion) -> Self {
        let answer = TrajectoryAnswer::from(NewMotion {
            obstacle: 0,
            motion: motion.clone(),
            justification: String::new(),
        });
        Self {
            manoeuvre: answer.manoeuvre,
            waypoints: answer.waypoints,
        }
    }
}

/// Files lie beside the manifest: only the name counts.
fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

impl From<&Rollout> for DriveEnd {
    fn from(drive: &Rollout) -> Self {
        Self {
            ended_with: drive.outcome.name().into(),
            first_step: drive.states.first().map(|(step, _)| *step),
            last_step: drive.states.last().map(|(step, _)| *step),
        }
    }
}

fn contact(collision: &Collision, effect: &Effect) -> ContactRecord {
    ContactRecord {
        with: collision.with,
        with_attacker: effect.is_attacker(collision.with),
        step: collision.step,
        ego_side: collision.ego.name().into(),
        other_side: collision.other.name().into(),
        impact: effect.impact.as_ref().map(Into::into),
    }
}

impl Variant<'_> {
    /// An answer for each reaction time (s), each with its proof and the name of its file among those that are `saved`;
    /// nothing where none was looked for.
    #[must_use]
    pub fn certificates(
        &self,
        saved: &VariantFiles,
    ) -> Option<BTreeMap<String, CertificateRecord>> {
        let is_looked_for = self.avoidability.is_looked_for();
        is_looked_for.then(|| certificates(self, saved))
    }
}

fn certificates(
    variant: &Variant<'_>,
    saved: &VariantFiles,
) -> BTreeMap<String, CertificateRecord> {
    // Several reaction times often share a trajectory.
    let mut last: Option<(&Arc<EvasiveTrajectory>, EvasiveReview)> = None;
    let all = variant.avoidability.certificates.iter();
    let all = all.map(|(delay, certificate)| {
        let file = saved.avoiding.iter().find(|(of, _)| of == delay);
        let record = match certificate {
            Certificate::Avoided(avoidance) => {
                let file = file.map(|(_, path)| file_name(path));
                let known = last
                    .take()
                    .filter(|(known, _)| Arc::ptr_eq(known, avoidance))
                    .map(|(_, review)| review);
                let review =
                    known.unwrap_or_else(|| avoidance.review(variant.closed, variant.effect));
                let record = CertificateRecord {
                    avoided: true,
                    why: None,
                    evasion: Some(EvasionRecord::new(avoidance, &review, file)),
                    searched: avoidance.searched.into(),
                };
                last = Some((avoidance, review));
                record
            }
            Certificate::NotFound(nothing) => CertificateRecord {
                avoided: false,
                why: Some(nothing.why.to_string()),
                evasion: None,
                searched: nothing.searched.into(),
            },
        };
        (format!("{delay:.1}"), record)
    });
    all.collect()
}

impl EvasionRecord {
    /// What `avoidance` does, as `review` found it, with the name of its file.
    #[must_use]
    pub fn new(
        avoidance: &EvasiveTrajectory,
        review: &EvasiveReview,
        file: Option<String>,
    ) -> Self {
        let names = |rules: Vec<&'static str>| rules.into_iter().map(String::from).collect();
        Self {
            trajectory: file,
            departs_after_step: (avoidance.found != Finder::Unchanged)
                .then_some(avoidance.reaction),
            found_by: avoidance.found.to_string(),
            manoeuvre: match avoidance.found {
                Finder::Manoeuvre(m) => Some(EvasiveManoeuvreRecord {
                    acceleration: m.acceleration,
                    until_speed: m.until,
                    offset: m.offset,
                    grip: m.grip,
                }),
                Finder::Unchanged | Finder::Planner(_) => None,
            },
            ends: DriveEnd::from(&avoidance.drive),
            max_acceleration: Some(review.acceleration),
            rules_broken: names(review.broken()),
            rules_undecided: names(review.undecided()),
            leaves_roadway_step: review.leaves_roadway,
        }
    }
}

impl From<SearchEffort> for SearchRecord {
    fn from(effort: SearchEffort) -> Self {
        Self {
            words: effort.to_string(),
            effort,
        }
    }
}

impl From<&Refusal> for RefusalRecord {
    fn from(refusal: &Refusal) -> Self {
        Self {
            reason: refusal.reason.name().into(),
            step: refusal.step,
            limit: refusal.limit,
            value: refusal.value,
            unit: refusal.reason.unit().into(),
            words: refusal.to_string(),
            attacker: refusal.attacker,
            manoeuvre: refusal.manoeuvre.map(String::from),
        }
    }
}
