//! The wire protocols: each is a file with its [`WireProtocol`] and a row of the table of [`Dialect`].

mod anthropic;
mod anthropic_blocks;
mod body;
mod gemini;
mod images;
mod ollama;
mod openai_chat;
mod openai_responses;
mod reasoning_details;
mod responses_items;

use std::fmt::Debug;

use reqwest::Url;
use serde::Deserialize;
use serde_json::{Value, json};

use super::accumulator::ResponseAccumulator;
use super::batch::BatchApi;
use super::endpoint::Endpoint;
use super::error::Error;
use super::request::Request;
use super::tool_calls::{ToolSpec, Toolbox};
pub(super) use body::Body;

/// Makes [`Dialect`] of a table: variant, name in configuration files, implementation.
macro_rules! dialects {
    ($($(#[$meta:meta])* $variant:ident = $name:literal: $protocol:path;)*) => {
        /// An API that models are served over.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Deserialize)]
        pub enum Dialect {
            $($(#[$meta])* #[serde(rename = $name)] $variant,)*
        }

        impl Dialect {
            /// Every dialect.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The word for it in configuration files.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            pub(super) fn protocol(self) -> &'static dyn WireProtocol {
                match self {
                    $(Self::$variant => &$protocol,)*
                }
            }
        }
    };
}

dialects! {
    /// OpenAI's chat completions, which most servers speak.
    #[default]
    OpenAiChat = "openai_chat": openai_chat::Protocol;
    /// OpenAI's Responses API.
    OpenAiResponses = "openai_responses": openai_responses::Protocol;
    /// Google's `generateContent`.
    Gemini = "gemini": gemini::Protocol;
    /// Anthropic's messages.
    Anthropic = "anthropic": anthropic::Protocol;
    /// Ollama's own `/api/chat`.
    Ollama = "ollama": ollama::Protocol;
}

impl Dialect {
    /// How its official clients send the key.
    #[must_use]
    pub fn auth(self) -> Auth {
        self.protocol().auth()
    }
}

/// One API on the wire: addresses, headers, bodies and how answers are read. Implementations do no I/O.
pub(super) trait WireProtocol: Sync {
    /// How its official clients send the key.
    fn auth(&self) -> Auth {
        Auth::Bearer
    }

    /// Headers that every request carries.
    fn headers(&self) -> &'static [(&'static str, &'static str)] {
        &[]
    }

    /// How the events of a streamed answer are marked off.
    fn framing(&self) -> Framing {
        Framing::Events
    }

    /// The base URL that an address in the configuration or the environment means.
    fn base_url(&self, address: &str) -> String {
        address.to_owned()
    }

    /// The path of questions below the API's root, without the model.
    fn method(&self) -> &'static str;

    /// The version that a root path without one lacks.
    fn version(&self, _root: &str) -> &'static str {
        "/v1"
    }

    /// The path of requests below a base path, which may be written with or without version and method.
    fn path(&self, base: &str) -> String {
        let (base, method) = (base.trim_end_matches('/'), self.method());
        let root = base.strip_suffix(method).unwrap_or(base);
        let last = root.rsplit('/').next().unwrap_or_default();
        let versioned = last
            .strip_prefix('v')
            .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
        let version = if root.len() < base.len() || versioned {
            ""
        } else {
            self.version(root)
        };
        format!("{root}{version}{method}")
    }

    /// The address of a question; APIs that name the model there add it.
    fn with_model(&self, url: Url, _model: &str) -> Url {
        url
    }

    /// Writes the body of a request.
    fn write(&self, endpoint: &Endpoint, request: &Request, out: &mut Body);

    /// The body of a request, with notes on what could not go in.
    fn body(&self, endpoint: &Endpoint, request: &Request) -> Body {
        let mut body = Body::default();
        self.write(endpoint, request, &mut body);
        body
    }

    /// A reader for one answer.
    fn reader(&self) -> Box<dyn AnswerReader>;

    /// The path of the list of models, in the place of [`WireProtocol::method`].
    fn models_path(&self) -> &'static str {
        "/models"
    }

    /// The names in a list of models; `None` for another document.
    fn models<'a>(&self, list: &'a Value) -> Option<Vec<&'a str>>;

    /// Its batches; `None` if it has none.
    fn batches(&self) -> Option<&'static dyn BatchApi> {
        None
    }
}

