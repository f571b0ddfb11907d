//! Submits a batch's questions to their providers' batch APIs at half the price, instead of asking one by one.

use std::collections::BTreeMap;

use nearmiss_store::{Item, StoreError};
use nearmiss_study::evaluation::remote::{RemoteError, SubmissionOutcome, submit};
use nearmiss_study::evaluation::{AxisValues, Judge, Question, RunOptions};
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
