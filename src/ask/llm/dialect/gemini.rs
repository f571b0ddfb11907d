//! Google's Gemini: `streamGenerateContent`, where thoughts are ordinary parts and the stream has no end marker.

use reqwest::Url;
use serde::Serialize;
use serde_json::{Value, json};

use super::{AnswerReader, Auth, Notes, WireProtocol, count, given, names_in, protocol, string};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::batch::{BatchApi, GeminiBatches};
use crate::llm::chunk::{ALTERNATIVES, Finish, Token, Usage};
use crate::llm::endpoint::{Endpoint, ResponseFormat};
use crate::llm::error::Error;
use crate::llm::quirks::{Effort, Efforts};
use crate::llm::request::{Request, Role, Schema, ToolRound, ToolSpec, Toolbox};

/// The body of a question.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Question {
    system_instruction: Option<Value>,
    tools: Option<Value>,
    tool_config: Option<Value>,
    contents: Vec<Value>,
    generation_config: Value,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct GenerationConfig {
    temperature: Option<f64>,
    max_output_tokens: Option<u32>,
    seed: Option<u64>,
    response_logprobs: Option<bool>,
    logprobs: Option<u32>,
    thinking_config: Value,
    response_mime_type: Option<&'static str>,
    response_json_schema: Option<Value>,
}

#[derive(Default, Serialize)]
#[serde(rename_all = "camelCase")]
struct Thinking {
    include_thoughts: Option<bool>,
    thinking_level: Option<String>,
    thinking_budget: Option<i32>,
}

/// The result of a call; ids are those that the server gave.
#[derive(Serialize)]
struct Returned<'a> {
    name: &'a str,
    response: Value,
    id: Option<&'a str>,
}

/// Google's Gemini.
pub(super) struct Protocol;

impl WireProtocol for Protocol {
    fn auth(&self) -> Auth {
        Auth::GoogleApiKey
    }

    fn method(&self) -> &'static str {
        "/models"
    }

    fn version(&self, _root: &str) -> &'static str {
        "/v1beta"
    }

    fn with_model(&self, mut url: Url, model: &str) -> Url {
        let model = model.strip_prefix("models/").unwrap_or(model);
        if let Ok(mut segments) = url.path_segments_mut() {
            segments.push(&format!("{model}:streamGenerateContent"));
        }
        url.query_pairs_mut().append_pair("alt", "sse");
        url
    }

    fn body(&self, endpoint: &Endpoint, request: &Request, notes: &mut Notes) -> Value {
        let of = |role| request.messages.iter().filter(move |m| m.role == role);
        let part = |text: &String| json!({"text": text});
        let system: Vec<_> = of(Role::System).map(|m| part(&m.content)).collect();
        let others = request.messages.iter().filter(|m| m.role != Role::System);
        let turns = others.map(|m| {
            let role = match m.role {
                Role::Assistant => "model",
                Role::System | Role::User => "user",
            };
            json!({"role": role, "parts": protocol::gemini(m)})
        });
        let tools = request.offered();
        let rounds = tools.into_iter().flat_map(|tools| &tools.rounds);
        let form = endpoint.response_format != ResponseFormat::Off && request.schema.is_some();
        // Functions are refused beside a form, even where none may be called.
        let declared = tools.filter(|tools| tools.may_call || !form);
        let forbidden = declared.filter(|tools| !tools.may_call);
        let temperature = notes.temperature(endpoint, request, 2.0);
        let seed = notes.seed(endpoint, request);
        let weighs = notes.log_probabilities(endpoint, request);
        // Models before Gemini 3 refuse a form for the answer beside tools.
        let schema = request.schema_to_send(false);
        let (asked, exact) = match endpoint.response_format {
            ResponseFormat::Off => (None, None),
            ResponseFormat::JsonObject => (schema, None),
            ResponseFormat::JsonSchema => (schema, schema),
        };
        given(Question {
            system_instruction: (!system.is_empty()).then(|| json!({"parts": system})),
            tools: declared.map(declarations),
            tool_config: forbidden.map(|_| json!({"functionCallingConfig": {"mode": "NONE"}})),
            contents: turns.chain(rounds.flat_map(round)).collect(),
            generation_config: given(GenerationConfig {
                temperature,
                max_output_tokens: request.parameters.max_tokens.or(endpoint.quirks.max_tokens),
                seed,
                response_logprobs: weighs.then_some(true),
                logprobs: weighs.then_some(ALTERNATIVES),
                thinking_config: given(thinking(endpoint, request.parameters.effort, notes)),
                response_mime_type: asked.map(|_| "application/json"),
                response_json_schema: exact.map(Schema::sent),
            }),
        })
    }

    fn reader(&self) -> Box<dyn AnswerReader> {
        Box::new(GeminiReader)
    }

    fn models<'a>(&self, list: &'a Value) -> Option<Vec<&'a str>> {
        names_in(list.get("models")?, "name", |_| true)
    }

    fn batches(&self) -> Option<&'static dyn BatchApi> {
        Some(&GeminiBatches)
    }
}

