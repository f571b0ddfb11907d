//! Bundles: an experiment with its answers as one file, which gives the same tables on every machine.
//!
//! [`pack`] reads a batch and writes the file: paths become names, and what reports would read off the scenarios (the
//! built-in judge's verdicts, ids of renumbered obstacles, counts of claims) is recorded. [`unpack`] checks the whole file
//! before any of it is in its place. [`read_manifest`] says what is in it.

mod manifest;
mod pack;
mod runs;
mod unpack;

use std::io;
use std::path::{Path, PathBuf};

use nearmiss_base::system::{self, SaveError};
use nearmiss_store::StoreError;

pub use manifest::{FORMAT as BUNDLE_FORMAT, Manifest, Member, PackedScenario};
pub use pack::{PackRequest, Packed, pack};
pub use unpack::{UnpackRequest, Unpacked, stored_bundle, unpack};

/// Why a bundle cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum BundleError {
    /// The system refused.
    #[error("{file}: {}", system::error_text(source))]
    Io {
        /// Which file.
        file: String,
        /// What the system said.
        source: io::Error,
    },
    /// A file was not saved.
    #[error(transparent)]
    Save(#[from] SaveError),
    /// The store refused.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The file is something else.
    #[error("{0}: not a bundle of `nearmiss runs export`")]
    NoBundle(String),
    /// It is not what was packed.
    #[error("{file}: damaged or altered: {why}; nothing was unpacked")]
    Damaged {
        /// Which file.
        file: String,
        /// What is wrong.
        why: String,
    },
    /// A newer program wrote it.
    #[error(
        "{file}: the bundle has format {found}, and this version reads up to {}; update nearmiss",
        manifest::FORMAT
    )]
    Later {
        /// Which file.
        file: String,
        /// Its format.
        found: u32,
    },
    /// There is another file in the way.
    #[error("{0}: already there with other content; unpack into another folder (--into)")]
    InTheWay(PathBuf),
    /// The batch cannot be packed.
    #[error("{0}")]
    Batch(String),
}

impl BundleError {
    fn io(path: &Path, source: io::Error) -> Self {
        Self::Io {
            file: path.display().to_string(),
            source,
        }
    }
}

/// What is in a bundle, after every member was checked.
///
/// # Errors
/// It cannot be read, is no bundle, or not what was packed.
pub fn read_manifest(file: &Path) -> Result<Manifest, BundleError> {
    manifest::read(file, &mut |_, _, _| Ok(()))
}
