//! Numbers that cannot be true, in every dialect: they cost no answer.

use serde_json::{Value, json};

use super::support::server::Script;
use super::{End, Row, data, row, usual, verdict};

/// What a server may write where a count belongs. What is no number in JSON stands in quotes.
const ODD: [(&str, &str); 10] = [
    ("the largest of 64 bits", "18446744073709551615"),
    ("more than 64 bits", "18446744073709551616000"),
    ("one too many for the store", "9223372036854775808"),
    ("a trillion", "1000000000000"),
    ("negative", "-1"),
    ("a fraction", "1.5"),
    ("1e308", "1e308"),
    ("a word", "\"many\""),
    ("null", "null"),
    ("an object", "{\"total\":{\"total\":3}}"),
];

const DIALECTS: [&str; 5] = [
    "openai_chat",
    "openai_responses",
    "gemini",
    "anthropic",
    "ollama",
];

pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for dialect in DIALECTS {
        for (name, number) in ODD {
            rows.push(Row {
                name: format!("usage: {name} ({dialect})"),
                dialect,
                script: answer(dialect, number),
                end: End::Verdict,
            });
        }
    }
    for (name, cost) in [
        ("negative", "-1"),
        ("1e300", "1e300"),
        ("a word", "\"free\""),
    ] {
        let usage = format!(
            "data: {{\"choices\":[],\"usage\":{{\"prompt_tokens\":1,\"completion_tokens\":1,\"cost\":{cost}}}}}\n\n"
        );
        let script = Script::events().send(usage + &usual());
        rows.push(row(&format!("usage: cost {name}"), script, End::Verdict));
    }
    let contradiction = data(&json!({"choices": [], "usage": {
        "prompt_tokens": 1, "completion_tokens": 1, "prompt_tokens_details": {"cached_tokens": 999_999_999},
    }}));
    let script = Script::events().send(contradiction + &usual());
    rows.push(row(
        "usage: more from the cache than there is",
        script,
        End::Verdict,
    ));
    rows
}

/// A whole answer of a dialect with this number in place of every count.
fn answer(dialect: &str, number: &str) -> Script {
    let n = "NUMBER";
    let text = verdict();
    let events: Vec<Value> = match dialect {
        "openai_responses" => vec![
            json!({"type": "response.output_text.delta", "delta": text}),
            json!({"type": "response.completed", "response": {"model": "m", "status": "completed", "output": [],
                "usage": {"input_tokens": n, "output_tokens": n, "input_tokens_details": {"cached_tokens": n},
                    "output_tokens_details": {"reasoning_tokens": n}}}}),
        ],
        "gemini" => vec![json!({"modelVersion": "m",
            "candidates": [{"content": {"parts": [{"text": text}]}, "finishReason": "STOP"}],
            "usageMetadata": {"promptTokenCount": n, "candidatesTokenCount": n, "thoughtsTokenCount": n,
                "cachedContentTokenCount": n, "toolUsePromptTokenCount": n}})],
        "anthropic" => vec![
            json!({"type": "message_start", "message": {"model": "m", "usage": {"input_tokens": n,
                "cache_read_input_tokens": n, "cache_creation_input_tokens": n, "output_tokens": n}}}),
            json!({"type": "content_block_delta", "delta": {"type": "text_delta", "text": text}}),
            json!({"type": "message_delta", "delta": {"stop_reason": "end_turn"}, "usage": {"output_tokens": n}}),
            json!({"type": "message_stop"}),
        ],
        "ollama" => vec![
            json!({"model": "m", "message": {"content": text}, "done": false}),
            json!({"done": true, "done_reason": "stop", "prompt_eval_count": n, "eval_count": n}),
        ],
        _ => vec![
            json!({"model": "m", "choices": [{"delta": {"content": text}, "finish_reason": "stop"}]}),
            json!({"choices": [], "usage": {"prompt_tokens": n, "completion_tokens": n, "cost": n,
                "prompt_tokens_details": {"cached_tokens": n, "cache_write_tokens": n},
                "completion_tokens_details": {"reasoning_tokens": n}}}),
        ],
    };
    let quoted = format!("\"{n}\"");
    let lines = events.iter().map(|event| match dialect {
        "ollama" => format!("{event}\n"),
        _ => data(event),
    });
    let body = lines.collect::<String>().replace(&quoted, number);
    match dialect {
        "ollama" => Script::lines().send(body),
        "openai_chat" => Script::events().send(body + super::DONE),
        _ => Script::events().send(body),
    }
}
