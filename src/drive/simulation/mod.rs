//! The closed loop: a planner drives the ego through the recorded traffic, or through traffic that reacts.
//!
//! The planner is the built-in one, or a process that reads JSON from a pipe, see `external`; both drive in the same
//! loop.

mod closed_loop;
mod collision;
mod drives;
mod external;
mod figures;
mod rollout;
mod traffic;

pub use closed_loop::{DriveSpan, Driver, MOST_DRIVEN};
pub use collision::{Collision, ContactSide, EndOfDriveCheck};
pub use drives::{Control, MotionFault};
pub use external::{
    Clock, ExternalOptions, ExternalPlanner, ExternalReport, OLDEST_PROTOCOL, PROTOCOL,
    PlannerError, PlannerFault, ReferencePoint, planner_message_names, planner_message_schema,
};
pub use figures::{BeyondVehicle, CollisionKind};
pub use rollout::{Cycle, DriveError, Outcome, ResumableRollout, Rollout, Settings};
pub use traffic::{DrivenTraffic, HitFromBehind, Reaction, TrafficMode};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
