//! The paper's recorded answers, which are not part of this repository.

use std::path::{Path, PathBuf};

use super::program::skipped;

/// The folder `data/from-words-to-collisions` in `../shared`, or in what `NEARMISS_SHARED` names; without it nothing,
/// and the test says that it did not run.
pub fn folder() -> Option<PathBuf> {
    let shared = std::env::var_os("NEARMISS_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    let folder = shared.join("data/from-words-to-collisions");
    if folder.is_dir() {
        return Some(folder);
    }
    skipped(
        "the recorded answers are not here; NEARMISS_SHARED can name the folder that holds data/",
    );
    None
}
