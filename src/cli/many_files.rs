//! Options of commands that work on many files: one part of them, and continuing a run that was killed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use super::plan::FinishedDrive;
use super::{Failure, output};
use nearmiss_base::system;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_study::evaluation::batch::Shard;
use nearmiss_workflow::journal::{
    EarlierRun, FOLDER, FinishedUnit, JobIdentity, Journal, JournalError, input_hash,
};

/// One part of the scenarios.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ShardOption {
    /// Only this part of the scenarios, such as 2/8; the name decides the part.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
}

/// One part of the scenarios, and continuing.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ManyFiles {
    #[command(flatten)]
    pub part: ShardOption,
    /// Continue in the folder of -o where a run with --resume was stopped or killed, or begin one: finished files are
    /// kept, those of changed scenarios are made again.
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

/// The files of each scenario that an interrupted run has finished.
pub struct FinishedFiles {
    journal: Journal,
    folder: PathBuf,
}

/// The input of a scenario, and whether its files are there.
pub struct Progressed {
    inputs: Vec<String>,
    /// What is known of the scenario, if it is finished.
    pub finished: Option<Value>,
    /// Files that an earlier run wrote, which may be replaced as long as nothing else has changed them.
    own: Vec<PathBuf>,
}

impl ManyFiles {
    /// Opens the record of finished files in the folder of -o, if --resume is given.
    ///
    /// # Errors
    /// The output is no folder, or its record belongs to another run.
    pub fn finished_files(
        &self,
        command: &'static str,
        folder: Option<&Path>,
        (settings, named): (String, BTreeMap<String, String>),
    ) -> Result<Option<FinishedFiles>, Failure> {
        if !self.resume {
            return Ok(None);
        }
        let folder = folder.ok_or_else(|| Failure::input("--resume needs a folder: -o FOLDER"))?;
        let job = JobIdentity {
            command,
            shard: self.part.shard,
            settings,
            named,
        };
        let journal = opened(folder, &job, EarlierRun::Continue)?;
        Ok(Some(FinishedFiles {
            journal,
            folder: folder.to_path_buf(),
        }))
    }
}

/// Whether a file holds these bytes already: a run that was killed had just written it.
pub fn holds(path: &Path, bytes: &[u8]) -> bool {
    system::read_file(path, system::LARGEST).is_ok_and(|found| found == bytes)
}

/// Opens a journal; its errors are those of input.
pub fn opened(folder: &Path, job: &JobIdentity, earlier: EarlierRun) -> Result<Journal, Failure> {
    Journal::open(folder, job, earlier).map_err(Failure::input)
}

impl FinishedFiles {
    /// Whether the planner's process is still the one that drove what is finished.
    ///
    /// # Errors
    /// It has another name or version now. A planner that cannot be asked is compared where it drives: nowhere.
    pub fn by_same_planner(
        &self,
        now: impl FnOnce() -> Option<(String, String)>,
    ) -> Result<(), Failure> {
        let of = |unit: &FinishedUnit| {
            let drive = FinishedDrive::deserialize(&unit.notes).ok()?.document;
            let process = drive.external_planner?;
            Some((process.name, process.version)).filter(|(name, _)| !name.is_empty())
        };
        let mut then: Vec<(String, String)> = self.journal.units().filter_map(of).collect();
        then.sort();
        then.dedup();
        if then.is_empty() {
            return Ok(());
        }
        let Some(now) = now() else {
            return Ok(());
        };
        match then.iter().find(|then| **then != now) {
            None => Ok(()),
            Some(then) => Err(Failure::input(output::visible(&format!(
                "{}: the drives in this folder are of planner {}, which is {} now; choose another folder, or leave out --resume and start again with --overwrite",
                self.folder.display(),
                format!("{} {}", then.0, then.1).trim(),
                format!("{} {}", now.0, now.1).trim()
            )))),
        }
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
    pub fn note_table(&self, file: &Path) -> Result<(), Failure> {
        let failed = |e: &std::io::Error| Failure::system(file.display(), e);
        let bytes = system::read_file(file, system::LARGEST).map_err(|e| failed(&e))?;
        let Some(note) = self.note_of(file) else {
            return Ok(());
        };
        let hash = format!("{}\n", ContentHash::digest(&bytes));
        std::fs::write(&note, hash).map_err(|e| Failure::system(note.display(), &e))
    }

    /// Where the hash of a table is noted.
    fn note_of(&self, file: &Path) -> Option<PathBuf> {
        let whole = file.canonicalize().ok()?;
        let hash = ContentHash::digest(whole.to_string_lossy().as_bytes()).to_string();
        let name = format!("table-{}.sha256", &hash[..16]);
        Some(self.folder.join(FOLDER).join(name))
    }

    /// The folder of the run.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What is known of a scenario. One that cannot be read is not finished.
    pub fn of(&self, entry: &Entry) -> Progressed {
        let hash = entry.content_hash().ok();
        let inputs: Vec<String> = hash
            .map(|hash| input_hash(&entry.display(), &hash))
            .into_iter()
            .collect();
        let known = self.journal.finished(&entry.display());
        let same = |unit: &&FinishedUnit| !inputs.is_empty() && unit.inputs == inputs;
        Progressed {
            finished: known.filter(same).map(|unit| unit.notes.clone()),
            own: known
                .map(|unit| unit.files.keys().map(|f| self.folder.join(f)).collect())
                .unwrap_or_default(),
            inputs,
        }
    }

    /// Removes the files of an earlier run of a scenario that has changed since.
    pub fn make_room(&self, progressed: &Progressed) -> Result<(), Failure> {
        for path in &progressed.own {
            std::fs::remove_file(path).map_err(|e| Failure::system(path.display(), &e))?;
        }
        Ok(())
    }

    /// Adds a scenario whose files are in their places. Those of a scenario that could not be read are not kept as
    /// finished.
    pub fn add(
        &self,
        entry: &Entry,
        progressed: Progressed,
        files: &[PathBuf],
        notes: Value,
    ) -> Result<(), Failure> {
        if progressed.inputs.is_empty() {
            return Ok(());
        }
        let inside = |path: &PathBuf| path.strip_prefix(&self.folder).map(Path::to_path_buf).ok();
        let files: Vec<PathBuf> = files.iter().filter_map(inside).collect();
        let added = self
            .journal
            .add(&entry.display(), progressed.inputs, &files, notes);
        added.map_err(|error: JournalError| Failure::input(error))
    }
}
