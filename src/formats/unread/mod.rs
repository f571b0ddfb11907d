//! Files that people have beside or instead of scenarios, and that are not read: what they are, and what to do.

mod binary;
mod text;

use std::path::Path;

use super::address::Address;
use super::commonroad::{self, ReadError};
use super::dispatch::{Format, Parts};
use super::recordings;
use nearmiss_scene::scenario::Scenario;

/// Files that are not read.
pub(super) struct Unread;

/// What a file is.
pub(super) struct Kind {
    /// As in `a road network of SUMO`.
    pub what: String,
    /// What its owner can do instead.
    instead: String,
    /// How a search of a folder takes it.
    pub found: Found,
}

/// What a search of a folder makes of a file that is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    /// It is data of driving that one could want to open.
    Data,
    /// It belongs to recordings, and is worth a word only where there are none.
    Beside,
    /// It is anything.
    Other,
}

/// What is said where there is nothing better to do.
const FORMATS: &str = "`nearmiss help scenarios` lists the formats that are read";

impl Kind {
    fn new(found: Found, what: impl Into<String>, instead: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            instead: instead.into(),
            found,
        }
    }

    /// Data of driving in a format that is not read.
    fn data(what: impl Into<String>) -> Self {
        Self::new(Found::Data, what, FORMATS)
    }

    /// Anything else.
    fn other(what: impl Into<String>) -> Self {
        Self::new(Found::Other, what, FORMATS)
    }
}

/// What a file is that is not read, by its name and its first bytes; `None` where it may be a scenario.
pub(super) fn kind(path: &Path, head: &[u8]) -> Option<Kind> {
    // Which of them are to be unpacked or saved anew is said by their readers.
    if head.is_empty() || commonroad::is_protobuf_name(path) || commonroad::foreign(head).is_some()
    {
        return None;
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if let Some(columns) = recordings::parquet_columns(path, head) {
        return Some(text::parquet(&columns));
    }
    if let Some(kind) = binary::kind(&name, head) {
        return Some(kind);
    }
    let decoded = String::from_utf8_lossy(head);
    let text = decoded.trim_start_matches('\u{feff}').trim_start();
    if text.contains('\0') {
        return None;
    }
    if text.starts_with('<') {
        return text::xml(&name, text);
    }
    text::other(&name, text)
}

impl Format for Unread {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        kind(path, head).is_some()
    }

    fn is_found(&self, _: &Path, _: &[u8]) -> bool {
        false
    }

    fn parts(&self, _: &Path) -> Result<Parts, ReadError> {
        Ok(Parts::One)
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let file = &address.file;
        let head = commonroad::beginning_of_file(file, super::dispatch::HEAD).unwrap_or_default();
        let message = match kind(file, &head) {
            Some(kind) => format!("{}, not a scenario; {}", kind.what, kind.instead),
            None => format!("not a scenario; {FORMATS}"),
        };
        Err(ReadError {
            file: file.display().to_string(),
            line: 0,
            column: 0,
            element: String::new(),
            message,
        })
    }
}
