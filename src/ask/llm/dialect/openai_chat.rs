//! OpenAI's Chat Completions, as also spoken by DeepSeek, OpenRouter, llama.cpp, vLLM, LM Studio and most others.

use serde::Serialize;
use serde_json::{Value, json};

use super::{
    AnswerReader, Notes, WireProtocol, count, function_tools, given, openai_models, openai_version,
    protocol, string,
};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::batch::{BatchApi, OpenAiBatches};
use crate::llm::chunk::{ALTERNATIVES, Cost, CostSource, Finish, Usage, tokens};
use crate::llm::endpoint::{Endpoint, ResponseFormat};
use crate::llm::error::Error;
use crate::llm::error_body::ErrorBody;
use crate::llm::portable_schema::name;
use crate::llm::quirks::{Effort, Efforts};
use crate::llm::request::{Request, Schema};

/// The body of a question.
#[derive(Default, Serialize)]
struct Question<'a> {
    model: &'a str,
    messages: Value,
    tools: Option<Value>,
    tool_choice: Option<&'static str>,
    stream: bool,
    stream_options: Option<Value>,
    temperature: Option<f64>,
    max_completion_tokens: Option<u32>,
    max_tokens: Option<u32>,
    seed: Option<u64>,
    logprobs: Option<bool>,
    top_logprobs: Option<u32>,
    thinking: Option<Value>,
    reasoning_effort: Option<&'static str>,
    reasoning: Option<Value>,
    enable_thinking: Option<bool>,
    chat_template_kwargs: Option<Value>,
    response_format: Option<Value>,
    provider: Option<Value>,
}

/// A turn that called tools.
#[derive(Serialize)]
#[serde(tag = "role", rename = "assistant")]
struct Called<'a> {
    content: Option<&'a str>,
    tool_calls: Vec<Value>,
    #[serde(skip_serializing_if = "str::is_empty")]
    reasoning_content: &'a str,
    #[serde(skip_serializing_if = "<[Value]>::is_empty")]
    reasoning_details: &'a [Value],
}

/// OpenAI's chat completions.
pub(super) struct Protocol;

impl WireProtocol for Protocol {
    fn method(&self) -> &'static str {
        "/chat/completions"
    }

    fn version(&self, root: &str) -> &'static str {
        openai_version(root)
    }

    fn body(&self, endpoint: &Endpoint, request: &Request, notes: &mut Notes) -> Value {
        let quirks = &endpoint.quirks;
        let tools = request.offered();
        let limit = request.parameters.max_tokens.or(quirks.max_tokens);
        let temperature = notes.temperature(endpoint, request, 2.0);
        let seed = notes.seed(endpoint, request);
        let weighs = notes.log_probabilities(endpoint, request);
        let mut body = Question {
            model: &request.model,
            messages: messages(endpoint, request),
            tools: tools.map(function_tools),
            tool_choice: tools.filter(|tools| !tools.may_call).map(|_| "none"),
            stream: true,
            stream_options: quirks
                .stream_options
                .then(|| json!({"include_usage": true})),
            temperature,
            // OpenAI's reasoning models refuse the old name; most other servers know no other.
            max_completion_tokens: limit.filter(|_| quirks.max_completion_tokens),
            max_tokens: limit.filter(|_| !quirks.max_completion_tokens),
            seed,
            logprobs: weighs.then_some(true),
            top_logprobs: weighs.then_some(ALTERNATIVES),
            ..Question::default()
        };
        if let Some(effort) = request.parameters.effort {
            let style = quirks.efforts.unwrap_or(Efforts::Levels);
            self::effort(style, effort, &mut body, notes);
        }
        // Servers on this machine refuse a grammar for the answer beside tools.
        if let Some(schema) = request.schema_to_send(!endpoint.is_here()) {
            body.response_format = response_format(endpoint, request, schema, notes);
            // Without this some of the hosts behind OpenRouter drop the schema.
            let is_exact = endpoint.response_format == ResponseFormat::JsonSchema;
            let must = is_exact && quirks.require_parameters;
            body.provider = must.then(|| json!({"require_parameters": true}));
        }
        given(body)
    }

    fn reader(&self) -> Box<dyn AnswerReader> {
        Box::new(ChatReader::default())
    }

    fn models<'a>(&self, list: &'a Value) -> Option<Vec<&'a str>> {
        openai_models(list)
    }

    fn batches(&self) -> Option<&'static dyn BatchApi> {
        Some(&OpenAiBatches {
            endpoint: "/v1/chat/completions",
        })
    }
}

