//! Submits a batch's questions to their providers' batch APIs at half the price, instead of asking one by one.

use std::collections::BTreeMap;
use std::path::PathBuf;

use nearmiss_base::system;
use nearmiss_store::{BatchId, Item, SplitPart, StoreError};
use nearmiss_study::evaluation::batch::{SpecError, TruthError};
use nearmiss_study::evaluation::remote::{RemoteError, SubmissionOutcome, submit};
use nearmiss_study::evaluation::{AxisValues, Judge, LabelError, Lead, Question, RunOptions};
use rayon::prelude::*;

use super::BatchRun;

/// Outcome of submitting a batch's questions.
#[derive(Debug, Default)]
pub struct SubmittedItems {
    /// By model.
    pub submitted: Vec<(String, SubmissionOutcome)>,
    /// Questions that no provider takes: those to the built-in judge or for recorded answers.
    pub own: Vec<Item>,
    /// Questions that cannot be made, with why.
    pub unaskable: Vec<(Item, String)>,
    /// Models whose questions did not all reach their provider, and why.
    pub broken: Vec<(String, RemoteError)>,
}

impl BatchRun {
    /// Whether a model is asked with tools under these values of axes.
    fn calls_tools(&self, model: &str, settings: &AxisValues) -> bool {
        let judge = self.judges.get(model).map(|judge| judge.under(settings));
        match judge.as_deref() {
            Some(Judge::Model(judge)) => judge.parameters.tools.is_some(),
            _ => false,
        }
    }

    /// Submits these questions to the providers of their models, in batches as large as those take.
    ///
    /// # Errors
    /// The store cannot be read or written.
    pub async fn submit(&self, items: Vec<Item>) -> Result<SubmittedItems, StoreError> {
        let mut done = SubmittedItems::default();
        let mut by_model: BTreeMap<(&str, AxisValues), Vec<(Question, RunOptions)>> =
            BTreeMap::new();
        let (own, asked): (Vec<Item>, Vec<Item>) = items
            .into_iter()
            .partition(|item| !matches!(self.judges.get(&item.asked.model), Some(Judge::Model(_))));
        done.own = own;
        let made: Vec<_> = asked
            .par_iter()
            .map(|item| self.builder.question_of_item(&item.asked))
            .collect();
        for (item, made) in asked.iter().zip(made) {
            match made.map(|(configuration, question)| (configuration.settings, question)) {
                Ok((settings, _)) if self.calls_tools(&item.asked.model, &settings) => {
                    let why = "tools need several requests; ask without --submit";
                    done.unaskable.push((item.clone(), why.into()));
                }
                Ok((settings, question)) => {
                    let questions = by_model.entry((&item.asked.model, settings)).or_default();
                    questions.push((Question::clone(&question), self.options(item)));
                }
                Err(why) => done.unaskable.push((item.clone(), why)),
            }
        }
        for ((model, settings), questions) in by_model {
            let judge = self.judges.get(model).map(|judge| judge.under(&settings));
            let Some(Judge::Model(judge)) = judge.as_deref() else {
                continue;
            };
            match submit(&questions, judge, &self.store).await {
                Ok(submitted) => done.submitted.push((model.to_string(), submitted)),
                Err(RemoteError::Store(error)) => return Err(error),
                Err(error) => done.broken.push((model.to_string(), error)),
            }
        }
        Ok(done)
    }

    /// Takes out the questions whose keys are with a provider: their answers are collected, and asking would wait for
    /// them. Says how many they were.
    ///
    /// # Errors
    /// The store cannot be read.
    pub(super) fn without_submitted(
        &self,
        items: Vec<Item>,
    ) -> Result<(Vec<Item>, usize), StoreError> {
        if !self.store.any_handed()? {
            return Ok((items, 0));
        }
        let all = items.len();
        let mut left = Vec::with_capacity(all);
        for item in items {
            let handed = match &item.asked.key {
                Some(key) => self.store.is_handed(key, item.asked.sample)?,
                None => false,
            };
            if !handed {
                left.push(item);
            }
        }
        let gone = all - left.len();
        Ok((left, gone))
    }
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
