//! Questions to language models over a real connection, against a server that answers with exact bytes.
#![allow(clippy::unwrap_used)]

mod damaged;
mod dialects;
mod failures;
mod faults;
mod keys;
mod log_probabilities;
mod money;
mod patience;
mod real;
use crate::support;
mod tools;

use std::time::{Duration, Instant};

use futures_util::StreamExt;
use nearmiss::llm::{
    Chunk, Client, Endpoint, Error, Finish, Message, Parameters, Request, Retry, Role, Schema,
    TimeoutKind, Timeouts, Usage, body, stream,
};
use serde_json::json;
use support::server::{Script, Server};

const KEY: &str = "sk-test-0123456789abcdef";

const MS: Duration = Duration::from_millis(1);

fn endpoint(base_url: &str) -> Endpoint {
    Endpoint {
        key: Some(KEY.into()),
        key_source: Some("TEST_API_KEY".into()),
        retry: Retry {
            first_wait: 5 * MS,
            ..Retry::default()
        },
        ..Endpoint::new("fixture", base_url)
    }
}

fn request() -> Request {
    Request {
        model: "small-1".into(),
        messages: vec![
            Message::new(Role::System, "Be brief."),
            Message::new(Role::User, "Dangerous? 車"),
        ],
        parameters: Parameters {
            temperature: Some(0.0),
            max_tokens: Some(64),
            seed: Some(3),
            effort: None,
            log_probabilities: false,
            tools: None,
        },
        schema: Some(Schema {
            is_bounded: false,
            name: "verdict".into(),
            schema: json!({"type": "object", "properties": {}}),
        }),
        tools: None,
    }
}

/// Everything that came: reasoning, text, other chunks, and the error.
#[derive(Debug, Default)]
struct Answer {
    reasoning: String,
    text: String,
    other: Vec<Chunk>,
    error: Option<Error>,
}

impl Answer {
    fn finish(&self) -> Option<&Chunk> {
        self.other
            .last()
            .filter(|c| matches!(c, Chunk::Finished(_)))
    }

    fn retries(&self) -> Vec<(u32, Duration, &str)> {
        let retry = |c| match c {
            &Chunk::Retrying {
                attempt,
                wait,
                ref why,
            } => Some((attempt, wait, why.as_str())),
            _ => None,
        };
        self.other.iter().filter_map(retry).collect()
    }
}

async fn ask(endpoint: Endpoint) -> Answer {
    let mut answer = Answer::default();
    let mut chunks = stream(&Client::direct(), endpoint, request());
    while let Some(chunk) = chunks.next().await {
        assert_eq!(answer.error, None, "nothing comes after an error");
        assert_eq!(answer.finish(), None, "nothing comes after the end");
        match chunk {
            Ok(Chunk::Reasoning(text)) => answer.reasoning += &text,
            Ok(Chunk::Text(text)) => answer.text += &text,
            Ok(chunk) => answer.other.push(chunk),
            Err(error) => answer.error = Some(error),
        }
    }
    assert!(chunks.next().await.is_none(), "an ended stream stays ended");
    // Whatever happened, the key shows nowhere.
    let shown = format!(
        "{answer:?} {}",
        answer
            .error
            .as_ref()
            .map(ToString::to_string)
            .unwrap_or_default()
    );
    assert!(!shown.contains(KEY), "{shown}");
    answer
}

async fn ask_script(script: Script) -> Answer {
    let server = Server::start(vec![script]).await;
    let answer = ask(endpoint(server.base_url())).await;
    assert_eq!(server.requests().len(), 1);
    answer
}

fn delta(text: &str) -> String {
    format!(
        "data: {}\n\n",
        json!({"model": "small-1-2026", "choices": [{"index": 0, "delta": {"content": text}}]})
    )
}

const FINISH: &str =
    "data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n";
const USAGE: &str =
    "data: {\"choices\":[],\"usage\":{\"prompt_tokens\":12,\"completion_tokens\":3}}\n\n";
const DONE: &str = "data: [DONE]\n\n";

/// A usual body with everything that may be cut in the wrong place.
fn usual() -> String {
    [
        ": OPENROUTER PROCESSING\n\n",
        &delta("<think>é</think>"),
        &delta("gefährlich 車 "),
        &delta("🚗"),
        FINISH,
        USAGE,
        DONE,
    ]
    .concat()
}

