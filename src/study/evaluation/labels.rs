//! Ground-truth labels by scenario, from CSV or a repository laid out as that of "From Words to Collisions".

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system;
use nearmiss_scene::scenario::Scenario;

/// Ground-truth label of one scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// No obstacle collides with the ego.
    Safe,
    /// One does: this obstacle, where it is given.
    Collision(Option<i64>),
}

/// Labels by the scenario's name.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Labels(BTreeMap<String, Entry>);

/// A label and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Entry {
    label: Label,
    file: Arc<str>,
    line: u64,
}

/// Why labels cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LabelError {
    /// It is no CSV.
    #[error("{file}: {message}")]
    Csv {
        /// The file.
        file: String,
        /// The problem.
        message: String,
    },
    /// A column is missing.
    #[error("{file}: no column for the {what}; the first line needs one of {known}")]
    Column {
        /// The file.
        file: String,
        /// Contents of the column.
        what: &'static str,
        /// Names it may have.
        known: String,
    },
    /// A value that says neither yes nor no.
    #[error("{file}, line {line}: `{value}` is not {what}")]
    Value {
        /// The file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// The invalid value.
        value: String,
        /// The expected content.
        what: &'static str,
    },
    /// A scenario has two different labels.
    #[error("{file}, line {line}: {scenario} already has a different label; remove one")]
    Contradiction {
        /// The file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Which scenario.
        scenario: String,
    },
    /// An obstacle that the scenario does not have.
    #[error("{file}, line {line}: {scenario} has no obstacle {id}; it has {there}")]
    Obstacle {
        /// The file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Which scenario.
        scenario: String,
        /// The id that the label names.
        id: i64,
        /// The ids that exist.
        there: String,
    },
    /// The file has no labels.
    #[error("{file}: has no labels")]
    Empty {
        /// The file.
        file: String,
    },
}

const SCENARIO: [&str; 3] = ["scenario", "scenario_name", "name"];
const ANSWER: [&str; 2] = ["label", "collision"];
/// Labels of scenarios in which an obstacle collides with the ego, or is about to; capitals are the same.
pub(super) const DANGEROUS: [&str; 6] = ["collision", "critical", "dangerous", "yes", "true", "1"];
/// Labels of the others.
pub(super) const SAFE: [&str; 6] = ["safe", "normal", "none", "no", "false", "0"];
const OBSTACLE: [&str; 2] = ["obstacle_id", "obstacle"];

/// The allowed labels.
fn known_labels() -> &'static str {
    static WORDS: std::sync::LazyLock<String> = std::sync::LazyLock::new(|| {
        format!(
            "a label; use one of {}, or of {}",
            DANGEROUS.join(", "),
            SAFE.join(", ")
        )
    });
    &WORDS
}

/// The name of a scenario without the ending of its file.
fn without_ending(name: &str) -> &str {
    let at = name.len().saturating_sub(4);
    match name.get(at..) {
        Some(ending) if ending.eq_ignore_ascii_case(".xml") => &name[..at],
        _ => name,
    }
}

/// Obstacles that are named where there may be hundreds.
const MAX_LISTED: usize = 5;

