//! The pieces in which an answer arrives.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// One piece of an answer, in the order of arrival.
///
/// The order is: any number of `Note`, any number of `Retrying`, one `Started`, any mix of `Reasoning` and `Text`, at most one
/// `Usage`, and on success exactly one `Finished`, which is last. A failed answer ends with an error instead of `Finished`;
/// everything that had arrived is delivered before the error.
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
    /// What the answer consumed, as the server counts it.
    Usage(Usage),
    /// A try failed in a way that may pass; the next one follows after the wait.
    Retrying {
        /// Number of the try that follows: 2 for the first repetition.
        attempt: u32,
        /// How long it waits before that try.
        wait: Duration,
        /// What went wrong, in a few words.
        why: String,
    },
    /// The answer is complete.
    Finished(Finish),
}

/// Token counts and cost of one answer, counted alike for all providers. `None` means that nobody said, never zero.
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
    /// What it cost.
    pub cost: Option<Cost>,
}

/// What an answer cost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// US dollars.
    pub usd: f64,
    /// Who says so.
    pub source: CostSource,
}

/// Who says what an answer cost.
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
    /// It said that it was finished, and had said nothing but white space: so DeepSeek ends an answer that is not the JSON
    /// asked for. Asking again may help, and is paid for again.
    Blank,
    /// It ran into the token limit: the text is cut off.
    Length,
    /// The server's filter stopped the answer.
    ContentFilter,
    /// The server's filter stopped the question; its reason.
    Blocked(String),
    /// The model declined; how it said so, which may be in the text or nowhere.
    Refusal(String),
    /// Any other reason, in the server's word; `"unstated"` if it gave none.
    Other(String),
}
