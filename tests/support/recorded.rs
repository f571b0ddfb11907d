//! Real data, which are not part of this repository: `../shared/data`, or what `NEARMISS_SHARED` names.

use std::path::{Path, PathBuf};

use super::program::skipped;

/// A part of the data; without it nothing, and the test says that it did not run.
pub fn shared(part: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let shared = std::env::var_os("NEARMISS_SHARED").map_or(beside, PathBuf::from);
    let path = shared.join("data").join(part);
    if path.exists() {
        return Some(path);
    }
    skipped(&format!(
        "there is no {}; NEARMISS_SHARED can name the folder that holds data/",
        path.display()
    ));
    None
}

/// The paper's repository: its scenarios, recorded egos and recorded answers.
pub fn folder() -> Option<PathBuf> {
    shared("from-words-to-collisions")
}
