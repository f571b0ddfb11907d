//! Rounds of tool calls while a model is asked: what it is offered, its calls answered, the limits.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::question::Question;
use crate::tools::{self, TOOLS, WindowView};
use nearmiss_ask::llm::{
    CALL_OVERHEAD, MAX_CALLS, ToolCall, ToolLimits, ToolRound, ToolSpec, ToolTurn, Toolbox,
};

/// Most bytes of a result: longer ones become an error that says so.
const MAX_RESULT_BYTES: usize = 6 << 10;

/// The tools as models are told of them.
#[must_use]
pub fn offered() -> Vec<ToolSpec> {
    let all = TOOLS.iter();
    all.map(|tool| ToolSpec {
        name: tool.name.into(),
        about: tool.about.into(),
        schema: (tool.arguments_schema)(),
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
    let tools = offered().into_iter();
    let all = tools.map(|spec| json!([spec.name, spec.about, spec.schema]));
    let key = nearmiss_store::Key::digest(&all.collect());
    key.as_str().chars().take(16).collect()
}

/// Answers the calls of a turn about the window of a question; `made` calls were answered before.
#[must_use]
pub fn answered(question: &Question, turn: ToolTurn, made: u32, limits: &ToolLimits) -> ToolRound {
    let case = &question.case;
    let view = WindowView::new(&case.scene, &case.thresholds, case.window);
    let left = limits.calls.saturating_sub(made) as usize;
    let results = turn
        .calls
        .iter()
        .enumerate()
        .map(|(place, call)| {
            if place >= left {
                return over_limit(limits);
            }
            result(&view, call)
        })
        .collect();
    ToolRound { turn, results }
}

/// The result of a call beyond the limit.
fn over_limit(limits: &ToolLimits) -> String {
    let most = limits.calls;
    error(format!("{BEFORE_LIMIT}{most}{AFTER_LIMIT}"))
}

/// The error of a call beyond the limit, around the number.
const BEFORE_LIMIT: &str = "the limit of ";

/// See [`BEFORE_LIMIT`].
const AFTER_LIMIT: &str = " tool calls is reached; answer now";

/// Whether a result is that of [`over_limit`].
fn is_over_limit(result: &str) -> bool {
    let failed = serde_json::from_str::<Failed>(result);
    failed.is_ok_and(|failed| {
        let rest = failed.error.strip_prefix(BEFORE_LIMIT);
        rest.is_some_and(|rest| rest.ends_with(AFTER_LIMIT))
    })
}

/// How many calls were answered in how many rounds: `4 calls in 2 rounds, 2 more refused`, with `noun` for calls.
#[must_use]
pub fn rounds_summary(rounds: &[ToolRound], noun: &str) -> String {
    let results = rounds.iter().flat_map(|round| &round.results);
    let refused = results.filter(|result| is_over_limit(result)).count();
    let made = (calls(rounds) as usize).saturating_sub(refused);
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    let noun = match noun {
        "" => String::new(),
        noun => format!(" {noun}{}", plural(made)),
    };
    let refused = match refused {
        0 => String::new(),
        n => format!(", {n} more refused"),
    };
    let all = rounds.len();
    format!("{made}{noun} in {all} round{}{refused}", plural(all))
}

/// The result of a call as the model gets it.
fn result(view: &WindowView<'_>, call: &ToolCall) -> String {
    match tools::call(view, &call.name, &call.arguments) {
        Ok(value) => {
            let text = value.to_string();
            if text.len() > MAX_RESULT_BYTES {
                error("the result is too long; ask for less of it")
            } else {
                text
            }
        }
        Err(why) => error(why.to_string()),
    }
}

/// A call without a result.
#[derive(Serialize, Deserialize)]
struct Failed {
    error: String,
}

fn error(error: impl Into<String>) -> String {
    let error = error.into();
    serde_json::to_string(&Failed { error }).unwrap_or_default()
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

/// What the last turn of a run said, of all that the run said: what stands before the calls of rounds is no answer.
/// `of` gives the part of a turn that the text is made of.
#[must_use]
pub fn last_turn<'a>(rounds: &[ToolRound], text: &'a str, of: fn(&ToolTurn) -> &str) -> &'a str {
    // Rounds that were continued are not in the text.
    rounds.iter().fold(text, |rest, round| {
        let after = rest
            .strip_prefix(of(&round.turn))
            .filter(|after| after.len() < rest.len());
        after.map_or(rest, |after| after.strip_prefix("\n\n").unwrap_or(after))
    })
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
    let tokens =
        |bytes: usize| u32::try_from((bytes + CALL_OVERHEAD).div_ceil(2)).unwrap_or(u32::MAX);
    let results = limits.calls.saturating_mul(tokens(MAX_RESULT_BYTES));
    // Calls of the last round that are beyond the limit are answered, too.
    let beyond = MAX_CALLS as u32 * tokens(over_limit(limits).len());
    rounds
        .saturating_mul(answer)
        .saturating_add(if rounds == 0 {
            0
        } else {
            results.saturating_add(beyond)
        })
}

/// Tokens of each request that one question with tools may need, at most: one for each round of calls, and one for the
/// answer. `question` is the tokens of its messages, `answer` the most of an answer, where it has a limit.
#[must_use]
pub fn most_tokens(question: usize, limits: &ToolLimits, answer: Option<u32>) -> Vec<usize> {
    // They are always the same, and a screen counts them for many models.
    static OFFERED: OnceLock<usize> = OnceLock::new();
    let told = question.saturating_add(*OFFERED.get_or_init(|| toolbox().tokens()));
    let added = |round| most_added(round, limits, answer.unwrap_or(0)) as usize;
    (0..=limits.rounds)
        .map(|round| told.saturating_add(added(round)))
        .collect()
}

/// What a turn that called tools after the limit leaves: no verdict, and why.
pub(super) fn beyond(limits: &ToolLimits) -> String {
    format!(
        "the model called tools after the limit of {} rounds and {} calls instead of answering; raise tool_rounds or \
         tool_calls",
        limits.rounds, limits.calls
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_ask::llm::{Endpoint, Message, Parameters, Request, Role};

    fn request(rounds: Vec<ToolRound>) -> Request {
        let tools = Toolbox {
            rounds,
            ..toolbox()
        };
        Request {
            model: "m".into(),
            messages: vec![Message::new(Role::User, "Is it safe?")],
            parameters: Parameters {
                max_tokens: Some(200),
                ..Parameters::default()
            },
            schema: None,
            tools: Some(tools),
        }
    }

    #[test]
    fn refused_calls_are_counted_apart() {
        let limits = ToolLimits {
            calls: 1,
            ..ToolLimits::default()
        };
        let call = ToolCall {
            id: "call".into(),
            name: "distance".into(),
            arguments: "{}".into(),
        };
        let round = |count: usize, results: Vec<String>| ToolRound {
            turn: ToolTurn {
                calls: vec![call.clone(); count],
                ..ToolTurn::default()
            },
            results,
        };
        let one = round(1, vec!["{}".into()]);
        assert_eq!(
            rounds_summary(std::slice::from_ref(&one), "tool call"),
            "1 tool call in 1 round"
        );
        let more = round(2, vec![over_limit(&limits); 2]);
        assert_eq!(
            rounds_summary(&[one, more], ""),
            "1 in 2 rounds, 2 more refused"
        );
    }

    /// Rounds as long as they can be: turns of many bytes a token, told again as the server wants them.
    fn longest(rounds: u32, limits: &ToolLimits) -> Vec<ToolRound> {
        let mut all: Vec<ToolRound> = Vec::new();
        for round in 0..rounds {
            let last = round + 1 == rounds;
            let count = if last { MAX_CALLS as u32 } else { 1 };
            let call = ToolCall {
                id: "call".into(),
                name: "distance".into(),
                arguments: "9".repeat(2000),
            };
            let made = calls(&all);
            let results = (0..count)
                .map(|place| {
                    if made + place < limits.calls {
                        "x".repeat(MAX_RESULT_BYTES)
                    } else {
                        over_limit(limits)
                    }
                })
                .collect();
            let turn = ToolTurn {
                text: "t".repeat(3000),
                thought: "t".repeat(3000),
                calls: vec![call; count as usize],
                echo: vec![json!({"thinking": "t".repeat(3000)})],
            };
            all.push(ToolRound { turn, results });
        }
        all
    }

    #[test]
    fn the_bound_of_a_dry_run_covers_what_is_reserved() {
        let endpoint = Endpoint::new("lab", "https://example.org");
        for limits in [
            ToolLimits::default(),
            ToolLimits {
                rounds: 3,
                calls: 4,
            },
        ] {
            let bare = endpoint.tokens(&request(Vec::new()));
            for rounds in 0..=limits.rounds {
                let reserved = endpoint.tokens(&request(longest(rounds, &limits)));
                let bound = bare + most_added(rounds, &limits, 200);
                assert!(reserved <= bound, "{limits:?} {rounds}: {reserved} {bound}");
                let untold = Request {
                    tools: None,
                    ..request(Vec::new())
                };
                let question = endpoint.tokens(&untold) as usize;
                let most = most_tokens(question, &limits, Some(200));
                assert!(reserved as usize <= most[rounds as usize]);
                assert_eq!(most.len(), limits.rounds as usize + 1);
            }
        }
    }

    #[test]
    fn the_last_turn_is_what_follows_the_rounds() {
        let round = |text: &str| ToolRound {
            turn: ToolTurn {
                text: text.into(),
                ..ToolTurn::default()
            },
            results: Vec::new(),
        };
        let of: fn(&ToolTurn) -> &str = |turn| &turn.text;
        let rounds = [round("{\"collision\": true}"), round(""), round("Now.")];
        assert_eq!(
            last_turn(&rounds, "{\"collision\": true}\n\nNow.\n\nNo.", of),
            "No."
        );
        // The first round was continued.
        assert_eq!(last_turn(&rounds, "Now.\n\nNo.", of), "No.");
        assert_eq!(last_turn(&[], "No.", of), "No.");
    }
}
