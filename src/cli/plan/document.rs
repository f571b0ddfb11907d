//! A planner drive for programs: its outcome, and every cycle.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::driven::{DrivenScenario, RuleRecord};
use super::monitor::MonitorRecord;
use crate::json::Output;
use crate::output;
use nearmiss_drive::planner::{Emergency, VehicleState};
use nearmiss_drive::simulation::{BeyondVehicle, Cycle, ExternalReport, Outcome, PlannerFault};
use nearmiss_formats::Entry;
use nearmiss_scene::traffic_rules::Rule;
use nearmiss_workflow::PlanError;
use nearmiss_workflow::tables::short_hash;

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
    /// Of a planner that is a process.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub external_planner: Option<ExternalDriveRecord>,
    /// With --monitor: what the monitor said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub monitor: Option<MonitorRecord>,
}

impl Output for DriveRecord {
    const NAME: &'static str = "plan";
    const TITLE: &'static str = "`plan --format json`: one drive a line";
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
    /// Steps that the vehicle cannot do.
    pub undrivable: usize,
    /// The first of them.
    pub first_undrivable_step: Option<i64>,
    /// What it is beyond.
    pub first_undrivable: Option<String>,
    /// The worst of them.
    pub worst_undrivable: Option<UndrivableRecord>,
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

/// A scenario that was not driven, and why.
#[derive(Debug, Serialize, JsonSchema)]
pub struct NotDrivenRecord {
    /// Always null.
    outcome: Option<String>,
    /// Name of the scenario: its file name without the ending.
    scenario: String,
    /// File of the scenario.
    file: String,
    /// Why the scenario could not be planned.
    error: String,
    /// How the planner's process failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    external_planner: Option<PlannerFailure>,
}

impl Output for NotDrivenRecord {
    const NAME: &'static str = "not-driven";
    const TITLE: &'static str =
        "`plan --format json`, `generate --format json`: a scenario that could not be driven";
}

/// How a planner's process failed.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct PlannerFailure {
    /// Name of the fault.
    error: String,
    /// The time step.
    error_step: Option<i64>,
    /// The last lines of standard error.
    stderr: Vec<String>,
}

/// One planning cycle.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CycleRecord {
    /// Name of the scenario.
    scenario: String,
    /// Id of the planning problem.
    planning_problem: i64,
    /// Time step.
    step: i64,
    /// Candidates; this and the next four are null for a planner that is a process.
    candidates: Option<usize>,
    /// Feasible candidates.
    feasible: Option<usize>,
    /// Rejected candidates by reason.
    rejected: Option<BTreeMap<&'static str, usize>>,
    /// Refinements of the sampling.
    refinements: Option<usize>,
    /// Target speed, m/s.
    wanted_speed: Option<f64>,
    /// Terms of the cost; null while braking and for a planner that is a process.
    cost: Option<BTreeMap<&'static str, f64>>,
    /// latest contact or braking; null for a normal cycle.
    emergency: Option<&'static str>,
    /// Traffic rule that asks for a stop ahead; null without one.
    hold: Option<HoldRecord>,
    /// Duration of the cycle, milliseconds.
    ms: f64,
    /// The chosen states.
    states: Vec<StateRecord>,
}

impl Output for CycleRecord {
    const NAME: &'static str = "plan-log";
    const TITLE: &'static str = "`plan --log`: one planning cycle a line";
}

/// A rule that asks for a stop.
#[derive(Debug, Serialize, JsonSchema)]
struct HoldRecord {
    rule: &'static str,
    /// Metres to the place.
    distance: f64,
}

/// Of the vehicle's centre, as in the table of the ego.
#[derive(Debug, Serialize, JsonSchema)]
struct StateRecord {
    x: f64,
    y: f64,
    orientation: f64,
    velocity: f64,
    acceleration: f64,
    /// Of the rear axle's way, 1/m.
    curvature: f64,
}

/// What a planner's process wrote to standard error.
#[derive(Debug, Serialize, JsonSchema)]
pub struct StandardErrorRecord {
    /// Name of the scenario.
    scenario: String,
    /// Id of the planning problem.
    planning_problem: i64,
    /// The planner as it was named.
    planner: String,
    /// Its last lines.
    stderr: Vec<String>,
}

impl Output for StandardErrorRecord {
    const NAME: &'static str = "plan-log-stderr";
    const TITLE: &'static str = "`plan --planner --log`: standard error of a planner's process, after the cycles of its drive";
}

impl DriveRecord {
    /// Of a drive.
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
            planner: output::visible(driven.planner()),
            outcome: driven.outcome().name().into(),
            collision_with: collision.map(|c| c.with),
            collision_step: collision.map(|c| c.step),
            collision_kind: collision.map(|c| c.kind().name().into()),
            ego_side: collision.map(|c| c.ego.name().into()),
            other_side: collision.map(|c| c.other.name().into()),
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
            external_planner: { driven.drive.external.as_ref() }
                .map(|report| ExternalDriveRecord::new(driven, report)),
            monitor: driven.monitor.as_ref().map(MonitorRecord::from),
        }
    }

    /// A planner's process and what it was told; nothing where it never got ready.
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
        Some(output::visible(&words))
    }
}

