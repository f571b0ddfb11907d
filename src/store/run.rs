//! The stored data of a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use strum::{IntoStaticStr, VariantArray};

use super::{ClaimCounts, Key, StoredImage, claim, document};
use nearmiss_scene::verdict::{ParsedAnswer, Task};

/// Identifies a run in its store.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    PartialOrd,
    Ord,
    Default,
    Serialize,
    Deserialize,
    JsonSchema,
)]
pub struct RunId(pub i64);

impl std::fmt::Display for RunId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// Data known before a judge is asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NewRun {
    /// Number of the sample among answers to the same request, from 0.
    pub sample: u32,
    /// Name of the batch that it belongs to, such as b7.
    pub batch: Option<String>,
    /// Name of the scenario: its file name without the ending.
    pub scenario: String,
    /// SHA-256 of its file, hexadecimal; null if an answer is known and the file is not.
    pub scenario_hash: Option<String>,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// The question: collision, safety, recording, attacker or trajectory.
    #[schemars(with = "String")]
    pub task: Task,
    /// Frame of the description.
    pub frame: String,
    /// Prompting techniques: cp, cot and icl joined by +, or base.
    pub techniques: String,
    /// First and last time step of the window; null if an answer is known and its window is not.
    pub window: Option<(i64, i64)>,
    /// Model asked, as provider/model.
    pub model: String,
    /// The provider of the model.
    pub provider: String,
    /// Wire protocol; null if no request is sent.
    pub dialect: Option<String>,
    /// Provider and address of the server, for people, without any key.
    pub endpoint: String,
    /// The address alone, without user, password and query; null if no request is sent.
    pub address: Option<String>,
    /// File name of the prompt template.
    pub template: String,
    /// Version that the template states; null for a draft.
    pub template_version: Option<String>,
    /// SHA-256 of the text of the template.
    pub template_hash: String,
    /// The messages: role and content of each, and its images by hash, if it has some.
    #[serde(with = "document")]
    #[schemars(with = "Value")]
    pub messages: String,
    /// Sampling parameters.
    #[serde(with = "document")]
    #[schemars(with = "Value")]
    pub parameters: String,
    /// JSON schema that the answer was asked in; null where there is none.
    #[serde(default, with = "document")]
    #[schemars(with = "Value")]
    pub answer_schema: Option<String>,
    /// The images that its messages name, to be kept with it; empty where a run is read.
    #[serde(skip)]
    pub images: Vec<StoredImage>,
}

/// The template that a run was asked with.
#[derive(
    Debug, Clone, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct StoredTemplate {
    /// Its file name; empty where it is not known.
    pub template: String,
    /// Its version, as it says itself; `None` for a draft.
    pub template_version: Option<String>,
    /// SHA-256 of its text.
    pub template_hash: String,
}

impl NewRun {
    /// The template it is asked with.
    #[must_use]
    pub fn template(&self) -> StoredTemplate {
        StoredTemplate {
            template: self.template.clone(),
            template_version: self.template_version.clone(),
            template_hash: self.template_hash.clone(),
        }
    }

    /// The key of the request; `None` if none is sent, or where not all of it is known.
    ///
    /// Two runs with the same key and sample are the same question: everything that the server is sent is the same.
    #[must_use]
    pub fn key(&self) -> Option<Key> {
        let json = |text: &str| serde_json::from_str::<Value>(text).ok();
        let schema = match &self.answer_schema {
            Some(text) => json(text)?,
            None => Value::Null,
        };
        let name = self
            .model
            .split_once('/')
            .map_or(self.model.as_str(), |(_, name)| name);
        Some(Key::digest(&json!({
            "address": self.address.as_ref()?,
            "dialect": self.dialect.as_ref()?,
            "model": name,
            "messages": json(&self.messages)?,
            "parameters": json(&self.parameters)?,
            "schema": schema,
        })))
    }
}

/// Origin of a run's answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Origin {
    /// This store's program asked a judge.
    #[default]
    Asked,
    /// The answer was published.
    Recorded,
    /// Another store's program asked a judge.
    Replayed,
}

nearmiss_record::named!(Origin, "origin");

