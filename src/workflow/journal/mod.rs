//! The journal of a long job over many files: what is finished, so that a run that was killed continues.
//!
//! It lies in the folder that the job writes to, in [`FOLDER`]: JSON lines, the first one with the job, then one for
//! each finished unit (a scenario, or a part of a table), added after the unit's files are in their places. A unit
//! whose line is missing, whose input has changed, or whose files were changed or removed is done again.

mod error;
mod lines;
mod settings;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use nearmiss_base::system;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_study::evaluation::batch::Shard;

pub use error::JournalError;
pub use settings::{RunSettings, SettingDifference};

/// The folder of journals inside an output folder. Spark, DuckDB and Polars pass over names that begin so.
pub const FOLDER: &str = "_nearmiss";

/// That of the program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The number of the present layout of journals. Those of the first one noted a hash of their settings, and those of
/// `plan` words for them.
const FORMAT: u32 = 2;

/// What is done, and with which settings.
#[derive(Debug, Clone)]
pub struct JobIdentity {
    /// The command.
    pub command: &'static str,
    /// The part of the scenarios; `None` for all.
    pub shard: Option<Shard>,
    /// Everything that changes the output, apart from the scenarios.
    pub settings: RunSettings,
}

/// What happens to an earlier run in the same folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EarlierRun {
    /// It is continued.
    Continue,
    /// It is an error.
    Refuse,
    /// Everything is done again.
    Replace,
}

/// A finished unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FinishedUnit {
    /// Its name.
    pub unit: String,
    /// A hash for each of its inputs, see [`input_hash`].
    pub inputs: Vec<String>,
    /// Its files, relative to the folder, with the SHA-256 of each.
    pub files: BTreeMap<String, String>,
    /// What the job has to know of it when it continues.
    pub notes: Value,
}

/// The first line.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Header {
    #[serde(default)]
    format: u32,
    command: String,
    shard: Option<String>,
    settings: Value,
    version: String,
    /// Words for the settings, in the first layout of `plan`.
    #[serde(default, skip_serializing)]
    named: BTreeMap<String, String>,
}

impl JobIdentity {
    /// What differs from a run of before, in words; nothing where its settings are the same.
    fn differences(&self, then: &Header) -> Vec<String> {
        let mut found = Vec::new();
        if then.version != VERSION {
            found.push(format!("nearmiss {}, now {VERSION}", then.version));
        }
        let settings = match RunSettings::deserialize(&then.settings) {
            Ok(settings) if then.format == FORMAT => settings.differences(&self.settings),
            _ if then.named.is_empty() => {
                found.push("its journal does not say with which settings it was made".into());
                return found;
            }
            _ => RunSettings::of_words(then.named.clone()).differences(&self.settings.in_words()),
        };
        found.extend(settings.iter().map(ToString::to_string));
        found
    }
}

/// An open journal. Only one program has it open at a time.
#[derive(Debug)]
pub struct Journal {
    folder: PathBuf,
    path: PathBuf,
    file: Mutex<File>,
    finished: HashMap<String, FinishedUnit>,
}

impl Journal {
    /// Opens the journal of a job in the folder that it writes to, and reads what is finished.
    ///
    /// # Errors
    /// See [`JournalError`].
    pub fn open(
        folder: &Path,
        job: &JobIdentity,
        earlier: EarlierRun,
    ) -> Result<Self, JournalError> {
        let journals = folder.join(FOLDER);
        let io = |path: &Path, source| JournalError::Io {
            path: path.to_path_buf(),
            source,
        };
        std::fs::create_dir_all(&journals).map_err(|e| io(&journals, e))?;
        let path = journals.join(job.file_name());
        let options = File::options().read(true).append(true).create(true).clone();
        let mut file = options.open(&path).map_err(|e| io(&path, e))?;
        if file.try_lock().is_err() {
            return Err(JournalError::Busy(path));
        }
        lines::check_others(&journals, &path, job)?;
        if earlier == EarlierRun::Replace {
            file.set_len(0).map_err(|e| io(&path, e))?;
        }
        let (found, finished) = lines::read(&mut file, &path)?;
        match found {
            Some(_) if earlier == EarlierRun::Refuse => {
                return Err(JournalError::EarlierRun(folder.to_path_buf()));
            }
            Some(found) => job.check(&path, &found)?,
            None => lines::append(&mut file, &job.header()).map_err(|e| io(&path, e))?,
        }
        let mut journal = Self {
            folder: folder.to_path_buf(),
            path,
            file: Mutex::new(file),
            finished,
        };
        journal.forget_changed();
        Ok(journal)
    }

