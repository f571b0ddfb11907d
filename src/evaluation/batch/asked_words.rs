//! How a batch was asked, in words for a report.

use serde_json::Value;

use super::spec::Spec;

impl Spec {
    /// The same as JSON, as the store has it: paths, ways of asking, window, sampling, templates and thresholds. The address
    /// of the server is left out, which may hold a key.
    #[must_use]
    pub fn asked(&self) -> Value {
        // What was written is an object.
        let mut asked: Value = serde_json::from_str(&self.to_json()).unwrap_or_default();
        if let Some(asked) = asked.as_object_mut() {
            for elsewhere in ["base_url", "truth", "truth_files"] {
                asked.shift_remove(elsewhere);
            }
        }
        asked
    }

    /// What a reader of the table has to know to repeat it: window, sampling, templates.
    #[must_use]
    pub fn asked_words(&self) -> String {
        let manner = &self.matrix.manner;
        let usual = |value: Option<String>, else_: &str| value.unwrap_or_else(|| else_.into());
        let lead = manner.lead.map(|lead| lead.to_string());
        let parts = [
            format!(
                "window of {} steps",
                usual(
                    manner.history.map(|n| n.to_string()),
                    "the templates' number of"
                )
            ),
            format!(
                "radius {}",
                usual(manner.radius.map(|m| format!("{m} m")), "of the templates")
            ),
            format!("lead {}", usual(lead, "as in the paper")),
            format!(
                "temperature {}",
                usual(
                    manner.temperature.map(|t| t.to_string()),
                    "of the templates or the server"
                )
            ),
            format!(
                "answers of {}",
                usual(
                    manner.max_tokens.map(|n| format!("at most {n} tokens")),
                    "as many tokens as the server allows"
                )
            ),
            format!(
                "reasoning {}",
                usual(
                    manner.effort.map(|e| e.name().to_string()),
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
