//! Finding scenario files in folders, the bundled scenarios, and opening either with its ego.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::commonroad::{self, ReadError};
use super::{Ego, EgoError, Scenario, find_recording, read_ego_file, read_recording};
use crate::system;

/// Where a scenario lies.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Place {
    /// A file.
    File(PathBuf),
    /// In the program itself, by its place in [`bundled`].
    Bundled(usize),
}

/// A scenario that can be opened.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Entry {
    /// What people call it: the file's name without its ending, and without the `-SC` of 2024 protobuf.
    pub name: String,
    /// The folder it is in, as far as it tells entries apart; may be empty.
    pub group: String,
    /// Where it lies.
    pub place: Place,
}

/// Why no scenarios were found.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// A path does not exist or cannot be read.
    #[error("{path}: {}", system::words(source))]
    Io {
        /// Which path.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The path is `-`.
    #[error(
        "-: standard input is not read; save it in a file and name that (one that is called `-` is meant by `./-`)"
    )]
    StandardInput,
    /// There is no scenario below a path.
    #[error(
        "{0}: no CommonRoad scenario (a .xml file with a <commonRoad> root, or a .pb file) in this folder or below"
    )]
    Nothing(PathBuf),
}

/// A bundled scenario: its name, its XML, its ego trajectory.
macro_rules! bundle {
    ($($name:literal),+ $(,)?) => {
        &[$((
            $name,
            include_bytes!(concat!("../../scenarios/", $name, ".xml")),
            include_bytes!(concat!("../../scenarios/", $name, ".ego_trajectory.csv")),
        )),+]
    };
}

/// The scenarios inside the program; `cargo run --example make-scenarios` writes them.
const BUNDLED: &[(&str, &[u8], &[u8])] = bundle![
    "ZAM_HardBraking-1_1_T-1",
    "ZAM_CutIn-1_1_T-1",
    "ZAM_RedLight-1_1_T-1",
    "ZAM_Overtaking-1_1_T-1",
    "ZAM_Pedestrian-1_1_T-1",
    "ZAM_Merge-1_1_T-1",
    "ZAM_RightTurn-1_1_T-1",
    "ZAM_JamTail-1_1_T-1",
];

/// Names, XML and ego trajectory of the scenarios inside the program.
#[must_use]
pub fn bundled() -> Vec<Entry> {
    let entries = BUNDLED.iter().enumerate();
    entries
        .map(|(place, (name, ..))| Entry {
            name: (*name).to_string(),
            group: String::new(),
            place: Place::Bundled(place),
        })
        .collect()
}

impl Entry {
    /// An entry for one file, whatever it holds.
    #[must_use]
    pub fn of_file(path: &Path) -> Self {
        let folder = path.parent().and_then(Path::file_name);
        Self {
            name: commonroad::scenario_name(path),
            group: folder.map_or_else(String::new, |f| f.to_string_lossy().into_owned()),
            place: Place::File(path.to_path_buf()),
        }
    }

    /// The entry that a command-line argument means: a file, or the name of a bundled scenario.
    #[must_use]
    pub fn of_argument(argument: &Path) -> Self {
        let named = bundled()
            .into_iter()
            .find(|e| Path::new(&e.name) == argument);
        match named {
            Some(entry) if !argument.exists() => entry,
            _ => Self::of_file(argument),
        }
    }

    /// What to call the file in messages.
    #[must_use]
    pub fn display(&self) -> String {
        match &self.place {
            Place::File(path) => path.display().to_string(),
            Place::Bundled(_) => format!("{} (bundled)", self.name),
        }
    }

    /// Reads the scenario.
    ///
    /// # Errors
    /// The file cannot be read, or is not a scenario: with file, line and element.
    pub fn read(&self) -> Result<Arc<Scenario>, ReadError> {
        match &self.place {
            Place::File(path) => commonroad::read_file(path),
            Place::Bundled(i) => commonroad::read(BUNDLED[*i].1, &self.display()),
        }
        .map(Arc::new)
    }

    /// Reads the ego that lies with the scenario, see [`find_recording`]; nothing if there is none.
    ///
    /// # Errors
    /// A file with an ego is there and cannot be read.
    pub fn recorded_ego(&self, scenario: &Scenario) -> Result<Option<Ego>, EgoError> {
        match &self.place {
            Place::Bundled(i) => {
                let name = format!("{}.ego_trajectory.csv", self.name);
                read_recording(BUNDLED[*i].2, &name, scenario).map(Some)
            }
            Place::File(path) => {
                let Some(recording) = find_recording(path) else {
                    return Ok(None);
                };
                read_ego_file(&recording, scenario, None).map(Some)
            }
        }
    }
}

/// Refuses `-`, by which other programs mean their standard input.
///
/// # Errors
/// The path is `-`.
pub fn not_standard_input(path: &Path) -> Result<(), LibraryError> {
    if path.as_os_str() == "-" {
        return Err(LibraryError::StandardInput);
    }
    Ok(())
}

/// The scenarios at `paths`: files as they are, folders searched to the bottom, each file once.
///
/// A scenario that is several files in a folder (2024 protobuf) is there once, with the file that needs the others.
///
/// In a folder laid out like the repository of "From Words to Collisions" (with `Scenarios` and
/// `Results`), the scenarios are those below `Scenarios`.
///
/// # Errors
/// A path that cannot be read, or not one scenario at any of them.
pub fn find(paths: &[PathBuf]) -> Result<Vec<Entry>, LibraryError> {
    let mut found = Vec::new();
    for path in paths {
        not_standard_input(path)?;
        let io = |source| LibraryError::Io {
            path: path.clone(),
            source,
        };
        if Entry::of_argument(path).place == Place::File(path.clone()) {
            let before = found.len();
            if path.metadata().map_err(io)?.is_dir() {
                let scenarios = path.join("Scenarios");
                let whole = !(scenarios.is_dir() && path.join("Results").is_dir());
                search(if whole { path } else { &scenarios }, 0, &mut found).map_err(io)?;
                found[before..].sort();
            } else {
                found.push(path.clone());
            }
        } else {
            found.push(path.clone());
        }
    }
    if let (true, Some(first)) = (found.is_empty(), paths.first()) {
        return Err(LibraryError::Nothing(first.clone()));
    }
    let mut seen = std::collections::HashSet::new();
    found.retain(|p| seen.insert(p.clone()));
    Ok(found.iter().map(|p| Entry::of_argument(p)).collect())
}

/// Folders nested deeper than this are not searched: it is a loop of links.
const DEEPEST: usize = 32;

fn search(folder: &Path, depth: usize, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let mut protobuf = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            let hidden = path
                .file_name()
                .is_some_and(|n| n.to_string_lossy().starts_with('.'));
            if depth < DEEPEST && !hidden {
                // A folder that may not be entered hides its scenarios, not its neighbours'.
                let _ = search(&path, depth + 1, found);
            }
        } else if !path.is_file() {
            // Reading from a pipe would wait for ever.
        } else if path.extension().is_some_and(|x| x == "xml") && is_scenario(&path) {
            found.push(path);
        } else if commonroad::is_protobuf_name(&path) {
            protobuf.push(path);
        }
    }
    found.extend(commonroad::protobuf_scenarios(protobuf));
    Ok(())
}

/// Whether the beginning of a file looks like a scenario's; other XML files are passed over.
pub(super) fn is_scenario(path: &Path) -> bool {
    let mut head = Vec::with_capacity(2048);
    let opened = std::fs::File::open(path);
    let read = opened.and_then(|f| f.take(2048).read_to_end(&mut head));
    read.is_ok() && head.windows(11).any(|w| w == b"<commonRoad")
}
