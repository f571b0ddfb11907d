//! Why a journal cannot be used.

use std::path::PathBuf;

use nearmiss_base::system;

/// Why a journal cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// It cannot be read or written, or a file of a finished unit cannot.
    #[error("{path}: {}", system::error_text(source))]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Another program is writing it.
    #[error("{0}: another nearmiss is working on the same part in this folder")]
    Busy(PathBuf),
    /// The folder has the output of an earlier run.
    #[error("{0}: holds an earlier run; --resume continues it, --overwrite starts again")]
    EarlierRun(PathBuf),
    /// The earlier run had other settings, or was made by another version.
    #[error(
        "{path}: the run in this folder has other settings or comes from another version of nearmiss ({differences}); \
         choose another folder, give the settings of then, or leave out --resume and start again with --overwrite"
    )]
    OtherSettings {
        /// The journal.
        path: PathBuf,
        /// What differs.
        differences: String,
    },
    /// The folder has another division into parts.
    #[error(
        "{0}: the folder holds a run divided otherwise, so scenarios would be there twice; use the same number of \
         parts, or another folder"
    )]
    OtherDivision(PathBuf),
    /// It is not a journal.
    #[error("{path}: line {line} is not a line of a journal of nearmiss; choose another folder")]
    NotAJournal {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
    },
}
