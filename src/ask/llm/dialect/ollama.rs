//! Ollama's native chat API: one JSON object a line.

use serde_json::{Value, json};

use super::{
    AnswerReader, Body, Framing, WireProtocol, count, function_tools, names_in, protocol, string,
};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::chunk::{ALTERNATIVES, Finish, Usage, tokens};
use crate::llm::endpoint::{Endpoint, ResponseFormat};
use crate::llm::error::Error;
use crate::llm::quirks::{Effort, Efforts};
use crate::llm::request::Request;

/// Tokens kept free for the answer where no limit is set.
const ANSWER_RESERVE: u32 = 4096;

/// Context windows are asked for in steps of this, so that the model is not loaded anew for every question.
const STEP: u32 = 8192;

/// Ollama's own chat.
pub(super) struct Protocol;

impl WireProtocol for Protocol {
    fn framing(&self) -> Framing {
        Framing::Lines
    }

    /// An address as `OLLAMA_HOST` has it: perhaps without scheme or port, and perhaps the one the server listens on.
    fn base_url(&self, address: &str) -> String {
        let address = address.trim();
        let (scheme, rest) = address.split_once("://").unwrap_or(("http", address));
        // A query stays as it is.
        let end = rest.find(['/', '?', '#']).unwrap_or(rest.len());
        let (host, path) = rest.split_at(end);
        let bracketed = host.rfind(']').unwrap_or(0);
        let has_port = host.rfind(':').is_some_and(|colon| colon > bracketed);
        let port = if has_port || address.contains("://") {
            ""
        } else {
            ":11434"
        };
        let host = match host.strip_prefix("0.0.0.0") {
            Some(rest) => format!("127.0.0.1{rest}"),
            None => host.to_owned(),
        };
        format!("{scheme}://{host}{port}{path}")
    }

    fn method(&self) -> &'static str {
        "/api/chat"
    }

    fn path(&self, base: &str) -> String {
        let base = base.trim_end_matches('/');
        let root = [self.method(), "/api", "/v1"]
            .iter()
            .find_map(|end| base.strip_suffix(end));
        format!("{}{}", root.unwrap_or(base), self.method())
    }

    fn write(&self, endpoint: &Endpoint, request: &Request, out: &mut Body) {
        let quirks = &endpoint.quirks;
        out.put("model", json!(request.model));
        out.put("messages", messages(request));
        // It has no way to forbid calls but to offer no tools.
        if let Some(tools) = request.offered().filter(|tools| tools.may_call) {
            out.put("tools", function_tools(tools));
        }
        out.put("stream", json!(true));
        let style = quirks.efforts.unwrap_or(Efforts::Levels);
        match request.parameters.effort {
            None => {}
            Some(_) if style == Efforts::Untaken => {
                out.untaken("effort", "not supported by this model")
            }
            Some(Effort::Off) => out.put("think", json!(false)),
            Some(_) if style == Efforts::Template => out.put("think", json!(true)),
            Some(effort) => out.put("think", json!(effort.name())),
        }
        out.log_probabilities(endpoint, request, |out| {
            out.put("logprobs", json!(true));
            out.put("top_logprobs", json!(ALTERNATIVES));
        });
        // A form for the answer keeps the model from calling tools.
        if let Some(schema) = request.schema_to_send(false) {
            match endpoint.response_format {
                ResponseFormat::Off => {}
                ResponseFormat::JsonObject => out.put("format", json!("json")),
                ResponseFormat::JsonSchema => out.put("format", schema.sent()),
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
        let needed = endpoint
            .tokens(request)
            .saturating_add(limit.unwrap_or(ANSWER_RESERVE));
        let window = needed.div_ceil(STEP).saturating_mul(STEP);
        options.put("num_ctx", json!(quirks.context.unwrap_or(window)));
        out.put_inner("options", options);
    }

    fn reader(&self) -> Box<dyn AnswerReader> {
        Box::new(OllamaReader)
    }

    fn models_path(&self) -> &'static str {
        "/api/tags"
    }

    fn models<'a>(&self, list: &'a Value) -> Option<Vec<&'a str>> {
        names_in(list.get("models")?, "name", |_| true)
    }
}

/// The conversation with the rounds of calls so far.
fn messages(request: &Request) -> Value {
    let mut all: Vec<Value> = request.messages.iter().map(protocol::ollama).collect();
    let rounds = request.offered().map_or(&[][..], |tools| &tools.rounds);
    for round in rounds {
        let calls = round
            .turn
            .calls
            .iter()
            .map(|call| json!({"function": {"name": call.name, "arguments": call.object()}}));
        let mut said = json!({
            "role": "assistant", "content": round.turn.text, "tool_calls": calls.collect::<Vec<_>>(),
        });
        if !round.turn.thought.is_empty() {
            said["thinking"] = json!(round.turn.thought);
        }
        all.push(said);
        all.extend(round.pairs().map(
            |(call, result)| json!({"role": "tool", "tool_name": call.name, "content": result}),
        ));
    }
    json!(all)
}

/// Calls, which come whole.
fn calls(message: &Value, answer: &mut ResponseAccumulator) {
    let list = message.get("tool_calls").and_then(Value::as_array);
    for call in list.into_iter().flatten() {
        let Some(function) = call.get("function") else {
            continue;
        };
        let number = answer.calls();
        let id = string(call, "id").unwrap_or_default();
        answer.call(number, id, string(function, "name").unwrap_or_default());
        match function.get("arguments") {
            Some(Value::String(text)) => answer.complete_call(number, text),
            Some(whole) => answer.complete_call(number, &whole.to_string()),
            None => {}
        }
    }
}

/// The reader of its answers.
#[derive(Debug, Default)]
struct OllamaReader;

impl AnswerReader for OllamaReader {
    fn event(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        answer.model(string(value, "model"));
        if let Some(message) = value.get("message") {
            answer.tokens(tokens(value.get("logprobs")));
            answer.reason(string(message, "thinking").unwrap_or_default());
            answer.push_text(string(message, "content").unwrap_or_default());
            calls(message, answer);
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

    fn document(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        if value.get("message").is_none() {
            return Err(answer.no_answer(value));
        }
        self.event(value, answer)
    }
}
