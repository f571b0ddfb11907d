//! Splits of a batch into dev and test: how far each part is, and looks at a test split before it was complete.

use std::collections::{BTreeMap, BTreeSet};

use rusqlite::params;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use super::database::now_ms;
use super::items::STATE;
use super::rows::from_row;
use super::{BatchId, RunId, Store, StoreError};

/// A part of a split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum SplitPart {
    /// For choosing models and prompts.
    Dev,
    /// For the figures that are published.
    Test,
}

nearmiss_record::named!(SplitPart, "part of a split");

/// Progress of a part: questions that can be asked, by state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
pub struct SplitProgress {
    /// Questions that can be asked.
    pub questions: u64,
    /// With an answer that a further run does not ask again: complete, or cut off by the server.
    pub answered: u64,
}

/// A look at the figures of a test split before it was complete.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema,
)]
pub struct UnlockRecord {
    /// When, milliseconds since 1970, UTC.
    pub at_ms: i64,
    /// Answers that were there.
    pub answered: u64,
    /// Questions of the test split.
    pub questions: u64,
}

impl Store {
    /// How far a part of a batch is; no questions where the batch has no split.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn split_progress(
        &self,
        batch: BatchId,
        part: SplitPart,
    ) -> Result<SplitProgress, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(&format!(
            "SELECT coalesce(sum(now <> 'unaskable'), 0) AS questions,
                 coalesce(sum(now IN ('answered', 'truncated')), 0) AS answered
             FROM (SELECT {STATE} AS now FROM items WHERE batch = ?1 AND split = ?2)"
        ))?;
        Ok(statement.query_row(params![batch.0, part.name()], from_row)?)
    }

    /// The looks at the test split of a batch before it was complete, in their order.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn looks(&self, batch: BatchId) -> Result<Vec<UnlockRecord>, StoreError> {
        let sql = "SELECT at_ms, answered, questions FROM looks WHERE batch = ?1 ORDER BY at_ms, answered";
        self.rows(sql, [batch.0], from_row)
    }

    /// Records that the figures of a test split are looked at now; afterwards that is on the disk.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn record_look(&self, batch: BatchId, progress: SplitProgress) -> Result<(), StoreError> {
        let look = UnlockRecord {
            at_ms: now_ms(),
            answered: progress.answered,
            questions: progress.questions,
        };
        self.add_looks(batch, &[look])
    }

    /// Adds looks that another store knows of; each once.
    pub(super) fn add_looks(
        &self,
        batch: BatchId,
        looks: &[UnlockRecord],
    ) -> Result<(), StoreError> {
        let known: BTreeSet<UnlockRecord> = self.looks(batch)?.into_iter().collect();
        self.durably(|transaction| {
            for look in looks.iter().filter(|look| !known.contains(look)) {
                transaction.execute(
                    "INSERT INTO looks (batch, at_ms, answered, questions) VALUES (?1, ?2, ?3, ?4)",
                    params![batch.0, look.at_ms, look.answered, look.questions],
                )?;
            }
            Ok(())
        })
    }

    /// The batches with a test split that is not complete here: questions are open, or parts of the batch are on other
    /// machines.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn locked_batches(&self) -> Result<Vec<BatchId>, StoreError> {
        let sql = format!(
            "SELECT id FROM batches JOIN (
                 SELECT batch, max(now IN ('waiting', 'failed')) AS open
                 FROM (SELECT items.batch, {STATE} AS now FROM items WHERE split = 'test') GROUP BY batch
             ) AS tests ON tests.batch = batches.id WHERE open OR shard IS NOT NULL"
        );
        self.rows(&sql, [], |row| row.get(0).map(BatchId))
    }

    /// The answers to questions of locked test splits, whichever batch asked for them, each with the batches that lock
    /// it.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn locked_runs(&self) -> Result<BTreeMap<RunId, BTreeSet<BatchId>>, StoreError> {
        let locked = self.locked_batches()?;
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT run FROM items WHERE batch = ?1 AND split = 'test' AND run IS NOT NULL
             UNION SELECT runs.id FROM items JOIN runs ON runs.key = items.key AND runs.sample = items.sample
                 WHERE items.batch = ?1 AND items.split = 'test'",
        )?;
        let mut runs: BTreeMap<RunId, BTreeSet<BatchId>> = BTreeMap::new();
        for batch in locked {
            let rows = statement.query_map([batch.0], |row| Ok(RunId(row.get(0)?)))?;
            for run in rows {
                runs.entry(run?).or_default().insert(batch);
            }
        }
        Ok(runs)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::items::tests::item;
    use super::super::{ItemState, NewItem};
    use super::*;

    fn of(part: SplitPart, scenario: &str) -> NewItem {
        NewItem {
            split: Some(part),
            key: None,
            ..item(scenario, 0)
        }
    }

    #[test]
    fn a_test_split_is_locked_until_nothing_of_it_is_open_and_looks_are_kept_once() {
        let store = Store::in_memory().unwrap();
        let asked = [
            of(SplitPart::Dev, "A"),
            of(SplitPart::Test, "B"),
            of(SplitPart::Test, "C"),
            NewItem {
                unaskable: Some("no ego".into()),
                ..of(SplitPart::Test, "D")
            },
        ];
        let batch = store.begin_batch("{}", None, &asked).unwrap();
        store.begin_batch("{}", None, &[item("E", 0)]).unwrap();
        let progress = |part| store.split_progress(batch, part).unwrap();
        let counts = |questions, answered| SplitProgress {
            questions,
            answered,
        };
        assert_eq!(progress(SplitPart::Test), counts(2, 0));
        assert_eq!(store.locked_batches().unwrap(), [batch]);
        let set = |place, state| {
            store
                .set_item(batch, place, None, state, None, None)
                .unwrap()
        };
        set(1, ItemState::Answered);
        set(2, ItemState::Failed);
        assert_eq!(progress(SplitPart::Test), counts(2, 1));
        assert_eq!(store.locked_batches().unwrap(), [batch]);
        store.record_look(batch, progress(SplitPart::Test)).unwrap();
        set(2, ItemState::Truncated);
        assert_eq!(progress(SplitPart::Test), counts(2, 2));
        assert!(store.locked_batches().unwrap().is_empty());
        assert_eq!(progress(SplitPart::Dev), counts(1, 0));
        let looks = store.looks(batch).unwrap();
        assert_eq!(
            (looks.len(), looks[0].answered, looks[0].questions),
            (1, 1, 2)
        );
        store.add_looks(batch, &looks).unwrap();
        assert_eq!(store.looks(batch).unwrap(), looks);
        let part = store
            .begin_batch("{}", Some("1/2"), &[of(SplitPart::Test, "F")])
            .unwrap();
        store
            .set_item(part, 0, None, ItemState::Answered, None, None)
            .unwrap();
        assert_eq!(
            store.locked_batches().unwrap(),
            [part],
            "other parts are missing"
        );
    }
}
