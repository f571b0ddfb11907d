//! The answer of `ask` as one JSON line; with `--dry-run` what the question would take, and nothing is sent.

use nearmiss_study::evaluation::batch::{Price, Size};
use nearmiss_study::evaluation::{Judge, Question};
use schemars::JsonSchema;
use serde::Serialize;

use super::CostLimit;
use crate::{Failure, Outcome, output};

/// What a question would take.
#[derive(Serialize, JsonSchema)]
pub struct AskDryRun<'a> {
    model: &'a str,
    /// The prompt template with its version.
    template: Option<String>,
    /// Estimated tokens of the question.
    input_tokens: u64,
    most_usd: Option<f64>,
    /// The price in words.
    price: String,
    /// Why a budget forbids the question; null if it does not.
    forbidden: Option<String>,
}

/// Says how long the question is, what it costs at most, and what a budget makes of that.
pub fn dry_run(
    question: &Question,
    judge: &Judge,
    bound: Option<&CostLimit>,
    as_json: bool,
) -> Outcome {
    let size = Size::estimate(question, judge);
    let forbidden = bound.and_then(|bound| forbidden(&size.price, bound.usd));
    let (words, usd) = match size.price {
        Price::Free => ("free: the built-in judge".to_string(), Some(0.0)),
        Price::AtMost(0.0) if is_here(judge) => {
            ("free: a server on this machine".into(), Some(0.0))
        }
        Price::AtMost(usd) => (format!("at most ${usd:.4}"), Some(usd)),
        Price::Question { usd, million } => (
            format!(
                "${usd:.4} and the answer, ${million:.2} per 1M tokens; --set max_tokens=N bounds it"
            ),
            None,
        ),
        Price::Unknown => (
            "unknown; [[provider.NAME.prices]] in config.toml states a price".into(),
            None,
        ),
    };
    let template = question.version().map(|version| version.to_string());
    if as_json {
        let document = AskDryRun {
            model: judge.id(),
            template,
            input_tokens: size.tokens,
            most_usd: usd,
            price: words,
            forbidden,
        };
        return output::document(&document).and(refusal(document.forbidden));
    }
    let mut rows = vec![
        ("model", judge.id().to_string()),
        ("how", question.label(judge.calls_tools())),
        ("template", template.unwrap_or_default()),
        ("tokens", format!("about {}", size.tokens)),
        ("price", words),
    ];
    rows.extend(size.bound.map(|bound| ("counted", bound)));
    let lines = rows
        .iter()
        .map(|(name, value)| format!("{name:<9} {}\n", output::visible(value)));
    output::text(&lines.collect::<String>()).and(refusal(forbidden))
}

/// Why a budget of so many US dollars would not let the question be asked.
fn forbidden(price: &Price, budget: f64) -> Option<String> {
    match price {
        Price::Free => None,
        Price::AtMost(usd) => (*usd > budget)
            .then(|| format!("it may cost ${usd:.4}, more than the budget of ${budget:.4}")),
        Price::Question { .. } => {
            Some("a budget needs a limit of the answer's tokens: --set max_tokens=N".into())
        }
        Price::Unknown => Some("a budget needs a price, and none is known".into()),
    }
}

fn refusal(forbidden: Option<String>) -> Outcome {
    forbidden.map_or(Ok(()), |why| {
        Err(Failure::input(format!("would not be asked: {why}")))
    })
}

/// Whether the model runs on this machine.
fn is_here(judge: &Judge) -> bool {
    match judge {
        Judge::Reference | Judge::Recorded(_) => true,
        Judge::Model(model) => model.endpoint.is_here(),
    }
}
