//! A batch: scenarios × tasks × frames × techniques × samples × models, stored before anything is sent.
//!
//! [`BatchRequest::plan`] starts a batch and [`ResumeRequest::plan`] resumes one. On either plan,
//! [`BatchPlan::dry_run`] builds the questions, [`BatchPlan::write`] stores them and [`BatchRun::ask`] asks them.

mod control;
mod dry_run;
mod error;
mod paused;
mod plan;
mod resume;
mod run;
mod submit;

pub use control::{BatchControl, ProviderSlots};
pub use dry_run::{DryRun, DryRunEvent};
pub use error::BatchError;
pub use paused::PausedModel;
pub use plan::{BatchPlan, BatchRequest};
pub use resume::{Relabelling, ResumeRequest};
pub use run::{BatchRun, QuestionOutcome, Selection, at_once};
pub use submit::SubmittedItems;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
