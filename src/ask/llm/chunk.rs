//! Chunks: the pieces in which an answer arrives, and its tokens with their log probabilities.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::request::ToolTurn;

/// One piece of an answer, in the order of arrival.
///
/// The order is: any number of `Note`, any number of `Retrying`, one `Started`, any mix of `Reasoning` and `Text`, at
/// most one `Usage`, before it perhaps a `Note` about it, and on success at most one `LogProbabilities`, at most one
/// `ToolCalls` and exactly one `Finished`, which is last. A
/// failed answer ends with an error instead of `Finished`; everything that had arrived is delivered before the error.
#[derive(Clone, Debug, PartialEq)]
pub enum Chunk {
    /// Something about the request that people should know, such as a parameter that this model does not take.
    Note(String),
    /// The answer begins.
    Started {
        /// The model the server says it used; it may differ from the one asked for.
        model: Option<String>,
    },
    /// A piece of the reasoning ("thinking") text, or of the server's summary of it.
    Reasoning(String),
    /// A piece of the answer itself.
    Text(String),
    /// Usage as counted by the server.
    Usage(Usage),
    /// The tokens of the answer with their log probabilities, where they were asked for and given.
    LogProbabilities(Vec<Token>),
    /// The model calls tools; [`Finish::ToolCalls`] follows.
    ToolCalls(ToolTurn),
    /// A try failed in a way that may pass; the next one follows after the wait.
    Retrying {
        /// Number of the try that follows: 2 for the first repetition.
        attempt: u32,
        /// How long it waits before that try.
        wait: Duration,
        /// The failure, in a few words.
        why: String,
    },
    /// The answer is complete.
    Finished(Finish),
}

/// Most of an answer that is read, reasoning and text together, in bytes.
pub const MAX_ANSWER_BYTES: usize = 4 << 20;

/// More tokens than any question or answer can have.
const MOST_TOKENS: u64 = 1_000_000_000;

/// More US dollars than any answer can cost.
const MAX_USD: f64 = 10_000.0;

/// Token counts and cost of one answer, counted alike for all providers. `None` means not reported, never zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Usage {
    /// Tokens of the question, those read from and written to a cache included.
    pub input_tokens: Option<u64>,
    /// Tokens of the answer, reasoning included.
    pub output_tokens: Option<u64>,
    /// Those of the output tokens that were reasoning.
    pub reasoning_tokens: Option<u64>,
    /// Those of the input tokens that came from the server's cache.
    pub cached_tokens: Option<u64>,
    /// Those of the input tokens that were written to the server's cache.
    pub cache_write_tokens: Option<u64>,
    /// Its cost.
    pub cost: Option<Cost>,
}

impl Usage {
    /// The usage without the numbers that cannot be true, and the names of those. A server may state anything; sums,
    /// budgets and reports have to stay of use.
    pub(super) fn plausible(mut self) -> (Self, Vec<&'static str>) {
        let mut dropped = Vec::new();
        for (name, count) in [
            ("input tokens", &mut self.input_tokens),
            ("output tokens", &mut self.output_tokens),
            ("reasoning tokens", &mut self.reasoning_tokens),
            ("cached tokens", &mut self.cached_tokens),
            ("tokens written to the cache", &mut self.cache_write_tokens),
        ] {
            if count.take_if(|count| *count > MOST_TOKENS).is_some() {
                dropped.push(name);
            }
        }
        let possible = |cost: &Cost| (0.0..=MAX_USD).contains(&cost.usd);
        if self.cost.take_if(|cost| !possible(cost)).is_some() {
            dropped.push("cost");
        }
        (self, dropped)
    }
}

/// Cost of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// US dollars.
    pub usd: f64,
    /// Source of the cost.
    pub source: CostSource,
}

/// Source of a cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CostSource {
    /// The server, with the answer.
    Server,
    /// Worked out from the token counts and a table of prices.
    Prices,
}

/// Why the model stopped.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finish {
    /// It had said everything.
    Stop,
    /// It said that it was finished, and had said nothing but white space: so DeepSeek ends an answer that is not the
    /// JSON asked for. Asking again may help, and is paid for again.
    Blank,
    /// It said that it was finished, and all that came is thinking between tags.
    Thinking,
    /// It called tools and waits for their results.
    ToolCalls,
    /// It ran into the token limit: the text is cut off.
    Length,
    /// This program stopped reading, because the answer was larger than [`MAX_ANSWER_BYTES`] bytes, or took more than
    /// is read of any answer: the text is cut off.
    TooLong,
    /// The server's filter stopped the answer.
    ContentFilter,
    /// The server's filter stopped the question; its reason.
    Blocked(String),
    /// The model declined; how it said so, which may be in the text or nowhere.
    Refusal(String),
    /// Any other reason, in the server's word; `"unstated"` if it gave none.
    Other(String),
}

