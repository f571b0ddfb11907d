//! One scenario of a file that holds several: `FILE#PART`.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

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
    pub fn of(path: &Path) -> Self {
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
    Address::of(path).file
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
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_what_follows_a_file_that_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.tfrecord");
        std::fs::write(&file, "").unwrap();
        let odd = folder.path().join("b#1");
        std::fs::write(&odd, "").unwrap();
        let of = |path: &Path| {
            let address = Address::of(path);
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
}
