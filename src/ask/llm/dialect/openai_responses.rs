//! OpenAI's Responses API: items instead of choices, named events, reasoning summaries, calls of tools.

use serde::Serialize;
use serde_json::{Value, json};

use super::{
    AnswerReader, Notes, WireProtocol, count, given, openai_models, openai_version, protocol,
    string,
};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::batch::{BatchApi, OpenAiBatches};
use crate::llm::chunk::{ALTERNATIVES, Finish, Usage, tokens};
use crate::llm::endpoint::{Endpoint, ResponseFormat};
use crate::llm::error::Error;
use crate::llm::error_body::ErrorBody;
use crate::llm::portable_schema::name;
use crate::llm::quirks::{Effort, Efforts};
use crate::llm::request::{Request, ToolCall, ToolSpec, Toolbox};

/// The body of a question.
#[derive(Serialize)]
struct Question<'a> {
    model: &'a str,
    input: Value,
    tools: Option<Value>,
    tool_choice: Option<&'static str>,
    stream: bool,
    store: bool,
    temperature: Option<f64>,
    max_output_tokens: Option<u32>,
    top_logprobs: Option<u32>,
    include: Option<Vec<&'static str>>,
    reasoning: Value,
    text: Option<Value>,
}

#[derive(Serialize)]
struct Reasoning {
    effort: Option<&'static str>,
    summary: Option<&'static str>,
}

/// OpenAI's Responses API.
pub(super) struct Protocol;

impl WireProtocol for Protocol {
    fn method(&self) -> &'static str {
        "/responses"
    }

    fn version(&self, root: &str) -> &'static str {
        openai_version(root)
    }

    fn body(&self, endpoint: &Endpoint, request: &Request, notes: &mut Notes) -> Value {
        let (quirks, parameters) = (&endpoint.quirks, &request.parameters);
        // A model that does not reason refuses the questions for a summary and for its thoughts.
        let effort = parameters
            .effort
            .filter(|_| quirks.efforts != Some(Efforts::Untaken));
        let thinks = effort != Some(Effort::Off) && (quirks.reasoning || effort.is_some());
        let tools = request.offered();
        let temperature = notes.temperature(endpoint, request, 2.0);
        if parameters.seed.is_some() {
            notes.untaken("seed", "not supported by the Responses API");
        }
        let weighs = notes.log_probabilities(endpoint, request);
        if parameters.effort != effort {
            notes.untaken("effort", "not supported by this model");
        }
        // Nothing is kept by the server, so its thoughts come along and go back.
        let thoughts = (thinks && tools.is_some()).then_some("reasoning.encrypted_content");
        let weights = weighs.then_some("message.output_text.logprobs");
        let include: Vec<_> = thoughts.into_iter().chain(weights).collect();
        let word = |effort| match effort {
            Effort::Off => "none",
            effort => effort.name(),
        };
        let schema = request.schema_to_send(true);
        let format = match endpoint.response_format {
            ResponseFormat::Off => None,
            ResponseFormat::JsonObject => schema.map(|_| json!({"type": "json_object"})),
            ResponseFormat::JsonSchema => schema.map(|schema| {
                json!({
                    "type": "json_schema", "name": name(&schema.name), "strict": true,
                    "schema": schema.sent(),
                })
            }),
        };
        given(Question {
            model: &request.model,
            input: input(request),
            tools: tools.map(flat_tools),
            tool_choice: tools.filter(|tools| !tools.may_call).map(|_| "none"),
            stream: true,
            // The server need not keep what the local store keeps anyway.
            store: false,
            temperature,
            max_output_tokens: parameters.max_tokens.or(quirks.max_tokens),
            top_logprobs: weighs.then_some(ALTERNATIVES),
            include: (!include.is_empty()).then_some(include),
            reasoning: given(Reasoning {
                effort: effort.map(word),
                summary: thinks.then_some("auto"),
            }),
            text: format.map(|format| json!({"format": format})),
        })
    }

    fn reader(&self) -> Box<dyn AnswerReader> {
        Box::new(ResponsesReader::default())
    }

    fn models<'a>(&self, list: &'a Value) -> Option<Vec<&'a str>> {
        openai_models(list)
    }

    fn batches(&self) -> Option<&'static dyn BatchApi> {
        Some(&OpenAiBatches {
            endpoint: "/v1/responses",
        })
    }
}

