//! A batch: scenarios × tasks × frames × techniques × samples × models, in the store before anything is sent.
//!
//! [`BatchRequest::plan`] begins one and [`ResumeRequest::plan`] goes on with one. Of either plan, [`BatchPlan::dry_run`]
//! makes the questions, [`BatchPlan::write`] stores them and [`BatchRun::ask`] asks them.

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
pub use paused::Paused;
pub use plan::{BatchPlan, BatchRequest};
pub use resume::{Relabelling, ResumeRequest};
pub use run::{BatchRun, Ended, Selection, at_once};
pub use submit::SubmittedItems;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
