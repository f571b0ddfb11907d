//! The stored specification of a batch: enough to resume it, or to detect that it has changed.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::matrix::{Matrix, RequestSettings};
use super::question_builder::QuestionBuilder;
use super::truth::TruthSource;
use crate::description::Frame;
use crate::evaluation::{Lead, default_frame, template};
use crate::formats::EgoSelection;
use crate::llm::Effort;
use crate::metrics::Thresholds;
use crate::prompts::{Library, Techniques};
use crate::verdict::Task;

/// Everything that determines what a batch asks.
#[derive(Debug, Clone, PartialEq)]
pub struct Spec {
    /// Files, folders, names of bundled scenarios.
    pub paths: Vec<PathBuf>,
    /// Questions about each scenario.
    pub matrix: Matrix,
    /// Where the truth is from.
    pub truth: TruthSource,
    /// The templates by file name, each with the hash of its text and fragments.
    pub templates: BTreeMap<String, String>,
    /// Descriptions of changes to the shipped thresholds.
    pub thresholds: Vec<String>,
    /// The address of the server, where it is not the provider's own.
    pub base_url: Option<String>,
    /// The ego of the scenarios.
    pub ego: EgoSelection,
    /// Texts of templates that were not saved, by file name.
    pub drafts: BTreeMap<String, String>,
}

/// Why a specification cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SpecError {
    /// It is not one, or one of another version of the program.
    #[error("what the batch asks cannot be read: {0}; begin a new batch")]
    Unreadable(String),
    /// Templates or thresholds are no longer the same.
    #[error("{0}; undo that, or begin a new batch")]
    Changed(String),
}

/// The form that is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    paths: Vec<PathBuf>,
    tasks: Vec<String>,
    frames: Vec<String>,
    techniques: Vec<String>,
    models: Vec<String>,
    samples: u32,
    history: Option<usize>,
    radius: Option<f64>,
    lead: Option<String>,
    temperature: Option<f64>,
    max_tokens: Option<u32>,
    effort: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    more_leads: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    transforms: Vec<String>,
    truth: String,
    truth_files: Vec<PathBuf>,
    templates: BTreeMap<String, String>,
    thresholds: Vec<String>,
    base_url: Option<String>,
    #[serde(default, skip_serializing_if = "is_default")]
    ego: EgoSelection,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    drafts: BTreeMap<String, String>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Spec {
    /// As JSON, the same for the same spec.
    #[must_use]
    pub fn to_json(&self) -> String {
        let (matrix, request) = (&self.matrix, &self.matrix.request);
        let (truth, truth_files) = match &self.truth {
            TruthSource::Geometry => ("geometry", Vec::new()),
            TruthSource::Layout => ("layout", Vec::new()),
            TruthSource::Files(files) => ("files", files.clone()),
        };
        let written = Written {
            paths: self.paths.clone(),
            tasks: words(&matrix.tasks, |task| task.name()),
            frames: words(&matrix.frames, |frame| frame.name()),
            techniques: words(&matrix.techniques, ToString::to_string),
            models: matrix.models.clone(),
            samples: matrix.samples,
            history: request.history,
            radius: request.radius,
            lead: request.lead.map(Lead::stored),
            temperature: request.temperature,
            max_tokens: request.max_tokens,
            effort: request.effort.map(|effort| effort.name().to_string()),
            more_leads: words(&matrix.more_leads, |lead| lead.stored()),
            transforms: words(&matrix.transforms, ToString::to_string),
            truth: truth.into(),
            truth_files,
            templates: self.templates.clone(),
            thresholds: self.thresholds.clone(),
            base_url: self.base_url.clone(),
            ego: self.ego.clone(),
            drafts: self.drafts.clone(),
        };
        // Strings, numbers and lists can always be written.
        serde_json::to_string(&written).unwrap_or_default()
    }

    /// From what [`Spec::to_json`] wrote.
    ///
    /// # Errors
    /// It is not of this form.
    pub fn from_json(json: &str) -> Result<Self, SpecError> {
        let written: Written =
            serde_json::from_str(json).map_err(|e| SpecError::Unreadable(e.to_string()))?;
        let effort = written.effort.map(|word| known(&word, Effort::parse));
        let lead = written.lead.map(|word| known(&word, |w| w.parse().ok()));
        let matrix = Matrix {
            tasks: each(&written.tasks, Task::parse)?,
            frames: each(&written.frames, Frame::parse)?,
            techniques: each(&written.techniques, |w| Techniques::parse(w).ok())?,
            models: written.models,
            samples: written.samples,
            more_leads: each(&written.more_leads, |w| w.parse().ok())?,
            transforms: each(&written.transforms, |w| w.parse().ok())?,
            request: RequestSettings {
                history: written.history,
                radius: written.radius,
                lead: lead.transpose()?,
                temperature: written.temperature,
                max_tokens: written.max_tokens,
                effort: effort.transpose()?,
            },
        };
        let truth = match written.truth.as_str() {
            "geometry" => TruthSource::Geometry,
            "layout" => TruthSource::Layout,
            "files" => TruthSource::Files(written.truth_files),
            other => return Err(unknown(other)),
        };
        Ok(Self {
            paths: written.paths,
            matrix,
            truth,
            templates: written.templates,
            thresholds: written.thresholds,
            base_url: written.base_url,
            ego: written.ego,
            drafts: written.drafts,
        })
    }

    /// The templates that a matrix is asked with, by file name with their hashes; frames that a task has none for are
    /// left out, their questions say so.
    #[must_use]
    pub fn templates_of(matrix: &Matrix, library: &Library) -> BTreeMap<String, String> {
        let mut found = BTreeMap::new();
        for way in matrix.ways() {
            let frame = way
                .frame
                .unwrap_or_else(|| default_frame(library, way.task));
            if let Ok((file, template)) = template(library, way.task, frame) {
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
        let mut library = library.clone();
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
        let (request, ego) = (self.matrix.request, self.ego.clone());
        Ok(QuestionBuilder::new(library, thresholds, request, ego))
    }

    /// Whether templates and thresholds are still those of the batch.
    ///
    /// # Errors
    /// Which are not.
    pub fn still(&self, library: &Library, thresholds: &Thresholds) -> Result<(), SpecError> {
        let now = Self::templates_of(&self.matrix, &self.library(library)?);
        for (file, hash) in &self.templates {
            if now.get(file) != Some(hash) {
                let why =
                    format!("the template {file} is not the one that the batch was begun with");
                return Err(SpecError::Changed(why));
            }
        }
        if Self::thresholds_of(thresholds) != self.thresholds {
            let why = "thresholds.toml says something else than when the batch was begun";
            return Err(SpecError::Changed(why.into()));
        }
        Ok(())
    }
}

fn words<T, S: ToString>(values: &[T], word: impl Fn(&T) -> S) -> Vec<String> {
    values.iter().map(|value| word(value).to_string()).collect()
}

fn each<T>(words: &[String], parse: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, SpecError> {
    words.iter().map(|word| known(word, &parse)).collect()
}

fn known<T>(word: &str, parse: impl Fn(&str) -> Option<T>) -> Result<T, SpecError> {
    parse(word).ok_or_else(|| unknown(word))
}

fn unknown(word: &str) -> SpecError {
    SpecError::Unreadable(format!("`{word}` is not known to this version"))
}
