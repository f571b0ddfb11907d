//! What the program does, once for the command line and the workbench: a request, events on the way, an outcome.
//!
//! - [`open`]: a scenario with its ego, after a change of its scene if one is asked for
//! - [`ask`]: one question to a model, its answer stored before it is shown
//! - [`batch`]: many questions, stored before they are asked, and gone on with at will
//! - [`prepare`]: the planner drives the ego of a planning problem
//! - [`generate`]: one obstacle's motion is changed until it endangers the planned ego
//!
//! What computes runs on the thread that calls it and calls `on_event` there. It ends early when its
//! [`Cancel`](crate::planner::Cancel) asks for it, also inside a planning cycle, and then has no outcome. What waits for a
//! server is a future: dropping it cancels the request.

mod ask;
pub mod batch;
mod generate;
mod open;
mod plan;

pub use ask::{AskOutcome, AskRequest, Models, Server, ask};
pub use generate::{
    AttackSource, AttackWriter, GenerateEvent, GenerateRequest, Generation, ModelWriter, generate,
};
pub use open::{MissingEgo, OpenError, OpenRequest, OpenedScene, open};
pub use plan::{PlanError, PlanEvent, PlanOutcome, PlanRequest, PreparedPlan, prepare};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
