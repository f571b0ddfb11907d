//! When answers were asked and whom: what captions of papers say.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::evaluation::AnswerCase;
use nearmiss_ask::llm::Parameters;
use nearmiss_store::{RunId, RunOrigin};

/// When and whom a table's answers were asked, and with which parameters.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AskedFacts {
    /// Parameters that were sent, by run.
    pub(super) parameters: HashMap<RunId, Parameters>,
    /// When the first and the last answer was asked, milliseconds since 1970, UTC.
    pub asked_ms: Option<(i64, i64)>,
    /// The names that servers returned, by the model asked for.
    pub returned: BTreeMap<String, BTreeSet<String>>,
}

impl AskedFacts {
    /// Of these answers, as far as the store knows their runs.
    #[must_use]
    pub fn new(cases: &[AnswerCase<'_>], runs: &[RunOrigin]) -> Self {
        let runs: HashMap<RunId, &RunOrigin> = runs.iter().map(|one| (one.run, one)).collect();
        let mut facts = Self::default();
        for case in cases {
            let Some((id, run)) = case.scored.run.and_then(|id| Some((id, runs.get(&id)?))) else {
                continue;
            };
            // Without a prompt nothing was sent.
            if case.scored.way.frame.is_some()
                && let Ok(sent) = serde_json::from_str(&run.parameters)
            {
                facts.parameters.insert(id, sent);
            }
            let (first, last) = facts.asked_ms.unwrap_or((run.created_ms, run.created_ms));
            facts.asked_ms = Some((first.min(run.created_ms), last.max(run.created_ms)));
            if let Some(name) = &run.model_returned {
                let names = facts.returned.entry(case.scored.way.model.clone());
                names.or_default().insert(name.clone());
            }
        }
        facts
    }

    /// In words: `asked 2026-11-23 to 2026-11-24; models as returned: …`; `None` where nothing is known.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        let day = |ms| {
            let time = jiff::Timestamp::from_millisecond(ms).ok()?;
            Some(time.strftime("%Y-%m-%d").to_string())
        };
        let mut parts = Vec::new();
        if let Some((first, last)) = self.asked_ms.and_then(|(a, b)| Some((day(a)?, day(b)?))) {
            parts.push(if first == last {
                format!("asked {first}")
            } else {
                format!("asked {first} to {last}")
            });
        }
        let models = self.returned.iter().map(|(model, names)| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            format!("{} ({model})", names.join(", "))
        });
        let models: Vec<String> = models.collect();
        if !models.is_empty() {
            parts.push(format!("models as returned: {}", models.join("; ")));
        }
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}
