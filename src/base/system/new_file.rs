//! Saving a file: completely or not at all, never over another one unasked, and nothing left of one that is unfinished.

use std::fs::{File, Permissions};
use std::io::{self, Error, ErrorKind, Seek, Write, copy};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

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
    #[error("{path}: {}", system::error_text(source))]
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
    written: FileKind,
    /// Prefix of its temporary name.
    prefix: String,
    readers: Readers,
}

#[derive(Debug)]
enum FileKind {
    #[cfg_attr(not(target_os = "linux"), allow(dead_code))]
    Unnamed(File),
    Named(NamedTempFile, Unfinished),
}

impl FileKind {
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
const MAX_TRIES: usize = 16;

impl PartialFile {
    /// Begins a file that will be called about `name`.
    pub fn begin(folder: &Path, name: &str, readers: Readers) -> io::Result<Self> {
        let prefix = format!(".{name}");
        let written = match unnamed(folder, readers) {
            Some(file) => FileKind::Unnamed(file),
            None => FileKind::with_name(named(folder, &prefix, readers)?),
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
            FileKind::Unnamed(file) => file,
            FileKind::Named(file, _) => file.as_file(),
        }
    }

    /// Gives the file its name, in the place of another one if `overwrite`.
    pub fn place(self, target: &Path, overwrite: bool) -> io::Result<()> {
        let file = match self.written {
            FileKind::Named(file, unfinished) => {
                // From here on a signal must not remove what stands at the target.
                drop(unfinished);
                return persist(file, target, overwrite);
            }
            FileKind::Unnamed(file) => file,
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

fn persist(file: NamedTempFile, target: &Path, overwrite: bool) -> io::Result<()> {
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
fn link(file: &File, target: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let itself = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(linkat(CWD, itself, CWD, target, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(not(target_os = "linux"))]
fn link(_: &File, _: &Path) -> io::Result<()> {
    Err(ErrorKind::Unsupported.into())
}

/// A link cannot replace a file, so it gets a temporary name first.
fn link_over(file: &File, prefix: &str, target: &Path) -> io::Result<()> {
    // One that is locked is not removed by another program in that moment; without locks nothing is removed.
    let _ = file.try_lock();
    let folder = folder_of(target);
    for _ in 0..MAX_TRIES {
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
fn named(folder: &Path, prefix: &str, readers: Readers) -> io::Result<NamedTempFile> {
    sweep(folder, prefix);
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(ENDING).rand_bytes(LETTERS);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(mode(readers)));
    }
    let mut file = builder.tempfile_in(folder)?;
    for _ in 0..MAX_TRIES {
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

static FILES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A file in the making; it is none any more when this is dropped.
#[derive(Debug)]
pub struct Unfinished(PathBuf);

impl Unfinished {
    /// Begins to keep the file, or the folder with all that is in it, in mind.
    #[must_use]
    pub fn begin(path: &Path) -> Self {
        files().push(path.to_path_buf());
        Self(path.to_path_buf())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let mut files = files();
        if let Some(place) = files.iter().position(|path| *path == self.0) {
            files.swap_remove(place);
        }
    }
}

/// Removes every file in the making: for a program that ends now, whatever it is doing.
pub fn remove_unfinished() {
    for path in files().drain(..) {
        // It may be in its place, or gone, already.
        let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
    }
}

fn files() -> MutexGuard<'static, Vec<PathBuf>> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    pub fn names(folder: &Path) -> Vec<String> {
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

#[cfg(test)]
mod temporary_file_tests {
    #![allow(clippy::unwrap_used)]

    use super::tests::names;
    use super::*;
    use std::io::Write;

    /// A part as it is where the system knows no files without a name.
    fn with_a_name(folder: &Path) -> PartialFile {
        PartialFile {
            written: FileKind::with_name(named(folder, ".a.csv", Readers::Umask).unwrap()),
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
