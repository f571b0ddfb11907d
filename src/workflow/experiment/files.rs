//! Finds the experiment files of a folder, among other TOML files.

use std::path::{Path, PathBuf};

use super::prepare::is_experiment_file;
use nearmiss_base::system;

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
const MOST: usize = 10_000;

/// TOML files of a folder that are read.
const MOST_READ: usize = 500;

/// A larger file is no experiment, bytes.
const LARGEST: u64 = 1 << 20;

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
    for entry in entries.flatten().take(MOST) {
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
    candidates.truncate(MOST_READ);
    found.files = candidates.into_iter().filter_map(experiment).collect();
    Ok(found)
}

/// The file, if it is an experiment; one that is broken still counts where it has a line for scenarios or models.
fn experiment(path: PathBuf) -> Option<ExperimentFile> {
    let text = system::read_text(&path, LARGEST).ok()?;
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
mod tests {
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
