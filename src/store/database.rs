//! The SQLite database behind the store: its version, and its commits, of which concurrent waiters share one sync to disk.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use nearmiss_base::system;
use rusqlite::{Connection, Params, Row, Transaction, TransactionBehavior};
use tempfile::TempDir;

use super::filter::KnownModels;
use super::read_only;

/// The store of all runs, safe for several threads and several processes at once.
#[derive(Debug)]
pub struct Store {
    connection: Mutex<Connection>,
    /// `None` without a log: in memory, or on a file system that cannot have one.
    log: Option<Log>,
    /// Where the copy lies that is read in place of a file that cannot be written. It goes after the connection.
    _copy: Option<TempDir>,
    /// For searches.
    models: Mutex<KnownModels>,
}

/// Errors of the store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The folder cannot be made.
    #[error(
        "{folder}: {}; set NEARMISS_DATA to a writable folder",
        system::error_text(source)
    )]
    Folder {
        /// Which folder.
        folder: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a store, or cannot be used as one.
    #[error("{file}: {source}; {}", advice(source.sqlite_error_code() == Some(rusqlite::ErrorCode::DiskFull)))]
    File {
        /// Which file.
        file: String,
        /// What SQLite said.
        source: rusqlite::Error,
    },
    /// The system cannot open the file, or it is not a file.
    #[error(
        "{file}: {}; {}",
        system::error_text(source),
        advice(source.kind() == std::io::ErrorKind::StorageFull)
    )]
    Open {
        /// Which file.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// SQLite refused.
    #[error("the store: {0}")]
    Database(#[from] rusqlite::Error),
    /// The file was written by a newer program.
    #[error(
        "the store has version {found}, but this program supports {known}; update nearmiss, or set NEARMISS_DATA to another folder"
    )]
    Newer {
        /// Version of the file.
        found: i64,
        /// Newest version known.
        known: i64,
    },
    /// The file was written by a program that was never released.
    #[error(
        "the store has version {found}, but this program supports {known}; move it away, or set NEARMISS_DATA to another folder"
    )]
    Older {
        /// Version of the file.
        found: i64,
        /// The version known.
        known: i64,
    },
    /// The file is a database of another program, or its version was changed.
    #[error(
        "the file is no store of nearmiss; move it away, or set NEARMISS_DATA to another folder"
    )]
    Foreign,
    /// A verdict cannot be written as JSON.
    #[error("a verdict cannot be stored: {0}")]
    Json(#[from] serde_json::Error),
    /// What was written may not be on the disk.
    #[error("the store cannot be synced to disk: {}", system::error_text(.0))]
    Sync(std::io::Error),
    /// An answer arrived but could not be stored; where it is instead.
    #[error("{0}")]
    Unstored(String),
    /// A word that another version wrote.
    #[error("the store: {0}")]
    Word(String),
    /// No run has this number.
    #[error("no run {0}; `nearmiss runs list` lists all")]
    NoRun(super::RunId),
    /// A person has no rating with this number.
    #[error("no rating {0} by this person")]
    NoRating(i64),
    /// A run is pinned and shall be deleted.
    #[error("run {0} is pinned; `nearmiss runs unpin {0}` before it can be deleted")]
    Pinned(super::RunId),
}

/// What to do where the store cannot be used.
fn advice(disk_is_full: bool) -> &'static str {
    if disk_is_full {
        "free some space, or set NEARMISS_DATA to a folder on another disk"
    } else {
        "move it away, or set NEARMISS_DATA to another folder"
    }
}

/// How long others are waited for that write at the same time.
pub(super) const BUSY_TIMEOUT: Duration = Duration::from_secs(10);

