//! The files that say what is being tried, and what ended a program when it was tried.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Result, Seek, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// A lock file for this program while it runs, and one file for each held subject.
#[derive(Debug)]
pub struct ActivityLocks {
    folder: PathBuf,
    path: PathBuf,
    file: File,
    held: BTreeSet<String>,
}

const RUNNING: &str = "running-";
const HELD: &str = "held-";

/// Longer files are none of ours, bytes.
const LONGEST: u64 = 1 << 20;

impl ActivityLocks {
    /// Opens the folder: what is marked by programs that are gone is held from now on.
    ///
    /// # Errors
    /// It cannot be made or written in.
    pub fn open(folder: &Path) -> Result<Self> {
        make_private(folder)?;
        let path = folder.join(format!("{RUNNING}{}", std::process::id()));
        // What a program of the same number left is taken up first.
        take_up(folder, &path);
        for entry in std::fs::read_dir(folder)?.flatten() {
            if named(&entry.path(), RUNNING) {
                take_up(folder, &entry.path());
            }
        }
        let file = OpenOptions::new()
            .create(true)
            .truncate(true)
            .write(true)
            .open(&path)?;
        // Where files cannot be locked, a program that is gone cannot be told from one that runs.
        file.try_lock().map_err(|error| match error {
            TryLockError::Error(error) => error,
            TryLockError::WouldBlock => std::io::ErrorKind::WouldBlock.into(),
        })?;
        let held = std::fs::read_dir(folder)?
            .flatten()
            .filter(|entry| named(&entry.path(), HELD))
            .filter_map(|entry| text(&mut File::open(entry.path()).ok()?))
            .map(|name| name.trim_end().to_string())
            .collect();
        Ok(Self {
            folder: folder.to_path_buf(),
            path,
            file,
            held,
        })
    }

    /// Writes down what is being tried; without room on the disk there is no mark.
    pub fn write(&mut self, names: &[&str]) {
        let mut lines = names.join("\n");
        lines.push('\n');
        let _ = self
            .file
            .rewind()
            .and_then(|()| self.file.set_len(0))
            .and_then(|()| self.file.write_all(lines.as_bytes()));
    }

    /// Whether this ended a program.
    #[must_use]
    pub fn holds(&self, name: &str) -> bool {
        self.held.contains(name)
    }

    /// Holds this from now on.
    pub fn hold(&mut self, name: &str) {
        hold(&self.folder, name);
        self.held.insert(name.to_string());
    }

    /// Holds it no longer.
    pub fn release(&mut self, name: &str) {
        if self.held.remove(name) {
            // One that cannot be removed is held again at the next start.
            let _ = std::fs::remove_file(held_file(&self.folder, name));
        }
    }
}

impl Drop for ActivityLocks {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Makes a folder that only its owner can look into.
pub fn make_private(folder: &Path) -> Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

fn named(path: &Path, begin: &str) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.is_some_and(|name| name.starts_with(begin))
}

fn held_file(folder: &Path, name: &str) -> PathBuf {
    let digest = Sha256::digest(name.as_bytes());
    let digits: String = digest.iter().take(8).map(|b| format!("{b:02x}")).collect();
    folder.join(format!("{HELD}{digits}"))
}

fn hold(folder: &Path, name: &str) {
    // Nothing can be done where nothing can be written.
    let _ = std::fs::write(held_file(folder, name), format!("{name}\n"));
}

fn text(file: &mut File) -> Option<String> {
    let mut text = String::new();
    file.take(LONGEST).read_to_string(&mut text).ok()?;
    Some(text)
}

/// Holds what a program was trying, if that program is gone: it has let go of its file.
fn take_up(folder: &Path, path: &Path) {
    let Ok(mut file) = OpenOptions::new().read(true).write(true).open(path) else {
        return;
    };
    if file.try_lock().is_err() {
        return;
    }
    let names = text(&mut file).unwrap_or_default();
    for name in names.lines().filter(|name| !name.is_empty()) {
        hold(folder, name);
    }
    let _ = std::fs::remove_file(path);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_a_program_that_is_gone_was_trying_is_held_until_released() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("marks");
        std::fs::create_dir(&place).unwrap();
        std::fs::write(place.join("running-1"), "scenario a\ntemplate b 1\n").unwrap();
        let mut marks = ActivityLocks::open(&place).unwrap();
        assert!(marks.holds("scenario a") && marks.holds("template b 1"));
        assert!(!place.join("running-1").exists());
        marks.release("scenario a");
        drop(marks);
        let marks = ActivityLocks::open(&place).unwrap();
        assert!(!marks.holds("scenario a") && marks.holds("template b 1"));
    }

    #[test]
    fn what_a_program_that_runs_is_trying_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("running-1");
        let mut file = File::create(&other).unwrap();
        file.lock().unwrap();
        file.write_all(b"scenario a\n").unwrap();
        let mut marks = ActivityLocks::open(folder.path()).unwrap();
        assert!(!marks.holds("scenario a") && other.exists());
        marks.write(&["scenario b"]);
        let own = folder
            .path()
            .join(format!("running-{}", std::process::id()));
        assert_eq!(std::fs::read_to_string(&own).unwrap(), "scenario b\n");
        drop(marks);
        assert!(!own.exists());
        drop(file);
        assert!(
            ActivityLocks::open(folder.path())
                .unwrap()
                .holds("scenario a")
        );
    }
}
