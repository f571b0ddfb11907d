//! Anthropic's Messages API: content blocks that start, grow, stop and are sent again as they were; usage in two places.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::{
    AnswerReader, Auth, Notes, WireProtocol, count, given, is_anthropic_model, names_in, protocol,
    string,
};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::batch::{AnthropicBatches, BatchApi};
use crate::llm::chunk::{Finish, Usage};
use crate::llm::endpoint::{Endpoint, ResponseFormat};
use crate::llm::error::Error;
use crate::llm::quirks::{Effort, Efforts};
use crate::llm::request::{Request, Role, ToolRound, ToolSpec};

/// The version of the API that is spoken, sent as a header.
const VERSION: &str = "2023-06-01";

/// Sent if no limit is set, because this API requires one.
const MOST_TOKENS: u32 = 8192;

/// The smallest thinking budget that the API accepts, in tokens.
const LEAST_BUDGET: u32 = 1024;

/// The body of a question.
#[derive(Serialize)]
struct Question<'a> {
    model: &'a str,
    max_tokens: u32,
    stream: bool,
    system: Option<Value>,
    tools: Option<Value>,
    tool_choice: Option<Value>,
    messages: Vec<Value>,
    thinking: Option<Thinking>,
    temperature: Option<f64>,
    output_config: Value,
}

#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Thinking {
    Disabled,
    Adaptive { display: &'static str },
    Enabled { budget_tokens: u32 },
}

#[derive(Serialize)]
struct OutputConfig {
    effort: Option<&'static str>,
    format: Option<Value>,
}

/// Anthropic's messages.
pub(super) struct Protocol;

impl WireProtocol for Protocol {
    fn auth(&self) -> Auth {
        Auth::ApiKey
    }

    fn headers(&self) -> &'static [(&'static str, &'static str)] {
        &[("anthropic-version", VERSION)]
    }

    fn method(&self) -> &'static str {
        "/messages"
    }

    fn body(&self, endpoint: &Endpoint, request: &Request, notes: &mut Notes) -> Value {
        let parameters = &request.parameters;
        let limit = endpoint.answer_limit(parameters).unwrap_or_else(|| {
            notes.note(&format!(
                "max_tokens: this API requires a limit; {MOST_TOKENS} is sent"
            ));
            MOST_TOKENS
        });
        let of = |system: bool| {
            let messages = request.messages.iter();
            messages.filter(move |m| (m.role == Role::System) == system)
        };
        let system: Vec<_> = of(true).map(|m| m.content.as_str()).collect();
        let tools = request.offered();
        let tool = |spec: &ToolSpec| json!({"name": spec.name, "description": spec.about, "input_schema": spec.schema});
        let rounds = tools.into_iter().flat_map(|tools| &tools.rounds);
        let thinking = thinking(endpoint, parameters.effort, limit, notes);
        let is_adaptive = matches!(thinking, Some(Thinking::Adaptive { .. }));
        let thinks = !matches!(thinking, None | Some(Thinking::Disabled));
        let temperature = if thinks && parameters.temperature.is_some_and(|t| t != 1.0) {
            notes.untaken("temperature", "with thinking on, this API accepts only 1");
            None
        } else {
            notes.temperature(endpoint, request, 1.0)
        };
        if parameters.log_probabilities {
            notes.untaken("log_probabilities", "this API gives none");
        }
        if parameters.seed.is_some() {
            notes.untaken("seed", "not supported by this API");
        }
        let schema = request.schema.as_ref();
        if schema.is_some() && endpoint.response_format == ResponseFormat::JsonObject {
            notes.untaken(
                "response_format json_object",
                "this API supports only json_schema",
            );
        }
        let schema = schema.filter(|_| endpoint.response_format == ResponseFormat::JsonSchema);
        given(Question {
            model: &request.model,
            max_tokens: limit,
            stream: true,
            system: (!system.is_empty()).then(|| system_prompt(endpoint, system.join("\n\n"))),
            tools: tools.map(|tools| tools.specs.iter().map(tool).collect()),
            tool_choice: tools
                .filter(|t| !t.may_call)
                .map(|_| json!({"type": "none"})),
            messages: of(false)
                .map(protocol::anthropic)
                .chain(rounds.flat_map(round))
                .collect(),
            thinking,
            temperature,
            output_config: given(OutputConfig {
                effort: parameters.effort.filter(|_| is_adaptive).map(Effort::name),
                format: schema.map(|s| json!({"type": "json_schema", "schema": s.sent()})),
            }),
        })
    }

    fn reader(&self) -> Box<dyn AnswerReader> {
        Box::new(MessagesReader::default())
    }

    fn models<'a>(&self, list: &'a Value) -> Option<Vec<&'a str>> {
        names_in(list.get("data")?, "id", is_anthropic_model)
    }

    fn batches(&self) -> Option<&'static dyn BatchApi> {
        Some(&AnthropicBatches)
    }
}

