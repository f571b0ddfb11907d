//! Merges another store's runs and batches: shards asked on several machines become one batch.

use super::{Intake, RunId, Store, StoreError};

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
        let mut intake = Intake::new(self);
        let batches = other.batches()?;
        for (theirs, _) in batches.iter().rev() {
            intake.batch(theirs)?;
        }
        for hash in other.image_hashes()? {
            if let Some(image) = other.image(&hash)? {
                intake.image(&image)?;
            }
        }
        for part in other.run_numbers()?.chunks(PART) {
            let runs = part.iter().map(|id| other.run(RunId(*id)));
            let runs: Vec<_> = runs.collect::<Result<_, _>>()?;
            intake.runs(runs.into_iter().flatten().collect())?;
        }
        for (theirs, _) in batches.iter().rev() {
            intake.items(theirs.id, &other.items(theirs.id)?)?;
        }
        Ok(intake.counts())
    }

    fn run_numbers(&self) -> Result<Vec<i64>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare("SELECT id FROM runs ORDER BY id")?;
        let rows = statement.query_map([], |row| row.get(0))?;
        Ok(rows.collect::<Result<_, _>>()?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::ItemState;
    use super::super::items::tests::item;
    use super::*;

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

    #[test]
    fn looks_at_a_test_split_come_along_once() {
        let (here, there) = (Store::in_memory().unwrap(), Store::in_memory().unwrap());
        let ours = here.begin_batch("{}", None, &[item("A", 0)]).unwrap();
        let theirs = there.begin_batch("{}", None, &[item("A", 0)]).unwrap();
        there.record_look(theirs, Default::default()).unwrap();
        here.merge(&there).unwrap();
        here.merge(&there).unwrap();
        assert_eq!(here.looks(ours).unwrap(), there.looks(theirs).unwrap());
    }
}
