//! A dry run in words: what would be asked and what it costs, for command line and workbench alike.

use super::DryRun;
use nearmiss_store::SplitPart;
use nearmiss_study::evaluation::batch::Estimate;

/// A line of a dry run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DryRunLine {
    /// A name with its value.
    Value(&'static str, String),
    /// A further line of the value above.
    Note(&'static str),
    /// Why questions cannot be asked.
    Reason(String),
}

/// What the price of a dry run counts.
const COUNTED: &str = "(tokens at the highest price of input, cache writes included, and max_tokens at that of output for each \
                       request; answers are mostly shorter; retries after errors are not included)";

impl DryRun {
    /// The questions and what they take. `refused` are the models that cannot be asked, and why; `budget` is the most
    /// that a run may cost, US dollars.
    #[must_use]
    pub fn lines(&self, refused: &[(String, String)], budget: Option<f64>) -> Vec<DryRunLine> {
        use DryRunLine::{Note, Reason, Value};
        let estimate = &self.estimate;
        let mut lines = vec![
            Value("questions", estimate.questions().to_string()),
            Value("requests", estimate.requests.to_string()),
            Value("built-in judge", estimate.free.to_string()),
            Value("in the store", estimate.stored.to_string()),
            Value("cannot be asked", estimate.unaskable.to_string()),
        ];
        if estimate.repeated > 0 {
            let words = format!(
                "{} with the request of another, sent once",
                estimate.repeated
            );
            lines.insert(2, Value("repeated", words));
        }
        for part in [SplitPart::Dev, SplitPart::Test] {
            let (all, dangerous) = self.part(part);
            if all > 0 {
                let words = format!("{all} questions, {dangerous} about dangerous windows");
                lines.push(Value(part.name(), words));
            }
        }
        let reasons = estimate.why.iter();
        lines.extend(reasons.map(|(why, count)| Reason(format!("{count} × {why}"))));
        lines.push(Value(
            "tokens",
            format!("{} (estimated, without the answers)", estimate.tokens),
        ));
        lines.push(Value("price", estimate.price()));
        let bounds = estimate.bounds.iter();
        lines.extend(bounds.map(|bound| Value("counted", bound.clone())));
        if estimate.requests > estimate.unpriced {
            lines.push(Note(COUNTED));
        }
        if let Some(usd) = budget {
            let words = match is_enough(usd, estimate) {
                Some(true) => "enough for all",
                Some(false) => "too little: questions that could exceed it stay open",
                None => "may not be enough: some prices or limits are unknown",
            };
            lines.push(Value("budget", format!("{usd} USD, {words}")));
        }
        let refused = refused.iter();
        lines.extend(refused.map(|(model, why)| Value("refused", format!("{model}: {why}"))));
        lines
    }
}

/// Whether a budget, US dollars, is enough for everything; `None` if that cost is unknown.
#[must_use]
pub fn is_enough(usd: f64, estimate: &Estimate) -> Option<bool> {
    if estimate.usd > usd {
        Some(false)
    } else {
        estimate.most_usd().map(|_| true)
    }
}
