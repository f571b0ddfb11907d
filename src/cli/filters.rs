//! Run filters, shared by `runs` and `export`.

use std::path::Path;
use std::sync::Arc;

use super::{Failure, open};
use crate::store::{Decision, Filter, Origin, RunState, Store, StoreError, moment};
use crate::verdict::Task;

/// Narrows runs down.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Filters {
    /// Runs whose model's name has this in it.
    #[arg(long, value_name = "PART")]
    model: Option<String>,
    /// Runs on scenarios whose name has this in it.
    #[arg(long, value_name = "PART")]
    scenario: Option<String>,
    /// Runs on this task.
    #[arg(long, value_parser = open::task)]
    task: Option<Task>,
    /// Runs in this state: answered, truncated, failed, cancelled, interrupted, running.
    #[arg(long, value_parser = state)]
    state: Option<RunState>,
    /// Runs that were asked here, recorded by others, or replayed: asked elsewhere and imported.
    #[arg(long, value_parser = origin)]
    origin: Option<Origin>,
    /// Runs of this batch.
    #[arg(long)]
    batch: Option<String>,
    /// Runs whose verdict is dangerous, safe or none.
    #[arg(long, value_parser = said)]
    verdict: Option<Decision>,
    /// Runs of this day or later, e.g. 2026-01-31.
    #[arg(long, value_name = "DAY", value_parser = moment)]
    since: Option<i64>,
    /// Runs before this day.
    #[arg(long, value_name = "DAY", value_parser = moment)]
    before: Option<i64>,
    /// Pinned runs.
    #[arg(long)]
    pinned: bool,
    /// The deleted runs instead of the others.
    #[arg(long)]
    deleted: bool,
}

impl Filters {
    /// What the store is asked for, with words to search for.
    pub fn filter(&self, words: Option<String>) -> Filter {
        Filter {
            words,
            model: self.model.clone(),
            scenario: self.scenario.clone(),
            task: self.task,
            state: self.state,
            origin: self.origin,
            batch: self.batch.clone(),
            verdict: self.verdict,
            since_ms: self.since,
            before_ms: self.before,
            pinned: self.pinned,
            deleted: self.deleted,
        }
    }
}

/// The store of the user's data folder.
pub fn store() -> Result<Arc<Store>, Failure> {
    opened(Store::open)
}

/// The store of the user's data folder for a command that only reads, also where nothing can be written.
pub fn store_to_read() -> Result<Arc<Store>, Failure> {
    opened(Store::open_to_read)
}

fn opened(open: impl Fn(&Path) -> Result<Store, StoreError>) -> Result<Arc<Store>, Failure> {
    let (folders, _) = open::configuration()?;
    open(&folders.store()).map(Arc::new).map_err(Failure::input)
}

fn state(word: &str) -> Result<RunState, String> {
    RunState::parse(word).ok_or_else(|| there_are(RunState::ALL.iter().map(|s| s.name())))
}

fn origin(word: &str) -> Result<Origin, String> {
    Origin::parse(word).ok_or_else(|| there_are(Origin::ALL.iter().map(|o| o.name())))
}

fn there_are(words: impl Iterator<Item = &'static str>) -> String {
    format!("there are {}", words.collect::<Vec<_>>().join(", "))
}

fn said(word: &str) -> Result<Decision, String> {
    Decision::parse(word).ok_or_else(|| there_are(Decision::ALL.iter().map(|d| d.name())))
}
