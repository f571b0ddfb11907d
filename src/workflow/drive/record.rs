//! A planner's drive as a record for programs.

use nearmiss_base::system::counted;
use nearmiss_drive::driver::PreventabilityRecord;
use nearmiss_drive::planner::Emergency;
use nearmiss_drive::simulation::{BeyondVehicle, ExternalReport, Outcome, PlannerFault};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::ImpactRecord;
use nearmiss_scene::traffic_rules::Rule;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DrivenScenario, MonitorRecord, RuleRecord};
use crate::tables::short_hash;

/// How a drive ended and what it took.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct DriveRecord {
    /// Name of the scenario: its file name without the ending.
    pub scenario: String,
    /// File of the scenario.
    pub file: String,
    /// First 12 digits of the SHA-256 of the scenario's content.
    pub hash: String,
    /// The planner as it was named; nearmiss is the built-in one.
    pub planner: String,
    /// How it ended: goal, collision, timeout, off_road, infeasible or planner_error.
    pub outcome: String,
    /// Id of the obstacle that the ego collides with.
    pub collision_with: Option<i64>,
    /// Step of the collision.
    pub collision_step: Option<i64>,
    /// ran_into (the ego's front), rear_ended (the obstacle's front, the ego's rear) or side.
    pub collision_kind: Option<String>,
    /// Side of the ego that is hit.
    pub ego_side: Option<String>,
    /// Side of the other body that is hit.
    pub other_side: Option<String>,
    /// How hard the collision is.
    pub impact: Option<ImpactRecord>,
    /// Which drivers would have avoided the collision.
    pub preventability: Option<PreventabilityRecord>,
    /// An obstacle drove into the ego's rear: unaware (it followed its recording) or reacting.
    pub hit_from_behind: Option<String>,
    /// Steps driven.
    pub steps: usize,
    /// Planning cycles.
    pub cycles: usize,
    /// Median duration of a cycle.
    #[schemars(extend("unit" = "ms"))]
    pub median_cycle_ms: Option<f64>,
    /// Longest duration of a cycle.
    #[schemars(extend("unit" = "ms"))]
    pub longest_cycle_ms: Option<f64>,
    /// Cycles without a feasible candidate.
    pub emergency_cycles: usize,
    /// Of these, cycles in which the ego brakes along its path.
    pub braking_cycles: usize,
    /// Cycles with refined sampling.
    pub refined_cycles: usize,
    /// Id of the planning problem.
    pub planning_problem: i64,
    /// Prediction of other road users.
    pub prediction: String,
    /// Number of the vehicle.
    pub vehicle: u8,
    /// Planning horizon.
    #[schemars(extend("unit" = "s"))]
    pub horizon: f64,
    /// Steps driven of each plan.
    pub replan: usize,
    /// First step.
    pub first_step: Option<i64>,
    /// Last step.
    pub last_step: Option<i64>,
    /// Index of the goal that was reached.
    pub goal: Option<usize>,
    /// What the other road users do: recorded or reactive.
    pub traffic: String,
    /// Obstacles that reacted.
    pub reacted: usize,
    /// Last recorded step of the first obstacle that reacted.
    pub first_reaction_step: Option<i64>,
    /// Obstacles that reacted, and their last recorded steps.
    pub reactions: Vec<ReactionRecord>,
    /// Largest deceleration.
    #[schemars(extend("unit" = "m/s²"))]
    pub largest_deceleration: f64,
    /// Mean of the absolute jerk.
    #[schemars(extend("unit" = "m/s³"))]
    pub mean_jerk: Option<f64>,
    /// Largest absolute jerk.
    #[schemars(extend("unit" = "m/s³"))]
    pub max_jerk: Option<f64>,
    /// From the start to the goal; null without arrival.
    #[schemars(extend("unit" = "s"))]
    pub seconds_to_goal: Option<f64>,
    /// Obstacles with a risk score of 1 or 0 that are not touched; null without --planner.
    pub near_misses: Option<usize>,
    /// What the built-in planner makes of the traffic rules: obey or off.
    pub rule_mode: String,
    /// What became of each traffic rule.
    pub rules: Vec<RuleRecord>,
    /// Traffic rules that the drive breaks.
    pub rules_broken: Vec<String>,
    /// What became of each traffic rule in the recorded ego's drive; null without one.
    pub recorded_rules: Option<Vec<RuleRecord>>,
    /// Traffic rules that the recorded ego breaks; null without one.
    pub recorded_rules_broken: Option<Vec<String>>,
    /// Remark for people.
    pub note: Option<String>,
    /// Steps that the vehicle cannot do; null where there are none, and of recordings, which are of other vehicles.
    pub beyond_vehicle: Option<BeyondVehicleRecord>,
    /// Of a planner that is a process.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub external_planner: Option<ExternalDriveRecord>,
    /// With --monitor: what the monitor said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monitor: Option<MonitorRecord>,
}

