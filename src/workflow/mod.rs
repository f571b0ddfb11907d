//! What the program does, once for the command line and the workbench: a request, events on the way, an outcome.
//!
//! - [`open`]: a scenario with its ego, after a change of its scene if one is asked for
//! - [`prepare`]: the planner drives the ego of a planning problem
//! - [`generate`]: one obstacle's motion is changed until it endangers the planned ego
//!
//! Each runs on the thread that calls it and calls `on_event` there. It ends early when its
//! [`Cancel`](crate::planner::Cancel) asks for it, also inside a planning cycle, and then has no outcome.

mod generate;
mod open;
mod plan;

pub use generate::{
    AttackSource, AttackWriter, GenerateEvent, GenerateRequest, Generation, ModelWriter, generate,
};
pub use open::{MissingEgo, OpenError, OpenRequest, OpenedScene, open};
pub use plan::{PlanError, PlanEvent, PlanOutcome, PlanRequest, PreparedPlan, prepare};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
