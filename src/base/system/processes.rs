//! Programs of this machine, and groups of child processes that end with this one.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// The leaders of those that run.
static RUNNING: Mutex<BTreeSet<i32>> = Mutex::new(BTreeSet::new());

/// A process group of a child of this program; it is killed where [`end_process_groups`] comes first.
#[derive(Debug)]
pub struct ProcessGroup {
    leader: Option<i32>,
}

impl ProcessGroup {
    /// That of a child which leads a group of its own, by its process id.
    #[must_use]
    pub fn led_by(id: u32) -> Self {
        let leader = i32::try_from(id).ok();
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        running.extend(leader);
        Self { leader }
    }

    /// Kills all that is left of it.
    pub fn kill(&self) {
        if let Some(leader) = self.leader {
            kill(leader);
        }
    }

    /// Forgets it: before its leader is waited for, as its id may then be that of another process.
    pub fn forget(&mut self) {
        if let Some(leader) = self.leader.take() {
            let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
            running.remove(&leader);
        }
    }
}

impl Drop for ProcessGroup {
    fn drop(&mut self) {
        self.forget();
    }
}

/// Kills every group that still runs.
pub fn end_process_groups() {
    let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    running.iter().copied().for_each(kill);
}

#[cfg(unix)]
fn kill(leader: i32) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Some(leader) = Pid::from_raw(leader) {
        // Those that have ended already are not there.
        let _ = kill_process_group(leader, Signal::KILL);
    }
}

#[cfg(not(unix))]
fn kill(_: i32) {}

/// Whether a word is the path of a file, or the name of one in the folders of `PATH`.
#[must_use]
pub fn is_program(word: &str) -> bool {
    let path = Path::new(word);
    if path.components().count() > 1 {
        return path.is_file();
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let mut folders = std::env::split_paths(&folders);
    folders.any(|folder| {
        let file = folder.join(word);
        file.is_file()
            || file
                .with_extension(std::env::consts::EXE_EXTENSION)
                .is_file()
    })
}