impl Labels {
    /// Reads CSV `bytes` with a header; `file` names it in errors.
    ///
    /// The scenario's name is in the column `scenario`, `scenario_name` or `name`; an ending `.xml` is left out. A
    /// column `label` or `collision` says one of `DANGEROUS` or `SAFE` below; or a column `obstacle_id` or `obstacle`
    /// has the id of the obstacle that collides, and `none` where none does (or nothing, beside a label), as the
    /// annotations of "From Words to Collisions" have it.
    ///
    /// # Errors
    /// See [`LabelError`].
    pub fn read(&mut self, bytes: &[u8], file: &str) -> Result<(), LabelError> {
        let csv_error = |e: csv::Error| LabelError::Csv {
            file: file.to_string(),
            message: e.to_string(),
        };
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(bytes);
        let header = reader.headers().map_err(csv_error)?.clone();
        let place = |names: &[&str]| {
            let known = |h: &str| names.iter().any(|n| h.eq_ignore_ascii_case(n));
            header
                .iter()
                .position(|h| known(h.trim_start_matches('\u{feff}')))
        };
        let missing = |what, known: &[&str]| LabelError::Column {
            file: file.to_string(),
            what,
            known: known.join(", "),
        };
        let scenario = place(&SCENARIO).ok_or_else(|| missing("scenario", &SCENARIO))?;
        let (answer, obstacle) = (place(&ANSWER), place(&OBSTACLE));
        if answer.is_none() && obstacle.is_none() {
            return Err(missing("label", &[&ANSWER[..], &OBSTACLE[..]].concat()));
        }
        let origin: Arc<str> = file.into();
        let mut any = false;
        for row in reader.records() {
            let row = row.map_err(csv_error)?;
            let line = row.position().map_or(0, csv::Position::line);
            let cell = |at: Option<usize>| at.and_then(|at| row.get(at)).unwrap_or("");
            let wrong = |value: &str, what| LabelError::Value {
                file: file.to_string(),
                line,
                value: value.chars().take(40).collect(),
                what,
            };
            let name = without_ending(cell(Some(scenario)));
            if name.is_empty() {
                return Err(wrong(name, "a scenario name"));
            }
            let who = cell(obstacle).to_ascii_lowercase();
            let id = match who.as_str() {
                // An empty cell alone is not a no: it may have been forgotten.
                "" if answer.is_none() => {
                    return Err(wrong("", "an obstacle id or none"));
                }
                "" | "none" => None,
                text => Some(
                    text.parse::<i64>()
                        .map_err(|_| wrong(text, "an obstacle id or none"))?,
                ),
            };
            let label = match (answer, cell(answer).to_ascii_lowercase().as_str()) {
                (None, _) => id.map_or(Label::Safe, |id| Label::Collision(Some(id))),
                (_, word) if DANGEROUS.contains(&word) => Label::Collision(id),
                (_, word) if SAFE.contains(&word) => Label::Safe,
                (_, text) => return Err(wrong(text, known_labels())),
            };
            if label == Label::Collision(None) && who == "none" {
                let what = "an obstacle, but the label is a collision; leave it empty if the obstacle is unknown";
                return Err(wrong(cell(obstacle), what));
            }
            if label == Label::Safe && id.is_some() {
                let what = "allowed as the obstacle of a safe scenario";
                return Err(wrong(cell(obstacle), what));
            }
            any = true;
            let said = Entry {
                label,
                file: Arc::clone(&origin),
                line,
            };
            let before = self.0.entry(name.to_string()).or_insert(said);
            if before.label != label {
                return Err(LabelError::Contradiction {
                    file: file.to_string(),
                    line,
                    scenario: name.chars().take(80).collect(),
                });
            }
        }
        if any {
            Ok(())
        } else {
            Err(LabelError::Empty {
                file: file.to_string(),
            })
        }
    }

