//! `check`: sentences about scenarios, one text or many, as text and JSON, with a trajectory and a prompt.

use serde_json::Value;

use super::batches::telling;
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";

#[test]
fn sentences_are_held_against_the_scene() {
    let home = Home::new();
    let measured = home.run(&["metrics", CUT_IN, "--format", "json"]);
    let rows = measured.status(0).stdout;
    let row = |line: &str| serde_json::from_str::<Value>(line).unwrap();
    let at_44 = { rows.lines().map(row) }
        .find(|row| row["step"] == 44 && row["obstacle"] == 301)
        .unwrap();
    let distance = at_44["distance"].as_f64().unwrap();
    home.write(
        "said.txt",
        format!(
            "## Obstacle 301\n\nIts distance is {distance:.2} m.\n- The distance is 99.0 m.\nWe wait.\n\
             It blinks while it is moving in a strange way.\n"
        ),
    );
    let run = ["check", CUT_IN, "--text", "said.txt", "--at", "44"];
    let told = home.run(&run).status(0).stdout;
    for part in [
        "right: Its distance is",
        "wrong: - The distance is 99.0 m.",
        "3 sentences",
        "right 1, wrong 1, open 0, not understood 1",
    ] {
        assert!(told.contains(part), "{part}\n{told}");
    }
    let json = home
        .run(&[&run[..], &["--format", "json"]].concat())
        .status(0);
    let found: Vec<Value> = json.stdout.lines().map(row).collect();
    let outcomes: Vec<&str> = { found.iter() }
        .map(|one| one["outcome"].as_str().unwrap())
        .collect();
    assert_eq!(outcomes, ["right", "wrong", "not_understood"]);
    let claim = &found[1]["claims"][0];
    assert_eq!(
        (&claim["obstacle"], &claim["step"], &claim["unit"]),
        (&301.into(), &44.into(), &"m".into())
    );
    assert!(
        (claim["actual"].as_f64().unwrap() - distance).abs() < 1e-3,
        "{claim}"
    );
    home.write("empty.txt", "We wait.\n");
    let told = home.run(&["check", CUT_IN, "--text", "empty.txt"]);
    assert!(
        told.status(0)
            .stdout
            .contains("no sentence says anything of")
    );
    home.run(&["check", CUT_IN, "--text", "nothing.txt"])
        .status(2)
        .says(&["nothing.txt"]);
    home.run(&["check", CUT_IN, "--text", "said.txt", "--at", "9999"])
        .status(2)
        .says(&["9999"]);
}

/// What a JSON lines output has under a key, a line each.
fn column(lines: &str, key: &str) -> Vec<Value> {
    { lines.lines() }
        .map(|line| serde_json::from_str::<Value>(line).unwrap()[key].clone())
        .collect()
}

#[test]
fn many_texts_make_a_table_by_model() {
    let home = Home::new();
    let lines = [
        r#"{"scenario": "ZAM_CutIn-1_1_T-1", "step": 44, "model": "a", "text": "Obstacle 301 is at a distance of 99 m."}"#,
        "",
        r#"{"scenario": "ZAM_CutIn-1_1_T-1", "time": 1.0, "text": "We have not collided with anything. Obstacle 301 approaches. Obstacle 301 moves away."}"#,
    ];
    home.write("texts.jsonl", lines.join("\n"));
    let table = home.run(&["check", "texts.jsonl"]).status(0).stdout;
    for part in [
        "Right share",
        "a: 1 sentence: right 0, wrong 1",
        "unnamed: 3 sentences",
        "2 contradict another one",
    ] {
        assert!(table.contains(part), "{part}\n{table}");
    }
    let json = home.run(&["check", "texts.jsonl", "--format", "json"]);
    let json = json.status(0).stdout;
    assert_eq!(column(&json, "line"), [1, 3, 3, 3]);
    assert_eq!(column(&json, "model")[0], "a");
    assert_eq!(column(&json, "model")[1], Value::Null);
    assert_eq!(column(&json, "contradicts")[1], Value::Array(Vec::new()));
    assert_ne!(column(&json, "contradicts")[2], Value::Array(Vec::new()));
}

