//! The journal of a job over many files: what it was begun with, what is done, and whether it can go on.
//!
//! It lies in the folder that the job writes to, in [`FOLDER`]: JSON lines, the first one with the job, then one for
//! each finished unit (a scenario, or a part of a table), added after the unit's files are in their places. A unit
//! whose line is missing, whose input has changed, or whose files were changed or removed is done again.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use nearmiss_base::system;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_study::evaluation::batch::Shard;
use serde::{Deserialize, Serialize};
use serde_json::Value;

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
        check_others(&journals, &path, job)?;
        if earlier == EarlierRun::Replace {
            file.set_len(0).map_err(|e| io(&path, e))?;
        }
        let (found, finished) = read(&mut file, &path)?;
        match found {
            Some(_) if earlier == EarlierRun::Refuse => {
                return Err(JournalError::EarlierRun(folder.to_path_buf()));
            }
            Some(found) => job.check(&path, &found)?,
            None => append(&mut file, &job.header()).map_err(|e| io(&path, e))?,
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
        append(&mut file, &line).map_err(|e| io(&self.path, e))
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

/// Whether a file holds these bytes already: a run that was killed had just written it.
#[must_use]
pub fn holds(path: &Path, bytes: &[u8]) -> bool {
    system::read_file(path, system::LARGEST).is_ok_and(|found| found == bytes)
}

/// A short hash of an input: where it was read, and its content.
#[must_use]
pub fn input_hash(place: &str, content: &ContentHash) -> String {
    let both = ContentHash::of_parts([place.as_bytes(), b"\n", content.to_string().as_bytes()]);
    both.to_string()[..16].to_string()
}

fn hash_of(path: &Path) -> io::Result<String> {
    let bytes = system::read_file(path, system::LARGEST)?;
    Ok(ContentHash::digest(&bytes).to_string())
}

/// Why a journal cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// It cannot be read or written, or a file of a finished unit cannot.
    #[error("{path}: {}", system::error_text(source))]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Another program is writing it.
    #[error("{0}: another nearmiss is working on the same part in this folder")]
    Busy(PathBuf),
    /// The folder has the output of an earlier run.
    #[error("{0}: holds an earlier run; --resume continues it, --overwrite starts again")]
    EarlierRun(PathBuf),
    /// The earlier run had other settings, or was made by another version.
    #[error(
        "{path}: the run in this folder has other settings or comes from another version of nearmiss ({differences}); \
         choose another folder, give the settings of then, or leave out --resume and start again with --overwrite"
    )]
    OtherSettings {
        /// The journal.
        path: PathBuf,
        /// What differs.
        differences: String,
    },
    /// The folder has another division into parts.
    #[error(
        "{0}: the folder holds a run divided otherwise, so scenarios would be there twice; use the same number of \
         parts, or another folder"
    )]
    OtherDivision(PathBuf),
    /// It is not a journal.
    #[error("{path}: line {line} is not a line of a journal of nearmiss; choose another folder")]
    NotAJournal {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
    },
}

/// The settings of a run by their keys, those of a table by the keys on the way to them: `search.seed`. What is not
/// given is left out.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RunSettings(BTreeMap<String, Value>);

/// A setting that two runs do not share.
#[derive(Debug, Clone, PartialEq)]
pub struct SettingDifference {
    /// Its key.
    pub key: String,
    /// Its value in the earlier run; `None` where it was not given.
    pub then: Option<Value>,
    /// Its value now.
    pub now: Option<Value>,
}

impl RunSettings {
    /// Those that a value has when it is written to a file and read again: digits that no file keeps make no
    /// difference.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub fn new(settings: &impl Serialize) -> serde_json::Result<Self> {
        let mut all = BTreeMap::new();
        let written = serde_json::to_string(settings)?;
        flatten(String::new(), serde_json::from_str(&written)?, &mut all);
        Ok(Self(all))
    }

    /// Settings of which only words are known.
    fn of_words(words: impl IntoIterator<Item = (String, String)>) -> Self {
        let value = |word: String| word.parse::<f64>().map_or(Value::String(word), Value::from);
        let all = words.into_iter().map(|(key, word)| (key, value(word)));
        Self(all.collect())
    }

    /// The same, with no more known than words.
    fn in_words(&self) -> Self {
        let word = |value: &Value| value.as_str().map_or(value.to_string(), String::from);
        Self::of_words(self.0.iter().map(|(key, value)| (key.clone(), word(value))))
    }

    /// Where these of an earlier run are others than those of now.
    #[must_use]
    pub fn differences(&self, now: &Self) -> Vec<SettingDifference> {
        let keys: BTreeSet<&String> = self.0.keys().chain(now.0.keys()).collect();
        let differ = keys
            .into_iter()
            .filter(|key| self.0.get(*key) != now.0.get(*key));
        differ
            .map(|key| SettingDifference {
                key: key.clone(),
                then: self.0.get(key).cloned(),
                now: now.0.get(key).cloned(),
            })
            .collect()
    }
}

