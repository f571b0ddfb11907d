//! Tests of the OpenAI chat protocol without a network.
#![allow(clippy::unwrap_used)]

use serde_json::json;

use super::*;
use crate::llm::decoder::Decoder;
use crate::llm::dialect::{Dialect, body};
use crate::llm::quirks::Quirks;
use crate::llm::{Chunk, Error, Message, Parameters, Role};

fn decoder() -> Decoder {
    let place = Endpoint::new("test", "http://localhost:1").place();
    Decoder::new(Dialect::OpenAiChat, place)
}

fn delta(delta: Value) -> Value {
    json!({"model": "m", "choices": [{"index": 0, "delta": delta, "finish_reason": null}]})
}

/// Reasoning, text, and the rest of the chunks of a complete answer.
fn decode(events: &[Value]) -> (String, String, Vec<Chunk>) {
    let mut decoder = decoder();
    let mut chunks: Vec<Chunk> = events
        .iter()
        .flat_map(|e| decoder.event(&e.to_string()).unwrap())
        .collect();
    chunks.extend(decoder.event("[DONE]").unwrap());
    assert!(decoder.is_done());
    let (mut reasoning, mut text, mut rest) = (String::new(), String::new(), Vec::new());
    for chunk in chunks {
        match chunk {
            Chunk::Reasoning(t) => reasoning.push_str(&t),
            Chunk::Text(t) => text.push_str(&t),
            other => rest.push(other),
        }
    }
    (reasoning, text, rest)
}

fn request() -> Request {
    Request {
        model: "gpt".into(),
        messages: vec![Message::new(Role::User, "hi")],
        parameters: Parameters {
            log_probabilities: false,
            tools: None,
            temperature: Some(0.5),
            max_tokens: Some(100),
            seed: Some(7),
            effort: None,
        },
        schema: Some(Schema {
            is_bounded: false,
            name: "my verdict!".into(),
            schema: json!({"type": "object"}),
        }),
        tools: None,
    }
}

#[test]
fn the_limit_has_the_name_that_the_server_knows() {
    let mut endpoint = Endpoint::new("x", "http://localhost:8080");
    assert_eq!(body(&endpoint, &request())["max_tokens"], 100);
    endpoint.quirks = Quirks {
        max_completion_tokens: true,
        ..Quirks::default()
    };
    assert_eq!(body(&endpoint, &request())["max_completion_tokens"], 100);
}

#[test]
fn what_was_not_asked_is_not_sent() {
    let mut endpoint = Endpoint::new("x", "http://localhost:8080");
    let mut bare = Request {
        parameters: Parameters::default(),
        ..request()
    };
    let keys = |value: Value| {
        value
            .as_object()
            .unwrap()
            .keys()
            .cloned()
            .collect::<Vec<_>>()
            .join(" ")
    };
    endpoint.response_format = ResponseFormat::Off;
    assert_eq!(
        keys(body(&endpoint, &bare)),
        "model messages stream stream_options"
    );
    endpoint.response_format = ResponseFormat::JsonObject;
    bare.schema = None;
    assert_eq!(
        keys(body(&endpoint, &bare)),
        "model messages stream stream_options"
    );
}

#[test]
fn reasoning_that_is_counted_beside_the_answer_is_added() {
    let counted = |total| {
        let usage = json!({
            "prompt_tokens": 32, "completion_tokens": 9, "total_tokens": total,
            "completion_tokens_details": {"reasoning_tokens": 94},
        });
        usage_of(&usage).output_tokens
    };
    assert_eq!((counted(135), counted(41)), (Some(103), Some(9)));
}

#[test]
fn thinking_is_switched_by_the_name_that_the_server_knows() {
    let mut endpoint = Endpoint::new("x", "https://x.org");
    let mut asked = request();
    for (effort, on) in [(Effort::Off, false), (Effort::High, true)] {
        asked.parameters.effort = Some(effort);
        endpoint.quirks.efforts = Some(Efforts::Switch);
        assert_eq!(body(&endpoint, &asked)["enable_thinking"], on);
        endpoint.quirks.efforts = Some(Efforts::Template);
        let template = &body(&endpoint, &asked)["chat_template_kwargs"];
        assert_eq!(template["enable_thinking"], on);
    }
}