/// A piece of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnswerPiece<'a> {
    /// Of the reasoning.
    Reasoning(&'a str),
    /// Of the answer itself.
    Answer(&'a str),
}

/// State of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum RunState {
    /// The answer is arriving.
    Running,
    /// The program ended while the answer was arriving.
    Interrupted,
    /// The answer is whole; it may still hold no verdict.
    Answered,
    /// The server cut the answer off: it ran into the token limit or a filter.
    Truncated,
    /// There is no whole answer.
    Failed,
    /// It was cancelled.
    Cancelled,
}

nearmiss_record::named!(RunState, "state");

/// Consumption of an answer, where known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Consumed {
    /// Tokens of the prompt, as the server counts.
    pub input_tokens: Option<u64>,
    /// Tokens of the answer, reasoning included, as the server counts.
    pub output_tokens: Option<u64>,
    /// Tokens of the reasoning, as the server counts.
    pub reasoning_tokens: Option<u64>,
    /// Prompt tokens that the server had cached.
    pub cached_tokens: Option<u64>,
    /// Cost in US dollars; null if unknown.
    pub cost_usd: Option<f64>,
    /// Time to the first token, milliseconds.
    pub first_chunk_ms: Option<u64>,
    /// Time to the end of the answer, milliseconds.
    pub duration_ms: Option<u64>,
}

/// Data known when a run ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ending {
    /// State of the run.
    pub state: RunState,
    /// Model that the server says has answered.
    pub model_returned: Option<String>,
    /// Why the server ended the answer.
    pub finish: Option<String>,
    /// What it says.
    #[serde(skip)]
    pub verdict: Option<ParsedAnswer>,
    /// How the verdict was read from the answer: strict or repaired, or why it could not be read.
    pub reading: Option<String>,
    /// Why asking failed.
    pub error: Option<String>,
    /// What it consumed.
    #[serde(flatten)]
    pub consumed: Consumed,
    /// Source of the price.
    pub price_source: Option<String>,
    /// Its claims about obstacles, where they were checked.
    #[serde(flatten)]
    pub claims: ClaimCounts,
}

impl Ending {
    /// An ending of which nothing more is known.
    #[must_use]
    pub fn bare(state: RunState) -> Self {
        Self {
            state,
            model_returned: None,
            finish: None,
            verdict: None,
            reading: None,
            error: None,
            consumed: Consumed::default(),
            price_source: None,
            claims: ClaimCounts::default(),
        }
    }
}

/// A run as it is kept. In JSON and in the database its fields, and those of its parts, are the columns of `runs`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Run {
    /// Number of the run in the store.
    #[serde(default, rename = "run", alias = "id")]
    pub id: RunId,
    /// When it began, milliseconds since 1970, UTC; of a recorded one, when it was read.
    pub created_ms: i64,
    /// Time of the last change, milliseconds since 1970, UTC.
    pub updated_ms: i64,
    /// Key of the request: SHA-256 of everything that is sent; null if nothing was sent.
    #[serde(default, deserialize_with = "claim::deserialize_key")]
    pub key: Option<Key>,
    /// Where the answer comes from: asked, recorded or replayed.
    pub origin: Origin,
    /// File that a recorded answer was read from.
    pub source: Option<String>,
    /// The question and its judge.
    #[serde(flatten)]
    pub question: NewRun,
    /// Text of the answer.
    pub answer: String,
    /// Reasoning of the model.
    pub reasoning: String,
    /// How it ended, or where it stands.
    #[serde(flatten)]
    pub ending: Ending,
    /// The structured verdict; null if there is none.
    // As it is kept, for programs that know more than [`Ending::verdict`] can say.
    #[serde(default, rename = "verdict", with = "document")]
    #[schemars(with = "Value")]
    pub verdict_json: Option<String>,
    /// Tools that the model called, by round: calls with id, name and arguments, and results in the same order;
    /// missing where none was called.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "document")]
    #[schemars(with = "Value")]
    pub tool_rounds: Option<String>,
    /// Maximum cost in US dollars; null if unknown when it was asked.
    #[serde(default)]
    pub most_usd: Option<f64>,
    /// Notes of a person.
    pub notes: String,
    /// Whether the run is protected from deletion.
    pub pinned: bool,
    /// Time of deletion, milliseconds since 1970, UTC; it can be restored.
    pub deleted_ms: Option<i64>,
}

impl Run {
    /// The same with its verdict read from [`Run::verdict_json`].
    pub(super) fn with_verdict(mut self) -> Self {
        let json = self.verdict_json.as_deref();
        self.ending.verdict = json.and_then(|json| serde_json::from_str(json).ok());
        self
    }
}
