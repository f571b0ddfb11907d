//! A dry run: a batch's questions and their estimated consumption, before anything is sent, as lines for every face.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_store::{Identity, Item, Key, NewItem, SplitPart, Store};
use nearmiss_study::evaluation::batch::{Ask, Estimate, PreparedQuestions};
use nearmiss_study::evaluation::{AxisValues, Judges, Question, can_ask};

use super::plan::Origin;
use super::{BatchError, BatchPlan, parts};

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
    /// The requests that are counted, each with its sample.
    keys: HashSet<(Key, u32)>,
    /// For each model and values of axes a question that would be sent to it.
    first: BTreeMap<(String, AxisValues), Arc<Question>>,
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
        let anew = self.asked_anew();
        let mut done = 0;
        let prepare = |(entry, asks): &(Entry, Vec<Ask>)| {
            self.builder
                .prepare(entry, asks, &self.truth, judges, store)
        };
        for part in parts(&self.scenarios, prepare) {
            done += part.len();
            for ((entry, _), prepared) in part {
                let split = self.spec.experiment.split;
                let of_split = split.map(|split| split.part(&entry.name));
                let asked = self.part.is_none() || self.part == of_split;
                dry_run.add(&entry.name, prepared?, &anew, (of_split, asked))?;
            }
            if cancel.is_asked() {
                return Ok(None);
            }
            on_event(DryRunEvent::Described {
                done,
                dry_run: &dry_run,
            });
        }
        dry_run.doubts.extend(dry_run.one_sided_parts());
        Ok(Some(dry_run))
    }
}

impl BatchPlan {
    /// The questions that are asked although the store has their answers.
    fn asked_anew(&self) -> HashSet<Identity<'_>> {
        let items: &[Item] = match &self.origin {
            Origin::Stored(stored) => &stored.items,
            Origin::New { .. } => &[],
        };
        let anew = items.iter().filter(|item| self.selection.asks_anew(item));
        anew.map(|item| item.asked.identity()).collect()
    }
}

impl DryRun {
    /// Adds the questions about a scenario with its part of a split, and whether that is asked; the answers to those of
    /// `anew` are not taken from the store.
    fn add(
        &mut self,
        scenario: &str,
        prepared: PreparedQuestions,
        anew: &HashSet<Identity<'_>>,
        (of_split, asked): (Option<SplitPart>, bool),
    ) -> Result<(), BatchError> {
        if let Some(wrong) = prepared.wrong {
            return Err(wrong.into());
        }
        if prepared.unlabelled {
            self.unlabelled.push(scenario.to_string());
        }
        let doubts = prepared.doubts.iter();
        self.doubts
            .extend(doubts.map(|doubt| format!("{scenario}: {doubt}")));
        for (model, settings, question) in prepared.first.into_iter().filter(|_| asked) {
            self.first.entry((model, settings)).or_insert(question);
        }
        for (mut item, mut size) in prepared.items {
            item.split = of_split;
            if let Some(size) = &mut size {
                size.stored &= !anew.contains(&item.identity());
            }
            let key = item.key.as_ref().map(|key| (key.clone(), item.sample));
            let to_send = size.as_ref().is_some_and(|size| !size.stored);
            let is_repeated = || key.is_some_and(|key| !self.keys.insert(key));
            if !asked {
            } else if to_send && is_repeated() {
                self.estimate.repeated += 1
            } else {
                self.estimate.add(size, item.unaskable.as_deref())
            }
            self.items.push(item);
        }
        Ok(())
    }

    /// The questions of a part of the split, and how many of them are about a dangerous window.
    #[must_use]
    pub fn part(&self, part: SplitPart) -> (usize, usize) {
        let of_part = self.items.iter().filter(|item| item.split == Some(part));
        of_part.fold((0, 0), |(all, dangerous), item| {
            (
                all + 1,
                dangerous + usize::from(item.collides == Some(true)),
            )
        })
    }