#[test]
fn lines_that_are_no_texts_are_errors_with_their_number() {
    let home = Home::new();
    let good = r#"{"scenario": "ZAM_CutIn-1_1_T-1", "text": "It is safe."}"#;
    for (bad, why) in [
        ("{", "texts.jsonl:2: "),
        (r#"{"scenario": "ZAM_CutIn-1_1_T-1"}"#, "`text`"),
        (
            r#"{"scenario": "ZAM_CutIn-1_1_T-1", "text": "", "txt": ""}"#,
            "`txt`",
        ),
        (
            r#"{"scenario": "ZAM_CutIn-1_1_T-1", "text": "", "step": 3, "time": 1.0}"#,
            "time and step",
        ),
        (
            r#"{"scenario": "ZAM_CutIn-1_1_T-1", "text": "", "step": 9999}"#,
            "9999",
        ),
        (r#"{"scenario": "nowhere.xml", "text": ""}"#, "nowhere.xml"),
    ] {
        home.write("texts.jsonl", format!("{good}\n{bad}\n"));
        home.run(&["check", "texts.jsonl"])
            .status(2)
            .says(&["texts.jsonl:2: ", why]);
    }
    home.write("texts.jsonl", "\n");
    home.run(&["check", "texts.jsonl"])
        .status(2)
        .says(&["no line with a text"]);
    home.write("texts.jsonl", good);
    home.run(&["check", "texts.jsonl", "--at", "3"])
        .status(2)
        .says(&["--at", "lines"]);
}

#[test]
fn plans_are_held_against_the_trajectory_and_numbers_against_the_prompt() {
    let home = Home::new();
    home.write("standing.json", "[[0.5, 0, 0], [1, 0, 0], [2, 0, 0]]");
    home.write("driving.json", "[[0.5, 5, 0], [1, 10, 0], [2, 20, 0]]");
    home.write("said.txt", "I will accelerate.");
    let run = ["check", CUT_IN, "--text", "said.txt", "--at", "20"];
    let outcome = |more: &[&str]| {
        let run = home.run(&[&run[..], &["--format", "json"], more].concat());
        column(&run.status(0).stdout, "outcome")
    };
    assert_ne!(outcome(&[]), ["wrong"]);
    assert_eq!(outcome(&["--trajectory", "standing.json"]), ["wrong"]);
    home.write("said.txt", "I will stop.");
    assert_eq!(outcome(&["--trajectory", "driving.json"]), ["wrong"]);
    for (broken, why) in [
        ("[[0.5, 0]]", "[[t, x, y]"),
        ("[]", "without points"),
        ("[[0, 0, 0]]", "one point"),
        ("[[1, 0, 0], [0.5, 1, 0]]", "point 2"),
    ] {
        home.write("broken.json", broken);
        home.run(&[&run[..], &["--trajectory", "broken.json"]].concat())
            .status(2)
            .says(&["broken.json", why]);
    }
    home.write("said.txt", "The distance to obstacle 301 is 987 m.");
    home.write("prompt.txt", "Obstacle 301 has a distance of 12 m.");
    let told = home.run(&[&run[..], &["--prompt", "prompt.txt"]].concat());
    let told = told.status(0).stdout;
    assert!(told.contains("1 invented number"), "{told}");
}

#[test]
fn the_agreement_on_labelled_sentences_is_printed() {
    let home = Home::new();
    let told = home.run(&["check", "--labelled"]).status(0).stdout;
    assert!(told.contains("all"), "{told}");
    let json = home.run(&["check", "--labelled", "--format", "json"]);
    assert!(!column(&json.status(0).stdout, "found").contains(&Value::Null));
    home.run(&["check", CUT_IN]).status(2).says(&["--text"]);
}

/// Checks a German and an English sentence with a second reader at this address.
fn read_again(home: &Home, url: &str, more: &[&str]) -> Ended {
    let config = format!(
        "[provider.lab]\nbase_url = \"{url}\"\nkey_env = []\n\
         [[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 1\noutput = 10\n"
    );
    home.write(home.config().join("config.toml"), config);
    home.write(
        "said.txt",
        "Obstacle 301 is 99 m away.\nDas Auto 301 ist 98,5 Meter vor uns.\n",
    );
    let run = ["check", CUT_IN, "--text", "said.txt", "--model", "lab/tiny"];
    tokio::task::block_in_place(|| home.run(&[&run, more].concat()))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_model_translates_what_the_rules_do_not_understand() {
    let said =
        r#"{"sentences": [{"number": 1, "claims": ["Obstacle 301 is 98.5 m ahead of the ego."]}]}"#;
    let server = Server::answering(move |_, _| Some(telling(said))).await;
    let home = Home::new();
    let url = server.base_url();
    let estimate = read_again(&home, url, &["--dry-run"]).status(0).stdout;
    assert!(estimate.starts_with("1 sentence not understood; 1 question to lab/tiny, at most 0.0"));
    let dear = read_again(&home, url, &["--budget", "0.000001"])
        .status(1)
        .says(&["budget"]);
    assert!(dear.stdout.contains("not understood 1"), "{}", dear.stdout);
    assert!(server.requests().is_empty());
    let read = read_again(&home, url, &[])
        .status(0)
        .says(&["lab/tiny read 1 of 1 sentence"]);
    for part in [
        "wrong: Das Auto 301",
        "» Obstacle 301 is 98.5 m ahead of the ego.",
        "1 read by a model",
    ] {
        assert!(read.stdout.contains(part), "{part}\n{}", read.stdout);
    }
    // The model sees the sentence in its text, and the language; its answer is kept.
    let body = server.requests()[0].json();
    let told = body["messages"][0]["content"].as_str().unwrap();
    assert!(told.contains("The TTC of obstacle 7 is 2.4 s."), "{told}");
    let asked = body["messages"][1]["content"].as_str().unwrap();
    assert!(asked.contains("⟦1: Das Auto 301 ist"), "{asked}");
    let again = read_again(&home, url, &["--format=json"]).status(0);
    let found: Vec<Value> = { again.stdout.lines() }
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(server.requests().len(), 1);
    assert_eq!(found[0]["translated"], serde_json::json!([]));
    assert_eq!(found[1]["outcome"], "wrong");
    assert_eq!(
        found[1]["translated"][0],
        "Obstacle 301 is 98.5 m ahead of the ego."
    );
    home.run(&[
        "check",
        CUT_IN,
        "--text",
        "said.txt",
        "--model",
        "reference/geometry",
    ])
    .status(2)
    .says(&["not a language model"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_model_does_not_translate_stays_not_understood() {
    let server = Server::answering(|number, _| {
        Some(match number {
            0 => telling("They are all true."),
            _ => Script::json(400, "{\"error\": \"no\"}"),
        })
    })
    .await;
    let home = Home::new();
    // An answer of another form is not kept to.
    for why in ["no JSON object", "400"] {
        let ended = read_again(&home, server.base_url(), &[])
            .status(1)
            .says(&[why, "read 0 of 1"]);
        assert!(
            ended.stdout.contains("not understood 1"),
            "{}",
            ended.stdout
        );
    }
}
