//! A planner drive as JSON: its outcome, and every cycle.

use serde_json::{Map, Value, json};

use super::driven::DrivenScenario;
use super::{monitor, rules};
use crate::output;
use crate::row_file::short_hash;
use nearmiss_drive::planner::{Emergency, VehicleState};
use nearmiss_drive::simulation::{
    BeyondVehicle, ContactSide, Cycle, ExternalReport, HitFromBehind, Outcome, PlannerFault,
};
use nearmiss_formats::Entry;
use nearmiss_workflow::PlanError;

/// How a drive ended and what it took, on one line.
pub fn document(driven: &DrivenScenario) -> Value {
    let collision = driven.collision();
    let ms = driven.milliseconds();
    let goal = match driven.outcome() {
        Outcome::Goal(place) => Some(place),
        _ => None,
    };
    let braking = driven.emergencies().filter(|e| *e == Emergency::Braking);
    let states = &driven.drive.states;
    let reactions = &driven.drive.traffic.reactions;
    let recorded = driven.recorded_rules.as_ref();
    let mut value = json!({
        "outcome": driven.outcome().name(),
        "collision_with": collision.map(|c| c.with),
        "steps": driven.steps(),
        "cycles": driven.drive.cycles.len(),
        "median_cycle_ms": ms.map(|(median, _)| thousandths(median)),
        "longest_cycle_ms": ms.map(|(_, longest)| thousandths(longest)),
        "emergency_cycles": driven.emergencies().count(),
        "braking_cycles": braking.count(),
        "refined_cycles": driven.refined(),
        "scenario": driven.name,
        "file": driven.file,
        "hash": short_hash(&driven.scenario.hash),
        "planning_problem": driven.problem,
        "prediction": driven.settings.forecast.name(),
        "vehicle": driven.settings.planner.vehicle.number(),
        "horizon": driven.settings.planner.horizon,
        "replan": driven.settings.replan,
        "first_step": states.first().map(|(step, _)| step),
        "last_step": states.last().map(|(step, _)| step),
        "goal": goal,
        "collision_step": collision.map(|c| c.step),
        "ego_side": collision.map(|c| ContactSide::name(c.ego)),
        "other_side": collision.map(|c| ContactSide::name(c.other)),
        "hit_from_behind": driven.drive.hit_from_behind().map(HitFromBehind::name),
        "traffic": driven.settings.traffic.name(),
        "reacted": reactions.len(),
        "first_reaction_step": reactions.first().map(|reaction| reaction.from),
        "reactions": reactions
            .iter()
            .map(|reaction| json!({"obstacle": reaction.obstacle, "step": reaction.from}))
            .collect::<Vec<_>>(),
        "largest_deceleration": thousandths(driven.drive.largest_deceleration()),
        "mean_jerk": driven.drive.jerk().map(|(mean, _)| thousandths(mean)),
        "max_jerk": driven.drive.jerk().map(|(_, most)| thousandths(most)),
        "seconds_to_goal": driven.drive.seconds_to_goal().map(thousandths),
        "collision_kind": collision.map(|c| c.kind().name()),
        "near_misses": driven.near_misses,
        "rule_mode": driven.settings.planner.rules.name(),
        "rules": rules::document(&driven.rules, driven.scenario.dt()),
        "rules_broken": rules::names(driven.rules.broken()),
        "recorded_rules": recorded.map(|report| rules::document(report, driven.scenario.dt())),
        "recorded_rules_broken": recorded.map(|report| rules::names(report.broken())),
        "planner": output::visible(driven.planner()),
        "note": driven.note(),
    });
    if let Some(report) = &driven.drive.external {
        value["external_planner"] = external(driven, report);
    }
    if let Some(report) = &driven.monitor {
        value["monitor"] = monitor::document(report);
    }
    value
}

