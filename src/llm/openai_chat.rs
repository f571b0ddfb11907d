//! The OpenAI chat protocol, as OpenAI and nearly everybody else speaks it: the request body and the decoder of the answer.

use serde_json::{Map, Value, json};

use super::chunk::{Chunk, Finish, Usage};
use super::endpoint::{Endpoint, ResponseFormat};
use super::error::{Error, Place};
use super::problem::Problem;
use super::request::{Request, Schema};
use super::think::{Part, Splitter};

/// The JSON body of a request. Everything the request states is in it, nothing is dropped to please a server.
pub fn body(endpoint: &Endpoint, request: &Request) -> Value {
    let mut body = Map::new();
    body.insert("model".into(), json!(request.model));
    body.insert("messages".into(), json!(request.messages));
    body.insert("stream".into(), json!(true));
    body.insert("stream_options".into(), json!({"include_usage": true}));
    let parameters = &request.parameters;
    if let Some(temperature) = parameters.temperature {
        body.insert("temperature".into(), json!(temperature));
    }
    if let Some(limit) = parameters.max_tokens {
        // OpenAI's reasoning models refuse the old name; most other servers know no other.
        let name = if is_openai(endpoint) {
            "max_completion_tokens"
        } else {
            "max_tokens"
        };
        body.insert(name.into(), json!(limit));
    }
    if let Some(seed) = parameters.seed {
        body.insert("seed".into(), json!(seed));
    }
    if let Some(format) = request
        .schema
        .as_ref()
        .and_then(|s| response_format(endpoint.response_format, s))
    {
        body.insert("response_format".into(), format);
    }
    Value::Object(body)
}

fn is_openai(endpoint: &Endpoint) -> bool {
    let url = endpoint.chat_url().ok();
    let host = url.as_ref().and_then(|u| u.host_str()).unwrap_or_default();
    host == "api.openai.com" || host.ends_with(".api.openai.com")
}

fn response_format(format: ResponseFormat, schema: &Schema) -> Option<Value> {
    match format {
        ResponseFormat::Off => None,
        ResponseFormat::JsonObject => Some(json!({"type": "json_object"})),
        ResponseFormat::JsonSchema => {
            let fits = |c: char| {
                if c.is_ascii_alphanumeric() || matches!(c, '_' | '-') {
                    c
                } else {
                    '_'
                }
            };
            let name: String = schema.name.chars().map(fits).take(64).collect();
            Some(
                json!({"type": "json_schema", "json_schema": {"name": name, "strict": true, "schema": schema.schema}}),
            )
        }
    }
}

/// Turns the events of one answer into chunks. Knows nothing of the network.
#[derive(Debug)]
pub(super) struct Decoder {
    place: Place,
    model: Option<String>,
    started: bool,
    done: bool,
    finish: Option<Finish>,
    refusal: String,
    usage: Option<Usage>,
    content: Splitter,
    /// The one field reasoning is read from: some servers send the same text in two.
    reasoning_field: Option<&'static str>,
    received: usize,
}

impl Decoder {
    /// A decoder for one answer from that place.
    pub fn new(place: Place) -> Self {
        Self {
            place,
            model: None,
            started: false,
            done: false,
            finish: None,
            refusal: String::new(),
            usage: None,
            content: Splitter::default(),
            reasoning_field: None,
            received: 0,
        }
    }

    /// Whether the answer is complete and nothing more needs to be read.
    pub fn is_done(&self) -> bool {
        self.done
    }

    /// The data of one event.
    ///
    /// # Errors
    /// [`Error::Malformed`] if it is no JSON object, [`Error::Provider`] if it reports an error.
    pub fn event(&mut self, data: &str) -> Result<Vec<Chunk>, Error> {
        let data = data.trim();
        if self.done || data.is_empty() {
            return Ok(Vec::new());
        }
        if data == "[DONE]" {
            return Ok(self.complete());
        }
        let value = serde_json::from_str(data)
            .map_err(|_| self.malformed(format!("the event `{data}`")))?;
        self.value(&value)
    }

    /// The data of an event that the server itself named `error`.
    pub fn error_event(&mut self, data: &str) -> Error {
        self.provider(Problem::in_body(data))
    }

