//! Planning problems.

use super::messages::{self, GoalState};
use super::report::{At, Report};
use super::states::state;
use super::values::ids;
use crate::scenario::commonroad::ReadError;
use crate::scenario::{Goal, PlanningProblem, Position, Severity};

pub(super) fn problem(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::PlanningProblem,
) -> Result<PlanningProblem, ReadError> {
    let id = report.need(at, "planning_problem_id", message.planning_problem_id)?;
    let initial = report.need(at, "initial_state", message.initial_state.as_ref())?;
    let initial = state(report, &at.field("initial_state"), initial)?;
    let mut goals = Vec::with_capacity(message.goal_states.len());
    for (i, message) in message.goal_states.iter().enumerate() {
        goals.push(goal(report, &at.nth("goal_states", i), message)?);
    }
    if goals.is_empty() {
        report.warn(at, "no goal");
    }
    if let Some(ego) = message.ego_id {
        let message = format!("`ego_id` {ego} has no place here and was left out");
        report.note(Severity::Note, at, message);
    }
    Ok(PlanningProblem {
        id: id.into(),
        initial,
        goals,
    })
}

/// A goal. Where it names lanelets, a shape in its state is their area, worked out by the writer: the names count.
fn goal(report: &mut Report, at: &At<'_>, message: &GoalState) -> Result<Goal, ReadError> {
    let inner = report.need(at, "state", message.state.as_ref())?;
    let lanelets = ids(&message.goal_position_lanelets);
    let at = at.field("state");
    let state = state(report, &at, inner)?;
    let positions = if lanelets.is_empty() {
        state.position.into_iter().collect()
    } else {
        vec![Position::Lanelets(lanelets)]
    };
    let rest = state.acceleration.map(|_| "acceleration").into_iter();
    for name in rest.chain(state.more.iter().map(|(field, _)| field.name())) {
        let message = format!("`{name}` of a goal has no place here and was left out");
        report.note(Severity::Note, &at, message);
    }
    Ok(Goal {
        time: state.time,
        positions,
        orientation: state.orientation,
        velocity: state.velocity,
    })
}
