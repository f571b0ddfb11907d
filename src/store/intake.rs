//! Takes in runs: those of another store, from its file or an export, and answers kept in files until the store is writable.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::Write;
use std::path::{Path, PathBuf};

use nearmiss_base::system;
use rusqlite::{OptionalExtension, Transaction, params};

use super::database::{all_rows, now_ms};
use super::items::insert;
use super::run::{self, insert_whole, there};
use super::{
    AnswerPiece, Batch, BatchId, Ending, Item, ItemState, NewRun, Origin, Run, RunId, RunState,
    Store, StoreError, StoredImage,
};

/// What is being taken in: batches first, so that their runs can be told which they belong to, then runs, and the
/// questions of the batches last, as they name runs.
pub struct Intake<'a> {
    store: &'a Store,
    /// The batches here, by the names that they have there, and which of them are new.
    batches: HashMap<String, (BatchId, bool)>,
    /// The runs here, by their numbers there.
    runs: BTreeMap<i64, RunId>,
    counts: MergeCounts,
}

impl<'a> Intake<'a> {
    /// Nothing so far.
    #[must_use]
    pub fn new(store: &'a Store) -> Self {
        Self {
            store,
            batches: HashMap::new(),
            runs: BTreeMap::new(),
            counts: MergeCounts::default(),
        }
    }

    /// What was taken in so far.
    #[must_use]
    pub fn counts(&self) -> MergeCounts {
        self.counts
    }

    /// Takes in a batch: into the one here in which the same is asked, unless another batch was taken into that, else
    /// as a new one.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn batch(&mut self, theirs: &Batch) -> Result<(), StoreError> {
        let taken: Vec<BatchId> = self.batches.values().map(|(id, _)| *id).collect();
        let found = self.store.unite(theirs, &taken)?;
        self.found(theirs, found)
    }

    /// Takes in an image.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn image(&mut self, image: &StoredImage) -> Result<(), StoreError> {
        self.store.keep_image(image)
    }

    /// Takes in a batch of a bundle: into this one here, which then has the parts of both, else as a new one, with the
    /// number that it has there where that is free. Returns its number here.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn batch_as(
        &mut self,
        theirs: &Batch,
        ours: Option<BatchId>,
    ) -> Result<BatchId, StoreError> {
        let (id, is_new) = match ours {
            Some(ours) => {
                self.store.add_parts(ours, theirs.shard.as_deref())?;
                (ours, false)
            }
            None => (self.store.add_batch(theirs)?, true),
        };
        self.found(theirs, (id, is_new))?;
        Ok(id)
    }

    /// The run here that was taken in as this one; `None` if it was not.
    #[must_use]
    pub fn run(&self, theirs: RunId) -> Option<RunId> {
        self.runs.get(&theirs.0).copied()
    }

    /// Notes where a batch is here, and takes in the looks at its test split, each once.
    fn found(&mut self, theirs: &Batch, found: (BatchId, bool)) -> Result<(), StoreError> {
        if !theirs.looks.is_empty() {
            self.store.add_looks(found.0, &theirs.looks)?;
        }
        self.counts.batches += usize::from(found.1);
        self.batches.insert(theirs.id.to_string(), found);
        Ok(())
    }

    /// Takes in runs, in one transaction; each once.
    ///
    /// # Errors
    /// SQLite refused. None is taken in then.
    pub fn runs(&mut self, runs: Vec<Run>) -> Result<(), StoreError> {
        let (batches, numbers, counts) = (&self.batches, &mut self.runs, &mut self.counts);
        self.store.durably(|transaction| {
            for mut run in runs {
                if run.ending.state == RunState::Running {
                    counts.running += 1;
                    continue;
                }
                let theirs = run.id;
                let batch = run.question.batch.as_ref().and_then(|b| batches.get(b));
                if let Some((ours, _)) = batch {
                    run.question.batch = Some(ours.to_string());
                }
                let (id, is_new) = match there(transaction, &run)? {
                    Some(id) => (id, false),
                    None => (insert_whole(transaction, &run)?, true),
                };
                numbers.insert(theirs.0, id);
                counts.runs += usize::from(is_new);
                counts.already_there += usize::from(!is_new);
            }
            Ok(())
        })
    }

    /// Takes in the questions of a batch: those that the one here lacks, and what became of those that are still waiting
    /// here.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn items(&mut self, batch: BatchId, items: &[Item]) -> Result<(), StoreError> {
        let Some(&(ours, is_new)) = self.batches.get(&batch.to_string()) else {
            return Ok(());
        };
        let more = self.store.add_items(ours, items, &self.runs)?;
        self.counts.united += usize::from(!is_new && more);
        Ok(())
    }
}

