//! Ground truth of a batch: exact geometry, risk scores, label files, or the scenarios' folders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::evaluation::{CriticalMoments, Label, LabelError, Labelled, Labels, annotations};
use nearmiss_base::system;
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_record::fields::{FieldValue, Takes, Wrong};
use nearmiss_scene::metrics::{RiskConvention, Thresholds};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_store::Item;
use toml::Value;

use super::question_builder::stored_path;
use super::scored::label_of_item;

/// Source of the ground truth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TruthSource {
    /// The exact geometry of the whole recordings.
    Geometry,
    /// The folders `collision_scenarios` and `normal_scenarios`, and the annotations of the repository that they are
    /// in.
    Layout,
    /// Risk scores from time and distance to a collision: what is of extreme risk is critical.
    Score(RiskConvention),
    /// CSV files.
    Files(Vec<PathBuf>),
}

/// Words of `--truth` for risk scores.
const SCORES: [(&str, RiskConvention); 2] = [
    ("score", RiskConvention::Exact),
    ("score:paper", RiskConvention::Paper),
];

/// Ground truth of a batch's scenarios.
#[derive(Debug)]
pub enum Truth {
    /// The exact geometry of the whole recordings.
    Geometry,
    /// The folders, and the annotations by the repository's folder.
    Layout(BTreeMap<PathBuf, Labels>),
    /// Labels.
    Labels(Labels),
    /// Risk scores.
    Score(RiskConvention),
    /// Labels stored by a batch, by the scenario's file, or the name of a bundled one; of the recording task, which
    /// says more than that of collisions, by themselves.
    Known(BTreeMap<(bool, String), Option<Label>>),
}

/// Why there is no ground truth.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// A file cannot be read.
    #[error(
        "--truth {file}: {}; use CSV files, or auto (exact geometry), score (risk score) or layout (folders) alone",
        system::error_text(source)
    )]
    File {
        /// Which file.
        file: String,
        /// The system's error.
        source: std::io::Error,
    },
    /// A file holds no labels.
    #[error(transparent)]
    Labels(#[from] LabelError),
}

/// The folders of the two halves in the repository of "From Words to Collisions", and whether they collide.
const HALVES: [(&str, bool); 2] = [("collision_scenarios", true), ("normal_scenarios", false)];

impl TruthSource {
    /// Where the truth is from by default: the folders, if a scenario lies in one of them, else the geometry.
    #[must_use]
    pub fn default_for(entries: &[Entry]) -> Self {
        if entries.iter().any(|entry| half(entry).is_some()) {
            Self::Layout
        } else {
            Self::Geometry
        }
    }

    /// The risk score that a word of `--truth` means.
    #[must_use]
    pub fn score(word: &str) -> Option<RiskConvention> {
        let found = SCORES.iter().find(|(known, _)| *known == word);
        found.map(|(_, convention)| *convention)
    }

    /// What such a truth is, in words for people.
    #[must_use]
    pub fn score_summary(convention: RiskConvention) -> String {
        let by = match convention {
            RiskConvention::Exact => "by exact geometry",
            RiskConvention::Paper => "by the paper's convention",
        };
        format!(
            "risk score of TTC and MDC {by}, critical up to {}",
            Task::HIGH_RISK
        )
    }

    /// Whether a risk score tells what is true about a task: of whole recordings it does beside folders, too.
    #[must_use]
    pub fn is_score(&self, task: Task) -> bool {
        match self {
            Self::Score(_) => matches!(task, Task::Safety | Task::Recording),
            Self::Geometry | Self::Layout => task == Task::Recording,
            Self::Files(_) => false,
        }
    }

    /// The same as words of `--truth`: `auto`, `layout`, `score`, or files.
    #[must_use]
    pub fn sources(&self) -> Vec<String> {
        match self {
            Self::Geometry => vec!["auto".into()],
            Self::Layout => vec!["layout".into()],
            Self::Score(convention) => {
                let words = SCORES.iter().filter(|(_, known)| known == convention);
                words.map(|(word, _)| (*word).into()).collect()
            }
            Self::Files(files) => files.iter().map(|f| f.display().to_string()).collect(),
        }
    }

