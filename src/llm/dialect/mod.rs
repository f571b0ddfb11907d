//! The wire protocols: one file each writes the requests and reads the answers of one API.

mod anthropic;
mod body;
mod gemini;
mod ollama;
mod openai_chat;
mod openai_responses;

use std::fmt::Debug;

use reqwest::Url;
use serde::Deserialize;
use serde_json::Value;

use super::accumulator::ResponseAccumulator;
use super::endpoint::Endpoint;
use super::problem::Problem;
use super::request::Request;
pub(super) use body::Body;

/// An API that models are served over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dialect {
    /// OpenAI's chat completions, which most servers speak.
    #[default]
    #[serde(rename = "openai_chat")]
    OpenAiChat,
    /// OpenAI's Responses API.
    #[serde(rename = "openai_responses")]
    OpenAiResponses,
    /// Google's `generateContent`.
    Gemini,
    /// Anthropic's messages.
    Anthropic,
    /// Ollama's own `/api/chat`.
    Ollama,
}

/// How an API marks off the events of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Framing {
    /// Server-sent events.
    Events,
    /// A JSON object a line.
    Lines,
}

/// Which header carries the key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Auth {
    /// `Authorization: Bearer …`.
    #[serde(rename = "bearer")]
    Bearer,
    /// `x-api-key`, Anthropic's.
    #[serde(rename = "x-api-key")]
    ApiKey,
    /// `x-goog-api-key`, Google's.
    #[serde(rename = "x-goog-api-key")]
    GoogleApiKey,
}

impl Auth {
    /// Name of the header, and the word before the key.
    pub(super) fn header(self) -> (&'static str, &'static str) {
        match self {
            Self::Bearer => ("authorization", "Bearer "),
            Self::ApiKey => ("x-api-key", ""),
            Self::GoogleApiKey => ("x-goog-api-key", ""),
        }
    }
}

impl Dialect {
    /// Every dialect.
    pub const ALL: [Self; 5] = [
        Self::OpenAiChat,
        Self::OpenAiResponses,
        Self::Gemini,
        Self::Anthropic,
        Self::Ollama,
    ];

    /// The word for it in configuration files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenAiChat => "openai_chat",
            Self::OpenAiResponses => "openai_responses",
            Self::Gemini => "gemini",
            Self::Anthropic => "anthropic",
            Self::Ollama => "ollama",
        }
    }

    /// How its official clients send the key.
    #[must_use]
    pub fn auth(self) -> Auth {
        match self {
            Self::OpenAiChat | Self::OpenAiResponses | Self::Ollama => Auth::Bearer,
            Self::Gemini => Auth::GoogleApiKey,
            Self::Anthropic => Auth::ApiKey,
        }
    }

    /// Headers that every request carries.
    pub(super) fn headers(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Anthropic => &[("anthropic-version", anthropic::VERSION)],
            _ => &[],
        }
    }

    pub(super) fn framing(self) -> Framing {
        match self {
            Self::Ollama => Framing::Lines,
            _ => Framing::Events,
        }
    }

    /// The path of requests below a base path, which people write with and without version and method. Gemini's lacks the
    /// model, see [`Dialect::with_model`].
    pub(super) fn path(self, base: &str) -> String {
        let base = base.trim_end_matches('/');
        let method = match self {
            Self::OpenAiChat => "/chat/completions",
            Self::OpenAiResponses => "/responses",
            Self::Gemini => "/models",
            Self::Anthropic => "/messages",
            Self::Ollama => {
                let root = ["/api/chat", "/api", "/v1"]
                    .iter()
                    .find_map(|end| base.strip_suffix(end));
                return format!("{}/api/chat", root.unwrap_or(base));
            }
        };
        let root = base.strip_suffix(method).unwrap_or(base);
        let last = root.rsplit('/').next().unwrap_or_default();
        let versioned = last
            .strip_prefix('v')
            .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
        let whole = root.len() < base.len();
        let version = match self {
            _ if whole || versioned => "",
            // OpenAI's address ends in the version, so what has any path is taken to be whole.
            Self::OpenAiChat | Self::OpenAiResponses if !root.is_empty() => "",
            Self::Gemini => "/v1beta",
            _ => "/v1",
        };
        format!("{root}{version}{method}")
    }

    /// The address with the model, for the API that has it there.
    pub(super) fn with_model(self, mut url: Url, model: &str) -> Url {
        if self == Self::Gemini {
            let model = model.strip_prefix("models/").unwrap_or(model);
            if let Ok(mut segments) = url.path_segments_mut() {
                segments.push(&format!("{model}:streamGenerateContent"));
            }
            url.query_pairs_mut().append_pair("alt", "sse");
        }
        url
    }

    pub(super) fn body(self, endpoint: &Endpoint, request: &Request) -> Body {
        let mut body = Body::default();
        match self {
            Self::OpenAiChat => openai_chat::write(endpoint, request, &mut body),
            Self::OpenAiResponses => openai_responses::write(endpoint, request, &mut body),
            Self::Gemini => gemini::write(endpoint, request, &mut body),
            Self::Anthropic => anthropic::write(endpoint, request, &mut body),
            Self::Ollama => ollama::write(endpoint, request, &mut body),
        }
        body
    }

    pub(super) fn protocol(self) -> Box<dyn Protocol> {
        match self {
            Self::OpenAiChat => Box::new(openai_chat::Chat::default()),
            Self::OpenAiResponses => Box::new(openai_responses::Responses::default()),
            Self::Gemini => Box::new(gemini::Gemini),
            Self::Anthropic => Box::new(anthropic::Messages::default()),
            Self::Ollama => Box::new(ollama::Ollama),
        }
    }
}

/// The JSON body of a request, exactly as [`super::stream()`] sends it.
#[must_use]
pub fn body(endpoint: &Endpoint, request: &Request) -> Value {
    Value::Object(endpoint.dialect.body(endpoint, request).fields)
}

/// What of a request the endpoint's model does not take, and what is sent that nobody asked for; a sentence each.
#[must_use]
pub fn notes(endpoint: &Endpoint, request: &Request) -> Vec<String> {
    endpoint.dialect.body(endpoint, request).notes
}

/// The reading side of a dialect; one per answer.
pub(super) trait Protocol: Debug + Send {
    /// Whether the word `[DONE]` ends an answer.
    fn ends_with_word(&self) -> bool {
        false
    }

    /// Reads one event, a JSON object that reports no error.
    fn event(&mut self, value: &Value, answer: &mut ResponseAccumulator)
    -> Result<(), DecodeError>;

    /// Reads a whole answer that was not streamed.
    fn document(
        &mut self,
        value: &Value,
        answer: &mut ResponseAccumulator,
    ) -> Result<(), DecodeError>;
}

/// An event that is no part of an answer.
#[derive(Debug)]
pub(super) enum DecodeError {
    /// It is not of this dialect.
    Malformed(String),
    /// It reports an error.
    Provider(Problem),
}

impl DecodeError {
    fn no_answer(value: &Value) -> Self {
        Self::Malformed(format!("a document without an answer: `{value}`"))
    }
}

fn string<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    value.get(key)?.as_str().filter(|text| !text.is_empty())
}

fn count(value: &Value, pointer: &str) -> Option<u64> {
    let value = value.pointer(pointer)?;
    // Counts have been seen as 12.0.
    let whole = |n: &f64| *n >= 0.0 && n.fract() == 0.0;
    let float = || value.as_f64().filter(whole).map(|n| n as u64);
    value.as_u64().or_else(float)
}

#[cfg(test)]
#[path = "path_tests.rs"]
mod tests;
