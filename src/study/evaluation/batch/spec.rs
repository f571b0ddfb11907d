//! The stored specification of a batch: enough to resume it or to detect changes; without folders, and for reports.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_ask::prompts::{Library, Origin, Techniques};
use nearmiss_formats::{EgoSelection, Entry, EntryLocation, PlannerDrives};
use nearmiss_record::fields::Fields;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::experiment::Experiment;
use super::question_builder::QuestionBuilder;
use super::truth::TruthSource;
use crate::evaluation::{Protocol, default_frame, template};

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
    pub fn truth_summary(&self) -> String {
        let tasks = &self.experiment.tasks;
        if matches!(tasks[..], [Task::Recording]) {
            return self.truth().recordings_summary();
        }
        let words = self.windowed_truth_summary();
        let more = if tasks.contains(&Task::Recording) {
            format!(
                "; of recordings as a whole, {}",
                self.truth().recordings_summary()
            )
        } else {
            String::new()
        };
        format!("{words}{more}")
    }

    fn windowed_truth_summary(&self) -> String {
        let words = self.truth().summary();
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
    pub fn templates_for(experiment: &Experiment, library: &Library) -> BTreeMap<String, String> {
        let library = &library.clone().with_pack(experiment.pack);
        let mut found = BTreeMap::new();
        let configurations = experiment.configurations();
        let asked = configurations
            .iter()
            .map(|configuration| (configuration.task, configuration.frame));
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
    pub fn threshold_changes(thresholds: &Thresholds) -> Vec<String> {
        thresholds
            .changes()
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// The templates that the batch is asked with: those of its files, whatever is in use by now, and its drafts in their places.
    ///
    /// # Errors
    /// A draft is no template.
    pub fn library(&self, library: &Library) -> Result<Library, SpecError> {
        let mut library = library.clone().with_pack(self.experiment.pack);
        for file in self.templates.keys() {
            library.use_file(file);
        }
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
        self.ensure_unchanged(library, &thresholds)?;
        self.builder(library, thresholds)
    }

    /// Whether templates and thresholds are still those of the batch.
    ///
    /// # Errors
    /// Which are not.
    pub fn ensure_unchanged(
        &self,
        library: &Library,
        thresholds: &Thresholds,
    ) -> Result<(), SpecError> {
        let library = self.library(library)?;
        let now = Self::templates_for(&self.experiment, &library);
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
        if Self::threshold_changes(thresholds) != self.thresholds {
            let why = "thresholds.toml has changed since the batch started";
            return Err(SpecError::Changed(why.into()));
        }
        Ok(())
    }
}

impl Spec {
    /// As JSON, the same for the same spec.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Strings, numbers and lists can always be written.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// From what [`Spec::to_json`] wrote, and from what was written before experiments and batches had the same keys.
    ///
    /// # Errors
    /// It is not of this form.
    pub fn from_json(json: &str) -> Result<Self, SpecError> {
        let unreadable = |error: serde_json::Error| SpecError::Unreadable(error.to_string());
        let mut spec: Map<String, Value> = serde_json::from_str(json).map_err(unreadable)?;
        if spec.contains_key("paths") {
            spec = with_keys_of_experiments(spec);
        }
        serde_json::from_value(Value::Object(spec)).map_err(unreadable)
    }
}

/// A specification whose keys were its own, with those of experiments.
fn with_keys_of_experiments(old: Map<String, Value>) -> Map<String, Value> {
    let mut spec = Map::new();
    let (mut leads, mut truth) = (Vec::new(), Vec::new());
    for (key, value) in old.into_iter().filter(|(_, value)| !value.is_null()) {
        match (key.as_str(), value) {
            ("paths", paths) => drop(spec.insert("scenarios".into(), paths)),
            ("lead", first) => leads.insert(0, first),
            ("more_leads", Value::Array(more)) => leads.extend(more),
            ("ego_axes", axes) => drop(spec.insert("axes".into(), axes)),
            ("measures", Value::String(ids)) => {
                let ids = ids.split([',', ' ']).filter(|id| !id.is_empty());
                spec.insert(key, ids.collect());
            }
            ("tools", Value::Object(limits)) => {
                spec.entry("tools").or_insert(true.into());
                spec.extend(
                    limits
                        .into_iter()
                        .map(|(key, most)| (format!("tool_{key}"), most)),
                );
            }
            ("axes", Value::Object(several)) => spec.extend(several),
            ("comparison", Value::Object(mut declared)) => {
                let primary = declared.shift_remove("primary");
                spec.extend(primary.map(|pair| ("compare".into(), pair)));
                spec.extend(declared);
            }
            ("truth", Value::String(word)) => truth.push(Value::String(match word.as_str() {
                "geometry" => "auto".into(),
                "files" => continue,
                other => other.into(),
            })),
            ("truth_files", Value::Array(files)) => truth.extend(files),
            (_, value) => drop(spec.insert(key, value)),
        }
    }
    spec.extend((!leads.is_empty()).then(|| ("leads".into(), leads.into())));
    spec.insert("truth".into(), truth.into());
    spec
}

/// Stands for a folder without a name, such as `/`.
const NAMELESS: &str = "scenarios";

impl Spec {
    /// The same with names in the place of paths, each once, and without user, password and query in its address. The
    /// portable form of a portable spec is itself.
    #[must_use]
    pub fn portable(&self) -> Self {
        Self {
            experiment: Experiment {
                scenarios: names(&self.experiment.scenarios),
                truth: self.experiment.truth.as_ref().map(|truth| match truth {
                    TruthSource::Files(files) => TruthSource::Files(names(files)),
                    other => other.clone(),
                }),
                base_url: self.experiment.base_url.as_deref().map(plain_address),
                ..self.experiment.clone()
            },
            ego: match &self.ego {
                EgoSelection::File {
                    path,
                    planning_problem,
                } => EgoSelection::File {
                    path: names(std::slice::from_ref(path)).remove(0),
                    planning_problem: *planning_problem,
                },
                EgoSelection::Planner(drives) => EgoSelection::Planner(drives.portable()),
                other => other.clone(),
            },
            drawn_from: { self.drawn_from.iter() }
                .map(|path| self.portable_path(path))
                .collect(),
            ..self.clone()
        }
    }

    /// The path of a question's scenario under the names of [`Self::portable`]; the name of a bundled one as it is.
    #[must_use]
    pub fn portable_path(&self, path: &str) -> String {
        let path = Path::new(path);
        if matches!(Entry::of_argument(path).place, EntryLocation::Bundled(_)) {
            return path.display().to_string();
        }
        let named = names(&self.experiment.scenarios);
        let mut below: Vec<(usize, PathBuf)> = Vec::new();
        for (root, name) in self.experiment.scenarios.iter().zip(named) {
            if let Ok(rest) = path.strip_prefix(root) {
                let whole = if rest.as_os_str().is_empty() {
                    name
                } else {
                    name.join(rest)
                };
                below.push((root.components().count(), whole));
            }
        }
        let nearest = below.into_iter().max_by_key(|(depth, _)| *depth);
        let found = nearest.map_or_else(|| file_name(path), |(_, whole)| whole);
        found.display().to_string().replace('\\', "/")
    }
}

/// The last part of a path.
fn file_name(path: &Path) -> PathBuf {
    path.file_name().unwrap_or(NAMELESS.as_ref()).into()
}

/// The last parts of paths; where two are alike, the second one has a number.
fn names(paths: &[PathBuf]) -> Vec<PathBuf> {
    let mut taken = BTreeSet::new();
    let each = paths.iter().map(|path| {
        let name = file_name(path);
        let mut unique = name.clone();
        let mut number = 2;
        while !taken.insert(unique.clone()) {
            unique = numbered(&name, number);
            number += 1;
        }
        unique
    });
    each.collect()
}

/// `labels.csv` as `labels-2.csv`.
pub fn numbered(name: &Path, number: usize) -> PathBuf {
    let stem = name.file_stem().unwrap_or_default().to_string_lossy();
    match name.extension() {
        Some(end) => name.with_file_name(format!("{stem}-{number}.{}", end.to_string_lossy())),
        None => name.with_file_name(format!("{stem}-{number}")),
    }
}

/// An address without user, password, query and fragment, which may hold secrets.
fn plain_address(url: &str) -> String {
    let url = url.split(['?', '#']).next().unwrap_or_default();
    let (scheme, rest) = url.split_once("://").unwrap_or(("", url));
    let (place, path) = rest
        .split_once('/')
        .map_or((rest, None), |(a, b)| (a, Some(b)));
    let host = place.rsplit('@').next().unwrap_or_default();
    let scheme = if scheme.is_empty() {
        String::new()
    } else {
        format!("{scheme}://")
    };
    match path {
        Some(path) => format!("{scheme}{host}/{path}"),
        None => format!("{scheme}{host}"),
    }
}

/// The scene descriptions of a batch, completed from its templates: each number once, in order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SceneDescriptions {
    /// Steps in a window.
    pub history: Vec<usize>,
    /// Obstacles farther from the ego are left out, metres.
    pub radius: Vec<f64>,
}

impl Spec {
    /// What its ways describe; `None` if the library no longer has the templates that the batch was begun with.
    #[must_use]
    pub fn described(&self, library: &Library) -> Option<SceneDescriptions> {
        let library = &self.library(library).ok()?;
        if Self::templates_for(&self.experiment, library) != self.templates {
            return None;
        }
        let mut described = SceneDescriptions::default();
        for configuration in self.experiment.configurations() {
            let frame = configuration
                .frame
                .unwrap_or_else(|| default_frame(library, configuration.task));
            let techniques = configuration.techniques.unwrap_or(Techniques::ALL);
            let (_, chosen) = template(library, configuration.task, frame).ok()?;
            let settings = self.experiment.settings(Some(techniques));
            let decided = settings.with(&chosen.front.defaults);
            described.history.push(decided.history);
            described.radius.push(decided.options.radius);
        }
        described.history.sort_unstable();
        described.history.dedup();
        described.radius.sort_by(f64::total_cmp);
        described.radius.dedup();
        Some(described)
    }

    /// The same as JSON, with the keys of experiments: names of the paths, what is asked and how, templates and
    /// thresholds. The address of the server, which may hold a key, and texts of drafts are left out. `history` and `radius`
    /// are numbers also where the templates decide them, as far as they are known: a list where they differ, and
    /// `of_templates` names those that are not the batch's.
    #[must_use]
    pub fn asked(&self, described: Option<&SceneDescriptions>) -> Value {
        let asked = Self {
            drafts: BTreeMap::new(),
            experiment: Experiment {
                base_url: None,
                truth: None,
                ..self.portable().experiment
            },
            ..self.portable()
        };
        let mut asked = serde_json::to_value(asked).unwrap_or_default();
        if let (Some(asked), Some(described)) = (asked.as_object_mut(), described) {
            let found = [
                ("history", one_or_all(&described.history)),
                ("radius", one_or_all(&described.radius)),
            ];
            let mut of_templates = Vec::new();
            for (name, value) in found {
                if !asked.contains_key(name) {
                    asked.insert(name.into(), value);
                    of_templates.push(name);
                }
            }
            asked.insert("of_templates".into(), json!(of_templates));
        }
        asked
    }

    /// How the windows of the questions were chosen.
    fn windows_summary(&self) -> String {
        let experiment = &self.experiment;
        if experiment.protocol == Protocol::Paper {
            return "windows of the paper, a yes of the safety task counts if it names the obstacle of the collision"
                .into();
        }
        let matched = if experiment.every_scenario {
            "matched windows and one of every other safe scenario"
        } else {
            "matched windows"
        };
        match (experiment.within, experiment.lead()) {
            (Some(horizon), Some(lead)) => {
                format!("{matched}, lead {lead}, contact within {horizon} s")
            }
            (Some(_), None) => matched.into(),
            (None, Some(lead)) => format!("lead {lead}, safe windows first in their recordings"),
            (None, None) => "windows at the end of the recordings".into(),
        }
    }

    /// Settings a reader needs to reproduce the table: window, description, sampling, templates.
    #[must_use]
    pub fn request_summary(&self, described: Option<&SceneDescriptions>) -> String {
        let decided = |key: &str| {
            let values = match (key, described?) {
                ("history", known) => joined(&known.history),
                ("radius", known) => joined(&known.radius),
                _ => return None,
            };
            Some(format!("{key} {values} (from the templates)"))
        };
        let rows = Experiment::rows().iter().filter(|row| match row.section {
            "windows" => row.key == "history",
            section => ["description", "sampling"].contains(&section),
        });
        let said = rows.filter_map(|row| match self.experiment.text(row.key) {
            Some(value) => Some(format!("{} {}", row.key, value.replace(", ", " or "))),
            None => decided(row.key),
        });
        let egos = self.ego.planner().map(PlannerDrives::text);
        let parts = [
            Some(self.windows_summary()),
            Some(format!("samples {}", self.experiment.samples())),
            egos.map(|egos| format!("egos {egos}")),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().chain(said).collect();
        let templates = self.templates.iter().map(|(file, hash)| {
            let short: String = hash.chars().take(12).collect();
            format!("{file} ({short})")
        });
        let templates: Vec<String> = templates.collect();
        format!(
            "Settings: {}; all else as templates and servers have it. Templates, with the start of their hashes: {}. nearmiss {}.",
            parts.join(", "),
            templates.join(", "),
            env!("CARGO_PKG_VERSION")
        )
    }
}

/// A number, or a list of several.
fn one_or_all<T: Serialize>(values: &[T]) -> Value {
    match values {
        [one] => json!(one),
        all => json!(all),
    }
}

/// Numbers, with a word between several.
fn joined<T: ToString>(values: &[T]) -> String {
    let all: Vec<String> = values.iter().map(T::to_string).collect();
    all.join(" or ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_apart_and_stay_when_named_again() {
        let paths = ["/a/rec", "/b/rec", "/c/x.xml", "/d/x.xml", "/"].map(PathBuf::from);
        let told = names(&paths);
        let wanted = ["rec", "rec-2", "x.xml", "x-2.xml", "scenarios"].map(PathBuf::from);
        assert_eq!(told, wanted);
        assert_eq!(names(&told), wanted);
    }

    #[test]
    fn addresses_lose_what_may_be_secret() {
        for (url, plain) in [
            ("https://ada:secret@host:1/v1?key=k#f", "https://host:1/v1"),
            ("http://localhost:8080/v1", "http://localhost:8080/v1"),
            ("ada@host/v1", "host/v1"),
        ] {
            assert_eq!(plain_address(url), plain);
        }
    }
}
