//! What is written of a file before it has its name.

use std::fs::File;
use std::io::{ErrorKind, Result, Seek, copy};
use std::path::Path;

use tempfile::NamedTempFile;

use super::Unfinished;

/// Read permissions of a new file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Readers {
    /// Who may read every new file of the user's.
    Umask,
    /// The user alone.
    User,
}

/// A file that is being written, in the folder where it will lie.
///
/// On Linux it has no name, so that nothing of it stays when the program is killed. Where the system or the file system
/// has no such files it is called `.NAME` and six letters and `.part`, and locked as long as it is written: one that is
/// not locked belongs to a program that was killed, and is removed when the same file is written the next time.
#[derive(Debug)]
pub struct PartialFile {
    written: Written,
    /// Prefix of its temporary name.
    prefix: String,
    readers: Readers,
}

#[derive(Debug)]
enum Written {
    #[cfg_attr(not(target_os = "linux"), allow(dead_code))]
    Unnamed(File),
    Named(NamedTempFile, Unfinished),
}

impl Written {
    /// A file that is removed when a signal ends the program.
    fn with_name(file: NamedTempFile) -> Self {
        let unfinished = Unfinished::begin(file.path());
        Self::Named(file, unfinished)
    }
}

/// How the name of a part ends.
const ENDING: &str = ".part";

/// Letters between the beginning and the ending.
const LETTERS: usize = 6;

/// Tries to find a name that is free, or that stays with a file while it is locked.
const TRIES: usize = 16;

impl PartialFile {
    /// Begins a file that will be called about `name`.
    pub fn begin(folder: &Path, name: &str, readers: Readers) -> Result<Self> {
        let prefix = format!(".{name}");
        let written = match unnamed(folder, readers) {
            Some(file) => Written::Unnamed(file),
            None => Written::with_name(named(folder, &prefix, readers)?),
        };
        Ok(Self {
            written,
            prefix,
            readers,
        })
    }

    /// The file.
    pub fn file(&self) -> &File {
        match &self.written {
            Written::Unnamed(file) => file,
            Written::Named(file, _) => file.as_file(),
        }
    }

    /// Gives the file its name, in the place of another one if `overwrite`.
    pub fn place(self, target: &Path, overwrite: bool) -> Result<()> {
        let file = match self.written {
            Written::Named(file, unfinished) => {
                // From here on a signal must not remove what stands at the target.
                drop(unfinished);
                return persist(file, target, overwrite);
            }
            Written::Unnamed(file) => file,
        };
        let linked = if overwrite {
            link_over(&file, &self.prefix, target)
        } else {
            link(&file, target)
        };
        match linked {
            // There is no /proc, or the file system knows no links.
            Err(error) if error.kind() != ErrorKind::AlreadyExists => {}
            done => return done,
        }
        let folder = folder_of(target);
        let mut named = named(folder, &self.prefix, self.readers)?;
        let mut file = file;
        file.rewind()?;
        copy(&mut file, named.as_file_mut())?;
        let permissions = file.metadata()?.permissions();
        named.as_file().set_permissions(permissions)?;
        named.as_file().sync_all()?;
        persist(named, target, overwrite)
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

fn persist(file: NamedTempFile, target: &Path, overwrite: bool) -> Result<()> {
    let persisted = if overwrite {
        file.persist(target)
    } else {
        file.persist_noclobber(target)
    };
    persisted.map(drop).map_err(|error| error.error)
}

#[cfg(target_os = "linux")]
fn unnamed(folder: &Path, readers: Readers) -> Option<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let flags = rustix::fs::OFlags::TMPFILE.bits().cast_signed();
    let opened = File::options()
        .read(true)
        .write(true)
        .mode(mode(readers))
        .custom_flags(flags)
        .open(folder);
    // Why nothing can be written there is said where a file with a name is tried.
    opened.ok()
}

#[cfg(not(target_os = "linux"))]
fn unnamed(_: &Path, _: Readers) -> Option<File> {
    None
}

#[cfg(target_os = "linux")]
fn link(file: &File, target: &Path) -> Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let itself = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(linkat(CWD, itself, CWD, target, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(not(target_os = "linux"))]
fn link(_: &File, _: &Path) -> Result<()> {
    Err(ErrorKind::Unsupported.into())
}

/// A link cannot replace a file, so it gets a temporary name first.
fn link_over(file: &File, prefix: &str, target: &Path) -> Result<()> {
    // One that is locked is not removed by another program in that moment; without locks nothing is removed.
    let _ = file.try_lock();
    let folder = folder_of(target);
    for _ in 0..TRIES {
        let letters: String = std::iter::repeat_with(fastrand::alphanumeric)
            .take(LETTERS)
            .collect();
        let between = folder.join(format!("{prefix}{letters}{ENDING}"));
        match link(file, &between) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
            Ok(()) => {
                return std::fs::rename(&between, target)
                    .inspect_err(|_| drop(std::fs::remove_file(&between)));
            }
        }
    }
    Err(ErrorKind::Other.into())
}

/// A file with a name, locked.
fn named(folder: &Path, prefix: &str, readers: Readers) -> Result<NamedTempFile> {
    sweep(folder, prefix);
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(ENDING).rand_bytes(LETTERS);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(mode(readers)));
    }
    let mut file = builder.tempfile_in(folder)?;
    for _ in 0..TRIES {
        // Where there are no locks nothing is swept either.
        let locked = file.as_file().try_lock().is_ok();
        if !locked || file.path().exists() {
            break;
        }
        // Another program took it for a left-over before it was locked.
        file = builder.tempfile_in(folder)?;
    }
    Ok(file)
}