impl Store {
    /// Adds a batch without its questions, with its own number if that is free.
    fn add_batch(&self, theirs: &Batch) -> Result<BatchId, StoreError> {
        self.durably(|transaction| {
            transaction.execute(
                "INSERT INTO batches (id, created_ms, updated_ms, spec, shard)
                 VALUES (CASE WHEN EXISTS (SELECT 1 FROM batches WHERE id = ?1) THEN NULL ELSE ?1 END, ?2, ?3, ?4, ?5)",
                params![
                    theirs.id.0,
                    theirs.created_ms,
                    theirs.updated_ms,
                    theirs.spec,
                    theirs.shard
                ],
            )?;
            Ok(BatchId(transaction.last_insert_rowid()))
        })
    }

    /// Notes that these parts of a batch are here, too.
    fn add_parts(&self, batch: BatchId, theirs: Option<&str>) -> Result<(), StoreError> {
        self.durably(|transaction| {
            let sql = "SELECT shard FROM batches WHERE id = ?1";
            let ours: Option<String> = transaction.query_row(sql, [batch.0], |row| row.get(0))?;
            let both = both(ours.as_deref(), theirs);
            if both != ours {
                let sql = "UPDATE batches SET shard = ?2, updated_ms = ?3 WHERE id = ?1";
                transaction.execute(sql, params![batch.0, both, now_ms()])?;
            }
            Ok(())
        })
    }

