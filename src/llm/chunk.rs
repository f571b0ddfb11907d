//! The pieces in which an answer arrives.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// One piece of an answer, in the order of arrival.
///
/// The order is: any number of `Retrying`, one `Started`, any mix of `Reasoning` and `Text`, at most one `Usage`, and on success
/// exactly one `Finished`, which is last. A failed answer ends with an error instead of `Finished`; everything that had
/// arrived is delivered before the error.
#[derive(Clone, Debug, PartialEq)]
pub enum Chunk {
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

/// Token counts and cost of one answer. `None` means that the server did not say, never zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Usage {
    /// Tokens of the question, cached ones included.
    pub input_tokens: Option<u64>,
    /// Tokens of the answer, reasoning included.
    pub output_tokens: Option<u64>,
    /// Those of the output tokens that were reasoning.
    pub reasoning_tokens: Option<u64>,
    /// Those of the input tokens that came from the server's cache.
    pub cached_tokens: Option<u64>,
    /// Cost in US dollars, where the server states it (OpenRouter does).
    pub cost: Option<f64>,
}

/// Why the model stopped.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Finish {
    /// It had said everything.
    Stop,
    /// It ran into the token limit: the text is cut off.
    Length,
    /// The server's filter stopped it.
    ContentFilter,
    /// The model declined; the text says how.
    Refusal(String),
    /// Any other reason, in the server's word; `"unstated"` if it gave none.
    Other(String),
}
