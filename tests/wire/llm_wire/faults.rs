//! Every dialect's ways not to answer: refusals, filters, limits, errors in the middle, statuses that pass and that
//! do not.

use nearmiss::llm::{Dialect, decode};
use serde_json::Value;

use super::dialects::sorted;
use super::support::dialects::{data, event, line, named, piece, script, usual_of};
use super::*;

fn finish(dialect: Dialect, body: &str) -> (String, Finish) {
    let (_, text, rest) = sorted(decode(dialect, [body.as_bytes()]));
    match rest.last() {
        Some(Chunk::Finished(finish)) => (text, finish.clone()),
        other => panic!("{dialect:?}: {other:?}"),
    }
}

fn chat(delta: Value, reason: &str) -> String {
    data(json!({"choices": [{"index": 0, "delta": delta, "finish_reason": reason}]})) + DONE
}

fn responses(events: &[Value], status: &str, more: Value) -> String {
    let mut response = json!({"model": "m-1", "status": status, "output": []});
    response
        .as_object_mut()
        .unwrap()
        .extend(more.as_object().unwrap().clone());
    let events: String = events.iter().cloned().map(named).collect();
    events + &named(json!({"type": format!("response.{status}"), "response": response}))
}

fn gemini(text: &str, reason: &str) -> String {
    data(json!({"candidates": [{"content": {"parts": [{"text": text}]}, "finishReason": reason}]}))
}

fn anthropic(text: &str, reason: &str) -> String {
    [
        named(json!({"type": "message_start", "message": {"model": "m-1"}})),
        named(json!({"type": "content_block_delta", "index": 0, "delta": {"type": "text_delta", "text": text}})),
        named(json!({"type": "message_delta", "delta": {"stop_reason": reason}})),
        named(json!({"type": "message_stop"})),
    ]
    .concat()
}

fn ollama(text: &str, reason: &str) -> String {
    line(json!({"model": "m-1", "message": {"content": text}, "done": false}))
        + &line(json!({"model": "m-1", "done": true, "done_reason": reason}))
}

#[test]
fn ways_to_stop() {
    let text_delta = |text: &str| json!({"type": "response.output_text.delta", "delta": text});
    let refusal_delta = json!({"type": "response.refusal.delta", "delta": "I will not"});
    let incomplete = |reason: &str| {
        let details = json!({"incomplete_details": {"reason": reason}});
        responses(&[text_delta("a")], "incomplete", details)
    };
    let said = |text: &str| Finish::Refusal(text.into());
    let other = |text: &str| Finish::Other(text.into());
    use Dialect::{Anthropic, Gemini, Ollama, OpenAiChat, OpenAiResponses};
    for (dialect, body, text, expected) in [
        (
            OpenAiChat,
            chat(json!({"content": "a"}), "length"),
            "a",
            Finish::Length,
        ),
        (
            OpenAiChat,
            chat(json!({"content": "a"}), "content_filter"),
            "a",
            Finish::ContentFilter,
        ),
        (
            OpenAiChat,
            chat(json!({"refusal": "I will not"}), "stop"),
            "",
            said("I will not"),
        ),
        (
            OpenAiChat,
            chat(json!({"content": "  \n "}), "stop"),
            "  \n ",
            Finish::Blank,
        ),
        (
            OpenAiChat,
            chat(json!({"content": "a"}), "abort"),
            "a",
            other("abort"),
        ),
        (
            OpenAiResponses,
            incomplete("max_output_tokens"),
            "a",
            Finish::Length,
        ),
        (
            OpenAiResponses,
            incomplete("content_filter"),
            "a",
            Finish::ContentFilter,
        ),
        (
            OpenAiResponses,
            responses(&[refusal_delta], "completed", json!({})),
            "",
            said("I will not"),
        ),
        (
            OpenAiResponses,
            responses(
                &[],
                "completed",
                json!({"output": [
                    {"type": "reasoning", "summary": [{"text": "b"}]},
                    {"type": "message", "content": [{"type": "output_text", "text": "a"}]},
                ]}),
            ),
            "a",
            Finish::Stop,
        ),
        (Gemini, gemini("a", "MAX_TOKENS"), "a", Finish::Length),
        (Gemini, gemini("a", "SAFETY"), "a", Finish::ContentFilter),
        (
            Gemini,
            gemini("a", "RECITATION"),
            "a",
            Finish::ContentFilter,
        ),
        (
            Gemini,
            gemini("a", "PROHIBITED_CONTENT"),
            "a",
            Finish::ContentFilter,
        ),
        (Gemini, gemini("a", "LANGUAGE"), "a", other("LANGUAGE")),
        (
            Gemini,
            data(
                json!({"promptFeedback": {"blockReason": "SAFETY"}, "usageMetadata": {"promptTokenCount": 3}}),
            ),
            "",
            Finish::Blocked("SAFETY".into()),
        ),
        (Gemini, gemini("", "STOP"), "", Finish::Blank),
        (Anthropic, anthropic("a", "max_tokens"), "a", Finish::Length),
        (
            Anthropic,
            anthropic("a", "model_context_window_exceeded"),
            "a",
            Finish::Length,
        ),
        (Anthropic, anthropic("No.", "refusal"), "No.", said("")),
        (
            Anthropic,
            anthropic("a", "stop_sequence"),
            "a",
            Finish::Stop,
        ),
        (
            Anthropic,
            anthropic("a", "pause_turn"),
            "a",
            other("pause_turn"),
        ),
        (Ollama, ollama("a", "length"), "a", Finish::Length),
        (Ollama, ollama("a", "load"), "a", other("load")),
        (Ollama, ollama(" ", "stop"), " ", Finish::Blank),
    ] {
        assert_eq!(
            finish(dialect, &body),
            (text.to_string(), expected),
            "{body}"
        );
    }
}

