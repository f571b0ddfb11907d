//! An experiment as a file: which questions are asked about which scenarios, to whom, and which comparison matters.

mod hashes;
mod prepare;
mod read;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nearmiss_ask::prompts::Library;
use nearmiss_base::system;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_record::fields::Fields;
use nearmiss_study::evaluation::batch::{Experiment, HASH_DIGITS, Shard, Spec};

use super::batch::BatchRequest;

pub use hashes::{hashed_name, hashes_in, scenario_hashes};
pub use prepare::{
    ConfigurationProgress, ExperimentContext, ExperimentProgress, PreparedExperiment,
    count_reasons, experiment_among, find_scenarios, is_experiment_file, prepare_experiment,
    selected,
};
pub use read::{
    WriteExperimentError, add_experiment_file, complete_experiment, configured_experiment,
    experiment_from_request, experiment_schema, experiment_toml, is_bundled, read_experiment,
    template_pins, write_experiment,
};

/// The batch that asks the questions of an experiment.
///
/// # Errors
/// A template or a scenario is not the one that the experiment was written with.
pub fn batch_request(
    experiment: &Experiment,
    entries: Vec<Entry>,
    shard: Option<Shard>,
    library: &Library,
) -> Result<BatchRequest, String> {
    let now = Spec::templates_for(experiment, library);
    let other = experiment.templates.iter().find(|pin| {
        let now = now.get(&pin.name);
        !now.is_some_and(|now| now.starts_with(&pin.hash))
    });
    if let Some(pin) = other {
        let (name, hash) = (&pin.name, &pin.hash);
        return Err(match now.get(name) {
            Some(now) => format!(
                "templates: {name} has the hash {}, but the experiment was written with {hash}; put that version of \
                 it into the folder of templates, or remove the line",
                &now[..HASH_DIGITS.min(now.len())]
            ),
            None => format!("templates: {name} is not asked with in this experiment"),
        });
    }
    hashes::check(&experiment.hashes, &entries)?;
    Ok(BatchRequest {
        experiment: experiment.clone(),
        entries,
        ego: EgoSelection::Beside,
        shard,
        drafts: BTreeMap::new(),
    })
}

/// An axis of an experiment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExperimentAxis {
    /// Its key in the file.
    pub name: &'static str,
    /// Its values; empty where the file leaves it open.
    pub values: Vec<String>,
}

/// Every axis, in the order of the file's keys, and the templates of its questions.
#[must_use]
pub fn experiment_axes(experiment: &Experiment, library: &Library) -> Vec<ExperimentAxis> {
    let rows = Experiment::rows().iter();
    let axes = rows.filter(|row| row.section == "questions" || row.is("axis"));
    let mut axes: Vec<ExperimentAxis> = axes
        .map(|row| ExperimentAxis {
            name: row.key,
            values: experiment.texts(row.key),
        })
        .collect();
    let templates = Spec::templates_for(experiment, library);
    axes.push(ExperimentAxis {
        name: "templates",
        values: templates.into_keys().collect(),
    });
    axes
}

/// The fields beside the axes that are set, each with its value in words.
#[must_use]
pub fn experiment_facts(experiment: &Experiment) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    for (row, _) in experiment.given() {
        let value = match row.key {
            "title" => continue,
            "truth" => Spec {
                experiment: experiment.clone(),
                ..Spec::default()
            }
            .truth_summary(),
            "templates" => format!("{} by their hashes", experiment.templates.len()),
            "hashes" => format!("{} scenarios", experiment.hashes.len()),
            _ if row.section == "questions" || row.is("axis") => continue,
            key => experiment.text(key).unwrap_or_default(),
        };
        facts.push((row.key, value));
    }
    facts
}

/// An experiment file of a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExperimentFile {
    /// Its path, as the folder's was given.
    pub path: PathBuf,
    /// What it asks, in a line, where it says so.
    pub title: Option<String>,
}

/// What is in a folder, for a path that is being typed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FolderOfExperiments {
    /// Its experiment files, by name.
    pub files: Vec<ExperimentFile>,
    /// Its folders, by name; hidden ones are left out.
    pub folders: Vec<PathBuf>,
}

/// Files and folders of a folder that are looked at.
const MAX_FILES: usize = 10_000;

/// TOML files of a folder that are read.
const MAX_READ: usize = 500;

/// A larger file is no experiment, bytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// The experiment files and the folders of a folder.
///
/// # Errors
/// The folder cannot be read: which, and why.
pub fn experiments_in(folder: &Path) -> Result<FolderOfExperiments, String> {
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let entries = here
        .read_dir()
        .map_err(|error| format!("{}: {}", here.display(), system::error_text(&error)))?;
    let mut found = FolderOfExperiments::default();
    let mut candidates = Vec::new();
    for entry in entries.flatten().take(MAX_FILES) {
        let name = entry.file_name();
        if name.as_encoded_bytes().starts_with(b".") {
            continue;
        }
        let path = folder.join(name);
        if path.is_dir() {
            found.folders.push(path)
        } else if is_experiment_file(&path) {
            candidates.push(path)
        }
    }
    found.folders.sort();
    candidates.sort();
    candidates.truncate(MAX_READ);
    found.files = candidates.into_iter().filter_map(experiment).collect();
    Ok(found)
}

/// The file, if it is an experiment; one that is broken still counts where it has a line for scenarios or models.
fn experiment(path: PathBuf) -> Option<ExperimentFile> {
    let text = system::read_text(&path, MAX_FILE_BYTES).ok()?;
    let keys = ["scenarios", "models"];
    let (is_one, title) = match text.parse::<toml::Table>() {
        Ok(table) => {
            let title = table.get("title").and_then(toml::Value::as_str);
            let is_one = keys.iter().any(|key| table.contains_key(*key));
            (is_one, title.map(str::to_string))
        }
        Err(_) => {
            let begins = |line: &str| {
                let rest = |key: &&str| line.trim_start().strip_prefix(*key);
                keys.iter()
                    .filter_map(rest)
                    .any(|rest| rest.trim_start().starts_with('='))
            };
            (text.lines().any(begins), None)
        }
    };
    is_one.then_some(ExperimentFile { path, title })
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod files_tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn experiments_are_told_from_other_toml_files() {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("b.toml", "title = \"B?\"\nscenarios = []\nmodels = []\n");
        write("a.toml", "models = [\nscenarios = \n");
        write("Cargo.toml", "[package]\nname = \"x\"\n");
        write("broken.toml", "[package\nmodelsx = 3\n");
        write("scenarios.txt", "scenarios = []\n");
        write(".hidden.toml", "scenarios = []\n");
        std::fs::create_dir(folder.path().join("more")).unwrap();
        let found = experiments_in(folder.path()).unwrap();
        let files: Vec<_> = found
            .files
            .iter()
            .map(|file| {
                (
                    file.path.file_name().unwrap().to_str(),
                    file.title.as_deref(),
                )
            })
            .collect();
        assert_eq!(
            files,
            [(Some("a.toml"), None), (Some("b.toml"), Some("B?"))]
        );
        assert_eq!(found.folders, [folder.path().join("more")]);
        let error = experiments_in(&folder.path().join("none")).unwrap_err();
        assert!(error.contains("none: "), "{error}");
    }
}
