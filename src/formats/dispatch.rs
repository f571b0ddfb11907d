//! The formats of scenarios: which one a file is, the scenarios in it (`FILE#PART`), and opening one.
//!
//! A new format is a [`Format`] and a line in [`FORMATS`].

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use nearmiss_scene::scenario::Scenario;

use super::commonroad::{self, ReadError, beginning_of_file};
use super::recordings::{self, LongRecording, RankedMoment, WindowList};
use super::unread::{self, Unread};

/// The scenarios in a file.
pub(super) enum Parts {
    /// The file as a whole is one.
    One,
    /// Several, with names.
    Named(Vec<String>),
    /// A recording of minutes, of which windows are.
    Long(Box<LongRecording>),
    /// One that is larger than memory, a stretch after the other.
    Stretches(Stretches),
}

/// Gives the next stretch of a recording.
pub(super) type Stretches = Box<dyn Iterator<Item = Result<LongRecording, ReadError>>>;

/// Around which moments of a long recording windows are listed.
pub type Ranking<'a> = &'a (dyn Fn(&LongRecording) -> Vec<RankedMoment> + Sync);

/// What of that which the user says of every table applies to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Applies {
    /// None of it.
    Nothing,
    /// The map.
    Map,
    /// The map, the columns and the rate.
    All,
}

/// A format of scenarios.
pub(super) trait Format: Sync {
    /// Whether a file begins as those of this format do; `head` is its first [`HEAD`] bytes or all of it.
    fn recognises(&self, path: &Path, head: &[u8]) -> bool;

    /// Whether a search of a folder takes a file of this format; some say what is wrong with files of others, too, when
    /// these are named.
    fn is_found(&self, path: &Path, head: &[u8]) -> bool {
        self.recognises(path, head)
    }

    /// What of that which the user says of tables applies to a file of this format.
    fn applies(&self, _: &Path, _: &[u8]) -> Applies {
        Applies::Nothing
    }

    /// The scenarios in a file, without reading each; by default it is one.
    ///
    /// # Errors
    /// The file is damaged.
    fn parts(&self, _: &Path) -> Result<Parts, ReadError> {
        Ok(Parts::One)
    }

    /// Reads one scenario.
    ///
    /// # Errors
    /// It is damaged or not there, or of several none is named.
    fn open(&self, address: &Address) -> Result<Scenario, ReadError>;
}

/// All formats; the last one takes every other file, and says what is wrong with it.
const FORMATS: [&dyn Format; 13] = [
    // Before those that look for XML: a map may be in it.
    &recordings::Osi,
    &recordings::Waymo,
    &recordings::Argoverse,
    &recordings::LevelX,
    &recordings::Sumo,
    &recordings::OpenScenario,
    &recordings::NuPlan,
    &recordings::NuScenes,
    &recordings::Py123d,
    &recordings::Tables,
    &recordings::MapAlone,
    &Unread,
    &CommonRoad,
];

/// As much of a file as tells its format, bytes: SUMO writes all its options before the root.
pub(super) const HEAD: usize = 16 << 10;

struct CommonRoad;

impl Format for CommonRoad {
    fn recognises(&self, _: &Path, _: &[u8]) -> bool {
        true
    }

