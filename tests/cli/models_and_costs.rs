//! Who is asked, what is left out, what it cost and how that is told: what a first user looks for.

use serde_json::json;

use super::CUT_IN;
use super::remote::{delta, streamed};
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

const PRICES: &str = "[[provider.lab.prices]]\nmodel = \"tiny*\"\ninput = 100\noutput = 1000\n";

fn no_collision() -> Script {
    streamed(&json!({"collision": false, "obstacles": [], "justification": "j"}).to_string())
}

fn configure(home: &Home, text: &str) {
    home.write(home.config().join("config.toml"), text);
}

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_configured_model_is_asked_where_none_is_named() {
    let home = Home::new();
    let server = Server::start(vec![no_collision()]).await;
    let url = server.base_url();
    configure(
        &home,
        &format!("model = \"lab/tiny\"\n[provider.lab]\nbase_url = \"{url}\"\n"),
    );
    let document = run(&home, &["ask", CUT_IN, "--format=json"])
        .status(0)
        .json();
    assert_eq!(document["model"], "lab/tiny");
    let named = [
        "ask",
        CUT_IN,
        "--format=json",
        "--model",
        "reference/geometry",
    ];
    let document = run(&home, &named).status(0).json();
    assert_eq!(document["model"], "reference/geometry");
    assert_eq!(server.requests().len(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_broken_provider_is_left_out_alone() {
    let home = Home::new();
    let server = Server::start(vec![no_collision()]).await;
    let url = server.base_url();
    let good = format!("[provider.good]\nbase_url = \"{url}\"\nmodels = [\"tiny\"]\n");
    let broken = PRICES.replace("input", "imput");
    configure(
        &home,
        &format!("{good}[provider.lab]\nbase_url = \"{url}\"\n{broken}"),
    );
    let place = "config.toml:8: [provider.lab]";
    let listed = run(&home, &["models", "--offline"]).status(0);
    assert!(listed.stdout.contains("good/tiny") && !listed.stdout.contains("\nlab/"));
    listed.says(&[place, "`imput`", "disabled"]);
    run(&home, &["ask", CUT_IN, "--model", "lab/tiny"])
        .status(2)
        .says(&[place]);
    run(&home, &["ask", CUT_IN, "--model", "good/tiny"])
        .status(0)
        .says(&[place]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_address_that_cannot_be_reached_is_an_attempt() {
    let home = Home::new();
    let ask = ["ask", CUT_IN, "--model", "x/tiny", "--base-url"];
    let at = |url: &str| run(&home, &[&ask[..], &[url]].concat());
    let ended = at("http://127.0.0.1:9")
        .status(1)
        .says(&["no answer: cannot reach x", "(run 1)"]);
    assert!(
        !ended.stderr.contains("nothing was sent"),
        "{}",
        ended.stderr
    );
    let shown = run(&home, &["runs", "show", "1"]).status(0).stdout;
    assert!(shown.contains("cost          0 US dollars"), "{shown}");
    let ended = at("127.0.0.1:4021")
        .status(2)
        .says(&["nothing was sent", "write it like http://127.0.0.1:4021"]);
    assert!(!ended.stderr.contains("relative"), "{}", ended.stderr);
    assert_eq!(home.runs().len(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_answer_under_another_name_says_so_and_has_its_price() {
    let home = Home::new();
    let server = Server::start(vec![no_collision()]).await;
    let url = server.base_url();
    // Prices of another model: the provider is not free, though it is on this machine.
    configure(
        &home,
        &format!(
            "[provider.x]\nbase_url = \"{url}\"\n[[provider.x.prices]]\nmodel = \"other\"\ninput = 1.0\noutput = 1.0\n"
        ),
    );
    let elsewhere = ["ask", CUT_IN, "--model", "x/tiny"];
    let first = run(&home, &elsewhere).status(0).stdout;
    assert!(first.contains("unknown (no price for"), "{first}");
    configure(
        &home,
        &format!("[provider.lab]\nbase_url = \"{url}\"\n{PRICES}"),
    );
    let asked = ["ask", CUT_IN, "--model", "lab/tiny"];
    let again = run(&home, &asked).status(0).stdout;
    for words in [
        "(lab/tiny; the answer of run 1, asked as x/tiny)",
        "0.954000 USD (computed now",
    ] {
        assert!(again.contains(words), "{words}: {again}");
    }
    let document = run(&home, &[&asked[..], &["--format=json"]].concat()).json();
    assert_eq!(document["cost_usd"], 0.954);
    assert_eq!(document["stored"]["asked_as"], "x/tiny");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_breaks_off_has_a_bound_of_its_cost() {
    let home = Home::new();
    let cut = Script::chunked_events().chunk(delta("{\"coll"));
    let long = r#"{"error":{"message":"This model's maximum context length is 4096 tokens"}}"#;
    let server = Server::start(vec![no_collision(), cut, Script::json(400, long)]).await;
    let url = server.base_url();
    configure(
        &home,
        &format!("max_tokens = 1000\n[provider.lab]\nbase_url = \"{url}\"\n{PRICES}"),
    );
    let ask = |status| {
        let arguments = ["ask", CUT_IN, "--model", "lab/tiny", "--fresh"];
        run(&home, &arguments).status(status)
    };
    ask(0);
    ask(1);
    let listed = run(&home, &["runs", "list"]).status(0);
    let lines: Vec<&str> = listed.stdout.lines().collect();
    assert!(lines[0].contains("verdict") && lines[0].contains("cost [$]"));
    assert!(
        lines[1].contains("failed") && lines[1].contains("<="),
        "{lines:?}"
    );
    assert!(lines[2].contains("no collision") && lines[2].contains("0.954000"));
    listed.says(&["2 runs: 0.954000 US dollars; 1 of unknown cost, at most "]);
    let shown = run(&home, &["runs", "show", "2"]).status(0).stdout;
    assert!(shown.contains("cost          at most "), "{shown}");
    ask(1).says(&["form=compact", "--history", "--techniques base"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_done_to_runs_is_said() {
    let home = Home::new();
    run(&home, &["ask", CUT_IN]).status(0);
    for (arguments, words) in [
        (&["pin", "1"][..], "run 1: pinned"),
        (&["pin", "1"], "already pinned; nothing changed"),
        (&["unpin", "1"], "no longer pinned"),
        (&["restore", "1"], "was not deleted; nothing changed"),
        (&["delete", "1"], "run 1: deleted; `nearmiss runs restore`"),
        (&["restore", "1"], "run 1: restored"),
        (&["note", "1", "odd"], "run 1: noted"),
        (&["note", "1", "odd"], "nothing changed"),
        (&["list", "nowhere"], "no matching runs"),
    ] {
        run(&home, &[&["runs"], arguments].concat())
            .status(0)
            .says(&[words]);
    }
    let ended = run(&home, &["runs", "show", "one"])
        .status(2)
        .says(&["'one'", "expected a whole number"]);
    assert!(!ended.stderr.contains("digit"), "{}", ended.stderr);
    let counted = home.rows("SELECT sum(is_dangerous) AS n, count(*) AS all_of_them FROM answers");
    assert_eq!(counted[0]["n"].as_deref(), Some("0"));
    let ended = run(&home, &[]).status(0);
    ended.says(&["runs, ", "render", "corpus", "completions"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_runs_here_is_listed_with_key_and_price() {
    let home = Home::new();
    let list = json!({"object": "list", "data": [
        {"id": "tiny-2", "object": "model"}, {"id": "nomic-embed-text", "object": "model"},
    ]});
    let list = || Script::json(200, &list.to_string());
    let server = Server::start(vec![list(), list(), list(), list()]).await;
    let url = server.base_url();
    let lab = format!("[provider.lab]\nbase_url = \"{url}\"\nkey_env = \"LAB_NOKEY\"\n{PRICES}");
    let other = format!("[provider.other]\nbase_url = \"{url}\"\ndialect = \"anthropic\"\n");
    configure(&home, &format!("{lab}{other}"));
    let table = run(&home, &["models"]).status(0).stdout;
    let row = table
        .lines()
        .find(|l| l.starts_with("lab/tiny-2"))
        .unwrap_or_else(|| panic!("{table}"));
    for words in ["missing: LAB_NOKEY", "100, 1000", "running here"] {
        assert!(row.contains(words), "{words}: {row}");
    }
    assert!(
        !table.contains("embed") && !table.contains("other/tiny"),
        "{table}"
    );
    let all = run(&home, &["models", "--all", "--format=json"])
        .status(0)
        .stdout;
    let rows = all.lines().map(|line| serde_json::from_str(line).unwrap());
    let rows: Vec<serde_json::Value> = rows.collect();
    let embed = rows
        .iter()
        .find(|r| r["model"] == "lab/nomic-embed-text")
        .unwrap_or_else(|| panic!("{all}"));
    assert_eq!(
        embed["key"],
        json!({"state": "missing", "source": "LAB_NOKEY"})
    );
    assert_eq!(embed["running"], true);
}

#[test]
fn a_run_of_the_built_in_judge_says_what_it_looked_at() {
    let home = Home::new();
    let shown = |task: &str, id: &str| {
        home.run(&["ask", CUT_IN, "--task", task]).status(0);
        home.run(&["runs", "show", id]).status(0).stdout
    };
    let collision = shown("collision", "1");
    let said = "asked with    exact geometry\nsteps         all recorded steps\n";
    assert!(collision.contains(said), "{collision}");
    let safety = shown("safety", "2");
    let how = "asked with    exact geometry\nsteps         ";
    assert!(safety.contains(how) && safety.contains(" to "), "{safety}");
    assert!(!safety.contains("all recorded"), "{safety}");
}

/// An answer in two tokens, the second of which decides with 0.9 against 0.1.
fn weighed() -> Script {
    let logs = |tokens: &[(&str, f64)]| -> Vec<serde_json::Value> {
        let one = |(token, p): &(&str, f64)| json!({"token": token, "logprob": f64::ln(*p)});
        tokens.iter().map(one).collect()
    };
    let piece = |text: &str, p: f64, top: &[(&str, f64)]| {
        let token = json!({"token": text, "logprob": f64::ln(p), "top_logprobs": logs(top)});
        format!(
            "data: {}\n\n",
            json!({"model": "tiny-2026", "choices": [{"index": 0, "delta": {"content": text},
                "logprobs": {"content": [token]}}]})
        )
    };
    let start = r#"{"justification": "j", "obstacles": [], "critical_obstacles": [], "probability": 0.6, "collision": "#;
    let end =
        json!({"choices": [{"index": 0, "delta": {"content": "}"}, "finish_reason": "stop"}]});
    Script::events()
        .send(piece(start, 1.0, &[]))
        .send(piece("true", 0.9, &[("true", 0.9), ("false", 0.1)]))
        .send(format!("data: {end}\n\ndata: [DONE]\n\n"))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn log_probabilities_are_kept_with_the_verdict_and_counted_in_reports() {
    let home = Home::new();
    let server = Server::start(vec![weighed()]).await;
    let url = server.base_url();
    configure(
        &home,
        &format!("log_probabilities = true\n[provider.lab]\nbase_url = \"{url}\"\n"),
    );
    let near = |value: &serde_json::Value| (value.as_f64().unwrap() - 0.9).abs() < 1e-9;
    let document = run(
        &home,
        &["ask", CUT_IN, "--model", "lab/tiny", "--format=json"],
    )
    .status(0)
    .json();
    let verdict = &document["verdict"];
    assert_eq!(verdict["probability"], 0.6);
    assert!(near(&verdict["token_probability"]), "{verdict}");
    let sent = server.requests().remove(0).json();
    assert_eq!(
        (&sent["logprobs"], &sent["top_logprobs"]),
        (&json!(true), &json!(5))
    );
    let shown = run(&home, &["runs", "show", "1", "--format=json"])
        .status(0)
        .json();
    assert!(near(&shown["verdict"]["token_probability"]), "{shown}");
    let report = run(&home, &["report", "--reread", "--format", "json"])
        .status(0)
        .json();
    let cell = &report["cells"].as_array().unwrap().last().unwrap();
    assert_eq!(cell["token_calibration"]["n"], 1, "{cell}");
    assert_eq!(cell["calibration"]["from_stated"], 1);
    let again = run(&home, &["ask", CUT_IN, "--model", "lab/tiny"]).status(0);
    assert!(
        again.stdout.contains("by tokens     0.90"),
        "{}",
        again.stdout
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_effort_that_the_model_does_not_take_is_refused_with_those_it_takes() {
    let home = Home::new();
    let ask = ["ask", CUT_IN, "--model", "deepseek/deepseek-flash"];
    let ended = run(&home, &[&ask[..], &["--set=effort=medium"]].concat()).status(2);
    ended.says(&[
        "nothing was sent",
        "deepseek-flash does not take effort medium; it takes off, low, high or max",
    ]);
    assert_eq!(home.runs().len(), 0);
}
