//! The lock of test splits for single answers: left out until the split is complete or unlocked.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::filters::{store, store_to_read};
use super::{Failure, Outcome, output};
use nearmiss_store::{BatchId, RunId, Store};
use nearmiss_study::evaluation::batch::TestSplit;

/// Shows answers of test splits that are not complete.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct Unlock {
    /// Include answers of test splits that are not complete; later reports say that these were looked at.
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
