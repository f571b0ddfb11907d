//! Every dialect: what is sent, word for word, and a usual answer with reasoning and usage, cut at every byte.

use nearmiss::llm::{
    Auth, Dialect, Effort, Efforts, Quirks, ResponseFormat, Temperature, decode, notes,
};
use serde_json::Value;

use super::support::dialects::{asked_at, finished, script, usage_of, usual_of};
use super::*;

/// Reasoning, text, and the rest of the chunks; an error panics.
pub fn sorted(items: Vec<Result<Chunk, Error>>) -> (String, String, Vec<Chunk>) {
    let (mut reasoning, mut text, mut rest) = (String::new(), String::new(), Vec::new());
    for item in items {
        match item.unwrap() {
            Chunk::Reasoning(piece) => reasoning += &piece,
            Chunk::Text(piece) => text += &piece,
            other => rest.push(other),
        }
    }
    (reasoning, text, rest)
}

fn assert_usual_of(dialect: Dialect, items: Vec<Result<Chunk, Error>>, how: &str) {
    let (reasoning, text, rest) = sorted(items);
    assert_eq!(
        (reasoning.as_str(), text.as_str()),
        ("wé", "gefährlich 車 🚗"),
        "{dialect:?} {how}"
    );
    let expected = [
        Chunk::Started {
            model: Some("m-1".into()),
        },
        Chunk::Usage(usage_of(dialect)),
        Chunk::Finished(Finish::Stop),
    ];
    assert_eq!(rest, expected, "{dialect:?} {how}");
}

#[test]
fn a_usual_answer_cut_at_every_byte() {
    for dialect in Dialect::ALL {
        let usual = usual_of(dialect);
        for text in [
            usual.clone(),
            usual.replace('\n', "\r\n"),
            format!("\u{feff}{usual}"),
            format!("\u{feff}\u{feff}{usual}"),
        ] {
            let bytes = text.as_bytes();
            for at in 0..=bytes.len() {
                let (before, after) = bytes.split_at(at);
                assert_usual_of(
                    dialect,
                    decode(dialect, [before, after]),
                    &format!("at {at}"),
                );
            }
            assert_usual_of(dialect, decode(dialect, bytes.chunks(1)), "byte by byte");
        }
    }
}

#[test]
fn what_is_cut_off_is_no_answer() {
    for dialect in Dialect::ALL {
        let usual = usual_of(dialect);
        let finished = finished(dialect);
        let begin = usual.rfind(finished).unwrap();
        let end = usual[begin..].find('\n').unwrap() + begin + 2;
        for at in 0..usual.len() {
            let items = decode(dialect, [&usual.as_bytes()[..at]]);
            let whole = matches!(items.last(), Some(Ok(Chunk::Finished(Finish::Stop))));
            let cut = matches!(items.last(), Some(Err(Error::Truncated { .. })));
            assert!(whole || cut, "{dialect:?} at {at}: {items:?}");
            if at + 3 < end {
                assert!(cut, "{dialect:?} at {at}: {items:?}");
            }
            let ends = items
                .iter()
                .filter(|i| matches!(i, Err(_) | Ok(Chunk::Finished(_))));
            assert_eq!(ends.count(), 1);
        }
    }
}

/// An endpoint of a dialect as its own provider's entry makes it.
fn endpoint_of(dialect: Dialect, base_url: &str) -> Endpoint {
    Endpoint {
        dialect,
        ..endpoint(base_url)
    }
}

#[tokio::test]
async fn over_a_connection_with_the_right_address_and_key() {
    for dialect in Dialect::ALL {
        let (path, header, value) = asked_at(dialect, KEY);
        let script = script(dialect).send(usual_of(dialect));
        let server = Server::start(vec![script.clone(), script]).await;
        let mut endpoint = endpoint_of(dialect, server.base_url());
        endpoint.headers = vec![("X-Team".into(), "seven".into())];
        let chunks: Vec<_> = stream(&Client::direct(), endpoint.clone(), request())
            .collect()
            .await;
        let said: Vec<_> = chunks
            .into_iter()
            .filter(|c| !matches!(c, Ok(Chunk::Note(_))))
            .collect();
        assert_usual_of(dialect, said, "over a connection");
        endpoint.auth = Some(Auth::ApiKey);
        endpoint.key = Some("other".into());
        let _: Vec<_> = stream(&Client::direct(), endpoint.clone(), request())
            .collect()
            .await;

        let requests = server.requests();
        assert_eq!(
            (requests[0].method.as_str(), requests[0].path.as_str()),
            ("POST", path)
        );
        assert_eq!(requests[0].header(header), Some(value.as_str()));
        assert_eq!(requests[0].header("x-team"), Some("seven"));
        let version = (dialect == Dialect::Anthropic).then_some("2023-06-01");
        assert_eq!(requests[0].header("anthropic-version"), version);
        assert_eq!(requests[0].json(), body(&endpoint, &request()));
        assert_eq!(requests[1].header("x-api-key"), Some("other"));
        for name in ["authorization", "x-goog-api-key"] {
            assert_eq!(requests[1].header(name), None, "{name}");
        }
    }
}

/// A body and its notes, for a snapshot.
fn sent(endpoint: &Endpoint, request: &Request) -> String {
    let body = serde_json::to_string_pretty(&body(endpoint, request)).unwrap();
    let notes: String = notes(endpoint, request)
        .into_iter()
        .map(|note| format!("\nnote: {note}"))
        .collect();
    body + &notes
}

fn schema() -> Value {
    json!({
        "type": "object",
        "properties": {
            "collision": {"type": "boolean"},
            "risk": {"type": "integer", "minimum": 0, "maximum": 5, "description": "The risk."},
        },
    })
}

