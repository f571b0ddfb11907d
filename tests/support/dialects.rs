//! What the tests know of each wire protocol: a usual answer, its counts and its end, pieces of answers, addresses. A new
//! dialect has its arms here.

use nearmiss::llm::{Dialect, Usage};
use serde_json::{Value, json};

use super::server::Script;

/// A line of a stream of named events.
pub fn named(value: Value) -> String {
    format!(
        "event: {}\ndata: {value}\n\n",
        value["type"].as_str().unwrap()
    )
}

pub fn data(value: Value) -> String {
    format!("data: {value}\n\n")
}

pub fn line(value: Value) -> String {
    format!("{value}\n")
}

/// A usual answer of a dialect: "wé" is thought, "gefährlich 車" and " 🚗" are said, and the counts are those of
/// [`usage_of`].
pub fn usual_of(dialect: Dialect) -> String {
    match dialect {
        Dialect::OpenAiChat => [
            ": keep-alive\n\n".to_string(),
            data(json!({"model": "m-1", "choices": [{"index": 0, "delta": {"role": "assistant", "content": null}}]})),
            data(json!({"choices": [{"index": 0, "delta": {"reasoning_content": "wé"}}]})),
            data(json!({"choices": [{"index": 0, "delta": {"content": "gefährlich 車"}}], "obfuscation": "x"})),
            data(json!({"choices": [{"index": 0, "delta": {"content": " 🚗"}, "finish_reason": "stop"}]})),
            data(json!({"choices": [], "usage": {
                "prompt_tokens": 120, "completion_tokens": 30, "total_tokens": 150,
                "prompt_tokens_details": {"cached_tokens": 64, "cache_write_tokens": 8},
                "completion_tokens_details": {"reasoning_tokens": 18},
            }})),
            "data: [DONE]\n\n".to_string(),
        ]
        .concat(),
        Dialect::OpenAiResponses => [
            named(json!({"type": "response.created", "sequence_number": 0, "response": {"model": "m-1", "status": "in_progress", "error": null, "output": [], "usage": null}})),
            named(json!({"type": "response.output_item.added", "output_index": 0, "item": {"type": "reasoning", "summary": []}})),
            named(json!({"type": "response.reasoning_summary_part.added", "summary_index": 0, "part": {"type": "summary_text", "text": ""}})),
            named(json!({"type": "response.reasoning_summary_text.delta", "summary_index": 0, "delta": "wé"})),
            named(json!({"type": "response.reasoning_summary_text.done", "text": "wé"})),
            named(json!({"type": "response.reasoning_text.delta", "delta": "the same at length"})),
            named(json!({"type": "response.output_text.delta", "delta": "gefährlich 車", "logprobs": []})),
            named(json!({"type": "response.output_text.delta", "delta": " 🚗"})),
            named(json!({"type": "response.output_text.done", "text": "gefährlich 車 🚗"})),
            named(json!({"type": "response.completed", "response": {
                "model": "m-1", "status": "completed", "error": null,
                "output": [{"type": "message", "content": [{"type": "output_text", "text": "gefährlich 車 🚗"}]}],
                "usage": {"input_tokens": 120, "input_tokens_details": {"cached_tokens": 64, "cache_write_tokens": 8},
                    "output_tokens": 30, "output_tokens_details": {"reasoning_tokens": 18}},
            }})),
        ]
        .concat(),
        Dialect::Gemini => {
            let part = |part: Value, more: Value| {
                let mut event = json!({"candidates": [{"content": {"parts": [part], "role": "model"}, "index": 0}], "modelVersion": "m-1"});
                event.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
                event
            };
            let early = json!({"usageMetadata": {"promptTokenCount": 120, "totalTokenCount": 121}});
            let mut last = part(
                json!({"text": " 🚗", "thoughtSignature": "c2ln"}),
                json!({"usageMetadata": {"promptTokenCount": 112, "toolUsePromptTokenCount": 8, "cachedContentTokenCount": 64,
                    "candidatesTokenCount": 12, "thoughtsTokenCount": 18, "totalTokenCount": 150}}),
            );
            last["candidates"][0]["finishReason"] = json!("STOP");
            [
                data(part(json!({"text": "wé", "thought": true}), early)),
                data(part(json!({"text": "gefährlich 車"}), json!({}))),
                data(last),
            ]
            .concat()
        }
        Dialect::Anthropic => [
            named(json!({"type": "message_start", "message": {"model": "m-1", "content": [], "stop_reason": null,
                "usage": {"input_tokens": 48, "cache_read_input_tokens": 64, "cache_creation_input_tokens": 8, "output_tokens": 1}}})),
            named(json!({"type": "content_block_start", "index": 0, "content_block": {"type": "thinking", "thinking": "", "signature": ""}})),
            named(json!({"type": "ping"})),
            named(json!({"type": "content_block_delta", "index": 0, "delta": {"type": "thinking_delta", "thinking": "wé"}})),
            named(json!({"type": "content_block_delta", "index": 0, "delta": {"type": "signature_delta", "signature": "c2ln"}})),
            // Blocks overlap on some servers.
            named(json!({"type": "content_block_start", "index": 1, "content_block": {"type": "text", "text": ""}})),
            named(json!({"type": "content_block_delta", "index": 1, "delta": {"type": "text_delta", "text": "gefährlich 車"}})),
            named(json!({"type": "content_block_stop", "index": 0})),
            named(json!({"type": "content_block_delta", "index": 1, "delta": {"type": "text_delta", "text": " 🚗"}})),
            named(json!({"type": "content_block_stop", "index": 1})),
            named(json!({"type": "message_delta", "delta": {"stop_reason": "end_turn", "stop_sequence": null},
                "usage": {"output_tokens": 30, "output_tokens_details": {"thinking_tokens": 18}, "input_tokens": null}})),
            named(json!({"type": "message_stop"})),
        ]
        .concat(),
        Dialect::Ollama => [
            line(json!({"model": "m-1", "message": {"role": "assistant", "content": "", "thinking": "wé"}, "done": false})),
            line(json!({"model": "m-1", "message": {"role": "assistant", "content": "gefährlich 車"}, "done": false})),
            line(json!({"model": "m-1", "message": {"content": " 🚗"}, "done": false})),
            line(json!({"model": "m-1", "message": {"content": ""}, "done": true, "done_reason": "stop",
                "total_duration": 1, "prompt_eval_count": 120, "eval_count": 30})),
        ]
        .concat(),
    }
}

