//! Searches folders for scenarios, tells them from files that only look alike, and says what it passes over.

use std::collections::HashSet;
use std::fmt;
use std::fs::DirEntry;
use std::path::{Path, PathBuf};

use nearmiss_base::system;

use super::commonroad::{self, ReadError, Unrecognised};
use super::dispatch::{self, Address, Ranking};
use super::library::{Entry, EntryLocation};
use super::recordings::LongRecording;
use super::unread::{FileKind, Kind};

/// Results of a search.
#[derive(Debug, Default)]
pub struct SearchResults {
    /// The scenarios.
    pub entries: Vec<Entry>,
    /// Files that are named like scenarios and cannot be told to be any, and folders that could not be searched. XML
    /// of another kind is not among them.
    pub passed_over: Vec<PassedOver>,
}

/// Why no scenarios were found.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// A path does not exist or cannot be read.
    #[error("{path}: {}", system::error_text(source))]
    Io {
        /// Which path.
        path: PathBuf,
        /// The system's message.
        source: std::io::Error,
    },
    /// The path is `-`, where standard input is not read.
    #[error(
        "-: standard input is read for scenarios only; save it to a file (write `./-` for a file called `-`)"
    )]
    StandardInput,
    /// No scenario lies below a path.
    #[error(
        "{path}: no CommonRoad scenario (a .xml file with a <commonRoad> root, or a .pb file) and no recording of another data \
         set in this folder or below{}{}",
        if passed_over.is_some() { "; " } else { "" },
        passed_over.as_deref().unwrap_or_default()
    )]
    Nothing {
        /// Which path.
        path: PathBuf,
        /// The skipped files, in short.
        passed_over: Option<String>,
    },
}

/// Most skipped files to name in a short message.
const MAX_LISTED: usize = 3;

impl SearchResults {
    /// Describes how many files and folders were skipped; `None` if none.
    #[must_use]
    pub fn passed_over_count(&self) -> Option<String> {
        count(&self.passed_over)
    }

    /// The first skipped files with their reasons, in a line; `None` if no file was skipped.
    #[must_use]
    pub fn passed_over_in_short(&self) -> Option<String> {
        let (all, named) = (&self.passed_over, self.passed_over.iter().take(MAX_LISTED));
        let named: Vec<String> = named.map(ToString::to_string).collect();
        let more = match all.len() - named.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let count = count(all)?;
        Some(format!("{count} skipped: {}{more}", named.join(", ")))
    }
}

impl From<Vec<Entry>> for SearchResults {
    fn from(entries: Vec<Entry>) -> Self {
        Self {
            entries,
            passed_over: Vec::new(),
        }
    }
}

/// Refuses `-` where standard input is not read.
///
/// # Errors
/// The path is `-`.
pub fn not_standard_input(path: &Path) -> Result<(), LibraryError> {
    if path.as_os_str() == "-" {
        return Err(LibraryError::StandardInput);
    }
    Ok(())
}

/// The scenarios at `paths`: files as they are, folders searched to the bottom, each file once, links to folders too.
///
/// A scenario that is several files in a folder (2024 protobuf) is there once, with the file that needs the others.
///
/// Long recordings are there with the beginnings of their tracks; [`find_ranked`] gives windows that a measure chose.
///
/// In a folder laid out like the repository of "From Words to Collisions" (with `Scenarios` and `Results`), none are
/// looked for below `Results` and `Generation`: they hold what was made of the scenarios.
///
/// # Errors
/// A path that cannot be read, or not one scenario at any of them.
pub fn find(paths: &[PathBuf]) -> Result<SearchResults, LibraryError> {
    find_ranked(paths, &LongRecording::beginnings)
}

/// The same, with the windows of long recordings that `ranking` names.
///
/// # Errors
/// As [`find`].
pub fn find_ranked(paths: &[PathBuf], ranking: Ranking<'_>) -> Result<SearchResults, LibraryError> {
    let mut entries = Vec::new();
    let mut passed_over = Vec::new();
    let mut seen = HashSet::new();
    for path in paths {
        let mut of_path = Vec::new();
        passed_over.extend(search(path, ranking, &mut |found| of_path.extend(found))?);
        // Windows of a recording stay in their order: those worth looking at come first.
        of_path.sort_by_cached_key(|p| Address::from_path(p).file);
        of_path.retain(|p| seen.insert(p.clone()));
        entries.extend(of_path.iter().map(|p| Entry::of_argument(p)));
    }
    let found = SearchResults {
        entries,
        passed_over,
    };
    match paths.first() {
        Some(first) if found.entries.is_empty() => Err(nothing(first, &found)),
        _ => Ok(found),
    }
}