    /// A whole answer in one JSON document, from a server that does not stream.
    ///
    /// # Errors
    /// As [`Decoder::event`]; [`Error::Truncated`] if the document ends in the middle.
    pub fn document(&mut self, body: &str) -> Result<Vec<Chunk>, Error> {
        let value: Value = serde_json::from_str(body).map_err(|e| {
            if e.is_eof() {
                Error::Truncated {
                    place: self.place.clone(),
                    received: 0,
                    why: "the document is incomplete".into(),
                }
            } else {
                self.malformed(format!("`{body}`"))
            }
        })?;
        let mut chunks = self.value(&value)?;
        if choice(&value).is_none() {
            return Err(self.malformed(format!("a document without an answer: `{body}`")));
        }
        chunks.extend(self.complete());
        Ok(chunks)
    }

    /// The body is over, for the reason given. It is a success all the same if the model had said that it was finished.
    pub fn ended(
        &mut self,
        cause: impl FnOnce(Place, usize) -> Error,
    ) -> Vec<Result<Chunk, Error>> {
        if self.done {
            Vec::new()
        } else if self.finish.is_some() {
            self.complete().into_iter().map(Ok).collect()
        } else {
            let rest = self.rest();
            let error = cause(self.place.clone(), self.received);
            self.with_error(rest, error)
        }
    }

    /// The answer failed: what was held back, then the error.
    pub fn failed(&mut self, error: Error) -> Vec<Result<Chunk, Error>> {
        let rest = self.rest();
        self.with_error(rest, error)
    }

    fn with_error(&mut self, rest: Vec<Chunk>, error: Error) -> Vec<Result<Chunk, Error>> {
        self.done = true;
        rest.into_iter().map(Ok).chain([Err(error)]).collect()
    }

    fn value(&mut self, value: &Value) -> Result<Vec<Chunk>, Error> {
        if let Some(problem) = Problem::in_value(value) {
            return Err(self.provider(problem));
        }
        if !value.is_object() {
            return Err(self.malformed(format!("the event `{value}`")));
        }
        if self.model.is_none() {
            self.model = string(value, "model").map(str::to_owned);
        }
        if let Some(usage) = value.get("usage").filter(|u| u.is_object()) {
            // Some servers repeat it with every event, always counting from the beginning: the last one holds.
            self.usage = Some(read_usage(usage));
        }
        let mut chunks = Vec::new();
        if let Some(choice) = choice(value) {
            self.choice(choice, &mut chunks);
        }
        Ok(self.opened(chunks))
    }

    fn choice(&mut self, choice: &Value, chunks: &mut Vec<Chunk>) {
        let message = || choice.get("message").filter(|_| self.received == 0);
        if let Some(delta) = choice
            .get("delta")
            .filter(|d| d.is_object())
            .or_else(message)
        {
            self.reasoning(delta, chunks);
            match delta.get("content") {
                Some(Value::String(text)) => self.said(text, chunks),
                Some(Value::Array(parts)) => parts.iter().for_each(|part| self.part(part, chunks)),
                _ => {}
            }
            if let Some(refusal) = string(delta, "refusal") {
                self.received += refusal.chars().count();
                self.refusal.push_str(refusal);
            }
        }
        if let Some(reason) = string(choice, "finish_reason") {
            self.finish = Some(match reason {
                "stop" | "eos" | "end_turn" => Finish::Stop,
                "length" | "max_tokens" | "model_length" => Finish::Length,
                "content_filter" => Finish::ContentFilter,
                other => Finish::Other(other.to_owned()),
            });
        }
    }

    fn reasoning(&mut self, delta: &Value, chunks: &mut Vec<Chunk>) {
        for field in ["reasoning_content", "reasoning", "reasoning_details"] {
            if self.reasoning_field.is_some_and(|chosen| chosen != field) {
                continue;
            }
            let text = match delta.get(field) {
                Some(Value::String(text)) => text.clone(),
                Some(Value::Array(details)) => details
                    .iter()
                    .filter_map(|d| string(d, "text").or_else(|| string(d, "summary")))
                    .collect(),
                _ => String::new(),
            };
            if !text.is_empty() {
                self.reasoning_field = Some(field);
                self.received += text.chars().count();
                chunks.push(Chunk::Reasoning(text));
                return;
            }
        }
    }

