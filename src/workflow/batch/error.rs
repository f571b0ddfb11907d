//! Why a batch cannot be started or resumed.

use std::path::PathBuf;

use crate::evaluation::LabelError;
use crate::evaluation::batch::{SpecError, TruthError};
use crate::store::{BatchId, StoreError};
use crate::system;

/// Why a batch cannot be started or resumed.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// A relative path cannot be resolved.
    #[error("{}: {}", path.display(), system::words(source))]
    Path {
        /// The path.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// What is true cannot be read.
    #[error(transparent)]
    Truth(#[from] TruthError),
    /// A label cannot be of its scenario.
    #[error("--truth: {0}")]
    Label(#[from] LabelError),
    /// The labels of another truth fit no scenario of the batch.
    #[error("--truth: it says nothing about any scenario of {0}; its truth stays as it was")]
    NoLabel(BatchId),
    /// The specification cannot be used.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The specification of a stored batch cannot be used any more.
    #[error("{batch}: {error}")]
    Stored {
        /// The batch.
        batch: BatchId,
        /// Why.
        error: SpecError,
    },
    /// A stored question holds a word that this version does not know.
    #[error("{0}")]
    Question(String),
    /// A draft is for another task or frame than is asked.
    #[error("{0}: the draft is for another task or frame than the batch asks about")]
    Draft(String),
    /// Samples cannot be taken away from a batch.
    #[error("--samples {wanted}: {batch} has {has} already, and they are not taken away")]
    FewerSamples {
        /// The samples asked for.
        wanted: u32,
        /// The batch.
        batch: BatchId,
        /// The samples it has.
        has: u32,
    },
    /// Several leads without the safety task.
    #[error(
        "{option}: windows of the collision task end with the recording; several leads are for --task safety"
    )]
    Leads {
        /// The option that names them.
        option: &'static str,
    },
    /// The store has no such batch.
    #[error("there is no batch {0}; `nearmiss evaluate --list` lists them")]
    NoBatch(BatchId),
    /// The store has no batch at all.
    #[error("there is no batch yet; `nearmiss evaluate --list` lists them")]
    NoBatchYet,
    /// The store cannot be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
}