impl ExternalDriveRecord {
    fn new(driven: &DrivenScenario, report: &ExternalReport) -> Self {
        let beyond = driven.drive.beyond_vehicle();
        Self {
            name: output::visible(&report.name),
            version: output::visible(&report.version),
            clock: report.clock.name().into(),
            predictions: { report.predictions }.then(|| driven.settings.forecast.name().into()),
            history: report.history,
            error: report.fault.map(|fault| fault.name().into()),
            error_step: match driven.outcome() {
                Outcome::PlannerError(error) => Some(error.step),
                _ => None,
            },
            message: report.message.as_deref().map(output::visible),
            stderr: last_lines(&report.stderr),
            start_seconds: report
                .started_in
                .map(|took| thousandths(took.as_secs_f64())),
            median_overhead_ms: driven.overhead().map(thousandths),
            late_steps: report.late_steps,
            largest_offset: thousandths(report.largest_offset),
            undrivable: beyond.map_or(0, |beyond| beyond.steps),
            first_undrivable_step: beyond.map(|beyond| beyond.first.step),
            first_undrivable: beyond.map(|beyond| beyond.first.bound.name().into()),
            worst_undrivable: beyond.map(|BeyondVehicle { worst, .. }| UndrivableRecord {
                step: worst.step,
                bound: worst.bound.name().into(),
                value: thousandths(worst.value),
                limit: thousandths(worst.most),
                unit: worst.bound.unit().into(),
            }),
        }
    }

    /// What of a drive the vehicle cannot do; nothing where it can do all.
    pub fn beyond_vehicle(&self) -> Option<String> {
        let (first, worst) = (self.first_undrivable_step?, self.worst_undrivable.as_ref()?);
        Some(format!(
            "{} beyond the vehicle, first: step {first}, worst: {} {:.2} {} at step {}, at most {:.2}",
            output::counted(self.undrivable, "step"),
            worst.bound,
            worst.value,
            worst.unit,
            worst.step,
            worst.limit
        ))
    }
}

/// The last lines of standard error, as they may be shown.
fn last_lines(stderr: &[String]) -> Vec<String> {
    let last = stderr.len().saturating_sub(STDERR_LINES);
    let lines = stderr[last..].iter();
    let short = |line: &String| line.chars().take(STDERR_COLUMNS).collect::<String>();
    lines.map(|line| output::visible(&short(line))).collect()
}

/// Lines of standard error in a document.
const STDERR_LINES: usize = 20;

/// Characters of such a line; the log has all.
const STDERR_COLUMNS: usize = 500;

impl StandardErrorRecord {
    /// Of a planner's process; nothing where it wrote nothing.
    pub fn new(driven: &DrivenScenario) -> Option<Self> {
        let report = driven.drive.external.as_ref()?;
        let lines = report.stderr.iter().map(|line| output::visible(line));
        (!report.stderr.is_empty()).then(|| Self {
            scenario: driven.name.clone(),
            planning_problem: driven.problem,
            planner: output::visible(driven.planner()),
            stderr: lines.collect(),
        })
    }
}

impl NotDrivenRecord {
    /// Of a scenario with its error.
    pub fn new(entry: &Entry, error: &PlanError) -> Self {
        Self {
            outcome: None,
            scenario: output::visible(&entry.name),
            file: entry.display(),
            error: output::visible(&error.to_string()),
            external_planner: match error {
                PlanError::PlannerFailed(failure) => Some(PlannerFailure::new(
                    failure.fault,
                    failure.step,
                    &failure.stderr,
                )),
                _ => None,
            },
        }
    }
}

impl PlannerFailure {
    /// The fault, the time step, and the last lines of standard error.
    pub fn new(fault: PlannerFault, step: Option<i64>, stderr: &[String]) -> Self {
        Self {
            error: fault.name().into(),
            error_step: step,
            stderr: last_lines(stderr),
        }
    }
}

impl CycleRecord {
    /// Of a cycle of a drive.
    pub fn new(driven: &DrivenScenario, cycle: &Cycle) -> Self {
        let plan = &cycle.plan;
        // A planner's process does not tell how it finds its trajectory; braking is not weighed.
        let ours = driven.drive.external.is_none();
        let weighed = ours && plan.emergency != Some(Emergency::Braking);
        let states = plan.states.iter();
        Self {
            scenario: driven.name.clone(),
            planning_problem: driven.problem,
            step: cycle.step,
            candidates: ours.then_some(plan.candidates),
            feasible: ours.then_some(plan.feasible),
            rejected: ours.then(|| plan.rejected.iter().map(|(why, n)| (*why, *n)).collect()),
            refinements: ours.then_some(plan.refinements),
            wanted_speed: ours.then_some(plan.wanted),
            cost: weighed.then(|| plan.cost.terms().into_iter().collect()),
            emergency: plan.emergency.map(|what| match what {
                Emergency::LatestContact => "latest contact",
                Emergency::Braking => "braking",
            }),
            hold: plan.hold.map(|hold| HoldRecord {
                rule: hold.rule.name(),
                distance: thousandths(hold.distance),
            }),
            ms: thousandths(cycle.took.as_secs_f64() * 1e3),
            states: states
                .map(|state| StateRecord::new(driven, state))
                .collect(),
        }
    }
}

impl StateRecord {
    fn new(driven: &DrivenScenario, state: &VehicleState) -> Self {
        let motion = state.centre(&driven.drive.limits);
        Self {
            x: motion.pose.position.x,
            y: motion.pose.position.y,
            orientation: motion.pose.heading,
            velocity: motion.velocity,
            acceleration: motion.acceleration,
            curvature: state.curvature,
        }
    }
}

/// Microseconds are enough.
pub fn thousandths(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}
