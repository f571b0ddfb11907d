//! Run filters, shared by `runs` and `export`.

use std::path::Path;
use std::sync::Arc;

use super::{Failure, open};
use nearmiss_base::system::unknown;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{BatchId, Decision, Filter, Origin, StateFilter, Store, StoreError, moment};

/// Narrows runs down.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Filters {
    /// Only runs whose model contains this text.
    #[arg(long, value_name = "PART")]
    model: Option<String>,
    /// Only runs whose scenario contains this text.
    #[arg(long, value_name = "PART")]
    scenario: Option<String>,
    /// Only runs of this task.
    #[arg(long, value_parser = open::task)]
    task: Option<Task>,
    /// Only runs in this state: answered (with or without a verdict), unparsed, truncated (filtered ones, too),
    /// filtered, failed, cancelled, interrupted, running (waiting in reports) or superseded.
    #[arg(long, value_parser = state)]
    state: Option<StateFilter>,
    /// Only runs of this origin: asked (here), recorded (published answers) or replayed (asked elsewhere, imported).
    #[arg(long, value_parser = origin)]
    origin: Option<Origin>,
    /// Only runs of this batch, such as b7, or `last`.
    #[arg(long)]
    batch: Option<String>,
    /// Only runs with this verdict: dangerous, safe or none.
    #[arg(long, value_parser = said)]
    verdict: Option<Decision>,
    /// Only runs from this day on, e.g. 2026-01-31.
    #[arg(long, value_name = "DAY", value_parser = moment)]
    since: Option<i64>,
    /// Only runs before this day.
    #[arg(long, value_name = "DAY", value_parser = moment)]
    before: Option<i64>,
    /// Only pinned runs.
    #[arg(long)]
    pinned: bool,
    /// Only deleted runs; without it they are left out.
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

impl Filters {
    /// The same for a store, which knows its batches.
    ///
    /// # Errors
    /// There is no such batch, or none yet with `--batch last`.
    pub fn in_store(&self, words: Option<String>, store: &Store) -> Result<Filter, Failure> {
        let mut filter = self.filter(words);
        match filter.batch.as_deref() {
            Some(LAST) => filter.batch = Some(last_batch(store)?.to_string()),
            Some(word) => known_batch(word, store)?,
            None => {}
        }
        Ok(filter)
    }
}

/// The word for the newest batch.
pub const LAST: &str = "last";

/// The newest batch.
///
/// # Errors
/// There is none yet.
pub fn last_batch(store: &Store) -> Result<BatchId, Failure> {
    let last = store.last_batch().map_err(Failure::input)?;
    let none = || Failure::input("no batch yet; `nearmiss evaluate` begins one");
    Ok(last.ok_or_else(none)?.id)
}

/// Refuses a word that names no batch and that no run has: imported runs may have words of their own.
fn known_batch(word: &str, store: &Store) -> Result<(), Failure> {
    let of_batch = || {
        store.numbers(&Filter {
            batch: Some(word.into()),
            ..Filter::default()
        })
    };
    let known = match word.parse().map(|id| store.batch(id)) {
        Ok(Ok(Some(_))) => true,
        Ok(Err(error)) => return Err(Failure::input(error)),
        _ => !of_batch().map_err(Failure::input)?.is_empty(),
    };
    let unknown = || {
        Failure::input(format!(
            "no batch {word}; `nearmiss evaluate list` lists batches"
        ))
    };
    known.then_some(()).ok_or_else(unknown)
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

fn state(word: &str) -> Result<StateFilter, String> {
    StateFilter::parse(word)
        .ok_or_else(|| unknown("state", word, StateFilter::ALL.iter().map(|s| s.name())))
}

fn origin(word: &str) -> Result<Origin, String> {
    Origin::parse(word).ok_or_else(|| unknown("origin", word, Origin::ALL.iter().map(|o| o.name())))
}

fn said(word: &str) -> Result<Decision, String> {
    Decision::parse(word)
        .ok_or_else(|| unknown("verdict", word, Decision::ALL.iter().map(|d| d.name())))
}
