//! The closed loop: the planner drives the ego through the recorded traffic, or through traffic that reacts.

mod closed_loop;
mod collision;
mod control;
mod ego;
mod look;
mod outcome;
mod rollout;
mod solution;
mod traffic;

pub use closed_loop::{DriveSpan, Driver, MOST_DRIVEN, ResumableRollout};
pub use collision::{Collision, ContactSide};
pub use control::Control;
pub use look::Look;
pub use outcome::Outcome;
pub use rollout::{Cycle, DriveError, Rollout, Settings};
pub use traffic::{DrivenTraffic, HitFromBehind, Reaction, TrafficMode};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
