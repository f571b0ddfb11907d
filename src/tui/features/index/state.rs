//! The index of a corpus that was chosen: its folder, and how far it is read.

use std::path::{Path, PathBuf};

use crate::model::JobId;

/// The chosen index; what was read of it belongs to the list.
#[derive(Debug, Clone, Default)]
pub struct IndexChoice {
    /// Its folder; `None` where there is no index.
    pub folder: Option<PathBuf>,
    /// The folder of the configuration, `None` where it names none.
    pub configured: Option<PathBuf>,
    /// The folder that was typed behind the action's name in the palette.
    pub typed: Option<String>,
    /// The job that reads it.
    pub job: Option<JobId>,
    /// Rows that were read, and rows in all.
    pub read: (u64, u64),
    /// Why it cannot be read.
    pub error: Option<String>,
}

impl IndexChoice {
    /// The folder as text; empty where there is none.
    #[must_use]
    pub fn text(folder: Option<&Path>) -> String {
        folder.map_or_else(String::new, |folder| folder.display().to_string())
    }

    /// The folder that a typed text means, of a program that was started in the folder `here`; nothing for an empty
    /// text.
    #[must_use]
    pub fn meant(text: &str, here: &Path) -> Option<PathBuf> {
        let text = text.trim();
        if text.is_empty() {
            return None;
        }
        let home = text.strip_prefix("~/").zip(std::env::home_dir());
        Some(match home {
            Some((rest, home)) => home.join(rest),
            None => here.join(text),
        })
    }
}