fn declarations(tools: &Toolbox) -> Value {
    let one = |spec: &ToolSpec| {
        json!({
            "name": spec.name, "description": spec.about, "parametersJsonSchema": spec.schema,
        })
    };
    let all: Vec<Value> = tools.specs.iter().map(one).collect();
    json!([{"functionDeclarations": all}])
}

/// A turn of the model and the results of its calls: its parts as they came, since some are signed.
fn round(round: &ToolRound) -> [Value; 2] {
    let mut parts = Vec::new();
    let echo = &round.turn.echo;
    let is_thought = |part: &Value| part.get("thought").and_then(Value::as_bool) == Some(true);
    let signed = echo.iter().filter(|part| !is_thought(part));
    let signed: String = signed.filter_map(|part| string(part, "text")).collect();
    // Signed text comes last, and is among the parts.
    let spoken = &round.turn.text;
    let text = spoken.strip_suffix(signed.as_str()).unwrap_or(spoken);
    if !text.is_empty() {
        parts.push(json!({"text": text}));
    }
    parts.extend(echo.iter().cloned());
    if !echo.iter().any(|part| part.get("functionCall").is_some()) {
        let calls = round.turn.calls.iter();
        parts.extend(
            calls.map(|call| json!({"functionCall": {"name": call.name, "args": call.object()}})),
        );
    }
    let results = round.pairs().map(|(call, result)| {
        let result = serde_json::from_str(result).unwrap_or_else(|_| Value::from(result));
        let response = given(Returned {
            name: &call.name,
            response: json!({"result": result}),
            id: (!call.id.starts_with("call_")).then_some(&call.id),
        });
        json!({"functionResponse": response})
    });
    let results: Vec<Value> = results.collect();
    [
        json!({"role": "model", "parts": parts}),
        json!({"role": "user", "parts": results}),
    ]
}

/// A call, which comes whole.
fn call(function: &Value, answer: &mut ResponseAccumulator) {
    let number = answer.calls();
    let id = string(function, "id").unwrap_or_default();
    answer.call(number, id, string(function, "name").unwrap_or_default());
    let arguments = function.get("args").filter(|args| args.is_object());
    answer.complete_call(number, &arguments.map_or("{}".into(), Value::to_string));
}

fn thinking(endpoint: &Endpoint, effort: Option<Effort>, notes: &mut Notes) -> Thinking {
    let style = endpoint.quirks.efforts.unwrap_or(Efforts::Levels);
    let wanted = effort.map_or(endpoint.quirks.reasoning, |effort| effort != Effort::Off);
    let mut thinking = Thinking {
        include_thoughts: (wanted && style != Efforts::Untaken).then_some(true),
        ..Thinking::default()
    };
    match (style, effort) {
        (_, None) => {}
        (Efforts::Levels, Some(Effort::Off)) => {
            thinking.thinking_level = Some("MINIMAL".into());
            notes.note("effort off: this model's lowest level is minimal, which is sent");
        }
        (Efforts::Levels, Some(effort)) => {
            thinking.thinking_level = Some(effort.name().to_uppercase());
        }
        (Efforts::Budget, Some(Effort::Off)) => thinking.thinking_budget = Some(0),
        (Efforts::Budget, Some(effort)) => {
            thinking.thinking_budget = Some(-1);
            notes.note(&format!(
                "effort {}: this model has no levels and chooses its own effort",
                effort.name()
            ));
        }
        (_, Some(_)) => notes.untaken("effort", "not supported by this model"),
    }
    thinking
}