/// What is known of a planner's process.
fn external(driven: &DrivenScenario, report: &ExternalReport) -> Value {
    let beyond = driven.drive.beyond_vehicle();
    json!({
        "name": output::visible(&report.name),
        "version": output::visible(&report.version),
        "clock": report.clock.name(),
        "predictions": report.predictions.then_some(driven.settings.forecast.name()),
        "history": report.history,
        "error": report.fault.map(|fault| fault.name()),
        "error_step": match driven.outcome() {
            Outcome::PlannerError(error) => Some(error.step),
            _ => None,
        },
        "message": report.message.as_deref().map(output::visible),
        "stderr": last_lines(&report.stderr),
        "start_seconds": report.started_in.map(|took| thousandths(took.as_secs_f64())),
        "median_overhead_ms": driven.overhead().map(thousandths),
        "late_steps": report.late_steps,
        "largest_offset": thousandths(report.largest_offset),
        "undrivable": beyond.map_or(0, |beyond| beyond.steps),
        "first_undrivable_step": beyond.map(|beyond| beyond.first.step),
        "first_undrivable": beyond.map(|beyond| beyond.first.bound.name()),
        "worst_undrivable": beyond.map(|BeyondVehicle { worst, .. }| json!({
            "step": worst.step,
            "bound": worst.bound.name(),
            "value": thousandths(worst.value),
            "limit": thousandths(worst.most),
            "unit": worst.bound.unit(),
        })),
    })
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

/// What a planner's process wrote to standard error, on one line; nothing where it wrote nothing.
pub fn standard_error(driven: &DrivenScenario) -> Option<Value> {
    let report = driven.drive.external.as_ref()?;
    let lines = report.stderr.iter().map(|line| output::visible(line));
    (!report.stderr.is_empty()).then(|| {
        json!({
            "scenario": driven.name,
            "planning_problem": driven.problem,
            "planner": output::visible(driven.planner()),
            "stderr": lines.collect::<Vec<_>>(),
        })
    })
}

/// A scenario that was not driven, and why, on one line.
pub fn missing(entry: &Entry, error: &PlanError) -> Value {
    let mut value = json!({
        "outcome": null,
        "scenario": output::visible(&entry.name),
        "file": entry.display(),
        "error": output::visible(&error.to_string()),
    });
    if let PlanError::PlannerFailed(failure) = error {
        value["external_planner"] = failed(failure.fault, failure.step, &failure.stderr);
    }
    value
}

/// How a planner's process failed: the name of the fault, the time step, and the last lines of standard error.
pub fn failed(fault: PlannerFault, step: Option<i64>, stderr: &[String]) -> Value {
    json!({
        "error": fault.name(),
        "error_step": step,
        "stderr": last_lines(stderr),
    })
}

/// One planning cycle.
pub fn cycle(driven: &DrivenScenario, cycle: &Cycle) -> Value {
    let plan = &cycle.plan;
    let object = |pairs: &mut dyn Iterator<Item = (&str, Value)>| -> Value {
        let pairs = pairs.map(|(name, value)| (name.to_string(), value));
        Value::Object(pairs.collect::<Map<_, _>>())
    };
    let rejected = &mut plan.rejected.iter().map(|(why, n)| (*why, json!(n)));
    // A planner's process does not tell how it finds its trajectory; braking is not weighed.
    let ours = driven.drive.external.is_none();
    let cost = ours && plan.emergency != Some(Emergency::Braking);
    let terms = plan.cost.terms();
    json!({
        "scenario": driven.name,
        "planning_problem": driven.problem,
        "step": cycle.step,
        "candidates": ours.then_some(plan.candidates),
        "feasible": ours.then_some(plan.feasible),
        "rejected": ours.then(|| object(rejected)),
        "refinements": ours.then_some(plan.refinements),
        "wanted_speed": ours.then_some(plan.wanted),
        "cost": cost.then(|| object(&mut terms.iter().map(|(name, x)| (*name, json!(x))))),
        "emergency": plan.emergency.map(|what| match what {
            Emergency::LatestContact => "latest contact",
            Emergency::Braking => "braking",
        }),
        "hold": plan.hold.map(|hold| json!({
            "rule": hold.rule.name(),
            "distance": thousandths(hold.distance),
        })),
        "ms": thousandths(cycle.took.as_secs_f64() * 1e3),
        "states": plan.states.iter().map(|s| state(driven, s)).collect::<Vec<_>>(),
    })
}

/// Of the vehicle's centre, as in the table of the ego; and the curvature of the rear axle's way, 1/m.
fn state(driven: &DrivenScenario, state: &VehicleState) -> Value {
    let motion = state.centre(&driven.drive.limits);
    let at = motion.pose.position;
    json!({
        "x": at.x,
        "y": at.y,
        "orientation": motion.pose.heading,
        "velocity": motion.velocity,
        "acceleration": motion.acceleration,
        "curvature": state.curvature,
    })
}

/// Microseconds are enough.
pub fn thousandths(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}
