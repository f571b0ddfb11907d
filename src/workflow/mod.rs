//! What the program does, shared by command line and workbench: a request, events on the way, an outcome.
//!
//! - [`open`]: a scenario with its ego, optionally with a changed scene
//! - [`ask`]: one question to a model, its answer stored before it is shown
//! - [`batch`]: many questions, stored before they are asked, and resumable
//! - [`compare_versions`]: the stored answers to two versions of a prompt, scenario by scenario
//! - [`prepare`]: the planner drives the ego of a planning problem
//! - [`generate`]: changes one obstacle's motion until it endangers the planned ego
//! - [`TruthSearch`]: what is true about stored answers
//!
//! Computations run on the calling thread and call `on_event` there. They end early when their
//! [`Cancel`](crate::planner::Cancel) is set, even inside a planning cycle, and then have no outcome. Work that waits
//! for a server is a future: dropping it cancels the request.

mod ask;
pub mod batch;
mod generate;
mod open;
mod plan;
mod truth;
mod versions;

pub use ask::{AskOutcome, AskRequest, Models, Server, ask};
pub use generate::{
    AttackSource, AttackWriter, GenerateEvent, GenerateRequest, Generation, ModelWriter, generate,
};
pub use open::{MissingEgo, OpenError, OpenRequest, OpenedScene, open};
pub use plan::{PlanError, PlanEvent, PlanOutcome, PlanRequest, PreparedPlan, prepare};
pub use truth::{StoredQuestion, TruthChoice, TruthSearch, batch_labels};

pub use versions::{
    ComparedAnswers, SideTotals, VersionChange, VersionComparison, VersionSource, VersionTotals,
    compare_versions,
};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