    /// Warnings about parts of a split whose windows are all of one kind.
    fn one_sided_parts(&self) -> Vec<String> {
        let warning = |part: SplitPart| {
            let (kind, without) = match self.part(part) {
                (0, _) => return None,
                (_, 0) => ("dangerous", "recall and F1"),
                (all, dangerous) if all == dangerous => ("safe", "specificity"),
                _ => return None,
            };
            Some(format!(
                "split: the {} part has no {kind} window, so {without} have no value there; change its seed or its share",
                part.name()
            ))
        };
        [SplitPart::Dev, SplitPart::Test]
            .into_iter()
            .filter_map(warning)
            .collect()
    }

    /// The models that cannot be asked as things stand, and why. Nothing is sent; a command that prints a key is run.
    pub async fn refused(&self, judges: &Judges) -> Vec<(String, String)> {
        let mut refused = Vec::new();
        for ((model, settings), question) in &self.first {
            if let Err(why) = can_ask(question, &judges[model].under(settings)).await {
                let of_settings = settings.to_stored().map(|words| format!(" ({words})"));
                let name = format!("{model}{}", of_settings.unwrap_or_default());
                refused.push((name, why.to_string()));
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

/// A line of a dry run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DryRunLine {
    /// A name with its value.
    Value(&'static str, String),
    /// A further line of the value above.
    Note(&'static str),
    /// Why questions cannot be asked.
    Reason(String),
}

/// What the price of a dry run counts.
const COUNTED: &str = "(tokens at the highest price of input, cache writes included, and max_tokens at that of output for each \
                       request; answers are mostly shorter; retries after errors are not included)";

impl DryRun {
    /// The questions and what they take. `refused` are the models that cannot be asked, and why; `budget` is the most
    /// that a run may cost, US dollars.
    #[must_use]
    pub fn lines(&self, refused: &[(String, String)], budget: Option<f64>) -> Vec<DryRunLine> {
        use DryRunLine::{Note, Reason, Value};
        let estimate = &self.estimate;
        let mut lines = vec![
            Value("questions", estimate.questions().to_string()),
            Value("requests", estimate.requests.to_string()),
            Value("built-in judge", estimate.free.to_string()),
            Value("in the store", estimate.stored.to_string()),
            Value("cannot be asked", estimate.unaskable.to_string()),
        ];
        if estimate.repeated > 0 {
            let words = format!(
                "{} with the request of another, sent once",
                estimate.repeated
            );
            lines.insert(2, Value("repeated", words));
        }
        for part in [SplitPart::Dev, SplitPart::Test] {
            let (all, dangerous) = self.part(part);
            if all > 0 {
                let words = format!("{all} questions, {dangerous} about dangerous windows");
                lines.push(Value(part.name(), words));
            }
        }
        let reasons = estimate.why.iter();
        lines.extend(reasons.map(|(why, count)| Reason(format!("{count} × {why}"))));
        lines.push(Value(
            "tokens",
            format!("{} (estimated, without the answers)", estimate.tokens),
        ));
        lines.push(Value("price", estimate.price()));
        let bounds = estimate.bounds.iter();
        lines.extend(bounds.map(|bound| Value("counted", bound.clone())));
        if estimate.requests > estimate.unpriced {
            lines.push(Note(COUNTED));
        }
        if let Some(usd) = budget {
            let words = match is_enough(usd, estimate) {
                Some(true) => "enough for all",
                Some(false) => "too little: questions that could exceed it stay open",
                None => "may not be enough: some prices or limits are unknown",
            };
            lines.push(Value("budget", format!("{usd} USD, {words}")));
        }
        let refused = refused.iter();
        lines.extend(refused.map(|(model, why)| Value("refused", format!("{model}: {why}"))));
        lines
    }
}

/// Whether a budget, US dollars, is enough for everything; `None` if that cost is unknown.
#[must_use]
pub fn is_enough(usd: f64, estimate: &Estimate) -> Option<bool> {
    if estimate.usd > usd {
        Some(false)
    } else {
        estimate.most_usd().map(|_| true)
    }
}
