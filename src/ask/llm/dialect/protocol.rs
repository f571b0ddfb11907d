//! What a wire protocol is: addresses, headers, bodies, images and how answers are read; and what several of them share.

use std::fmt::Debug;

use reqwest::Url;
use serde::Serialize;
use serde_json::{Value, json};

use super::super::accumulator::ResponseAccumulator;
use super::super::batch::BatchApi;
use super::super::endpoint::Endpoint;
use super::super::error::Error;
use super::super::request::{Request, ToolSpec, Toolbox};
use super::{Auth, Dialect};
use crate::llm::quirks::{Effort, LogProbabilities, Temperature};
use crate::llm::request::{Message, Role};

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

    /// The body of a request; notes say what could not go in.
    fn body(&self, endpoint: &Endpoint, request: &Request, notes: &mut Notes) -> Value;

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

/// A JSON object of the fields that have a value; null where none has.
pub(super) fn given(fields: impl Serialize) -> Value {
    let mut json = serde_json::to_value(fields).unwrap_or_default();
    if let Value::Object(all) = &mut json {
        all.retain(|_, value| !value.is_null());
        if all.is_empty() {
            return Value::Null;
        }
    }
    json
}

/// What people should know about a body.
#[derive(Debug, Default)]
pub(in crate::llm) struct Notes(pub Vec<String>);

impl Notes {
    pub fn note(&mut self, text: &str) {
        self.0.push(text.to_owned());
    }

    /// Something that was asked for and cannot be sent.
    pub fn untaken(&mut self, what: &str, why: &str) {
        self.0.push(format!("{what} is not sent: {why}"));
    }

    /// The temperature, if one is asked for and the model takes it; `most` is the highest the API takes.
    pub fn temperature(
        &mut self,
        endpoint: &Endpoint,
        request: &Request,
        most: f64,
    ) -> Option<f64> {
        let temperature = request.parameters.temperature?;
        let thinks = request.parameters.effort != Some(Effort::Off);
        match endpoint.quirks.temperature {
            Temperature::Fixed if temperature != 1.0 => {
                self.untaken("temperature", "this model accepts only 1");
            }
            Temperature::NotThinking if thinks => self.untaken(
                "temperature",
                "no effect while this model thinks, which it does unless effort is off",
            ),
            _ if temperature > most => {
                self.untaken("temperature", &format!("this API accepts 0 to {most}"));
            }
            _ => return Some(temperature),
        }
        None
    }

    /// Whether log probabilities are asked for and the model gives them.
    pub fn log_probabilities(&mut self, endpoint: &Endpoint, request: &Request) -> bool {
        if !request.parameters.log_probabilities {
            return false;
        }
        let thinks = request.parameters.effort != Some(Effort::Off);
        match endpoint.quirks.log_probabilities {
            LogProbabilities::Given => return true,
            LogProbabilities::NotThinking if !thinks => return true,
            LogProbabilities::NotThinking => self.untaken(
                "log_probabilities",
                "this model gives them only with effort off",
            ),
            LogProbabilities::Withheld => {
                self.untaken("log_probabilities", "this model gives none");
            }
        }
        false
    }

    /// The seed, if one is asked for and the model takes it.
    pub fn seed(&mut self, endpoint: &Endpoint, request: &Request) -> Option<u64> {
        let seed = request.parameters.seed?;
        if !endpoint.quirks.seed {
            self.untaken("seed", "not documented by this provider");
        }
        endpoint.quirks.seed.then_some(seed)
    }
}

/// The JSON body of a request, exactly as [`crate::llm::stream()`] sends it.
#[must_use]
pub fn body(endpoint: &Endpoint, request: &Request) -> Value {
    let endpoint = &*endpoint.for_request(request);
    let protocol = endpoint.dialect.protocol();
    protocol.body(endpoint, request, &mut Notes::default())
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
    endpoint.dialect != Dialect::Anthropic && Notes::default().log_probabilities(endpoint, request)
}

/// Parts of a request the endpoint's model does not accept, and parameters sent unrequested; one sentence each.
#[must_use]
pub fn notes(endpoint: &Endpoint, request: &Request) -> Vec<String> {
    let endpoint = &*endpoint.for_request(request);
    let mut notes = Notes::default();
    endpoint
        .dialect
        .protocol()
        .body(endpoint, request, &mut notes);
    notes.0
}

/// OpenAI's chat: the content is a list of parts, images as data addresses.
pub(super) fn chat(message: &Message) -> Value {
    parts(
        message,
        |text| json!({"type": "text", "text": text}),
        |image| json!({"type": "image_url", "image_url": {"url": image.data_url()}}),
    )
}

/// OpenAI's Responses API: parts of input, with the detail that the API would choose anyway.
pub(super) fn responses(message: &Message) -> Value {
    parts(
        message,
        |text| json!({"type": "input_text", "text": text}),
        |image| json!({"type": "input_image", "image_url": image.data_url(), "detail": "auto"}),
    )
}

/// Anthropic's messages: content blocks, images before the text that asks about them.
pub(super) fn anthropic(message: &Message) -> Value {
    parts(
        message,
        |text| json!({"type": "text", "text": text}),
        |image| {
            json!({"type": "image", "source": {
                "type": "base64", "media_type": image.media_type, "data": image.base64(),
            }})
        },
    )
}

/// The parts of a message in Gemini's form.
pub(super) fn gemini(message: &Message) -> Value {
    let images = message
        .images
        .iter()
        .map(|image| json!({"inlineData": {"mimeType": image.media_type, "data": image.base64()}}));
    let text = json!({"text": message.content});
    images.chain([text]).collect()
}

fn text(message: &Message) -> Value {
    json!({"role": message.role, "content": message.content})
}

/// The images, and then the text.
fn parts(
    message: &Message,
    text_part: impl Fn(&str) -> Value,
    image_part: impl Fn(&crate::llm::request::Image) -> Value,
) -> Value {
    // Only the user shows images.
    if message.images.is_empty() || message.role != Role::User {
        return text(message);
    }
    let images = message.images.iter().map(image_part);
    let content: Vec<Value> = images.chain([text_part(&message.content)]).collect();
    json!({"role": message.role, "content": content})
}
