//! The answer of `ask` as one JSON line; with `--dry-run` what the question would take, and nothing is sent.

use nearmiss_ask::llm::ToolRound;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{ParsedAnswer, Task};
use nearmiss_store::{Origin, RunId};
use nearmiss_study::evaluation::batch::{Price, Size};
use nearmiss_study::evaluation::consumption::unknown;
use nearmiss_study::evaluation::{Answer, Case, Judge, JudgeOutcome, Question};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::CostLimit;
use crate::{Failure, Outcome, json, output};

/// The verdict, its cost and where it is stored; the same keys with or without a verdict.
#[derive(Serialize, JsonSchema)]
pub struct AskDocument<'a> {
    run: Option<RunId>,
    scenario: &'a str,
    task: &'static str,
    frame: &'static str,
    techniques: String,
    window: Option<(i64, i64)>,
    template: &'a str,
    template_hash: &'a str,
    model: &'a str,
    model_returned: Option<&'a str>,
    dangerous: Option<bool>,
    #[schemars(with = "Value")]
    verdict: Option<ParsedAnswer>,
    reading: Option<&'static str>,
    /// Repairs that reading the verdict took.
    repaired: &'a [String],
    /// What makes the verdict doubtful: contradictions, obstacles named twice or not in the scene.
    flags: Vec<String>,
    /// Why the answer ends early.
    cut_off: Option<String>,
    problem: Option<String>,
    answer: &'a str,
    reasoning: &'a str,
    input_tokens: Option<u64>,
    output_tokens: Option<u64>,
    reasoning_tokens: Option<u64>,
    cached_tokens: Option<u64>,
    cost_usd: Option<f64>,
    price_source: Option<String>,
    /// Why the cost is unknown.
    cost_unknown: Option<String>,
    /// Where a stored answer comes from.
    stored: Option<StoredAnswer<'a>>,
    /// Basis of a safety verdict of the built-in judge.
    prediction: Option<Prediction>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    #[schemars(with = "Value")]
    tool_rounds: &'a [ToolRound],
}

impl json::Output for AskDocument<'_> {
    const NAME: &'static str = "ask";
    const TITLE: &'static str = "`ask --format json`: one answer";
}

/// An answer that was in the store before it was asked for.
#[derive(Serialize, JsonSchema)]
struct StoredAnswer<'a> {
    /// Its run.
    run: RunId,
    /// When it was asked, RFC 3339.
    asked: String,
    /// The model that was asked, as provider/model.
    asked_as: &'a str,
    /// Where it comes from.
    origin: Origin,
    /// Number of the sample.
    sample: u32,
}

/// What the built-in judge's verdict on safety follows from.
#[derive(Serialize, JsonSchema)]
struct Prediction {
    /// Seconds after the window that count.
    horizon: f64,
    /// Probability of a contact from which on a window is critical.
    threshold: f64,
    /// First step of the window.
    first_step: i64,
    /// Last step of the window.
    last_step: i64,
    /// Obstacles that may touch the ego.
    obstacles: Vec<Contact>,
}

/// A contact that the built-in judge predicts.
#[derive(Serialize, JsonSchema)]
struct Contact {
    /// Id of the obstacle.
    id: i64,
    /// Its probability.
    probability: f64,
    /// Seconds from the end of the window; null without a contact.
    time: Option<f64>,
}

impl<'a> AskDocument<'a> {
    pub(super) fn new(answer: &'a Answer, question: &'a Question, judge: &Judge) -> Self {
        let case = &question.case;
        let (verdict, problem) = match &answer.judged {
            JudgeOutcome::Verdict(parsed) => {
                (Some(ParsedAnswer::Verdict(parsed.verdict.clone())), None)
            }
            JudgeOutcome::Other(reading) => (Some(reading.said.clone()), None),
            JudgeOutcome::Missing(missing) => (None, Some(super::missing_verdict(missing))),
        };
        let reading = match (&problem, answer.repairs().is_empty()) {
            (Some(_), _) => None,
            (None, true) => Some("strict"),
            (None, false) => Some("repaired"),
        };
        let consumed = answer.consumed;
        let (cost_usd, price_source) = match (
            consumed.cost_usd,
            super::cost_at_current_prices(answer, judge),
        ) {
            (Some(usd), _) => (Some(usd), answer.price_source.clone()),
            (None, _) if answer.model == judge::MODEL => (Some(0.0), Some("built in".into())),
            (None, Some((usd, how))) => (Some(usd), Some(how)),
            (None, None) => (None, None),
        };
        let returned = answer.model_returned.as_deref();
        Self {
            run: answer.run,
            scenario: &case.name,
            task: case.task.name(),
            frame: case.frame.name(),
            techniques: case.techniques.to_string(),
            window: answer.window,
            template: &question.template,
            template_hash: &question.template_hash,
            model: &answer.model,
            model_returned: returned,
            dangerous: answer.verdict().map(|verdict| verdict.dangerous),
            verdict,
            reading,
            repaired: answer.repairs(),
            flags: answer.flags(&case.scene.scenario),
            cut_off: answer.cut_off(),
            problem,
            answer: &answer.text,
            reasoning: &answer.reasoning,
            cost_unknown: cost_usd
                .is_none()
                .then(|| unknown(&consumed, &answer.model, returned)),
            input_tokens: consumed.input_tokens,
            output_tokens: consumed.output_tokens,
            reasoning_tokens: consumed.reasoning_tokens,
            cached_tokens: consumed.cached_tokens,
            cost_usd,
            price_source,
            stored: answer.past.zip(answer.run).map(|(past, run)| StoredAnswer {
                run,
                asked: output::rfc3339(past.created_ms),
                asked_as: &answer.model,
                origin: past.origin,
                sample: past.sample,
            }),
            prediction: (answer.model == judge::MODEL && case.task == Task::Safety)
                .then(|| Prediction::of(case)),
            tool_rounds: &answer.tool_rounds,
        }
    }
}

impl Prediction {
    fn of(case: &Case) -> Self {
        let rounded = |value: f64| (value * 1e6).round() / 1e6;
        let prospects = case.judgement().prospects;
        let obstacles = prospects.iter().map(|prospect| Contact {
            id: prospect.id,
            probability: rounded(prospect.probability),
            time: prospect.time.map(rounded),
        });
        Self {
            horizon: judge::Criterion::REFERENCE.horizon,
            threshold: judge::Criterion::REFERENCE.threshold,
            first_step: case.window.first(),
            last_step: case.window.last(),
            obstacles: obstacles.collect(),
        }
    }
}

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

impl json::Output for AskDryRun<'_> {
    const NAME: &'static str = "ask-dry-run";
    const TITLE: &'static str = "`ask --dry-run --format json`: what a question would take";
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
