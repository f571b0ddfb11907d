//! Google's Gemini: `streamGenerateContent`, where thoughts are ordinary parts and the stream has no end marker.

use reqwest::Url;
use serde_json::{Map, Value, json};

use super::{AnswerReader, Auth, Body, WireProtocol, count, names_in, protocol, string};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::batch::{BatchApi, GeminiBatches};
use crate::llm::chunk::{ALTERNATIVES, Finish, Token, Usage};
use crate::llm::endpoint::{Endpoint, ResponseFormat};
use crate::llm::error::Error;
use crate::llm::quirks::{Effort, Efforts};
use crate::llm::request::{Request, Role, ToolRound, ToolSpec, Toolbox};

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

    fn write(&self, endpoint: &Endpoint, request: &Request, out: &mut Body) {
        let quirks = &endpoint.quirks;
        let part = |text: &String| json!({"text": text});
        let of = |role| request.messages.iter().filter(move |m| m.role == role);
        let system: Vec<_> = of(Role::System).map(|m| part(&m.content)).collect();
        if !system.is_empty() {
            out.put("systemInstruction", json!({"parts": system}));
        }
        let turns = request
            .messages
            .iter()
            .filter(|m| m.role != Role::System)
            .map(|m| {
                let role = match m.role {
                    Role::Assistant => "model",
                    Role::System | Role::User => "user",
                };
                json!({"role": role, "parts": protocol::gemini(m)})
            });
        let mut contents: Vec<Value> = turns.collect();
        if let Some(tools) = request.offered() {
            contents.extend(tools.rounds.iter().flat_map(round));
            let form = endpoint.response_format != ResponseFormat::Off;
            match (tools.may_call, form && request.schema.is_some()) {
                (true, _) => out.put("tools", declarations(tools)),
                // Functions are refused beside a form, even where none may be called.
                (false, true) => {}
                (false, false) => {
                    out.put("tools", declarations(tools));
                    let none = json!({"functionCallingConfig": {"mode": "NONE"}});
                    out.put("toolConfig", none);
                }
            }
        }
        out.put("contents", json!(contents));

        let mut config = Body::default();
        config.temperature(endpoint, request, 2.0, |out, t| out.put("temperature", t));
        if let Some(limit) = request.parameters.max_tokens.or(quirks.max_tokens) {
            config.put("maxOutputTokens", json!(limit));
        }
        config.seed(endpoint, request, |out, seed| out.put("seed", seed));
        config.log_probabilities(endpoint, request, |config| {
            config.put("responseLogprobs", json!(true));
            config.put("logprobs", json!(ALTERNATIVES));
        });
        thinking(endpoint, request.parameters.effort, &mut config);
        // Models before Gemini 3 refuse a form for the answer beside tools.
        if let Some(schema) = request.schema_to_send(false) {
            if endpoint.response_format != ResponseFormat::Off {
                config.put("responseMimeType", json!("application/json"));
            }
            if endpoint.response_format == ResponseFormat::JsonSchema {
                config.put("responseJsonSchema", schema.sent());
            }
        }
        out.put_inner("generationConfig", config);
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

/// The tools.
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
    if echo.iter().any(|part| part.get("functionCall").is_some()) {
    } else {
        parts.extend(
            round
                .turn
                .calls
                .iter()
                .map(|call| json!({"functionCall": {"name": call.name, "args": call.object()}})),
        )
    }
    let results = round.pairs().map(|(call, result)| {
        let result: Value = serde_json::from_str(result).unwrap_or_else(|_| json!(result));
        let mut response = json!({"name": call.name, "response": {"result": result}});
        if !call.id.starts_with("call_") {
            response["id"] = json!(call.id);
        }
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

fn thinking(endpoint: &Endpoint, effort: Option<Effort>, config: &mut Body) {
    let mut thinking = Map::new();
    let style = endpoint.quirks.efforts.unwrap_or(Efforts::Levels);
    let wanted = effort.map_or(endpoint.quirks.reasoning, |effort| effort != Effort::Off);
    if wanted && style != Efforts::Untaken {
        thinking.insert("includeThoughts".into(), json!(true));
    }
    match (style, effort) {
        (_, None) => {}
        (Efforts::Levels, Some(Effort::Off)) => {
            thinking.insert("thinkingLevel".into(), json!("MINIMAL"));
            config.note("effort off: this model's lowest level is minimal, which is sent");
        }
        (Efforts::Levels, Some(effort)) => {
            let level = effort.name().to_uppercase();
            thinking.insert("thinkingLevel".into(), json!(level));
        }
        (Efforts::Budget, Some(Effort::Off)) => {
            thinking.insert("thinkingBudget".into(), json!(0));
        }
        (Efforts::Budget, Some(effort)) => {
            thinking.insert("thinkingBudget".into(), json!(-1));
            config.note(&format!(
                "effort {}: this model has no levels and chooses its own effort",
                effort.name()
            ));
        }
        (_, Some(_)) => config.untaken("effort", "not supported by this model"),
    }
    if !thinking.is_empty() {
        config.put("thinkingConfig", Value::Object(thinking));
    }
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
