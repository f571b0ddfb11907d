//! The end of an answer: its verdict, or why it has none.

use super::answer::{Answer, JudgeOutcome, MissingVerdict, TOO_LONG};
use super::token_probability::token_probability;
use crate::llm::{Finish, LONGEST_ANSWER, Token};
use crate::verdict::{self, Task};

/// Reads an answer whose text is complete, truncated or missing.
pub(super) fn read(task: Task, answer: &Answer, failure: Option<MissingVerdict>) -> JudgeOutcome {
    read_from(task, answer, [0, 0], failure)
}

/// The same of text and reasoning from these bytes on: what a model says before it calls tools is no answer.
pub(super) fn read_from(
    task: Task,
    answer: &Answer,
    from: [usize; 2],
    failure: Option<MissingVerdict>,
) -> JudgeOutcome {
    let last = answer.text.get(from[0]..).unwrap_or_default();
    // A model that puts everything into its reasoning has still answered.
    let whole = if last.trim().is_empty() {
        answer.reasoning.get(from[1]..).unwrap_or_default()
    } else {
        last
    };
    match failure {
        Some(missing @ (MissingVerdict::NoAnswer(_) | MissingVerdict::NotSent(_))) => {
            JudgeOutcome::Missing(missing)
        }
        stopped => match (verdict::read(task, whole), stopped) {
            (Ok(reading), _) => JudgeOutcome::from(reading),
            (Err(_), Some(stopped)) => JudgeOutcome::Missing(stopped),
            (Err(why), None) => JudgeOutcome::Missing(MissingVerdict::NotInAnswer(why.to_string())),
        },
    }
}

/// Adds to a verdict what the log probabilities of its tokens say. Whether they say it, or are about no verdict.
pub(super) fn weighed(task: Task, tokens: &[Token], judged: &mut JudgeOutcome) -> bool {
    let JudgeOutcome::Verdict(parsed) = judged else {
        return true;
    };
    let verdict = &mut parsed.verdict;
    verdict.token_probability = token_probability(tokens, task, verdict.dangerous);
    verdict.token_probability.is_some()
}

/// Why an answer that ended this way may hold no verdict.
pub(super) fn stopped_short(finish: &Finish) -> Option<MissingVerdict> {
    let why = match finish {
        Finish::Length => "the answer ran into the token limit; raise max_tokens".to_string(),
        Finish::TooLong => too_long(),
        Finish::ContentFilter => "the server's content filter stopped the answer".to_string(),
        Finish::Blocked(why) => format!("the server's filter blocked the question ({why})"),
        Finish::Blank => {
            "the answer is blank, as from some servers that fail to produce the requested JSON; ask again".into()
        }
        Finish::ToolCalls => "the model called tools that it was not offered".to_string(),
        Finish::Refusal(text) if text.is_empty() => "the model declined".into(),
        Finish::Refusal(text) => format!("the model declined: {text}"),
        Finish::Stop | Finish::Other(_) => return None,
    };
    Some(MissingVerdict::NotInAnswer(why))
}

/// The message for an answer cut off by this program.
pub(super) fn too_long() -> String {
    let limit = LONGEST_ANSWER >> 20;
    format!("nearmiss cut the answer off at {limit} MiB; set max_tokens, or choose another model")
}

pub(super) fn word(finish: &Finish) -> String {
    match finish {
        Finish::Stop => "stop".into(),
        Finish::ToolCalls => "tool_calls".into(),
        Finish::Length => "length".into(),
        Finish::TooLong => TOO_LONG.into(),
        Finish::ContentFilter => "content_filter".into(),
        Finish::Blocked(_) => "blocked".into(),
        Finish::Blank => "blank".into(),
        Finish::Refusal(_) => "refusal".into(),
        Finish::Other(word) => word.clone(),
    }
}