/// An obstacle that reacted.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ReactionRecord {
    obstacle: i64,
    /// Its last recorded step.
    step: i64,
}

/// What is known of a planner's process.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct ExternalDriveRecord {
    /// Its name as it says.
    pub name: String,
    /// Its version as it says.
    pub version: String,
    /// Simulated or real time.
    pub clock: String,
    /// What predictions came from; null for none.
    pub predictions: Option<String>,
    /// Earlier states of obstacles.
    pub history: usize,
    /// Name of the fault that ended the drive.
    pub error: Option<String>,
    /// Step of the fault.
    pub error_step: Option<i64>,
    /// The fault's details, or why nothing could be driven.
    pub message: Option<String>,
    /// The last lines of standard error.
    pub stderr: Vec<String>,
    /// From the start of the process until it was ready.
    #[schemars(extend("unit" = "s"))]
    pub start_seconds: Option<f64>,
    /// Median of the time of a cycle that the planner did not measure itself.
    #[schemars(extend("unit" = "ms"))]
    pub median_overhead_ms: Option<f64>,
    /// In real time: the most steps until an answer counted.
    pub late_steps: usize,
    /// In real time: the largest distance between the ego and a trajectory that came late.
    #[schemars(extend("unit" = "m"))]
    pub largest_offset: f64,
}

/// What of a drive the vehicle cannot do.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct BeyondVehicleRecord {
    /// Steps that it cannot do.
    pub steps: usize,
    /// The first of them.
    pub first_step: i64,
    /// What it is beyond.
    pub first_bound: String,
    /// The worst of them.
    pub worst: UndrivableRecord,
}

/// A step that the vehicle cannot do.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct UndrivableRecord {
    step: i64,
    /// What it is beyond.
    bound: String,
    value: f64,
    /// At most allowed.
    limit: f64,
    unit: String,
}

/// How a planner's process failed.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PlannerFailure")]
pub struct PlannerFaultRecord {
    /// Name of the fault.
    error: String,
    /// The time step.
    error_step: Option<i64>,
    /// The last lines of standard error.
    stderr: Vec<String>,
}

impl DriveRecord {
    /// Of a drive.
    #[must_use]
    pub fn new(driven: &DrivenScenario) -> Self {
        let collision = driven.collision();
        let ms = driven.milliseconds();
        let braking = driven.emergencies().filter(|e| *e == Emergency::Braking);
        let states = &driven.drive.states;
        let jerk = driven.drive.jerk();
        let settings = &driven.settings;
        let reactions = &driven.drive.traffic.reactions;
        let recorded = driven.recorded_rules.as_ref();
        let dt = driven.scenario.dt();
        let broken = |rules: &mut dyn Iterator<Item = Rule>| -> Vec<String> {
            rules.map(|rule| rule.name().into()).collect()
        };
        Self {
            scenario: driven.name.clone(),
            file: driven.file.clone(),
            hash: short_hash(&driven.scenario.hash),
            planner: visible(driven.planner()).into_owned(),
            outcome: driven.outcome().name().into(),
            collision_with: collision.map(|c| c.with),
            collision_step: collision.map(|c| c.step),
            collision_kind: collision.map(|c| c.kind().name().into()),
            ego_side: collision.map(|c| c.ego.name().into()),
            other_side: collision.map(|c| c.other.name().into()),
            impact: driven.impact.as_ref().map(Into::into),
            preventability: driven.preventability(),
            hit_from_behind: driven.drive.hit_from_behind().map(|hit| hit.name().into()),
            steps: driven.steps(),
            cycles: driven.drive.cycles.len(),
            median_cycle_ms: ms.map(|(median, _)| thousandths(median)),
            longest_cycle_ms: ms.map(|(_, longest)| thousandths(longest)),
            emergency_cycles: driven.emergencies().count(),
            braking_cycles: braking.count(),
            refined_cycles: driven.refined(),
            planning_problem: driven.problem,
            prediction: settings.forecast.name().into(),
            vehicle: settings.planner.vehicle.number(),
            horizon: settings.planner.horizon,
            replan: settings.replan,
            first_step: states.first().map(|(step, _)| *step),
            last_step: states.last().map(|(step, _)| *step),
            goal: match driven.outcome() {
                Outcome::Goal(place) => Some(*place),
                _ => None,
            },
            traffic: settings.traffic.name().into(),
            reacted: reactions.len(),
            first_reaction_step: reactions.first().map(|reaction| reaction.from),
            reactions: { reactions.iter() }
                .map(|reaction| ReactionRecord {
                    obstacle: reaction.obstacle,
                    step: reaction.from,
                })
                .collect(),
            largest_deceleration: thousandths(driven.drive.largest_deceleration()),
            mean_jerk: jerk.map(|(mean, _)| thousandths(mean)),
            max_jerk: jerk.map(|(_, most)| thousandths(most)),
            seconds_to_goal: driven.drive.seconds_to_goal().map(thousandths),
            near_misses: driven.near_misses,
            rule_mode: settings.planner.rules.name().into(),
            rules: RuleRecord::all(&driven.rules, dt),
            rules_broken: broken(&mut driven.rules.broken()),
            recorded_rules: recorded.map(|report| RuleRecord::all(report, dt)),
            recorded_rules_broken: recorded.map(|report| broken(&mut report.broken())),
            note: driven.note(),
            beyond_vehicle: driven.beyond_vehicle().map(Into::into),
            external_planner: { driven.drive.external.as_ref() }
                .map(|report| ExternalDriveRecord::new(driven, report)),
            monitor: driven.monitor.as_ref().map(MonitorRecord::from),
        }
    }