impl Store {
    /// Opens the store in a file, making it and its folder where they are missing, bringing it to the newest version
    /// where it is older, and marking what was running in programs that have ended as interrupted.
    ///
    /// ```
    /// use nearmiss_store::Store;
    ///
    /// let folder = tempfile::tempdir()?;
    /// let store = Store::open(&folder.path().join("runs.sqlite"))?;
    /// assert!(store.ratings()?.is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The file cannot be used, or is newer than the program.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        if let Some(folder) = path.parent() {
            system::make_folder(folder).map_err(|source| StoreError::Folder {
                folder: folder.display().to_string(),
                source,
            })?;
        }
        read_only::check(path)?;
        // SQLite gives what it keeps beside the file the permissions of the file. What cannot be made it says itself.
        let _ = system::make_file(path);
        read_only::files(path).for_each(|file| system::close_file(&file));
        Connection::open(path)
            .map_err(StoreError::from)
            .and_then(Self::prepare)
            .map_err(|error| match error {
                StoreError::Database(source) => StoreError::File {
                    file: path.display().to_string(),
                    source,
                },
                other => other,
            })
    }

    /// A store that lasts as long as the program.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn in_memory() -> Result<Self, StoreError> {
        Self::prepare(Connection::open_in_memory()?)
    }

    fn prepare(mut connection: Connection) -> Result<Self, StoreError> {
        connection.busy_timeout(BUSY_TIMEOUT)?;
        connection.set_prepared_statement_cache_capacity(64);
        write_ahead(&connection)?;
        // Pieces outlive a killed program as they are; whole answers outlive a power cut (see `durably`).
        connection.pragma_update(None, "synchronous", "normal")?;
        create_tables(&mut connection)?;
        connection.pragma_update(None, "foreign_keys", true)?;
        let mode: String = connection.query_row("PRAGMA journal_mode", [], |row| row.get(0))?;
        let log = connection
            .path()
            .filter(|_| mode == "wal")
            .map(Log::next_to);
        let store = Self {
            connection: Mutex::new(connection),
            log,
            _copy: None,
            models: Mutex::default(),
        };
        store.interrupt_abandoned()?;
        store.take_in();
        Ok(store)
    }

    /// Over a connection that only reads.
    pub(super) fn of_reader(connection: Connection) -> Self {
        connection.set_prepared_statement_cache_capacity(64);
        Self {
            connection: Mutex::new(connection),
            log: None,
            _copy: None,
            models: Mutex::default(),
        }
    }

    /// Keeps the folder of the copy that is read until the store is closed.
    pub(super) fn with_copy(self, copy: TempDir) -> Self {
        Self {
            _copy: Some(copy),
            ..self
        }
    }

    pub(super) fn known_models(&self) -> MutexGuard<'_, KnownModels> {
        self.models.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Connection> {
        // A panic elsewhere leaves SQLite itself sound: its transactions roll back.
        self.connection
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Every row that a query finds, as `read` has it.
    pub(super) fn rows<T>(
        &self,
        sql: &str,
        values: impl Params,
        read: impl FnMut(&Row<'_>) -> Result<T, rusqlite::Error>,
    ) -> Result<Vec<T>, StoreError> {
        all_rows(&self.lock(), sql, values, read)
    }

    /// Changes something in one transaction that has the file to itself.
    pub(super) fn change<T>(
        &self,
        work: impl FnOnce(&Transaction<'_>) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        change(&mut self.lock(), work)
    }

    /// Like [`Store::change`], and what was changed is on the disk afterwards, with everything before it.
    pub(super) fn durably<T>(
        &self,
        work: impl FnOnce(&Transaction<'_>) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let mut connection = self.lock();
        if let Some(log) = &self.log {
            let done = change(&mut connection, work)?;
            let ticket = log.committed();
            // While this one is on its way to the disk, others commit, and share the next sync.
            drop(connection);
            log.sync(ticket).map_err(StoreError::Sync)?;
            return Ok(done);
        }
        // The setting is the connection's own, and cannot be changed inside a transaction.
        connection.pragma_update(None, "synchronous", "full")?;
        let done = change(&mut connection, work);
        connection.pragma_update(None, "synchronous", "normal")?;
        done
    }
}

/// Every row that a query finds, as `read` has it.
pub(super) fn all_rows<T>(
    connection: &Connection,
    sql: &str,
    values: impl Params,
    read: impl FnMut(&Row<'_>) -> Result<T, rusqlite::Error>,
) -> Result<Vec<T>, StoreError> {
    let mut statement = connection.prepare_cached(sql)?;
    let rows = statement.query_map(values, read)?;
    Ok(rows.collect::<Result<_, _>>()?)
}

fn change<T>(
    connection: &mut Connection,
    work: impl FnOnce(&Transaction<'_>) -> Result<T, StoreError>,
) -> Result<T, StoreError> {
    // Immediate: a transaction that first reads and then writes cannot wait for others, it fails.
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    let done = work(&transaction)?;
    transaction.commit()?;
    Ok(done)
}

/// Switches to a write-ahead log. Where several programs open a new file at once, SQLite answers that it is locked
/// without waiting.
fn write_ahead(connection: &Connection) -> Result<(), StoreError> {
    let begun = std::time::Instant::now();
    loop {
        match connection.pragma_update(None, "journal_mode", "wal") {
            Err(error) if is_busy(&error) && begun.elapsed() < BUSY_TIMEOUT => {
                std::thread::sleep(Duration::from_millis(5));
            }
            done => return Ok(done?),
        }
    }
}

fn is_busy(error: &rusqlite::Error) -> bool {
    use rusqlite::ErrorCode::{DatabaseBusy, DatabaseLocked};
    matches!(
        error.sqlite_error_code(),
        Some(DatabaseBusy | DatabaseLocked)
    )
}

/// Milliseconds since 1970, UTC.
#[must_use]
pub fn now_ms() -> i64 {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
}

/// The write-ahead log of a store. Commits are counted while the store is locked, and synced when it is not.
#[derive(Debug)]
struct Log {
    file: PathBuf,
    state: Mutex<State>,
    turn: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// Commits so far.
    written: u64,
    /// How many of them are on the disk.
    synced: u64,
    /// Whether a thread is syncing.
    busy: bool,
    /// Whether the folder is on the disk with the log's name in it. The log stays as long as the store is open.
    named: bool,
}

/// A commit that waits to be on the disk.
#[derive(Debug, Clone, Copy)]
struct Ticket(u64);

impl Log {
    /// The log beside a store's file.
    fn next_to(store: &str) -> Self {
        Self {
            file: Path::new(&format!("{store}-wal")).to_path_buf(),
            state: Mutex::default(),
            turn: Condvar::new(),
        }
    }

    /// Counts a commit. A thread calls it after its commit, before any other can commit.
    fn committed(&self) -> Ticket {
        let mut state = self.lock();
        state.written += 1;
        Ticket(state.written)
    }

    /// Waits until a commit is on the disk, with all before it.
    ///
    /// # Errors
    /// The system cannot sync the file.
    fn sync(&self, ticket: Ticket) -> io::Result<()> {
        let mut state = self.lock();
        while state.synced < ticket.0 {
            if state.busy {
                let waited = self.turn.wait(state);
                state = waited.unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            // What was committed until now is in the file; what follows needs another sync.
            let (written, named) = (state.written, state.named);
            state.busy = true;
            drop(state);
            let done = File::options()
                .write(true)
                .open(&self.file)
                .and_then(|file| file.sync_data())
                .and_then(|()| {
                    if named {
                        Ok(())
                    } else {
                        sync_folder(&self.file)
                    }
                });
            state = self.lock();
            state.busy = false;
            if done.is_ok() {
                state.synced = state.synced.max(written);
                state.named = true;
            }
            self.turn.notify_all();
            done?;
        }
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Puts the names in the folder of a file onto the disk: a synced file whose name is lost is lost, too.
#[cfg(unix)]
fn sync_folder(file: &Path) -> io::Result<()> {
    let folder = file.parent().filter(|path| !path.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

/// Elsewhere folders cannot be opened as files, and the system keeps names by itself.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Makes the tables of a new file.
const SCHEMA: &str = include_str!("schema.sql");

/// The version of a file that this program reads and writes.
pub const VERSION: i64 = 14;

/// The version before, which is brought to [`VERSION`] when it is opened.
pub const BEFORE: i64 = 13;

/// What [`BEFORE`] lacks.
const CHANGES: &str = "ALTER TABLE runs ADD COLUMN claims_invented INTEGER;
    ALTER TABLE runs ADD COLUMN sentences INTEGER;
    ALTER TABLE runs ADD COLUMN sentences_not_understood INTEGER;
    ALTER TABLE runs ADD COLUMN sentences_contradictory INTEGER;";

/// Makes the tables of a new file, and adds what an older one lacks. Several programs may try at once; one does it, the
/// others wait.
fn create_tables(connection: &mut Connection) -> Result<(), StoreError> {
    if check_version(connection)? == VERSION {
        return Ok(());
    }
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    match check_version(&transaction)? {
        0 => {
            let tables: i64 =
                transaction
                    .query_row("SELECT count(*) FROM sqlite_master", [], |row| row.get(0))?;
            if tables > 0 {
                return Err(StoreError::Foreign);
            }
            transaction.execute_batch(SCHEMA)?;
        }
        BEFORE => transaction.execute_batch(CHANGES)?,
        _ => {}
    }
    transaction.pragma_update(None, "user_version", VERSION)?;
    transaction.commit()?;
    Ok(())
}

/// The version of a file: [`VERSION`], [`BEFORE`], or 0 of one without tables.
pub fn check_version(connection: &Connection) -> Result<i64, StoreError> {
    let found = connection.query_row("PRAGMA user_version", [], |row| row.get(0))?;
    match found {
        0 | BEFORE | VERSION => Ok(found),
        newer if newer > VERSION => Err(StoreError::Newer {
            found,
            known: VERSION,
        }),
        _ => Err(StoreError::Older {
            found,
            known: VERSION,
        }),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn every_commit_is_synced_and_one_sync_is_enough_for_those_before() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("runs.sqlite").display().to_string();
        let log = Log::next_to(&store);
        let first = log.committed();
        assert!(log.sync(first).is_err(), "there is no log");
        assert!(!log.lock().named);
        std::fs::write(format!("{store}-wal"), "x").unwrap();
        let second = log.committed();
        log.sync(second).unwrap();
        assert!(log.lock().named, "its name is on the disk, too");
        std::fs::remove_file(format!("{store}-wal")).unwrap();
        log.sync(first).unwrap();
        assert!(
            log.sync(log.committed()).is_err(),
            "a later one is not on the disk"
        );
    }

    #[test]
    fn many_at_once_wait_for_their_own() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("runs.sqlite").display().to_string();
        std::fs::write(format!("{store}-wal"), "x").unwrap();
        let log = Log::next_to(&store);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..20 {
                        let ticket = log.committed();
                        log.sync(ticket).unwrap();
                        assert!(log.lock().synced >= ticket.0);
                    }
                });
            }
        });
        assert_eq!(log.lock().synced, 160);
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_cannot_be_synced_is_said() {
        assert!(sync_folder(Path::new("/nowhere/at/all/runs.sqlite-wal")).is_err());
        // A file that was named without a folder.
        sync_folder(Path::new("runs.sqlite-wal")).unwrap();
    }
}