/// The same in chunks of at most 256 scenarios, for callers that do not want to wait. In each folder, scenarios come
/// first, then subfolders, both by name. Returns what was skipped.
///
/// # Errors
/// As [`find`]; scenarios found before an unreadable path have been delivered by then.
pub fn find_in_pieces(
    paths: &[PathBuf],
    ranking: Ranking<'_>,
    give: &mut dyn FnMut(Vec<Entry>),
) -> Result<Vec<PassedOver>, LibraryError> {
    let mut seen = HashSet::new();
    let mut passed_over = Vec::new();
    for path in paths {
        let mut piece = |mut found: Vec<PathBuf>| {
            found.retain(|p| seen.insert(p.clone()));
            if !found.is_empty() {
                give(found.iter().map(|p| Entry::of_argument(p)).collect());
            }
        };
        passed_over.extend(search(path, ranking, &mut piece)?);
    }
    match paths.first() {
        Some(first) if seen.is_empty() => {
            let found = SearchResults {
                entries: Vec::new(),
                passed_over,
            };
            Err(nothing(first, &found))
        }
        _ => Ok(passed_over),
    }
}

fn nothing(path: &Path, found: &SearchResults) -> LibraryError {
    // What to do about the first one often helps with all.
    let instead = found
        .passed_over
        .first()
        .and_then(|first| match &first.why {
            PassedOverReason::Kind { instead, .. } => Some(format!("; {instead}")),
            _ => None,
        });
    let passed_over = found.passed_over_in_short();
    LibraryError::Nothing {
        path: path.to_path_buf(),
        passed_over: passed_over.map(|words| words + &instead.unwrap_or_default()),
    }
}

/// Scenarios in a piece, at most; the first pieces are smaller.
const PIECE: usize = 256;

/// Scenarios in the first piece: about a screen of them.
const FIRST_PIECE: usize = 64;

/// Searches one path, file or folder, and gives out what is there.
fn search(
    path: &Path,
    ranking: Ranking<'_>,
    give: &mut dyn FnMut(Vec<PathBuf>),
) -> Result<Vec<PassedOver>, LibraryError> {
    let io = |source| LibraryError::Io {
        path: path.to_path_buf(),
        source,
    };
    let named = Entry::of_argument(path).place != EntryLocation::File(path.to_path_buf());
    if named || Address::from_path(path).part.is_some() {
        give(vec![path.to_path_buf()]);
        return Ok(Vec::new());
    }
    if !path.metadata().map_err(io)?.is_dir() {
        // A damaged file is opened by what comes next, which says what is wrong with it.
        give(dispatch::scenarios_in(path, ranking).unwrap_or_else(|_| vec![path.to_path_buf()]));
        return Ok(Vec::new());
    }
    let is_of_the_paper = path.join("Results").is_dir() && path.join("Scenarios").is_dir();
    let made: &[&str] = if is_of_the_paper {
        &["Results", "Generation"]
    } else {
        &[]
    };
    Search::run(path, made, ranking, give).map_err(io)
}

/// A search below one folder.
struct Search<'a> {
    folders: Vec<PathBuf>,
    links: Vec<PathBuf>,
    entered: HashSet<PathBuf>,
    found: Vec<PathBuf>,
    given: usize,
    ranking: Ranking<'a>,
    give: &'a mut dyn FnMut(Vec<PathBuf>),
    passed_over: Vec<PassedOver>,
    /// Files that belong to recordings, and what they are.
    beside: Vec<(PathBuf, Kind)>,
}

impl<'a> Search<'a> {
    fn run(
        root: &Path,
        not_in: &[&str],
        ranking: Ranking<'a>,
        give: &'a mut dyn FnMut(Vec<PathBuf>),
    ) -> std::io::Result<Vec<PassedOver>> {
        let mut entered = HashSet::from([root.canonicalize()?]);
        // A folder that is not there has no scenarios either.
        entered.extend(
            not_in
                .iter()
                .filter_map(|name| root.join(name).canonicalize().ok()),
        );
        let mut search = Self {
            folders: Vec::new(),
            links: Vec::new(),
            entered,
            found: Vec::new(),
            given: 0,
            ranking,
            give,
            passed_over: Vec::new(),
            beside: Vec::new(),
        };
        search.enter(root)?;
        // Links come last: what is both there and linked to is found where it is. Each folder is entered once, as
        // links may lead in circles.
        loop {
            search.links.sort_by(|a, b| b.cmp(a));
            let Some(folder) = search.folders.pop().or_else(|| search.links.pop()) else {
                break;
            };
            let new = folder
                .canonicalize()
                .map(|real| search.entered.insert(real));
            let entered = match new {
                Ok(true) => search.enter(&folder),
                Ok(false) => Ok(()),
                Err(error) => Err(error),
            };
            // A folder that may not be entered hides its scenarios, not its neighbours'.
            if let Err(error) = entered {
                search.pass_over(folder, PassedOverReason::Folder(error));
            }
        }
        search.give_out();
        // With recordings they need no word; alone they are what was meant.
        if search.given == 0 {
            for (path, kind) in std::mem::take(&mut search.beside) {
                search.pass_over(path, kind.into());
            }
        }
        search.passed_over.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(search.passed_over)
    }

