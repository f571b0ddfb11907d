//! A batch: scenarios × tasks × frames × techniques × samples × models, stored before anything is sent.
//!
//! [`BatchRequest::plan`] starts a batch and [`ResumeRequest::plan`] resumes one. On either plan,
//! [`BatchPlan::dry_run`] builds the questions, [`BatchPlan::write`] stores them and [`BatchRun::ask`] asks them.
//! [`BatchPlan::built_in`] has the built-in judge and simpler predictors answer them at once, and stores nothing.

mod built_in;
mod dry_run;
mod judges;
mod plan;
mod resume;
mod run;
mod submit;

pub use built_in::{BuiltInAnswers, BuiltInEvent};
pub use dry_run::{DryRun, DryRunEvent, DryRunLine, is_enough};
pub use judges::{BatchModels, PausedModel};
pub use plan::{BatchPlan, BatchRequest, PlanningEvent, Selection};
pub use resume::{Relabelling, ResumeRequest};
pub use run::{BatchControl, BatchRun, ProviderSlots, QuestionOutcome, at_once};
pub use submit::{BatchError, SubmittedItems};

use rayon::prelude::*;

/// Items that are worked on at once, for each core: enough to keep all busy, and the memory bounded.
const AT_ONCE: usize = 4;

/// The results of `work` on each item, on all cores, a part of the items at a time.
fn parts<'a, T: Sync, R: Send>(
    items: &'a [T],
    work: impl Fn(&'a T) -> R + Sync,
) -> impl Iterator<Item = Vec<(&'a T, R)>> {
    let parts = items.chunks(AT_ONCE * rayon::current_num_threads());
    parts.map(move |part| part.par_iter().map(|item| (item, work(item))).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