#[test]
fn bodies_word_for_word() {
    for dialect in Dialect::ALL {
        let mut request = request();
        request.messages.push(Message::new(Role::Assistant, "Yes."));
        request.schema.as_mut().unwrap().schema = schema();
        request.parameters.effort = Some(Effort::High);
        let endpoint = endpoint_of(dialect, "http://h");
        insta::assert_snapshot!(
            format!("{}-everything", dialect.name()),
            sent(&endpoint, &request)
        );
        let bare = Request {
            parameters: Parameters::default(),
            schema: None,
            ..request
        };
        insta::assert_snapshot!(format!("{}-bare", dialect.name()), sent(&endpoint, &bare));
    }
}

#[test]
fn quirks_word_for_word() {
    let mut request = request();
    request.schema.as_mut().unwrap().schema = schema();
    request.messages[0].content = "Answer in JSON.".into();
    let mut texts = String::new();
    let mut add = |title: &str, endpoint: &Endpoint, effort: Effort| {
        request.parameters.effort = Some(effort);
        texts += &format!("# {title}\n{}\n\n", sent(endpoint, &request));
    };
    let chat = endpoint_of(Dialect::OpenAiChat, "http://h");
    let quirks = Quirks::default();
    let deepseek = Endpoint {
        response_format: ResponseFormat::JsonObject,
        quirks: Quirks {
            temperature: Temperature::NotThinking,
            seed: false,
            efforts: Some(Efforts::DeepSeek),
            ..quirks
        },
        ..chat.clone()
    };
    add("DeepSeek, thinking a little", &deepseek, Effort::Low);
    add("DeepSeek, thinking without a bound", &deepseek, Effort::Max);
    add("DeepSeek, not thinking", &deepseek, Effort::Off);
    let openrouter = Quirks {
        efforts: Some(Efforts::OpenRouter),
        require_parameters: true,
        ..quirks
    };
    let with = |quirks, dialect| Endpoint {
        quirks,
        dialect,
        ..chat.clone()
    };
    add(
        "OpenRouter",
        &with(openrouter, Dialect::OpenAiChat),
        Effort::Medium,
    );
    let reasoning = Quirks {
        max_completion_tokens: true,
        temperature: Temperature::Fixed,
        reasoning: true,
        ..quirks
    };
    add(
        "a reasoning model",
        &with(reasoning, Dialect::OpenAiChat),
        Effort::Off,
    );
    add(
        "a reasoning model, Responses",
        &with(reasoning, Dialect::OpenAiResponses),
        Effort::Off,
    );
    add(
        "a reasoning model, Gemini",
        &with(reasoning, Dialect::Gemini),
        Effort::Off,
    );
    let template = Quirks {
        efforts: Some(Efforts::Template),
        ..quirks
    };
    add(
        "llama.cpp and vLLM",
        &with(template, Dialect::OpenAiChat),
        Effort::Low,
    );
    let budget = Quirks {
        efforts: Some(Efforts::Budget),
        max_tokens: Some(4000),
        context: Some(2048),
        ..quirks
    };
    add(
        "Gemini with budgets",
        &with(budget, Dialect::Gemini),
        Effort::Low,
    );
    add(
        "Anthropic with budgets and few tokens",
        &with(budget, Dialect::Anthropic),
        Effort::High,
    );
    add(
        "Ollama with a window",
        &with(budget, Dialect::Ollama),
        Effort::Off,
    );
    insta::assert_snapshot!("quirks", texts);
}

#[test]
fn nothing_asked_for_is_dropped_in_silence() {
    // For every dialect and quirk: what is asked for stands in the body, or a note says that it does not.
    let temperatures = [
        Temperature::Taken,
        Temperature::Fixed,
        Temperature::NotThinking,
    ];
    let efforts = [
        None,
        Some(Efforts::Levels),
        Some(Efforts::Budget),
        Some(Efforts::DeepSeek),
        Some(Efforts::OpenRouter),
        Some(Efforts::Template),
        Some(Efforts::Untaken),
    ];
    for (dialect, temperature, efforts) in Dialect::ALL.into_iter().flat_map(|dialect| {
        let pairs = temperatures
            .into_iter()
            .flat_map(move |t| efforts.into_iter().map(move |e| (t, e)));
        pairs.map(move |(t, e)| (dialect, t, e))
    }) {
        let mut endpoint = endpoint_of(dialect, "http://h");
        endpoint.quirks = Quirks {
            temperature,
            efforts,
            seed: temperature == Temperature::Taken,
            ..Quirks::default()
        };
        for effort in Effort::ALL {
            let mut request = request();
            request.parameters.temperature = Some(0.731);
            request.parameters.seed = Some(60_125);
            request.parameters.effort = Some(effort);
            let text = body(&endpoint, &request).to_string();
            let notes = notes(&endpoint, &request).join("\n");
            let what =
                format!("{dialect:?} {temperature:?} {efforts:?} {effort:?}: {text}\n{notes}");
            assert!(
                text.contains("0.731") || notes.contains("temperature"),
                "{what}"
            );
            assert!(text.contains("60125") || notes.contains("seed"), "{what}");
            let words = ["effort", "thinking", "think\"", "reasoning"];
            let told = words.iter().any(|word| text.contains(word)) || notes.contains("effort");
            assert!(told, "{what}");
        }
    }
}

#[tokio::test]
async fn notes_come_before_the_answer() {
    let server = Server::start(vec![Script::events().send(usual_of(Dialect::Anthropic))]).await;
    let endpoint = endpoint_of(Dialect::Anthropic, server.base_url());
    let answer = ask(endpoint).await;
    assert!(
        matches!(&answer.other[0], Chunk::Note(note) if note.contains("seed is not sent")),
        "{answer:?}"
    );
}
