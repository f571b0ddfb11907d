//! `mcp`: jobs run aside, say how long they take, and end when they are cancelled.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::mcp::{CUT_IN, Client};
use super::support::dialects::{saying, script};
use super::support::program::Home;
use super::support::server::Server;

/// A scenario in which a search tries every motion: its only obstacle is too far behind to reach the ego.
pub const FAR: &str = "Far.xml";

/// Writes that scenario and its ego into the folder `in`.
pub fn write_far(home: &Home) {
    let shipped = |ending: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        std::fs::read_to_string(folder.join(format!("{CUT_IN}.{ending}"))).unwrap()
    };
    let text = shipped("xml");
    let end = "</dynamicObstacle>";
    let others = |part: &&str| !part.contains("<dynamicObstacle") || part.contains("id=\"303\"");
    let (head, all) = text.split_at(text.find("<dynamicObstacle").unwrap());
    let far: String = all.split_inclusive(end).filter(others).collect();
    home.write(format!("in/{FAR}"), format!("{head}{far}"));
    home.write("in/Far.ego_trajectory.csv", shipped("ego_trajectory.csv"));
}

/// A server of that scenario.
fn start(home: &Home) -> Client {
    write_far(home);
    Client::start(home, &["in"])
}

/// Sends a search that takes long.
fn begin(client: &mut Client, id: &str, token: &Value) {
    client.send(
        &json!({"jsonrpc": "2.0", "id": id, "method": "tools/call", "params": {
        "name": "generate", "arguments": {"scenario": FAR, "candidates": 100_000},
        "_meta": {"progressToken": token}}})
        .to_string(),
    );
}

fn cancel(client: &mut Client, id: &str) {
    let gone =
        json!({"jsonrpc": "2.0", "method": "notifications/cancelled", "params": {"requestId": id}});
    client.send(&gone.to_string());
}

