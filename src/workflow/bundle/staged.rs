//! The files of a bundle on their way into a folder: all of them are written beside it before one is in its place.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::BundleError;
use nearmiss_base::system::Unfinished;

/// Files that are written and not yet in their places. They are gone when this is dropped.
pub(super) struct Staged {
    folder: TempDir,
    /// Names, with `/` between the parts.
    names: Vec<String>,
    /// What a signal that ends the program removes.
    _unfinished: Unfinished,
}

impl Staged {
    /// Begins on the disk where `into` is, or will be.
    pub fn begin(into: &Path) -> Result<Self, BundleError> {
        let mut there = into;
        while let (false, Some(above)) = (there.is_dir(), there.parent()) {
            there = above;
        }
        let folder = tempfile::Builder::new()
            .prefix(".")
            .suffix(".part")
            .tempdir_in(there)
            .map_err(|source| BundleError::io(there, source))?;
        Ok(Self {
            _unfinished: Unfinished::begin(folder.path()),
            folder,
            names: Vec::new(),
        })
    }

    /// Where the file with this name is meanwhile.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn add(&mut self, name: &str, content: &mut dyn Read) -> Result<(), BundleError> {
        let path = self.path(name);
        let mut write = || {
            path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
            let mut file = File::create_new(&path)?;
            io::copy(content, &mut file)?;
            file.flush()?;
            file.sync_all()
        };
        write().map_err(|source| BundleError::io(&path, source))?;
        self.names.push(name.into());
        Ok(())
    }

    /// Puts all files into their places below `into`, and none where one cannot be: nothing is replaced.
    pub fn place(self, into: &Path) -> Result<usize, BundleError> {
        let mut placed = Placed::default();
        for name in &self.names {
            let target = into.join(name);
            let moved = { target.parent() }
                .map_or(Ok(()), |folder| placed.make_folder(folder))
                .and_then(|()| move_to(&self.path(name), &target));
            if let Err(source) = moved {
                placed.remove();
                return Err(match source.kind() {
                    ErrorKind::AlreadyExists => BundleError::InTheWay(target),
                    _ => BundleError::io(&target, source),
                });
            }
            placed.files.push(target);
        }
        Ok(placed.files.len())
    }
}

/// What was put into its place so far.
#[derive(Default)]
struct Placed {
    files: Vec<PathBuf>,
    /// The folders that were made for them, outer ones first.
    folders: Vec<PathBuf>,
}

impl Placed {
    fn make_folder(&mut self, folder: &Path) -> io::Result<()> {
        let missing = folder.ancestors().take_while(|folder| !folder.exists());
        let mut missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
        missing.reverse();
        std::fs::create_dir_all(folder)?;
        self.folders.extend(missing);
        Ok(())
    }

    /// As if nothing had been placed.
    fn remove(&self) {
        // What cannot be removed was changed by somebody else meanwhile.
        for file in &self.files {
            let _ = std::fs::remove_file(file);
        }
        for folder in self.folders.iter().rev() {
            let _ = std::fs::remove_dir(folder);
        }
    }
}

/// Moves a file on one disk to where nothing is.
fn move_to(from: &Path, to: &Path) -> io::Result<()> {
    match std::fs::hard_link(from, to) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(error),
        // The file system knows no second names.
        Err(_) if to.symlink_metadata().is_err() => std::fs::rename(from, to),
        linked => linked,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn all_files_are_placed_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let into = folder.path().join("new/place");
        let names = || {
            let entries = std::fs::read_dir(folder.path()).unwrap();
            entries.map(|e| e.unwrap().file_name()).collect::<Vec<_>>()
        };
        let staged = |into: &Path| {
            let mut staged = Staged::begin(into).unwrap();
            for name in ["a.xml", "deep/down/b.xml", "c.xml"] {
                staged.add(name, &mut name.as_bytes()).unwrap();
            }
            staged
        };
        // One of their folders is a file, which is seen when others are in their places.
        std::fs::create_dir_all(&into).unwrap();
        std::fs::write(into.join("deep"), "mine").unwrap();
        assert!(staged(&into).place(&into).is_err());
        assert!(!into.join("a.xml").exists());
        std::fs::remove_file(into.join("deep")).unwrap();
        std::fs::write(into.join("c.xml"), "mine").unwrap();
        let error = staged(&into).place(&into);
        assert!(matches!(error, Err(BundleError::InTheWay(_))));
        assert!(!into.join("deep").exists() && !into.join("a.xml").exists());
        assert_eq!(std::fs::read(into.join("c.xml")).unwrap(), b"mine");
        std::fs::remove_dir_all(folder.path().join("new")).unwrap();
        assert_eq!(staged(&into).place(&into).unwrap(), 3);
        assert_eq!(
            std::fs::read(into.join("deep/down/b.xml")).unwrap(),
            b"deep/down/b.xml"
        );
        drop(staged(&into));
        assert_eq!(names(), ["new"]);
        assert_eq!(std::fs::read_dir(&into).unwrap().count(), 3);
    }
}