    /// What is wrong with files that are no scenarios is said when they are read.
    fn applies(&self, path: &Path, _: &[u8]) -> Applies {
        match commonroad::is_scenario(path) {
            Ok(true) => Applies::Nothing,
            _ => Applies::All,
        }
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

/// What of that which the user says of tables applies to a file; all of it where it is a folder, in which tables may be.
pub(super) fn applies(file: &Path) -> Applies {
    let Ok(head) = beginning_of_file(file, HEAD) else {
        return Applies::All;
    };
    format_of(file).applies(file, &head)
}

/// Reads the scenario at a path, of whatever format.
pub(super) fn open(path: &Path) -> Result<Scenario, ReadError> {
    let address = Address::from_path(path);
    format_of(&address.file).open(&address)
}

/// Whether a file is of a format other than CommonRoad.
pub(super) fn is_recording(file: &Path) -> bool {
    let Ok(head) = beginning_of_file(file, HEAD) else {
        return false;
    };
    let others = &FORMATS[..FORMATS.len() - 1];
    others.iter().any(|format| format.is_found(file, &head))
}

/// How recordings are called, those that are read and the others that people have.
const NAMES: [&str; 21] = [
    ".parquet",
    ".csv",
    ".csv.gz",
    ".tsv",
    ".tsv.gz",
    ".txt",
    ".txt.gz",
    ".jsonl",
    ".jsonl.gz",
    ".json.gz",
    ".zst",
    ".xosc",
    ".db",
    ".osm",
    ".bag",
    ".mcap",
    ".feather",
    ".arrow",
    ".osi",
    ".sumocfg",
    "scene.json",
];

/// What a file is, if it is of a known kind that is not read.
pub(super) fn unread_kind(file: &Path) -> Option<unread::Kind> {
    let head = beginning_of_file(file, HEAD).ok()?;
    unread::kind(file, &head)
}

/// Whether a file's name is one that recordings have; their contents decide.
pub(super) fn is_recording_name(path: &Path) -> bool {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().to_lowercase());
    // Shards are called `x.tfrecord-00000-of-00150`.
    name.is_some_and(|name| {
        name.contains(".tfrecord") || NAMES.iter().any(|ending| name.ends_with(ending))
    })
}

/// The paths of the scenarios in a file: the file itself, or one for each of them; of a long recording the windows that
/// `ranking` names.
pub(super) fn scenarios_in(path: &Path, ranking: Ranking<'_>) -> Result<Vec<PathBuf>, ReadError> {
    let address = Address::from_path(path);
    let whole = || Ok(vec![path.to_path_buf()]);
    if address.part.is_some() {
        return whole();
    }
    let names = match format_of(path).parts(path)? {
        Parts::One => return whole(),
        Parts::Named(names) => names,
        Parts::Long(recording) => windows(std::iter::once(Ok(*recording)), ranking)?,
        Parts::Stretches(all) => windows(all, ranking)?,
    };
    if names.is_empty() {
        return whole();
    }
    let path = |part: &String| Address::path(&address.file, part);
    Ok(names.iter().map(path).collect())
}

fn windows(
    stretches: impl Iterator<Item = Result<LongRecording, ReadError>>,
    ranking: Ranking<'_>,
) -> Result<Vec<String>, ReadError> {
    let mut list = WindowList::default();
    for stretch in stretches {
        let recording = stretch?;
        list.add(&recording, &ranking(&recording));
    }
    Ok(list.addresses())
}

/// The path of the scenario in a file that could have several and has one; any other path stays as it is, also of what
/// cannot be read.
pub fn only_part(path: &Path) -> PathBuf {
    let address = Address::from_path(path);
    let parts = match address.part {
        Some(_) => None,
        None => format_of(&address.file).parts(&address.file).ok(),
    };
    match parts {
        Some(Parts::Named(names)) if names.len() == 1 => Address::path(&address.file, &names[0]),
        _ => path.to_path_buf(),
    }
}

/// Between the file and what of it is meant.
const SEPARATOR: char = '#';

/// A file, and which of its scenarios is meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Address {
    /// The file.
    pub file: PathBuf,
    /// The scenario in it; `None` where the file is one.
    pub part: Option<String>,
}

impl Address {
    /// What a path means. A file whose own name has a `#` is that file.
    pub fn from_path(path: &Path) -> Self {
        let whole = || Self {
            file: path.to_path_buf(),
            part: None,
        };
        let text = path.to_string_lossy();
        let Cow::Borrowed(text) = text else {
            return whole();
        };
        if !text.contains(SEPARATOR) || path.symlink_metadata().is_ok() {
            return whole();
        }
        // A part may have a `#` in it as well: the first file that is there is meant.
        let mut splits = text.match_indices(SEPARATOR).map(|(at, _)| at);
        let found = splits.find(|at| Path::new(&text[..*at]).is_file());
        found.map_or_else(whole, |at| Self {
            file: PathBuf::from(&text[..at]),
            part: Some(text[at + SEPARATOR.len_utf8()..].to_string()),
        })
    }

    /// The path of a part of a file.
    pub fn path(file: &Path, part: &str) -> PathBuf {
        let mut path = file.as_os_str().to_os_string();
        path.push(format!("{SEPARATOR}{part}"));
        PathBuf::from(path)
    }
}

/// The file in which the scenario at a path lies: the path itself, or what is before its `#`.
pub(super) fn file_of(path: &Path) -> PathBuf {
    Address::from_path(path).file
}

/// A part as a part of a file's name.
pub(super) fn plain_name(part: &str) -> String {
    let plain = |c: char| {
        if c.is_alphanumeric() || matches!(c, '.' | '_' | '-') {
            c
        } else {
            '-'
        }
    };
    part.chars().map(plain).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn a_part_is_what_follows_a_file_that_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.tfrecord");
        std::fs::write(&file, "").unwrap();
        let odd = folder.path().join("b#1");
        std::fs::write(&odd, "").unwrap();
        let of = |path: &Path| {
            let address = Address::from_path(path);
            (address.file, address.part)
        };
        assert_eq!(of(&file), (file.clone(), None));
        let part = Address::path(&file, "63#7");
        assert_eq!(of(&part), (file, Some("63#7".into())));
        assert_eq!(of(&odd), (odd.clone(), None));
        let part = Address::path(&odd, "2");
        assert_eq!(of(&part), (odd, Some("2".into())));
        let missing = folder.path().join("c#1");
        assert_eq!(of(&missing), (missing, None));
        assert_eq!(plain_name("track=12@34.0s"), "track-12-34.0s");
    }

    #[test]
    fn packed_tables_have_names_of_recordings() {
        for name in [
            "a.csv",
            "A.CSV.GZ",
            "a.tsv",
            "a.txt",
            "a.jsonl",
            "a.json.gz",
            "a.csv.zst",
        ] {
            assert!(is_recording_name(Path::new(name)), "{name}");
        }
        assert!(!is_recording_name(Path::new("a.rs")));
    }
}
