//! Planning problems as JSON: initial states of the ego, and goals with their regions.

use serde_json::{Value, json};

use super::document::all;
use super::states::initial_state;
use nearmiss_scene::scenario::{Goal, PlanningProblem};

pub fn problem(problem: &PlanningProblem) -> Value {
    json!({
        "id": problem.id,
        "initial": initial_state(&problem.initial),
        "goals": all(&problem.goals, goal),
    })
}

/// `positions` are alternatives; `lanelets` are those among them.
fn goal(goal: &Goal) -> Value {
    let mut value = json!(goal);
    value["lanelets"] = json!(goal.lanelets());
    value
}
