//! Calls of tools on the wire: read in fragments cut anywhere, sent again with their results.

use nearmiss::llm::{
    Chunk, Dialect, Endpoint, Finish, Request, ToolRound, ToolSpec, ToolTurn, Toolbox, body,
    decode, sends_form,
};
use serde_json::{Value, json};

use super::request;
use super::support::dialects::calling;

const CALLS: [(&str, &str, &str); 2] = [
    ("call_a", "distance", r#"{"obstacle": 304, "t": -0.5}"#),
    (
        "call_b",
        "measure",
        r#"{"id": "ttc", "obstacle": 301, "word": "é車"}"#,
    ),
];

fn turn(items: &[Result<Chunk, nearmiss::llm::Error>]) -> Option<&ToolTurn> {
    items.iter().find_map(|item| match item {
        Ok(Chunk::ToolCalls(turn)) => Some(turn),
        _ => None,
    })
}

#[test]
fn calls_are_read_wherever_the_stream_is_cut() {
    for dialect in Dialect::ALL {
        let stream = calling(dialect, &CALLS).into_bytes();
        let whole = decode(dialect, [&stream[..]]);
        let read = turn(&whole).unwrap_or_else(|| panic!("{dialect:?} {whole:?}"));
        for (call, (_, name, arguments)) in read.calls.iter().zip(CALLS) {
            assert_eq!(call.name, name, "{dialect:?}");
            let said: Value = serde_json::from_str(&call.arguments).unwrap();
            assert_eq!(said, serde_json::from_str::<Value>(arguments).unwrap());
        }
        assert_eq!(read.calls.len(), 2, "{dialect:?}");
        assert!(!read.calls[0].id.is_empty() && read.calls[0].id != read.calls[1].id);
        assert!(matches!(
            whole.last(),
            Some(Ok(Chunk::Finished(Finish::ToolCalls)))
        ));
        for cut in 1..stream.len() {
            let items = decode(dialect, [&stream[..cut], &stream[cut..]]);
            assert_eq!(turn(&items), Some(read), "{dialect:?} cut at {cut}");
            // A stream that ends here has called nothing, or all of it.
            let ended = decode(dialect, [&stream[..cut]]);
            match ended.last() {
                Some(Ok(Chunk::Finished(Finish::ToolCalls))) => {
                    assert_eq!(turn(&ended), Some(read), "{dialect:?} ended at {cut}");
                }
                Some(Err(_)) => assert_eq!(turn(&ended), None, "{dialect:?} ended at {cut}"),
                other => panic!("{dialect:?} ended at {cut}: {other:?}"),
            }
        }
    }
}

#[test]
fn each_call_that_is_sent_again_has_a_result() {
    let many: Vec<(String, &str, &str)> = (0..80)
        .map(|n| (format!("call_{n}_x"), "distance", r#"{"obstacle": 304}"#))
        .collect();
    let many: Vec<(&str, &str, &str)> = many
        .iter()
        .map(|(id, n, a)| (id.as_str(), *n, *a))
        .collect();
    for dialect in Dialect::ALL {
        let items = decode(dialect, [calling(dialect, &many).as_bytes()]);
        let turn = turn(&items).unwrap().clone();
        assert!((2..=80).contains(&turn.calls.len()), "{dialect:?}");
        let results = vec![r#"{"distance":2.02}"#.to_string(); turn.calls.len()];
        let mut request = after_a_round(dialect, true);
        let calls = turn.calls.len();
        request.tools.as_mut().unwrap().rounds = vec![ToolRound { turn, results }];
        let mut endpoint = Endpoint::new("lab", "https://example.org");
        endpoint.dialect = dialect;
        let sent = body(&endpoint, &request).to_string();
        let (call, result) = match dialect {
            Dialect::OpenAiChat => (r#""type":"function"}"#, r#""role":"tool""#),
            Dialect::OpenAiResponses => (
                r#""type":"function_call""#,
                r#""type":"function_call_output""#,
            ),
            Dialect::Anthropic => (r#""type":"tool_use""#, r#""type":"tool_result""#),
            Dialect::Gemini => (r#""functionCall":"#, r#""functionResponse":"#),
            Dialect::Ollama => (r#""arguments":"#, r#""role":"tool""#),
        };
        let count = |word: &str| sent.matches(word).count();
        assert_eq!(count(result), calls, "{dialect:?}");
        if dialect != Dialect::OpenAiChat {
            assert_eq!(count(call), calls, "{dialect:?}");
        }
    }
}

#[test]
fn calls_that_share_a_number_are_told_apart_by_their_ids() {
    let piece = |call: Value| {
        let delta = json!({"choices": [{"index": 0, "delta": {"tool_calls": [call]}}]});
        format!("data: {delta}\n\n")
    };
    let fragment = |id: Option<&str>, name: Option<&str>, arguments: &str| {
        let mut call = json!({"index": 0, "function": {"arguments": arguments}});
        if let (Some(id), Some(name)) = (id, name) {
            call["id"] = id.into();
            call["function"]["name"] = name.into();
        }
        piece(call)
    };
    let stream = [
        fragment(Some("a"), Some("distance"), r#"{"obstacle":"#),
        fragment(None, None, "304}"),
        fragment(Some("b"), Some("measure"), r#"{"obstacle":"#),
        fragment(None, None, "301}"),
        // Some say the id with every fragment.
        fragment(Some("c"), Some("distance"), r#"{"obstacle":"#),
        fragment(Some("c"), Some("distance"), "302}"),
        "data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"tool_calls\"}]}\n\ndata: [DONE]\n\n".into(),
    ];
    let items = decode(Dialect::OpenAiChat, [stream.concat().as_bytes()]);
    let read = turn(&items).unwrap();
    let calls: Vec<(&str, &str, &str)> = { read.calls.iter() }
        .map(|call| {
            (
                call.id.as_str(),
                call.name.as_str(),
                call.arguments.as_str(),
            )
        })
        .collect();
    assert_eq!(
        calls,
        [
            ("a", "distance", r#"{"obstacle":304}"#),
            ("b", "measure", r#"{"obstacle":301}"#),
            ("c", "distance", r#"{"obstacle":302}"#),
        ]
    );
}

#[test]
fn thoughts_between_calls_go_back_in_their_places() {
    let dialect = Dialect::OpenAiResponses;
    let thought =
        |n: usize| json!({"type": "reasoning", "id": n, "summary": [], "encrypted_content": "x"});
    let call = |id: &str| json!({"type": "function_call", "call_id": id, "name": "distance", "arguments": "{}"});
    let items = [thought(0), call("a"), thought(1), call("b")];
    let done = items.iter().enumerate().map(|(index, item)| {
        let event =
            json!({"type": "response.output_item.done", "output_index": index, "item": item});
        format!("event: response.output_item.done\ndata: {event}\n\n")
    });
    let end =
        json!({"type": "response.completed", "response": {"status": "completed", "output": items}});
    let stream = done.collect::<String>() + &format!("event: response.completed\ndata: {end}\n\n");
    let items = decode(dialect, [stream.as_bytes()]);
    let read = turn(&items).unwrap().clone();
    assert_eq!(read.calls.len(), 2);
    let mut request = after_a_round(dialect, true);
    let mut endpoint = Endpoint::new("lab", "https://example.org");
    endpoint.dialect = dialect;
    let mut kinds = |echo: Option<Vec<Value>>| -> Vec<String> {
        let mut turn = read.clone();
        turn.echo = echo.unwrap_or(turn.echo);
        let results = vec!["{}".to_string(); 2];
        request.tools.as_mut().unwrap().rounds = vec![ToolRound { turn, results }];
        let sent = body(&endpoint, &request);
        let input = sent["input"].as_array().unwrap().iter();
        input
            .filter_map(|i| i["type"].as_str().map(str::to_owned))
            .collect()
    };
    let outputs = ["function_call_output"; 2];
    let pair = ["reasoning", "function_call"];
    assert_eq!(kinds(None), [&pair[..], &pair, &outputs].concat());
    // Rounds that were stored before calls had places.
    assert_eq!(
        kinds(Some(vec![thought(0)])),
        [&pair[..], &["function_call"], &outputs].concat()
    );
}

/// A request after one round.
fn after_a_round(dialect: Dialect, may_call: bool) -> Request {
    let items = decode(dialect, [calling(dialect, &CALLS).as_bytes()]);
    let turn = turn(&items).unwrap().clone();
    let results = vec![
        r#"{"distance":2.02}"#.to_string(),
        r#"{"error":"no"}"#.to_string(),
    ];
    Request {
        tools: Some(Toolbox {
            specs: vec![ToolSpec {
                name: "distance".into(),
                about: "How far.".into(),
                schema: json!({"type": "object", "properties": {}}),
            }],
            rounds: vec![ToolRound { turn, results }],
            may_call,
        }),
        ..request()
    }
}

#[test]
fn rounds_are_sent_again_in_the_form_of_each_dialect() {
    for dialect in Dialect::ALL {
        let mut endpoint = Endpoint::new("lab", "https://example.org");
        endpoint.dialect = dialect;
        let sent = body(&endpoint, &after_a_round(dialect, true));
        let last = body(&endpoint, &after_a_round(dialect, false));
        let text = sent.to_string();
        assert!(text.contains("2.02"), "{dialect:?} {text}");
        match dialect {
            Dialect::OpenAiChat => {
                assert_eq!(sent["tools"][0]["function"]["name"], "distance");
                let messages = sent["messages"].as_array().unwrap();
                let [.., said, first, second] = &messages[..] else {
                    panic!()
                };
                assert_eq!(said["tool_calls"][1]["id"], "call_b");
                assert_eq!(said["tool_calls"][0]["function"]["arguments"], CALLS[0].2);
                assert_eq!(
                    (&first["role"], &first["tool_call_id"]),
                    (&json!("tool"), &json!("call_a"))
                );
                assert_eq!(second["content"], r#"{"error":"no"}"#);
                assert_eq!(last["tool_choice"], "none");
                // Servers on this machine take no form beside tools.
                for (address, beside_tools) in
                    [("https://example.org", true), ("http://127.0.0.1:1", false)]
                {
                    let mut endpoint = Endpoint::new("lab", address);
                    endpoint.dialect = dialect;
                    endpoint.response_format = nearmiss::llm::ResponseFormat::JsonSchema;
                    let sent = |may| sends_form(&endpoint, &after_a_round(dialect, may));
                    assert_eq!([sent(true), sent(false)], [beside_tools, true], "{address}");
                }
            }
            Dialect::OpenAiResponses => {
                assert_eq!(sent["tools"][0]["name"], "distance");
                let input = sent["input"].as_array().unwrap();
                let kinds: Vec<&str> = input.iter().filter_map(|i| i["type"].as_str()).collect();
                assert_eq!(
                    kinds,
                    [
                        "reasoning",
                        "function_call",
                        "function_call",
                        "function_call_output",
                        "function_call_output"
                    ]
                );
                assert_eq!(input.last().unwrap()["call_id"], "call_b");
                assert_eq!(last["tool_choice"], "none");
            }
            Dialect::Gemini => {
                let turns = sent["contents"].as_array().unwrap();
                let [.., said, results] = &turns[..] else {
                    panic!()
                };
                assert_eq!(said["role"], "model");
                assert_eq!(said["parts"][0]["thoughtSignature"], "c2ln");
                assert_eq!(
                    results["parts"][0]["functionResponse"]["response"]["result"]["distance"],
                    2.02
                );
                assert!(!sends_form(&endpoint, &after_a_round(dialect, true)));
                assert!(sends_form(&endpoint, &after_a_round(dialect, false)));
                // A form and functions exclude each other, even functions that may not be called.
                assert!(last.get("tools").is_none() && last.get("toolConfig").is_none());
                let mut formless = endpoint.clone();
                formless.response_format = nearmiss::llm::ResponseFormat::Off;
                let last_formless = body(&formless, &after_a_round(dialect, false));
                assert_eq!(
                    last_formless["toolConfig"]["functionCallingConfig"]["mode"],
                    "NONE"
                );
                assert!(sent["generationConfig"].get("responseJsonSchema").is_none());
                assert!(last["generationConfig"].get("responseJsonSchema").is_some());
            }
            Dialect::Anthropic => {
                let turns = sent["messages"].as_array().unwrap();
                let [.., said, results] = &turns[..] else {
                    panic!()
                };
                assert_eq!(
                    said["content"][0],
                    json!({"type": "thinking", "thinking": "hm", "signature": "c2ln"})
                );
                assert_eq!(said["content"][1]["input"]["obstacle"], 304);
                assert_eq!(results["content"][1]["tool_use_id"], "call_b");
                assert_eq!(last["tool_choice"]["type"], "none");
            }
            Dialect::Ollama => {
                let messages = sent["messages"].as_array().unwrap();
                let [.., said, _, second] = &messages[..] else {
                    panic!()
                };
                assert_eq!(
                    said["tool_calls"][0]["function"]["arguments"]["obstacle"],
                    304
                );
                assert_eq!(
                    (&second["role"], &second["tool_name"]),
                    (&json!("tool"), &json!("measure"))
                );
                assert!(sent.get("format").is_none() && last.get("format").is_some());
                assert!(last.get("tools").is_none());
            }
        }
    }
}