#[test]
fn errors_in_the_middle_keep_what_had_come() {
    let begun = |dialect| piece(dialect, "so far", false);
    use Dialect::{Anthropic, Gemini, Ollama, OpenAiChat, OpenAiResponses};
    for (dialect, event, code) in [
        (
            OpenAiChat,
            data(json!({"error": {"message": "gone", "code": 502}})),
            Some("502"),
        ),
        (OpenAiChat, data(json!({"error": "gone"})), None),
        (
            OpenAiChat,
            "event: error\ndata: {\"message\":\"gone\"}\n\n".to_string(),
            None,
        ),
        (
            OpenAiResponses,
            named(
                json!({"type": "error", "code": "server_error", "message": "gone", "param": null}),
            ),
            Some("server_error"),
        ),
        (
            OpenAiResponses,
            named(
                json!({"type": "response.failed", "response": {"status": "failed", "error": {"code": "server_error", "message": "gone"}}}),
            ),
            Some("server_error"),
        ),
        (
            Gemini,
            data(json!({"error": {"code": 503, "message": "gone", "status": "UNAVAILABLE"}})),
            Some("503"),
        ),
        (
            Gemini,
            data(json!([{"error": {"code": 503, "message": "gone"}}])),
            Some("503"),
        ),
        (
            Anthropic,
            named(
                json!({"type": "error", "error": {"type": "overloaded_error", "message": "gone"}, "request_id": "r"}),
            ),
            Some("overloaded_error"),
        ),
        (Ollama, line(json!({"error": "gone"})), None),
    ] {
        let stream = begun(dialect) + &event;
        let items = decode(dialect, [stream.as_bytes()]);
        assert!(
            items.contains(&Ok(Chunk::Text("so far".into()))),
            "{items:?}"
        );
        match items.last() {
            Some(Err(Error::Provider {
                message, code: c, ..
            })) => {
                assert_eq!((message.as_str(), c.as_deref()), ("gone", code), "{event}");
            }
            other => panic!("{event}: {other:?}"),
        }
    }
    let ran_out = chat(json!({"content": "so far"}), "insufficient_system_resource");
    let items = decode(OpenAiChat, [ran_out.as_bytes()]);
    assert!(
        matches!(items.last(), Some(Err(Error::Provider { .. }))),
        "{items:?}"
    );
    for dialect in Dialect::ALL {
        let after = |last: &str| {
            let stream = begun(dialect) + &event(dialect, last);
            let items = decode(dialect, [stream.as_bytes()]);
            assert!(items.contains(&Ok(Chunk::Text("so far".into()))));
            items
        };
        let items = after("{broken");
        assert!(
            matches!(items.last(), Some(Err(Error::Malformed { .. }))),
            "{items:?}"
        );
        // What says nothing is passed over: then the stream ends early.
        for nothing in ["[1, 2]", "7", "\"text\"", "null"] {
            let items = after(nothing);
            assert!(
                matches!(items.last(), Some(Err(Error::Truncated { .. }))),
                "{items:?}"
            );
        }
        let stream = [begun(dialect).as_bytes(), b"\xff\n\n"].concat();
        let items = decode(dialect, [stream.as_slice()]);
        assert!(
            matches!(items.last(), Some(Err(Error::Malformed { .. }))),
            "{items:?}"
        );
    }
}

