//! Words of a search that are part of a model's name: these find the model's runs, too.

use std::collections::BTreeSet;

use rusqlite::Connection;

use super::{Store, StoreError};

/// The models that were asked, as far as the store was read.
#[derive(Debug, Default)]
pub(super) struct KnownModels {
    /// Their ids.
    ids: BTreeSet<String>,
    /// The run up to which they were read: a run keeps its model.
    read_to: i64,
}

impl Store {
    /// The models whose names contain a word, in any case. Only runs that came since the last search are read.
    pub(super) fn models_with(
        &self,
        connection: &Connection,
        word: &str,
    ) -> Result<Vec<String>, StoreError> {
        let mut known = self.known_models();
        let newest: Option<i64> =
            connection.query_row("SELECT max(id) FROM runs", [], |row| row.get(0))?;
        if let Some(newest) = newest.filter(|newest| *newest > known.read_to) {
            let sql = "SELECT DISTINCT model FROM runs WHERE id > ?1 AND id <= ?2";
            let mut statement = connection.prepare_cached(sql)?;
            let ids = statement
                .query_map((known.read_to, newest), |row| row.get(0))?
                .collect::<Result<Vec<String>, _>>()?;
            known.ids.extend(ids);
            known.read_to = newest;
        }
        let word = word.to_lowercase();
        let has = |id: &&String| id.to_lowercase().contains(&word);
        Ok(known.ids.iter().filter(has).cloned().collect())
    }
}
