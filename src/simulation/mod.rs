//! The closed loop: the planner drives the ego through the recorded traffic, which does not react to it.

mod closed_loop;
mod collision;
mod control;
mod ego;
mod look;
mod outcome;
mod rollout;
mod solution;

pub use closed_loop::{DriveSpan, Driver, MOST_DRIVEN, ResumableRollout};
pub use collision::{Collision, ContactSide};
pub use control::Control;
pub use look::Look;
pub use outcome::Outcome;
pub use rollout::{Cycle, DriveError, Rollout, Settings};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
