//! Planning problems.

use super::messages::{self, GoalState};
use super::report::FieldPath;
use super::states::state;
use super::values::ids;
use super::words::TAGS;
use crate::commonroad::ReadError;
use nearmiss_scene::scenario::{Goal, PlanningProblem, Position, StateField};

pub(super) fn problem(
    at: &FieldPath<'_>,
    message: &messages::PlanningProblem,
) -> Result<PlanningProblem, ReadError> {
    let id = at.need("planning_problem_id", message.planning_problem_id)?;
    let initial = at.need("initial_state", message.initial_state.as_deref())?;
    let initial = state(&at.field("initial_state"), initial)?;
    let goals = message
        .goal_states
        .iter()
        .enumerate()
        .map(|(i, message)| goal(&at.nth("goal_states", i), message))
        .collect::<Result<_, _>>()?;
    if message.ego_id.is_some() {
        at.no_place_for("ego_id");
    }
    Ok(PlanningProblem {
        id: id.into(),
        initial,
        goals,
    })
}

/// A goal. Where it names lanelets, a shape in its state is their area, worked out by the writer: the names count.
fn goal(at: &FieldPath<'_>, message: &GoalState) -> Result<Goal, ReadError> {
    let bytes = at.need("state", message.state.as_deref())?;
    let lanelets = ids(&message.goal_position_lanelets);
    let at = at.field("state");
    let state = state(&at, bytes)?;
    let positions = if lanelets.is_empty() {
        state.position.into_iter().collect()
    } else {
        vec![Position::Lanelets(lanelets)]
    };
    let acceleration = state.acceleration.map(|_| StateField::Acceleration);
    let rest = state.more.iter().map(|(field, _)| *field);
    for field in acceleration.into_iter().chain(rest) {
        at.no_place_for(field.name());
    }
    Ok(Goal {
        time: state.time,
        positions,
        orientation: state.orientation,
        velocity: state.velocity,
    })
}

/// The tags of a scenario.
pub(super) fn tags(at: &FieldPath<'_>, message: &messages::ScenarioTags) -> Vec<String> {
    let numbered = message.tags.iter().enumerate();
    let words = numbered.filter_map(|(i, number)| at.nth("tags", i).word(TAGS, *number));
    words.map(str::to_string).collect()
}
