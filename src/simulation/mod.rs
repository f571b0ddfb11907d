//! The closed loop: the planner drives the ego through the recorded traffic, which does not react to it.

mod closed_loop;
mod collision;
mod ego;
mod outcome;
mod rollout;
mod solution;

pub use closed_loop::{DriveSpan, Driver, Look, MOST_DRIVEN, ResumableRollout};
pub use collision::{Collision, ContactSide};
pub use outcome::Outcome;
pub use rollout::{Cycle, DriveError, Rollout, Settings};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