impl fmt::Display for SettingDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = |value: &Option<Value>| match value {
            Some(value) => value.to_string(),
            None => "not given".into(),
        };
        write!(
            f,
            "{} {}, now {}",
            self.key,
            word(&self.then),
            word(&self.now)
        )
    }
}

fn flatten(path: String, value: Value, all: &mut BTreeMap<String, Value>) {
    match value {
        Value::Null => {}
        Value::Object(table) => {
            for (key, value) in table {
                let dot = if path.is_empty() { "" } else { "." };
                flatten(format!("{path}{dot}{key}"), value, all);
            }
        }
        value => {
            all.insert(path, value);
        }
    }
}

type Contents = (Option<Header>, HashMap<String, FinishedUnit>);

/// Reads a journal. A last line without an end is cut off: its program was killed. Of a unit that was done again, the
/// last line counts.
fn read(file: &mut File, path: &Path) -> Result<Contents, JournalError> {
    let io = |source| JournalError::Io {
        path: path.to_path_buf(),
        source,
    };
    let mut reader = BufReader::new(&*file);
    let (mut header, mut finished) = (None, HashMap::new());
    let (mut whole, mut line, mut text) = (0_u64, 0, String::new());
    loop {
        text.clear();
        let length = reader.read_line(&mut text).map_err(io)?;
        if !text.ends_with('\n') {
            break;
        }
        whole += length as u64;
        line += 1;
        let wrong = |_| JournalError::NotAJournal {
            path: path.to_path_buf(),
            line,
        };
        if line == 1 {
            header = Some(serde_json::from_str(&text).map_err(wrong)?);
            continue;
        }
        let unit: FinishedUnit = serde_json::from_str(&text).map_err(wrong)?;
        finished.insert(unit.unit.clone(), unit);
    }
    file.set_len(whole).map_err(io)?;
    Ok((header, finished))
}

/// Adds a line, in one piece.
fn append(file: &mut File, line: &impl serde::Serialize) -> io::Result<()> {
    let mut text = serde_json::to_string(line)?;
    text.push('\n');
    file.write_all(text.as_bytes())
}

/// Refuses journals of the same command beside it that have other settings, or divide the scenarios otherwise.
fn check_others(folder: &Path, own: &Path, job: &JobIdentity) -> Result<(), JournalError> {
    let entries = std::fs::read_dir(folder).map_err(|source| JournalError::Io {
        path: folder.to_path_buf(),
        source,
    })?;
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let same = name
            .strip_prefix(job.command)
            .is_some_and(|rest| rest == ".jsonl" || rest.starts_with('-'));
        if path == own || !same {
            continue;
        }
        let mut first = String::new();
        let opened = system::open_file(&path);
        let read = opened.and_then(|file| BufReader::new(file).read_line(&mut first));
        read.map_err(|source| JournalError::Io {
            path: path.clone(),
            source,
        })?;
        // One that is just being begun has no whole line yet.
        let Ok(found) = serde_json::from_str::<Header>(&first) else {
            continue;
        };
        let own = job.shard.map(|shard| shard.to_string());
        if parts(found.shard.as_deref()) != parts(own.as_deref()) {
            return Err(JournalError::OtherDivision(path));
        }
        job.check(&path, &found)?;
    }
    Ok(())
}

/// The number of parts, as text.
fn parts(shard: Option<&str>) -> Option<&str> {
    shard
        .and_then(|shard| shard.split_once('/'))
        .map(|(_, of)| of)
}

#[cfg(test)]
mod tests;
