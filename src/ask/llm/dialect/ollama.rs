//! Ollama's native chat API: one JSON object a line.

use serde::Serialize;
use serde_json::{Value, json};

use super::{
    AnswerReader, Framing, Notes, WireProtocol, count, function_tools, given, names_in, string,
};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::chunk::{ALTERNATIVES, Finish, Usage, tokens};
use crate::llm::endpoint::{Endpoint, ResponseFormat};
use crate::llm::error::Error;
use crate::llm::quirks::{Effort, Efforts};
use crate::llm::request::{Image, Request, Role, Schema};

/// Tokens kept free for the answer where no limit is set.
const ANSWER_RESERVE: u32 = 4096;

/// Context windows are asked for in steps of this, so that the model is not loaded anew for every question.
const STEP: u32 = 8192;

/// The body of a question.
#[derive(Serialize)]
struct Question<'a> {
    model: &'a str,
    messages: Vec<Value>,
    tools: Option<Value>,
    stream: bool,
    think: Option<Value>,
    logprobs: Option<bool>,
    top_logprobs: Option<u32>,
    format: Option<Value>,
    options: Value,
}

#[derive(Serialize)]
struct Options {
    temperature: Option<f64>,
    seed: Option<u64>,
    num_predict: Option<u32>,
    num_ctx: u32,
}

/// A turn of the conversation.
#[derive(Serialize)]
struct Said<'a> {
    role: Role,
    content: &'a str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    images: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tool_calls: Option<Vec<Value>>,
    #[serde(skip_serializing_if = "str::is_empty")]
    thinking: &'a str,
}

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

    fn body(&self, endpoint: &Endpoint, request: &Request, notes: &mut Notes) -> Value {
        let quirks = &endpoint.quirks;
        // It has no way to forbid calls but to offer no tools.
        let tools = request.offered().filter(|tools| tools.may_call);
        let style = quirks.efforts.unwrap_or(Efforts::Levels);
        let think = match request.parameters.effort {
            None => None,
            Some(_) if style == Efforts::Untaken => {
                notes.untaken("effort", "not supported by this model");
                None
            }
            Some(Effort::Off) => Some(false.into()),
            Some(_) if style == Efforts::Template => Some(true.into()),
            Some(effort) => Some(effort.name().into()),
        };
        let weighs = notes.log_probabilities(endpoint, request);
        // A form for the answer keeps the model from calling tools.
        let schema = request.schema_to_send(false);
        let limit = endpoint.answer_limit(&request.parameters);
        // A question longer than the window is cut without a word, so the window is made to fit.
        let needed = endpoint
            .tokens(request)
            .saturating_add(limit.unwrap_or(ANSWER_RESERVE));
        let window = needed.div_ceil(STEP).saturating_mul(STEP);
        given(Question {
            model: &request.model,
            messages: messages(request),
            tools: tools.map(function_tools),
            stream: true,
            think,
            logprobs: weighs.then_some(true),
            top_logprobs: weighs.then_some(ALTERNATIVES),
            format: match endpoint.response_format {
                ResponseFormat::Off => None,
                ResponseFormat::JsonObject => schema.map(|_| "json".into()),
                ResponseFormat::JsonSchema => schema.map(Schema::sent),
            },
            options: given(Options {
                temperature: notes.temperature(endpoint, request, 2.0),
                seed: notes.seed(endpoint, request),
                num_predict: limit,
                num_ctx: quirks.context.unwrap_or(window),
            }),
        })
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

/// The conversation with the rounds of calls so far; images are a list beside the text.
fn messages(request: &Request) -> Vec<Value> {
    let messages = request.messages.iter().map(|message| {
        json!(Said {
            role: message.role,
            content: &message.content,
            images: message.images.iter().map(Image::base64).collect(),
            tool_calls: None,
            thinking: "",
        })
    });
    let mut all: Vec<Value> = messages.collect();
    let rounds = request.offered().map_or(&[][..], |tools| &tools.rounds);
    for round in rounds {
        let calls = { round.turn.calls.iter() }
            .map(|call| json!({"function": {"name": call.name, "arguments": call.object()}}));
        all.push(json!(Said {
            role: Role::Assistant,
            content: &round.turn.text,
            images: Vec::new(),
            tool_calls: Some(calls.collect()),
            thinking: &round.turn.thought,
        }));
        all.extend(round.pairs().map(
            |(call, result)| json!({"role": "tool", "tool_name": call.name, "content": result}),
        ));
    }
    all
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