    /// Every scenario with its label, in the order of the names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Label)> {
        self.0
            .iter()
            .map(|(name, said)| (name.as_str(), said.label))
    }

    /// The label of a scenario.
    #[must_use]
    pub fn get(&self, scenario: &str) -> Option<Label> {
        self.0.get(scenario).map(|said| said.label)
    }

    /// Whether the label of a scenario says who collides, so that [`Labels::fit`] has something to look at.
    #[must_use]
    pub fn names_an_obstacle(&self, scenario: &str) -> bool {
        matches!(self.get(scenario), Some(Label::Collision(Some(_))))
    }

    /// Whether the obstacle that the label of a scenario names is there; `name` is what the labels call the scenario.
    ///
    /// # Errors
    /// [`LabelError::Obstacle`].
    pub fn fit(&self, name: &str, scenario: &Scenario) -> Result<(), LabelError> {
        let Some(said) = self.0.get(name) else {
            return Ok(());
        };
        let Label::Collision(Some(id)) = said.label else {
            return Ok(());
        };
        if scenario.obstacle(id).is_some() {
            return Ok(());
        }
        let ids: BTreeSet<i64> = scenario.obstacles.iter().map(|o| o.id).collect();
        let first: Vec<String> = ids
            .iter()
            .take(MAX_LISTED)
            .map(ToString::to_string)
            .collect();
        let there = match ids.len() {
            0 => "none".into(),
            all if all > MAX_LISTED => {
                format!("{} and {} more", first.join(", "), all - MAX_LISTED)
            }
            _ => first.join(", "),
        };
        Err(LabelError::Obstacle {
            file: said.file.to_string(),
            line: said.line,
            scenario: name.into(),
            id,
            there,
        })
    }

    /// In words, that there are labels of scenarios that are not among these; `None` if there are none.
    #[must_use]
    pub fn strangers<'a>(&self, scenarios: impl Iterator<Item = &'a str>) -> Option<String> {
        let there: BTreeSet<&str> = scenarios.collect();
        let mut strangers = self.0.keys().filter(|name| !there.contains(name.as_str()));
        let first = strangers.next()?;
        Some(match strangers.count() {
            0 => format!("the truth names {first}, which is not among these scenarios"),
            more => format!(
                "the truth names {} scenarios that are not among these, such as {first}",
                more + 1
            ),
        })
    }
}

impl Label {
    /// Whether the ego collides.
    #[must_use]
    pub fn collides(self) -> bool {
        matches!(self, Self::Collision(_))
    }

    /// The critical obstacles that it tells: that which collides, where it is given.
    #[must_use]
    pub fn critical(self) -> Vec<i64> {
        match self {
            Self::Collision(obstacle) => obstacle.into_iter().collect(),
            Self::Safe => Vec::new(),
        }
    }
}

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

    fn read(text: &str) -> Result<Labels, String> {
        let mut labels = Labels::default();
        let read = labels.read(text.as_bytes(), "truth.csv");
        read.map(|()| labels).map_err(|e| e.to_string())
    }

    #[test]
    fn labels_and_annotated_obstacles() {
        let labels = read("Scenario_Name,Obstacle_ID\r\nA-1,7\r\nB-1,none\r\n").unwrap();
        assert_eq!(labels.get("A-1"), Some(Label::Collision(Some(7))));
        assert_eq!(labels.get("B-1"), Some(Label::Safe));
        assert_eq!(labels.get("C-1"), None);
        let labels = read("\u{feff}name,label\nA, Collision\nB,0\n").unwrap();
        assert_eq!(labels.get("A"), Some(Label::Collision(None)));
        assert_eq!(labels.get("B"), Some(Label::Safe));
        let labels = read("name,label,obstacle\nA.xml,critical,\nB.XML,Dangerous,3\n").unwrap();
        assert_eq!(labels.get("A"), Some(Label::Collision(None)));
        assert_eq!(labels.get("B"), Some(Label::Collision(Some(3))));
        assert_eq!(labels.get("A.xml"), None);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, words) in [
            ("a,b\nx,1\n", "no column for the scenario"),
            ("name,b\nx,1\n", "no column for the label"),
            ("name,label\nx,1\ny,perhaps\n", "line 3: `perhaps`"),
            (
                "name,label\nx,perhaps\n",
                "collision, critical, dangerous, yes, true, 1, or of safe",
            ),
            (
                "name,label,obstacle_id\nx,yes,None\n",
                "line 2: `None` is not an obstacle",
            ),
            ("name,obstacle_id\nx,7b\n", "line 2: `7b`"),
            (
                "name,label\nx,1\nx,0\n",
                "line 3: x already has a different label",
            ),
            ("name,label\n,1\n", "line 2: `` is not a scenario name"),
            ("name,obstacle_id\nx,\n", "line 2: `` is not an obstacle id"),
            (
                "name,label,obstacle_id\nx,no,7\n",
                "line 2: `7` is not allowed",
            ),
            ("name,label\n", "has no labels"),
            ("name,label\nx\n", "found record with 1 field"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }

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
