//! Models that call tools: a server plays them in every dialect.

use nearmiss::llm::Dialect;
use serde_json::{Value, json};

use super::CUT_IN;
use super::support::dialects::{calling, saying, script};
use super::support::program::{Ended, Home};
use super::support::server::{Recorded, Script, Server};

const VERDICT: &str =
    r#"{"collision": false, "obstacles": [], "justification": "The gap stays 2 m."}"#;

const PRICES: &str = "[[provider.lab.prices]]\nmodel = \"tiny*\"\ninput = 1000\noutput = 10000\n[[provider.lab.prices]]\nmodel = \"m-*\"\ninput = 1000\noutput = 10000\n";

fn ask(home: &Home, url: &str, dialect: Dialect, more: &[&str]) -> Ended {
    let dialect_option = format!("--set=dialect={}", dialect.name());
    let mut all = vec![
        "ask",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--base-url",
        url,
        &dialect_option,
    ];
    all.extend(["--format=json", "--set=tools=on"]);
    all.extend(more);
    tokio::task::block_in_place(|| home.run(&all))
}

/// Whether a request offers tools and lets the model call them.
fn may_call(body: &Value) -> bool {
    let forbidden = body["tool_choice"] == "none"
        || body["tool_choice"]["type"] == "none"
        || body["toolConfig"]["functionCallingConfig"]["mode"] == "NONE";
    body.get("tools").is_some() && !forbidden
}

