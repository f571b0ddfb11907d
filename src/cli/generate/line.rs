//! What is known of one scenario's variant: the JSON line, from which table and report are made, too.
//!
//! Both read only the line, so one reused from an earlier run counts like a new one.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::json::Output;
use crate::plan::PlannerFailure;
use nearmiss_drive::generation::{
    AttackerRecord, LogLikelihoods, MotionSamples, OutcomeName, RefusalRecord, RequestedMotion,
};
use nearmiss_drive::simulation::CollisionKind;
use nearmiss_study::evaluation::generating::AuthoredRecord;

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
    /// Step before a contact that is only between two steps.
    pub touched_after_step: Option<i64>,
    /// Whether a good driver avoids it, by reaction time in seconds.
    pub avoidable: Option<BTreeMap<String, bool>>,
    /// The good driver with the longest reaction time who survives.
    pub good_driver: Option<GoodDriver>,
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
    pub reference_ranking: Vec<RankedAttacker>,
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

impl Output for VariantLine {
    const NAME: &'static str = "generate";
    const TITLE: &'static str = "`generate --format json`: one scenario a line";
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
    pub failure: Option<PlannerFailure>,
}

/// A possible attacker, by the reference.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct RankedAttacker {
    /// Its id.
    pub id: i64,
    /// The least acceleration that brings it to the ego, m/s².
    pub acceleration: f64,
    /// When.
    pub step: i64,
    /// How near it is as recorded, metres.
    pub distance: f64,
    /// Whether it is near.
    pub near: bool,
    /// Whether it comes from behind.
    pub behind: bool,
    /// Whether it reaches the ego without reversing.
    pub reaches: bool,
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
    pub fn ids(&self) -> Vec<i64> {
        let all = self.attackers.iter().flatten();
        all.map(|one| one.id).collect()
    }

    /// The planner that is attacked: as it was named, and as its process names itself.
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
    pub fn is_hit_from_behind(&self) -> bool {
        let kind = self.collision_kind.as_deref();
        kind == Some(CollisionKind::RearEnded.name()) && self.outcome != OutcomeName::Collision
    }

    /// What the attackers do: the names of their manoeuvres.
    pub fn manoeuvres(&self) -> Option<String> {
        let all = self.attackers.as_ref().filter(|all| !all.is_empty())?;
        let names: Vec<&str> = all.iter().map(|one| one.manoeuvre.as_str()).collect();
        Some(names.join(" + "))
    }

    /// What the good driver who survives does that is to be noted: broken rules, leaving the roadway.
    pub fn good_driver_note(&self) -> Option<String> {
        let driver = self.good_driver.as_ref()?;
        let rules = (!driver.rules_broken.is_empty())
            .then(|| format!("breaks {}", driver.rules_broken.join(", ")));
        let leaves = driver
            .leaves_roadway_step
            .map(|step| format!("leaves the lanelets of cars at step {step}"));
        let both: Vec<String> = rules.into_iter().chain(leaves).collect();
        (!both.is_empty()).then(|| format!("the good driver {}", both.join(" and ")))
    }

    /// The longest reaction time (s) with which a good driver avoids it.
    pub fn latest(&self) -> Option<&str> {
        let all = self.avoidable.iter().flatten();
        let avoided = all.filter(|(_, avoided)| **avoided);
        avoided.map(|(delay, _)| delay.as_str()).next_back()
    }
}