/// The instructions, which are the same in many questions: marked for the server's cache where they are long enough for
/// it. Tokens are counted as a quarter of the bytes, rather too few: the mark on a shorter text has no effect.
fn system_prompt(endpoint: &Endpoint, text: String) -> Value {
    let tokens = u32::try_from(text.len() / 4).unwrap_or(u32::MAX);
    match endpoint.quirks.cache_from {
        Some(least) if endpoint.prompt_cache && tokens >= least => json!([{
            "type": "text", "text": text, "cache_control": {"type": "ephemeral"},
        }]),
        _ => json!(text),
    }
}

/// How the model is to think, where that is asked for.
fn thinking(
    endpoint: &Endpoint,
    effort: Option<Effort>,
    limit: u32,
    notes: &mut Notes,
) -> Option<Thinking> {
    let effort = effort?;
    match (endpoint.quirks.efforts.unwrap_or(Efforts::Levels), effort) {
        // Newer models think unless told not to.
        (_, Effort::Off) => Some(Thinking::Disabled),
        (Efforts::Levels, _) => Some(Thinking::Adaptive {
            display: "summarized",
        }),
        (Efforts::Budget, _) => {
            let wanted = match effort {
                Effort::High | Effort::XHigh | Effort::Max => 16 * LEAST_BUDGET,
                Effort::Medium => 4 * LEAST_BUDGET,
                Effort::Low | Effort::Minimal | Effort::Off => LEAST_BUDGET,
            };
            let budget_tokens = wanted.min(limit.saturating_sub(1));
            if budget_tokens < LEAST_BUDGET {
                notes.untaken(
                    "effort",
                    "thinking needs max_tokens above 1024, which it shares",
                );
                return None;
            }
            if budget_tokens < wanted {
                notes.note(&format!(
                    "effort {}: the thinking budget is limited to {budget_tokens}, below max_tokens",
                    effort.name()
                ));
            }
            Some(Thinking::Enabled { budget_tokens })
        }
        _ => {
            notes.untaken("effort", "not supported by this model");
            None
        }
    }
}

/// Fields of usage.
const COUNTS: [&str; 5] = [
    "input_tokens",
    "cache_read_input_tokens",
    "cache_creation_input_tokens",
    "output_tokens",
    "output_tokens_details",
];

/// The reader of its answers.
#[derive(Debug, Default)]
struct MessagesReader {
    /// The counts so far: the first event has some, a later one others, and what is repeated holds from then on.
    counts: Map<String, Value>,
    /// The blocks so far, which the server has to see again after calls.
    blocks: Blocks,
}

