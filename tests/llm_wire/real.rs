//! Real and simulated servers, where there are some: NEARMISS_LLAMA_SERVER and NEARMISS_AIMOCK hold their addresses.

use nearmiss::llm::Dialect;

use super::*;

fn server(variable: &str) -> Option<String> {
    let url = std::env::var(variable).ok().filter(|url| !url.is_empty());
    if url.is_none() {
        println!("skipped: {variable} is not set");
    }
    url
}

async fn asked(endpoint: Endpoint, model: &str, question: &str, schema: bool) -> Answer {
    let mut answer = Answer::default();
    let request = Request {
        model: model.into(),
        messages: vec![Message {
            role: Role::User,
            content: question.into(),
        }],
        parameters: Parameters {
            temperature: Some(0.0),
            max_tokens: Some(200),
            ..Parameters::default()
        },
        schema: schema.then(|| Schema {
            name: "r".into(),
            schema: json!({"type": "object", "properties": {
                "risk": {"type": "integer", "enum": [0, 1, 2, 3, 4, 5]},
                "label": {"type": "string", "enum": ["safe", "risky", "critical"]},
            }}),
        }),
    };
    let mut chunks = stream(&Client::direct(), endpoint, request);
    while let Some(chunk) = chunks.next().await {
        match chunk {
            Ok(Chunk::Reasoning(text)) => answer.reasoning += &text,
            Ok(Chunk::Text(text)) => answer.text += &text,
            Ok(chunk) => answer.other.push(chunk),
            Err(error) => answer.error = Some(error),
        }
    }
    answer
}

fn of(dialect: Dialect, url: &str) -> Endpoint {
    Endpoint {
        dialect,
        ..endpoint(url)
    }
}

#[tokio::test]
async fn a_real_llama_server() {
    let Some(url) = server("NEARMISS_LLAMA_SERVER") else {
        return;
    };
    for dialect in [
        Dialect::OpenAiChat,
        Dialect::OpenAiResponses,
        Dialect::Anthropic,
    ] {
        let answer = asked(of(dialect, &url), "bigram", "x", false).await;
        assert_eq!(answer.error, None, "{dialect:?}");
        assert!(
            answer.reasoning.contains("the ego car"),
            "{dialect:?} {answer:?}"
        );
        assert!(answer.text.ends_with("brake now"), "{dialect:?} {answer:?}");
        assert_eq!(
            answer.finish(),
            Some(&Chunk::Finished(Finish::Stop)),
            "{dialect:?}"
        );
        let counted =
            |chunk: &Chunk| matches!(chunk, Chunk::Usage(u) if u.output_tokens > Some(10));
        assert!(answer.other.iter().any(counted), "{dialect:?} {answer:?}");
        let mut short = of(dialect, &url);
        short.quirks.max_tokens = Some(4);
        let request = Request {
            parameters: Parameters::default(),
            schema: None,
            ..request()
        };
        let chunks: Vec<_> = stream(&Client::direct(), short, request).collect().await;
        // Its Responses say `completed` even then; what is left is that nothing was answered.
        let expected = match dialect {
            Dialect::OpenAiResponses => Finish::Blank,
            _ => Finish::Length,
        };
        assert_eq!(
            chunks.last(),
            Some(&Ok(Chunk::Finished(expected))),
            "{dialect:?}"
        );
        let long = asked(of(dialect, &url), "bigram", &"x".repeat(90_000), false).await;
        assert!(
            matches!(long.error, Some(Error::BadRequest { status: 400, .. })),
            "{dialect:?} {long:?}"
        );
    }
    let answer = asked(of(Dialect::OpenAiChat, &url), "bigram", "x", true).await;
    let value: serde_json::Value = serde_json::from_str(&answer.text).unwrap();
    assert!(
        value["risk"].as_u64().is_some_and(|risk| risk <= 5),
        "{answer:?}"
    );
    assert!(value["label"].is_string() && value.as_object().unwrap().len() == 2);
    assert!(!answer.reasoning.is_empty());
}

#[tokio::test]
async fn a_simulator_of_many_providers() {
    let Some(url) = server("NEARMISS_AIMOCK") else {
        return;
    };
    for (dialect, model) in [
        (Dialect::OpenAiChat, "gpt-4o"),
        (Dialect::OpenAiResponses, "gpt-5"),
        (Dialect::Gemini, "gemini-3.8-flash"),
        (Dialect::Anthropic, "claude-sonnet-5"),
    ] {
        let answer = asked(of(dialect, &url), model, "scenario", false).await;
        assert_eq!(answer.error, None, "{dialect:?}");
        assert_eq!(
            answer.text, "{\"risk\":4,\"obstacle\":7}",
            "{dialect:?} {answer:?}"
        );
        assert_eq!(
            answer.reasoning, "TTC is 1.2 s, so obstacle 7 is critical.",
            "{dialect:?}"
        );
        assert_eq!(
            answer.finish(),
            Some(&Chunk::Finished(Finish::Stop)),
            "{dialect:?}"
        );
        let answer = asked(of(dialect, &url), model, "toolong", false).await;
        // The simulator leaves out the reason that the Responses API states.
        let expected = match dialect {
            Dialect::OpenAiResponses => Finish::Other("incomplete".into()),
            _ => Finish::Length,
        };
        assert_eq!(
            answer.finish(),
            Some(&Chunk::Finished(expected)),
            "{dialect:?} {answer:?}"
        );
        let answer = asked(of(dialect, &url), model, "cut", false).await;
        assert!(
            matches!(answer.error, Some(Error::Truncated { .. })),
            "{dialect:?} {answer:?}"
        );
        let answer = asked(of(dialect, &url), model, "overload", false).await;
        assert!(
            matches!(answer.error, Some(Error::Server { status: 529, .. })),
            "{dialect:?} {answer:?}"
        );
        assert_eq!(answer.retries().len(), 2, "{dialect:?}");
        let answer = asked(of(dialect, &url), model, "unavail", false).await;
        assert!(
            matches!(answer.error, Some(Error::Server { status: 503, .. })),
            "{dialect:?} {answer:?}"
        );
    }
    let answer = asked(of(Dialect::Ollama, &url), "q", "scenario", false).await;
    assert_eq!(answer.text, "{\"risk\":4,\"obstacle\":7}", "{answer:?}");
    assert_eq!(answer.finish(), Some(&Chunk::Finished(Finish::Stop)));
}
