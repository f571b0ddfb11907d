//! Rounds of tool calls while a model is asked: what it is offered, its calls answered, the limits.

use serde_json::{Value, json};

use super::question::Question;
use crate::llm::{ToolCall, ToolLimits, ToolRound, ToolSpec, ToolTurn, Toolbox};
use crate::tools::{self, Kind, WindowView, tools};

/// Most bytes of a result: longer ones become an error that says so.
const LONGEST_RESULT: usize = 6 << 10;

/// The instruments as models are told of them. Oracles are never among them.
#[must_use]
pub fn offered() -> Vec<ToolSpec> {
    let all = tools(Kind::Instrument);
    all.map(|tool| ToolSpec {
        name: tool.name.into(),
        about: tool.about.into(),
        schema: tool.arguments_schema(),
    })
    .collect()
}

/// The tools of a first request.
pub(super) fn toolbox() -> Toolbox {
    Toolbox {
        specs: offered(),
        rounds: Vec::new(),
        may_call: true,
    }
}

/// What the store knows the offered tools by: changed tools are another question.
#[must_use]
pub(super) fn table_hash() -> String {
    let all = offered().into_iter();
    let all: Vec<Value> = all
        .map(|spec| json!([spec.name, spec.about, spec.schema]))
        .collect();
    let key = crate::store::Key::digest(&json!(all));
    key.as_str().chars().take(16).collect()
}

/// Answers the calls of a turn about the window of a question; `made` calls were answered before.
#[must_use]
pub fn answered(question: &Question, turn: ToolTurn, made: u32, limits: &ToolLimits) -> ToolRound {
    let case = &question.case;
    let view = WindowView::new(&case.scene, &case.thresholds, case.window);
    let left = limits.calls.saturating_sub(made) as usize;
    let results = turn.calls.iter().enumerate().map(|(place, call)| {
        if place >= left {
            let most = limits.calls;
            return error(&format!(
                "the limit of {most} tool calls is reached; answer now"
            ));
        }
        result(&view, call)
    });
    let results = results.collect();
    ToolRound { turn, results }
}

/// The result of a call as the model gets it.
fn result(view: &WindowView<'_>, call: &ToolCall) -> String {
    match tools::call(view, &[Kind::Instrument], &call.name, &call.arguments) {
        Ok(value) => {
            let text = value.to_string();
            match text.len() > LONGEST_RESULT {
                true => error("the result is too long; ask for less of it"),
                false => text,
            }
        }
        Err(why) => error(&why.to_string()),
    }
}

fn error(message: &str) -> String {
    json!({ "error": message }).to_string()
}

/// How many calls these rounds have.
#[must_use]
pub fn calls(rounds: &[ToolRound]) -> u32 {
    let calls = rounds.iter().map(|round| round.turn.calls.len());
    u32::try_from(calls.sum::<usize>()).unwrap_or(u32::MAX)
}

/// Whether a model that has had these rounds may call more tools.
pub(super) fn may_call(rounds: &[ToolRound], limits: &ToolLimits) -> bool {
    let had = u32::try_from(rounds.len()).unwrap_or(u32::MAX);
    had < limits.rounds && calls(rounds) < limits.calls
}

/// The rounds that the store has of a run.
#[must_use]
pub fn stored(json: Option<&str>) -> Vec<ToolRound> {
    let read = json.map(serde_json::from_str);
    read.and_then(Result::ok).unwrap_or_default()
}

/// A round in lines, a call each: `distance {"obstacle":304} → {"distance":2.02}`.
#[must_use]
pub fn lines(round: &ToolRound) -> Vec<String> {
    let pairs = round.pairs();
    let line = |(call, result): (&ToolCall, &str)| {
        let arguments = match call.arguments.trim() {
            "" => "{}",
            text => text,
        };
        format!("{} {arguments} → {result}", call.name)
    };
    pairs.map(line).collect()
}

/// Tokens that the rounds may add to a request at most: calls and results of all rounds before it.
pub(super) fn most_added(rounds: u32, limits: &ToolLimits, answer: u32) -> u32 {
    // A turn is at most an answer long; results are half as many tokens as bytes.
    let results = limits.calls.saturating_mul(LONGEST_RESULT as u32 / 2);
    rounds
        .saturating_mul(answer)
        .saturating_add(if rounds == 0 { 0 } else { results })
}

/// What a turn that called tools after the limit leaves: no verdict, and why.
pub(super) fn beyond(limits: &ToolLimits) -> String {
    format!(
        "the model called tools after the limit of {} rounds and {} calls instead of answering; raise --tool-rounds or \
         --tool-calls",
        limits.rounds, limits.calls
    )
}
