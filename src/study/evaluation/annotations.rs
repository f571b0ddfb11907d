//! Annotations in a repository laid out as that of "From Words to Collisions": the ground truth of its scenarios.

use std::path::{Path, PathBuf};

use super::labels::Labels;
use nearmiss_base::system;

/// A file or folder that is no answer or annotation, or an incomplete one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {message}", path.display())]
pub struct Problem {
    /// Which file or folder.
    pub path: PathBuf,
    /// The problem and its consequence.
    pub message: String,
    /// The data it loses.
    pub loss: Loss,
}

/// Severity of a problem: what data it loses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// No effect: just something unexpected.
    Nothing,
    /// An optional answer is absent.
    Absent,
    /// Something present could not be read, or only in part.
    Unread,
}

impl Problem {
    /// A file or folder that could not be read, or only in part.
    #[must_use]
    pub fn unread(path: impl Into<PathBuf>, message: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            message: message.into(),
            loss: Loss::Unread,
        }
    }
}

/// The truth about the scenarios below `root`: its files `annotations.csv` and `annotation_normal.csv` in
/// `Results/LLM`.
#[must_use]
pub fn annotations(root: &Path) -> (Labels, Vec<Problem>) {
    let mut labels = Labels::default();
    let mut problems = Vec::new();
    let top = results_folder(root).join("LLM");
    let mut files = Vec::new();
    let mut folders = vec![(top.clone(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let paths = sorted_paths(&folder).unwrap_or_else(|problem| {
            problems.push(problem);
            Vec::new()
        });
        for path in paths {
            let name = file_name(&path);
            if path.is_dir() && depth < 3 {
                folders.push((path, depth + 1));
            } else if name.starts_with("annotation") && name.ends_with(".csv") {
                files.push(path);
            }
        }
    }
    files.sort();
    if files.is_empty() {
        problems.push(Problem::unread(top, "there are no annotations below it"));
    }
    for file in files {
        let bytes = system::read_file(&file, system::LARGEST).map_err(|e| system::error_text(&e));
        let read = bytes.and_then(|bytes| {
            let read = labels.read(&bytes, &file_name(&file));
            read.map_err(|e| e.to_string())
        });
        if let Err(message) = read {
            problems.push(Problem::unread(file, message));
        }
    }
    (labels, problems)
}

/// `Results` below `root`, or `root` where there is no such folder.
pub(crate) fn results_folder(root: &Path) -> PathBuf {
    let results = root.join("Results");
    if results.is_dir() {
        results
    } else {
        root.to_path_buf()
    }
}

/// What is in a folder, in order.
pub(crate) fn sorted_paths(folder: &Path) -> Result<Vec<PathBuf>, Problem> {
    let read = std::fs::read_dir(folder).and_then(|entries| {
        let paths = entries.map(|entry| entry.map(|e| e.path()));
        paths.collect::<Result<Vec<_>, _>>()
    });
    let mut paths =
        read.map_err(|error| Problem::unread(folder, format!("cannot be read: {error}")))?;
    paths.sort();
    Ok(paths)
}

/// The last part of a path.
pub(crate) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::Label;

    fn put(root: &Path, path: &str, text: &str) {
        let path = root.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    #[test]
    fn truth_comes_from_the_annotations() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        put(
            root,
            "Results/LLM/Scenario_Collision/ego/annotations.csv",
            "Scenario_Name,Obstacle_ID\nZAM_A-1,7\n",
        );
        put(
            root,
            "Results/LLM/Senario_Normal/ego/annotation_normal.csv",
            "Scenario_Name,Obstacle_ID\nZAM_B-1,none\n",
        );
        put(root, "Results/LLM/x/annotation_bad.csv", "a,b\n1,2\n");
        let (labels, problems) = annotations(root);
        assert_eq!(labels.get("ZAM_A-1"), Some(Label::Collision(Some(7))));
        assert_eq!(labels.get("ZAM_B-1"), Some(Label::Safe));
        assert_eq!(problems.len(), 1);
    }
}
