//! What a wire protocol is: addresses, headers, bodies and how answers are read; and what several of them share.

use std::fmt::Debug;

use reqwest::Url;
use serde_json::{Value, json};

use super::super::accumulator::ResponseAccumulator;
use super::super::batch::BatchApi;
use super::super::endpoint::Endpoint;
use super::super::error::Error;
use super::super::request::Request;
use super::super::tool_calls::{ToolSpec, Toolbox};
use super::body::Body;
use super::kind::Auth;

/// One API on the wire: addresses, headers, bodies and how answers are read. Implementations do no I/O.
pub(in crate::llm) trait WireProtocol: Sync {
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
pub(in crate::llm) trait AnswerReader: Debug + Send {
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
pub(in crate::llm) enum Framing {
    /// Server-sent events.
    Events,
    /// A JSON object a line.
    Lines,
}

/// The texts under `key` of the selected entries of a list.
pub(super) fn names_in<'a>(
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
pub(super) fn is_anthropic_model(entry: &Value) -> bool {
    entry.get("type").and_then(Value::as_str) == Some("model")
}

/// The version that OpenAI's address lacks: it ends in the version, so a base with any path is taken to be whole.
pub(super) fn openai_version(root: &str) -> &'static str {
    if root.is_empty() { "/v1" } else { "" }
}

/// The names in a list of models as OpenAI has it.
pub(super) fn openai_models(list: &Value) -> Option<Vec<&str>> {
    let is_meant = |entry: &Value| !is_anthropic_model(entry) || entry.get("object").is_some();
    names_in(list.get("data")?, "id", is_meant)
}

/// Tools as OpenAI's chat and Ollama have them.
pub(super) fn function_tools(tools: &Toolbox) -> Value {
    let function = |spec: &ToolSpec| {
        json!({"type": "function", "function": {
            "name": spec.name, "description": spec.about, "parameters": spec.schema,
        }})
    };
    tools.specs.iter().map(function).collect()
}

pub(super) fn string<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    value.get(key)?.as_str().filter(|text| !text.is_empty())
}

pub(super) fn count(value: &Value, pointer: &str) -> Option<u64> {
    let value = value.pointer(pointer)?;
    // Counts have been seen as 12.0.
    let whole = |n: &f64| *n >= 0.0 && n.fract() == 0.0;
    let float = || value.as_f64().filter(whole).map(|n| n as u64);
    value.as_u64().or_else(float)
}
