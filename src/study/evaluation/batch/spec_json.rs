//! The specification of a batch as JSON, the form in which the store keeps it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::matrix::{Matrix, RequestSettings};
use super::spec::{Spec, SpecError};
use super::split::{Split, Subset};
use super::truth::TruthSource;
use crate::evaluation::report::Comparison;
use crate::evaluation::{Axes, Lead, Protocol};
use nearmiss_ask::llm::{Effort, ToolLimits};
use nearmiss_ask::prompts::{Pack, Techniques};
use nearmiss_formats::EgoSelection;
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::metrics::MeasureList;
use nearmiss_scene::verdict::Task;

/// The form that is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    title: Option<String>,
    paths: Vec<PathBuf>,
    tasks: Vec<String>,
    frames: Vec<String>,
    techniques: Vec<String>,
    models: Vec<String>,
    samples: u32,
    history: Option<usize>,
    radius: Option<f64>,
    lead: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    within: Option<f64>,
    #[serde(default, skip_serializing_if = "is_default")]
    every_scenario: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    protocol: Option<String>,
    temperature: Option<f64>,
    max_tokens: Option<u32>,
    effort: Option<String>,
    #[serde(default, skip_serializing_if = "is_default")]
    log_probabilities: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tools: Option<ToolLimits>,
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
    #[serde(default, skip_serializing_if = "is_default")]
    comparison: Comparison,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    form: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stride: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    road: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ego_axes: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    measures: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pack: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    #[serde(default, skip_serializing_if = "is_default")]
    axes: WrittenAxes,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    select: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    split: Option<Split>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    drawn_from: Vec<String>,
}

/// Settings in several values.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct WrittenAxes {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    form: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    stride: Vec<usize>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    effort: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    temperature: Vec<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    seed: Vec<u64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tools: Vec<bool>,
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
            TruthSource::Score(convention) => (TruthSource::word_of_score(*convention), Vec::new()),
            TruthSource::Files(files) => ("files", files.clone()),
        };
        let written = Written {
            title: self.title.clone(),
            paths: self.paths.clone(),
            tasks: words(&matrix.tasks, |task| task.name()),
            frames: words(&matrix.frames, |frame| frame.name()),
            techniques: words(&matrix.techniques, ToString::to_string),
            models: matrix.models.clone(),
            samples: matrix.samples,
            history: request.history,
            radius: request.radius,
            lead: request.lead.map(Lead::stored),
            within: request.within,
            every_scenario: request.every_scenario,
            protocol: (request.protocol != Protocol::default())
                .then(|| request.protocol.name().to_string()),
            temperature: request.temperature,
            max_tokens: request.max_tokens,
            effort: request.effort.map(|effort| effort.name().to_string()),
            log_probabilities: request.log_probabilities,
            tools: request.tools,
            more_leads: words(&matrix.more_leads, |lead| lead.stored()),
            transforms: words(&matrix.transforms, ToString::to_string),
            truth: truth.into(),
            truth_files,
            templates: self.templates.clone(),
            thresholds: self.thresholds.clone(),
            base_url: self.base_url.clone(),
            ego: self.ego.clone(),
            drafts: self.drafts.clone(),
            comparison: self.comparison.clone(),
            form: request.form.map(|form| form.name().to_string()),
            stride: request.stride,
            road: request.road,
            ego_axes: request.axes.map(|axes| axes.name().to_string()),
            measures: request.measures.map(|measures| measures.to_string()),
            pack: (request.pack != Pack::default()).then(|| request.pack.name().to_string()),
            seed: request.seed,
            axes: WrittenAxes {
                form: words(&matrix.axes.forms, |form| form.name()),
                stride: matrix.axes.strides.clone(),
                effort: words(&matrix.axes.efforts, |effort| effort.name()),
                temperature: matrix.axes.temperatures.clone(),
                seed: matrix.axes.seeds.clone(),
                tools: matrix.axes.tools.clone(),
            },
            select: self.subset.select.clone(),
            split: self.subset.split,
            drawn_from: self.drawn_from.clone(),
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
        let form = written.form.map(|word| known(&word, Form::parse));
        let ego_axes = written.ego_axes.map(|word| known(&word, EgoAxes::parse));
        let measures = written
            .measures
            .map(|word| known(&word, |w| MeasureList::parse(w).ok()));
        let pack = written.pack.map(|word| known(&word, Pack::parse));
        let lead = written.lead.map(|word| known(&word, |w| w.parse().ok()));
        let matrix = Matrix {
            tasks: each(&written.tasks, Task::parse)?,
            frames: each(&written.frames, Frame::parse)?,
            techniques: each(&written.techniques, |w| Techniques::parse(w).ok())?,
            models: written.models,
            samples: written.samples,
            more_leads: each(&written.more_leads, |w| w.parse().ok())?,
            transforms: each(&written.transforms, |w| w.parse().ok())?,
            axes: Axes {
                forms: each(&written.axes.form, Form::parse)?,
                strides: written.axes.stride,
                efforts: each(&written.axes.effort, Effort::parse)?,
                temperatures: written.axes.temperature,
                seeds: written.axes.seed,
                tools: written.axes.tools,
            },
            request: RequestSettings {
                history: written.history,
                radius: written.radius,
                lead: lead.transpose()?,
                within: written.within,
                every_scenario: written.every_scenario,
                protocol: match written.protocol.as_deref() {
                    None => Protocol::default(),
                    Some(word) => Protocol::parse(word).ok_or_else(|| unknown(word))?,
                },
                temperature: written.temperature,
                max_tokens: written.max_tokens,
                effort: effort.transpose()?,
                log_probabilities: written.log_probabilities,
                tools: written.tools,
                form: form.transpose()?,
                stride: written.stride,
                road: written.road,
                axes: ego_axes.transpose()?,
                measures: measures.transpose()?,
                pack: pack.transpose()?.unwrap_or_default(),
                seed: written.seed,
            },
        };
        let truth = match written.truth.as_str() {
            "geometry" => TruthSource::Geometry,
            "layout" => TruthSource::Layout,
            "files" => TruthSource::Files(written.truth_files),
            other => match TruthSource::score(other) {
                Some(convention) => TruthSource::Score(convention),
                None => return Err(unknown(other)),
            },
        };
        Ok(Self {
            title: written.title,
            paths: written.paths,
            matrix,
            truth,
            templates: written.templates,
            thresholds: written.thresholds,
            base_url: written.base_url,
            ego: written.ego,
            drafts: written.drafts,
            comparison: written.comparison,
            subset: Subset {
                select: written.select,
                split: written.split,
            },
            drawn_from: written.drawn_from,
        })
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
