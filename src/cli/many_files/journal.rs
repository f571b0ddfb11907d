//! The journal of a command over many files: a scenario that an earlier run has finished is not done again.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::{Failure, Outcome};
use nearmiss_base::system;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_study::evaluation::batch::Shard;
use nearmiss_workflow::journal::{
    EarlierRun, FOLDER, JobIdentity, Journal, RunSettings, input_hash,
};

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

/// Whether a file holds these bytes already: a run that was killed had just written it.
pub fn holds(path: &Path, bytes: &[u8]) -> bool {
    system::read_file(path, system::LARGEST).is_ok_and(|found| found == bytes)
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
