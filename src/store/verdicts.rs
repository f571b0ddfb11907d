//! Verdicts of all stored answers in one query, for lists of many scenarios.

use rusqlite::params;
use serde::Deserialize;

use super::{Origin, SUPERSEDED, Store, StoreError, rows};
use nearmiss_scene::verdict::Task;

/// Verdict of a stored answer.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct StoredVerdict {
    /// SHA-256 of the scenario's file; `None` if only its name is known.
    pub scenario_hash: Option<String>,
    /// Name of the scenario.
    pub scenario: String,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// Where the answer comes from.
    pub origin: Origin,
    /// The task.
    pub task: Task,
    /// First and last time step of the window, where known.
    pub window: Option<(i64, i64)>,
    /// Yes or no.
    pub dangerous: bool,
}

impl Store {
    /// The verdicts in all whole answers, whatever template they were asked with, without those in whose place another
    /// answer to the same request counts ([`SUPERSEDED`]) and those of the model `but`; all of them, or those about one
    /// scenario, by hash and name as in [`Store::of_scenario`].
    ///
    /// # Errors
    /// SQLite refused.
    pub fn verdicts(
        &self,
        but: &str,
        of: Option<(&str, &str)>,
    ) -> Result<Vec<StoredVerdict>, StoreError> {
        let connection = self.lock();
        let which = match of {
            None => "?2 IS NULL AND ?3 IS NULL",
            Some(_) => "(scenario_hash = ?2 OR (scenario_hash IS NULL AND scenario = ?3))",
        };
        let sql = format!(
            "SELECT scenario_hash, scenario, ego, origin, task, window_first, window_last, dangerous
             FROM runs
             WHERE deleted_ms IS NULL AND state = 'answered' AND dangerous IS NOT NULL AND model <> ?1 AND {which}
                 AND NOT {SUPERSEDED}"
        );
        let mut statement = connection.prepare_cached(&sql)?;
        let (hash, name) = of.unzip();
        let found = statement.query_map(params![but, hash, name], rows::from_row)?;
        Ok(found.collect::<Result<_, _>>()?)
    }
}
