//! Merges another store's runs and batches: shards asked on several machines become one batch.

use std::collections::{BTreeMap, HashMap};

use rusqlite::{OptionalExtension, Transaction, params};

use super::database::now_ms;
use super::items::insert;
use super::write::{insert_whole, there};
use super::{Batch, BatchId, Item, ItemState, Run, RunId, RunState, Store, StoreError};

/// Counts of merged rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MergeCounts {
    /// Runs that are new here.
    pub runs: usize,
    /// Runs that were here already.
    pub already_there: usize,
    /// Runs whose answers are still arriving elsewhere; they are left out.
    pub running: usize,
    /// Batches that are new here.
    pub batches: usize,
    /// Batches that were here in part, and now have more.
    pub united: usize,
}

/// Runs that are read and added at a time.
const PART: usize = 200;

impl Store {
    /// Adds every run and batch of another store; each run once. Batches in which the same is asked become one.
    ///
    /// # Errors
    /// SQLite refused one of the two. What was added until then stays, and adding it again does no harm.
    pub fn merge(&self, other: &Self) -> Result<MergeCounts, StoreError> {
        let mut merged = MergeCounts::default();
        // Batches first, so that their runs can be told which they belong to; their questions last, as they name runs.
        let mut names = HashMap::new();
        let mut batches = Vec::new();
        for (theirs, _) in other.batches()?.into_iter().rev() {
            let (ours, is_new) = self.unite(&theirs)?;
            names.insert(theirs.id.to_string(), ours.to_string());
            batches.push((theirs, ours, is_new));
        }
        let mut numbers: BTreeMap<i64, RunId> = BTreeMap::new();
        for part in other.run_numbers()?.chunks(PART) {
            let mut runs = Vec::with_capacity(part.len());
            for id in part {
                match other.run(RunId(*id))? {
                    Some(run) if run.ending.state == RunState::Running => merged.running += 1,
                    Some(run) => runs.push(run),
                    None => {}
                }
            }
            self.durably(|transaction| {
                for mut run in runs {
                    let theirs = run.id;
                    if let Some(ours) = run.question.batch.as_ref().and_then(|b| names.get(b)) {
                        run.question.batch = Some(ours.clone());
                    }
                    let (id, is_new) = add(transaction, &run)?;
                    numbers.insert(theirs.0, id);
                    merged.runs += usize::from(is_new);
                    merged.already_there += usize::from(!is_new);
                }
                Ok(())
            })?;
        }
        for (theirs, ours, is_new) in batches {
            let items = other.items(theirs.id)?;
            let more = self.add_items(ours, &items, &numbers)?;
            merged.batches += usize::from(is_new);
            merged.united += usize::from(!is_new && more);
        }
        Ok(merged)
    }

    fn run_numbers(&self) -> Result<Vec<i64>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare("SELECT id FROM runs ORDER BY id")?;
        let rows = statement.query_map([], |row| row.get(0))?;
        Ok(rows.collect::<Result<_, _>>()?)
    }

    /// The batch here in which the same is asked as in one of another store, and whether it is new.
    fn unite(&self, theirs: &Batch) -> Result<(BatchId, bool), StoreError> {
        self.durably(|transaction| {
            let found: Option<(i64, Option<String>)> = transaction
                .query_row(
                    "SELECT id, shard FROM batches WHERE spec = ?1 ORDER BY id LIMIT 1",
                    [&theirs.spec],
                    |row| Ok((row.get(0)?, row.get(1)?)),
                )
                .optional()?;
            if let Some((id, shard)) = found {
                let both = both(shard.as_deref(), theirs.shard.as_deref());
                let sql = "UPDATE batches SET shard = ?2, updated_ms = ?3 WHERE id = ?1";
                transaction.execute(sql, params![id, both, now_ms()])?;
                return Ok((BatchId(id), false));
            }
            transaction.execute(
                "INSERT INTO batches (created_ms, updated_ms, spec, shard) VALUES (?1, ?2, ?3, ?4)",
                params![
                    theirs.created_ms,
                    theirs.updated_ms,
                    theirs.spec,
                    theirs.shard
                ],
            )?;
            Ok((BatchId(transaction.last_insert_rowid()), true))
        })
    }

    /// Adds the questions a batch lacks, and outcomes of those it has that are still waiting here.
    fn add_items(
        &self,
        batch: BatchId,
        theirs: &[Item],
        numbers: &BTreeMap<i64, RunId>,
    ) -> Result<bool, StoreError> {
        let ours = self.items(batch)?;
        let places: HashMap<_, _> = ours
            .iter()
            .map(|item| (item.asked.identity(), item))
            .collect();
        let fresh = |item: &&Item| !places.contains_key(&item.asked.identity());
        let new: Vec<_> = theirs.iter().filter(fresh).collect();
        let asked: Vec<_> = new.iter().map(|item| item.asked.clone()).collect();
        let first = ours.last().map_or(0, |last| last.place + 1);
        self.durably(|transaction| insert(transaction, batch, &asked))?;
        let known = theirs.iter().filter_map(|item| {
            let here = places.get(&item.asked.identity())?;
            let better = here.state != ItemState::Answered && item.state == ItemState::Answered;
            better.then_some((here.place, item))
        });
        let states: Vec<_> = (first..).zip(new.iter().copied()).chain(known).collect();
        for (place, item) in &states {
            let run = item.run.and_then(|run| numbers.get(&run.0)).copied();
            let (key, error) = (item.asked.key.as_ref(), item.error.as_deref());
            self.set_item(batch, *place, key, item.state, run, error)?;
        }
        Ok(!states.is_empty())
    }
}

