//! Which stored runs: filters shared by `runs list`, `runs export` and `report`, and the lock of test splits.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use nearmiss_store::{BatchId, Filter, RunId, Store, StoreError};
use nearmiss_study::evaluation::batch::TestSplit;

use super::{Failure, Outcome, open, output};

/// Narrows runs down, as an argument.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Filters {
    /// Select runs that contain all WORDs and match all FILTERs
    ///
    /// Words are searched in model, scenario, answer, reasoning, justification and notes. Filters: model:PART,
    /// scenario:PART, task:, verdict: (dangerous, safe, none), state: (answered, unparsed, failed, …), origin: (asked,
    /// recorded, replayed), batch:, since:DAY, before:DAY, pinned, deleted.
    #[arg(value_name = "WORD|FILTER")]
    filter: Vec<String>,
    #[command(flatten)]
    batch: BatchOption,
}

/// Narrows runs down, as an option.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct FilterOption {
    /// Select runs by words and filters, as in `nearmiss runs list`: 'model:gpt task:safety'.
    #[arg(long, value_name = "FILTER")]
    runs: Vec<String>,
    #[command(flatten)]
    batch: BatchOption,
}

#[derive(Debug, Clone, Default, clap::Args)]
struct BatchOption {
    /// Select runs of one batch, such as b7, or `last`.
    #[arg(long)]
    batch: Option<String>,
}

impl BatchOption {
    fn filter(&self, words: &[String]) -> Result<Filter, Failure> {
        let mut filter = Filter::read(&words.join(" ")).map_err(Failure::input)?;
        if self.batch.is_some() {
            filter.batch.clone_from(&self.batch);
        }
        Ok(filter)
    }
}

impl FilterOption {
    /// What the store is asked for.
    ///
    /// # Errors
    /// A filter means nothing.
    pub fn filter(&self) -> Result<Filter, Failure> {
        self.batch.filter(&self.runs)
    }
}

impl Filters {
    /// The batch that is chosen, as it was named.
    ///
    /// # Errors
    /// None is, or other filters choose some of its runs.
    pub fn batch_alone(&self) -> Result<String, Failure> {
        let mut filter = self.batch.filter(&self.filter)?;
        let batch = filter.batch.take();
        batch
            .filter(|_| filter == Filter::default())
            .ok_or_else(|| {
                Failure::input("a bundle holds one whole batch: --batch ID, without other filters")
            })
    }

    /// What the store, which knows its batches, is asked for.
    ///
    /// # Errors
    /// A filter means nothing, or there is no such batch, or none yet with `--batch last`.
    pub fn in_store(&self, store: &Store) -> Result<Filter, Failure> {
        let mut filter = self.batch.filter(&self.filter)?;
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

/// Shows answers of test splits that are not complete.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct Unlock {
    /// Include answers of incomplete test splits; later reports state that these were unlocked.
    #[arg(long)]
    unlock: bool,
}

/// Answers that may not be shown.
#[derive(Debug, Default)]
pub struct LockedAnswers {
    runs: BTreeSet<RunId>,
}

impl LockedAnswers {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.runs.len()
    }

    /// Whether an answer is one of them.
    pub fn has(&self, run: RunId) -> bool {
        self.runs.contains(&run)
    }

    /// Says how many were left out, and how to see them; `does` is what the command does with answers: lists.
    pub fn say(&self, does: &str) {
        let answers = match self.count() {
            0 => return,
            1 => "left out 1 answer of a test split that is not complete",
            n => &format!("left out {n} answers of test splits that are not complete"),
        };
        output::say(&format!(
            "nearmiss: {answers}; --unlock {does} them, too, and records the look"
        ));
    }
}

impl Unlock {
    /// Which of these answers are locked. With --unlock none, and the look is recorded for their batches.
    pub fn locked(
        self,
        store: &Store,
        runs: impl IntoIterator<Item = RunId>,
    ) -> Result<LockedAnswers, Failure> {
        let known = store.locked_runs().map_err(Failure::input)?;
        let mut found = LockedAnswers::default();
        let mut batches: BTreeSet<BatchId> = BTreeSet::new();
        for run in runs {
            if let Some(of) = known.get(&run) {
                found.runs.insert(run);
                batches.extend(of);
            }
        }
        if !self.unlock {
            return Ok(found);
        }
        for batch in batches {
            record_look(store, batch)?;
        }
        Ok(LockedAnswers::default())
    }

    /// The store: a look is recorded in it.
    pub fn store(self) -> Result<Arc<Store>, Failure> {
        if self.unlock {
            store()
        } else {
            store_to_read()
        }
    }
}

/// Records a look at the test split of a batch, and says so.
fn record_look(store: &Store, batch: BatchId) -> Outcome {
    let Some(batch) = store.batch(batch).map_err(Failure::input)? else {
        return Ok(());
    };
    if let Some(test) = TestSplit::open(store, &batch, true).map_err(Failure::input)? {
        output::say(&format!("nearmiss: {}: {}", batch.id, test.summary()));
    }
    Ok(())
}