/// The reader of its answers.
#[derive(Debug, Default)]
struct ResponsesReader {
    /// The one kind of event reasoning is read from: some servers send the text and its summary.
    reasoning_from: Option<&'static str>,
}

const SUMMARY: &str = "response.reasoning_summary_text.delta";
const RAW: &str = "response.reasoning_text.delta";

impl AnswerReader for ResponsesReader {
    fn event(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        let delta = string(value, "delta").unwrap_or_default();
        match string(value, "type") {
            Some("response.output_text.delta") => {
                answer.tokens(tokens(value.get("logprobs")));
                answer.push_text(delta);
            }
            Some("response.refusal.delta") => answer.refuse(delta),
            Some("response.function_call_arguments.delta") => {
                answer.call_arguments(output_index(value), delta);
            }
            Some("response.output_item.added") => begun(value, answer),
            Some("response.output_item.done") => done(value, answer),
            Some("response.reasoning_summary_text.delta") => self.reason(SUMMARY, delta, answer),
            Some("response.reasoning_text.delta") => self.reason(RAW, delta, answer),
            Some("response.reasoning_summary_part.added") => {
                let later = value.get("summary_index").and_then(Value::as_u64) > Some(0);
                if later && self.reasoning_from == Some(SUMMARY) {
                    answer.reason("\n\n");
                }
            }
            Some(
                "response.created"
                | "response.in_progress"
                | "response.completed"
                | "response.incomplete"
                | "response.failed",
            ) => {
                if let Some(response) = value.get("response") {
                    return self.response(response, answer);
                }
            }
            // Events that repeat what the deltas said.
            _ => {}
        }
        Ok(())
    }

    fn document(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        if !value.get("output").is_some_and(Value::is_array) {
            return Err(answer.no_answer(value));
        }
        self.response(value, answer)
    }
}

impl ResponsesReader {
    fn reason(&mut self, from: &'static str, text: &str, answer: &mut ResponseAccumulator) {
        if *self.reasoning_from.get_or_insert(from) == from {
            answer.reason(text);
        }
    }

    /// The response object, complete once its status says so.
    fn response(
        &mut self,
        response: &Value,
        answer: &mut ResponseAccumulator,
    ) -> Result<(), Error> {
        answer.model(string(response, "model"));
        if let Some(usage) = response.get("usage").filter(|u| u.is_object()) {
            answer.usage(usage_of(usage));
        }
        match string(response, "status") {
            Some("completed") => answer.finish(Finish::Stop),
            Some("incomplete") => {
                let reason = response.pointer("/incomplete_details/reason");
                answer.finish(match reason.and_then(Value::as_str) {
                    Some("max_output_tokens") => Finish::Length,
                    Some("content_filter") => Finish::ContentFilter,
                    other => Finish::Other(other.unwrap_or("incomplete").to_owned()),
                });
            }
            Some("failed" | "cancelled") => {
                let failed = ErrorBody {
                    message: "the answer failed without a reason".into(),
                    ..ErrorBody::default()
                };
                return Err(answer.reported(ErrorBody::in_value(response).unwrap_or(failed)));
            }
            _ => return Ok(()),
        }
        if answer.received() == 0 {
            self.output(response, answer);
        }
        if answer.calls() == 0 {
            read_calls(response, answer);
        }
        answer.complete();
        Ok(())
    }

    /// The text of the output items, for servers that did not stream it.
    fn output(&mut self, response: &Value, answer: &mut ResponseAccumulator) {
        let list = |value: &Value, key: &str| {
            let items = value.get(key).and_then(Value::as_array);
            items.cloned().unwrap_or_default()
        };
        for item in list(response, "output") {
            if string(&item, "type") == Some("function_call") {
                continue;
            }
            if string(&item, "type") == Some("reasoning") {
                let summary = list(&item, "summary");
                let texts: Vec<_> = summary.iter().filter_map(|s| string(s, "text")).collect();
                if texts.is_empty() {
                    let content = list(&item, "content");
                    let texts = content.iter().filter_map(|c| string(c, "text"));
                    texts.for_each(|text| answer.reason(text));
                } else {
                    answer.reason(&texts.join("\n\n"));
                }
                continue;
            }
            for part in list(&item, "content") {
                answer.tokens(tokens(part.get("logprobs")));
                answer.push_text(string(&part, "text").unwrap_or_default());
                answer.refuse(string(&part, "refusal").unwrap_or_default());
            }
        }
    }
}

