//! A request to a language model: messages, parameters, and the schema of the answer.

use serde::{Deserialize, Serialize};

use super::effort::Effort;
use super::image::{Image, ImageTokens};
use super::portable_schema::{bounded, portable};
use super::tool_calls::{ToolLimits, Toolbox};

/// Author of a [`Message`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Standing instructions.
    System,
    /// The question.
    User,
    /// An answer of the model, given as an example or as history.
    Assistant,
}

impl Role {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::System => "system",
            Self::User => "user",
            Self::Assistant => "assistant",
        }
    }
}

/// One turn of the conversation.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Message {
    /// Who speaks.
    pub role: Role,
    /// The message as plain text.
    pub content: String,
    /// Images that are shown with it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub images: Vec<Image>,
}

impl Message {
    /// A message without images.
    #[must_use]
    pub fn new(role: Role, content: impl Into<String>) -> Self {
        Self {
            role,
            content: content.into(),
            images: Vec::new(),
        }
    }

    /// The message for people: its text, and a line for each image.
    #[must_use]
    pub fn in_words(&self) -> String {
        let image = |image: &Image| format!("\n\n[picture: {image:?}]");
        let images: String = self.images.iter().map(image).collect();
        self.content.clone() + &images
    }
}

/// The JSON schema an answer has to follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Schema {
    /// A name for the server's error texts; letters, digits, `_` and `-` are kept on the wire.
    pub name: String,
    /// The JSON Schema document itself.
    pub schema: serde_json::Value,
    /// Whether its bounds are sent, and bounds of all texts and lists: not every API takes them.
    pub is_bounded: bool,
}

impl Schema {
    /// The document as it is sent.
    pub(super) fn sent(&self) -> serde_json::Value {
        if self.is_bounded {
            bounded(&self.schema)
        } else {
            portable(&self.schema)
        }
    }
}

/// Sampling parameters; what is `None` is not sent, so the server's own default holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Parameters {
    /// Sampling temperature, without unit; most servers take 0 to 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<f64>,
    /// Most tokens the answer may have, reasoning included where the server counts it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_tokens: Option<u32>,
    /// Seed of the sampling, for servers that are reproducible.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How much the model is to reason before it answers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<Effort>,
    /// Whether the log probabilities of the answer's tokens are asked for.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub log_probabilities: bool,
    /// Whether the model may call tools, and how often.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tools: Option<ToolLimits>,
}

/// One question to one model.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// The model's name as the server knows it (without our provider prefix).
    pub model: String,
    /// The conversation so far, oldest first.
    pub messages: Vec<Message>,
    /// Sampling parameters.
    pub parameters: Parameters,
    /// The shape wanted of the answer; see [`super::ResponseFormat`] for what is sent of it.
    pub schema: Option<Schema>,
    /// The tools that the model may call, with the rounds of calls so far.
    pub tools: Option<Toolbox>,
}

impl Request {
    /// Tokens of the question, estimated to be rather too many than too few: half of the bytes. Numbers, which scenes
    /// in words are full of, are two to three bytes a token. Images count as the endpoint's documentation says, and
    /// turns that called tools as `answer` tokens at most, the most that an answer may have.
    #[must_use]
    pub fn tokens(&self, counted: ImageTokens, answer: Option<u32>) -> u32 {
        let messages: usize = self.messages.iter().map(|m| m.content.len() + 16).sum();
        let schema = self
            .schema
            .as_ref()
            .map_or(0, |s| s.schema.to_string().len());
        let tools = self.tools.as_ref().map_or(0, |tools| tools.bytes(answer));
        let words = u32::try_from((messages + schema + tools) / 2).unwrap_or(u32::MAX);
        let images = self.images().map(|i| counted.of(i.width, i.height));
        images.fold(words, u32::saturating_add)
    }

    /// Every image of the conversation.
    pub fn images(&self) -> impl Iterator<Item = &Image> {
        self.messages.iter().flat_map(|message| &message.images)
    }

    /// Whether the model may call tools now.
    pub(super) fn may_call(&self) -> bool {
        self.tools.as_ref().is_some_and(|tools| tools.may_call)
    }

    /// The tools, where the request has some.
    pub(super) fn offered(&self) -> Option<&Toolbox> {
        self.tools.as_ref().filter(|tools| !tools.specs.is_empty())
    }

    /// The schema to send; `beside_tools` says whether the server takes one while the model may call tools.
    pub(super) fn schema_to_send(&self, beside_tools: bool) -> Option<&Schema> {
        let wanted = beside_tools || !self.may_call();
        self.schema.as_ref().filter(|_| wanted)
    }
}
