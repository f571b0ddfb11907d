//! The answer to one question as one object: the verdict, its cost, where it is stored.

use jiff::Timestamp;
use jiff::tz::TimeZone;
use nearmiss_ask::llm::{ToolRound, Usage};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{ParsedAnswer, Task};
use nearmiss_store::{Origin, RunId};
use nearmiss_study::evaluation::consumption::unknown;
use nearmiss_study::evaluation::{Answer, Case, Judge, JudgeOutcome, MissingVerdict, Question};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

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
    /// That of an answer to a question.
    #[must_use]
    pub fn new(answer: &'a Answer, question: &'a Question, judge: &Judge) -> Self {
        let case = &question.case;
        let (verdict, problem) = match &answer.judged {
            JudgeOutcome::Verdict(parsed) => {
                (Some(ParsedAnswer::Verdict(parsed.verdict.clone())), None)
            }
            JudgeOutcome::Other(reading) => (Some(reading.said.clone()), None),
            JudgeOutcome::Missing(missing) => (None, Some(missing_verdict(missing))),
        };
        let reading = match (&problem, answer.repairs().is_empty()) {
            (Some(_), _) => None,
            (None, true) => Some("strict"),
            (None, false) => Some("repaired"),
        };
        let consumed = answer.consumed;
        let (cost_usd, price_source) =
            match (consumed.cost_usd, cost_at_current_prices(answer, judge)) {
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
                asked: rfc3339(past.created_ms),
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

/// What an answer cost by the prices of the model that is asked for now, US dollars, with where they are from; nothing
/// where the run knows its cost, or the prices or tokens are not known.
#[must_use]
pub fn cost_at_current_prices(answer: &Answer, judge: &Judge) -> Option<(f64, String)> {
    let (Judge::Model(model), Some(past), None) = (judge, &answer.past, answer.consumed.cost_usd)
    else {
        return None;
    };
    let asked = Timestamp::from_millisecond(past.created_ms).ok()?;
    let day = asked.to_zoned(TimeZone::UTC).date();
    let prices = &model.endpoint.prices;
    let pricing = prices.of_answer(&model.name, answer.model_returned.as_deref(), day)?;
    let usage = Usage {
        input_tokens: answer.consumed.input_tokens,
        output_tokens: answer.consumed.output_tokens,
        reasoning_tokens: answer.consumed.reasoning_tokens,
        cached_tokens: answer.consumed.cached_tokens,
        ..Usage::default()
    };
    let usd = pricing.cost(&usage, asked)?;
    let origin = pricing.origin().map_or(String::new(), |o| format!(", {o}"));
    let provider = &model.endpoint.name;
    Some((
        usd,
        format!("computed now: tokens of the run times prices of {provider}{origin}"),
    ))
}

/// Why there is no verdict. An address that cannot be reached was tried, other than what is refused beforehand.
#[must_use]
pub fn missing_verdict(missing: &MissingVerdict) -> String {
    match missing {
        MissingVerdict::NotSent(why) => format!("no answer: {why}"),
        MissingVerdict::NoAnswer(why) if is_too_long(why) => format!(
            "{missing}; a shorter question may fit: --set form=compact, a smaller --history or radius, --techniques base"
        ),
        missing => missing.to_string(),
    }
}

/// Whether a server means that the question is longer than what its model can take.
fn is_too_long(why: &str) -> bool {
    let why = why.to_ascii_lowercase();
    let context = ["length", "window", "size", "maximum", "exceed", "limit"];
    (why.contains("(400") || why.contains("(413"))
        && ((why.contains("context") && context.iter().any(|word| why.contains(word)))
            || why.contains("too long")
            || why.contains("too many tokens"))
}

/// A time for programs, in UTC, from milliseconds since 1970.
#[must_use]
pub fn rfc3339(ms: i64) -> String {
    // Only an edited store holds a moment that no calendar has.
    let moment = Timestamp::from_millisecond(ms);
    moment.map_or_else(|_| format!("{ms} ms"), |moment| moment.to_string())
}
