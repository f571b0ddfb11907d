//! Read-only access: opens a store of another user, or on a read-only disk, and checks its file without changing it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use nearmiss_base::system;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use tempfile::TempDir;

use super::database::{BEFORE, VERSION, check_version};
use super::{Store, StoreError, database};

/// What SQLite keeps beside a file: its write-ahead log, that log's index, and a journal of other modes.
const SIDE_FILE_ENDINGS: [&str; 3] = ["-wal", "-shm", "-journal"];

/// The file and those that SQLite keeps beside it.
pub fn files(path: &Path) -> impl Iterator<Item = PathBuf> + '_ {
    let beside = SIDE_FILE_ENDINGS
        .iter()
        .map(|ending| side_file(path, ending));
    std::iter::once(path.to_path_buf()).chain(beside)
}

fn side_file(path: &Path, ending: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(ending);
    name.into()
}

/// Whether a file can be opened as a store; a pipe or a device would be waited for.
///
/// # Errors
/// What is in the way.
pub fn check(path: &Path) -> Result<(), StoreError> {
    for file in files(path) {
        match system::check_file(&file) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
                let file = file.display().to_string();
                return Err(StoreError::Open { file, source });
            }
            _ => {}
        }
    }
    Ok(())
}

/// A connection that only reads.
#[derive(Debug)]
pub struct Reading {
    /// The connection.
    pub connection: Connection,
    /// Where the copy lies that is read in place of the file itself.
    pub copy: Option<TempDir>,
}

/// Opens a file without writing to it or beside it.
///
/// SQLite reads a write-ahead log only through an index beside it. Where there is none and none can be made, a file
/// without a log is read as one that does not change, and one with a log is copied.
///
/// # Errors
/// It cannot be read, or is no SQLite file.
pub fn open(path: &Path) -> Result<Reading, StoreError> {
    check(path)?;
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let error = match Connection::open_with_flags(path, flags).and_then(looked_at) {
        Ok(connection) => {
            return Ok(Reading {
                connection,
                copy: None,
            });
        }
        Err(error) if !is_refusal(&error) => return Err(error.into()),
        Err(error) => error,
    };
    let log = side_file(path, "-wal")
        .metadata()
        .map_or(0, |log| log.len());
    if let Some(unchanging) = unchanging(path).filter(|_| log == 0) {
        let flags = flags | OpenFlags::SQLITE_OPEN_URI;
        if let Ok(connection) = Connection::open_with_flags(unchanging, flags).and_then(looked_at) {
            return Ok(Reading {
                connection,
                copy: None,
            });
        }
    }
    let Ok((folder, file)) = copied(path) else {
        return Err(error.into());
    };
    Ok(Reading {
        connection: looked_at(Connection::open(file)?)?,
        copy: Some(folder),
    })
}

/// SQLite opens a file when it is first read.
fn looked_at(connection: Connection) -> rusqlite::Result<Connection> {
    connection.busy_timeout(database::BUSY_TIMEOUT)?;
    connection.query_row("SELECT count(*) FROM sqlite_schema", [], |_| Ok(()))?;
    Ok(connection)
}

/// Whether the system let nothing be written, or not even be opened to write.
fn is_refusal(error: &rusqlite::Error) -> bool {
    use ErrorCode::{CannotOpen, PermissionDenied, ReadOnly, SystemIoFailure};
    let refusals = [CannotOpen, PermissionDenied, ReadOnly, SystemIoFailure];
    error
        .sqlite_error_code()
        .is_some_and(|code| refusals.contains(&code))
}

/// The address of a file that is not written to; `None` for a name that is not UTF-8.
fn unchanging(path: &Path) -> Option<String> {
    let whole = std::path::absolute(path).ok()?;
    let name = whole.to_str()?;
    let escaped = name
        .replace('%', "%25")
        .replace('?', "%3f")
        .replace('#', "%23");
    Some(format!("file:{escaped}?immutable=1"))
}

