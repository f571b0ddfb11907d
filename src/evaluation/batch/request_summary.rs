//! Describes how a batch was asked, for reports.

use serde::Serialize;
use serde_json::{Value, json};

use super::spec::Spec;
use crate::evaluation::{default_frame, template};
use crate::prompts::{Library, Techniques};

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

    /// The same as JSON, as the store has it: paths, ways of asking, window, sampling, templates and thresholds. The
    /// address of the server is left out, which may hold a key. `history` and `radius` are numbers also where the
    /// templates decide them, as far as they are known: a list where they differ, and `of_templates` names those that
    /// are not the batch's.
    #[must_use]
    pub fn asked(&self, described: Option<&SceneDescriptions>) -> Value {
        // A serialised struct is an object.
        let mut asked: Value = serde_json::from_str(&self.to_json()).unwrap_or_default();
        if let Some(asked) = asked.as_object_mut() {
            for elsewhere in ["base_url", "truth", "truth_files"] {
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

    /// Settings a reader needs to reproduce the table: window, sampling, templates.
    #[must_use]
    pub fn asked_words(&self, described: Option<&SceneDescriptions>) -> String {
        let request = &self.matrix.request;
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
        let lead = request.lead.map(|lead| lead.to_string());
        let parts = [
            format!(
                "steps in a window {}",
                usual(history, "as the templates had it, which are others now")
            ),
            format!(
                "radius in metres {}",
                usual(radius, "as the templates had it, which are others now")
            ),
            format!("lead {}", usual(lead, "as in the paper")),
            format!(
                "temperature {}",
                usual(
                    request.temperature.map(|t| t.to_string()),
                    "of the templates or the server"
                )
            ),
            format!(
                "answers of {}",
                usual(
                    request.max_tokens.map(|n| format!("at most {n} tokens")),
                    "as many tokens as the server allows"
                )
            ),
            format!(
                "reasoning {}",
                usual(
                    request.effort.map(|e| e.name().to_string()),
                    "as the server does it"
                )
            ),
            format!("samples {}", self.matrix.samples),
        ];
        let templates = self.templates.iter().map(|(file, hash)| {
            let short: String = hash.chars().take(12).collect();
            format!("{file} ({short})")
        });
        let templates: Vec<String> = templates.collect();
        format!(
            "Asked with: {}. Templates, with the beginnings of their hashes: {}. nearmiss {}.",
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

/// `10 (of the templates)`, with a word between several.
fn joined<T: ToString>(values: &[T], of_templates: bool) -> Option<String> {
    let all: Vec<String> = values.iter().map(T::to_string).collect();
    let words = all.join(" or ");
    (!all.is_empty()).then(|| match of_templates {
        true => format!("{words} (of the templates)"),
        false => words,
    })
}