/// The counts of a usual answer; Ollama tells fewer, Gemini does not count what it writes to a cache.
pub fn usage_of(dialect: Dialect) -> Usage {
    let all = Usage {
        input_tokens: Some(120),
        output_tokens: Some(30),
        reasoning_tokens: Some(18),
        cached_tokens: Some(64),
        cache_write_tokens: Some(8),
        cost: None,
    };
    match dialect {
        Dialect::Gemini => Usage {
            cache_write_tokens: None,
            ..all
        },
        Dialect::Ollama => Usage {
            reasoning_tokens: None,
            cached_tokens: None,
            cache_write_tokens: None,
            ..all
        },
        _ => all,
    }
}

/// A piece of an answer, or of its reasoning.
pub fn piece(dialect: Dialect, text: &str, thought: bool) -> String {
    let kind = |yes: &'static str, no: &'static str| if thought { yes } else { no };
    match dialect {
        Dialect::OpenAiChat => {
            data(json!({"choices": [{"delta": {kind("reasoning", "content"): text}}]}))
        }
        Dialect::OpenAiResponses => {
            let kind = kind(
                "response.reasoning_text.delta",
                "response.output_text.delta",
            );
            data(json!({"type": kind, "delta": text}))
        }
        Dialect::Gemini => {
            let part = json!({"text": text, "thought": thought});
            data(json!({"candidates": [{"content": {"parts": [part]}}]}))
        }
        Dialect::Anthropic => {
            let delta = json!({kind("thinking", "text"): text});
            data(json!({"type": "content_block_delta", "delta": delta}))
        }
        Dialect::Ollama => format!(
            "{}\n",
            json!({"message": {kind("thinking", "content"): text}})
        ),
    }
}

/// The beginning of a streamed answer, with its content type.
pub fn script(dialect: Dialect) -> Script {
    match dialect {
        Dialect::Ollama => Script::lines(),
        _ => Script::events(),
    }
}