#[test]
fn a_usual_answer() {
    let (reasoning, text, rest) = decode(&[
        delta(json!({"role": "assistant", "content": null})),
        delta(json!({"content": "Hel"})),
        delta(json!({"content": "lo"})),
        json!({"choices": [{"delta": {}, "finish_reason": "stop"}]}),
        json!({"choices": [], "usage": {
            "prompt_tokens": 10, "completion_tokens": 5.0, "total_tokens": 15, "cost": 0.0125,
            "prompt_tokens_details": {"cached_tokens": 4}, "completion_tokens_details": {"reasoning_tokens": 2},
        }}),
    ]);
    assert_eq!((reasoning.as_str(), text.as_str()), ("", "Hello"));
    let usage = Usage {
        input_tokens: Some(10),
        output_tokens: Some(5),
        reasoning_tokens: Some(2),
        cached_tokens: Some(4),
        cache_write_tokens: None,
        cost: Some(Cost {
            usd: 0.0125,
            source: CostSource::Server,
        }),
    };
    assert_eq!(
        rest,
        [
            Chunk::Started {
                model: Some("m".into())
            },
            Chunk::Usage(usage),
            Chunk::Finished(Finish::Stop)
        ]
    );
}

#[test]
fn reasoning_is_read_from_one_field_only() {
    let variants = [
        json!({"reasoning_content": "why"}),
        json!({"reasoning": "why"}),
        json!({"reasoning_details": [{"type": "reasoning.text", "text": "why"}]}),
        json!({"reasoning_details": [{"type": "reasoning.encrypted", "data": "xx"}, {"summary": "why"}]}),
        json!({"reasoning_content": "why", "reasoning": "why", "reasoning_details": [{"text": "why"}]}),
        json!({"reasoning_content": "", "reasoning": "why", "reasoning_details": [{"text": "why"}]}),
        json!({"content": [{"type": "thinking", "thinking": [{"type": "text", "text": "why"}]}]}),
    ];
    for variant in variants {
        let (reasoning, text, _) =
            decode(&[delta(variant.clone()), delta(json!({"content": "so"}))]);
        assert_eq!(
            (reasoning.as_str(), text.as_str()),
            ("why", "so"),
            "{variant}"
        );
    }
    // The same text in another field of a later event, and once more in tags.
    let (reasoning, text, _) = decode(&[
        delta(json!({"reasoning": "why"})),
        delta(json!({"reasoning_details": [{"text": "why"}]})),
        delta(json!({"content": "<think>why</think>so"})),
    ]);
    assert_eq!((reasoning.as_str(), text.as_str()), ("why", "so"));
}

#[test]
fn think_tags_are_split_off_across_events() {
    let pieces = ["<th", "ink>be", "cause</", "think>\n", "\n{}"];
    let (reasoning, text, _) = decode(&pieces.map(|p| delta(json!({"content": p}))));
    assert_eq!((reasoning.as_str(), text.as_str()), ("because", "{}"));
}

#[test]
fn why_it_stopped() {
    let finish = |reason: Value, refusal: Value| {
        let last = json!({"choices": [{"delta": {"refusal": refusal}, "finish_reason": reason}]});
        decode(&[delta(json!({"content": "a"})), last])
            .2
            .pop()
            .unwrap()
    };
    assert_eq!(
        finish(json!("stop"), Value::Null),
        Chunk::Finished(Finish::Stop)
    );
    assert_eq!(
        finish(json!("length"), Value::Null),
        Chunk::Finished(Finish::Length)
    );
    assert_eq!(
        finish(json!("content_filter"), Value::Null),
        Chunk::Finished(Finish::ContentFilter)
    );
    assert_eq!(
        finish(json!("tool_calls"), Value::Null),
        Chunk::Finished(Finish::Other("tool_calls".into()))
    );
    assert_eq!(
        finish(Value::Null, Value::Null),
        Chunk::Finished(Finish::Other("unstated".into()))
    );
    assert_eq!(
        finish(json!("stop"), json!("I will not")),
        Chunk::Finished(Finish::Refusal("I will not".into()))
    );
}

