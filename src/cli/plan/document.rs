//! A planner drive for programs: its outcome, and every cycle.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use crate::output;
use nearmiss_drive::planner::{Emergency, VehicleState};
use nearmiss_drive::simulation::Cycle;
use nearmiss_formats::Entry;
use nearmiss_workflow::PlanError;
use nearmiss_workflow::drive::{DrivenScenario, PlannerFaultRecord, thousandths};

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
    external_planner: Option<PlannerFaultRecord>,
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
                PlanError::PlannerFailed(failure) => Some(PlannerFaultRecord::new(
                    failure.fault,
                    failure.step,
                    &failure.stderr,
                )),
                _ => None,
            },
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
