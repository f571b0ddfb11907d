//! Reads experiments from files and the command line, and writes them.

use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};
use toml::Value;

use crate::Selector;
use nearmiss_ask::llm::Effort;
use nearmiss_ask::prompts::Library;
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_settings::Config;
use nearmiss_study::evaluation::batch::{Experiment, TruthSource};

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
/// configuration says: it means the same for everybody.
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
            if is_bundled(path) {
                path.into()
            } else {
                folder.join(path)
            }
        });
    });
    layers.edit("truth", |value| {
        if matches!(truth_of(value), Some(TruthSource::Files(_))) {
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

fn truth_of(value: &Value) -> Option<TruthSource> {
    let words = value.as_array()?.iter();
    let words: Option<Vec<String>> = words.map(|word| Some(word.as_str()?.to_string())).collect();
    TruthSource::of_words(&words?)
}

fn is_bundled(path: &str) -> bool {
    let entry = Entry::of_argument(Path::new(path));
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
