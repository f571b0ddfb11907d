//! Checks that output files can be written: before hours of planning, not after.

use std::path::{Path, PathBuf};

use crate::Failure;
use crate::output::refused;
use nearmiss_formats::commonroad::{NewFile, SaveError};
use nearmiss_formats::{Entry, EntryLocation};

/// Refuses a place that is named as a folder and is none.
pub fn named_rightly(flag: &str, path: &Path) -> Result<(), Failure> {
    let text = path.to_string_lossy();
    if !text.ends_with(std::path::is_separator) || path.is_dir() {
        return Ok(());
    }
    Err(Failure::input(format!(
        "{flag} {text}: no such folder; create it first"
    )))
}

/// Tries to make a file at a place, or in it where it is a folder; nothing stays behind.
pub fn writable(flag: &str, path: &Path, overwrite: bool) -> Result<(), Failure> {
    let tried = if path.is_dir() {
        NewFile::begin(&path.join(".nearmiss"), true)
    } else {
        NewFile::begin(path, overwrite)
    };
    tried.map(drop).map_err(|error| match error {
        SaveError::Exists(_) => refused(&error),
        SaveError::Io { .. } => Failure::input(format!(
            "{flag} {}: not writable ({}); choose another folder",
            path.display(),
            error
        )),
        _ => Failure::input(format!("{flag} {error}")),
    })
}

/// Refuses copies of scenarios in a folder where the same scenarios are found: each would be there twice.
///
/// `paths` are what was named, `copied` the scenarios of which a copy would be written into `folder`.
pub fn no_second_copies<'a>(
    folder: &Path,
    paths: &[PathBuf],
    copied: impl Iterator<Item = &'a Entry>,
) -> Result<(), Failure> {
    let Ok(whole) = folder.canonicalize() else {
        return Ok(());
    };
    let mut copied = copied.peekable();
    if copied.peek().is_none() {
        return Ok(());
    }
    let within = |outer: &PathBuf| {
        let outer = outer.canonicalize().ok().filter(|outer| outer.is_dir());
        outer.is_some_and(|outer| whole.starts_with(outer))
    };
    let read_from = paths.iter().find(|path| within(path));
    let mut files = copied.filter_map(|entry| match &entry.place {
        EntryLocation::File(path) => path.canonicalize().ok(),
        EntryLocation::Bundled(_) => None,
    });
    let inside = files.find(|file| file.starts_with(&whole));
    let found = match (&inside, read_from) {
        (Some(_), _) => folder,
        (None, Some(path)) => path,
        (None, None) => return Ok(()),
    };
    // An ego in NAME/ belongs to the NAME.xml beside it.
    let without = match inside {
        Some(file) if file.parent() == Some(&whole) => {
            ", or drop --with-scenario: egos are found beside their scenarios"
        }
        _ => "",
    };
    Err(Failure::input(format!(
        "--with-scenario -o {}: the scenarios are read from {}, so each copy would be found as a second scenario of the same name; choose a folder outside it{without}",
        folder.display(),
        found.display()
    )))
}