    /// One part of a content that is a list, as Mistral sends it.
    fn part(&mut self, part: &Value, chunks: &mut Vec<Chunk>) {
        match part.get("thinking") {
            Some(Value::String(text)) => self.sort([Part::Thought(text.clone())], chunks),
            Some(Value::Array(inner)) => {
                let text = inner.iter().filter_map(|p| string(p, "text")).collect();
                self.sort([Part::Thought(text)], chunks);
            }
            _ => self.said(string(part, "text").unwrap_or_default(), chunks),
        }
    }

    fn said(&mut self, text: &str, chunks: &mut Vec<Chunk>) {
        let parts = self.content.push(text);
        self.sort(parts, chunks);
    }

    fn sort(&mut self, parts: impl IntoIterator<Item = Part>, chunks: &mut Vec<Chunk>) {
        for part in parts {
            let (text, chunk): (_, fn(String) -> Chunk) = match part {
                // Already received through a field of its own.
                Part::Thought(_) if self.reasoning_field.is_some() => continue,
                Part::Thought(text) => (text, Chunk::Reasoning),
                Part::Said(text) => (text, Chunk::Text),
            };
            if !text.is_empty() {
                self.received += text.chars().count();
                chunks.push(chunk(text));
            }
        }
    }

    /// Puts `Started` before the first chunk. The first event may not name the model yet, so it waits for a name or a chunk.
    fn opened(&mut self, mut chunks: Vec<Chunk>) -> Vec<Chunk> {
        if !self.started && (self.model.is_some() || !chunks.is_empty()) {
            self.started = true;
            chunks.insert(
                0,
                Chunk::Started {
                    model: self.model.clone(),
                },
            );
        }
        chunks
    }

    /// What is held back: text that might have become a tag, and the usage.
    fn rest(&mut self) -> Vec<Chunk> {
        let mut chunks = Vec::new();
        let parts = self.content.end();
        self.sort(parts, &mut chunks);
        chunks.extend(self.usage.take().map(Chunk::Usage));
        self.opened(chunks)
    }

    fn complete(&mut self) -> Vec<Chunk> {
        self.done = true;
        let mut chunks = self.rest();
        let finish = match self.finish.take() {
            Some(Finish::Stop) | None if !self.refusal.is_empty() => {
                Finish::Refusal(std::mem::take(&mut self.refusal))
            }
            Some(finish) => finish,
            None => Finish::Other("unstated".into()),
        };
        chunks.push(Chunk::Finished(finish));
        self.opened(chunks)
    }

    fn malformed(&self, what: String) -> Error {
        Error::Malformed {
            place: self.place.clone(),
            what,
        }
    }

    fn provider(&self, problem: Problem) -> Error {
        Error::Provider {
            place: self.place.clone(),
            code: problem.code.or(problem.kind),
            message: problem.message,
        }
    }
}

/// The only choice asked for; the index may be missing, and the list empty.
fn choice(value: &Value) -> Option<&Value> {
    let choices = value.get("choices")?.as_array()?;
    choices
        .iter()
        .find(|c| c.get("index").and_then(Value::as_u64).unwrap_or(0) == 0)
}

fn string<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    value.get(key)?.as_str().filter(|text| !text.is_empty())
}

fn read_usage(usage: &Value) -> Usage {
    let count = |pointer: &str| {
        let value = usage.pointer(pointer)?;
        // Counts have been seen as 12.0.
        value.as_u64().or_else(|| {
            value
                .as_f64()
                .filter(|n| *n >= 0.0 && n.fract() == 0.0)
                .map(|n| n as u64)
        })
    };
    Usage {
        input_tokens: count("/prompt_tokens"),
        output_tokens: count("/completion_tokens"),
        reasoning_tokens: count("/completion_tokens_details/reasoning_tokens"),
        // The second is DeepSeek's name.
        cached_tokens: count("/prompt_tokens_details/cached_tokens")
            .or_else(|| count("/prompt_cache_hit_tokens")),
        cost: usage
            .get("cost")
            .and_then(Value::as_f64)
            .filter(|c| c.is_finite() && *c >= 0.0),
    }
}

#[cfg(test)]
#[path = "openai_chat_tests.rs"]
mod tests;