#[test]
fn odd_events_are_borne() {
    let odd = [
        json!({}),
        json!({"type": "of tomorrow"}),
        json!({"choices": "?", "candidates": "?", "message": 5, "usage": [], "usageMetadata": null, "model": 5}),
        json!({"type": "response.completed"}),
        json!({"type": "content_block_delta", "delta": {"type": "citations_delta"}}),
        json!({"candidates": [{"content": {}}]}),
        json!({"candidates": []}),
    ];
    for dialect in Dialect::ALL {
        let begin: String = odd
            .iter()
            .map(|odd| event(dialect, &odd.to_string()))
            .collect();
        let items = decode(dialect, [begin.as_bytes()]);
        assert!(
            matches!(
                items.last(),
                Some(Err(Error::Truncated { received: 0, .. }))
            ),
            "{dialect:?}: {items:?}"
        );
    }
}

/// What a dialect's server says with a status, asked of it over a connection until it is satisfied.
async fn status(dialect: Dialect, scripts: Vec<Script>) -> (Answer, usize) {
    let server = Server::start(scripts).await;
    let endpoint = Endpoint {
        dialect,
        ..endpoint(server.base_url())
    };
    let mut answer = ask(endpoint).await;
    answer
        .other
        .retain(|chunk| !matches!(chunk, Chunk::Note(_)));
    (answer, server.requests().len())
}

fn good(dialect: Dialect) -> Script {
    script(dialect).send(usual_of(dialect))
}

#[tokio::test]
async fn what_may_pass_is_asked_again() {
    use Dialect::{Anthropic, Gemini, Ollama, OpenAiResponses};
    let delay = json!([{"error": {"code": 429, "message": "quota", "status": "RESOURCE_EXHAUSTED",
        "details": [{"@type": "type.googleapis.com/google.rpc.RetryInfo", "retryDelay": "0.02s"}]}}]);
    let overloaded =
        json!({"type": "error", "error": {"type": "overloaded_error", "message": "Overloaded"}});
    for (dialect, code, headers, body, wait) in [
        (Gemini, 429, vec![], delay.to_string(), Some(20 * MS)),
        (
            Gemini,
            503,
            vec![],
            r#"{"error":{"code":503,"message":"overloaded","status":"UNAVAILABLE"}}"#.into(),
            None,
        ),
        (
            Anthropic,
            529,
            vec![("retry-after-ms", "7")],
            overloaded.to_string(),
            Some(7 * MS),
        ),
        (
            OpenAiResponses,
            500,
            vec![("x-should-retry", "true")],
            "{}".into(),
            None,
        ),
        (
            OpenAiResponses,
            501,
            vec![("x-should-retry", "true")],
            "{}".into(),
            None,
        ),
        (
            Ollama,
            503,
            vec![("Retry-After", "0.01")],
            r#"{"error":"server busy"}"#.into(),
            Some(10 * MS),
        ),
    ] {
        let script = Script::answer(code, &headers, &body);
        let (answer, requests) = status(dialect, vec![script, good(dialect)]).await;
        assert_eq!(requests, 2, "{dialect:?} {code}");
        assert_eq!(
            (answer.error.as_ref(), answer.text.as_str()),
            (None, "gefährlich 車 🚗")
        );
        let retries = answer.retries();
        assert_eq!(retries.len(), 1);
        if let Some(wait) = wait {
            assert_eq!(retries[0].1, wait, "{dialect:?} {code}");
        }
    }
}

