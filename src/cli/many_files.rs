//! Commands that work on many files: one part of them, the job over them, and continuing a run that was killed.

use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use nearmiss_base::system;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_study::evaluation::batch::Shard;
pub use nearmiss_workflow::journal::holds;
use nearmiss_workflow::journal::{
    EarlierRun, FOLDER, JobIdentity, Journal, RunSettings, input_hash,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::output::Progress;
use super::{Failure, Outcome, output};

/// One part of the scenarios.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ShardOption {
    /// Process only part I of N of the scenarios, such as 2/8; the scenario name decides the part.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
}

/// One part of the scenarios, and continuing.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ManyFiles {
    #[command(flatten)]
    pub part: ShardOption,
    /// Resume a run in the folder of -o, or start one that can be resumed. Finished files are kept; those of changed
    /// scenarios are written again.
    #[arg(long, requires = "output")]
    pub resume: bool,
}

impl ShardOption {
    /// The scenarios of this part; an empty part is said.
    pub fn of(self, mut entries: Vec<Entry>) -> Vec<Entry> {
        let Some(shard) = self.shard else {
            return entries;
        };
        entries.retain(|entry| shard.has(&entry.name));
        if entries.is_empty() {
            output::say(&format!("nearmiss: part {shard} has no scenarios"));
        }
        entries
    }
}

impl ManyFiles {
    /// Opens the journal of finished files in the folder of -o, if --resume is given.
    ///
    /// # Errors
    /// The output is no folder, or its journal belongs to another run.
    pub fn journal(
        &self,
        command: &'static str,
        folder: Option<&Path>,
        settings: &impl Serialize,
    ) -> Result<RunJournal, Failure> {
        if !self.resume {
            return Ok(RunJournal::none());
        }
        let folder = folder.ok_or_else(|| Failure::input("--resume needs a folder: -o FOLDER"))?;
        let shard = self.part.shard;
        let journal = open_journal(folder, command, shard, settings, EarlierRun::Continue)?;
        Ok(RunJournal::new(journal, folder))
    }
}

/// How soon an interrupt is noticed while nothing is finished.
const POLL: Duration = Duration::from_millis(50);

/// What comes after a result was taken: the next one, or the end.
pub type Taken = Result<ControlFlow<()>, Failure>;

/// The next result is wanted.
pub const NEXT: Taken = Ok(ControlFlow::Continue(()));

/// How many things are worked on.
pub struct Job<'a> {
    what: &'static str,
    to_file: bool,
    keeps: bool,
    stop: &'a AtomicBool,
}

/// How far a job came.
#[derive(Debug)]
#[must_use = "`end` tells how it ended"]
pub struct Done {
    /// Results that were taken.
    pub count: usize,
    of: usize,
    what: &'static str,
    failure: Option<Failure>,
    /// It was stopped before all was done.
    pub interrupted: bool,
}

/// How many of several scenarios could not be done.
#[derive(Debug)]
pub struct Failed {
    of: usize,
    /// So many.
    pub count: usize,
    last: Option<Failure>,
}

impl<'a> Job<'a> {
    /// Work on things that the progress bar calls `what`, until `stop` becomes true.
    pub fn new(what: &'static str, stop: &'a AtomicBool) -> Self {
        Self {
            what,
            to_file: true,
            keeps: false,
            stop,
        }
    }

    /// The same, which may write to standard output, where no bar must stand: see [`Progress::new`].
    pub fn writing_file(self, to_file: bool) -> Self {
        Self { to_file, ..self }
    }

    /// The same for work that takes so long that nothing finished may be lost: when it is stopped, what is being worked
    /// on is waited for, and all results are taken that there are. Some before them may be missing then.
    pub fn keeping_finished(self) -> Self {
        Self {
            keeps: true,
            ..self
        }
    }