fn assert_usual(answer: &Answer) {
    assert_eq!(answer.error, None);
    assert_eq!(
        (answer.reasoning.as_str(), answer.text.as_str()),
        ("é", "gefährlich 車 🚗")
    );
    let usage = Usage {
        input_tokens: Some(12),
        output_tokens: Some(3),
        ..Usage::default()
    };
    assert_eq!(
        answer.other,
        [
            Chunk::Started {
                model: Some("small-1-2026".into())
            },
            Chunk::Usage(usage),
            Chunk::Finished(Finish::Stop)
        ]
    );
}

#[tokio::test]
async fn a_streamed_answer_and_what_was_asked_for_it() {
    let server = Server::start(vec![Script::events().send(usual())]).await;
    let endpoint = endpoint(server.base_url());
    let expected = body(&endpoint, &request());
    assert_usual(&ask(endpoint).await);
    let requests = server.requests();
    assert_eq!(requests.len(), 1);
    let sent = &requests[0];
    assert_eq!(
        (sent.method.as_str(), sent.path.as_str()),
        ("POST", "/v1/chat/completions")
    );
    assert_eq!(
        sent.header("authorization"),
        Some(format!("Bearer {KEY}").as_str())
    );
    assert_eq!(sent.header("content-type"), Some("application/json"));
    assert_eq!(
        sent.header("user-agent"),
        Some(concat!("nearmiss/", env!("CARGO_PKG_VERSION")))
    );
    assert_eq!(sent.json(), expected);
    assert_eq!(
        sent.json(),
        json!({
            "model": "small-1",
            "messages": [
                {"role": "system", "content": "Be brief."},
                {"role": "user", "content": "Dangerous? 車"},
            ],
            "stream": true,
            "stream_options": {"include_usage": true},
            "temperature": 0.0,
            "max_tokens": 64,
            "seed": 3,
            "response_format": {"type": "json_schema", "json_schema": {
                "name": "verdict", "strict": true,
                "schema": {"type": "object", "properties": {}, "required": [], "additionalProperties": false},
            }},
        })
    );
}

#[tokio::test]
async fn without_a_key_none_is_sent() {
    let server = Server::start(vec![Script::events().send(usual())]).await;
    assert_usual(
        &ask(Endpoint {
            key: Some(" \n".into()),
            ..endpoint(server.base_url())
        })
        .await,
    );
    assert_eq!(server.requests()[0].header("authorization"), None);
}

#[tokio::test]
async fn pieces_of_one_byte() {
    for text in [
        usual(),
        usual().replace('\n', "\r\n"),
        format!("\u{feff}{}", usual()),
    ] {
        let script = text
            .as_bytes()
            .iter()
            .fold(Script::chunked_events(), |s, byte| s.chunk([*byte]));
        assert_usual(&ask_script(script.end_of_chunks()).await);
    }
}

#[tokio::test]
async fn two_pieces_cut_at_every_byte() {
    let text = usual().replace('\n', "\r\n");
    let cut = |at| {
        Script::chunked_events()
            .chunk(&text.as_bytes()[..at])
            .chunk(&text.as_bytes()[at..])
            .end_of_chunks()
    };
    let server = Server::start((1..text.len()).map(cut).collect()).await;
    let client = Client::direct();
    for _ in 1..text.len() {
        let chunks: Vec<_> = stream(&client, endpoint(server.base_url()), request())
            .collect()
            .await;
        let said: String = chunks
            .iter()
            .filter_map(|c| {
                if let Ok(Chunk::Text(t)) = c {
                    Some(t.as_str())
                } else {
                    None
                }
            })
            .collect();
        assert_eq!(said, "gefährlich 車 🚗");
        assert_eq!(chunks.last(), Some(&Ok(Chunk::Finished(Finish::Stop))));
    }
}

#[tokio::test]
async fn comments_and_event_names_do_no_harm() {
    let text = [
        ": keep-alive\n",
        "\n\n",
        "event: message\nid: 4\nretry: 10\n",
        &delta("a"),
        ":\n\n",
        "event: message\n",
        &delta("b"),
        FINISH,
        DONE,
    ]
    .concat();
    let answer = ask_script(Script::events().send(text)).await;
    assert_eq!((answer.error.as_ref(), answer.text.as_str()), (None, "ab"));
}

