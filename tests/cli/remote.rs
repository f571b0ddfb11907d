//! `ask` with a language model: a server on loopback that speaks the chat-completions dialect of OpenAI.

use serde_json::{Value, json};

use super::CUT_IN;
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

pub const KEY: &str = "sk-test-9f8e7d6c5b4a3210";

const FINISH: &str =
    "data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n";
const USAGE: &str =
    "data: {\"choices\":[],\"usage\":{\"prompt_tokens\":9200,\"completion_tokens\":34}}\n\n";
const DONE: &str = "data: [DONE]\n\n";

pub fn delta(text: &str) -> String {
    format!(
        "data: {}\n\n",
        json!({"model": "tiny-2026", "choices": [{"index": 0, "delta": {"content": text}}]})
    )
}

/// A streamed answer in pieces of a few characters.
pub fn streamed(answer: &str) -> Script {
    let characters: Vec<char> = answer.chars().collect();
    let pieces = characters
        .chunks(7)
        .map(|c| delta(&c.iter().collect::<String>()));
    let script = pieces.fold(Script::chunked_events(), |script, piece| {
        script.chunk(piece)
    });
    script
        .chunk(FINISH)
        .chunk(USAGE)
        .chunk(DONE)
        .end_of_chunks()
}

fn verdict() -> Value {
    json!({
        "collision": true,
        "obstacles": [{"id": 301, "risk_score": 1, "reason": "close"}],
        "justification": "It cuts in.",
    })
}

