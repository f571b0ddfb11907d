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
pub use submit::SubmittedItems;

use std::path::PathBuf;

use nearmiss_base::system;
use nearmiss_store::{BatchId, SplitPart, StoreError};
use nearmiss_study::evaluation::batch::{SpecError, TruthError};
use nearmiss_study::evaluation::{LabelError, Lead};
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

/// Why a batch cannot be started or resumed.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// A relative path cannot be resolved.
    #[error("{}: {}", path.display(), system::error_text(source))]
    Path {
        /// The path.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// What is true cannot be read.
    #[error(transparent)]
    Truth(#[from] TruthError),
    /// A label cannot be of its scenario.
    #[error("--truth: {0}")]
    Label(#[from] LabelError),
    /// The labels of another truth fit no scenario of the batch.
    #[error("--truth: has no label for any scenario of {0}; its truth is unchanged")]
    NoLabel(BatchId),
    /// No scenario of a new batch has a label.
    #[error("no label for any of {scenarios} scenario{}; ground truth: {truth}", if *.scenarios == 1 { "" } else { "s" })]
    Unlabelled {
        /// How many scenarios there are.
        scenarios: usize,
        /// Where the truth is from.
        truth: String,
    },
    /// A part of a split is to be asked, and there is no split.
    #[error(
        "--split: the scenarios have no split; add `split = {{ test = 0.5 }}` to the experiment file, or use --set split.test=0.5"
    )]
    NoSplit,
    /// The specification cannot be used.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The specification of a stored batch cannot be used any more.
    #[error("{batch}: {error}")]
    Stored {
        /// The batch.
        batch: BatchId,
        /// Why.
        error: SpecError,
    },
    /// There would be more ways of asking than a batch has.
    #[error("{0}")]
    TooLarge(String),
    /// A stored question holds a word that this version does not know.
    #[error("{0}")]
    Question(String),
    /// A draft is for another task or frame than is asked.
    #[error("{0}: the draft is for another task or frame than the batch")]
    Draft(String),
    /// Samples cannot be taken away from a batch.
    #[error("samples {wanted}: {batch} already has {has}, and samples cannot be removed")]
    FewerSamples {
        /// The samples asked for.
        wanted: u32,
        /// The batch.
        batch: BatchId,
        /// The samples it has.
        has: u32,
    },
    /// One part of a split has no scenario.
    #[error("split: no scenario is in the {} part; change its seed or its share", .0.name())]
    EmptyPart(SplitPart),
    /// Leads without the safety task.
    #[error(
        "leads: windows of the collision task have no lead; several leads are for the safety task"
    )]
    Leads,
    /// Leads of a batch that asks about the paper's windows.
    #[error("leads: the batch asks about the windows of the paper, which have no leads")]
    PaperWindows,
    /// A lead at which a contact is later than the truth of a window looks.
    #[error(
        "leads: {lead}: the contact is later than within = {within} s after the window, which makes the window safe; use \
         a shorter lead, or a new batch with a longer `within`"
    )]
    Beyond {
        /// The lead.
        lead: Lead,
        /// How far the truth looks, seconds.
        within: f64,
    },
    /// Settings that a batch keeps as they were when it was begun.
    #[error(
        "{batch} keeps what it was begun with, so that {} cannot be changed; models, techniques, leads, transforms and \
         samples can be added, for all else start a new batch",
        keys.join(", ")
    )]
    Kept {
        /// The batch.
        batch: BatchId,
        /// Their keys.
        keys: Vec<&'static str>,
    },
    /// The store has no such batch.
    #[error("no batch {0}; `nearmiss evaluate list` lists all")]
    NoBatch(BatchId),
    /// The store has no batch at all.
    #[error("no batch yet; `nearmiss evaluate list` lists all")]
    NoBatchYet,
    /// The store cannot be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
