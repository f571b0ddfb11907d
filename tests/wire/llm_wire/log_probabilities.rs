//! Log probabilities in every dialect that has them: how they are asked for, and how they arrive.

use nearmiss::llm::{
    Chunk, Dialect, Effort, Endpoint, LogProbabilities, Quirks, Token, body, decode,
    gives_log_probabilities, notes,
};
use serde_json::json;

use super::{endpoint, request};

/// An answer of one dialect whose second token has two alternatives.
fn answer(dialect: Dialect) -> Option<String> {
    let entry = |token: &str, log: f64| json!({"token": token, "logprob": log});
    let tokens = json!([
        {"token": "{\"a\": ", "logprob": 0.0, "top_logprobs": []},
        {"token": "true", "logprob": -0.5, "top_logprobs": [entry("true", -0.5), entry("false", -1.0)]},
    ]);
    let event = |value: serde_json::Value| format!("data: {value}\n\n");
    Some(match dialect {
        Dialect::OpenAiChat => {
            let delta = |i: usize| {
                event(
                    json!({"choices": [{"index": 0, "delta": {"content": tokens[i]["token"]},
                    "logprobs": {"content": [tokens[i]]}}]}),
                )
            };
            let end = json!({"choices": [{"index": 0, "delta": {}, "finish_reason": "stop", "logprobs": null}]});
            format!("{}{}{}data: [DONE]\n\n", delta(0), delta(1), event(end))
        }
        Dialect::OpenAiResponses => {
            let delta = json!({"type": "response.output_text.delta", "delta": "{\"a\": true", "logprobs": tokens});
            let end = json!({"type": "response.completed", "response": {"status": "completed", "output": []}});
            format!("{}{}", event(delta), event(end))
        }
        Dialect::Gemini => {
            let entry = |token: &str, log: f64| json!({"token": token, "logProbability": log});
            event(json!({"candidates": [{
            "content": {"parts": [{"text": "{\"a\": true"}]}, "finishReason": "STOP",
            "logprobsResult": {
                "chosenCandidates": [entry("{\"a\": ", 0.0), entry("true", -0.5)],
                "topCandidates": [{"candidates": []},
                    {"candidates": [entry("true", -0.5), entry("false", -1.0)]}],
            }}]}))
        }
        Dialect::Ollama => {
            let line =
                json!({"message": {"content": "{\"a\": true"}, "logprobs": tokens, "done": false});
            let end = json!({"message": {"content": ""}, "done": true, "done_reason": "stop"});
            format!("{line}\n{end}\n")
        }
        Dialect::Anthropic => return None,
    })
}

#[test]
fn they_arrive_before_the_end() {
    let token = |text: &str, log_probability, alternatives: &[(&str, f64)]| Token {
        text: text.into(),
        log_probability,
        alternatives: alternatives
            .iter()
            .map(|(t, l)| ((*t).into(), *l))
            .collect(),
    };
    let wanted = Chunk::LogProbabilities(vec![
        token("{\"a\": ", 0.0, &[]),
        token("true", -0.5, &[("true", -0.5), ("false", -1.0)]),
    ]);
    for dialect in Dialect::ALL {
        let Some(text) = answer(dialect) else {
            continue;
        };
        let chunks = decode(dialect, text.as_bytes().chunks(7));
        let [.., weights, end] = &chunks[..] else {
            panic!("{dialect:?}: {chunks:?}")
        };
        assert_eq!(weights.as_ref().ok(), Some(&wanted), "{dialect:?}");
        assert!(matches!(end, Ok(Chunk::Finished(_))), "{dialect:?}");
    }
}

#[test]
fn they_are_asked_for_where_the_model_gives_them_and_a_note_says_where_not() {
    for (dialect, gives, effort) in Dialect::ALL.into_iter().flat_map(|dialect| {
        let ways = [
            (LogProbabilities::Given, None),
            (LogProbabilities::NotThinking, None),
            (LogProbabilities::NotThinking, Some(Effort::Off)),
            (LogProbabilities::Withheld, Some(Effort::Off)),
        ];
        ways.map(move |(gives, effort)| (dialect, gives, effort))
    }) {
        let endpoint = Endpoint {
            dialect,
            quirks: Quirks {
                log_probabilities: gives,
                ..Quirks::default()
            },
            ..endpoint("http://h")
        };
        let mut request = request();
        request.parameters.effort = effort;
        let silent = body(&endpoint, &request).to_string();
        assert!(!silent.to_lowercase().contains("logprobs"), "{silent}");
        request.parameters.log_probabilities = true;
        let text = body(&endpoint, &request).to_string();
        let asked = text.to_lowercase().contains("logprobs");
        let told = notes(&endpoint, &request).join("\n");
        let what = format!("{dialect:?} {gives:?} {effort:?}: {text}\n{told}");
        let possible = dialect != Dialect::Anthropic
            && (gives == LogProbabilities::Given
                || (gives == LogProbabilities::NotThinking && effort.is_some()));
        assert_eq!(asked, possible, "{what}");
        assert_eq!(
            told.contains("log_probabilities is not sent"),
            !possible,
            "{what}"
        );
        assert_eq!(
            gives_log_probabilities(&endpoint, &request),
            possible,
            "{what}"
        );
    }
}

#[test]
fn a_long_system_prompt_is_marked_for_the_cache_of_anthropic() {
    let mut request = request();
    request.messages[0].role = nearmiss::llm::Role::System;
    let system = |endpoint: &Endpoint, request: &nearmiss::llm::Request| {
        body(endpoint, request)["system"].clone()
    };
    let endpoint = Endpoint {
        dialect: Dialect::Anthropic,
        quirks: Quirks {
            cache_from: Some(1024),
            ..Quirks::default()
        },
        ..endpoint("http://h")
    };
    request.messages[0].content = "x".repeat(4 * 1024 - 1);
    assert!(system(&endpoint, &request).is_string(), "too short");
    request.messages[0].content.push('x');
    let marked = system(&endpoint, &request);
    assert_eq!(marked[0]["cache_control"], json!({"type": "ephemeral"}));
    assert_eq!(marked[0]["text"], json!(request.messages[0].content));
    let off = Endpoint {
        prompt_cache: false,
        ..endpoint.clone()
    };
    assert!(system(&off, &request).is_string());
    let plain = Endpoint {
        quirks: Quirks::default(),
        ..endpoint
    };
    assert!(system(&plain, &request).is_string());
}
