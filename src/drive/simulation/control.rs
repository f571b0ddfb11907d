//! What overrules the planner.

/// What the ego does in the next step of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// It follows the planner.
    Follow,
    /// It brakes fully along its path: see [`Planner::full_braking`](crate::planner::Planner::full_braking).
    Brake,
    /// The drive ends here, and is to be dropped.
    Stop,
}
