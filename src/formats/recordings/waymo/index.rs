//! Which scenarios a file holds and where, remembered for the file that was asked for last.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use super::tfrecord::{Record, Records};
use crate::commonroad::ReadError;

/// The field of a scenario with its id.
const SCENARIO_ID: u64 = 5;

/// No name of a scenario is longer.
const LONGEST_NAME: usize = 64;

/// Names of the scenarios in a file, with their places.
#[derive(Debug, Default)]
pub struct Index {
    /// In the order of the file. A scenario without a usable id has its place as its name, from 1.
    pub names: Vec<String>,
    records: Vec<Record>,
    by_name: HashMap<String, usize>,
}

impl Index {
    /// A scenario by its name, or by its place from 1.
    pub fn record(&self, part: &str) -> Option<Record> {
        let by_place = || part.parse::<usize>().ok()?.checked_sub(1);
        let place = self.by_name.get(part).copied().or_else(by_place)?;
        self.records.get(place).copied()
    }

    /// The only scenario.
    pub fn only(&self) -> Option<Record> {
        match self.records[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    fn scan(path: &Path) -> Result<Self, ReadError> {
        let mut file = Records::open(path)?;
        let mut index = Self::default();
        while let Some(record) = file.next()? {
            let id = file.string_field(record, SCENARIO_ID)?;
            file.pass(record)?;
            let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
            let usable = |id: &String| {
                (1..=LONGEST_NAME).contains(&id.len())
                    && id.chars().all(plain)
                    && !index.by_name.contains_key(id)
            };
            let name = id
                .filter(usable)
                .unwrap_or_else(|| (record.place + 1).to_string());
            index.by_name.entry(name.clone()).or_insert(record.place);
            index.names.push(name);
            index.records.push(record);
        }
        Ok(index)
    }
}

/// A file as it was when it was looked through.
type Seen = (PathBuf, u64, Option<SystemTime>, Arc<Index>);

/// The file that was looked through last: each of its scenarios asks for the same index.
static LAST: Mutex<Option<Seen>> = Mutex::new(None);

/// The scenarios of a file, found by reading their ids only.
///
/// # Errors
/// The file cannot be read or is damaged: with the record.
pub fn of(path: &Path) -> Result<Arc<Index>, ReadError> {
    let found = path
        .metadata()
        .map_err(|error| ReadError::io(&path.display().to_string(), &error))?;
    let now = (found.len(), found.modified().ok());
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((seen, size, changed, index)) = &*last
        && seen == path
        && (*size, *changed) == now
    {
        return Ok(Arc::clone(index));
    }
    let index = Arc::new(Index::scan(path)?);
    *last = Some((path.to_path_buf(), now.0, now.1, Arc::clone(&index)));
    Ok(index)
}
