//! A dry run: a batch's questions and their estimated consumption, before anything is sent.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::{BatchError, BatchPlan, parts};
use crate::evaluation::batch::{Ask, Estimate, PreparedQuestions};
use crate::evaluation::{Judges, Question, can_ask};
use crate::formats::Entry;
use crate::planner::Cancel;
use crate::store::{Identity, Item, Key, NewItem, Store};

/// The questions of a batch.
#[derive(Debug, Default)]
pub struct DryRun {
    /// In the order in which they are asked.
    pub items: Vec<NewItem>,
    /// What they take.
    pub estimate: Estimate,
    /// Scenarios that are left out because their truth is unknown.
    pub unlabelled: Vec<String>,
    /// Warnings about the scenarios.
    pub doubts: Vec<String>,
    /// For each model a question that would be sent to it.
    first: BTreeMap<String, Arc<Question>>,
}

/// Events while questions are built.
#[derive(Debug)]
pub enum DryRunEvent<'a> {
    /// The questions about more scenarios are there.
    Described {
        /// Scenarios so far.
        done: usize,
        /// The questions so far.
        dry_run: &'a DryRun,
    },
}

impl BatchPlan {
    /// Makes the questions, on all cores. Nothing where `cancel` asked for an end.
    ///
    /// # Errors
    /// The store cannot be read, or a label cannot be of its scenario.
    pub fn dry_run(
        &self,
        judges: &Judges,
        store: &Store,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(DryRunEvent<'_>),
    ) -> Result<Option<DryRun>, BatchError> {
        let mut dry_run = DryRun::default();
        let mut done = 0;
        let prepare = |(entry, asks): &(Entry, Vec<Ask>)| {
            self.builder
                .prepare(entry, asks, &self.truth, judges, store)
        };
        for part in parts(&self.scenarios, prepare) {
            done += part.len();
            for ((entry, _), prepared) in part {
                dry_run.add(&entry.name, prepared?)?;
            }
            if cancel.is_asked() {
                return Ok(None);
            }
            on_event(DryRunEvent::Described {
                done,
                dry_run: &dry_run,
            });
        }
        Ok(Some(dry_run))
    }
}

impl DryRun {
    fn add(&mut self, scenario: &str, prepared: PreparedQuestions) -> Result<(), BatchError> {
        if let Some(wrong) = prepared.wrong {
            return Err(wrong.into());
        }
        if prepared.unlabelled {
            self.unlabelled.push(scenario.to_string());
        }
        let doubts = prepared.doubts.iter();
        self.doubts
            .extend(doubts.map(|doubt| format!("{scenario}: {doubt}")));
        for (model, question) in prepared.first {
            self.first.entry(model).or_insert(question);
        }
        for (item, size) in prepared.items {
            self.estimate.add(size, item.unaskable.as_deref());
            self.items.push(item);
        }
        Ok(())
    }

    /// The models that cannot be asked as things stand, and why. Nothing is sent; a command that prints a key is run.
    pub async fn refused(&self, judges: &Judges) -> Vec<(String, String)> {
        let mut refused = Vec::new();
        for (model, question) in &self.first {
            if let Err(why) = can_ask(question, &judges[model]).await {
                refused.push((model.clone(), why.to_string()));
            }
        }
        refused
    }

    /// Gives the items their keys, so that no question is made again to know its key.
    pub(super) fn copy_keys(&self, items: &mut [Item]) {
        let made = self.items.iter().map(|item| (item.identity(), &item.key));
        let made: HashMap<Identity<'_>, &Option<Key>> = made.collect();
        for item in items {
            if let Some(key) = made.get(&item.asked.identity()) {
                let key = Option::clone(key);
                item.asked.key = key;
            }
        }
    }
}
