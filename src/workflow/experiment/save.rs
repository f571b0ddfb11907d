//! Writes a batch that is to be begun as an experiment file.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::{experiment_toml, hashes_of};
use crate::batch::{BatchError, BatchRequest};
use nearmiss_ask::prompts::Library;
use nearmiss_base::system::{self, NewFile, SaveError};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_study::evaluation::batch::{Experiment, HASH_DIGITS, Spec, TemplatePin};

/// Why an experiment file is not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteExperimentError {
    /// The batch cannot be written down.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// A value has no place in a TOML file.
    #[error("{0}")]
    Text(String),
    /// The path is a folder.
    #[error("{}: is a folder; name a file in it", .0.display())]
    Folder(PathBuf),
    /// The file is there already, or cannot be written.
    #[error(transparent)]
    Save(#[from] SaveError),
    /// The file cannot be written.
    #[error("{}: {}", path.display(), system::error_text(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// The experiment that asks what a batch is to ask. It pins the templates, and the scenarios by their contents.
///
/// # Errors
/// See [`BatchRequest::spec`].
pub fn experiment_of(
    mut request: BatchRequest,
    library: &Library,
    thresholds: &Thresholds,
) -> Result<Experiment, BatchError> {
    let spec = request.spec(library, thresholds)?;
    Ok(Experiment {
        budget: request.experiment.budget,
        concurrency: request.experiment.concurrency,
        tune: request.experiment.tune,
        hashes: hashes_of(&request.entries),
        templates: pins_of(&spec),
        ..spec.experiment
    })
}

/// The templates of a specification, each with the start of its hash.
pub fn pins_of(spec: &Spec) -> Vec<TemplatePin> {
    let pin = |(name, hash): (&String, &String)| TemplatePin {
        name: name.clone(),
        hash: hash.get(..HASH_DIGITS).unwrap_or(hash).into(),
    };
    spec.templates.iter().map(pin).collect()
}

/// Writes the experiment to a file, whole or not at all; an existing file is replaced only with `overwrite`.
///
/// # Errors
/// See [`WriteExperimentError`].
pub fn write_experiment(
    experiment: &Experiment,
    file: &Path,
    overwrite: bool,
) -> Result<(), WriteExperimentError> {
    if file.is_dir() {
        return Err(WriteExperimentError::Folder(file.to_path_buf()));
    }
    let failed = |source| WriteExperimentError::Io {
        path: file.to_path_buf(),
        source,
    };
    let absolute = std::path::absolute(file).map_err(failed)?;
    let folder = absolute.parent().unwrap_or(Path::new("/"));
    let text = experiment_toml(experiment, folder).map_err(WriteExperimentError::Text)?;
    let mut new = NewFile::begin(file, overwrite)?;
    new.write_all(text.as_bytes()).map_err(failed)?;
    Ok(new.finish()?)
}