/// Removes what killed programs left of a file. What cannot be removed stays; it does no harm.
fn sweep(folder: &Path, prefix: &str) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let letters = name
            .to_str()
            .and_then(|name| name.strip_prefix(prefix)?.strip_suffix(ENDING));
        let is_part = letters
            .is_some_and(|l| l.len() == LETTERS && l.bytes().all(|b| b.is_ascii_alphanumeric()));
        if !is_part || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let path = entry.path();
        let abandoned = super::open_file(&path).is_ok_and(|file| file.try_lock().is_ok());
        if abandoned {
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(unix)]
fn mode(readers: Readers) -> u32 {
    match readers {
        // Less the user's mask, as every program makes its files.
        Readers::Umask => 0o666,
        Readers::User => 0o600,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::io::Write;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// A part as it is where the system knows no files without a name.
    fn with_a_name(folder: &Path) -> PartialFile {
        PartialFile {
            written: Written::with_name(named(folder, ".a.csv", Readers::Umask).unwrap()),
            prefix: ".a.csv".into(),
            readers: Readers::Umask,
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_that_is_being_written_has_no_name() {
        let folder = tempfile::tempdir().unwrap();
        let part = PartialFile::begin(folder.path(), "a.csv", Readers::Umask).unwrap();
        part.file().write_all(b"half").unwrap();
        assert_eq!(names(folder.path()), [""; 0]);
        part.place(&folder.path().join("a.csv"), true).unwrap();
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    #[test]
    fn what_a_killed_program_left_is_removed_and_what_is_being_written_is_not() {
        let folder = tempfile::tempdir().unwrap();
        for left in [".a.csvabc123.part", ".b.csvabc123.part", ".a.csv-abc1.part"] {
            std::fs::write(folder.path().join(left), b"half").unwrap();
        }
        let first = with_a_name(folder.path());
        let second = with_a_name(folder.path());
        let there = names(folder.path());
        assert!(
            !there.contains(&".a.csvabc123.part".to_string()),
            "{there:?}"
        );
        assert!(
            there.contains(&".b.csvabc123.part".to_string()),
            "{there:?}"
        );
        assert!(there.contains(&".a.csv-abc1.part".to_string()), "{there:?}");
        assert_eq!(there.len(), 4, "both are being written: {there:?}");
        first.file().write_all(b"first").unwrap();
        second.file().write_all(b"second").unwrap();
        let target = folder.path().join("a.csv");
        first.place(&target, false).unwrap();
        let error = second.place(&target, false).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::AlreadyExists);
        assert_eq!(std::fs::read(&target).unwrap(), b"first");
        assert_eq!(names(folder.path()).len(), 3);
    }
}