/// A model that makes these calls, a round each, and then answers; it calls nothing once it may not.
async fn played(
    dialect: Dialect,
    rounds: Vec<Vec<(&'static str, &'static str, &'static str)>>,
) -> Server {
    Server::answering(move |number, request: &Recorded| {
        let body = match rounds.get(number) {
            Some(calls) if may_call(&request.json()) => calling(dialect, calls),
            _ => saying(dialect, VERDICT),
        };
        Some(script(dialect).send(body))
    })
    .await
}

fn rounds(home: &Home) -> Value {
    let rows = home.rows("SELECT tool_rounds FROM runs ORDER BY id DESC LIMIT 1");
    serde_json::from_str(rows[0]["tool_rounds"].as_deref().unwrap()).unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn calls_are_answered_stored_and_counted_in_every_dialect() {
    for dialect in Dialect::ALL {
        let home = Home::new();
        let form = "[provider.lab]\nresponse_format = \"json_schema\"\n";
        home.write(home.config().join("config.toml"), format!("{form}{PRICES}"));
        let calls = vec![
            vec![
                ("call_a", "list_obstacles", "{}"),
                ("call_b", "distance", r#"{"obstacle": 304}"#),
            ],
            vec![
                ("call_c", "distanse", "{}"),
                ("call_d", "distance", r#"{"obstacle": 304, "t": 3}"#),
                ("call_e", "judge", "{}"),
            ],
        ];
        let server = played(dialect, calls).await;
        let document = ask(&home, server.base_url(), dialect, &[]).status(0).json();
        assert_eq!(document["dangerous"], false, "{dialect:?}");
        assert_eq!(server.requests().len(), 3);
        let last = String::from_utf8(server.requests()[2].body.clone()).unwrap();
        for told in [
            "nothing after t = 0 can be asked",
            "unknown tool `distanse`",
            "unknown tool `judge`",
        ] {
            assert!(last.contains(told), "{dialect:?} {told}: {last}");
        }
        let stored = rounds(&home);
        assert_eq!(stored.as_array().unwrap().len(), 2);
        assert!(
            stored[0]["results"][1]
                .as_str()
                .unwrap()
                .contains("distance"),
            "{stored}"
        );
        // 100 + 100 + 200 tokens of questions, 10 + 10 + 20 of answers.
        assert_eq!(document["input_tokens"], 400, "{dialect:?}");
        let usd = document["cost_usd"].as_f64().unwrap();
        assert!(
            (usd - (400.0 * 1000.0 + 40.0 * 10000.0) / 1e6).abs() < 1e-9,
            "{usd}"
        );
        // Gemini, Ollama and servers on this machine take no form beside tools.
        let parameters = home.rows("SELECT parameters FROM runs ORDER BY id DESC LIMIT 1");
        let parameters = parameters[0]["parameters"].as_deref().unwrap();
        let late = !matches!(dialect, Dialect::OpenAiResponses | Dialect::Anthropic);
        assert_eq!(
            parameters.contains("answer_form"),
            late,
            "{dialect:?} {parameters}"
        );
        // The same question again is answered by the store, with its calls.
        let again = ask(&home, server.base_url(), dialect, &[]).status(0).json();
        assert_eq!(again["run"], document["run"]);
        assert_eq!(server.requests().len(), 3);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn endless_calls_end_at_the_limits() {
    let dialect = Dialect::OpenAiChat;
    let endless = || vec![vec![("c", "distance", r#"{"obstacle": 304}"#); 3]; 50];
    let home = Home::new();
    let server = played(dialect, endless()).await;
    let limited = ask(&home, server.base_url(), dialect, &["--set=tool_rounds=3"]).status(0);
    limited.says(&["9 tool calls in 3 rounds, the most allowed; the model answers without tools"]);
    assert_eq!(server.requests().len(), 4);
    assert!(!may_call(&server.requests()[3].json()));
    let home = Home::new();
    let server = played(dialect, endless()).await;
    let few = ask(&home, server.base_url(), dialect, &["--set=tool_calls=4"]).status(0);
    // Calls that were refused are not made.
    few.says(&["4 tool calls in 2 rounds, 2 more refused, the most allowed"]);
    assert_eq!(server.requests().len(), 3);
    assert!(
        rounds(&home)[1]["results"][2]
            .as_str()
            .unwrap()
            .contains("limit of 4 tool calls")
    );
    // One that does not stop has no verdict, and the run says why.
    let home = Home::new();
    let stubborn = Server::answering(move |_, _: &Recorded| {
        Some(script(dialect).send(calling(dialect, &[("c", "distance", "{}")])))
    })
    .await;
    ask(
        &home,
        stubborn.base_url(),
        dialect,
        &["--set=tool_rounds=2"],
    )
    .status(1)
    .says(&["after the limit of 2 rounds"]);
    assert_eq!(stubborn.requests().len(), 3);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_budget_holds_between_rounds() {
    let dialect = Dialect::OpenAiChat;
    let home = Home::new();
    home.write(home.config().join("config.toml"), PRICES);
    let endless = vec![vec![("c", "list_obstacles", "{}")]; 50];
    let server = played(dialect, endless).await;
    let most = ["--set=max_tokens=10", "--budget", "9"];
    let ended = ask(&home, server.base_url(), dialect, &most);
    let asked = server.requests().len();
    assert!((1..9).contains(&asked), "{asked} {ended:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_killed_run_goes_on_after_its_paid_rounds() {
    let dialect = Dialect::Anthropic;
    let home = Home::new();
    let server = Server::answering(move |number, request: &Recorded| {
        let text = String::from_utf8_lossy(&request.body).into_owned();
        let had = text.matches("tool_result").count();
        Some(match (number, had) {
            (_, 0) => script(dialect).send(calling(dialect, &[("call_a", "list_obstacles", "{}")])),
            // The second request is never answered; the program is killed meanwhile.
            (1, _) => Script::silent().await_close(),
            _ => script(dialect).send(saying(dialect, VERDICT)),
        })
    })
    .await;
    let url = server.base_url().to_string();
    let arguments = [
        "ask",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--base-url",
        &url,
        "--set=dialect=anthropic",
        "--set=tools=on",
        "--format=json",
    ];
    let mut child = home.start(&arguments);
    for _ in 0..400 {
        if server.requests().len() == 2 {
            break;
        }
        tokio::time::sleep(std::time::Duration::from_millis(50)).await;
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(server.requests().len(), 2);
    let ended = ask(&home, &url, dialect, &[]).status(0);
    let document = ended.json();
    ended.says(&["continuing after 1 round of tool calls"]);
    assert_eq!(document["dangerous"], false);
    // The first request was not sent again.
    let bodies = server.requests().into_iter().map(|r| r.json());
    let first = bodies
        .filter(|body| !body.to_string().contains("tool_result"))
        .count();
    assert_eq!((first, server.requests().len()), (1, 3));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn rounds_that_the_server_refuses_are_left_out() {
    let dialect = Dialect::OpenAiChat;
    let home = Home::new();
    // The second request of the first run gets no answer; then rounds of that run are refused.
    let server = Server::answering(move |number, request: &Recorded| {
        let had = String::from_utf8_lossy(&request.body).contains("call_old");
        Some(match (number, had) {
            (0, _) => {
                script(dialect).send(calling(dialect, &[("call_old", "list_obstacles", "{}")]))
            }
            (_, true) => Script::json(400, r#"{"error": {"message": "no such call"}}"#),
            _ => script(dialect).send(saying(dialect, VERDICT)),
        })
    })
    .await;
    let url = server.base_url();
    ask(&home, url, dialect, &[])
        .status(1)
        .says(&["no such call"]);
    assert_eq!(server.requests().len(), 2);
    let ended = ask(&home, url, dialect, &[])
        .status(0)
        .says(&["continuing after 1 round ", "asking from the beginning"]);
    assert_eq!(ended.json()["dangerous"], false);
    assert_eq!(server.requests().len(), 4);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn with_and_without_tools_are_an_axis() {
    let dialect = Dialect::OpenAiChat;
    let home = Home::new();
    let server = Server::answering(move |_, request: &Recorded| {
        let body = request.json();
        let had = body.to_string().contains("tool_call_id");
        Some(script(dialect).send(if may_call(&body) && !had {
            calling(dialect, &[("c", "list_obstacles", "{}")])
        } else {
            saying(dialect, VERDICT)
        }))
    })
    .await;
    let address = format!("base_url={}", server.base_url());
    let arguments = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--set",
        &address,
        "--set",
        "tools=off,on",
        "--format=json",
    ];
    let ended = tokio::task::block_in_place(|| home.run(&arguments)).status(0);
    assert!(ended.stdout.contains("tools"), "{ended:?}");
    let asked = server.requests().into_iter().map(|r| r.json());
    let with = asked.filter(|body| body.get("tools").is_some()).count();
    assert_eq!((with, server.requests().len()), (2, 3));
    let rows = home.rows("SELECT settings FROM items ORDER BY place");
    let settings: Vec<_> = rows.iter().map(|row| row["settings"].clone()).collect();
    assert_eq!(
        settings,
        [Some("tools off".to_string()), Some("tools on".to_string())]
    );
    assert_eq!(json!(settings).as_array().unwrap().len(), 2);
    // The page of answers shows what a model was told.
    home.run(&["report", "-o", "page.html"]).status(0);
    let page = std::fs::read_to_string(home.files().join("page.html")).unwrap();
    assert!(page.contains("tools, round 1") && page.contains("list_obstacles {}"));
    // What nothing bounds is said not to be in the price.
    home.write(home.config().join("config.toml"), PRICES);
    let priced = |tools: &str| {
        // Another frame: nothing of it is stored.
        let all = ["evaluate", CUT_IN, "--model", "lab/tiny", "--dry-run"];
        let more = ["--set", "frames=metrics", "--set", &address];
        let tools = format!("tools={tools}");
        home.run(&[&all[..], &more, &["--set", &tools]].concat())
            .status(0)
            .stdout
    };
    assert!(
        priced("on").contains("without up to 8 rounds of tools each"),
        "{}",
        priced("on")
    );
    assert!(!priced("off").contains("rounds of tools"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn models_whose_chat_refuses_tools_are_asked_by_responses() {
    let home = Home::new();
    let server = Server::answering(|number, request: &Recorded| {
        let dialect = if request.path.ends_with("/responses") {
            Dialect::OpenAiResponses
        } else {
            Dialect::OpenAiChat
        };
        let calls = [("call_a", "list_obstacles", "{}")];
        let body = match number {
            0 => calling(dialect, &calls),
            _ => saying(dialect, VERDICT),
        };
        Some(script(dialect).send(body))
    })
    .await;
    let url = format!("{}/v1", server.base_url());
    let ask = |more: &[&str]| {
        let mut all = vec!["ask", CUT_IN, "--model", "openai/gpt-6-luna"];
        all.extend(["--base-url", &url, "--format=json"].iter().chain(more));
        let keys = [("OPENAI_API_KEY", "sk-0123456789")];
        tokio::task::block_in_place(|| home.run_with(&all, &keys)).status(0)
    };
    ask(&["--set=tools=on", "--set=effort=high"]);
    ask(&[]);
    let sent = server.requests();
    let paths: Vec<&str> = sent.iter().map(|request| request.path.as_str()).collect();
    let [tools, plain] = ["/v1/responses", "/v1/chat/completions"];
    assert_eq!(paths, [tools, tools, plain]);
    assert_eq!(sent[0].json()["reasoning"]["effort"], "high");
    assert_eq!(
        sent[0].header("authorization"),
        Some("Bearer sk-0123456789")
    );
    let rows = home.rows("SELECT dialect, address, cost_usd FROM runs ORDER BY id");
    for (row, (dialect, path)) in rows
        .iter()
        .zip([("openai_responses", tools), ("openai_chat", plain)])
    {
        assert_eq!(row["dialect"].as_deref(), Some(dialect));
        assert!(
            row["address"].as_deref().unwrap().ends_with(path),
            "{row:?}"
        );
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_model_that_calls_no_tools_is_refused_before_anything_is_sent() {
    let dialect = Dialect::OpenAiChat;
    let server = played(dialect, Vec::new()).await;
    let home = Home::new();
    let lacking = "[provider.lab]\nquirks = { tools = false }\n";
    home.write(home.config().join("config.toml"), lacking);
    ask(&home, server.base_url(), dialect, &[])
        .status(2)
        .says(&["tiny calls no tools", "tools = true"]);
    assert_eq!(server.requests().len(), 0);
    assert_eq!(home.rows("SELECT id FROM runs").len(), 0);
}