/// The parts that two stores have together; `None` if that is the whole.
fn both(ours: Option<&str>, theirs: Option<&str>) -> Option<String> {
    let mut parts: Vec<&str> = ours?.split(',').chain(theirs?.split(',')).collect();
    let place = |part: &&str| part.split('/').next().and_then(|n| n.parse::<u64>().ok());
    parts.sort_by_key(place);
    parts.dedup();
    let of = parts.first()?.split('/').nth(1)?.parse::<usize>().ok()?;
    (parts.len() < of).then(|| parts.join(","))
}

/// The run here that is the same, else a new one; and whether it is new.
fn add(transaction: &Transaction<'_>, run: &Run) -> Result<(RunId, bool), StoreError> {
    if let Some(id) = there(transaction, run)? {
        return Ok((id, false));
    }
    Ok((insert_whole(transaction, run)?, true))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::items::tests::item;
    use super::*;

    #[test]
    fn parts_become_a_whole() {
        assert_eq!(both(Some("2/3"), Some("1/3")).as_deref(), Some("1/3,2/3"));
        assert_eq!(
            both(Some("1/3,2/3"), Some("2/3")).as_deref(),
            Some("1/3,2/3")
        );
        assert_eq!(both(Some("1/3,2/3"), Some("3/3")), None);
        assert_eq!(both(None, Some("3/3")), None);
    }

    #[test]
    fn batches_with_the_same_questions_are_united() {
        let (here, there) = (Store::in_memory().unwrap(), Store::in_memory().unwrap());
        let ours = here
            .begin_batch("{\"a\":1}", Some("1/2"), &[item("A", 0), item("A", 1)])
            .unwrap();
        there
            .begin_batch("{\"b\":2}", None, &[item("C", 0)])
            .unwrap();
        let theirs = there
            .begin_batch("{\"a\":1}", Some("2/2"), &[item("B", 0), item("A", 1)])
            .unwrap();
        let answered = ItemState::Answered;
        there
            .set_item(theirs, 1, None, answered, None, None)
            .unwrap();
        let merged = here.merge(&there).unwrap();
        assert_eq!((merged.batches, merged.united, merged.runs), (1, 1, 0));
        let items = here.items(ours).unwrap();
        let states: Vec<_> = items
            .iter()
            .map(|i| (i.asked.scenario.as_str(), i.asked.sample, i.state))
            .collect();
        let waiting = ItemState::Waiting;
        let wanted = [("A", 0, waiting), ("A", 1, answered), ("B", 0, waiting)];
        assert_eq!(states, wanted);
        assert_eq!(here.batch(ours).unwrap().unwrap().shard, None);
        let again = here.merge(&there).unwrap();
        assert_eq!((again.batches, again.united, again.runs), (0, 0, 0));
        assert_eq!(here.items(ours).unwrap(), items);
    }

    #[test]
    fn changed_scenes_and_leads_are_questions_of_their_own() {
        let (here, there) = (Store::in_memory().unwrap(), Store::in_memory().unwrap());
        let ours = here.begin_batch("{}", None, &[item("A", 0)]).unwrap();
        let mut mirrored = item("A", 0);
        mirrored.transform = Some("mirror".into());
        let mut early = item("A", 0);
        early.lead = Some("1".into());
        let theirs = [item("A", 0), mirrored, early];
        there.begin_batch("{}", None, &theirs).unwrap();
        here.merge(&there).unwrap();
        let items = here.items(ours).unwrap();
        let asked: Vec<_> = items.into_iter().map(|item| item.asked).collect();
        assert_eq!(asked, theirs);
    }
}
