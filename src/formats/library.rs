//! Scenarios in files or bundled with the program, the path that an argument means, and opening them with their ego.

use std::fs::File;
use std::io::{ErrorKind, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use nearmiss_base::system::{self, available, did_you_mean};
use nearmiss_scene::scenario::{ContentHash, Ego, RecordedEgo, Scenario};

use super::commonroad::{self, ReadError};
use super::dispatch::{self, Address};
use super::ego::sized;
use super::{EgoError, find_recording, read_ego, read_ego_file};

/// Location of a scenario.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum EntryLocation {
    /// A file; of one with several scenarios, one of them by `FILE#NAME`.
    File(PathBuf),
    /// In the program itself, by its place in [`bundled`].
    Bundled(usize),
}

/// A scenario that can be opened.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Entry {
    /// Its display name: the file's name without its extension and the `-SC` of 2024 protobuf.
    pub name: String,
    /// The folder it is in, as far as it tells entries apart; may be empty.
    pub group: String,
    /// Its location.
    pub place: EntryLocation,
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
            place: EntryLocation::Bundled(place),
        })
        .collect()
}

impl Entry {
    /// An entry for one file, whatever it holds.
    #[must_use]
    pub fn of_file(path: &Path) -> Self {
        let address = Address::from_path(path);
        let named = |path: Option<&std::ffi::OsStr>| {
            path.map_or_else(String::new, |f| f.to_string_lossy().into_owned())
        };
        let file = commonroad::scenario_name(&address.file);
        let (name, group) = match &address.part {
            // A scenario with a name of its own, or a window of a recording.
            Some(part) if !part.contains('=') => (part.clone(), named(address.file.file_name())),
            Some(part) => (format!("{file}-{part}"), named(address.file.file_name())),
            None => (file, named(path.parent().and_then(Path::file_name))),
        };
        Self {
            name: match address.part {
                Some(_) => dispatch::plain_name(&name),
                None => name,
            },
            group,
            place: EntryLocation::File(path.to_path_buf()),
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

    /// The file that it lies in: of one of several scenarios in a file, that file; `None` if it is bundled.
    #[must_use]
    pub fn file(&self) -> Option<PathBuf> {
        match &self.place {
            EntryLocation::File(path) => Some(dispatch::file_of(path)),
            EntryLocation::Bundled(_) => None,
        }
    }

    /// Whether it is a recording of a data set other than CommonRoad.
    #[must_use]
    pub fn is_recording(&self) -> bool {
        self.file()
            .is_some_and(|file| dispatch::is_recording(&file))
    }

    /// Whether it is a part of a long recording, around one of its tracks.
    #[must_use]
    pub fn is_window(&self) -> bool {
        match &self.place {
            EntryLocation::File(path) => path.to_string_lossy().contains("#track="),
            EntryLocation::Bundled(_) => false,
        }
    }

    /// The name of the file in messages.
    #[must_use]
    pub fn display(&self) -> String {
        match &self.place {
            EntryLocation::File(path) => shown(path.display().to_string()),
            EntryLocation::Bundled(_) => format!("{} (bundled)", self.name),
        }
    }

    /// Reads the scenario.
    ///
    /// # Errors
    /// The file cannot be read, or is not a scenario: with file, line and element.
    pub fn read(&self) -> Result<Arc<Scenario>, ReadError> {
        if let EntryLocation::File(path) = &self.place {
            system::crash::reading(path);
        }
        let read = match &self.place {
            EntryLocation::File(path) => dispatch::open(path),
            EntryLocation::Bundled(i) => commonroad::read(BUNDLED[*i].1, &self.display()),
        };
        match read {
            Ok(mut scenario) => {
                if let Some(own) = &mut scenario.recorded_ego {
                    own.file = shown(std::mem::take(&mut own.file));
                }
                Ok(Arc::new(scenario))
            }
            Err(error) => Err(ReadError {
                file: shown(error.file.clone()),
                ..error
            }),
        }
    }

    /// The text of its file.
    ///
    /// # Errors
    /// It cannot be read, or is not XML in UTF-8: with the file.
    pub fn source(&self) -> Result<String, String> {
        let named = |words: &str| format!("{}: {words}", self.display());
        let bytes = match &self.place {
            EntryLocation::Bundled(i) => BUNDLED[*i].1.to_vec(),
            EntryLocation::File(path) if commonroad::is_protobuf_name(path) => {
                return Err(named("protobuf files have no text to show"));
            }
            EntryLocation::File(path) if dispatch::is_recording(&dispatch::file_of(path)) => {
                return Err(named(
                    "a recording has no CommonRoad text to show; `nearmiss convert` writes it",
                ));
            }
            EntryLocation::File(path) => system::read_file(path, system::LARGEST)
                .map_err(|error| named(&system::error_text(&error)))?,
        };
        String::from_utf8(bytes).map_err(|_| named("not UTF-8 text"))
    }

    /// The hash of all that is read of it: its file with those it needs, and the ego that lies with it. It changes when
    /// one of them does, wherever they lie.
    ///
    /// # Errors
    /// What the system says about one of the files.
    pub fn content_hash(&self) -> std::io::Result<ContentHash> {
        let path = match &self.place {
            EntryLocation::Bundled(i) => {
                let (_, xml, ego) = BUNDLED[*i];
                return Ok(ContentHash::of_parts([xml, ego]));
            }
            EntryLocation::File(path) => path,
        };
        if dispatch::is_recording(&dispatch::file_of(path)) {
            let scenario = dispatch::open(path);
            return match scenario {
                Ok(scenario) => Ok(scenario.hash),
                Err(error) => Err(std::io::Error::other(error)),
            };
        }
        let own = system::read_file(path, system::LARGEST)?;
        let mut hash = ContentHash::digest(&own);
        // The files that a protobuf scenario needs are found by reading it.
        if commonroad::is_protobuf_name(path)
            && let Ok(scenario) = commonroad::read_file(path)
        {
            hash = scenario.hash;
        }
        let ego = find_recording(path)
            .map(|ego| system::read_file(&ego, system::LARGEST))
            .transpose()?
            .unwrap_or_default();
        Ok(ContentHash::of_parts([
            hash.to_string().as_bytes(),
            b"\n",
            &ego,
        ]))
    }

    /// Reads the ego that lies with the scenario, see [`find_recording`]; nothing if there is none.
    ///
    /// # Errors
    /// A file with an ego is there and cannot be read.
    pub fn recorded_ego(&self, scenario: &Scenario) -> Result<Option<Ego>, EgoError> {
        self.recorded_ego_for(scenario, None)
    }

    /// The same, and of a file with several the one of a planning problem.
    ///
    /// # Errors
    /// A file with an ego is there, and cannot be read or has none for that problem.
    pub fn recorded_ego_for(
        &self,
        scenario: &Scenario,
        planning_problem: Option<i64>,
    ) -> Result<Option<Ego>, EgoError> {
        match &self.place {
            EntryLocation::Bundled(i) => {
                let name = format!("{}.ego_trajectory.csv", self.name);
                read_ego(BUNDLED[*i].2, &name, scenario, planning_problem).map(Some)
            }
            EntryLocation::File(_) if scenario.recorded_ego.is_some() => {
                let own = scenario.recorded_ego.as_ref().and_then(RecordedEgo::ego);
                match (own, planning_problem) {
                    (Some(own), Some(problem)) if own.id != problem => {
                        Err(EgoError::NoSuchProblem {
                            file: self.display(),
                            problem,
                            known: own.id.to_string(),
                        })
                    }
                    (own, _) => Ok(own),
                }
            }
            EntryLocation::File(path) => {
                let Some(recording) = find_recording(path) else {
                    return Ok(None);
                };
                let ego = read_ego_file(&recording, scenario, planning_problem)?;
                Ok(Some(sized(ego, &recording, &self.name, scenario)))
            }
        }
    }
}

static KEPT: OnceLock<Result<PathBuf, String>> = OnceLock::new();

/// A file in messages, which may be standard input.
fn shown(file: String) -> String {
    match KEPT.get() {
        Some(Ok(kept)) => file.replace(&*kept.to_string_lossy(), "standard input"),
        _ => file,
    }
}

/// Standard input as a file, which can be opened twice; it is gone when the program ends.
///
/// # Errors
/// It is a terminal, empty, or cannot be kept: in words.
fn standard_input() -> Result<PathBuf, String> {
    let keep = || {
        if std::io::stdin().is_terminal() {
            return Err("-: standard input is a terminal; pipe a file into it".to_string());
        }
        let said = |error: std::io::Error| format!("-: {}", system::error_text(&error));
        let folder = tempfile::Builder::new()
            .prefix("nearmiss-")
            .tempdir()
            .map_err(said)?;
        let folder = folder.keep();
        std::mem::forget(system::Unfinished::begin(&folder));
        let path = folder.join("stdin");
        let mut file = File::create_new(&path).map_err(said)?;
        let size = std::io::copy(&mut std::io::stdin().lock(), &mut file).map_err(said)?;
        if size == 0 {
            return Err("-: standard input is empty".into());
        }
        let head = commonroad::beginning_of_file(&path, dispatch::HEAD).unwrap_or_default();
        // Names tell CommonRoad's protobuf from its XML.
        let end = match head.first() {
            Some(b'<') => "xml",
            _ => "csv",
        };
        let named = path.with_extension(end);
        std::fs::rename(&path, &named).map_err(said)?;
        Ok(named)
    };
    KEPT.get_or_init(keep).clone()
}

/// The path that an argument means: itself, the bundled scenario whose name begins so, if it is the only one, or standard
/// input for `-`.
///
/// # Errors
/// There is no such file or scenario, with what was probably meant; or several scenarios begin so: in words.
pub fn resolved(argument: &Path) -> Result<PathBuf, String> {
    if argument == Path::new("-") {
        return standard_input();
    }
    let missing = matches!(argument.symlink_metadata(), Err(e) if e.kind() == ErrorKind::NotFound);
    let is_part = || Address::from_path(argument).part.is_some();
    if !missing || is_part() {
        return Ok(argument.to_path_buf());
    }
    let names: Vec<String> = bundled().into_iter().map(|e| e.name).collect();
    let said = argument.to_string_lossy();
    let wanted = said.to_lowercase();
    let begin = |name: &&String| !wanted.is_empty() && name.to_lowercase().starts_with(&wanted);
    let found: Vec<&String> = names.iter().filter(begin).collect();
    match &found[..] {
        _ if names.iter().any(|name| *name == said) => Ok(argument.to_path_buf()),
        [name] => Ok(PathBuf::from(name)),
        [] if let Some(window) = window_named(argument) => Ok(window),
        [] => Err(format!(
            "{}: no such file or bundled scenario{}",
            argument.display(),
            instead(argument, &names)
        )),
        several => {
            let first: Vec<&str> = several.iter().take(SUGGESTED).map(|n| n.as_str()).collect();
            let more = several.len() - first.len();
            let more = match more {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            Err(format!(
                "{}: ambiguous; matches {}{more}",
                argument.display(),
                first.join(", ")
            ))
        }
    }
}

/// The window of a recording that lists call so: `fcd-track-6-79.2s` is `fcd.xml#track=6@79.2s`.
fn window_named(argument: &Path) -> Option<PathBuf> {
    let wanted = argument.file_name()?.to_str()?;
    let folder = argument
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let files = folder.unwrap_or_else(|| Path::new(".")).read_dir().ok()?;
    let names = files
        .flatten()
        .take(MOST_FILES)
        .map(|file| file.file_name());
    names.into_iter().find_map(|name| {
        let file = argument.with_file_name(name);
        let stem = dispatch::plain_name(&commonroad::scenario_name(&file));
        let window = wanted.strip_prefix(&stem)?.strip_prefix("-track-")?;
        let timed = window.rsplit_once('-').filter(|(_, time)| is_time(time));
        let part = match timed {
            Some((track, time)) => format!("track={track}@{time}"),
            None => format!("track={window}"),
        };
        dispatch::is_recording(&file).then(|| Address::path(&file, &part))
    })
}

/// Whether a text is a time such as `79.2s`.
fn is_time(text: &str) -> bool {
    let seconds = text.strip_suffix('s').map(str::parse::<f64>);
    seconds.is_some_and(|seconds| seconds.is_ok())
}

/// Scenarios that are named where several begin alike.
const SUGGESTED: usize = 3;

/// What is called nearly like a path that does not exist: bundled scenarios, or files in its folder.
fn instead(path: &Path, bundled: &[String]) -> String {
    let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    else {
        return available(&path.to_string_lossy(), bundled.iter().map(String::as_str));
    };
    let files = folder
        .read_dir()
        .into_iter()
        .flatten()
        .flatten()
        .map(|file| file.file_name().to_string_lossy().into_owned());
    let files: Vec<String> = files.take(MOST_FILES).collect();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    did_you_mean(&name, files.iter().map(String::as_str))
}

/// Files of a folder that are compared with a name.
const MOST_FILES: usize = 10_000;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn the_name_of_a_window_means_its_address() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("fcd.xml"), "<fcd-export>").unwrap();
        std::fs::write(at("other.xml"), "<net>").unwrap();
        for (name, address) in [
            ("fcd-track-6-79.2s", "fcd.xml#track=6@79.2s"),
            ("fcd-track-a-b", "fcd.xml#track=a-b"),
        ] {
            assert_eq!(resolved(&at(name)), Ok(at(address)));
        }
        assert!(resolved(&at("other-track-6-79.2s")).is_err());
        assert!(resolved(&at("fcd-6")).is_err());
    }
}