/// An event of a stream.
pub fn event(dialect: Dialect, text: &str) -> String {
    match dialect {
        Dialect::Ollama => format!("{text}\n"),
        _ => format!("data: {text}\n\n"),
    }
}

/// Where in a usual answer the model says that it is finished.
pub fn finished(dialect: Dialect) -> &'static str {
    match dialect {
        Dialect::OpenAiChat => "\"finish_reason\":\"stop\"}]}\n\n",
        Dialect::OpenAiResponses => "}}\n\n",
        Dialect::Gemini => "\"modelVersion\":\"m-1\",\"usageMetadata\":{\"promptTokenCount\":112",
        Dialect::Anthropic => "\"input_tokens\":null}}\n\n",
        Dialect::Ollama => "\"done\":true",
    }
}

/// The path of a question to `small-1`, and the header that carries the key.
pub fn asked_at(dialect: Dialect, key: &str) -> (&'static str, &'static str, String) {
    let bearer = |path| (path, "authorization", format!("Bearer {key}"));
    match dialect {
        Dialect::OpenAiChat => bearer("/v1/chat/completions"),
        Dialect::OpenAiResponses => bearer("/v1/responses"),
        Dialect::Gemini => (
            "/v1beta/models/small-1:streamGenerateContent?alt=sse",
            "x-goog-api-key",
            key.into(),
        ),
        Dialect::Anthropic => ("/v1/messages", "x-api-key", key.into()),
        Dialect::Ollama => bearer("/api/chat"),
    }
}

/// A streamed turn of the model that calls tools, each with id, name and arguments; arguments come in fragments where the
/// dialect has them so.
pub fn calling(dialect: Dialect, calls: &[(&str, &str, &str)]) -> String {
    let halves = |text: &str| {
        let middle = (0..=text.len() / 2)
            .rev()
            .find(|at| text.is_char_boundary(*at))
            .unwrap();
        [text[..middle].to_string(), text[middle..].to_string()]
    };
    let parsed = |text: &str| serde_json::from_str::<Value>(text).unwrap_or_else(|_| json!({}));
    let mut out = String::new();
    match dialect {
        Dialect::OpenAiChat => {
            let delta = |calls: Value| {
                data(
                    json!({"model": "m-1", "choices": [{"index": 0, "delta": {"tool_calls": calls}}]}),
                )
            };
            for (index, (id, name, text)) in calls.iter().enumerate() {
                out += &delta(
                    json!([{"index": index, "id": id, "type": "function", "function": {"name": name, "arguments": ""}}]),
                );
                for half in halves(text) {
                    out += &delta(json!([{"index": index, "function": {"arguments": half}}]));
                }
            }
            out += &data(
                json!({"choices": [{"index": 0, "delta": {}, "finish_reason": "tool_calls"}]}),
            );
            out += &data(
                json!({"choices": [], "usage": {"prompt_tokens": 100, "completion_tokens": 10}}),
            );
            out + "data: [DONE]\n\n"
        }
        Dialect::OpenAiResponses => {
            let mut output = vec![
                json!({"type": "reasoning", "id": "rs_1", "summary": [], "encrypted_content": "c2Vj"}),
            ];
            out += &named(
                json!({"type": "response.output_item.done", "output_index": 0, "item": output[0]}),
            );
            for (index, (id, name, text)) in calls.iter().enumerate() {
                let index = index + 1;
                let item = |arguments: &str| json!({"type": "function_call", "id": "fc_1", "call_id": id, "name": name, "arguments": arguments});
                out += &named(
                    json!({"type": "response.output_item.added", "output_index": index, "item": item("")}),
                );
                for half in halves(text) {
                    out += &named(
                        json!({"type": "response.function_call_arguments.delta", "output_index": index, "delta": half}),
                    );
                }
                out += &named(
                    json!({"type": "response.output_item.done", "output_index": index, "item": item(text)}),
                );
                output.push(item(text));
            }
            out + &named(
                json!({"type": "response.completed", "response": {"model": "m-1", "status": "completed", "output": output,
                "usage": {"input_tokens": 100, "output_tokens": 10}}}),
            )
        }
        Dialect::Gemini => {
            let parts: Vec<Value> = calls.iter().map(|(_, name, text)| {
                json!({"functionCall": {"name": name, "args": parsed(text)}, "thoughtSignature": "c2ln"})
            }).collect();
            data(
                json!({"candidates": [{"content": {"parts": parts, "role": "model"}, "finishReason": "STOP", "index": 0}],
                "modelVersion": "m-1", "usageMetadata": {"promptTokenCount": 100, "candidatesTokenCount": 10}}),
            )
        }
        Dialect::Anthropic => {
            out += &named(
                json!({"type": "message_start", "message": {"model": "m-1", "content": [], "usage": {"input_tokens": 100, "output_tokens": 1}}}),
            );
            out += &named(
                json!({"type": "content_block_start", "index": 0, "content_block": {"type": "thinking", "thinking": "", "signature": ""}}),
            );
            out += &named(
                json!({"type": "content_block_delta", "index": 0, "delta": {"type": "thinking_delta", "thinking": "hm"}}),
            );
            out += &named(
                json!({"type": "content_block_delta", "index": 0, "delta": {"type": "signature_delta", "signature": "c2ln"}}),
            );
            for (index, (id, name, text)) in calls.iter().enumerate() {
                let index = index + 1;
                out += &named(
                    json!({"type": "content_block_start", "index": index, "content_block": {"type": "tool_use", "id": id, "name": name, "input": {}}}),
                );
                for half in halves(text) {
                    out += &named(
                        json!({"type": "content_block_delta", "index": index, "delta": {"type": "input_json_delta", "partial_json": half}}),
                    );
                }
                out += &named(json!({"type": "content_block_stop", "index": index}));
            }
            out += &named(
                json!({"type": "message_delta", "delta": {"stop_reason": "tool_use"}, "usage": {"output_tokens": 10}}),
            );
            out + &named(json!({"type": "message_stop"}))
        }
        Dialect::Ollama => {
            let calls: Vec<Value> = calls.iter().map(|(_, name, text)| {
                json!({"function": {"name": name, "arguments": parsed(text)}})
            }).collect();
            out += &line(
                json!({"model": "m-1", "message": {"role": "assistant", "content": "", "tool_calls": calls}, "done": false}),
            );
            out + &line(
                json!({"model": "m-1", "message": {"content": ""}, "done": true, "done_reason": "stop", "prompt_eval_count": 100, "eval_count": 10}),
            )
        }
    }
}

