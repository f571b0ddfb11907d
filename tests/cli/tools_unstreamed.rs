//! Models that call tools behind servers that do not stream: whole JSON documents, round by round, in every dialect.

use nearmiss::llm::Dialect;
use serde_json::{Value, json};

use super::CUT_IN;
use super::support::program::Home;
use super::support::server::{Recorded, Script, Server};

const VERDICT: &str =
    r#"{"collision": false, "obstacles": [], "justification": "The gap stays 2 m."}"#;

/// A call: its id, its tool, its arguments.
type Call = (&'static str, &'static str, &'static str);

/// The rounds that the model of the tests calls.
const ROUNDS: [&[Call]; 2] = [
    &[
        ("call_a", "list_obstacles", "{}"),
        ("call_b", "distance", r#"{"obstacle": 304}"#),
    ],
    &[("call_c", "distance", r#"{"obstacle": 304, "t": 3}"#)],
];

/// A turn that calls tools, as each API documents it for requests without streaming.
fn calling(dialect: Dialect, calls: &[Call]) -> Value {
    let parsed = |text: &str| serde_json::from_str::<Value>(text).unwrap();
    let each = |of: &dyn Fn(&Call) -> Value| calls.iter().map(of).collect::<Vec<_>>();
    match dialect {
        Dialect::OpenAiChat => json!({
            "id": "x", "object": "chat.completion", "model": "m-1",
            "choices": [{"index": 0, "finish_reason": "tool_calls", "message": {
                "role": "assistant", "content": null,
                "tool_calls": each(&|(id, name, text)| json!({
                    "id": id, "type": "function", "function": {"name": name, "arguments": text},
                })),
            }}],
            "usage": {"prompt_tokens": 100, "completion_tokens": 10},
        }),
        Dialect::OpenAiResponses => {
            let mut output = vec![
                json!({"type": "reasoning", "id": "rs_1", "summary": [], "encrypted_content": "c2Vj"}),
            ];
            output.extend(each(&|(id, name, text)| {
                json!({
                    "type": "function_call", "id": "fc_1", "call_id": id, "name": name, "arguments": text,
                })
            }));
            json!({
                "object": "response", "model": "m-1", "status": "completed", "output": output,
                "usage": {"input_tokens": 100, "output_tokens": 10},
            })
        }
        Dialect::Gemini => {
            let parts = each(&|(_, name, text)| {
                json!({
                    "functionCall": {"name": name, "args": parsed(text)}, "thoughtSignature": "c2ln",
                })
            });
            json!({
                "candidates": [{
                    "content": {"parts": parts, "role": "model"}, "finishReason": "STOP", "index": 0,
                }],
                "modelVersion": "m-1",
                "usageMetadata": {"promptTokenCount": 100, "candidatesTokenCount": 10},
            })
        }
        Dialect::Anthropic => {
            let mut content =
                vec![json!({"type": "thinking", "thinking": "hm", "signature": "c2ln"})];
            content.extend(each(&|(id, name, text)| {
                json!({
                    "type": "tool_use", "id": id, "name": name, "input": parsed(text),
                })
            }));
            json!({
                "type": "message", "role": "assistant", "model": "m-1", "content": content,
                "stop_reason": "tool_use", "usage": {"input_tokens": 100, "output_tokens": 10},
            })
        }
        Dialect::Ollama => {
            let calls = each(&|(_, name, text)| {
                json!({
                    "function": {"name": name, "arguments": parsed(text)},
                })
            });
            json!({
                "model": "m-1", "done": true, "done_reason": "stop",
                "message": {"role": "assistant", "content": "", "tool_calls": calls},
                "prompt_eval_count": 100, "eval_count": 10,
            })
        }
    }
}

/// The last answer, in the same form.
fn saying(dialect: Dialect, text: &str) -> Value {
    match dialect {
        Dialect::OpenAiChat => json!({
            "model": "m-1",
            "choices": [{"index": 0, "message": {"role": "assistant", "content": text}, "finish_reason": "stop"}],
            "usage": {"prompt_tokens": 200, "completion_tokens": 20},
        }),
        Dialect::OpenAiResponses => json!({
            "model": "m-1", "status": "completed",
            "output": [{"type": "message", "content": [{"type": "output_text", "text": text}]}],
            "usage": {"input_tokens": 200, "output_tokens": 20},
        }),
        Dialect::Gemini => json!({
            "candidates": [{"content": {"parts": [{"text": text}]}, "finishReason": "STOP"}],
            "usageMetadata": {"promptTokenCount": 200, "candidatesTokenCount": 20},
        }),
        Dialect::Anthropic => json!({
            "type": "message", "model": "m-1", "content": [{"type": "text", "text": text}],
            "stop_reason": "end_turn", "usage": {"input_tokens": 200, "output_tokens": 20},
        }),
        Dialect::Ollama => json!({
            "model": "m-1", "message": {"role": "assistant", "content": text}, "done": true,
            "done_reason": "stop", "prompt_eval_count": 200, "eval_count": 20,
        }),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn calls_in_whole_documents_are_answered_stored_and_counted_in_every_dialect() {
    for dialect in Dialect::ALL {
        let home = Home::new();
        let server = Server::answering(move |number, _: &Recorded| {
            let turn = match ROUNDS.get(number) {
                Some(calls) => calling(dialect, calls),
                None => saying(dialect, VERDICT),
            };
            Some(Script::json(200, &turn.to_string()))
        })
        .await;
        let arguments = [
            "ask",
            CUT_IN,
            "--model",
            "lab/tiny",
            "--base-url",
            server.base_url(),
            &format!("--set=dialect={}", dialect.name()),
            "--format=json",
            "--set=tools=on",
        ];
        let asked = || {
            tokio::task::block_in_place(|| home.run(&arguments))
                .status(0)
                .json()
        };
        let document = asked();
        assert_eq!(document["dangerous"], false, "{dialect:?}");
        assert_eq!(server.requests().len(), 3, "{dialect:?}");
        let requests = server.requests();
        let bodies: Vec<String> = { requests.iter() }
            .map(|request| String::from_utf8(request.body.clone()).unwrap())
            .collect();
        // What was called is told again with its results, and what the server has to see again.
        assert!(!bodies[0].contains("call_a"));
        assert!(bodies[1].contains("list_obstacles"), "{dialect:?}");
        assert!(
            bodies[2].contains("nothing after t = 0 can be asked"),
            "{dialect:?}"
        );
        let echo = match dialect {
            Dialect::OpenAiResponses => "\"encrypted_content\":\"c2Vj\"",
            Dialect::Gemini => "\"thoughtSignature\":\"c2ln\"",
            Dialect::Anthropic => "\"signature\":\"c2ln\"",
            Dialect::OpenAiChat | Dialect::Ollama => "\"role\":\"tool\"",
        };
        assert!(bodies[1].contains(echo), "{dialect:?} {}", bodies[1]);
        let rows = home.rows("SELECT tool_rounds FROM runs");
        let rounds: Value =
            serde_json::from_str(rows[0]["tool_rounds"].as_deref().unwrap()).unwrap();
        let results = |round: usize| rounds[round]["results"].as_array().unwrap().len();
        assert_eq!([results(0), results(1)], [2, 1], "{dialect:?} {rounds}");
        let used = [&document["input_tokens"], &document["output_tokens"]];
        assert_eq!(used, [&json!(400), &json!(40)], "{dialect:?}");
        assert_eq!(asked()["run"], document["run"], "the store answers");
        assert_eq!(server.requests().len(), 3);
    }
}
