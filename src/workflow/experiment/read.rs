//! Reads experiments from files and the command line, and writes them, also batches that are to be begun.

use std::io::Write;
use std::path::{Path, PathBuf};

use nearmiss_ask::llm::Effort;
use nearmiss_ask::prompts::Library;
use nearmiss_base::system::{self, NewFile, SaveError};
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::Config;
use nearmiss_study::evaluation::batch::{Experiment, HASH_DIGITS, Spec, TemplatePin, TruthSource};
use serde_json::{Value as Json, json};
use toml::Value;

use super::scenario_hashes;
use crate::Selector;
use crate::batch::{BatchError, BatchRequest};

/// What the configuration says of experiments, where neither their files nor the command line say it.
#[must_use]
pub fn configured_experiment(config: &Config) -> Experiment {
    Experiment {
        models: config.model.iter().cloned().collect(),
        history: config.history,
        radius: config.radius,
        temperature: config.temperature.into(),
        max_tokens: config.max_tokens,
        effort: config.effort.as_deref().and_then(Effort::parse).into(),
        log_probabilities: config.log_probabilities,
        tools: config.tools.then_some(true).into(),
        ..Experiment::default()
    }
}

/// Reads an experiment; what it leaves open is as without options on the command line, whatever the user's
/// configuration says: it means the same for every user.
///
/// # Errors
/// Every mistake in the text, each with `file` and line.
pub fn read_experiment(text: &str, file: &Path, library: &Library) -> Result<Experiment, String> {
    let mut layers = Layers::default();
    add_experiment_file(&mut layers, text, file);
    complete_experiment(layers, library)
}

/// Adds what a file says; its paths are relative to its folder.
pub fn add_experiment_file(layers: &mut Layers<Experiment>, text: &str, file: &Path) {
    layers.file(&file.display().to_string(), text);
    let folder = file.parent().unwrap_or(Path::new(""));
    layers.edit("scenarios", |value| {
        each_text(value, |path| {
            if is_bundled(Path::new(path)) {
                path.into()
            } else {
                folder.join(path)
            }
        });
    });
    layers.edit("truth", |value| {
        if matches!(read_truth(value), Some(TruthSource::Files(_))) {
            // Absolute as the scenarios of a batch, so that it asks the same wherever it is gone on with.
            each_text(value, |path| absolute(folder.join(path)));
        }
    });
}

/// The experiment that layers make, with what depends on other fields.
///
/// # Errors
/// Every mistake.
pub fn complete_experiment(
    mut layers: Layers<Experiment>,
    library: &Library,
) -> Result<Experiment, String> {
    layers.require();
    let mut experiment = layers.fields_so_far();
    let mut mistakes = experiment.complete(library);
    if let Some(Err(why)) = experiment.select.as_deref().map(Selector::read) {
        mistakes.push(("select", why));
    }
    for (key, words) in &mistakes {
        layers.mistake(key, words);
    }
    layers.checked()?;
    Ok(experiment)
}

fn each_text(value: &mut Value, change: impl Fn(&str) -> PathBuf) {
    let texts = value.as_array_mut().into_iter().flatten();
    for text in texts {
        if let Some(path) = text.as_str() {
            *text = change(path).display().to_string().into();
        }
    }
}

fn read_truth(value: &Value) -> Option<TruthSource> {
    let words = value.as_array()?.iter();
    let words: Option<Vec<String>> = words.map(|word| Some(word.as_str()?.to_string())).collect();
    TruthSource::from_arguments(&words?)
}

/// Whether a path is the name of a bundled scenario.
pub fn is_bundled(path: &Path) -> bool {
    let entry = Entry::of_argument(path);
    matches!(entry.place, EntryLocation::Bundled(_))
}

fn absolute(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}

/// The experiment as a file in a folder: paths below the folder are written relative to it, all others absolute.
///
/// # Errors
/// A path is not UTF-8.
pub fn experiment_toml(experiment: &Experiment, folder: &Path) -> Result<String, String> {
    let relative = |path: &PathBuf| {
        let below = path.strip_prefix(folder).unwrap_or(path);
        match below.to_str() {
            Some(_) => Ok(below.to_path_buf()),
            None => Err(format!("{}: not UTF-8, which TOML needs", path.display())),
        }
    };
    let mut written = experiment.clone();
    for path in &mut written.scenarios {
        *path = relative(path)?;
    }
    if let Some(TruthSource::Files(files)) = &mut written.truth {
        for file in files {
            *file = relative(file)?;
        }
    }
    Ok(written.to_toml())
}

/// The JSON schema of the file, for editors.
#[must_use]
pub fn experiment_schema() -> Json {
    let mut schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "nearmiss experiment",
        "description": "`nearmiss evaluate FILE.toml` runs it.",
    });
    if let (Some(schema), Json::Object(fields)) =
        (schema.as_object_mut(), Experiment::json_schema())
    {
        schema.extend(fields);
    }
    schema
}

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
pub fn experiment_from_request(
    mut request: BatchRequest,
    library: &Library,
    thresholds: &Thresholds,
) -> Result<Experiment, BatchError> {
    let spec = request.spec(library, thresholds)?;
    Ok(Experiment {
        budget: request.experiment.budget,
        concurrency: request.experiment.concurrency,
        tune: request.experiment.tune,
        hashes: scenario_hashes(&request.entries),
        templates: template_pins(&spec),
        ..spec.experiment
    })
}

/// The templates of a specification, each with the start of its hash.
pub fn template_pins(spec: &Spec) -> Vec<TemplatePin> {
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
