//! Items of OpenAI's Responses API that are about tools: calls in fragments, thoughts that go back, results.

use serde_json::{Value, json};

use super::{images, string};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::request::Request;
use crate::llm::tool_calls::{ToolCall, ToolSpec, Toolbox};

/// The tools.
pub(super) fn flat_tools(tools: &Toolbox) -> Value {
    let one = |spec: &ToolSpec| {
        json!({
            "type": "function", "name": spec.name, "description": spec.about,
            "parameters": spec.schema, "strict": false,
        })
    };
    tools.specs.iter().map(one).collect()
}

/// The conversation with the rounds of calls so far.
pub(super) fn input(request: &Request) -> Value {
    let mut all: Vec<Value> = request.messages.iter().map(images::responses).collect();
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
        named(output_index(event), item, answer);
    }
}

/// An item is whole.
pub(super) fn done(event: &Value, answer: &mut ResponseAccumulator) {
    if let Some(item) = event.get("item") {
        whole(output_index(event), item, answer);
    }
}

/// The calls of a whole response, from servers that do not tell of their items.
pub(super) fn calls_of(response: &Value, answer: &mut ResponseAccumulator) {
    let items = response.get("output").and_then(Value::as_array);
    for (number, item) in items.into_iter().flatten().enumerate() {
        whole(number as u64, item, answer);
    }
}

fn is_call(item: &Value) -> bool {
    string(item, "type") == Some("function_call")
}

fn named(number: u64, item: &Value, answer: &mut ResponseAccumulator) {
    let id = string(item, "call_id").or_else(|| string(item, "id"));
    let name = string(item, "name").unwrap_or_default();
    answer.call(number, id.unwrap_or_default(), name);
}

fn whole(number: u64, item: &Value, answer: &mut ResponseAccumulator) {
    if is_call(item) {
        named(number, item, answer);
        if let Some(arguments) = string(item, "arguments") {
            answer.call_whole(number, arguments);
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