/// The answer to a ping, and the tokens of progress that came before it.
fn ping(client: &mut Client) -> Vec<Value> {
    client.send(r#"{"jsonrpc":"2.0","id":"ping","method":"ping"}"#);
    let mut tokens = Vec::new();
    loop {
        let message = client.next();
        if message["id"] == "ping" {
            assert_eq!(message["result"], json!({}));
            return tokens;
        }
        assert_eq!(message["method"], "notifications/progress", "{message}");
        tokens.push(message["params"]["progressToken"].clone());
    }
}

#[test]
fn a_cancelled_job_says_no_more_and_gives_its_place_back() {
    let home = Home::new();
    let mut client = start(&home);
    for id in ["a", "b", "c", "d"] {
        begin(&mut client, id, &json!(id));
    }
    let progress = client.next();
    assert_eq!(progress["method"], "notifications/progress", "{progress}");
    // An id that is still in use, and one job too many.
    begin(&mut client, "a", &json!("again"));
    begin(&mut client, "e", &json!("e"));
    let (mut twice, mut full) = (Value::Null, Value::Null);
    while twice.is_null() || full.is_null() {
        let message = client.next();
        match message["id"].as_str() {
            Some("a") => twice = message,
            Some("e") => full = message,
            _ => assert_eq!(message["method"], "notifications/progress", "{message}"),
        }
    }
    assert_eq!(twice["error"]["code"], -32600, "{twice}");
    assert_eq!(full["result"]["isError"], true, "{full}");
    cancel(&mut client, "a");
    cancel(&mut client, "b");
    // It has some seconds to end by itself.
    let begun = Instant::now();
    let mut number = 0;
    loop {
        assert!(
            begun.elapsed() < Duration::from_secs(20),
            "no place is free"
        );
        std::thread::sleep(Duration::from_millis(200));
        ping(&mut client);
        number += 1;
        let id = format!("late {number}");
        begin(&mut client, &id, &json!(id));
        // Refusals come at once.
        client.send(r#"{"jsonrpc":"2.0","id":"ping","method":"ping"}"#);
        let mut refused = false;
        loop {
            let message = client.next();
            if message["id"] == "ping" {
                break;
            }
            refused |= message["id"] == json!(id);
        }
        if !refused {
            break;
        }
    }
    std::thread::sleep(Duration::from_millis(4000));
    // What was said until they had ended.
    ping(&mut client);
    std::thread::sleep(Duration::from_millis(1500));
    let after = ping(&mut client);
    assert!(after.contains(&json!("c")), "{after:?}");
    assert!(
        !after.contains(&json!("a")) && !after.contains(&json!("b")),
        "{after:?}"
    );
    client.end_amid_jobs();
}

/// Processes that run as children of one.
#[cfg(target_os = "linux")]
fn children(of: u32) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").unwrap().flatten();
    let numbers = all.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let is_child = |number: &u32| {
        let stat = std::fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
        let after_name = stat.rsplit(") ").next().unwrap_or_default().to_string();
        after_name.split(' ').nth(1) == Some(&of.to_string())
    };
    numbers.filter(is_child).collect()
}

#[cfg(target_os = "linux")]
#[test]
fn jobs_end_with_a_server_that_is_terminated() {
    let home = Home::new();
    let mut client = start(&home);
    begin(&mut client, "a", &json!("a"));
    assert_eq!(client.next()["params"]["progressToken"], "a");
    let jobs = children(client.child.id());
    assert_eq!(jobs.len(), 1);
    let server = client.child.id().to_string();
    // Waiting would end the input, which ends the server, too.
    let input = client.child.stdin.take();
    let sent = std::process::Command::new("kill")
        .args(["-TERM", &server])
        .status();
    assert!(sent.unwrap().success());
    assert_eq!(client.child.wait().unwrap().code(), Some(130));
    drop(input);
    let runs = || {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", jobs[0])).unwrap_or_default();
        !stat.is_empty() && !stat.contains(") Z ")
    };
    let begun = Instant::now();
    while runs() {
        assert!(
            begun.elapsed() < Duration::from_secs(2),
            "the job goes on alone"
        );
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn progress_is_told_only_by_tokens_of_the_protocol() {
    let home = Home::new();
    let mut client = start(&home);
    for (id, token) in [("a", json!(1.5)), ("b", json!({"x": 1})), ("c", json!(7))] {
        begin(&mut client, id, &token);
    }
    std::thread::sleep(Duration::from_millis(2500));
    let tokens = ping(&mut client);
    assert!(
        !tokens.is_empty() && tokens.iter().all(|token| *token == json!(7)),
        "{tokens:?}"
    );
    client.end_amid_jobs();
}

#[test]
fn prompts_are_filled_aside() {
    let home = Home::new();
    let mut client = Client::start(&home, &[]);
    let prompt = json!({"jsonrpc": "2.0", "id": "prompt", "method": "prompts/get",
        "params": {"name": "safety-ego", "arguments": {"scenario": CUT_IN, "at": "20"}}});
    client.send(&format!(
        "{prompt}\n{}",
        json!({"jsonrpc": "2.0", "id": "ping", "method": "ping"})
    ));
    assert_eq!(client.next()["id"], "ping");
    let prompt = client.next();
    assert_eq!(prompt["id"], "prompt");
    assert!(prompt["result"]["messages"].is_array(), "{prompt}");
    // Mistakes are those of the client.
    let missing = client.ask(
        "prompts/get",
        json!({"name": "safety-ego", "arguments": {"scenario": CUT_IN, "at": 9999}}),
    );
    assert_eq!(missing["error"]["code"], -32602, "{missing}");
    let other = client.ask(
        "prompts/get",
        json!({"name": "safety-ego", "arguments": {"scenario": CUT_IN, "egoo": "7"}}),
    );
    assert_eq!(other["error"]["code"], -32602, "{other}");
    let why = other["error"]["message"].as_str().unwrap();
    assert!(why.contains("`egoo`") && why.contains("`ego`"), "{why}");
    let unknown = client.ask(
        "prompts/get",
        json!({"name": "no", "arguments": {"scenario": CUT_IN}}),
    );
    assert_eq!(unknown["error"]["code"], -32602, "{unknown}");
    client.end();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn models_are_asked_within_the_budget_of_the_session() {
    let dialect = nearmiss::llm::Dialect::OpenAiChat;
    let home = Home::new();
    let verdict = r#"{"collision": false, "obstacles": [], "justification": "Far."}"#;
    let server =
        Server::answering(move |_, _| Some(script(dialect).send(saying(dialect, verdict)))).await;
    let url = server.base_url();
    home.write(
        home.config().join("config.toml"),
        format!(
            "max_tokens = 200\n[provider.lab]\nbase_url = \"{url}\"\n[[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 1\noutput = 1\n"
        ),
    );
    tokio::task::block_in_place(|| {
        home.run(&["mcp", "--allow-models"])
            .status(2)
            .says(&["--budget"]);
        let mut client = Client::start(&home, &["--allow-models", "--budget", "0.5"]);
        let asked = |client: &mut Client, budget: Value| {
            client.call(
                "ask_model",
                json!({"scenario": CUT_IN, "model": "lab/tiny", "budget": budget}),
            )
        };
        for refused in [json!(0.6), json!(-5)] {
            let refused = asked(&mut client, refused);
            assert_eq!(refused["isError"], true, "{refused}");
        }
        // What is not sent costs nothing.
        let little = asked(&mut client, json!(1e-9));
        assert!(little.to_string().contains("nothing was sent"), "{little}");
        let answer = asked(&mut client, json!(0.5));
        assert_eq!(
            answer["structuredContent"]["verdict"]["collision"], false,
            "{answer}"
        );
        // What the answer did not cost is there again.
        let again = asked(&mut client, json!(0.4));
        assert_eq!(again["isError"], false, "{again}");
        client.end();
    });
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_model_is_asked_with_the_limit_of_the_call_where_the_configuration_has_none() {
    let dialect = nearmiss::llm::Dialect::OpenAiChat;
    let home = Home::new();
    let verdict = r#"{"collision": false, "obstacles": [], "justification": "Far."}"#;
    let server =
        Server::answering(move |_, _| Some(script(dialect).send(saying(dialect, verdict)))).await;
    let url = server.base_url();
    let config = format!(
        "[provider.lab]\nbase_url = \"{url}\"\n[[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 1\noutput = 1\n"
    );
    home.write(home.config().join("config.toml"), config);
    tokio::task::block_in_place(|| {
        let mut client = Client::start(&home, &["--allow-models", "--budget", "0.02"]);
        let asked = |client: &mut Client, limit: Value| {
            let arguments = json!({"scenario": CUT_IN, "model": "lab/tiny", "max_tokens": limit});
            client.call("ask_model", arguments)
        };
        let unlimited = asked(&mut client, Value::Null);
        assert!(unlimited.to_string().contains("max_tokens"), "{unlimited}");
        let none = asked(&mut client, json!(0)).to_string();
        assert!(none.contains("a whole number from 1 to"), "{none}");
        let answer = asked(&mut client, json!(200));
        assert_eq!(
            answer["structuredContent"]["verdict"]["collision"], false,
            "{answer}"
        );
        client.end();
    });
    assert_eq!(server.requests().len(), 1);
}
