//! Checks the store's file without changing it.

use std::path::Path;
use std::time::Duration;

use rusqlite::{Connection, OpenFlags};

use super::migrate::VERSION;
use super::{StoreError, read_only};

/// How long others are waited for that write at the same time.
const PATIENCE: Duration = Duration::from_millis(500);

/// State of the store's file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Health {
    /// Its version.
    pub version: i64,
    /// The version that this program writes; a newer file cannot be used, an older one is brought to it.
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
            Err(error) => return Err(nearmiss_base::system::words(&error)),
        };
        let words = |error: rusqlite::Error| error.to_string();
        let opened = read_only::open(path).map_err(|error| match error {
            StoreError::Open { source, .. } => nearmiss_base::system::words(&source),
            StoreError::Database(source) => words(source),
            other => other.to_string(),
        })?;
        let reading = &opened.connection;
        reading.busy_timeout(PATIENCE).map_err(words)?;
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
    writing.busy_timeout(PATIENCE)?;
    writing.execute_batch("BEGIN IMMEDIATE; ROLLBACK")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Store;

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