    /// Does `work` for each item on rayon's threads and hands the results to `take` on this one, in order, while the
    /// progress bar is away. Work that was cut short gives nothing.
    ///
    /// Ends early when `take` fails or breaks, or the job is stopped; what is being worked on then is finished and
    /// dropped.
    pub fn run<'i, I: Sync, T: Send>(
        &self,
        items: &'i [I],
        work: impl Fn(&'i I) -> Option<T> + Sync,
        mut take: impl FnMut(&'i I, T) -> Taken,
    ) -> Done {
        let progress = Progress::new(items.len(), self.what, self.to_file);
        let (mut count, mut failure) = (0, None);
        let work = |i: usize| Some((i, work(&items[i])?));
        in_order(items.len(), self.stop, self.keeps, work, |result| {
            let Some((i, result)) = result else {
                return ControlFlow::Continue(());
            };
            count += 1;
            let mut taken = NEXT;
            progress.suspend(|| taken = take(&items[i], result));
            progress.step();
            taken.unwrap_or_else(|error| {
                failure = Some(error);
                ControlFlow::Break(())
            })
        });
        Done {
            count,
            of: items.len(),
            what: self.what,
            failure,
            interrupted: self.stop.load(Ordering::Relaxed) && count < items.len(),
        }
    }
}

impl Done {
    /// The same, unless it failed.
    pub fn or_failure(mut self) -> Result<Self, Failure> {
        self.failure.take().map_or(Ok(self), Err)
    }

    /// That it failed or was interrupted, if so; `kept` says what that leaves, and how it goes on.
    pub fn end(self, kept: &str) -> Outcome {
        match self.failure {
            Some(failure) => Err(failure),
            None if self.interrupted => {
                let done = format!(" after {} of {} {}", self.count, self.of, self.what);
                Err(Failure::interrupted_after(&done, kept))
            }
            None => Ok(()),
        }
    }
}

impl Failed {
    /// None yet of so many.
    pub fn of(of: usize) -> Self {
        Self {
            of,
            count: 0,
            last: None,
        }
    }

    /// One more; of several scenarios it is said at once.
    pub fn add(&mut self, failure: Failure) {
        if self.of > 1 {
            failure.say();
        }
        self.count += 1;
        self.last = Some(failure);
    }

    /// Whether nothing could be done.
    pub fn all(&self) -> bool {
        self.count == self.of
    }

    /// How the command ends; `done` says what is done with scenarios: measured.
    pub fn end(self, done: &str) -> Outcome {
        match (self.count, self.last) {
            (0, _) => Ok(()),
            (_, Some(only)) if self.of == 1 => Err(only),
            (count, _) if count == self.of => {
                Err(Failure::input(format!("no scenario could be {done}")))
            }
            (count, _) => Err(Failure::finding(format!(
                "{count} of {} scenarios could not be {done}",
                self.of
            ))),
        }
    }
}

/// Does `work` for `0..count` on rayon's threads, a bounded number ahead, and hands the results to `take` in order.
fn in_order<T: Send>(
    count: usize,
    stop: &AtomicBool,
    keep: bool,
    work: impl Fn(usize) -> T + Sync,
    mut take: impl FnMut(T) -> ControlFlow<()>,
) {
    let ahead = 2 * rayon::current_num_threads() + 2;
    let (work, given_up) = (&work, &AtomicBool::new(false));
    let stopped = move || stop.load(Ordering::Relaxed) || given_up.load(Ordering::Relaxed);
    rayon::in_place_scope(|scope| {
        let mut waiting = VecDeque::new();
        let mut next = 0..count;
        loop {
            while waiting.len() < ahead
                && let Some(i) = next.next()
            {
                let (sender, receiver) = sync_channel(1);
                scope.spawn(move |_| {
                    if !stopped() {
                        // The receiver is gone after an early end.
                        let _ = sender.send(work(i));
                    }
                });
                waiting.push_back(receiver);
            }
            let Some(first) = waiting.pop_front() else {
                return;
            };
            let result = loop {
                match first.recv_timeout(POLL) {
                    Ok(result) if keep || !stopped() => break result,
                    Err(RecvTimeoutError::Timeout) if !stopped() => {}
                    _ if keep => {
                        let left = std::iter::once(first).chain(waiting);
                        // Those that were not begun hang up.
                        let finished = left.filter_map(|one| one.recv().ok());
                        let _ = finished.map(&mut take).find(ControlFlow::is_break);
                        return;
                    }
                    _ => return,
                }
            };
            if take(result).is_break() {
                given_up.store(true, Ordering::Relaxed);
                return;
            }
        }
    });
}

/// What earlier runs have finished; nothing without --resume.
pub struct RunJournal(Option<(Journal, PathBuf)>);

/// A scenario of a run that may be continued.
pub enum Unit<N, T> {
    /// An earlier run has finished it, and noted this.
    Kept(N),
    /// It was worked on, and is to be written.
    New(T, Earlier),
}

/// What an earlier run has of a scenario that is to be written.
#[derive(Default)]
pub struct Earlier {
    inputs: Vec<String>,
    /// Files that an earlier run wrote, which may be replaced as long as nothing else has changed them.
    own: Vec<PathBuf>,
}

/// Opens the journal of a command in a folder; its errors are those of input.
pub fn open_journal(
    folder: &Path,
    command: &'static str,
    shard: Option<Shard>,
    settings: &impl Serialize,
    earlier: EarlierRun,
) -> Result<Journal, Failure> {
    let job = JobIdentity {
        command,
        shard,
        settings: RunSettings::new(settings).map_err(Failure::input)?,
    };
    Journal::open(folder, &job, earlier).map_err(Failure::input)
}

impl RunJournal {
    /// None: every scenario is done.
    pub fn none() -> Self {
        Self(None)
    }