#[test]
fn odd_events_are_borne() {
    let (_, text, rest) = decode(&[
        json!({"type": "ping"}),
        json!({"model": "", "choices": [], "prompt_filter_results": []}),
        json!({"error": null, "choices": null, "usage": null}),
        json!({"choices": [{"index": 1, "delta": {"content": "other"}}, {"delta": {"content": "this"}}]}),
        json!({"choices": [{"index": 0, "delta": null, "message": {"content": "this again"}, "finish_reason": ""}]}),
        json!({"choices": [{"index": 0}], "usage": {"prompt_tokens": "many"}}),
        json!({"choices": "?", "model": 5}),
    ]);
    assert_eq!(text, "this");
    assert_eq!(rest.first(), Some(&Chunk::Started { model: None }));
    assert!(rest.contains(&Chunk::Usage(Usage::default())));
}

#[test]
fn errors_inside_the_stream() {
    for (event, message, code) in [
        (
            json!({"error": {"message": "gone", "code": 502}, "choices": [{"delta": {"content": ""}}]}),
            "gone",
            Some("502"),
        ),
        (
            json!({"error": {"message": "gone", "code": "overloaded"}}),
            "gone",
            Some("overloaded"),
        ),
        (
            json!({"error": {"message": "gone", "code": null}}),
            "gone",
            None,
        ),
        (json!({"error": "gone"}), "gone", None),
        (
            json!({"object": "error", "message": "gone", "code": 400}),
            "gone",
            Some("400"),
        ),
        (
            json!({"choices": [{"error": {"message": "gone"}}]}),
            "gone",
            None,
        ),
    ] {
        match decoder().event(&event.to_string()) {
            Err(Error::Provider {
                message: m,
                code: c,
                ..
            }) => assert_eq!((m.as_str(), c.as_deref()), (message, code)),
            other => panic!("{event}: {other:?}"),
        }
    }
    assert!(
        matches!(decoder().error_event(r#"{"message":"gone"}"#), Error::Provider { message, .. } if message == "gone")
    );
    // What says nothing is passed over.
    for nothing in ["null", "\"ping\"", "[1,2]", "7"] {
        assert_eq!(decoder().event(nothing).unwrap(), [], "{nothing}");
    }
    for nonsense in ["{\"choices\":[", "hello"] {
        assert!(
            matches!(decoder().event(nonsense), Err(Error::Malformed { .. })),
            "{nonsense}"
        );
    }
}

#[test]
fn an_end_without_finish_is_no_success() {
    let mut decoder = decoder();
    decoder
        .event(&delta(json!({"reasoning": "wé"})).to_string())
        .unwrap();
    decoder
        .event(&delta(json!({"content": "<thi"})).to_string())
        .unwrap();
    let end = decoder.ended(|place, received| Error::Truncated {
        place,
        received,
        why: "cut".into(),
    });
    assert_eq!(end[0], Ok(Chunk::Text("<thi".into())));
    assert!(matches!(end[1], Err(Error::Truncated { received: 6, .. })));
    assert_eq!(end.len(), 2);
}

#[test]
fn a_document_is_an_answer_too() {
    let body = json!({
        "model": "m-1",
        "choices": [{"index": 0, "message": {"content": "<think>why</think>so"}, "finish_reason": "length"}],
        "usage": {"prompt_tokens": 1, "completion_tokens": 2, "prompt_cache_hit_tokens": 1},
    });
    let chunks = decoder().document(&body.to_string()).unwrap();
    let usage = Usage {
        input_tokens: Some(1),
        output_tokens: Some(2),
        cached_tokens: Some(1),
        ..Usage::default()
    };
    assert_eq!(
        chunks,
        [
            Chunk::Started {
                model: Some("m-1".into())
            },
            Chunk::Reasoning("why".into()),
            Chunk::Text("so".into()),
            Chunk::Usage(usage),
            Chunk::Finished(Finish::Length),
        ]
    );
    assert!(matches!(
        decoder().document("{\"choices\":[{"),
        Err(Error::Truncated { .. })
    ));
    assert!(matches!(
        decoder().document("{\"models\":[]}"),
        Err(Error::Malformed { .. })
    ));
    assert!(matches!(
        decoder().document("{\"error\":\"x\"}"),
        Err(Error::Provider { .. })
    ));
}
