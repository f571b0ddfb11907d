//! Files in the making, and folders of them, so that a program that has to end at once leaves none of them behind.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

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
