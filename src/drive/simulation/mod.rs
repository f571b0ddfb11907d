//! The closed loop: a planner drives the ego through the recorded traffic, or through traffic that reacts.
//!
//! The planner is the built-in one, or a process that reads JSON from a pipe, see `external`; both drive in the same
//! loop.

mod closed_loop;
mod collision;
mod external;
mod policy;
mod rollout;
mod traffic;

pub use closed_loop::{Control, DriveSpan, Driver, MOST_DRIVEN, MotionFault};
pub use collision::{Collision, EndOfDriveCheck};
pub use external::{
    Answering, Clock, ExternalOptions, ExternalPlanner, ExternalReport, OLDEST_PROTOCOL, PROTOCOL,
    PlannerError, PlannerFault, PlannerFunction, ReferencePoint, planner_message_names,
    planner_message_schema,
};
pub use nearmiss_scene::metrics::ContactSide;
pub use policy::Policy;
pub use rollout::{
    BeyondVehicle, CollisionKind, Cycle, DriveError, Outcome, ResumableRollout, Rollout, Settings,
};
pub use traffic::{DrivenTraffic, HitFromBehind, Reaction, TrafficMode};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
