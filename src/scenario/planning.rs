//! Planning problems: where the ego starts and what counts as having arrived.

use super::{Position, Quantity, State, Steps};

/// What an ego vehicle shall do.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanningProblem {
    /// Unique in the scenario; recorded egos carry it as their id.
    pub id: i64,
    /// Where it starts.
    pub initial: State,
    /// Any one of these is an arrival.
    pub goals: Vec<Goal>,
}

/// One way to arrive: all that is given must hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// When, in time steps.
    pub time: Steps,
    /// Where; several regions are alternatives.
    pub positions: Vec<Position>,
    /// Heading, radians.
    pub orientation: Option<Quantity>,
    /// Speed, m/s.
    pub velocity: Option<Quantity>,
}

impl Goal {
    /// Ids of the lanelets among the goal's positions.
    #[must_use]
    pub fn lanelets(&self) -> Vec<i64> {
        let ids = self.positions.iter().filter_map(|p| match p {
            Position::Lanelets(ids) => Some(ids.as_slice()),
            _ => None,
        });
        ids.flatten().copied().collect()
    }
}