/// Alternatives that are asked for at each token: a yes, a no, and how either may be spelt.
pub(super) const ALTERNATIVES: u32 = 5;

/// Most alternatives of a token that are kept, and most bytes of each.
const MAX_ALTERNATIVES: usize = 20;
const MAX_ALTERNATIVE_BYTES: usize = 200;

/// A token of an answer, with what the model might have written in its place. It is the server's text, from which
/// secrets are not taken out: to be computed with, neither shown nor stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    /// Its text.
    pub text: String,
    /// The natural logarithm of its probability.
    pub log_probability: f64,
    /// The likeliest tokens at its place, perhaps itself among them, each with the same.
    pub alternatives: Vec<(String, f64)>,
}

impl Token {
    /// A token; `None` if it has no logarithm of a probability. What is wrong with an alternative leaves that one out.
    pub(super) fn new(
        chosen: (Option<&str>, Option<f64>),
        alternatives: impl Iterator<Item = (Option<String>, Option<f64>)>,
    ) -> Option<Self> {
        let valid = |log: &f64| *log <= 0.001 && !log.is_nan();
        let kept = alternatives.filter_map(|(text, log)| Some((cut(&text?), log.filter(valid)?)));
        Some(Self {
            text: chosen.0?.to_owned(),
            log_probability: chosen.1.filter(valid)?,
            alternatives: kept.take(MAX_ALTERNATIVES).collect(),
        })
    }
}

fn cut(text: &str) -> String {
    text[..text.floor_char_boundary(MAX_ALTERNATIVE_BYTES)].to_owned()
}

/// The tokens of a list as OpenAI has it: `token`, `logprob`, `top_logprobs`. Others speak it too.
pub(super) fn tokens(list: Option<&Value>) -> Vec<Token> {
    let pair = |entry: &Value| {
        let text = entry.get("token").and_then(Value::as_str);
        let log = entry.get("logprob").and_then(Value::as_f64);
        (text.map(str::to_owned), log)
    };
    let token = |entry: &Value| {
        let top = entry.get("top_logprobs").and_then(Value::as_array);
        let (text, log) = pair(entry);
        Token::new((text.as_deref(), log), top.into_iter().flatten().map(pair))
    };
    let entries = list.and_then(Value::as_array);
    entries.into_iter().flatten().filter_map(token).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_that_cannot_be_true_are_dropped_by_name() {
        let cost = |usd| {
            Some(Cost {
                usd,
                source: CostSource::Server,
            })
        };
        let usage = Usage {
            input_tokens: Some(u64::MAX),
            output_tokens: Some(34),
            cached_tokens: Some(MOST_TOKENS + 1),
            cost: cost(0.5),
            ..Usage::default()
        };
        let (left, dropped) = usage.plausible();
        assert_eq!((left.input_tokens, left.output_tokens), (None, Some(34)));
        assert_eq!((left.cached_tokens, left.cost), (None, cost(0.5)));
        assert_eq!(dropped, ["input tokens", "cached tokens"]);
        for usd in [f64::NAN, f64::INFINITY, -1.0, 1e300] {
            let usage = Usage {
                cost: cost(usd),
                ..Usage::default()
            };
            assert_eq!(usage.plausible(), (Usage::default(), vec!["cost"]), "{usd}");
        }
    }

    #[test]
    fn what_is_no_log_probability_is_left_out() {
        let list = json!([
            {"token": "true", "logprob": -0.1, "top_logprobs": [
                {"token": "true", "logprob": -0.1}, {"token": "false", "logprob": 3.0}, {"logprob": -1.0}]},
            {"token": "}", "logprob": null},
            {"token": "}", "logprob": -9999.0},
        ]);
        let found = tokens(Some(&list));
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!(found[0].alternatives, [("true".to_string(), -0.1)]);
        assert_eq!(found[1].log_probability, -9999.0);
        assert_eq!(tokens(None), []);
        assert_eq!(tokens(Some(&json!("no list"))), []);
    }
}