#[tokio::test]
async fn what_cannot_pass_is_asked_once_in_every_dialect() {
    let day = json!({"error": {"code": 429, "message": "daily", "status": "RESOURCE_EXHAUSTED", "details": [
        {"violations": [{"quotaId": "GenerateRequestsPerDayPerProjectPerModel-FreeTier"}]}, {"retryDelay": "1s"}]}});
    let spend = json!({"type": "error", "error": {"type": "rate_limit_error", "message": "spend",
        "details": {"error_code": "enforced_spend_limit_reached"}}});
    for (dialect, code, body) in [
        (
            Dialect::OpenAiResponses,
            429,
            json!({"error": {"message": "pay", "type": "insufficient_quota", "code": "credit_balance_exhausted"}}),
        ),
        (Dialect::Gemini, 429, day),
        (Dialect::Anthropic, 429, spend),
        (Dialect::Ollama, 402, json!({"error": "subscribe"})),
    ] {
        let (answer, requests) = status(
            dialect,
            vec![Script::json(code, &body.to_string()), good(dialect)],
        )
        .await;
        assert_eq!(requests, 1, "{dialect:?}");
        assert!(
            matches!(
                answer.error,
                Some(Error::RateLimited {
                    exhausted: true,
                    ..
                })
            ),
            "{answer:?}"
        );
    }
    for dialect in Dialect::ALL {
        let later = Script::answer(429, &[("Retry-After", "300")], "{\"error\":\"later\"}");
        let (answer, requests) = status(dialect, vec![later, good(dialect)]).await;
        assert!(
            matches!(answer.error, Some(Error::RateLimited { retry, .. }) if retry.after().is_some_and(|wait| wait.as_secs() == 300))
        );
        assert_eq!(requests, 1, "{dialect:?}");
        let missing = Script::json(404, r#"{"error":{"message":"no such model"}}"#);
        let (answer, _) = status(dialect, vec![missing, good(dialect)]).await;
        assert!(
            matches!(answer.error, Some(Error::NotFound { .. })),
            "{dialect:?}"
        );
        let (answer, requests) = status(
            dialect,
            vec![Script::events().send(": hello\n\n"), good(dialect)],
        )
        .await;
        let broken = matches!(
            answer.error,
            Some(Error::Truncated { .. } | Error::Malformed { .. })
        );
        assert!(broken && requests == 1, "{dialect:?}: {answer:?}");
    }
}

#[tokio::test]
async fn answers_that_are_not_streamed() {
    for (dialect, document) in [
        (
            Dialect::OpenAiResponses,
            json!({"model": "m-1", "status": "completed", "output": [
            {"type": "reasoning", "summary": [], "content": [{"type": "reasoning_text", "text": "why"}]},
            {"type": "message", "content": [{"type": "output_text", "text": "so"}]}]}),
        ),
        (
            Dialect::Gemini,
            json!([{"modelVersion": "m-1", "candidates": [{"content": {"parts": [
            {"text": "why", "thought": true}, {"text": "so"}]}, "finishReason": "STOP"}]}]),
        ),
        (
            Dialect::Anthropic,
            json!({"type": "message", "model": "m-1", "stop_reason": "end_turn", "content": [
            {"type": "thinking", "thinking": "why"}, {"type": "redacted_thinking", "data": "x"}, {"type": "text", "text": "so"}]}),
        ),
        (
            Dialect::Ollama,
            json!({"model": "m-1", "message": {"thinking": "why", "content": "so"}, "done": true, "done_reason": "stop"}),
        ),
    ] {
        let script = Script::json(200, &document.to_string());
        let (answer, _) = status(dialect, vec![script]).await;
        assert_eq!(
            (answer.reasoning.as_str(), answer.text.as_str()),
            ("why", "so"),
            "{dialect:?} {answer:?}"
        );
        assert_eq!(answer.finish(), Some(&Chunk::Finished(Finish::Stop)));
        let (answer, _) = status(dialect, vec![Script::json(200, "{\"hello\": 1}")]).await;
        let nothing = matches!(
            answer.error,
            Some(Error::Malformed { .. } | Error::Truncated { .. })
        );
        assert!(nothing, "{dialect:?} {answer:?}");
    }
}

#[tokio::test]
async fn dropping_closes_the_connection_in_every_dialect() {
    for dialect in Dialect::ALL {
        let usual = usual_of(dialect);
        let (first, _) = usual.split_at(usual.find("gef").unwrap());
        let script = script(dialect);
        let server = Server::start(vec![script.send(first).await_close()]).await;
        let endpoint = Endpoint {
            dialect,
            ..endpoint(server.base_url())
        };
        let mut chunks = stream(&Client::direct(), endpoint, request());
        while !matches!(chunks.next().await, Some(Ok(Chunk::Reasoning(_)))) {}
        drop(chunks);
        assert!(server.seen_close().await, "{dialect:?}");
    }
}

#[tokio::test]
async fn silence_is_noticed_in_every_dialect() {
    for dialect in Dialect::ALL {
        let script = script(dialect);
        let server = Server::start(vec![script.await_close()]).await;
        let endpoint = Endpoint {
            dialect,
            timeouts: Timeouts {
                idle: 60 * MS,
                ..Timeouts::default()
            },
            ..endpoint(server.base_url())
        };
        let answer = ask(endpoint).await;
        assert!(
            matches!(
                answer.error,
                Some(Error::Timeout {
                    which: TimeoutKind::Idle,
                    ..
                })
            ),
            "{dialect:?} {answer:?}"
        );
    }
}