    /// What is true of the recording task, in words for people.
    #[must_use]
    pub fn recordings_summary(&self) -> String {
        let exact = Self::score_summary(RiskConvention::Exact);
        match self {
            Self::Geometry => exact,
            Self::Layout => format!("collisions by folder, else {exact}"),
            Self::Score(_) | Self::Files(_) => self.summary(),
        }
    }

    /// From words of `--truth`; files as they are named. None without a word.
    #[must_use]
    pub fn from_arguments(words: &[String]) -> Option<Self> {
        Some(match words {
            [] => return None,
            [one] if one == "auto" => Self::Geometry,
            [one] if one == "layout" => Self::Layout,
            [one] if Self::score(one).is_some() => Self::Score(Self::score(one)?),
            files => Self::Files(files.iter().map(PathBuf::from).collect()),
        })
    }

    /// The same with absolute paths.
    #[must_use]
    pub fn absolute(self) -> Self {
        let absolute = |file: PathBuf| std::path::absolute(&file).unwrap_or(file);
        match self {
            Self::Files(files) => Self::Files(files.into_iter().map(absolute).collect()),
            other => other,
        }
    }

    /// In words for people.
    #[must_use]
    pub fn summary(&self) -> String {
        match self {
            Self::Geometry => "exact geometry of the whole recordings".into(),
            Self::Layout => "the scenarios' folders and their annotations".into(),
            Self::Score(convention) => Self::score_summary(*convention),
            Self::Files(files) => {
                let names: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
                format!("labels from {}", names.join(", "))
            }
        }
    }
}

impl FieldValue for TruthSource {
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        let words = match value.as_str() {
            Some(word) => vec![word.to_string()],
            None => <Vec<String>>::read(value, takes)?,
        };
        Self::from_arguments(&words).ok_or(Wrong::kind())
    }

    fn write(&self) -> Option<Value> {
        Some(self.sources().into())
    }

    fn describe(takes: &Takes) -> (String, serde_json::Value) {
        <Vec<String>>::describe(takes)
    }

    fn parse(text: &str) -> Value {
        <Vec<String>>::parse(text)
    }
}

impl Truth {
    /// Reads the ground truth of these scenarios, with warnings about it.
    ///
    /// # Errors
    /// A file cannot be read, or holds no labels.
    pub fn open(
        source: &TruthSource,
        entries: &[Entry],
    ) -> Result<(Self, Vec<String>), TruthError> {
        let mut doubts = Vec::new();
        let truth = match source {
            TruthSource::Geometry => Self::Geometry,
            TruthSource::Score(convention) => Self::Score(*convention),
            TruthSource::Files(files) => {
                let mut labels = Labels::default();
                for path in files {
                    let file = path.display().to_string();
                    let bytes = system::read_file(path, system::LARGEST).map_err(|source| {
                        TruthError::File {
                            file: file.clone(),
                            source,
                        }
                    })?;
                    labels.read(&bytes, &file)?;
                }
                doubts.extend(labels.strangers(entries.iter().map(|e| e.name.as_str())));
                Self::Labels(labels)
            }
            TruthSource::Layout => {
                let mut annotated: BTreeMap<PathBuf, Labels> = BTreeMap::new();
                for entry in entries {
                    let Some((collides, root)) = half(entry) else {
                        continue;
                    };
                    let labels = annotated.entry(root.clone()).or_insert_with(|| {
                        if !root.join("Results").join("LLM").is_dir() {
                            return Labels::default();
                        }
                        let (labels, problems) = annotations(&root);
                        doubts.extend(problems.iter().map(ToString::to_string));
                        labels
                    });
                    if let Some(label) = labels.get(&entry.name)
                        && label.collides() != collides
                    {
                        doubts.push(format!(
                            "{}: annotation and folder disagree; the folder counts",
                            entry.name
                        ));
                    }
                }
                Self::Layout(annotated)
            }
        };
        Ok((truth, doubts))
    }

    /// Whether scenarios that it says nothing about are left out; they could be neither right nor wrong.
    #[must_use]
    pub fn leaves_out(&self) -> bool {
        matches!(self, Self::Labels(_) | Self::Layout(_))
    }

    /// The truth as the questions of a batch have it: a scenario with a dangerous window is a collision.
    #[must_use]
    pub fn of_items(items: &[Item]) -> Self {
        let mut known: BTreeMap<(bool, String), Option<Label>> = BTreeMap::new();
        for item in items {
            let label = label_of_item(&item.asked);
            let whole = item.asked.task == Task::Recording;
            let path = item.asked.path.clone();
            let before = known.entry((whole, path)).or_insert(label);
            if !before.is_some_and(Label::collides) {
                *before = label.or(*before);
            }
        }
        Self::Known(known)
    }