/// A streamed final answer.
pub fn saying(dialect: Dialect, text: &str) -> String {
    match dialect {
        Dialect::OpenAiChat => [
            piece(dialect, text, false),
            data(json!({"choices": [{"index": 0, "delta": {}, "finish_reason": "stop"}]})),
            data(json!({"choices": [], "usage": {"prompt_tokens": 200, "completion_tokens": 20}})),
            "data: [DONE]\n\n".into(),
        ]
        .concat(),
        Dialect::OpenAiResponses => [
            piece(dialect, text, false),
            named(json!({"type": "response.completed", "response": {"model": "m-1", "status": "completed", "output": [],
                "usage": {"input_tokens": 200, "output_tokens": 20}}})),
        ]
        .concat(),
        Dialect::Gemini => data(json!({"candidates": [{"content": {"parts": [{"text": text}]}, "finishReason": "STOP"}],
            "usageMetadata": {"promptTokenCount": 200, "candidatesTokenCount": 20}})),
        Dialect::Anthropic => [
            named(json!({"type": "message_start", "message": {"model": "m-1", "content": [], "usage": {"input_tokens": 200, "output_tokens": 1}}})),
            named(json!({"type": "content_block_start", "index": 0, "content_block": {"type": "text", "text": ""}})),
            named(json!({"type": "content_block_delta", "index": 0, "delta": {"type": "text_delta", "text": text}})),
            named(json!({"type": "content_block_stop", "index": 0})),
            named(json!({"type": "message_delta", "delta": {"stop_reason": "end_turn"}, "usage": {"output_tokens": 20}})),
            named(json!({"type": "message_stop"})),
        ]
        .concat(),
        Dialect::Ollama => [
            piece(dialect, text, false),
            line(json!({"model": "m-1", "message": {"content": ""}, "done": true, "done_reason": "stop", "prompt_eval_count": 200, "eval_count": 20})),
        ]
        .concat(),
    }
}