    /// The batch here in which the same is asked as in one of another store, leaving aside those that are `taken`, and
    /// whether it is new. Of several the one that was begun at the same time counts first.
    fn unite(&self, theirs: &Batch, taken: &[BatchId]) -> Result<(BatchId, bool), StoreError> {
        self.durably(|transaction| {
            let sql = "SELECT id, shard FROM batches WHERE spec = ?1 ORDER BY created_ms <> ?2, id";
            let values = params![theirs.spec, theirs.created_ms];
            let rows = all_rows(transaction, sql, values, |row| {
                Ok((BatchId(row.get(0)?), row.get::<_, Option<String>>(1)?))
            })?;
            if let Some((id, shard)) = rows.into_iter().find(|(id, _)| !taken.contains(id)) {
                let both = both(shard.as_deref(), theirs.shard.as_deref());
                let sql = "UPDATE batches SET shard = ?2, updated_ms = ?3 WHERE id = ?1";
                transaction.execute(sql, params![id.0, both, now_ms()])?;
                return Ok((id, false));
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
            let better = match here.state {
                ItemState::Answered => false,
                ItemState::Waiting => item.state != ItemState::Waiting,
                _ => item.state == ItemState::Answered,
            };
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

/// The parts that two stores have together, such as `1/4,3/4`; `None` if that is the whole.
fn both(ours: Option<&str>, theirs: Option<&str>) -> Option<String> {
    let parts = ours?.split(',').chain(theirs?.split(','));
    let numbers = parts.filter_map(|part| {
        let (number, of) = part.split_once('/')?;
        Some((of.parse::<u64>().ok()?, number.parse::<u64>().ok()?))
    });
    let parts: BTreeSet<(u64, u64)> = numbers.collect();
    let has_all = |of: u64| parts.range((of, 0)..=(of, u64::MAX)).count() as u64 == of;
    if parts.iter().any(|(of, _)| has_all(*of)) {
        return None;
    }
    let words: Vec<String> = parts.iter().map(|(of, n)| format!("{n}/{of}")).collect();
    Some(words.join(","))
}

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
const RUNS_AT_ONCE: usize = 200;

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
        for part in other.run_numbers()?.chunks(RUNS_AT_ONCE) {
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
        self.rows("SELECT id FROM runs ORDER BY id", [], |row| row.get(0))
    }
}

/// How the names of the files begin and end.
const NAME: (&str, &str) = ("unstored-", ".jsonl");

/// More bytes than such a file has.
const MAX_BYTES: u64 = 64 << 20;

/// An answer that arrived and is not in the store.
#[derive(Debug)]
pub struct UnstoredAnswer {
    /// Why the store does not have it.
    pub why: StoreError,
    /// The file that it was written to; `None` if none could be written.
    pub file: Option<PathBuf>,
    /// Whether that file is taken in by itself when the store is opened again.
    pub beside: bool,
}

impl std::fmt::Display for UnstoredAnswer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the answer could not be stored: {}; ", self.why)?;
        match &self.file {
            Some(file) if self.beside => write!(
                f,
                "saved to {}; it is imported when the store is writable again",
                file.display()
            ),
            Some(file) => write!(
                f,
                "saved to {0}; run `nearmiss runs import {0}` when the store is writable again",
                file.display()
            ),
            None => f.write_str("it could not be saved to a file either; free disk space"),
        }
    }
}

impl Store {
    /// [`Store::conclude`]s a run of which some pieces may be stored already: these are its whole texts.
    ///
    /// # Errors
    /// SQLite refused; no data is written.
    pub fn conclude_whole(
        &self,
        run: RunId,
        reasoning: &str,
        answer: &str,
        ending: &Ending,
    ) -> Result<(), StoreError> {
        self.durably(|transaction| conclude_whole(transaction, run, reasoning, answer, ending))
    }

    /// Keeps an answer that the store cannot have, as a line that `nearmiss runs import` reads: beside the store, else in
    /// the folder for temporary files. With the rounds of its tool calls, JSON, if it has some.
    #[must_use]
    pub fn set_aside(
        &self,
        id: RunId,
        question: &NewRun,
        (reasoning, answer): (&str, &str),
        ending: &Ending,
        tool_rounds: Option<String>,
        why: StoreError,
    ) -> UnstoredAnswer {
        let now = now_ms();
        let verdict = ending.verdict.as_ref();
        let run = Run {
            id,
            created_ms: now,
            updated_ms: now,
            key: question.key(),
            origin: Origin::Asked,
            source: None,
            question: question.clone(),
            answer: answer.to_owned(),
            reasoning: reasoning.to_owned(),
            ending: ending.clone(),
            verdict_json: verdict.and_then(|said| serde_json::to_string(said).ok()),
            tool_rounds,
            most_usd: None,
            notes: String::new(),
            pinned: false,
            deleted_ms: None,
        };
        let line = nearmiss_record::json_line(&run.to_record(false)).unwrap_or_default();
        let name = format!("{}{id}-{now}{}", NAME.0, NAME.1);
        let written = |folder: &Path| save(&folder.join(&name), &line).ok();
        let beside = self.folder().as_deref().and_then(written);
        UnstoredAnswer {
            why,
            beside: beside.is_some(),
            file: beside.or_else(|| written(&std::env::temp_dir())),
        }
    }

    /// Takes in the answers that were set aside beside the store. What cannot be taken in stays where it is.
    pub(super) fn take_in(&self) {
        let Some(files) = self.folder().and_then(|f| std::fs::read_dir(f).ok()) else {
            return;
        };
        for file in files.flatten() {
            let os_name = file.file_name();
            let name = os_name.to_string_lossy();
            if !(name.starts_with(NAME.0) && name.ends_with(NAME.1)) {
                continue;
            }
            let path = file.path();
            let Ok(line) = system::read_text(&path, MAX_BYTES) else {
                continue;
            };
            let Ok(run) = Run::from_record(line.trim()) else {
                continue;
            };
            if self.restore(&run).is_ok() {
                // Taken in twice, it would be found to be there.
                let _ = std::fs::remove_file(path);
            }
        }
    }

    /// Ends the run that an answer belongs to, where it is still open here; else adds it.
    fn restore(&self, run: &Run) -> Result<(), StoreError> {
        let open = self.durably(|transaction| {
            let key = run.key.as_ref().map(super::Key::as_str);
            let sql = "SELECT 1 FROM runs WHERE id = ?1 AND key IS ?2 AND sample = ?3
                AND state IN ('running', 'interrupted')";
            let values = params![run.id.0, key, run.question.sample];
            let open = transaction.query_row(sql, values, |_| Ok(())).optional()?;
            if open.is_some() {
                conclude_whole(
                    transaction,
                    run.id,
                    &run.reasoning,
                    &run.answer,
                    &run.ending,
                )?;
            }
            Ok(open.is_some())
        })?;
        if !open {
            self.add(std::slice::from_ref(run))?;
        }
        Ok(())
    }

    /// The folder of the store's file; `None` for a store in memory.
    fn folder(&self) -> Option<PathBuf> {
        let connection = self.lock();
        let file = connection.path().filter(|path| !path.is_empty())?;
        Path::new(file).parent().map(Path::to_path_buf)
    }
}

fn conclude_whole(
    transaction: &Transaction<'_>,
    run: RunId,
    reasoning: &str,
    answer: &str,
    ending: &Ending,
) -> Result<(), StoreError> {
    transaction.execute("DELETE FROM pieces WHERE run = ?1", [run.0])?;
    let sql = "UPDATE runs SET answer = '', reasoning = '' WHERE id = ?1";
    transaction.execute(sql, [run.0])?;
    let pieces = [
        AnswerPiece::Reasoning(reasoning),
        AnswerPiece::Answer(answer),
    ];
    run::conclude(transaction, run, &pieces, ending)
}

/// Writes a file whole or not at all, for its owner alone.
fn save(path: &Path, line: &str) -> std::io::Result<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(line.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(path.to_path_buf())
}

#[cfg(test)]
#[path = "unstored_tests.rs"]
mod unstored_tests;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::ItemState;
    use super::both;
    use super::*;
    use crate::items::tests::item;

    #[test]
    fn parts_become_a_whole() {
        assert_eq!(both(Some("2/3"), Some("1/3")).as_deref(), Some("1/3,2/3"));
        assert_eq!(
            both(Some("1/3,2/3"), Some("2/3")).as_deref(),
            Some("1/3,2/3")
        );
        assert_eq!(both(Some("1/3,2/3"), Some("3/3")), None);
        assert_eq!(both(None, Some("3/3")), None);
        let mixed = both(Some("1/3,2/3"), Some("2/4"));
        assert_eq!(mixed.as_deref(), Some("1/3,2/3,2/4"), "of two divisions");
        assert_eq!(both(mixed.as_deref(), Some("3/3")), None);
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
