//! Ground truths that batches store for their runs.

use super::rows::{self, from_row};
use super::{BatchId, RunId, Store, StoreError, WindowFacts};

/// What is true about a run, from its batch.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
pub struct RunLabel {
    /// The run.
    pub run: RunId,
    /// The batch.
    pub batch: BatchId,
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

impl Store {
    /// Labels of runs from their batches, one a run. If several batches have one, the batch that the run was made for
    /// counts. Changed scenes are left out, as their obstacles can have other ids.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn truths(&self) -> Result<Vec<RunLabel>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT items.run, items.batch, collides, obstacle,
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