#[tokio::test]
async fn reasoning_comes_under_many_names() {
    for fields in [
        json!({"reasoning_content": "why"}),
        json!({"reasoning": "why"}),
        json!({"reasoning": "why", "reasoning_details": [{"type": "reasoning.text", "text": "why"}]}),
        json!({"content": "<think>why</think>"}),
    ] {
        let event = format!("data: {}\n\n", json!({"choices": [{"delta": fields}]}));
        let answer =
            ask_script(Script::events().send([&event, &delta("so"), FINISH, DONE].concat())).await;
        assert_eq!(
            (answer.reasoning.as_str(), answer.text.as_str()),
            ("why", "so"),
            "{fields}"
        );
    }
}

#[tokio::test]
async fn a_cut_stream_is_no_answer() {
    let whole_events = delta("so far");
    let half_an_event = delta("so far") + &delta("and more").replace("\n\n", "\n");
    let half_a_character = [delta("so far").as_bytes(), b"data: \xe8\xbb"].concat();
    for script in [
        Script::events().send(&whole_events),
        Script::events().send(&half_an_event),
        Script::events().send(&half_a_character),
        Script::chunked_events().chunk(&whole_events),
        Script::chunked_events().chunk(&half_an_event),
        Script::chunked_events()
            .chunk(&whole_events)
            .end_of_chunks(),
        Script::chunked_events()
            .chunk(&whole_events)
            .send("ff\r\ndata: {"),
    ] {
        let answer = ask_script(script.clone()).await;
        assert_eq!(answer.text, "so far");
        assert!(
            matches!(answer.error, Some(Error::Truncated { received: 6, .. })),
            "{script:?}: {answer:?}"
        );
    }
    for script in [
        Script::silent(),
        Script::events(),
        Script::answer(200, &[], ""),
    ] {
        let answer = ask_script(script.clone()).await;
        assert!(
            matches!(answer.error, Some(Error::Truncated { received: 0, .. })),
            "{script:?}: {answer:?}"
        );
    }
}

#[tokio::test]
async fn a_finish_reason_is_an_end_too() {
    for script in [
        Script::events().send(delta("all") + FINISH),
        // The connection breaks after the answer: only the usage is lost.
        Script::chunked_events().chunk(delta("all") + FINISH),
    ] {
        let answer = ask_script(script).await;
        assert_eq!((answer.error.as_ref(), answer.text.as_str()), (None, "all"));
        assert_eq!(answer.finish(), Some(&Chunk::Finished(Finish::Stop)));
    }
}

#[tokio::test]
async fn errors_inside_the_stream() {
    let event = format!(
        "data: {}\n\n",
        json!({"error": {"code": 502, "message": format!("upstream of {KEY} died")}})
    );
    let answer = ask_script(Script::events().send(delta("so far") + &event)).await;
    assert_eq!(answer.text, "so far");
    match answer.error {
        Some(Error::Provider { code, message, .. }) => {
            assert_eq!(
                (code.as_deref(), message.as_str()),
                (Some("502"), "upstream of [key] died")
            );
        }
        other => panic!("{other:?}"),
    }
    let answer =
        ask_script(Script::events().send("event: error\ndata: {\"message\":\"flat\"}\n\n")).await;
    assert!(matches!(answer.error, Some(Error::Provider { message, .. }) if message == "flat"));
    let answer = ask_script(Script::events().send(delta("a") + "data: {broken\n\n")).await;
    assert_eq!(answer.text, "a");
    assert!(matches!(answer.error, Some(Error::Malformed { .. })));
    let answer =
        ask_script(Script::events().send([delta("a").as_bytes(), b"data: \xff\n\n"].concat()))
            .await;
    assert!(matches!(answer.error, Some(Error::Malformed { .. })));
}

#[tokio::test]
async fn an_answer_that_is_not_streamed() {
    let document = json!({
        "model": "small-1-2026",
        "choices": [{"index": 0, "message": {"role": "assistant", "content": "gefährlich 車 🚗", "reasoning": "é"}, "finish_reason": "stop"}],
        "usage": {"prompt_tokens": 12, "completion_tokens": 3},
    });
    assert_usual(&ask_script(Script::json(200, &document.to_string())).await);
    let answer = ask_script(Script::json(200, r#"{"error":"model not pulled"}"#)).await;
    assert!(
        matches!(answer.error, Some(Error::Provider { message, .. }) if message == "model not pulled")
    );
    let cut = "HTTP/1.1 200 OK\r\nContent-Type: application/json\r\nContent-Length: 900\r\n\r\n{\"choices\":[";
    let answer = ask_script(Script::silent().send(cut)).await;
    assert!(
        matches!(answer.error, Some(Error::Truncated { .. })),
        "{answer:?}"
    );
}