/// Asks the server at `url` about a bundled scenario, with the key in the environment.
pub fn ask(home: &Home, url: &str, more: &[&str]) -> Ended {
    let mut arguments = vec!["ask", CUT_IN, "--model", "lab/tiny", "--base-url", url];
    arguments.extend(["--set=key_env=LAB_KEY"]);
    arguments.extend(more);
    let ended = tokio::task::block_in_place(|| home.run_with(&arguments, &[("LAB_KEY", KEY)]));
    assert!(
        !ended.stdout.contains(KEY) && !ended.stderr.contains(KEY),
        "{ended:?}"
    );
    assert!(home.files_with(KEY).is_empty(), "the key is in a file");
    ended
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_streamed_verdict_is_printed_and_kept() {
    let home = Home::new();
    let answer = format!("Let me see.\n```json\n{}\n```\n", verdict());
    let server = Server::start(vec![streamed(&answer)]).await;
    let more = [
        "--format=json",
        "--set=temperature=0.5",
        "--set=max_tokens=900",
        "--set=seed=4",
    ];
    let document = ask(&home, server.base_url(), &more).status(0).json();
    assert_eq!(document["task"], "collision");
    assert_eq!(document["verdict"]["collision"], true);
    assert_eq!(document["verdict"]["obstacles"], verdict()["obstacles"]);
    assert_eq!(document["model"], "lab/tiny");
    assert_eq!(document["model_returned"], "tiny-2026");

    let requests = server.requests();
    assert_eq!(requests.len(), 1);
    assert_eq!(
        requests[0].header("authorization"),
        Some(format!("Bearer {KEY}").as_str())
    );
    assert_eq!(requests[0].path, "/v1/chat/completions");
    let body = requests[0].json();
    assert_eq!(
        (&body["model"], &body["stream"]),
        (&json!("tiny"), &json!(true))
    );
    assert_eq!(
        (&body["temperature"], &body["max_tokens"], &body["seed"]),
        (&json!(0.5), &json!(900), &json!(4))
    );

    let runs = home.runs();
    assert_eq!(runs.len(), 1);
    let column = |name: &str| runs[0][name].as_deref().unwrap_or("NULL");
    let parsed = |name: &str| serde_json::from_str::<Value>(column(name)).unwrap();
    assert_eq!(
        parsed("messages"),
        body["messages"],
        "what is kept is what was sent"
    );
    let prompt = tokio::task::block_in_place(|| {
        home.run(&["prompt", "show", CUT_IN, "--format=json"])
            .status(0)
            .json()
    });
    assert_eq!(
        prompt["messages"], body["messages"],
        "what is shown is what was sent"
    );
    assert_eq!(
        parsed("parameters"),
        json!({"temperature": 0.5, "max_tokens": 900, "seed": 4})
    );
    assert_eq!(column("state"), "answered");
    assert_eq!(column("answer"), answer);
    assert_eq!(
        (column("model"), column("model_returned")),
        ("lab/tiny", "tiny-2026")
    );
    assert_eq!(
        column("endpoint"),
        format!("lab ({}/v1/chat/completions)", server.base_url())
    );
    assert_eq!(
        (column("input_tokens"), column("output_tokens")),
        ("9200", "34")
    );
    assert_eq!((column("cost_usd"), column("error")), ("NULL", "NULL"));
    assert_eq!(parsed("verdict")["collision"], true);
    assert_eq!(
        (column("task"), column("frame"), column("scenario")),
        ("collision", "ego", CUT_IN)
    );
    assert!(column("template_hash").len() == 64 && column("scenario_hash").len() == 64);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn people_see_the_verdict_the_tokens_and_the_other_name() {
    let home = Home::new();
    let server = Server::start(vec![streamed(&verdict().to_string())]).await;
    let ended = ask(&home, server.base_url(), &[]).status(0);
    for word in [
        "collision (lab/tiny)",
        "risk 1",
        "301",
        "It cuts in.",
        "9,200 in, 34 out",
        "tiny-2026",
    ] {
        assert!(ended.stdout.contains(word), "{word}: {}", ended.stdout);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_answer_without_a_verdict_is_kept_and_shown() {
    let home = Home::new();
    let words = "I would rather talk about the weather.";
    let server = Server::start(vec![streamed(words), streamed(words)]).await;
    let document = ask(&home, server.base_url(), &["--format=json"])
        .status(1)
        .says(&["no verdict"])
        .json();
    assert_eq!(document["answer"], words);
    assert_eq!(document["verdict"], Value::Null);
    assert_eq!(document["model"], "lab/tiny");
    assert!(
        document["problem"]
            .as_str()
            .is_some_and(|p| p.contains("no verdict"))
    );
    let ended = ask(&home, server.base_url(), &["--fresh"]).status(1);
    assert!(ended.stdout.contains(words), "{}", ended.stdout);
    // It was paid for, and is whole.
    let ended = ask(&home, server.base_url(), &[]).status(1);
    assert!(ended.stdout.contains(words), "{}", ended.stdout);
    assert_eq!(server.requests().len(), 2);
    let runs = home.runs();
    assert_eq!(runs.len(), 2);
    assert_eq!(runs[0]["answer"].as_deref(), Some(words));
    assert_eq!(
        (runs[0]["state"].as_deref(), &runs[0]["verdict"]),
        (Some("answered"), &None)
    );
}

/// A failure of a server whose words repeat the key, as some do.
async fn fails(script: Script, words: &[&str]) {
    let home = Home::new();
    let server = Server::start(vec![script.clone(), script.clone(), script]).await;
    let ended = ask(&home, server.base_url(), &["--format=json"])
        .status(1)
        .says(&["no answer", "lab", server.base_url()])
        .says(words);
    let document = ended.json();
    assert!(
        document["problem"]
            .as_str()
            .is_some_and(|p| ended.stderr.contains(p)),
        "{document}"
    );
    let runs = home.runs();
    assert_eq!(runs.len(), 1);
    assert_eq!(runs[0]["state"].as_deref(), Some("failed"));
    assert!(
        runs[0]["error"]
            .as_deref()
            .is_some_and(|e| words.iter().all(|w| e.contains(w)))
    );
}

fn refusal(status: u16, message: &str) -> Script {
    let body = json!({"error": {"message": format!("{message} (key {KEY})")}}).to_string();
    Script::answer(
        status,
        &[
            ("Content-Type", "application/json"),
            ("retry-after-ms", "5"),
        ],
        &body,
    )
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_wrong_key_is_named_by_its_variable() {
    fails(
        refusal(401, "invalid key"),
        &["rejected the key from LAB_KEY", "401"],
    )
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_unknown_model_is_named() {
    fails(
        refusal(404, "no such model"),
        &["tiny", "404", "check the model's name"],
    )
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_limit_is_explained() {
    fails(
        refusal(429, "slow down"),
        &["limiting requests", "429", "slow down"],
    )
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_failing_server_is_reported() {
    fails(refusal(500, "oops"), &["500", "oops", "try again"]).await;
    let home = Home::new();
    let server = Server::start(vec![refusal(400, "oops")]).await;
    let ended = ask(&home, server.base_url(), &[]).status(1);
    let all: Vec<&str> = ended.stdout.lines().chain(ended.stderr.lines()).collect();
    assert!(all.iter().all(|line| !line.is_empty()), "{all:?}");
    assert!(!ended.stdout.contains("unknown"), "{}", ended.stdout);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_failure_that_passes_is_not_reported() {
    let home = Home::new();
    let server = Server::start(vec![refusal(503, "busy"), streamed(&verdict().to_string())]).await;
    ask(&home, server.base_url(), &["--format=json"]).status(0);
    assert_eq!(server.requests().len(), 2);
    assert_eq!(home.runs().len(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_cut_stream_is_no_answer_and_its_text_is_kept() {
    let home = Home::new();
    let script = Script::chunked_events().chunk(delta("{\"collision\": true, "));
    let server = Server::start(vec![script]).await;
    let ended = ask(&home, server.base_url(), &["--format=json"])
        .status(1)
        .says(&["broke off", "ask again"]);
    assert_eq!(ended.json()["answer"], "{\"collision\": true, ");
    assert_eq!(
        server.requests().len(),
        1,
        "an answer that began is not asked for twice"
    );
    let runs = home.runs();
    assert_eq!(runs[0]["state"].as_deref(), Some("failed"));
    assert_eq!(runs[0]["answer"].as_deref(), Some("{\"collision\": true, "));
    assert_eq!(runs[0]["verdict"], None);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_refused_connection_says_what_to_check() {
    let home = Home::new();
    // A port that was free a moment ago.
    let url = Server::start(Vec::new()).await.base_url().to_string();
    let ended = ask(&home, &url, &[]).status(1);
    ended.says(&["cannot reach lab", &url, "check that the server is running"]);
    assert_eq!(home.runs()[0]["state"].as_deref(), Some("failed"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_missing_key_is_asked_for_by_name() {
    let home = Home::new();
    let server = Server::start(vec![Script::json(
        401,
        r#"{"error":{"message":"who are you"}}"#,
    )])
    .await;
    let url = server.base_url();
    let arguments = [
        "ask",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--base-url",
        url,
        "--set=key_env=LAB_KEY_NOT_SET",
    ];
    let ended = tokio::task::block_in_place(|| home.run(&arguments));
    ended
        .status(2)
        .says(&["nothing was sent", "set LAB_KEY_NOT_SET"]);
    assert!(
        server.requests().is_empty(),
        "nothing is sent that could only be refused"
    );
    let ended =
        tokio::task::block_in_place(|| home.run(&["ask", CUT_IN, "--model", "openrouter/x"]));
    ended.status(2).says(&["set OPENROUTER_API_KEY"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_provider_of_the_configuration_is_asked() {
    let home = Home::new();
    let server = Server::start(vec![streamed(&verdict().to_string())]).await;
    let config = format!(
        "temperature = 0.25\n[provider.house]\nbase_url = \"{}\"\nkey_env = \"LAB_KEY\"\nresponse_format = \"off\"\n",
        server.base_url()
    );
    home.write(home.config().join("config.toml"), config);
    let arguments = ["ask", CUT_IN, "--model", "house/org/big", "--format=json"];
    let ended = tokio::task::block_in_place(|| home.run_with(&arguments, &[("LAB_KEY", KEY)]));
    assert_eq!(ended.status(0).json()["model"], "house/org/big");
    let body = server.requests()[0].json();
    assert_eq!(
        (&body["model"], &body["temperature"]),
        (&json!("org/big"), &json!(0.25))
    );
    assert_eq!(body.get("response_format"), None);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn all_techniques_send_the_same_form_of_answer() {
    let home = Home::new();
    let all = ["base", "cp", "cp,cot", "all"];
    let answers = all.map(|_| streamed(&verdict().to_string()));
    let server = Server::start(answers.to_vec()).await;
    let config = format!(
        "max_tokens = 900\n[provider.house]\nbase_url = \"{}\"\nkey_env = \"LAB_KEY\"\nresponse_format = \"json_schema\"\n",
        server.base_url()
    );
    home.write(home.config().join("config.toml"), config);
    for techniques in all {
        let model = ["ask", CUT_IN, "--model", "house/big"];
        let arguments = [&model[..], &["--techniques", techniques, "--format=json"]].concat();
        let ended = tokio::task::block_in_place(|| home.run_with(&arguments, &[("LAB_KEY", KEY)]));
        ended.status(0);
    }
    let bodies: Vec<Value> = server.requests().iter().map(|r| r.json()).collect();
    assert_eq!(bodies.len(), all.len());
    let form = &bodies[0]["response_format"];
    assert_eq!(form["type"], "json_schema", "{form}");
    for body in &bodies {
        assert_eq!(&body["response_format"], form);
        assert_eq!(body["max_tokens"], 900);
        let system = body["messages"][0]["content"].as_str().unwrap();
        assert!(
            system.contains("one JSON object of exactly this form"),
            "{system}"
        );
        assert!(!system.contains("```json"), "{system}");
    }
}
