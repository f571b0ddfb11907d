//! Real and simulated servers, where there are some: NEARMISS_LLAMA_SERVER and NEARMISS_AIMOCK hold their addresses.

use nearmiss::llm::Dialect;

use super::*;

fn server(variable: &str) -> Option<String> {
    let url = std::env::var(variable).ok().filter(|url| !url.is_empty());
    if url.is_none() {
        crate::support::program::skipped(&format!("{variable} is not set"));
    }
    url
}

async fn asked(endpoint: Endpoint, model: &str, question: &str, schema: bool) -> Answer {
    let mut answer = Answer::default();
    let request = Request {
        model: model.into(),
        messages: vec![Message::new(Role::User, question)],
        parameters: Parameters {
            temperature: Some(0.0),
            max_tokens: Some(200),
            ..Parameters::default()
        },
        schema: schema.then(|| Schema {
            is_bounded: false,
            name: "r".into(),
            schema: json!({"type": "object", "properties": {
                "risk": {"type": "integer", "enum": [0, 1, 2, 3, 4, 5]},
                "label": {"type": "string", "enum": ["safe", "risky", "critical"]},
            }}),
        }),
        tools: None,
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
    let _alone = ALONE.lock().await;
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

/// One test at a time asks the real server: one of them looks whether it is idle.
static ALONE: tokio::sync::Mutex<()> = tokio::sync::Mutex::const_new(());

/// What the server says about its places for requests: whether each is at work, and tokens it has made.
async fn places(url: &str) -> Vec<(bool, u64)> {
    let address = format!("{url}/slots");
    let body = reqwest::get(address).await.unwrap().text().await.unwrap();
    let places: Vec<serde_json::Value> = serde_json::from_str(&body).unwrap();
    let of = |place: &serde_json::Value| {
        let made = place
            .pointer("/next_token/0/n_decoded")
            .or_else(|| place.pointer("/next_token/n_decoded"));
        (
            place["is_processing"].as_bool().unwrap(),
            made.and_then(serde_json::Value::as_u64).unwrap_or(0),
        )
    };
    places.iter().map(of).collect()
}

#[tokio::test]
async fn a_real_llama_server_keeps_to_its_seed() {
    let Some(url) = server("NEARMISS_LLAMA_SERVER") else {
        return;
    };
    let _alone = ALONE.lock().await;
    let sampled = async |seed: u64| {
        let request = Request {
            model: "bigram".into(),
            messages: vec![Message::new(Role::User, "x")],
            parameters: Parameters {
                temperature: Some(1.0),
                max_tokens: Some(80),
                seed: Some(seed),
                ..Parameters::default()
            },
            schema: None,
            tools: None,
        };
        let chunks = stream(&Client::direct(), of(Dialect::OpenAiChat, &url), request);
        let chunks: Vec<_> = chunks.collect().await;
        let text = |chunk: &Result<Chunk, Error>| match chunk {
            Ok(Chunk::Reasoning(text) | Chunk::Text(text)) => text.clone(),
            Ok(_) => String::new(),
            Err(error) => panic!("{error}"),
        };
        chunks.iter().map(text).collect::<String>()
    };
    let mut answers = Vec::new();
    for seed in 1..9 {
        let answer = sampled(seed).await;
        assert!(!answer.is_empty());
        assert_eq!(answer, sampled(seed).await, "seed {seed}");
        answers.push(answer);
    }
    answers.dedup();
    assert!(answers.len() > 1, "no seed changes anything: {answers:?}");
}

#[tokio::test]
async fn cancelling_frees_the_place_of_a_real_llama_server() {
    let Some(url) = server("NEARMISS_LLAMA_SERVER") else {
        return;
    };
    let _alone = ALONE.lock().await;
    // A list that takes the server long: its grammar does not let it end before.
    let request = Request {
        model: "bigram".into(),
        messages: vec![Message::new(Role::User, "x")],
        parameters: Parameters::default(),
        schema: Some(Schema {
            is_bounded: false,
            name: "r".into(),
            schema: json!({"type": "object", "required": ["risks"], "properties": {"risks": {
                "type": "array", "minItems": MOST, "items": {"type": "string", "enum": ["risky"]},
            }}}),
        }),
        tools: None,
    };
    let mut chunks = stream(&Client::direct(), of(Dialect::OpenAiChat, &url), request);
    let mut begun = false;
    while let Some(chunk) = chunks.next().await {
        if let Chunk::Text(_) = chunk.unwrap() {
            begun = true;
            break;
        }
    }
    assert!(begun, "nothing arrived");
    let busy = places(&url).await;
    assert!(
        busy.iter().any(|(at_work, _)| *at_work),
        "the answer was over before it could be cancelled: {busy:?}"
    );
    drop(chunks);
    let mut after = places(&url).await;
    for _ in 0..50 {
        if !after.iter().any(|(at_work, _)| *at_work) {
            break;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
        after = places(&url).await;
    }
    assert!(!after.iter().any(|(at_work, _)| *at_work), "{after:?}");
    // The whole list would be more: a token at least for each of its words.
    assert!(after.iter().all(|(_, made)| *made < MOST), "{after:?}");
}

/// Words in the long list.
const MOST: u64 = 1500;

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
