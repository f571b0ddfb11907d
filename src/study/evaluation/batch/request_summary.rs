//! Describes how a batch was asked, for reports.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Value, json};

use super::experiment::Experiment;
use super::spec::Spec;
use crate::evaluation::{Protocol, default_frame, template};
use nearmiss_ask::prompts::{Library, Techniques};
use nearmiss_formats::PlannerDrives;
use nearmiss_record::fields::Fields;

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
        if Self::templates_of(&self.experiment, library) != self.templates {
            return None;
        }
        let mut described = SceneDescriptions::default();
        for way in self.experiment.ways() {
            let frame = way
                .frame
                .unwrap_or_else(|| default_frame(library, way.task));
            let techniques = way.techniques.unwrap_or(Techniques::ALL);
            let (_, chosen) = template(library, way.task, frame).ok()?;
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
    fn windows_words(&self) -> String {
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
    pub fn asked_words(&self, described: Option<&SceneDescriptions>) -> String {
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
            Some(self.windows_words()),
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