/// Reads the events of one answer, or a whole one.
pub(super) trait AnswerReader: Debug + Send {
    /// Whether the word `[DONE]` ends an answer.
    fn ends_with_word(&self) -> bool {
        false
    }

    /// Reads one event, a JSON object that reports no error.
    fn event(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error>;

    /// Reads a whole answer that was not streamed.
    fn document(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error>;
}

/// How an API separates the events of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Framing {
    /// Server-sent events.
    Events,
    /// A JSON object a line.
    Lines,
}

/// The header that carries the key.
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

/// The JSON body of a request, exactly as [`super::stream()`] sends it.
#[must_use]
pub fn body(endpoint: &Endpoint, request: &Request) -> Value {
    let endpoint = &*endpoint.for_request(request);
    Value::Object(endpoint.dialect.protocol().body(endpoint, request).fields)
}

/// Whether a request carries the form of its answer: some servers take none while tools may be called.
#[must_use]
pub fn sends_form(endpoint: &Endpoint, request: &Request) -> bool {
    let with = Request {
        messages: Vec::new(),
        ..request.clone()
    };
    let without = Request {
        schema: None,
        ..with.clone()
    };
    body(endpoint, &with) != body(endpoint, &without)
}

/// Whether a request asks for log probabilities, and the endpoint's model gives them.
#[must_use]
pub fn gives_log_probabilities(endpoint: &Endpoint, request: &Request) -> bool {
    let endpoint = &*endpoint.for_request(request);
    let wanted = request.parameters.log_probabilities;
    wanted && endpoint.dialect != Dialect::Anthropic && {
        let mut asked = Body::default();
        asked.log_probabilities(endpoint, request, |out| out.put("asked", Value::Null));
        !asked.fields.is_empty()
    }
}

/// Parts of a request the endpoint's model does not accept, and parameters sent unrequested; one sentence each.
#[must_use]
pub fn notes(endpoint: &Endpoint, request: &Request) -> Vec<String> {
    let endpoint = &*endpoint.for_request(request);
    endpoint.dialect.protocol().body(endpoint, request).notes
}

/// The texts under `key` of the selected entries of a list.
fn names_in<'a>(
    list: &'a Value,
    key: &str,
    is_meant: impl Fn(&Value) -> bool,
) -> Option<Vec<&'a str>> {
    let entries = list.as_array()?.iter().filter(|entry| is_meant(entry));
    Some(
        entries
            .filter_map(|entry| entry.get(key)?.as_str())
            .collect(),
    )
}

/// Whether an entry of a list of models is in Anthropic's form: several protocols list their models at the same path.
fn is_anthropic_model(entry: &Value) -> bool {
    entry.get("type").and_then(Value::as_str) == Some("model")
}

/// The version that OpenAI's address lacks: it ends in the version, so a base with any path is taken to be whole.
fn openai_version(root: &str) -> &'static str {
    if root.is_empty() { "/v1" } else { "" }
}

/// The names in a list of models as OpenAI has it.
fn openai_models(list: &Value) -> Option<Vec<&str>> {
    let is_meant = |entry: &Value| !is_anthropic_model(entry) || entry.get("object").is_some();
    names_in(list.get("data")?, "id", is_meant)
}

/// Tools as OpenAI's chat and Ollama have them.
fn function_tools(tools: &Toolbox) -> Value {
    let function = |spec: &ToolSpec| {
        json!({"type": "function", "function": {
            "name": spec.name, "description": spec.about, "parameters": spec.schema,
        }})
    };
    tools.specs.iter().map(function).collect()
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
