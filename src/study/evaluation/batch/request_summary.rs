//! Describes how a batch was asked, for reports.

use serde::Serialize;
use serde_json::{Value, json};

use super::spec::Spec;
use crate::evaluation::{Protocol, default_frame, template};
use nearmiss_ask::prompts::{Library, Pack, Techniques};
use nearmiss_formats::PlannerDrives;

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
        if Self::templates_of(&self.matrix, library) != self.templates {
            return None;
        }
        let mut described = SceneDescriptions::default();
        for way in self.matrix.ways() {
            let frame = way
                .frame
                .unwrap_or_else(|| default_frame(library, way.task));
            let techniques = way.techniques.unwrap_or(Techniques::ALL);
            let (_, chosen) = template(library, way.task, frame).ok()?;
            let settings = self.matrix.request.settings(Some(techniques));
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

    /// The same as JSON: names of the paths, ways of asking, window, sampling, templates and thresholds. The
    /// address of the server, which may hold a key, and texts of drafts are left out. `history` and `radius` are numbers also where the
    /// templates decide them, as far as they are known: a list where they differ, and `of_templates` names those that
    /// are not the batch's.
    #[must_use]
    pub fn asked(&self, described: Option<&SceneDescriptions>) -> Value {
        // A serialised struct is an object.
        let mut asked: Value = serde_json::from_str(&self.portable().to_json()).unwrap_or_default();
        if let Some(asked) = asked.as_object_mut() {
            for elsewhere in ["base_url", "truth", "truth_files", "drafts"] {
                asked.shift_remove(elsewhere);
            }
            if let Some(described) = described {
                let request = &self.matrix.request;
                let found = [
                    (
                        "history",
                        request.history.is_none(),
                        one_or_all(&described.history),
                    ),
                    (
                        "radius",
                        request.radius.is_none(),
                        one_or_all(&described.radius),
                    ),
                ];
                let mut of_templates = Vec::new();
                for (name, of_template, value) in found {
                    if of_template {
                        asked.insert(name.into(), value);
                        of_templates.push(name);
                    }
                }
                asked.insert("of_templates".into(), json!(of_templates));
            }
        }
        asked
    }

    /// How the windows of the questions were chosen.
    fn windows_words(&self) -> String {
        let request = &self.matrix.request;
        if request.protocol == Protocol::Paper {
            return "windows of the paper, a yes of the safety task counts if it names the obstacle of the collision"
                .into();
        }
        let matched = if request.every_scenario {
            "matched windows and one of every other safe scenario"
        } else {
            "matched windows"
        };
        match (request.within, request.lead) {
            (Some(horizon), Some(lead)) => {
                format!("{matched}, lead {lead}, contact within {horizon} s")
            }
            (Some(_), None) => matched.into(),
            (None, Some(lead)) => format!("lead {lead}, safe windows first in their recordings"),
            (None, None) => "windows at the end of the recordings".into(),
        }
    }

    /// Settings a reader needs to reproduce the table: window, sampling, templates.
    #[must_use]
    pub fn asked_words(&self, described: Option<&SceneDescriptions>) -> String {
        let (request, axes) = (&self.matrix.request, &self.matrix.axes);
        let usual = |value: Option<String>, else_: &str| value.unwrap_or_else(|| else_.into());
        let (history, radius) = match described {
            Some(described) => (
                joined(&described.history, request.history.is_none()),
                joined(&described.radius, request.radius.is_none()),
            ),
            None => (
                request.history.map(|n| n.to_string()),
                request.radius.map(|m| m.to_string()),
            ),
        };
        let parts = [
            format!(
                "steps in a window {}",
                usual(history, "from the templates, which have changed since")
            ),
            format!(
                "radius in metres {}",
                usual(radius, "from the templates, which have changed since")
            ),
            self.windows_words(),
            format!(
                "temperature {}",
                usual(
                    one_or_each(request.temperature, &axes.temperatures, f64::to_string),
                    "from the templates or the server"
                )
            ),
            format!(
                "answers of {}",
                usual(
                    request.max_tokens.map(|n| format!("at most {n} tokens")),
                    "unlimited tokens"
                )
            ),
            format!(
                "reasoning {}",
                usual(
                    one_or_each(request.effort, &axes.efforts, |effort| effort.name().into()),
                    "server default"
                )
            ),
            format!("samples {}", self.matrix.samples),
        ];
        let egos = self.ego.planner().map(PlannerDrives::words);
        let more = [
            ("egos", egos),
            (
                "form",
                one_or_each(request.form, &axes.forms, |form| form.name().into()),
            ),
            (
                "stride",
                one_or_each(request.stride, &axes.strides, usize::to_string),
            ),
            (
                "road",
                request
                    .road
                    .map(|road| if road { "yes" } else { "no" }.into()),
            ),
            ("axes", request.axes.map(|axes| axes.name().into())),
            ("measures", request.measures.map(|all| all.ids().join(" "))),
            (
                "pack",
                (request.pack != Pack::default()).then(|| request.pack.name().into()),
            ),
            (
                "seed",
                one_or_each(request.seed, &axes.seeds, u64::to_string),
            ),
        ]
        .into_iter()
        .filter_map(|(name, value)| Some(format!("{name} {}", value?)));
        let parts: Vec<String> = parts.into_iter().chain(more).collect();
        let templates = self.templates.iter().map(|(file, hash)| {
            let short: String = hash.chars().take(12).collect();
            format!("{file} ({short})")
        });
        let templates: Vec<String> = templates.collect();
        format!(
            "Settings: {}. Templates, with the start of their hashes: {}. nearmiss {}.",
            parts.join(", "),
            templates.join(", "),
            env!("CARGO_PKG_VERSION")
        )
    }
}

/// The value of a setting in words, or those of its axis; `None` where the batch does not say it.
fn one_or_each<T>(one: Option<T>, each: &[T], word: impl Fn(&T) -> String) -> Option<String> {
    let all: Vec<String> = one.iter().chain(each).map(word).collect();
    (!all.is_empty()).then(|| all.join(" or "))
}

/// A number, or a list of several.
fn one_or_all<T: Serialize>(values: &[T]) -> Value {
    match values {
        [one] => json!(one),
        all => json!(all),
    }
}

/// `10 (from the templates)`, with a word between several.
fn joined<T: ToString>(values: &[T], of_templates: bool) -> Option<String> {
    let all: Vec<String> = values.iter().map(T::to_string).collect();
    let words = all.join(" or ");
    (!all.is_empty()).then(|| {
        if of_templates {
            format!("{words} (from the templates)")
        } else {
            words
        }
    })
}
