//! Saving a file: whole or not at all, and never over another one unasked.

use std::fs::Permissions;
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::temporary_file::{PartialFile, Readers};
use crate::system;

/// Why a file was not saved. An existing file at its path is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// There is something at the path already, and overwriting was not asked for.
    #[error("{0}: already exists; choose another name, or overwrite it")]
    Exists(PathBuf),
    /// What is at the path is no file that could be replaced: a folder, a pipe, a device.
    #[error("{0}: not a regular file, so it cannot be replaced")]
    NotAFile(PathBuf),
    /// The folder that the file is to lie in does not exist.
    #[error("{file}: no folder {folder}; create it first", file = .0.display(), folder = .1.display())]
    NoFolder(PathBuf, PathBuf),
    /// The system refused.
    #[error("{path}: {}", system::words(source))]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: Error,
    },
}

/// A file in the making: nothing is at its path before [`NewFile::finish`], and nothing stays behind if that is not
/// called.
///
/// What is written goes to a file without a name, which gets its own at the end: who looks sees the old contents or all
/// of the new ones, also after a crash, and a program that is killed leaves nothing. Elsewhere than on Linux a
/// part with a name may stay, which the next write of the same file removes.
#[derive(Debug)]
pub struct NewFile {
    part: PartialFile,
    path: PathBuf,
    /// Where a symbolic link at the path leads.
    target: PathBuf,
    replaced: Option<Permissions>,
    overwrite: bool,
}

impl NewFile {
    /// Begins the file `path`, in a folder that exists.
    ///
    /// With `overwrite` a file at `path` is replaced and its permissions stay; a symbolic link stays and the
    /// file it leads to is replaced. Without it nothing is ever replaced, not even what another program puts there
    /// meanwhile.
    ///
    /// # Errors
    /// See [`SaveError`].
    pub fn begin(path: &Path, overwrite: bool) -> Result<Self, SaveError> {
        Self::begin_for(path, overwrite, Readers::Umask)
    }

    /// Begins a file that replaces what is at `path` and that only the user may read.
    ///
    /// # Errors
    /// See [`SaveError`].
    pub fn begin_private(path: &Path) -> Result<Self, SaveError> {
        Self::begin_for(path, true, Readers::User)
    }

    fn begin_for(path: &Path, overwrite: bool, readers: Readers) -> Result<Self, SaveError> {
        let io = |source| SaveError::Io {
            path: path.to_path_buf(),
            source,
        };
        let present = match path.symlink_metadata() {
            Ok(_) => true,
            Err(e) if e.kind() == ErrorKind::NotFound => false,
            Err(e) => return Err(io(e)),
        };
        if present && !overwrite {
            return Err(SaveError::Exists(path.to_path_buf()));
        }
        let target = if present {
            path.canonicalize().map_err(io)?
        } else {
            path.to_path_buf()
        };
        let replaced = present.then(|| target.metadata()).transpose().map_err(io)?;
        if replaced.as_ref().is_some_and(|m| !m.is_file()) {
            return Err(SaveError::NotAFile(path.to_path_buf()));
        }
        let name = path
            .file_name()
            .ok_or_else(|| io(Error::new(ErrorKind::InvalidInput, "no file's name")))?;
        let folder = match target.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(SaveError::NoFolder(
                path.to_path_buf(),
                folder.to_path_buf(),
            ));
        }
        let name: String = name.to_string_lossy().chars().take(40).collect();
        let replaced = replaced.filter(|_| readers == Readers::Umask);
        Ok(Self {
            part: PartialFile::begin(folder, &name, readers).map_err(io)?,
            path: path.to_path_buf(),
            target,
            replaced: replaced.map(|m| m.permissions()),
            overwrite,
        })
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// See [`SaveError`]; nothing is left behind.
    pub fn finish(self) -> Result<(), SaveError> {
        let path = self.path;
        let io = |source| SaveError::Io {
            path: path.clone(),
            source,
        };
        let file = self.part.file();
        if let Some(permissions) = self.replaced {
            file.set_permissions(permissions).map_err(io)?;
        }
        file.sync_all().map_err(io)?;
        let placed = self.part.place(&self.target, self.overwrite);
        placed.map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => SaveError::Exists(path.clone()),
            _ => io(error),
        })
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.part.file().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.part.file().flush()
    }
}