/// The conversation with the rounds of calls so far.
fn messages(endpoint: &Endpoint, request: &Request) -> Value {
    let mut all: Vec<Value> = request.messages.iter().map(protocol::chat).collect();
    let rounds = request.offered().map_or(&[][..], |tools| &tools.rounds);
    for round in rounds {
        let calls = round.turn.calls.iter().map(|call| {
            json!({
                "id": call.id, "type": "function",
                "function": {"name": call.name, "arguments": call.arguments},
            })
        });
        let text = Some(round.turn.text.as_str());
        // DeepSeek wants to see what it thought before its calls, OpenRouter gives the details to the model's own server,
        // which signs some; others refuse the fields.
        let (reasoning_content, reasoning_details) = match endpoint.quirks.efforts {
            Some(Efforts::DeepSeek) => (round.turn.thought.as_str(), &[][..]),
            Some(Efforts::OpenRouter) => ("", &round.turn.echo[..]),
            _ => ("", &[][..]),
        };
        all.push(json!(Called {
            content: text.filter(|text| !text.is_empty()),
            tool_calls: calls.collect(),
            reasoning_content,
            reasoning_details,
        }));
        all.extend(round.pairs().map(
            |(call, result)| json!({"role": "tool", "tool_call_id": call.id, "content": result}),
        ));
    }
    json!(all)
}

/// Fragments of calls; whole ones have no index.
fn calls(list: Option<&Value>, answer: &mut ResponseAccumulator) {
    for call in list.and_then(Value::as_array).into_iter().flatten() {
        let number = call
            .get("index")
            .and_then(Value::as_u64)
            .unwrap_or_else(|| answer.calls());
        let function = call.get("function").unwrap_or(&Value::Null);
        let id = string(call, "id").unwrap_or_default();
        // Some servers give all calls of a turn the same index; fragments then belong to the newest one.
        let number = answer.call_number(number, id);
        answer.call(number, id, string(function, "name").unwrap_or_default());
        match function.get("arguments") {
            Some(Value::String(fragment)) => answer.call_arguments(number, fragment),
            // Some servers send an object.
            Some(whole @ Value::Object(_)) => answer.complete_call(number, &whole.to_string()),
            _ => {}
        }
    }
}

fn effort(style: Efforts, effort: Effort, body: &mut Question<'_>, notes: &mut Notes) {
    let on = effort != Effort::Off;
    let word = if on { effort.name() } else { "none" };
    match style {
        Efforts::Levels => body.reasoning_effort = Some(word),
        Efforts::DeepSeek if on => {
            body.thinking = Some(json!({"type": "enabled"}));
            body.reasoning_effort = Some(word);
        }
        Efforts::DeepSeek => body.thinking = Some(json!({"type": "disabled"})),
        Efforts::OpenRouter if on => body.reasoning = Some(json!({"effort": word})),
        Efforts::OpenRouter => body.reasoning = Some(json!({"enabled": false})),
        Efforts::Switch => body.enable_thinking = Some(on),
        Efforts::Template => body.chat_template_kwargs = Some(json!({"enable_thinking": on})),
        Efforts::Budget | Efforts::Untaken => {
            notes.untaken("effort", "not supported by this model");
        }
    }
    if on && matches!(style, Efforts::Switch | Efforts::Template) {
        notes.note(&format!(
            "effort {word}: this server can only switch reasoning on or off; it is switched on"
        ));
    }
}

