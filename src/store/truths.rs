//! What the batches hold true about their scenarios.

use super::{BatchId, Store, StoreError};

/// What a batch holds true about a scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Told {
    /// The batch.
    pub batch: BatchId,
    /// The scenario's name.
    pub scenario: String,
    /// SHA-256 of its file.
    pub scenario_hash: Option<String>,
    /// Whether the ego collides.
    pub collides: bool,
    /// With whom, where that is known.
    pub obstacle: Option<i64>,
}

impl Store {
    /// What every batch holds true, once a scenario.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn truths(&self) -> Result<Vec<Told>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT DISTINCT batch, scenario, scenario_hash, collides, obstacle FROM items
             WHERE collides IS NOT NULL",
        )?;
        let rows = statement.query_map([], |row| {
            Ok(Told {
                batch: BatchId(row.get(0)?),
                scenario: row.get(1)?,
                scenario_hash: row.get(2)?,
                collides: row.get(3)?,
                obstacle: row.get(4)?,
            })
        })?;
        Ok(rows.collect::<Result<_, _>>()?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::items::tests::item;
    use super::*;
    use crate::store::NewItem;

    #[test]
    fn a_batch_says_once_what_is_true_about_a_scenario() {
        let store = Store::in_memory().unwrap();
        let unknown = NewItem {
            collides: None,
            obstacle: None,
            ..item("B", 0)
        };
        let begun = [item("A", 0), item("A", 1), unknown];
        let id = store.begin_batch("{}", None, &begun).unwrap();
        let told = store.truths().unwrap();
        assert_eq!(told.len(), 1);
        assert_eq!((told[0].batch, told[0].scenario.as_str()), (id, "A"));
        assert_eq!((told[0].collides, told[0].obstacle), (true, Some(7)));
    }
}
