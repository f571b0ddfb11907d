//! How a drive ends.

use super::{Collision, PlannerError};

/// Outcome of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// The goal with this place among the problem's was reached.
    Goal(usize),
    /// The ego's body touched an obstacle's.
    Collision(Collision),
    /// The last step at which a goal could be reached went by.
    Timeout,
    /// The ego's body left the road.
    OffRoad,
    /// The vehicle cannot be driven from where it starts.
    Infeasible,
    /// The planner's process failed.
    PlannerError(PlannerError),
}

impl Outcome {
    /// Its name on the command line and in tables.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Goal(_) => "goal",
            Self::Collision(_) => "collision",
            Self::Timeout => "timeout",
            Self::OffRoad => "off_road",
            Self::Infeasible => "infeasible",
            Self::PlannerError(_) => "planner_error",
        }
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Goal(_) => f.write_str("goal reached"),
            Self::Collision(collision) => write!(f, "collision with {collision}"),
            Self::Timeout => f.write_str("goal not reached in time"),
            Self::OffRoad => f.write_str("off the road"),
            Self::Infeasible => f.write_str("no feasible motion"),
            Self::PlannerError(error) => error.fmt(f),
        }
    }
}