/// The reader of its answers.
#[derive(Debug, Default)]
struct GeminiReader;

impl AnswerReader for GeminiReader {
    fn event(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        answer.model(string(value, "modelVersion"));
        if let Some(usage) = value.get("usageMetadata").filter(|u| u.is_object()) {
            answer.usage(usage_of(usage));
        }
        let blocked = value.pointer("/promptFeedback/blockReason");
        let candidates = value.get("candidates").and_then(Value::as_array);
        let candidate = candidates.and_then(|list| {
            let first = |c: &&Value| c.get("index").and_then(Value::as_u64).unwrap_or(0) == 0;
            list.iter().find(first)
        });
        let Some(candidate) = candidate else {
            if let Some(reason) = blocked.and_then(Value::as_str) {
                answer.finish(Finish::Blocked(reason.to_owned()));
                answer.complete();
            }
            return Ok(());
        };
        answer.tokens(tokens(candidate));
        let parts = candidate.pointer("/content/parts");
        for part in parts.and_then(Value::as_array).into_iter().flatten() {
            let text = string(part, "text").unwrap_or_default();
            let function = part.get("functionCall");
            let before = answer.calls();
            if let Some(function) = function {
                call(function, answer);
            }
            if function.is_some() && answer.calls() == before {
                // There are too many: a call without a result must not be sent again.
                continue;
            }
            if function.is_some() || part.get("thoughtSignature").is_some() {
                answer.echo(part.clone());
            }
            if part.get("thought").and_then(Value::as_bool) == Some(true) {
                answer.reason(text);
            } else {
                answer.push_text(text);
            }
        }
        if let Some(reason) = string(candidate, "finishReason") {
            // There is no other end marker; usage may still follow.
            answer.finish(finish(reason));
        }
        Ok(())
    }

    fn document(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        // Without `alt=sse` the events come as one list.
        let one = std::slice::from_ref(value);
        let events = value.as_array().map_or(one, Vec::as_slice);
        let known = |v: &Value| v.get("candidates").is_some() || v.get("promptFeedback").is_some();
        if !events.iter().any(known) {
            return Err(answer.no_answer(value));
        }
        events
            .iter()
            .try_for_each(|event| self.event(event, answer))
    }
}

/// The tokens of a candidate, each with those that might have been in its place.
fn tokens(candidate: &Value) -> Vec<Token> {
    let list = |pointer| candidate.pointer(pointer).and_then(Value::as_array);
    let chosen = list("/logprobsResult/chosenCandidates")
        .into_iter()
        .flatten();
    let top = list("/logprobsResult/topCandidates");
    let pair = |entry: &Value| {
        let text = entry.get("token").and_then(Value::as_str);
        let log = entry.get("logProbability").and_then(Value::as_f64);
        (text.map(str::to_owned), log)
    };
    let token = |(i, entry): (usize, &Value)| {
        let others = top.and_then(|all| all.get(i)?.get("candidates")?.as_array());
        let (text, log) = pair(entry);
        Token::new(
            (text.as_deref(), log),
            others.into_iter().flatten().map(pair),
        )
    };
    chosen.enumerate().filter_map(token).collect()
}

fn finish(reason: &str) -> Finish {
    match reason {
        "STOP" => Finish::Stop,
        "MAX_TOKENS" => Finish::Length,
        "SAFETY" | "RECITATION" | "BLOCKLIST" | "PROHIBITED_CONTENT" | "SPII" => {
            Finish::ContentFilter
        }
        other => Finish::Other(other.to_owned()),
    }
}

fn usage_of(usage: &Value) -> Usage {
    let count = |pointer| count(usage, pointer);
    let sum = |a: Option<u64>, b: Option<u64>| match (a, b) {
        (None, None) => None,
        (a, b) => Some(a.unwrap_or(0).saturating_add(b.unwrap_or(0))),
    };
    let thoughts = count("/thoughtsTokenCount");
    Usage {
        input_tokens: sum(
            count("/promptTokenCount"),
            count("/toolUsePromptTokenCount"),
        ),
        // The candidates' count leaves the thoughts out, which are paid for as output.
        output_tokens: sum(count("/candidatesTokenCount"), thoughts),
        reasoning_tokens: thoughts,
        cached_tokens: count("/cachedContentTokenCount"),
        cache_write_tokens: None,
        cost: None,
    }
}
