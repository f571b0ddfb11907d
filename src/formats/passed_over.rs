//! What a search of folders passes over, and why.

use std::fmt;
use std::path::PathBuf;

use super::commonroad::{ReadError, Unrecognised};
use nearmiss_base::system;

/// A skipped file or folder.
#[derive(Debug)]
pub struct PassedOver {
    /// Its path.
    pub path: PathBuf,
    /// Why it was.
    pub why: PassedOverReason,
}

/// Why something was skipped.
#[derive(Debug, thiserror::Error)]
pub enum PassedOverReason {
    /// A file that is not known to be a scenario.
    #[error(transparent)]
    File(#[from] Unrecognised),
    /// A recording that is damaged.
    #[error("{}", .0.message)]
    Recording(ReadError),
    /// Data of driving in a format that is not read: what it is.
    #[error("{0}, which is not read")]
    Kind(String),
    /// A folder that could not be read.
    #[error("not searched: {}", system::words(.0))]
    Folder(std::io::Error),
}

/// Describes how many files and folders these are; `None` if none.
pub(super) fn count(all: &[PassedOver]) -> Option<String> {
    let is_folder = |p: &&PassedOver| matches!(p.why, PassedOverReason::Folder(_));
    let folders = all.iter().filter(is_folder).count();
    let words = |count: usize, one: &str, many: &str| match count {
        0 => None,
        1 => Some(format!("1 {one}")),
        _ => Some(format!("{count} {many}")),
    };
    let files = words(all.len() - folders, "file", "files");
    let folders = words(folders, "folder", "folders");
    let both = files.into_iter().chain(folders).collect::<Vec<_>>();
    (!both.is_empty()).then(|| both.join(" and "))
}

impl fmt::Display for PassedOver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.path.display(), self.why)
    }
}