    /// That in the folder of the run.
    pub fn new(journal: Journal, folder: &Path) -> Self {
        Self(Some((journal, folder.to_path_buf())))
    }

    /// The folder of the run, if it is one that can be continued.
    pub fn folder(&self) -> Option<&Path> {
        self.0.as_ref().map(|(_, folder)| folder.as_path())
    }

    /// What earlier runs have noted of all scenarios.
    pub fn notes<N: DeserializeOwned>(&self) -> impl Iterator<Item = N> {
        let journal = self.0.iter().map(|(journal, _)| journal);
        let units = journal.flat_map(Journal::units);
        units.filter_map(|unit| N::deserialize(&unit.notes).ok())
    }

    /// Does `work` for a scenario unless an earlier run has finished it; nothing where it was cut short. One that cannot
    /// be read is not finished.
    ///
    /// # Errors
    /// The notes of an earlier run are not those of this command.
    pub fn unit<N: DeserializeOwned, T>(
        &self,
        entry: &Entry,
        work: impl FnOnce() -> Option<T>,
    ) -> Option<Result<Unit<N, T>, Failure>> {
        let mut earlier = Earlier::default();
        if let Some((journal, folder)) = &self.0 {
            let place = entry.display();
            let hash = entry.content_hash().ok();
            earlier.inputs = Vec::from_iter(hash.map(|hash| input_hash(&place, &hash)));
            if let Some(unit) = journal.finished(&place) {
                if !earlier.inputs.is_empty() && unit.inputs == earlier.inputs {
                    let notes = N::deserialize(&unit.notes);
                    return Some(notes.map(Unit::Kept).map_err(|why| {
                        Failure::input(format!("the notes of an earlier run cannot be read: {why}"))
                    }));
                }
                earlier.own = unit.files.keys().map(|file| folder.join(file)).collect();
            }
        }
        Some(Ok(Unit::New(work()?, earlier)))
    }

    /// Writes a scenario's files with `write`, which gives them and what is to be noted, and adds it to the journal. The
    /// files of an earlier run of a scenario that has changed since are removed before. A scenario that could not be
    /// read is not kept as finished.
    pub fn write<N: Serialize>(
        &self,
        entry: &Entry,
        earlier: Earlier,
        write: impl FnOnce() -> Result<(Vec<PathBuf>, N), Failure>,
    ) -> Result<N, Failure> {
        for path in &earlier.own {
            std::fs::remove_file(path).map_err(|e| Failure::system(path.display(), &e))?;
        }
        let (files, notes) = write()?;
        let Some((journal, folder)) = self.0.as_ref().filter(|_| !earlier.inputs.is_empty()) else {
            return Ok(notes);
        };
        let inside = |path: &PathBuf| path.strip_prefix(folder).map(Path::to_path_buf).ok();
        let files: Vec<PathBuf> = files.iter().filter_map(inside).collect();
        let kept = serde_json::to_value(&notes).map_err(Failure::input)?;
        journal
            .add(&entry.display(), earlier.inputs, &files, kept)
            .map_err(Failure::input)?;
        Ok(notes)
    }

