//! Chunks: the pieces in which an answer arrives.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::token::Token;
use super::tool_calls::ToolTurn;

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
pub const LONGEST_ANSWER: usize = 4 << 20;

/// More tokens than any question or answer can have.
const MOST_TOKENS: u64 = 1_000_000_000;

/// More US dollars than any answer can cost.
const MOST_USD: f64 = 10_000.0;

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
        let possible = |cost: &Cost| (0.0..=MOST_USD).contains(&cost.usd);
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
    /// This program stopped reading, because the answer was larger than [`LONGEST_ANSWER`] bytes, or took more than
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