    /// A planner's process and what it was told; nothing where it never got ready.
    #[must_use]
    pub fn planner_summary(&self) -> Option<String> {
        let process = self.external_planner.as_ref()?;
        if process.name.is_empty() {
            return None;
        }
        let identity = format!("{} {}", process.name, process.version);
        let predictions = match &process.predictions {
            None => "no predictions".into(),
            Some(from) => format!("prediction {from}"),
        };
        let words = format!(
            "{}: {} time, {predictions}, {} earlier states",
            identity.trim(),
            process.clock,
            process.history
        );
        Some(visible(&words).into_owned())
    }
}

impl ExternalDriveRecord {
    fn new(driven: &DrivenScenario, report: &ExternalReport) -> Self {
        Self {
            name: visible(&report.name).into_owned(),
            version: visible(&report.version).into_owned(),
            clock: report.clock.name().into(),
            predictions: { report.predictions }.then(|| driven.settings.forecast.name().into()),
            history: report.history,
            error: report.fault.map(|fault| fault.name().into()),
            error_step: match driven.outcome() {
                Outcome::PlannerError(error) => Some(error.step),
                _ => None,
            },
            message: report
                .message
                .as_deref()
                .map(|words| visible(words).into_owned()),
            stderr: last_lines(&report.stderr),
            start_seconds: report
                .started_in
                .map(|took| thousandths(took.as_secs_f64())),
            median_overhead_ms: driven.overhead().map(thousandths),
            late_steps: report.late_steps,
            largest_offset: thousandths(report.largest_offset),
        }
    }
}

impl From<BeyondVehicle> for BeyondVehicleRecord {
    fn from(
        BeyondVehicle {
            steps,
            first,
            worst,
        }: BeyondVehicle,
    ) -> Self {
        Self {
            steps,
            first_step: first.step,
            first_bound: first.bound.name().into(),
            worst: UndrivableRecord {
                step: worst.step,
                bound: worst.bound.name().into(),
                value: thousandths(worst.value),
                limit: thousandths(worst.most),
                unit: worst.bound.unit().into(),
            },
        }
    }
}

impl std::fmt::Display for BeyondVehicleRecord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let worst = &self.worst;
        write!(
            f,
            "{} beyond the vehicle, first: step {}, worst: {} {:.2} {} at step {}, at most {:.2}",
            counted(self.steps, "step"),
            self.first_step,
            worst.bound,
            worst.value,
            worst.unit,
            worst.step,
            worst.limit
        )
    }
}

/// The last lines of standard error, as they may be shown.
fn last_lines(stderr: &[String]) -> Vec<String> {
    let last = stderr.len().saturating_sub(STDERR_LINES);
    let lines = stderr[last..].iter();
    let short = |line: &String| line.chars().take(STDERR_COLUMNS).collect::<String>();
    lines
        .map(|line| visible(&short(line)).into_owned())
        .collect()
}

/// Lines of standard error in a document.
const STDERR_LINES: usize = 20;

/// Characters of such a line; the log has all.
const STDERR_COLUMNS: usize = 500;

impl PlannerFaultRecord {
    /// The fault, the time step, and the last lines of standard error.
    #[must_use]
    pub fn new(fault: PlannerFault, step: Option<i64>, stderr: &[String]) -> Self {
        Self {
            error: fault.name().into(),
            error_step: step,
            stderr: last_lines(stderr),
        }
    }
}

/// Microseconds are enough.
#[must_use]
pub fn thousandths(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}