fn usage_of(usage: &Value) -> Usage {
    let count = |pointer| count(usage, pointer);
    Usage {
        input_tokens: count("/input_tokens"),
        output_tokens: count("/output_tokens"),
        reasoning_tokens: count("/output_tokens_details/reasoning_tokens"),
        cached_tokens: count("/input_tokens_details/cached_tokens"),
        cache_write_tokens: count("/input_tokens_details/cache_write_tokens"),
        cost: None,
    }
}

fn flat_tools(tools: &Toolbox) -> Value {
    let one = |spec: &ToolSpec| {
        json!({
            "type": "function", "name": spec.name, "description": spec.about,
            "parameters": spec.schema, "strict": false,
        })
    };
    tools.specs.iter().map(one).collect()
}

/// The conversation with the rounds of calls so far.
fn input(request: &Request) -> Value {
    let mut all: Vec<Value> = request.messages.iter().map(protocol::responses).collect();
    let rounds = request.offered().map_or(&[][..], |tools| &tools.rounds);
    for round in rounds {
        let turn = &round.turn;
        let places = turn.echo.iter().filter(|item| is_call(item));
        let places: Vec<&str> = places.filter_map(|item| string(item, "call_id")).collect();
        let mut text =
            (!turn.text.is_empty()).then(|| json!({"role": "assistant", "content": turn.text}));
        for item in &turn.echo {
            if !is_call(item) {
                all.push(item.clone());
                continue;
            }
            all.extend(text.take());
            let meant = turn
                .calls
                .iter()
                .find(|call| string(item, "call_id") == Some(&call.id));
            all.extend(meant.map(sent_call));
        }
        all.extend(text);
        let rest = turn
            .calls
            .iter()
            .filter(|call| !places.contains(&call.id.as_str()));
        all.extend(rest.map(sent_call));
        all.extend(round.pairs().map(|(call, result)| {
            json!({"type": "function_call_output", "call_id": call.id, "output": result})
        }));
    }
    json!(all)
}

fn sent_call(call: &ToolCall) -> Value {
    json!({
        "type": "function_call", "call_id": call.id, "name": call.name, "arguments": call.arguments,
    })
}

/// The number of an item.
pub(super) fn output_index(event: &Value) -> u64 {
    let index = event.get("output_index").and_then(Value::as_u64);
    index.unwrap_or(0)
}

/// An item begins; only calls are told of here.
pub(super) fn begun(event: &Value, answer: &mut ResponseAccumulator) {
    if let Some(item) = event.get("item").filter(|item| is_call(item)) {
        begin_call(output_index(event), item, answer);
    }
}

/// An item is whole.
pub(super) fn done(event: &Value, answer: &mut ResponseAccumulator) {
    if let Some(item) = event.get("item") {
        complete_call(output_index(event), item, answer);
    }
}

/// The calls of a whole response, from servers that do not tell of their items.
pub(super) fn read_calls(response: &Value, answer: &mut ResponseAccumulator) {
    let items = response.get("output").and_then(Value::as_array);
    for (number, item) in items.into_iter().flatten().enumerate() {
        complete_call(number as u64, item, answer);
    }
}

fn is_call(item: &Value) -> bool {
    string(item, "type") == Some("function_call")
}

fn begin_call(number: u64, item: &Value, answer: &mut ResponseAccumulator) {
    let id = string(item, "call_id").or_else(|| string(item, "id"));
    let name = string(item, "name").unwrap_or_default();
    answer.call(number, id.unwrap_or_default(), name);
}

fn complete_call(number: u64, item: &Value, answer: &mut ResponseAccumulator) {
    if is_call(item) {
        begin_call(number, item, answer);
        if let Some(arguments) = string(item, "arguments") {
            answer.complete_call(number, arguments);
        }
        // Its place among the thoughts, which go back in their order.
        if let Some(id) = string(item, "call_id") {
            answer.echo(json!({"type": "function_call", "call_id": id}));
        }
    } else if string(item, "type") == Some("reasoning")
        && string(item, "encrypted_content").is_some()
    {
        // Without what is encrypted the server would look for an item that it did not keep.
        answer.echo(json!({
            "type": "reasoning", "id": item.get("id"),
            "summary": item.get("summary").cloned().unwrap_or_else(|| json!([])),
            "encrypted_content": item.get("encrypted_content"),
        }));
    }
}
