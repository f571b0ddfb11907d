//! The stored specification of a batch: enough to resume it, or to detect that it has changed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::experiment::Experiment;
use super::question_builder::QuestionBuilder;
use super::truth::TruthSource;
use crate::evaluation::{default_frame, template};
use nearmiss_ask::prompts::{Library, Origin};
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;

/// Everything that determines what a batch asks.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Spec {
    /// The templates by file name, each with the hash of its text and fragments.
    pub templates: BTreeMap<String, String>,
    /// Descriptions of changes to the shipped thresholds.
    pub thresholds: Vec<String>,
    /// The ego of the scenarios.
    #[serde(default, skip_serializing_if = "is_default")]
    pub ego: EgoSelection,
    /// Texts of templates that were not saved, by file name.
    #[serde(default, skip_serializing_if = "is_default")]
    pub drafts: BTreeMap<String, String>,
    /// Paths of the scenarios that windows are drawn from, in order, asked about or not: windows of what is added are
    /// matched among the same. Empty in batches of versions that did not write them down.
    #[serde(default, skip_serializing_if = "is_default")]
    pub drawn_from: Vec<String>,
    /// What is asked.
    #[serde(flatten)]
    pub experiment: Experiment,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Why a specification cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SpecError {
    /// It is not one, or one of another version of the program.
    #[error("the batch's questions cannot be read: {0}; start a new batch")]
    Unreadable(String),
    /// A template is not the one that the batch was begun with.
    #[error("template {file} is not the one that the batch began with ({hash}…): {}", other(file, place.as_deref()))]
    OtherTemplate {
        /// The file's name.
        file: String,
        /// The user's file; `None` if it is the program's own.
        place: Option<PathBuf>,
        /// The start of the hash of the one it began with.
        hash: String,
    },
    /// Templates or thresholds are no longer the same.
    #[error("{0}; undo that, or start a new batch")]
    Changed(String),
}

/// What changed about a template, and what to do.
fn other(file: &str, place: Option<&Path>) -> String {
    match place {
        Some(path) => format!(
            "{}, or a fragment that it includes, has changed; undo that, or start a new batch",
            path.display()
        ),
        None => format!(
            "the program's own text is used now; put the older text into your folder of templates (`nearmiss prompt text \
             {file}` with the nearmiss that began the batch prints it), or start a new batch. Reports still have its answers"
        ),
    }
}

impl Spec {
    /// Where the truth is from.
    #[must_use]
    pub fn truth(&self) -> &TruthSource {
        let truth = self.experiment.truth.as_ref();
        truth.unwrap_or(&TruthSource::Geometry)
    }

    /// What the truth of its questions is, in words for people.
    #[must_use]
    pub fn truth_words(&self) -> String {
        let tasks = &self.experiment.tasks;
        if matches!(tasks[..], [Task::Recording]) {
            return self.truth().words_of_recordings();
        }
        let words = self.words_of_windows();
        let more = if tasks.contains(&Task::Recording) {
            format!(
                "; of recordings as a whole, {}",
                self.truth().words_of_recordings()
            )
        } else {
            String::new()
        };
        format!("{words}{more}")
    }

    fn words_of_windows(&self) -> String {
        let words = self.truth().words();
        match (self.experiment.within, self.truth()) {
            (None, _) => words,
            (Some(horizon), TruthSource::Score(_)) => {
                format!("{words}; of windows, within the {horizon} s after them")
            }
            (Some(horizon), TruthSource::Geometry) => {
                format!("exact geometry of each matched window and the {horizon} s after it")
            }
            (Some(horizon), _) => {
                format!("{words}, for each matched window and the {horizon} s after it")
            }
        }
    }

    /// The templates that an experiment is asked with, by file name with their hashes; frames that a task has none for are
    /// left out, their questions say so.
    #[must_use]
    pub fn templates_of(experiment: &Experiment, library: &Library) -> BTreeMap<String, String> {
        let library = &library.clone().with_pack(experiment.pack);
        let mut found = BTreeMap::new();
        let ways = experiment.ways();
        let asked = ways.iter().map(|way| (way.task, way.frame));
        for (task, frame) in asked.collect::<BTreeSet<_>>() {
            let frame = frame.unwrap_or_else(|| default_frame(library, task));
            if let Ok((file, template)) = template(library, task, frame) {
                found.insert(file.to_string(), library.hash(&template.source));
            }
        }
        found
    }

    /// Describes the changes to the thresholds.
    #[must_use]
    pub fn thresholds_of(thresholds: &Thresholds) -> Vec<String> {
        thresholds
            .changes()
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// The templates that the batch is asked with: those of the library, and its drafts in their places.
    ///
    /// # Errors
    /// A draft is no template.
    pub fn library(&self, library: &Library) -> Result<Library, SpecError> {
        let mut library = library.clone().with_pack(self.experiment.pack);
        for (file, text) in &self.drafts {
            let used = library.use_draft(file, text);
            used.map_err(|error| SpecError::Unreadable(error.in_file(file)))?;
        }
        Ok(library)
    }

    /// What makes the questions of the batch.
    ///
    /// # Errors
    /// A draft is no template.
    pub fn builder(
        &self,
        library: &Library,
        thresholds: Arc<Thresholds>,
    ) -> Result<QuestionBuilder, SpecError> {
        let library = self.library(library)?;
        let (experiment, ego) = (self.experiment.clone(), self.ego.clone());
        Ok(QuestionBuilder::new(library, thresholds, experiment, ego))
    }

    /// What makes the questions of the batch again.
    ///
    /// # Errors
    /// They would be others now: templates or thresholds have changed.
    pub fn builder_again(
        &self,
        library: &Library,
        thresholds: Arc<Thresholds>,
    ) -> Result<QuestionBuilder, SpecError> {
        self.still(library, &thresholds)?;
        self.builder(library, thresholds)
    }

    /// Whether templates and thresholds are still those of the batch.
    ///
    /// # Errors
    /// Which are not.
    pub fn still(&self, library: &Library, thresholds: &Thresholds) -> Result<(), SpecError> {
        let library = self.library(library)?;
        let now = Self::templates_of(&self.experiment, &library);
        for (file, hash) in &self.templates {
            if now.get(file) != Some(hash) {
                let place = match library.source(file) {
                    Some((_, Origin::User(path))) => Some(path.clone()),
                    _ => None,
                };
                return Err(SpecError::OtherTemplate {
                    file: file.clone(),
                    place,
                    hash: hash.chars().take(12).collect(),
                });
            }
        }
        if Self::thresholds_of(thresholds) != self.thresholds {
            let why = "thresholds.toml has changed since the batch started";
            return Err(SpecError::Changed(why.into()));
        }
        Ok(())
    }
}
