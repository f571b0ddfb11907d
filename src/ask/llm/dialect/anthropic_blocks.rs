//! Content blocks of Anthropic's turns that call tools: read in fragments, sent again as they were.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::string;
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::tool_calls::ToolRound;

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
const MOST: usize = 256;

fn index(event: &Value) -> u64 {
    event.get("index").and_then(Value::as_u64).unwrap_or(0)
}

impl Blocks {
    /// A block begins; outside of streams it is whole.
    pub fn start(&mut self, event: &Value, answer: &mut ResponseAccumulator) {
        let Some(block) = event.get("content_block").filter(|b| b.is_object()) else {
            return;
        };
        if self.blocks.len() == MOST {
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
            let whole = block.get("input").and_then(Value::as_object);
            if let Some(whole) = whole.filter(|input| !input.is_empty()) {
                answer.call_whole(number, &json!(whole).to_string());
            }
            kept.call = Some(number);
        }
        self.blocks.insert(index(event), kept);
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
            if let Some(whole) = block.whole() {
                answer.echo(whole);
            }
        }
    }
}

impl Block {
    /// The block as it is sent again; `None` for an empty text, which the API refuses.
    fn whole(self) -> Option<Value> {
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
                    let read = serde_json::from_str::<Value>(&self.added).ok();
                    block["input"] = read.filter(Value::is_object).unwrap_or_else(|| json!({}));
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
