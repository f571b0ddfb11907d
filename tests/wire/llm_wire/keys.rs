//! The key: it is sent in one header and shows nowhere else, whatever a server makes of it.

use nearmiss::llm::{Dialect, Environment, KeyCommand, Registry, probe};

use super::support::dialects::{event, script, usual_of};
use super::*;

/// Everything that comes of asking, as text, with the endpoint's own.
async fn shown(endpoint: Endpoint) -> String {
    let mut shown = format!("{endpoint:?} {}", endpoint.place());
    let client = Client::direct();
    let mut chunks = stream(&client, endpoint, request());
    let (mut reasoning, mut text) = (String::new(), String::new());
    while let Some(item) = chunks.next().await {
        shown += &format!("{item:?}");
        match item {
            Ok(Chunk::Reasoning(piece)) => reasoning += &piece,
            Ok(Chunk::Text(piece)) => text += &piece,
            Err(error) => shown += &error.to_string(),
            Ok(_) => {}
        }
    }
    shown + &reasoning + "|" + &text + &format!("{client:?}")
}

#[tokio::test]
async fn a_server_that_quotes_the_key_does_not_spread_it() {
    let (one, two) = KEY.split_at(9);
    let scripts = |dialect: Dialect| {
        let cut_inside = usual_of(dialect)
            .replace("gefährlich 車", &format!("it is {one}"))
            .replace(" 🚗", two)
            .replace("wé", &format!("{KEY}{KEY}"))
            .replace("m-1", KEY);
        let events = script(dialect);
        let error = json!({"error": {"message": format!("bad {KEY}"), "code": KEY, "type": KEY}});
        let mid = event(dialect, &error.to_string());
        vec![
            events.clone().send(&cut_inside),
            events.clone().send(mid),
            events.clone().send(cut_inside.replace('}', "")),
            events.send(format!("data: {{\"{KEY}\n\n")),
            Script::json(400, &error.to_string()),
            Script::json(401, &format!("{KEY} is wrong")),
            Script::json(503, &error.to_string()),
            Script::answer(302, &[("Location", &format!("/{KEY}"))], ""),
            Script::json(200, &error.to_string()),
        ]
    };
    for dialect in Dialect::ALL {
        for script in scripts(dialect) {
            let server = Server::start(vec![script.clone()]).await;
            let endpoint = Endpoint {
                dialect,
                retry: Retry {
                    attempts: 2,
                    first_wait: MS,
                    ..Retry::default()
                },
                headers: vec![("x-also".into(), KEY.into())],
                ..endpoint(server.base_url())
            };
            let shown = shown(endpoint).await;
            assert!(!shown.contains(KEY), "{dialect:?} {script:?}\n{shown}");
            assert!(!server.requests().is_empty());
        }
    }
    let server = Server::start(scripts(Dialect::OpenAiChat)).await;
    let shown = shown(endpoint(server.base_url())).await;
    assert!(shown.contains("[key][key]|it is [key]"), "{shown}");
}

#[cfg(unix)]
#[tokio::test]
async fn a_command_is_asked_for_the_key_once_and_again_when_it_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let count = folder.path().join("count");
    let line = format!("echo x >> '{}'; echo '{KEY}'; echo user", count.display());
    let runs = || {
        std::fs::read_to_string(&count)
            .unwrap_or_default()
            .lines()
            .count()
    };
    let good = Script::events().send(usual());
    let server = Server::start(vec![
        good.clone(),
        good.clone(),
        Script::json(401, "{}"),
        good,
    ])
    .await;
    let endpoint = Endpoint {
        key: None,
        key_command: Some(KeyCommand::Shell(line)),
        ..endpoint(server.base_url())
    };
    let client = Client::direct();
    for expected in [1, 1, 1, 2] {
        let chunks: Vec<_> = stream(&client, endpoint.clone(), request()).collect().await;
        assert!(!format!("{chunks:?} {client:?}").contains(KEY));
        assert_eq!(runs(), expected);
    }
    let bearer = format!("Bearer {KEY}");
    for sent in server.requests() {
        assert_eq!(sent.header("authorization"), Some(bearer.as_str()));
    }
}

#[cfg(unix)]
#[tokio::test]
async fn a_command_that_fails_is_named_and_nothing_is_sent() {
    let server = Server::start(vec![]).await;
    let words = ["sh", "-c", "echo geheim; exit 4"]
        .map(String::from)
        .to_vec();
    let answer = ask(Endpoint {
        key: None,
        key_command: Some(KeyCommand::Program(words)),
        ..endpoint(server.base_url())
    })
    .await;
    let error = answer.error.unwrap().to_string();
    assert!(
        error.contains("key command `sh` failed") && error.contains("status: 4"),
        "{error}"
    );
    assert!(!error.contains("geheim"), "{error}");
    assert_eq!(server.requests(), []);
}

#[tokio::test]
async fn servers_of_this_machine_are_found() {
    let tags = json!({"models": [{"name": "qwen3:8b"}, {"name": "gemma:2b"}, {"name": ""}, {"name": "a\u{1b}[2J"}]});
    let models = json!({"object": "list", "data": [{"id": "a/b.gguf"}, {"id": "a/b.gguf"}]});
    let ollama = Server::start(vec![Script::json(200, &tags.to_string())]).await;
    let local = Server::start(vec![Script::json(200, &models.to_string())]).await;
    let page = Server::start(vec![Script::answer(
        200,
        &[("Content-Type", "text/html")],
        "<html>",
    )])
    .await;
    let slow = Server::start(vec![Script::silent().await_close()]).await;
    let users = format!(
        "[ollama]\nbase_url = \"{}\"\n[local]\nbase_url = \"{}/v1\"\nkey_env = \"K\"\n[lmstudio]\nbase_url = \"{}\"\n[vllm]\nbase_url = \"{}\"\n",
        ollama.base_url(),
        local.base_url(),
        page.base_url(),
        slow.base_url()
    );
    let registry = Registry::new(&toml::from_str(&users).unwrap()).unwrap();
    let environment = Environment::from_lookup(|name| (name == "K").then(|| KEY.to_string()));
    let begun = Instant::now();
    let found = probe(&registry, &environment).await;
    assert!(begun.elapsed() < Duration::from_secs(4));
    let ids: Vec<_> = found.models.iter().map(|d| d.id.as_str()).collect();
    assert_eq!(
        ids,
        ["local/a/b.gguf", "ollama/gemma:2b", "ollama/qwen3:8b"]
    );
    assert_eq!(ollama.requests()[0].path, "/api/tags");
    let asked = &local.requests()[0];
    assert_eq!(
        (asked.method.as_str(), asked.path.as_str()),
        ("GET", "/v1/models")
    );
    assert_eq!(
        asked.header("authorization"),
        Some(format!("Bearer {KEY}").as_str())
    );
}
