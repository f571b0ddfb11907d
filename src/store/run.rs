//! The stored data of a run.

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{ClaimCounts, Key, StoredImage, claim};
use nearmiss_scene::verdict::{ParsedAnswer, Task};

/// Identifies a run in its store.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize,
)]
pub struct RunId(pub i64);

impl std::fmt::Display for RunId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// Data known before a judge is asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NewRun {
    /// Which of several answers to the same request this is, from 0.
    pub sample: u32,
    /// The batch it belongs to.
    pub batch: Option<String>,
    /// Name of the scenario.
    pub scenario: String,
    /// SHA-256 of its file, hexadecimal; `None` if an answer is known and the file is not.
    pub scenario_hash: Option<String>,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// The task.
    pub task: Task,
    /// From where the scene is described.
    pub frame: String,
    /// Prompting techniques in use.
    pub techniques: String,
    /// First and last time step of the window; `None` if an answer is known and its window is not.
    pub window: Option<(i64, i64)>,
    /// `provider/model`, as asked for.
    pub model: String,
    /// The provider of the model.
    pub provider: String,
    /// The protocol spoken; `None` if no request is sent.
    pub dialect: Option<String>,
    /// Provider and address of the server, for people, without any key.
    pub endpoint: String,
    /// The address alone, without user, password and query; `None` if no request is sent.
    pub address: Option<String>,
    /// File name of the template.
    pub template: String,
    /// Its version, as it says itself; `None` for a draft.
    pub template_version: Option<String>,
    /// SHA-256 of its text.
    pub template_hash: String,
    /// The messages as JSON.
    pub messages: String,
    /// The parameters as JSON.
    pub parameters: String,
    /// The shape of the answer that is asked of the server, as JSON.
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
        let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).ok();
        let schema = match &self.answer_schema {
            Some(text) => json(text)?,
            None => serde_json::Value::Null,
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Origin {
    /// This store's program asked a judge.
    #[default]
    Asked,
    /// The answer was published.
    Recorded,
    /// Another store's program asked a judge.
    Replayed,
}

/// A piece of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnswerPiece<'a> {
    /// Of the reasoning.
    Reasoning(&'a str),
    /// Of the answer itself.
    Answer(&'a str),
}

/// State of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
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

/// Words for the variants of an enum, in the store, in exports and on the command line.
macro_rules! names {
    ($type:ident, $($variant:ident => $name:literal),+) => {
        impl $type {
            /// Every one.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The word for it.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }

            /// The one that this word is for.
            #[must_use]
            pub fn parse(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|one| one.name() == name)
            }
        }

        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let word: String = serde::Deserialize::deserialize(deserializer)?;
                let unknown = || format!("`{word}` is not known to this version");
                Self::parse(&word).ok_or_else(|| serde::de::Error::custom(unknown()))
            }
        }
    };
}
pub(super) use names;

names!(Origin, Asked => "asked", Recorded => "recorded", Replayed => "replayed");
names!(RunState, Running => "running", Interrupted => "interrupted", Answered => "answered",
    Truncated => "truncated", Failed => "failed", Cancelled => "cancelled");

/// Consumption of an answer, where known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Consumed {
    /// Tokens of the question.
    pub input_tokens: Option<u64>,
    /// Tokens of the answer, reasoning included.
    pub output_tokens: Option<u64>,
    /// Those that were reasoning.
    pub reasoning_tokens: Option<u64>,
    /// Those of the question that the server had in its cache.
    pub cached_tokens: Option<u64>,
    /// US dollars; [`Ending::price_source`] says whose figure.
    pub cost_usd: Option<f64>,
    /// Milliseconds to the first piece.
    pub first_chunk_ms: Option<u64>,
    /// Milliseconds to the end.
    pub duration_ms: Option<u64>,
}

/// Data known when a run ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ending {
    /// Where it stands now.
    pub state: RunState,
    /// The model as the server named it.
    pub model_returned: Option<String>,
    /// Why the model stopped.
    pub finish: Option<String>,
    /// What it says.
    #[serde(skip)]
    pub verdict: Option<ParsedAnswer>,
    /// How the verdict was read, or why there is none.
    pub reading: Option<String>,
    /// Why there is no answer.
    pub error: Option<String>,
    /// What it consumed.
    #[serde(flatten)]
    pub consumed: Consumed,
    /// Where the cost comes from.
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Its number.
    #[serde(default)]
    pub id: RunId,
    /// When it began, milliseconds since 1970, UTC; of a recorded one, when it was read.
    pub created_ms: i64,
    /// When it was last changed.
    pub updated_ms: i64,
    /// The key that it was kept under, see [`NewRun::key`].
    #[serde(default, deserialize_with = "claim::deserialize_key")]
    pub key: Option<Key>,
    /// Where its answer comes from.
    pub origin: Origin,
    /// The file that a recorded answer was read from.
    pub source: Option<String>,
    /// The question and its judge.
    #[serde(flatten)]
    pub question: NewRun,
    /// The answer's text.
    pub answer: String,
    /// The reasoning's text.
    pub reasoning: String,
    /// How it ended, or where it stands.
    #[serde(flatten)]
    pub ending: Ending,
    /// The verdict as it is kept, for programs that know more than [`Ending::verdict`] can say.
    #[serde(rename = "verdict")]
    pub verdict_json: Option<String>,
    /// Rounds of tool calls with their results, a JSON array; nothing where no tool was called.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_rounds: Option<String>,
    /// The most that it can have cost, US dollars, where that was known when it was asked.
    #[serde(default)]
    pub most_usd: Option<f64>,
    /// What a person wrote about it.
    pub notes: String,
    /// Whether it is kept from deletion.
    pub pinned: bool,
    /// When it was deleted; it can be restored.
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
