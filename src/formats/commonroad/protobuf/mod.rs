//! CommonRoad files in protobuf: the single message of 2020a, and the map, dynamic and scenario files of 2024.

mod checks;
mod dynamic;
mod elements;
mod header;
mod kind;
mod map;
mod map_elements;
mod sibling_files;
#[rustfmt::skip]
mod messages;
mod format_2020a;
mod format_2024;
mod obstacles;
mod place;
mod planning;
mod report;
mod road;
mod shapes;
mod sign_values;
mod signs;
mod states;
mod tasks;
mod values;
pub(crate) mod wire;
mod words;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use kind::{FileHeader, MessageKind};
use report::{FieldPath, Report};
use sibling_files::Folder;

pub(super) use sibling_files::{is_protobuf_name, scenario_name};

use super::ReadError;
use super::builder::SourceLocation;
use super::encoding::{foreign, without_marks};
use super::root::{Unrecognised, beginning_of_file};
use nearmiss_scene::scenario::Scenario;

/// Larger files are not read, bytes.
const LARGEST_FILE: u64 = 128 << 20;

/// Whether a file is protobuf: its beginning is a message's, or it has the name of one and is no XML.
pub(super) fn is_meant(bytes: &[u8], file: &str) -> bool {
    FileHeader::detect(bytes).is_some() || !is_markup(bytes) && is_protobuf_name(Path::new(file))
}

/// Reads a scenario; `path` is where the other files of a scenario of 2024 are looked for.
pub(super) fn read(bytes: &[u8], file: &str, path: Option<&Path>) -> Result<Scenario, ReadError> {
    check_size(file, bytes.len() as u64)?;
    match FileHeader::detect(bytes) {
        Some(FileHeader {
            kind: MessageKind::Single,
            ..
        }) => format_2020a::read(bytes, file),
        Some(head) => format_2024::read(bytes, file, &head, path),
        None => Err(fail(file, &no_message(bytes))),
    }
}

/// The nature of bytes that do not begin as a message does.
fn no_message(bytes: &[u8]) -> String {
    let said = match foreign(bytes) {
        Some(what) => return format!("this is {what}"),
        None if bytes.is_empty() => "it is empty",
        None => {
            "not a CommonRoad protobuf message, or damaged at its beginning: field 1 must be the information of a scenario or map"
        }
    };
    said.to_string()
}

fn fail(file: &str, message: &str) -> ReadError {
    FieldPath::root(&Report::about(file), "").fail(message)
}

fn check_size(file: &str, size: u64) -> Result<(), ReadError> {
    if size <= LARGEST_FILE {
        return Ok(());
    }
    let (size, largest) = (size.div_ceil(1 << 20), LARGEST_FILE >> 20);
    let message = format!("{size} MiB; at most {largest} MiB are read");
    Err(fail(file, &message))
}

/// Those of the protobuf files in one folder that are scenarios, in the order given: not those that are part of another
/// one. And those that are nothing known, with why.
pub(super) fn scenarios(files: Vec<PathBuf>) -> (Vec<PathBuf>, Vec<(PathBuf, Unrecognised)>) {
    let Some(mut folder) = files.first().map(|file| Folder::around(file)) else {
        return Default::default();
    };
    let parts = files.iter().flat_map(|file| folder.parts_of(file));
    let parts: HashSet<PathBuf> = parts.flatten().collect();
    let whole = files.into_iter().filter(|file| !parts.contains(file));
    let (known, unknown): (Vec<_>, Vec<_>) = whole.partition(|file| folder.head(file).is_some());
    let unknown = unknown.into_iter().map(|file| {
        let why = why_unknown(&file);
        (file, why)
    });
    (known, unknown.collect())
}

/// Why a file is no message that is known.
fn why_unknown(file: &Path) -> Unrecognised {
    match beginning_of_file(file, 64) {
        Err(why) => why,
        Ok(bytes) => match foreign(&bytes) {
            Some(what) => Unrecognised::Foreign(what),
            None if is_markup(&bytes) => Unrecognised::Foreign("XML; its name should end in .xml"),
            None => Unrecognised::NoMessage,
        },
    }
}

/// Whether bytes begin as XML does.
fn is_markup(bytes: &[u8]) -> bool {
    without_marks(bytes).trim_ascii_start().starts_with(b"<")
}