/// A copy of a file and its log, for the user alone.
fn copied(path: &Path) -> std::io::Result<(TempDir, PathBuf)> {
    let folder = tempfile::Builder::new().prefix("nearmiss-").tempdir()?;
    let copy = folder.path().join("runs.sqlite");
    for ending in ["-wal", ""] {
        match system::open_file(&side_file(path, ending)) {
            Ok(mut from) => {
                let to = side_file(&copy, ending);
                system::make_file(&to)?;
                std::io::copy(
                    &mut from,
                    &mut std::fs::File::options().write(true).open(to)?,
                )?;
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound && !ending.is_empty() => {}
            Err(error) => return Err(error),
        }
    }
    Ok((folder, copy))
}

/// Opens a copy of a file of the version before, brought to the newest one.
fn open_changed(path: &Path) -> Result<Reading, StoreError> {
    let (folder, file) = copied(path).map_err(|source| StoreError::Open {
        file: path.display().to_string(),
        source,
    })?;
    drop(Store::open(&file)?);
    Ok(Reading {
        copy: Some(folder),
        ..open(&file)?
    })
}

impl Store {
    /// Opens the store in a file to read it, as [`Store::open`] does where that can be; one that cannot be written is
    /// left as it is, and where there is no file, nothing is made and nothing is there.
    ///
    /// # Errors
    /// The file cannot be used, or is newer than the program.
    pub fn open_to_read(path: &Path) -> Result<Self, StoreError> {
        let missing = path.symlink_metadata();
        if missing.is_err_and(|e| e.kind() == std::io::ErrorKind::NotFound) {
            return Self::in_memory();
        }
        match Self::open(path) {
            Err(StoreError::File { file, source }) if is_refusal(&source) => {
                Self::open_read_only(path).map_err(|error| match error {
                    StoreError::Database(_) => StoreError::File { file, source },
                    other => other,
                })
            }
            opened => opened,
        }
    }

    /// Opens the store in a file that is not written to.
    fn open_read_only(path: &Path) -> Result<Self, StoreError> {
        let mut reading = open(path)?;
        match check_version(&reading.connection)? {
            0 => return Self::in_memory(),
            BEFORE => reading = open_changed(path)?,
            _ => {}
        }
        let copy = reading.copy.take();
        let store = Self::of_reader(reading.connection);
        Ok(match copy {
            Some(folder) => store.with_copy(folder),
            None => store,
        })
    }
}

/// How long others are waited for that write at the same time.
const WRITE_TIMEOUT: Duration = Duration::from_millis(500);

/// State of the store's file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Health {
    /// Its version.
    pub version: i64,
    /// The version that this program writes; a file of another one cannot be used.
    pub known: i64,
    /// Its size, bytes.
    pub bytes: u64,
    /// Its runs, deleted ones too; `None` for a file without any tables yet.
    pub runs: Option<u64>,
    /// What SQLite's quick check found to be wrong, a line each.
    pub damage: Vec<String>,
    /// Why nothing can be written to it now; `None` if it can.
    pub locked: Option<String>,
}

impl Health {
    /// Looks at a file; `None` if there is none.
    ///
    /// # Errors
    /// It cannot be opened, or is no SQLite file: in SQLite's words.
    pub fn inspect(path: &Path) -> Result<Option<Self>, String> {
        let bytes = match path.metadata() {
            Ok(data) => data.len(),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(nearmiss_base::system::error_text(&error)),
        };
        let words = |error: rusqlite::Error| error.to_string();
        let opened = open(path).map_err(|error| match error {
            StoreError::Open { source, .. } => nearmiss_base::system::error_text(&source),
            StoreError::Database(source) => words(source),
            other => other.to_string(),
        })?;
        let reading = &opened.connection;
        reading.busy_timeout(WRITE_TIMEOUT).map_err(words)?;
        let number = |sql: &str| reading.query_row(sql, [], |row| row.get::<_, i64>(0));
        let version = number("PRAGMA user_version").map_err(words)?;
        let runs = number("SELECT count(*) FROM runs").ok();
        let mut check = reading.prepare("PRAGMA quick_check(20)").map_err(words)?;
        let rows = check.query_map([], |row| row.get::<_, String>(0));
        let rows: Result<Vec<String>, _> = rows.map_err(words)?.collect();
        let damage = rows.map_err(words)?;
        Ok(Some(Self {
            version,
            known: VERSION,
            bytes,
            runs: runs.and_then(|runs| u64::try_from(runs).ok()),
            damage: damage.into_iter().filter(|line| line != "ok").collect(),
            locked: locked(path).err().map(|error| error.to_string()),
        }))
    }
}