    /// Looks at what is in a folder, by name.
    fn enter(&mut self, folder: &Path) -> std::io::Result<()> {
        if system::is_of_kernel(folder) {
            let why = "no files are saved there; the system makes them up";
            return Err(std::io::Error::other(why));
        }
        let mut protobuf = Vec::new();
        let mut entries = Vec::new();
        let mut read = Ok(());
        for entry in std::fs::read_dir(folder)? {
            match entry {
                Ok(entry) => entries.push(entry),
                Err(error) => read = Err(error),
            }
        }
        entries.sort_by_cached_key(DirEntry::file_name);
        let before = self.folders.len();
        for entry in &entries {
            self.look(entry, &mut protobuf);
            let full = if self.given == 0 { FIRST_PIECE } else { PIECE };
            if self.found.len() >= full {
                self.give_out();
            }
        }
        // The last one is entered next.
        self.folders[before..].reverse();
        let (scenarios, others) = commonroad::protobuf_scenarios(protobuf);
        self.found.extend(scenarios);
        for (path, why) in others {
            self.pass_over(path, why.into());
        }
        read
    }

    fn give_out(&mut self) {
        let found = std::mem::take(&mut self.found);
        self.given += found.len();
        (self.give)(found);
    }

    fn look(&mut self, entry: &DirEntry, protobuf: &mut Vec<PathBuf>) {
        let path = entry.path();
        let kind = entry.file_type();
        let link = kind.as_ref().is_ok_and(std::fs::FileType::is_symlink);
        let is_folder = match kind {
            Ok(kind) if !link => kind.is_dir(),
            _ => path.is_dir(),
        };
        if is_folder {
            if !entry.file_name().as_encoded_bytes().starts_with(b".") {
                let into = if link {
                    &mut self.links
                } else {
                    &mut self.folders
                };
                into.push(path);
            }
        } else if commonroad::is_protobuf_name(&path) {
            protobuf.push(path);
        } else if commonroad::is_xml_name(&path) {
            match commonroad::is_scenario(&path) {
                Ok(true) => self.found.push(path),
                Ok(false) => self.look_for_recordings(path),
                Err(why) => self.pass_over(path, why.into()),
            }
        } else if dispatch::is_recording_name(&path) {
            self.look_for_recordings(path);
        }
    }

    /// Takes the scenarios of a file, if it is a recording.
    fn look_for_recordings(&mut self, path: PathBuf) {
        if !dispatch::is_recording(&path) {
            match dispatch::unread_kind(&path) {
                Some(kind) if kind.found == FileKind::Data => {
                    self.pass_over(path, kind.into());
                }
                Some(kind) if kind.found == FileKind::Beside => self.beside.push((path, kind)),
                _ => {}
            }
            return;
        }
        match dispatch::scenarios_in(&path, self.ranking) {
            Ok(scenarios) => self.found.extend(scenarios),
            Err(error) => self.pass_over(path, PassedOverReason::Recording(error)),
        }
    }

    fn pass_over(&mut self, path: PathBuf, why: PassedOverReason) {
        self.passed_over.push(PassedOver { path, why });
    }
}

/// A skipped file or folder.
#[derive(Debug)]
pub struct PassedOver {
    /// Its path.
    pub path: PathBuf,
    /// Why it was.
    pub why: PassedOverReason,
}

/// Why something was skipped.
#[derive(Debug, thiserror::Error)]
pub enum PassedOverReason {
    /// A file that is not known to be a scenario.
    #[error(transparent)]
    File(#[from] Unrecognised),
    /// A recording that is damaged.
    #[error("{}", .0.message)]
    Recording(ReadError),
    /// Data of driving in a format that is not read.
    #[error("{what}, not a scenario")]
    Kind {
        /// What it is.
        what: String,
        /// What to do instead.
        instead: String,
    },
    /// A folder that could not be read.
    #[error("not searched: {}", system::error_text(.0))]
    Folder(std::io::Error),
}

impl From<Kind> for PassedOverReason {
    fn from(kind: Kind) -> Self {
        Self::Kind {
            what: kind.what,
            instead: kind.instead,
        }
    }
}

/// Describes how many files and folders these are; `None` if none.
pub(super) fn count(all: &[PassedOver]) -> Option<String> {
    let is_folder = |p: &&PassedOver| matches!(p.why, PassedOverReason::Folder(_));
    let folders = all.iter().filter(is_folder).count();
    let words = |count: usize, one: &str, many: &str| match count {
        0 => None,
        1 => Some(format!("1 {one}")),
        _ => Some(format!("{count} {many}")),
    };
    let files = words(all.len() - folders, "file", "files");
    let folders = words(folders, "folder", "folders");
    let both = files.into_iter().chain(folders).collect::<Vec<_>>();
    (!both.is_empty()).then(|| both.join(" and "))
}

impl fmt::Display for PassedOver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.path.display(), self.why)
    }
}
