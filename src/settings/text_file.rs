//! A small text file of the user's, for others to understand.

use std::io;
use std::path::Path;

use nearmiss_base::system;

/// A text with the name of its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextFile {
    /// Where it is from, for people.
    pub file: String,
    /// What is in it.
    pub text: String,
}

/// No file that a person wrote by hand is larger, bytes.
const MAX_BYTES: u64 = 1 << 20;

impl TextFile {
    /// Reads a regular file of up to 1 MiB.
    ///
    /// # Errors
    /// It cannot be read, is larger, or is no UTF-8: with its name.
    pub fn read(path: &Path) -> Result<Self, String> {
        let file = path.display().to_string();
        match text(path) {
            Ok(text) => Ok(Self { file, text }),
            Err(error) => Err(format!("{file}: {error}")),
        }
    }

    /// Reads a file if it is there.
    ///
    /// # Errors
    /// Like [`Self::read`], but for a file that does not exist.
    pub fn read_if_there(path: &Path) -> Result<Option<Self>, String> {
        let file = path.display().to_string();
        match text_if_there(path) {
            Ok(text) => Ok(text.map(|text| Self { file, text })),
            Err(error) => Err(format!("{file}: {error}")),
        }
    }
}

/// What is in a file if it is there; errors do not name it.
pub(super) fn text_if_there(path: &Path) -> Result<Option<String>, String> {
    match std::fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        _ => text(path).map(Some),
    }
}

fn text(path: &Path) -> Result<String, String> {
    let bytes = system::read_file(path, MAX_BYTES).map_err(|error| system::error_text(&error))?;
    system::text_of(bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_is_there_is_read_and_what_cannot_be_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.toml");
        assert_eq!(TextFile::read_if_there(&path), Ok(None));
        assert!(TextFile::read(&path).unwrap_err().contains("t.toml: "));
        std::fs::write(&path, "a = 1").unwrap();
        assert_eq!(TextFile::read(&path).unwrap().text, "a = 1");
        std::fs::write(&path, [0xff]).unwrap();
        assert!(
            TextFile::read_if_there(&path)
                .unwrap_err()
                .contains("UTF-8")
        );
        std::fs::write(&path, vec![b' '; 1 + (1 << 20)]).unwrap();
        assert!(TextFile::read(&path).unwrap_err().contains("1 MiB"));
        assert!(
            TextFile::read(folder.path())
                .unwrap_err()
                .contains("folder")
        );
    }
}