/// Begins to write, and leaves it at that.
fn locked(path: &Path) -> rusqlite::Result<()> {
    let writing = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
    writing.busy_timeout(WRITE_TIMEOUT)?;
    writing.execute_batch("BEGIN IMMEDIATE; ROLLBACK")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::tests::question;
    use crate::{Claim, Filter, RunId, Store};

    /// A name that is invalid in an address.
    const NAME: &str = "50% of #1?.sqlite";

    /// A store with one run in a folder.
    fn one(folder: &Path) -> PathBuf {
        let path = folder.join(NAME);
        add(&Store::open(&path).unwrap());
        path
    }

    fn add(store: &Store) {
        let claimed = store.claim(&question(), true).unwrap();
        assert!(matches!(claimed, Claim::Granted(_)));
    }

    fn runs(store: &Store) -> usize {
        store.numbers(&Filter::default()).unwrap().len()
    }

    #[test]
    fn a_file_without_a_log_is_read_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = one(folder.path());
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI;
        let connection = Connection::open_with_flags(unchanging(&path).unwrap(), flags).unwrap();
        let store = Store::of_reader(looked_at(connection).unwrap());
        assert_eq!(runs(&store), 1);
        assert!(store.run(RunId(1)).unwrap().is_some());
        assert!(store.delete(RunId(1), true).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_only_in_the_log_yet_is_copied_with_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = one(folder.path());
        let writing = Store::open(&path).unwrap();
        add(&writing);
        let (copy, file) = copied(&path).unwrap();
        let store = Store::open(&file).unwrap().with_copy(copy);
        assert_eq!(runs(&store), 2);
        drop(store);
        assert!(!file.exists(), "the copy goes with the store");
    }

    #[test]
    fn files_of_other_versions_are_refused_and_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(NAME);
        for version in [0, BEFORE - 1, VERSION + 1] {
            let connection = Connection::open(&path).unwrap();
            connection
                .pragma_update(None, "user_version", version)
                .unwrap();
            drop(connection);
            let before = std::fs::read(&path).unwrap();
            let opened = Store::open_read_only(&path);
            match version {
                0 => assert_eq!(runs(&opened.unwrap()), 0, "a file without tables"),
                older if older < VERSION => {
                    assert!(matches!(opened, Err(StoreError::Older { .. })));
                }
                _ => assert!(matches!(opened, Err(StoreError::Newer { .. }))),
            }
            assert_eq!(std::fs::read(&path).unwrap(), before);
        }
    }

    #[test]
    fn a_file_of_the_version_before_is_read_in_a_copy() {
        let folder = tempfile::tempdir().unwrap();
        let path = one(folder.path());
        let connection = Connection::open(&path).unwrap();
        for column in [
            "claims_invented",
            "sentences",
            "sentences_not_understood",
            "sentences_contradictory",
        ] {
            let drop = format!("ALTER TABLE runs DROP COLUMN {column}");
            connection.execute_batch(&drop).unwrap();
        }
        connection
            .pragma_update(None, "user_version", BEFORE)
            .unwrap();
        drop(connection);
        let before = std::fs::read(&path).unwrap();
        let store = Store::open_read_only(&path).unwrap();
        assert_eq!(store.outcomes(&Filter::default()).unwrap().len(), 1);
        assert!(store.delete(RunId(1), true).is_err());
        drop(store);
        assert_eq!(std::fs::read(&path).unwrap(), before);
        drop(Store::open(&path).unwrap());
        let connection = Connection::open(&path).unwrap();
        assert_eq!(check_version(&connection).unwrap(), VERSION);
    }

    #[test]
    fn reading_makes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data/runs.sqlite");
        assert_eq!(runs(&Store::open_to_read(&path).unwrap()), 0);
        assert!(!folder.path().join("data").exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_in_the_place_of_a_file_is_said_and_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        for ending in ["", "-wal", "-shm", "-journal"] {
            let pipe = side_file(&path, ending);
            let made = std::process::Command::new("mkfifo").arg(&pipe).status();
            assert!(made.unwrap().success());
            let mut refusals = vec![Store::open(&path).map(drop)];
            if ending.is_empty() {
                refusals.push(Store::open_to_read(&path).map(drop));
                assert!(crate::Health::inspect(&path).is_err());
            }
            for refused in refusals {
                let said = refused.unwrap_err().to_string();
                assert!(said.contains("not a regular file"), "{ending}: {said}");
                assert!(said.contains("runs.sqlite"), "{ending}: {said}");
            }
            std::fs::remove_file(pipe).unwrap();
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_file_and_what_lies_beside_it_are_for_the_user_alone() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data/runs.sqlite");
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o777;
        let store = Store::open(&path).unwrap();
        add(&store);
        let wal = side_file(&path, "-wal");
        assert_eq!(
            [mode(&path), mode(&wal), mode(path.parent().unwrap())],
            [0o600, 0o600, 0o700]
        );
        // As an older program made them.
        for file in files(&path).filter(|file| file.exists()) {
            std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o644)).unwrap();
        }
        let again = Store::open(&path).unwrap();
        for file in files(&path).filter(|file| file.exists()) {
            assert_eq!(mode(&file), 0o600, "{}", file.display());
        }
        drop((store, again));
    }

    #[test]
    fn a_sound_store_a_locked_one_and_what_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        assert_eq!(Health::inspect(&path), Ok(None));
        assert!(!path.exists(), "looking makes nothing");
        drop(Store::open(&path).unwrap());
        let health = Health::inspect(&path).unwrap().unwrap();
        assert_eq!((health.version, health.runs), (VERSION, Some(0)));
        assert!(health.damage.is_empty() && health.locked.is_none() && health.bytes > 0);

        let writer = Connection::open(&path).unwrap();
        writer.execute_batch("BEGIN IMMEDIATE").unwrap();
        let busy = Health::inspect(&path).unwrap().unwrap();
        assert!(busy.locked.unwrap().contains("locked"));
        drop(writer);

        std::fs::write(
            &path,
            "this is no database, and long enough to be read as one",
        )
        .unwrap();
        assert!(
            Health::inspect(&path)
                .unwrap_err()
                .contains("not a database")
        );
    }

    #[test]
    fn damage_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.sqlite");
        drop(Store::open(&path).unwrap());
        let mut bytes = std::fs::read(&path).unwrap();
        let page = 4096;
        assert!(bytes.len() > 4 * page);
        bytes[2 * page..3 * page].fill(0xa5);
        std::fs::write(&path, bytes).unwrap();
        let found = Health::inspect(&path);
        let damaged = match &found {
            Ok(Some(health)) => !health.damage.is_empty(),
            Ok(None) => false,
            Err(error) => error.contains("malformed"),
        };
        assert!(damaged, "{found:?}");
    }
}
