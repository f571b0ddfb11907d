//! Ollama's own chat: a JSON object a line.

use serde_json::{Value, json};

use super::{Body, DecodeError, Protocol, count, string};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::chunk::{Finish, Usage};
use crate::llm::endpoint::{Endpoint, ResponseFormat};
use crate::llm::quirks::Efforts;
use crate::llm::request::{Effort, Request};
use crate::llm::schema::portable;

/// Tokens kept free for the answer where no limit is set.
const ROOM: u32 = 4096;

/// Context windows are asked for in steps of this, so that the model is not loaded anew for every question.
const STEP: u32 = 8192;

/// Writes the body of a request.
pub(super) fn write(endpoint: &Endpoint, request: &Request, out: &mut Body) {
    let quirks = &endpoint.quirks;
    out.put("model", json!(request.model));
    out.put("messages", json!(request.messages));
    out.put("stream", json!(true));
    let style = quirks.efforts.unwrap_or(Efforts::Levels);
    match request.parameters.effort {
        None => {}
        Some(_) if style == Efforts::Untaken => out.untaken("effort", "this model takes none"),
        Some(Effort::Off) => out.put("think", json!(false)),
        Some(_) if style == Efforts::Template => out.put("think", json!(true)),
        Some(effort) => out.put("think", json!(effort.name())),
    }
    if let Some(schema) = &request.schema {
        match endpoint.response_format {
            ResponseFormat::Off => {}
            ResponseFormat::JsonObject => out.put("format", json!("json")),
            ResponseFormat::JsonSchema => out.put("format", portable(&schema.schema)),
        }
    }
    let mut options = Body::default();
    options.temperature(endpoint, request, 2.0, |out, t| out.put("temperature", t));
    options.seed(endpoint, request, |out, seed| out.put("seed", seed));
    let limit = endpoint.answer_limit(&request.parameters);
    if let Some(limit) = limit {
        options.put("num_predict", json!(limit));
    }
    // A question longer than the window is cut without a word, so the window is made to fit.
    let needed = request.tokens().saturating_add(limit.unwrap_or(ROOM));
    let window = needed.div_ceil(STEP).saturating_mul(STEP);
    options.put("num_ctx", json!(quirks.context.unwrap_or(window)));
    out.put_inner("options", options);
}

/// The reader of this dialect.
#[derive(Debug, Default)]
pub(super) struct Ollama;

impl Protocol for Ollama {
    fn event(
        &mut self,
        value: &Value,
        answer: &mut ResponseAccumulator,
    ) -> Result<(), DecodeError> {
        answer.model(string(value, "model"));
        if let Some(message) = value.get("message") {
            answer.reason(string(message, "thinking").unwrap_or_default());
            answer.say(string(message, "content").unwrap_or_default());
        }
        if value.get("done").and_then(Value::as_bool) == Some(true) {
            answer.usage(Usage {
                input_tokens: count(value, "/prompt_eval_count"),
                output_tokens: count(value, "/eval_count"),
                ..Usage::default()
            });
            answer.finish(match string(value, "done_reason") {
                Some("stop") => Finish::Stop,
                Some("length") => Finish::Length,
                other => Finish::Other(other.unwrap_or("unstated").to_owned()),
            });
            answer.complete();
        }
        Ok(())
    }

    fn document(
        &mut self,
        value: &Value,
        answer: &mut ResponseAccumulator,
    ) -> Result<(), DecodeError> {
        if value.get("message").is_none() {
            return Err(DecodeError::no_answer(value));
        }
        self.event(value, answer)
    }
}
