//! The formats of scenarios: which one a file is, the scenarios in it, and opening one.
//!
//! A new format is a [`Format`] and a line in [`FORMATS`].

use std::path::{Path, PathBuf};

use super::address::Address;
use super::commonroad::{self, ReadError, beginning_of_file};
use super::recordings;
use crate::scenario::Scenario;

/// A format of scenarios.
pub(super) trait Format: Sync {
    /// Whether a file begins as those of this format do; `head` is its first [`HEAD`] bytes or all of it.
    fn recognises(&self, path: &Path, head: &[u8]) -> bool;

    /// Names of the scenarios in a file, without reading them; none where the file as a whole is one.
    ///
    /// # Errors
    /// The file is damaged.
    fn parts(&self, path: &Path) -> Result<Vec<String>, ReadError>;

    /// Reads one scenario.
    ///
    /// # Errors
    /// It is damaged or not there, or of several none is named.
    fn open(&self, address: &Address) -> Result<Scenario, ReadError>;
}

/// All formats; the last one takes every other file, and says what is wrong with it.
const FORMATS: [&dyn Format; 6] = [
    &recordings::Waymo,
    &recordings::Argoverse,
    &recordings::LevelX,
    &recordings::Sumo,
    &recordings::OpenScenario,
    &CommonRoad,
];

/// As much of a file as tells its format, bytes.
pub(super) const HEAD: usize = 4096;

struct CommonRoad;

impl Format for CommonRoad {
    fn recognises(&self, _: &Path, _: &[u8]) -> bool {
        true
    }

    fn parts(&self, _: &Path) -> Result<Vec<String>, ReadError> {
        Ok(Vec::new())
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        commonroad::read_file(recordings::whole_file(address)?)
    }
}

/// The format of a file; that of CommonRoad where it cannot be read, which says why.
fn format_of(file: &Path) -> &'static dyn Format {
    let head = beginning_of_file(file, HEAD).unwrap_or_default();
    let mut all = FORMATS.into_iter();
    all.find(|format| format.recognises(file, &head))
        .unwrap_or(&CommonRoad)
}

/// Reads the scenario at a path, of whatever format.
pub(super) fn open(path: &Path) -> Result<Scenario, ReadError> {
    let address = Address::of(path);
    format_of(&address.file).open(&address)
}

/// Whether a file is of a format other than CommonRoad.
pub(super) fn is_recording(file: &Path) -> bool {
    let Ok(head) = beginning_of_file(file, HEAD) else {
        return false;
    };
    let others = &FORMATS[..FORMATS.len() - 1];
    others.iter().any(|format| format.recognises(file, &head))
}

/// Whether a file's name is one that recordings have; their contents decide.
pub(super) fn is_recording_name(path: &Path) -> bool {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().to_lowercase());
    // Shards are called `x.tfrecord-00000-of-00150`.
    name.is_some_and(|name| {
        name.contains(".tfrecord")
            || [".parquet", ".csv", ".xosc"]
                .iter()
                .any(|ending| name.ends_with(ending))
    })
}

/// The paths of the scenarios in a file: the file itself, or one for each of them.
pub(super) fn scenarios_in(path: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let address = Address::of(path);
    if address.part.is_some() {
        return Ok(vec![path.to_path_buf()]);
    }
    let parts = format_of(path).parts(path)?;
    if parts.is_empty() {
        return Ok(vec![path.to_path_buf()]);
    }
    let path = |part: &String| Address::path(&address.file, part);
    Ok(parts.iter().map(path).collect())
}