fn response_format(
    endpoint: &Endpoint,
    request: &Request,
    schema: &Schema,
    notes: &mut Notes,
) -> Option<Value> {
    match endpoint.response_format {
        ResponseFormat::Off => None,
        ResponseFormat::JsonObject => {
            let says_json = |text: &str| text.to_ascii_lowercase().contains("json");
            if request.messages.iter().any(|m| says_json(&m.content)) {
                return Some(json!({"type": "json_object"}));
            }
            notes.untaken(
                "response_format json_object",
                "servers require the word JSON in the prompt, which lacks it",
            );
            None
        }
        ResponseFormat::JsonSchema => Some(json!({"type": "json_schema", "json_schema": {
            "name": name(&schema.name), "strict": true, "schema": schema.sent(),
        }})),
    }
}

/// The reader of its answers.
#[derive(Debug, Default)]
struct ChatReader {
    /// The one field reasoning is read from: some servers send the same text in two.
    reasoning_field: Option<&'static str>,
    /// OpenRouter's, put together from fragments.
    details: Details,
}

impl AnswerReader for ChatReader {
    fn ends_with_word(&self) -> bool {
        true
    }

    fn event(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        answer.model(string(value, "model"));
        if let Some(usage) = value.get("usage").filter(|u| u.is_object()) {
            answer.usage(usage_of(usage));
        }
        match choice(value) {
            Some(choice) => self.choice(choice, answer),
            None => Ok(()),
        }
    }

    fn document(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        if choice(value).is_none() {
            return Err(answer.no_answer(value));
        }
        self.event(value, answer)
    }
}

impl ChatReader {
    fn choice(&mut self, choice: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        answer.tokens(tokens(choice.pointer("/logprobs/content")));
        let message = || choice.get("message").filter(|_| answer.received() == 0);
        if let Some(delta) = choice
            .get("delta")
            .filter(|d| d.is_object())
            .or_else(message)
        {
            self.reasoning(delta, answer);
            if !answer.is_capped() {
                self.details.add(delta);
            }
            match delta.get("content") {
                Some(Value::String(text)) => answer.push_text(text),
                Some(Value::Array(parts)) => parts.iter().for_each(|p| self.part(p, answer)),
                _ => {}
            }
            calls(delta.get("tool_calls"), answer);
            answer.refuse(string(delta, "refusal").unwrap_or_default());
        } else if let Some(text) = string(choice, "text") {
            // As servers of completions have it.
            answer.push_text(text);
        }
        let finish = string(choice, "finish_reason");
        if finish.is_some() && answer.calls() > 0 {
            self.details.take().into_iter().for_each(|d| answer.echo(d));
        }
        let word = finish.map(str::to_ascii_lowercase);
        match word.as_deref() {
            None => {}
            Some("stop" | "eos" | "eos_token" | "stop_sequence" | "end_turn") => {
                answer.finish(Finish::Stop)
            }
            Some("tool_calls" | "function_call") => answer.finish(Finish::ToolCalls),
            Some("length" | "max_tokens" | "max_new_tokens" | "model_length") => {
                answer.finish(Finish::Length)
            }
            Some("content_filter") => answer.finish(Finish::ContentFilter),
            // DeepSeek broke off: the partial text is not an answer.
            Some(word @ "insufficient_system_resource") => {
                return Err(answer.reported(ErrorBody {
                    message: "the server ran out of resources".into(),
                    code: Some(word.into()),
                    ..ErrorBody::default()
                }));
            }
            Some(other) => answer.finish(Finish::Other(other.to_owned())),
        }
        Ok(())
    }

