//! Durable commits: concurrent waiters share one sync to disk.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The write-ahead log of a store. Commits are counted while the store is locked, and synced when it is not.
#[derive(Debug)]
pub struct Log {
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
pub struct Ticket(u64);

impl Log {
    /// The log beside a store's file.
    pub fn beside(store: &str) -> Self {
        Self {
            file: Path::new(&format!("{store}-wal")).to_path_buf(),
            state: Mutex::default(),
            turn: Condvar::new(),
        }
    }

    /// Counts a commit. A thread calls it after its commit, before any other can commit.
    pub fn committed(&self) -> Ticket {
        let mut state = self.lock();
        state.written += 1;
        Ticket(state.written)
    }

    /// Waits until a commit is on the disk, with all before it.
    ///
    /// # Errors
    /// The system cannot sync the file.
    pub fn sync(&self, ticket: Ticket) -> io::Result<()> {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_commit_is_synced_and_one_sync_is_enough_for_those_before() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("runs.sqlite").display().to_string();
        let log = Log::beside(&store);
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
        let log = Log::beside(&store);
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
