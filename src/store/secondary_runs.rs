//! Secondary runs: answers at other leads or about changed scenes, beside a batch's primary questions.

use std::collections::{BTreeMap, BTreeSet};

use super::{RunId, Store, StoreError};

/// Runs of batches, sorted: no table of what is right or wrong counts those of other leads and changed scenes among the
/// others, as they ask something else.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SecondaryRuns {
    /// About the scenes as they are, at a lead that is not the first one of their batch.
    pub leads: BTreeSet<RunId>,
    /// About changed scenes.
    pub changed: BTreeSet<RunId>,
    /// The others of batches: answers to first questions, whatever else they answer.
    pub first: BTreeSet<RunId>,
    /// The values of the axes of their batches, of those that were asked with some.
    pub settings: BTreeMap<RunId, String>,
    /// Answers to questions of a test split that is not complete, whatever else they answer.
    pub locked: BTreeSet<RunId>,
}

impl Store {
    /// The runs that were made for other leads and changed scenes of batches, and those that answer the same request. A
    /// run that is also the answer to a first question of a batch is none of them.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn asides(&self) -> Result<SecondaryRuns, StoreError> {
        let locked = self.locked_runs()?.into_keys().collect();
        let connection = self.lock();
        // What a batch was begun with comes first: questions without a lead, else the lead that stands first.
        let mut statement = connection.prepare_cached(
            "WITH firsts AS MATERIALIZED (
                 SELECT batch, CASE
                     WHEN max(task = 'safety' AND lead IS NULL AND transform IS NULL) THEN NULL
                     ELSE (SELECT lead FROM items AS one WHERE one.batch = items.batch AND lead IS NOT NULL
                           ORDER BY place LIMIT 1) END AS lead
                 FROM items GROUP BY batch),
             sorted AS MATERIALIZED (
                 SELECT items.run, items.key, items.sample, CASE
                     WHEN items.transform IS NOT NULL THEN 2
                     WHEN items.lead IS NULL OR items.lead IS firsts.lead THEN 0
                     ELSE 1 END AS kind
                 FROM items JOIN firsts ON firsts.batch = items.batch)
             SELECT run, min(kind) FROM (
                 SELECT run, kind FROM sorted WHERE run IS NOT NULL
                 UNION ALL
                 SELECT runs.id, kind FROM sorted JOIN runs ON runs.key = sorted.key AND runs.sample = sorted.sample)
             GROUP BY run",
        )?;
        let rows =
            statement.query_map([], |row| Ok((RunId(row.get(0)?), row.get::<_, i64>(1)?)))?;
        let mut asides = SecondaryRuns {
            locked,
            ..SecondaryRuns::default()
        };
        for row in rows {
            let (run, kind) = row?;
            let runs = match kind {
                0 => &mut asides.first,
                1 => &mut asides.leads,
                _ => &mut asides.changed,
            };
            runs.insert(run);
        }
        let mut statement = connection.prepare_cached(
            "SELECT run, settings FROM items WHERE settings IS NOT NULL AND run IS NOT NULL
             UNION ALL SELECT runs.id, items.settings FROM items
                 JOIN runs ON runs.key = items.key AND runs.sample = items.sample WHERE items.settings IS NOT NULL",
        )?;
        let rows = statement.query_map([], |row| Ok((RunId(row.get(0)?), row.get(1)?)))?;
        for row in rows {
            let (run, settings) = row?;
            asides.settings.insert(run, settings);
        }
        Ok(asides)
    }
}