    fn reasoning(&mut self, delta: &Value, answer: &mut ResponseAccumulator) {
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
                answer.reason(&text);
                return;
            }
        }
    }

    /// One part of a content that is a list, as Mistral sends it.
    fn part(&mut self, part: &Value, answer: &mut ResponseAccumulator) {
        let chosen = "content";
        let other = self.reasoning_field.is_some_and(|field| field != chosen);
        let thought = match part.get("thinking") {
            Some(Value::String(text)) => text.clone(),
            Some(Value::Array(inner)) => inner.iter().filter_map(|p| string(p, "text")).collect(),
            _ => return answer.push_text(string(part, "text").unwrap_or_default()),
        };
        if !other && !thought.is_empty() {
            self.reasoning_field = Some(chosen);
            answer.reason(&thought);
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

fn usage_of(usage: &Value) -> Usage {
    let count = |pointer| count(usage, pointer);
    let cost = usage.get("cost").and_then(Value::as_f64);
    let (input, answer) = (count("/prompt_tokens"), count("/completion_tokens"));
    let reasoning = count("/completion_tokens_details/reasoning_tokens");
    // xAI counts the reasoning beside the answer, others within it; the total tells.
    let sum = |counts: &[Option<u64>]| {
        counts
            .iter()
            .try_fold(0_u64, |sum, n| sum.checked_add((*n)?))
    };
    let beside =
        sum(&[input, answer, reasoning]).filter(|all| Some(*all) == count("/total_tokens"));
    Usage {
        input_tokens: input,
        output_tokens: beside.and_then(|_| sum(&[answer, reasoning])).or(answer),
        reasoning_tokens: reasoning,
        // The second is DeepSeek's name.
        cached_tokens: count("/prompt_tokens_details/cached_tokens")
            .or_else(|| count("/prompt_cache_hit_tokens")),
        cache_write_tokens: count("/prompt_tokens_details/cache_write_tokens"),
        cost: cost.filter(|c| c.is_finite() && *c >= 0.0).map(|usd| Cost {
            usd,
            source: CostSource::Server,
        }),
    }
}

/// Most details of a turn that are kept.
const MAX_DETAILS: usize = 256;

/// The details of a turn so far.
#[derive(Debug, Default)]
pub(super) struct Details(Vec<Value>);

impl Details {
    /// Adds those of a fragment: texts grow, everything else is what was said last.
    pub fn add(&mut self, delta: &Value) {
        let list = delta.get("reasoning_details").and_then(Value::as_array);
        for detail in list.into_iter().flatten().filter(|d| d.is_object()) {
            let same = |known: &&mut Value| {
                known.get("index") == detail.get("index") && known.get("type") == detail.get("type")
            };
            let room = self.0.len() < MAX_DETAILS;
            match self.0.last_mut().filter(same) {
                Some(known) => grow(known, detail),
                None if room => self.0.push(detail.clone()),
                None => {}
            }
        }
    }

    /// All of them; none are left.
    pub fn take(&mut self) -> Vec<Value> {
        std::mem::take(&mut self.0)
    }
}

fn grow(known: &mut Value, more: &Value) {
    for (key, value) in more.as_object().into_iter().flatten() {
        match (key.as_str(), string(known, key), value) {
            ("text" | "summary" | "data", Some(before), Value::String(after)) => {
                let grown = format!("{before}{after}");
                known[key] = grown.into();
            }
            (_, _, Value::Null) => {}
            _ => known[key] = value.clone(),
        }
    }
}

#[cfg(test)]
#[path = "openai_chat_tests.rs"]
mod tests;

#[cfg(test)]
mod reasoning_details_tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn fragments_grow_together_and_keep_their_signature() {
        let mut details = Details::default();
        let fragments = [
            json!([{"type": "reasoning.text", "index": 0, "text": "The gap", "format": "f"}]),
            json!([{"type": "reasoning.text", "index": 0, "text": " shrinks."}]),
            json!([{"type": "reasoning.text", "index": 0, "signature": "s", "text": null}]),
            json!([{"type": "reasoning.encrypted", "index": 1, "data": "x"}, 7]),
        ];
        for fragment in fragments {
            details.add(&json!({"reasoning_details": fragment}));
        }
        details.add(&json!({"reasoning_details": "none"}));
        assert_eq!(
            details.take(),
            [
                json!({
                    "type": "reasoning.text", "index": 0, "text": "The gap shrinks.", "format": "f", "signature": "s",
                }),
                json!({"type": "reasoning.encrypted", "index": 1, "data": "x"}),
            ]
        );
        assert!(details.take().is_empty());
    }
}
