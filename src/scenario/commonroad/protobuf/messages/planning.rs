//! 2020a and 2024: planning problems and tags (`planning_problem.proto`, `scenario_tags.proto` of both).

use super::State;

#[derive(Clone, PartialEq, prost::Message)]
pub struct GoalState {
    #[prost(message, optional, tag = "1")]
    pub state: Option<State>,
    #[prost(uint32, repeated, packed = "false", tag = "2")]
    pub goal_position_lanelets: Vec<u32>,
}

/// The ego's id and the tags are of 2024 only.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PlanningProblem {
    #[prost(uint32, optional, tag = "1")]
    pub planning_problem_id: Option<u32>,
    #[prost(message, optional, tag = "2")]
    pub initial_state: Option<State>,
    #[prost(message, repeated, tag = "3")]
    pub goal_states: Vec<GoalState>,
    #[prost(uint32, optional, tag = "4")]
    pub ego_id: Option<u32>,
    #[prost(message, optional, tag = "5")]
    pub scenario_tags: Option<ScenarioTags>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct ScenarioTags {
    #[prost(int32, repeated, packed = "false", tag = "1")]
    pub tags: Vec<i32>,
}
