//! The closed loop: the planner drives the ego through the recorded traffic, which does not react to it.

mod collision;
mod driver;
mod ego;
mod outcome;
mod rollout;
mod solution;

pub use collision::{Collision, ContactSide};
pub use driver::{DriveSpan, Driver, Look, MOST_DRIVEN, ResumableRollout};
pub use outcome::Outcome;
pub use rollout::{Cycle, DriveError, Rollout, Settings, drive};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