impl AnswerReader for MessagesReader {
    fn event(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        match string(value, "type") {
            Some("message_start") => {
                if let Some(message) = value.get("message") {
                    answer.model(string(message, "model"));
                    self.usage(message, answer);
                }
            }
            // Deltas name their kind, so that blocks which overlap are not mixed up.
            Some("content_block_start") => {
                let begun = value.get("content_block");
                block(begun, answer);
                self.blocks.start(index(value), begun, answer);
            }
            Some("content_block_delta") => {
                block(value.get("delta"), answer);
                self.blocks.grow(value, answer);
            }
            Some("message_delta") => {
                self.usage(value, answer);
                if let Some(delta) = value.get("delta") {
                    self.blocks.stop(delta, answer);
                    stopped(delta, answer);
                }
            }
            Some("message_stop") => answer.complete(),
            // Pings, ends of blocks, and what is yet to be invented.
            _ => {}
        }
        Ok(())
    }

    fn document(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        let Some(blocks) = value.get("content").and_then(Value::as_array) else {
            return Err(answer.no_answer(value));
        };
        answer.model(string(value, "model"));
        self.usage(value, answer);
        for (index, whole) in blocks.iter().enumerate() {
            block(Some(whole), answer);
            self.blocks.start(index as u64, Some(whole), answer);
        }
        self.blocks.stop(value, answer);
        stopped(value, answer);
        Ok(())
    }
}

impl MessagesReader {
    fn usage(&mut self, holder: &Value, answer: &mut ResponseAccumulator) {
        let Some(Value::Object(counts)) = holder.get("usage") else {
            return;
        };
        let known =
            |(name, count): &(&String, &Value)| COUNTS.contains(&name.as_str()) && !count.is_null();
        let stated = counts.iter().filter(known);
        self.counts
            .extend(stated.map(|(k, v)| (k.clone(), v.clone())));
        let all = Value::Object(self.counts.clone());
        let count = |pointer| count(&all, pointer);
        let read = count("/cache_read_input_tokens");
        let written = count("/cache_creation_input_tokens");
        let cached = read.unwrap_or(0).saturating_add(written.unwrap_or(0));
        answer.usage(Usage {
            // Cached tokens are not in the input count.
            input_tokens: count("/input_tokens").map(|n| n.saturating_add(cached)),
            output_tokens: count("/output_tokens"),
            reasoning_tokens: count("/output_tokens_details/thinking_tokens"),
            cached_tokens: read,
            cache_write_tokens: written,
            cost: None,
        });
    }
}

/// A block or a piece of one: its kind shows in its fields.
fn block(block: Option<&Value>, answer: &mut ResponseAccumulator) {
    let Some(block) = block else { return };
    answer.reason(string(block, "thinking").unwrap_or_default());
    answer.push_text(string(block, "text").unwrap_or_default());
}

fn stopped(holder: &Value, answer: &mut ResponseAccumulator) {
    match string(holder, "stop_reason") {
        None => {}
        Some("end_turn" | "stop_sequence") => answer.finish(Finish::Stop),
        Some("tool_use") => answer.finish(Finish::ToolCalls),
        Some("max_tokens" | "model_context_window_exceeded") => answer.finish(Finish::Length),
        Some("refusal") => answer.finish(Finish::Refusal(String::new())),
        Some(other) => answer.finish(Finish::Other(other.to_owned())),
    }
}

/// The blocks of a turn by their index.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    blocks: BTreeMap<u64, Block>,
}

#[derive(Debug, Default)]
struct Block {
    /// As it began.
    block: Value,
    /// What was added: text, thought or arguments, by its kind.
    added: String,
    signature: String,
    /// The number of the call, for calls.
    call: Option<u64>,
}

/// Most blocks of a turn that are kept.
const MAX_BLOCKS: usize = 256;

fn index(event: &Value) -> u64 {
    event.get("index").and_then(Value::as_u64).unwrap_or(0)
}