/// Saves `bytes` as the file `path`, in a folder that exists; see [`NewFile`].
///
/// # Errors
/// See [`SaveError`]; nothing is left behind.
pub fn save(path: &Path, bytes: &[u8], overwrite: bool) -> Result<(), SaveError> {
    write(NewFile::begin(path, overwrite)?, path, bytes)
}

/// Saves `bytes` as the file `path`, in the place of what is there, for the user alone.
///
/// # Errors
/// See [`SaveError`]; nothing is left behind.
pub fn save_private(path: &Path, bytes: &[u8]) -> Result<(), SaveError> {
    write(NewFile::begin_private(path)?, path, bytes)
}

fn write(mut file: NewFile, path: &Path, bytes: &[u8]) -> Result<(), SaveError> {
    file.write_all(bytes).map_err(|source| SaveError::Io {
        path: path.to_path_buf(),
        source,
    })?;
    file.finish()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn saves_and_leaves_nothing_beside() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xml");
        save(&path, b"one", false).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        save(&path, b"two", true).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        save(&folder.path().join("new.xml"), b"three", true).unwrap();
        assert_eq!(names(folder.path()), ["a.xml", "new.xml"]);
    }

    #[test]
    fn what_is_not_finished_was_never_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut file = NewFile::begin(&path, false).unwrap();
        file.write_all(b"half").unwrap();
        assert!(!path.exists());
        drop(file);
        assert!(names(folder.path()).is_empty());
        let mut file = NewFile::begin(&path, false).unwrap();
        file.write_all(b"yours").unwrap();
        std::fs::write(&path, b"mine").unwrap();
        assert!(matches!(file.finish(), Err(SaveError::Exists(_))));
        assert_eq!(std::fs::read(&path).unwrap(), b"mine");
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    #[test]
    fn nothing_is_replaced_unasked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xml");
        std::fs::write(&path, b"mine").unwrap();
        let error = save(&path, b"yours", false).unwrap_err();
        assert!(matches!(error, SaveError::Exists(_)), "{error}");
        assert!(error.to_string().contains("a.xml"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"mine");
        assert_eq!(names(folder.path()), ["a.xml"]);
    }

    #[test]
    fn of_many_at_once_one_wins() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xml");
        let won: Vec<u8> = std::thread::scope(|scope| {
            let tasks: Vec<_> = (0..8u8)
                .map(|i| {
                    let path = &path;
                    scope.spawn(move || save(path, &[i; 1000], false).is_ok().then_some(i))
                })
                .collect();
            tasks
                .into_iter()
                .filter_map(|t| t.join().unwrap())
                .collect()
        });
        assert_eq!(won.len(), 1);
        assert_eq!(std::fs::read(&path).unwrap(), [won[0]; 1000]);
    }

    #[test]
    fn folders_are_neither_replaced_nor_made() {
        let folder = tempfile::tempdir().unwrap();
        let error = save(folder.path(), b"x", true).unwrap_err();
        assert!(matches!(error, SaveError::NotAFile(_)), "{error}");
        let error = save(&folder.path().join("no/a.xml"), b"x", false).unwrap_err();
        assert!(matches!(error, SaveError::NoFolder(..)), "{error}");
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn what_is_private_is_for_the_user_alone_also_where_it_was_not() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("session.json");
        let mode = || path.metadata().unwrap().permissions().mode() & 0o777;
        save_private(&path, b"one").unwrap();
        assert_eq!(mode(), 0o600);
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o644)).unwrap();
        save_private(&path, b"two").unwrap();
        assert_eq!(mode(), 0o600);
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_and_links_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a.xml"), folder.path().join("link.xml"));
        save(&path, b"one", false).unwrap();
        let plain = folder.path().join("plain");
        std::fs::write(&plain, b"").unwrap();
        let mode = |p: &Path| p.metadata().unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&plain), "as open as any new file");
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o666)).unwrap();
        symlink("a.xml", &link).unwrap();
        save(&link, b"two", true).unwrap();
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(mode(&path) & 0o777, 0o666);
    }
}
