//! Ground truths that batches store for their runs, and how many claims of an answer are right.

use nearmiss_scene::verdict::Task;
use rusqlite::params;
use serde::{Deserialize, Serialize};

use super::rows::{self, from_row};
use super::{BatchId, Item, RunId, Store, StoreError, WindowFacts};

/// What is true about a run, from its batch.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
pub struct RunLabel {
    /// The run.
    pub run: RunId,
    /// The batch.
    pub batch: BatchId,
    /// The task.
    pub task: Task,
    /// Whether the ego collides: in the scenario, or as the truth of its window says where that was drawn.
    pub collides: bool,
    /// The colliding obstacle, where known.
    pub obstacle: Option<i64>,
    /// Whether its window was drawn, so that the truth is that of the window.
    pub drawn: bool,
    /// What is known of its window.
    #[serde(deserialize_with = "rows::json")]
    pub facts: Option<WindowFacts>,
}

/// Another truth of a question.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ItemTruth {
    /// The question's place in the batch.
    pub place: u64,
    /// What is true; `None` if it is unknown.
    pub collides: Option<bool>,
    /// The obstacle that the truth names, if it names one.
    pub obstacle: Option<i64>,
    /// The critical obstacles of its window, in place of those in [`WindowFacts`]; `None` leaves these.
    pub critical: Option<Vec<i64>>,
}

impl Item {
    /// Has this truth from now on.
    pub fn set_truth(&mut self, truth: &ItemTruth) {
        (self.asked.collides, self.asked.obstacle) = (truth.collides, truth.obstacle);
        if let (Some(facts), Some(critical)) = (&mut self.asked.facts, &truth.critical) {
            facts.critical.clone_from(critical);
        }
    }
}

impl Store {
    /// Replaces the ground truth: by place, whether the ego collides, and with which obstacle.
    ///
    /// # Errors
    /// SQLite refused; no change is made.
    pub fn set_truth(
        &self,
        batch: BatchId,
        spec: &str,
        truth: &[ItemTruth],
    ) -> Result<(), StoreError> {
        self.durably(|transaction| {
            transaction.execute(
                "UPDATE batches SET spec = ?2 WHERE id = ?1",
                params![batch.0, spec],
            )?;
            let mut statement = transaction.prepare_cached(
                "UPDATE items SET collides = ?3, obstacle = ?4,
                     facts = CASE WHEN ?5 IS NOT NULL AND json_type(facts, '$.critical') IS NOT NULL
                         THEN json_set(facts, '$.critical', json(?5)) ELSE facts END
                 WHERE batch = ?1 AND place = ?2",
            )?;
            for one in truth {
                let critical = one
                    .critical
                    .as_ref()
                    .map(serde_json::to_string)
                    .transpose()?;
                let told = (one.place, one.collides, one.obstacle);
                statement.execute(params![batch.0, told.0, told.1, told.2, critical])?;
            }
            Ok(())
        })
    }

    /// The batch that each run was made for, in words; runs that were made for none are left out.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn run_batches(&self) -> Result<Vec<(RunId, String)>, StoreError> {
        let connection = self.lock();
        let mut statement =
            connection.prepare_cached("SELECT id, batch FROM runs WHERE batch IS NOT NULL")?;
        let rows = statement.query_map([], |row| Ok((RunId(row.get(0)?), row.get(1)?)))?;
        Ok(rows.collect::<Result<_, _>>()?)
    }

    /// Labels of runs from their batches, one a run. If several batches have one, the batch that the run was made for
    /// counts. Changed scenes are left out, as their obstacles can have other ids.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn truths(&self) -> Result<Vec<RunLabel>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT items.run, items.batch, items.task, collides, obstacle,
                 items.window_first IS NOT NULL AS drawn, items.facts
             FROM items JOIN runs ON runs.id = items.run
             WHERE collides IS NOT NULL AND transform IS NULL
             ORDER BY items.run, coalesce(runs.batch = 'b' || items.batch, 0) DESC, items.batch",
        )?;
        let rows = statement.query_map([], from_row)?;
        let mut told: Vec<RunLabel> = rows.collect::<Result<_, _>>()?;
        told.dedup_by_key(|one| one.run);
        Ok(told)
    }
}

/// Counts of claims. All are `None` where the answer was not checked, as its scenario was not at hand.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema,
)]
pub struct ClaimCounts {
    /// Claims about obstacles in the answer that hold; null if they were not checked.
    pub claims_right: Option<u32>,
    /// Claims that do not hold.
    pub claims_wrong: Option<u32>,
    /// Claims that cannot be decided.
    pub claims_open: Option<u32>,
    /// Version of the check that counted the claims.
    pub claims_check: Option<u32>,
}

impl ClaimCounts {
    /// Right, wrong and open; `None` if the answer was not checked.
    #[must_use]
    pub fn known(self) -> Option<[u32; 3]> {
        Some([self.claims_right?, self.claims_wrong?, self.claims_open?])
    }
}

impl Store {
    /// Keeps counts of claims with their runs; runs that are gone are left out.
    ///
    /// # Errors
    /// SQLite refused; nothing is kept then.
    pub fn keep_claims(&self, counted: &[(RunId, ClaimCounts)]) -> Result<(), StoreError> {
        self.durably(|transaction| {
            let mut statement = transaction.prepare_cached(
                "UPDATE runs SET claims_right = ?2, claims_wrong = ?3, claims_open = ?4, claims_check = ?5
                 WHERE id = ?1",
            )?;
            for (run, counts) in counted {
                statement.execute(params![
                    run.0,
                    counts.claims_right,
                    counts.claims_wrong,
                    counts.claims_open,
                    counts.claims_check
                ])?;
            }
            Ok(())
        })
    }
}
