//! What is refused or warned of before anything is sent, what the store answers all the same, and what `ask --format json`
//! always says.

use serde_json::{Value, json};

use super::CUT_IN;
use super::remote::{KEY, streamed};
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

fn verdict() -> Script {
    streamed(&json!({"collision": true, "obstacles": [], "justification": "j"}).to_string())
}

fn configure(home: &Home, entry: &str) {
    let config = format!("[provider.lab]\n{entry}\n");
    home.write(home.config().join("config.toml"), config);
}

fn ask(home: &Home, more: &[&str], variables: &[(&str, &str)]) -> Ended {
    let arguments = [&["ask", CUT_IN, "--model", "lab/tiny"], more].concat();
    tokio::task::block_in_place(|| home.run_with(&arguments, variables))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_in_the_store_needs_neither_key_nor_budget() {
    let home = Home::new();
    let server = Server::start(vec![verdict()]).await;
    let entry = format!("base_url = \"{}\"\n", server.base_url());
    configure(&home, &format!("{entry}key_env = \"LAB_NOKEY\""));
    ask(&home, &[], &[("LAB_NOKEY", KEY)]).status(0);
    let stored = |more: &[&str]| {
        let document = ask(&home, &[&["--format=json"], more].concat(), &[])
            .status(0)
            .json();
        assert_eq!(document["stored"]["run"], 1, "{document}");
    };
    stored(&[]);
    stored(&["--budget", "0.01"]);
    stored(&["--base-url", server.base_url(), "--set=key_env=LAB_OTHER"]);
    configure(&home, &format!("{entry}key_command = \"false\""));
    stored(&[]);
    let fresh = ["--fresh"];
    ask(&home, &fresh, &[]).status(2).says(&["`false`"]);
    assert_eq!((server.requests().len(), home.runs().len()), (1, 1));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_refused_is_no_run() {
    let home = Home::new();
    let server = Server::start(vec![verdict()]).await;
    let here = format!("base_url = \"{}\"\n", server.base_url());
    let price = "[[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 100\noutput = 1000\n";
    let budget = ["--budget", "0.01", "--set=max_tokens=100"];
    let cases: [(String, &[&str], &str); 6] = [
        ("base_url = \"ftp://x\"".into(), &[], "`ftp:`"),
        (
            format!("{here}key_env = \"LAB_NOKEY\""),
            &[],
            "set LAB_NOKEY",
        ),
        (
            format!("{here}key_command = \"exit 3; geheim\""),
            &[],
            "`exit` failed",
        ),
        (format!("{here}{price}"), &budget, "raise the budget"),
        (
            format!("{here}key_command = \"echo key\""),
            &budget,
            "none is known for tiny",
        ),
        (
            format!("{here}tokens_per_minute = 20"),
            &[],
            "tokens_per_minute is 20",
        ),
    ];
    for (entry, more, words) in cases {
        configure(&home, &entry);
        let ended = ask(&home, more, &[])
            .status(2)
            .says(&["nothing was sent", words]);
        assert!(!ended.stderr.contains("geheim"), "{}", ended.stderr);
        let again = ask(&home, &[&["--no-store"], more].concat(), &[]);
        again.status(2).says(&[words]);
    }
    assert!(home.runs().is_empty() && server.requests().is_empty());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_key_that_the_configuration_names_is_listed_as_missing() {
    let home = Home::new();
    configure(
        &home,
        "base_url = \"http://127.0.0.1:9\"\nkey_env = \"LAB_NOKEY\"\nmodels = [\"tiny\"]",
    );
    let table = tokio::task::block_in_place(|| home.run(&["models", "--offline"]).status(0));
    let line = table.stdout.lines().find(|line| line.contains("lab/tiny"));
    assert!(
        line.is_some_and(|l| l.contains("missing: LAB_NOKEY")),
        "{line:?}"
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_document_tells_run_usage_and_cost_in_any_case() {
    let home = Home::new();
    let server = Server::start(vec![
        verdict(),
        streamed("{'collision': false}"),
        streamed("I do not know."),
        Script::json(400, r#"{"error":{"message":"no"}}"#),
    ])
    .await;
    // Prices of another model: the provider is not free, though it is on this machine.
    let entry = format!(
        "base_url = \"{}\"\n[[provider.lab.prices]]\nmodel = \"other\"\ninput = 1.0\noutput = 1.0\n",
        server.base_url()
    );
    configure(&home, &entry);
    let asked = |status: i32| {
        ask(&home, &["--format=json", "--fresh"], &[])
            .status(status)
            .json()
    };
    let tokens = |document: &Value| {
        (
            document["input_tokens"].as_u64(),
            document["output_tokens"].as_u64(),
        )
    };
    let whole = asked(0);
    assert_eq!(
        (&whole["run"], &whole["reading"]),
        (&json!(1), &json!("strict"))
    );
    assert_eq!(whole["repaired"], json!([]));
    assert_eq!(tokens(&whole), (Some(9200), Some(34)));
    let unknown = json!("no price for tiny-2026");
    assert_eq!(whole["cost_unknown"], unknown);
    let repaired = asked(0);
    assert_eq!(
        (&repaired["run"], &repaired["reading"]),
        (&json!(2), &json!("repaired"))
    );
    assert!(
        repaired["repaired"]
            .as_array()
            .is_some_and(|notes| !notes.is_empty())
    );
    let none = asked(1);
    assert_eq!((&none["run"], &none["reading"]), (&json!(3), &Value::Null));
    assert_eq!(
        (tokens(&none), &none["cost_unknown"]),
        ((Some(9200), Some(34)), &unknown)
    );
    let failed = asked(1);
    assert_eq!((&failed["run"], tokens(&failed)), (&json!(4), (None, None)));
    let why = failed["cost_unknown"].as_str();
    assert!(why.is_some_and(|why| why.contains("no token counts")));
}

#[test]
fn an_export_says_which_endings_it_knows() {
    let home = Home::new();
    home.run(&["ask", CUT_IN]).status(0);
    for name in ["e.xlsx", "e"] {
        home.run(&["runs", "export", "-o", name])
            .status(2)
            .says(&[name, ".jsonl", ".csv", ".parquet", "--format"]);
        assert!(!home.files().join(name).exists());
    }
    home.run(&["runs", "export", "-o", "e.xlsx", "--format", "csv"])
        .status(0);
    let csv = std::fs::read_to_string(home.files().join("e.xlsx")).unwrap();
    assert!(csv.starts_with("run,"), "{csv}");
    let lines = home.run(&["runs", "export", "-o", "-"]).status(0).stdout;
    assert!(lines.starts_with('{') && !home.files().join("-").exists());
    let piped = home.bytes(&["runs", "export", "-o", "-", "--format", "parquet"]);
    assert!(piped.starts_with(b"PAR1"));
    home.write("e.parquet", "PAR1");
    home.run(&["runs", "import", "e.parquet"])
        .status(2)
        .says(&["e.parquet: only JSONL can be imported"]);
}

#[test]
fn only_the_template_in_use_stops() {
    let home = Home::new();
    for name in ["collision-ego.md", "trajectory.md", "_risk.md"] {
        home.write(home.config().join("prompts").join(name), "{% if %}");
    }
    let all = home.run(&["prompt", "list"]).status(1).stderr;
    assert!(
        all.contains("trajectory.md") && all.contains("_risk.md"),
        "{all}"
    );
    // What it includes, then itself.
    for name in ["_risk.md", "collision-ego.md"] {
        let stopped = home.run(&["prompt", "show", CUT_IN]).status(2).stderr;
        assert!(stopped.contains(name), "{stopped}");
        assert!(!stopped.contains("trajectory.md"), "{stopped}");
        std::fs::remove_file(home.config().join("prompts").join(name)).unwrap();
    }
    home.run(&["prompt", "show", CUT_IN]).status(0);
}