impl Blocks {
    /// A block begins; outside of streams it is whole.
    pub fn start(&mut self, at: u64, block: Option<&Value>, answer: &mut ResponseAccumulator) {
        let Some(block) = block.filter(|b| b.is_object()) else {
            return;
        };
        if self.blocks.len() == MAX_BLOCKS {
            return;
        }
        let mut kept = Block {
            block: block.clone(),
            ..Block::default()
        };
        if string(block, "type") == Some("tool_use") {
            let number = answer.calls();
            let name = string(block, "name").unwrap_or_default();
            answer.call(number, string(block, "id").unwrap_or_default(), name);
            if answer.calls() == number {
                // There are too many: a call without a result must not be sent again.
                return;
            }
            // In streams the input begins empty, and comes in fragments.
            let is_whole = |input: &Value| input.as_object().is_some_and(|all| !all.is_empty());
            if let Some(input) = block.get("input").filter(|input| is_whole(input)) {
                answer.complete_call(number, &input.to_string());
            }
            kept.call = Some(number);
        }
        self.blocks.insert(at, kept);
    }

    /// A block grows. Texts are bounded by the answer, which has taken them already.
    pub fn grow(&mut self, event: &Value, answer: &mut ResponseAccumulator) {
        let (Some(block), Some(delta)) = (self.blocks.get_mut(&index(event)), event.get("delta"))
        else {
            return;
        };
        if answer.is_capped() {
            return;
        }
        for key in ["text", "thinking"] {
            block.added.push_str(string(delta, key).unwrap_or_default());
        }
        block
            .signature
            .push_str(string(delta, "signature").unwrap_or_default());
        if let (Some(number), Some(fragment)) = (block.call, string(delta, "partial_json")) {
            answer.call_arguments(number, fragment);
            block.added.push_str(fragment);
        }
    }

    /// The turn stops: if it calls tools, its blocks are kept as they have to be sent again.
    pub fn stop(&mut self, holder: &Value, answer: &mut ResponseAccumulator) {
        if string(holder, "stop_reason").is_none() || answer.calls() == 0 {
            return;
        }
        for block in std::mem::take(&mut self.blocks).into_values() {
            if let Some(whole) = block.into_value() {
                answer.echo(whole);
            }
        }
    }
}

impl Block {
    /// The block as it is sent again; `None` for an empty text, which the API refuses.
    fn into_value(self) -> Option<Value> {
        let mut block = self.block;
        let grown = |block: &Value, key: &str| {
            format!("{}{}", string(block, key).unwrap_or_default(), self.added)
        };
        match string(&block, "type") {
            Some("text") => {
                let text = grown(&block, "text");
                (!text.trim().is_empty()).then(|| json!({"type": "text", "text": text}))
            }
            Some("thinking") => {
                let began = string(&block, "signature").unwrap_or_default();
                let signature = format!("{began}{}", self.signature);
                let thinking = grown(&block, "thinking");
                Some(json!({"type": "thinking", "thinking": thinking, "signature": signature}))
            }
            Some("tool_use") => {
                if !self.added.is_empty() {
                    let read: Map<_, _> = serde_json::from_str(&self.added).unwrap_or_default();
                    block["input"] = read.into();
                }
                Some(block)
            }
            Some("redacted_thinking") => Some(block),
            _ => None,
        }
    }
}

/// A turn of the model and the results of its calls.
pub(super) fn round(round: &ToolRound) -> [Value; 2] {
    let mut blocks = round.turn.echo.clone();
    if blocks.is_empty() {
        if !round.turn.text.trim().is_empty() {
            blocks.push(json!({"type": "text", "text": round.turn.text}));
        }
        blocks.extend(round.turn.calls.iter().map(|call| {
            json!({"type": "tool_use", "id": call.id, "name": call.name, "input": call.object()})
        }));
    }
    let results = round.pairs().map(
        |(call, result)| json!({"type": "tool_result", "tool_use_id": call.id, "content": result}),
    );
    let results: Vec<Value> = results.collect();
    [
        json!({"role": "assistant", "content": blocks}),
        json!({"role": "user", "content": results}),
    ]
}