    /// Whether a file is the table that a run in this folder wrote, unchanged.
    pub fn wrote_table(&self, file: &Path) -> bool {
        let noted = self
            .note_of(file)
            .and_then(|note| std::fs::read_to_string(note).ok());
        let is = system::read_file(file, system::LARGEST)
            .map(|bytes| ContentHash::digest(&bytes).to_string());
        matches!((noted, is), (Some(noted), Ok(is)) if noted.trim() == is)
    }

    /// Notes that a file is the table of this run, so that it may be replaced when the run is continued.
    pub fn note_table(&self, file: &Path) -> Outcome {
        let Some(note) = self.note_of(file) else {
            return Ok(());
        };
        let bytes = system::read_file(file, system::LARGEST)
            .map_err(|e| Failure::system(file.display(), &e))?;
        let hash = format!("{}\n", ContentHash::digest(&bytes));
        std::fs::write(&note, hash).map_err(|e| Failure::system(note.display(), &e))
    }

    /// Where the hash of a table is noted.
    fn note_of(&self, file: &Path) -> Option<PathBuf> {
        let full = file.canonicalize().ok()?;
        let hash = ContentHash::digest(full.to_string_lossy().as_bytes()).to_string();
        let name = format!("table-{}.sha256", &hash[..16]);
        Some(self.folder()?.join(FOLDER).join(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    #[test]
    fn results_come_in_order_and_not_too_far_ahead() {
        let (begun, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
        let mut taken = Vec::new();
        let work = |i: usize| {
            begun.fetch_add(1, Ordering::SeqCst);
            // Later ones are faster.
            std::thread::sleep(Duration::from_micros(500 - 2 * i as u64));
            i
        };
        let ahead = 2 * rayon::current_num_threads() + 2;
        in_order(200, &stop, false, work, |i| {
            taken.push(i);
            assert!(begun.load(Ordering::SeqCst) <= i + 1 + ahead);
            ControlFlow::Continue(())
        });
        assert_eq!(taken, (0..200).collect::<Vec<_>>());
        in_order(
            0,
            &stop,
            false,
            |i| i,
            |_| unreachable!("there is nothing to do"),
        );
    }

    #[test]
    fn what_is_finished_when_it_is_stopped_is_kept_if_that_is_wanted() {
        let stop = AtomicBool::new(false);
        let finished = AtomicUsize::new(0);
        let work = |i: usize| {
            if i == 1 {
                std::thread::sleep(Duration::from_millis(20));
                stop.store(true, Ordering::SeqCst);
            }
            finished.fetch_add(1, Ordering::SeqCst);
            i
        };
        let mut taken = Vec::new();
        in_order(1000, &stop, true, work, |i| {
            taken.push(i);
            ControlFlow::Continue(())
        });
        assert_eq!(taken.len(), finished.load(Ordering::SeqCst));
        assert!(taken.contains(&1) && taken.is_sorted() && taken.len() < 1000);
    }

    #[test]
    fn ends_early_when_told_to() {
        let begun = AtomicUsize::new(0);
        let work = |i| {
            begun.fetch_add(1, Ordering::SeqCst);
            i
        };
        let mut taken = 0;
        in_order(100_000, &AtomicBool::new(false), false, work, |_| {
            taken += 1;
            match taken {
                3 => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        });
        assert_eq!(taken, 3);
        assert!(begun.load(Ordering::SeqCst) < 100_000);
        in_order(9, &AtomicBool::new(true), false, work, |_| {
            unreachable!("it was stopped before it began")
        });
    }
}