    /// Whether the obstacle that a label names is in its scenario; without the scene nothing is looked at.
    ///
    /// # Errors
    /// It is not.
    pub fn fits(&self, entry: &Entry, scene: Option<&Scene>) -> Result<(), LabelError> {
        match (self, scene) {
            (Self::Labels(labels), Some(scene)) => labels.fit(&entry.name, &scene.scenario),
            _ => Ok(()),
        }
    }

    /// Why the risk score says nothing about a scene, where it is the truth and does not.
    #[must_use]
    pub fn not_scored(&self, scene: &Scene, thresholds: &Thresholds) -> Option<String> {
        let convention = self.convention()?;
        let why = CriticalMoments::new(convention, scene, thresholds).err()?;
        Some(format!("not scored, so left out of the counts: {why}"))
    }

    /// What is true about a task's question about this window, and the critical obstacles; `None` if unknown.
    ///
    /// Whether a recording is of high risk is told by risk scores, but for labels; a folder tells of collisions alone.
    #[must_use]
    pub fn of_question(
        &self,
        task: Task,
        (entry, scene): (&Entry, Option<&Scene>),
        (window, horizon): (&Window, f64),
        thresholds: &Thresholds,
    ) -> Option<(Label, Vec<i64>)> {
        let moments =
            |convention: RiskConvention| CriticalMoments::new(convention, scene?, thresholds).ok();
        let whole = |convention| Some(moments(convention)?.of_recording());
        let alone = |label: Label| (label, label.critical());
        match (self, task) {
            (Self::Score(convention), Task::Recording) => whole(*convention),
            (Self::Score(convention), Task::Safety) => {
                let dt = scene?.scenario.dt();
                Some(moments(*convention)?.after(window, horizon, dt))
            }
            (Self::Geometry, Task::Recording) => whole(RiskConvention::Exact),
            (Self::Layout(_), Task::Recording) => match self.label(entry, None)? {
                Label::Safe => whole(RiskConvention::Exact),
                collision => Some(alone(collision)),
            },
            (Self::Known(known), Task::Recording) => {
                known.get(&(true, stored_path(entry))).copied()?.map(alone)
            }
            _ => self.label(entry, scene).map(alone),
        }
    }

    /// The risk score that it is, if it is one.
    #[must_use]
    pub fn convention(&self) -> Option<RiskConvention> {
        match self {
            Self::Score(convention) => Some(*convention),
            _ => None,
        }
    }

    /// Whether a scenario collides; `None` if unknown. Exact geometry and risk scores, of which contact is the lowest,
    /// need the scene.
    #[must_use]
    pub fn label(&self, entry: &Entry, scene: Option<&Scene>) -> Option<Label> {
        match self {
            Self::Geometry | Self::Score(_) => scene.map(|scene| Labelled::new(scene, None).label),
            Self::Labels(labels) => labels.get(&entry.name),
            Self::Known(known) => known.get(&(false, stored_path(entry))).copied().flatten(),
            Self::Layout(annotated) => {
                let (collides, root) = half(entry)?;
                if !collides {
                    return Some(Label::Safe);
                }
                let label = annotated
                    .get(&root)
                    .and_then(|labels| labels.get(&entry.name));
                Some(match label {
                    Some(label @ Label::Collision(_)) => label,
                    _ => Label::Collision(None),
                })
            }
        }
    }
}

/// Whether the folder of a scenario is that of the collisions, and the repository that it is in; nothing if it is
/// neither of the two.
fn half(entry: &Entry) -> Option<(bool, PathBuf)> {
    let EntryLocation::File(path) = &entry.place else {
        return None;
    };
    path.ancestors().skip(1).find_map(|folder| {
        let name = folder.file_name()?;
        let (_, collides) = HALVES.iter().find(|(half, _)| name == *half)?;
        let above = folder.parent().unwrap_or(Path::new(""));
        let root = match above.file_name() {
            Some(name) if name == "Scenarios" => above.parent().unwrap_or(above),
            _ => above,
        };
        Some((*collides, root.to_path_buf()))
    })
}
