//! The end of an answer: its verdict, or why it has none.

use super::answer::{Answer, JudgeOutcome, MissingVerdict};
use super::token_probability::token_probability;
use nearmiss_ask::llm::{Finish, LONGEST_ANSWER, THINKING_TAGS, Token};
use nearmiss_scene::verdict::{self, Task};
use nearmiss_store::TOO_LONG;

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
        after_thinking(last)
    };
    let finish = answer.finish.as_deref();
    let is_cut = finish.is_some_and(|word| is_cut(word) || DECLINED.contains(&word));
    match failure {
        Some(missing @ (MissingVerdict::NoAnswer(_) | MissingVerdict::NotSent(_))) => {
            JudgeOutcome::Missing(missing)
        }
        Some(stopped) if is_cut => JudgeOutcome::Missing(stopped),
        _ if whole.trim().is_empty() && !last.trim().is_empty() => {
            JudgeOutcome::Missing(MissingVerdict::NotInAnswer(ONLY_THINKING.into()))
        }
        stopped => match (verdict::read(task, whole), stopped) {
            (Ok(reading), _) => JudgeOutcome::from(reading),
            (Err(_), Some(stopped)) => JudgeOutcome::Missing(stopped),
            (Err(why), None) => JudgeOutcome::Missing(MissingVerdict::NotInAnswer(why.to_string())),
        },
    }
}

/// A question is known to be cut where a server counts less than this share of its estimated tokens: the estimate is
/// within 5 % of o200k_base, and other tokenizers make more of scenes in words.
const CUT: f64 = 0.8;

/// No server's context is smaller, tokens: one that counts less does not count.
const LEAST_CONTEXT: u64 = 256;

/// What was read in an answer, unless the server read only a part of the question: by the tokens that it counted and the
/// estimate of those sent, where these were words alone.
pub(super) fn unless_cut(
    judged: JudgeOutcome,
    counted: Option<u64>,
    sent: Option<usize>,
) -> JudgeOutcome {
    match judged {
        JudgeOutcome::Verdict(_) | JudgeOutcome::Other(_) => sent
            .and_then(|sent| cut_question(counted, sent))
            .map_or(judged, JudgeOutcome::Missing),
        JudgeOutcome::Missing(_) => judged,
    }
}

fn cut_question(counted: Option<u64>, sent: usize) -> Option<MissingVerdict> {
    let counted = counted.filter(|counted| *counted >= LEAST_CONTEXT)?;
    let is_cut = (counted as f64) < CUT * sent as f64;
    is_cut.then(|| {
        MissingVerdict::NotInAnswer(format!(
            "the server counts {counted} of about {sent} tokens that were sent, so it read only a part of the question; raise \
             its context (num_ctx, --ctx-size), or shorten the question (stride, radius, history), and ask with --fresh"
        ))
    })
}

/// Whether an answer that ended with this word is not whole: the rest could have said something else.
pub(super) fn is_cut(word: &str) -> bool {
    matches!(word, "length" | TOO_LONG | "content_filter" | "blocked") || is_broken(word)
}

/// How whole answers end in which nothing counts: there is nothing but thinking, in which verdicts are drafts, or the
/// model declined.
const DECLINED: [&str; 2] = ["refusal", THINKING];

const THINKING: &str = "thinking";

/// Words of servers for an answer that they broke off, in lower case; those that nobody knows say that it is whole.
fn is_broken(word: &str) -> bool {
    const BEGINNINGS: [&str; 8] = [
        "abort",
        "cancel",
        "error",
        "fail",
        "incomplete",
        "interrupt",
        "malformed",
        "timeout",
    ];
    let word = word.to_ascii_lowercase();
    word == "other" || BEGINNINGS.iter().any(|begin| word.starts_with(begin))
}

const ONLY_THINKING: &str =
    "the answer is thinking and nothing else; raise max_tokens, or ask for less effort";

/// What a text says between the last end of thinking, which may have begun without a tag, and thinking that never ends;
/// all of it where it is one JSON value.
fn after_thinking(text: &str) -> &str {
    if serde_json::from_str::<serde_json::Value>(text).is_ok() {
        return text;
    }
    let plain = text.to_ascii_lowercase();
    let ends = THINKING_TAGS.iter().filter_map(|(_, close)| {
        let tag = close.to_ascii_lowercase();
        Some(plain.rfind(&tag)? + tag.len())
    });
    let said = ends.max().unwrap_or(0);
    let begins = THINKING_TAGS
        .iter()
        .filter_map(|(open, _)| plain[said..].find(&open.to_ascii_lowercase()));
    let end = begins.min().map_or(text.len(), |at| said + at);
    &text[said..end]
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
        Finish::Thinking => ONLY_THINKING.to_string(),
        Finish::ToolCalls => "the model called tools that it was not offered".to_string(),
        Finish::Refusal(text) if text.is_empty() => "the model declined".into(),
        Finish::Refusal(text) => format!("the model declined: {text}"),
        Finish::Other(word) if is_broken(word) => {
            format!("the server broke the answer off ({word}); ask again")
        }
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
        Finish::Thinking => THINKING.into(),
        Finish::Refusal(_) => "refusal".into(),
        Finish::Other(word) => word.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_lies_outside_of_thinking_in_any_case() {
        for (text, said) in [
            ("draft</Think> yes", " yes"),
            ("first <THINK>no, yes", "first "),
            ("<think>a</think>b <scratchpad>c", "b "),
            ("a <think>yes, <think>no", "a "),
            ("{\"a\": \"<think>\"}", "{\"a\": \"<think>\"}"),
            ("plain", "plain"),
        ] {
            assert_eq!(after_thinking(text), said, "{text}");
        }
    }

    #[test]
    fn words_of_servers_for_broken_answers() {
        for (word, cut) in [
            ("stop", false),
            ("eos_found", false),
            ("abort", true),
            ("OTHER", true),
            ("MALFORMED_RESPONSE", true),
            ("length", true),
            ("blank", false),
        ] {
            assert_eq!(is_cut(word), cut, "{word}");
            let finish = Finish::Other(word.into());
            let broken = cut && word != "length";
            assert_eq!(stopped_short(&finish).is_some(), broken, "{word}");
        }
    }

    #[test]
    fn only_what_a_context_can_have_kept_is_a_cut_question() {
        for (counted, sent, is_cut) in [
            (Some(2050), 2688, true),
            (Some(2048), 3526, true),
            (Some(512), 11_582, true),
            (Some(3400), 3526, false),
            // Servers that do not count write anything.
            (Some(10), 2688, false),
            (None, 2688, false),
        ] {
            let found = cut_question(counted, sent);
            assert_eq!(found.is_some(), is_cut, "{counted:?} of {sent}");
        }
    }

    #[test]
    fn thinking_without_its_first_tag_is_no_answer() {
        for (text, said) in [
            ("draft {\"collision\": false}\n</think>\n\nyes", "\n\nyes"),
            ("a [/THINK] b </think> c", " c"),
            ("draft </think>", ""),
            ("plain", "plain"),
            ("\"of </think>\"", "\"of </think>\""),
        ] {
            assert_eq!(after_thinking(text), said);
        }
    }
}
