//! Attempts: every run that was made for a question of a batch, and which runs another one superseded.

use std::collections::{BTreeMap, BTreeSet};

use rusqlite::params;
use serde::Deserialize;

use super::{BatchId, ClaimCounts, Consumed, RunId, RunState, Store, StoreError, rows};

/// A run that was made for a question, without its texts.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct QuestionRun {
    /// The run.
    pub run: RunId,
    /// Where it stands.
    pub state: RunState,
    /// First and last time step of its window, where known.
    pub window: Option<(i64, i64)>,
    /// The most that it can have cost, US dollars, where that was known when it was asked.
    pub most_usd: Option<f64>,
    /// Time, tokens and cost.
    #[serde(flatten)]
    pub consumed: Consumed,
    /// Claims about obstacles, where they were checked.
    #[serde(flatten)]
    pub claims: ClaimCounts,
}

/// Whether another run counts in the place of one of `runs`: of the same request and sample a whole answer counts
/// before one that was cut or failed, these before what was cancelled or interrupted, and of equals the one that
/// entered the store last. What is arriving is never superseded, and supersedes nothing.
pub const SUPERSEDED: &str = "(runs.state <> 'running' AND runs.deleted_ms IS NULL AND EXISTS (
         SELECT 1 FROM runs AS other WHERE other.key = runs.key AND other.sample = runs.sample
             AND other.id <> runs.id AND other.deleted_ms IS NULL AND CASE other.state
                 WHEN 'answered' THEN runs.state <> 'answered' OR other.id > runs.id
                 WHEN 'truncated' THEN runs.state IN ('cancelled', 'interrupted')
                     OR (runs.state IN ('truncated', 'failed') AND other.id > runs.id)
                 WHEN 'failed' THEN runs.state IN ('cancelled', 'interrupted')
                     OR (runs.state IN ('truncated', 'failed') AND other.id > runs.id)
                 WHEN 'running' THEN 0
                 ELSE runs.state IN ('cancelled', 'interrupted') AND other.id > runs.id END))";

impl Store {
    /// The runs that were made for questions of a batch, by the places of the questions, each in the order in which
    /// they entered the store: of `most` questions from the place `from` on. Deleted runs are left out.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn question_runs(
        &self,
        batch: BatchId,
        from: u64,
        most: Option<u32>,
    ) -> Result<BTreeMap<u64, Vec<QuestionRun>>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "WITH asked AS MATERIALIZED (
                 SELECT place, key, sample, run FROM items WHERE batch = ?1 AND place >= ?2 ORDER BY place LIMIT ?3),
             made AS MATERIALIZED (
                 SELECT place, runs.id AS run FROM asked
                     JOIN runs ON runs.key = asked.key AND runs.sample = asked.sample
                 UNION SELECT place, run FROM asked WHERE run IS NOT NULL)
             SELECT place, runs.id AS run, state, window_first, window_last, most_usd, input_tokens, output_tokens,
                 reasoning_tokens, cached_tokens, cost_usd, first_chunk_ms, duration_ms,
                 claims_right, claims_wrong, claims_open, claims_check
             FROM made JOIN runs ON runs.id = made.run WHERE deleted_ms IS NULL ORDER BY place, runs.id",
        )?;
        let most = most.map_or(-1, i64::from); // a negative limit is none
        let mut found: BTreeMap<u64, Vec<QuestionRun>> = BTreeMap::new();
        let rows = statement.query_map(params![batch.0, from, most], |row| {
            Ok((row.get("place")?, rows::from_row(row)?))
        })?;
        for row in rows {
            let (place, run) = row?;
            found.entry(place).or_default().push(run);
        }
        Ok(found)
    }

    /// The runs in whose place another one counts, see [`SUPERSEDED`].
    ///
    /// # Errors
    /// SQLite refused.
    pub fn superseded(&self) -> Result<BTreeSet<RunId>, StoreError> {
        let connection = self.lock();
        let sql = format!("SELECT id FROM runs WHERE {SUPERSEDED}");
        let mut statement = connection.prepare_cached(&sql)?;
        let rows = statement.query_map([], |row| row.get(0).map(RunId))?;
        Ok(rows.collect::<Result<_, _>>()?)
    }
}
