//! Rounds of tool calls: kept as each is done, and found again by a later run of the same question.

use rusqlite::{OptionalExtension, params};

use super::claim::renew;
use super::{NewRun, RunId, Store, StoreError};

impl Store {
    /// Keeps the rounds of a run so far, a JSON array; afterwards they are on the disk. Renews the claim.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn keep_rounds(&self, run: RunId, json: &str) -> Result<(), StoreError> {
        self.durably(|transaction| {
            transaction
                .prepare_cached("UPDATE runs SET tool_rounds = ?2 WHERE id = ?1")?
                .execute(params![run.0, json])?;
            renew(transaction, run)
        })
    }

    /// The rounds of the newest earlier run of the same question and sample that broke off: they are paid, and `run`
    /// goes on after them. Nothing if that run answered, or was deleted.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn unfinished_rounds(
        &self,
        question: &NewRun,
        run: RunId,
    ) -> Result<Option<(RunId, String)>, StoreError> {
        let Some(key) = question.key() else {
            return Ok(None);
        };
        let connection = self.lock();
        let sql = "SELECT id, state, tool_rounds FROM runs WHERE key = ?1 AND sample = ?2 AND id < ?3
            AND deleted_ms IS NULL AND (tool_rounds IS NOT NULL OR state IN ('answered', 'truncated'))
            ORDER BY id DESC LIMIT 1";
        let found = connection
            .prepare_cached(sql)?
            .query_row(params![key.as_str(), question.sample, run.0], |row| {
                let (id, state): (i64, String) = (row.get(0)?, row.get(1)?);
                let rounds: Option<String> = row.get(2)?;
                Ok((RunId(id), state, rounds))
            })
            .optional()?;
        let broken = |state: &str| ["interrupted", "failed", "cancelled"].contains(&state);
        Ok(found.and_then(|(id, state, rounds)| Some((id, rounds.filter(|_| broken(&state))?))))
    }
}