    /// What is known of a finished unit whose files are as they were.
    #[must_use]
    pub fn finished(&self, unit: &str) -> Option<&FinishedUnit> {
        self.finished.get(unit)
    }

    /// The finished units whose files are as they were.
    pub fn units(&self) -> impl Iterator<Item = &FinishedUnit> {
        self.finished.values()
    }

    /// Adds a unit whose files, relative to the folder, are in their places.
    ///
    /// # Errors
    /// A file cannot be read, or the journal cannot be written.
    pub fn add(
        &self,
        unit: &str,
        inputs: Vec<String>,
        files: &[PathBuf],
        notes: Value,
    ) -> Result<(), JournalError> {
        let io = |path: &Path, source| JournalError::Io {
            path: path.to_path_buf(),
            source,
        };
        let mut hashes = BTreeMap::new();
        for file in files {
            let path = self.folder.join(file);
            let hash = hash_of(&path).map_err(|e| io(&path, e))?;
            hashes.insert(file.to_string_lossy().into_owned(), hash);
        }
        let line = FinishedUnit {
            unit: unit.to_string(),
            inputs,
            files: hashes,
            notes,
        };
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        lines::append(&mut file, &line).map_err(|e| io(&self.path, e))
    }

    /// Forgets units whose files were changed or removed.
    fn forget_changed(&mut self) {
        use rayon::prelude::*;
        let folder = &self.folder;
        let as_it_was = |(file, hash): (&String, &String)| {
            let inside = Path::new(file)
                .components()
                .all(|part| matches!(part, std::path::Component::Normal(_)));
            inside && hash_of(&folder.join(file)).is_ok_and(|now| now == *hash)
        };
        let changed: Vec<String> = self
            .finished
            .par_iter()
            .filter(|(_, unit)| !unit.files.iter().all(as_it_was))
            .map(|(name, _)| name.clone())
            .collect();
        for name in changed {
            self.finished.remove(&name);
        }
    }
}

impl JobIdentity {
    fn header(&self) -> Header {
        Header {
            format: FORMAT,
            command: self.command.to_string(),
            shard: self.shard.map(|shard| shard.to_string()),
            settings: serde_json::json!(self.settings),
            version: VERSION.to_string(),
            named: BTreeMap::new(),
        }
    }

    /// Refuses a journal with other settings.
    fn check(&self, path: &Path, found: &Header) -> Result<(), JournalError> {
        let differences = self.differences(found);
        if differences.is_empty() {
            return Ok(());
        }
        Err(JournalError::OtherSettings {
            path: path.to_path_buf(),
            differences: differences.join("; "),
        })
    }

    fn file_name(&self) -> String {
        match self.shard {
            Some(shard) => format!("{}-{}.jsonl", self.command, shard.file_word()),
            None => format!("{}.jsonl", self.command),
        }
    }
}

/// A short hash of an input: where it was read, and its content.
#[must_use]
pub fn input_hash(place: &str, content: &ContentHash) -> String {
    let both = ContentHash::of_parts([place.as_bytes(), b"\n", content.to_string().as_bytes()]);
    both.to_string()[..16].to_string()
}

fn hash_of(path: &Path) -> std::io::Result<String> {
    let bytes = system::read_file(path, system::LARGEST)?;
    Ok(ContentHash::digest(&bytes).to_string())
}
