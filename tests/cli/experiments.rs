//! Experiment files: written from flags, run, gone on with, and refused where they are wrong.

use super::support::program::{Home, untimed};

const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";
const RED_LIGHT: &str = "ZAM_RedLight-1_1_T-1";

/// An experiment that needs no server.
const FLAGS: [&str; 9] = [
    "evaluate",
    CUT_IN,
    RED_LIGHT,
    "--model",
    "reference/geometry",
    "--set",
    "leads=0.5,1",
    "--samples",
    "2",
];

fn nothing_is_stored(home: &Home) {
    let list = home.run(&["evaluate", "list"]).status(0);
    assert!(!list.stdout.contains("b1"), "{}", list.stdout);
}

#[test]
fn flags_and_their_file_give_the_same_table_and_a_second_run_goes_on() {
    let home = Home::new();
    let write = [&FLAGS[..], &["--write-experiment", "e.toml"]].concat();
    home.run(&write).status(0).says(&["e.toml"]);
    let text = std::fs::read_to_string(home.files().join("e.toml")).unwrap();
    for line in [
        "scenarios = [\"ZAM_CutIn-1_1_T-1\", \"ZAM_RedLight-1_1_T-1\"]",
        "models = [\"reference/geometry\"]",
        "leads = [0.5, 1.0]",
        "within = 2.0",
        "samples = 2",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    // Nothing was asked.
    nothing_is_stored(&home);
    let flagged = home
        .run(&[&FLAGS[..], &["--format=json"]].concat())
        .status(0)
        .stdout;
    let again = home
        .run(&["evaluate", "e.toml", "--format=json"])
        .status(0)
        .says(&["going on with b1"]);
    let table = |text: &str| untimed(serde_json::from_str(text).unwrap());
    assert_eq!(
        table(&again.stdout),
        table(&flagged),
        "the file asks what the flags asked"
    );
    // Another folder, another home, without the flags.
    let other = Home::new();
    other.write("e.toml", &text);
    let first = other
        .run(&["evaluate", "e.toml", "--format=json"])
        .status(0);
    assert_eq!(table(&first.stdout), table(&flagged));
    assert!(!first.stderr.contains("going on"), "{}", first.stderr);
    // A change of the file is another batch.
    other.write("e.toml", text.replace("[0.5, 1.0]", "[0.5]"));
    let changed = other.run(&["evaluate", "e.toml"]).status(0);
    assert!(!changed.stderr.contains("going on"), "{}", changed.stderr);
}

#[test]
fn a_title_heads_lists_and_reports_and_questions_are_listed_after_they_were_answered() {
    let home = Home::new();
    let title = "Does the judge see a cut-in?";
    home.write(
        "e.toml",
        format!(
            "title = \"{title}\"\nscenarios = [\"{CUT_IN}\"]\nmodels = [\"reference/geometry\"]\n"
        ),
    );
    let lines = |home: &Home| {
        let listed = home
            .run(&["evaluate", "e.toml", "--dry-run=questions"])
            .status(0);
        listed.stdout
    };
    let before = lines(&home);
    assert!(before.lines().count() > 0, "{before}");
    // A requirement needs answers.
    for looks in ["--dry-run", "--dry-run=questions", "--dry-run=leaks"] {
        let gate = ["evaluate", "e.toml", looks, "--junit", "junit.xml"];
        home.run(&gate).status(2).says(&["--junit"]);
    }
    home.run(&["evaluate", "e.toml"]).status(0);
    assert_eq!(lines(&home), before, "all are answered, and still listed");
    let report = home.run(&["report", "--batch", "last"]).status(0);
    assert!(report.stdout.starts_with(&format!("# {title}\n")));
    let list = home.run(&["evaluate", "list"]).status(0);
    assert!(list.stdout.contains(title), "{}", list.stdout);
    home.run(&[
        "runs",
        "export",
        "--format=bundle",
        "--batch",
        "b1",
        "-o",
        "b.nearmiss",
    ])
    .status(0);
    let other = Home::new();
    let bundle = home.files().join("b.nearmiss");
    other
        .run(&["runs", "import", bundle.to_str().unwrap()])
        .status(0);
    let there = other.run(&["report", "--batch", "last"]).status(0);
    assert!(there.stdout.starts_with(&format!("# {title}\n")));
}

#[test]
fn mistakes_are_told_with_line_and_key_and_nothing_is_asked() {
    let home = Home::new();
    home.write(
        "e.toml",
        "scenarios = [\"a.xml\"]\nmodels = [\"lab/a\"]\nsample = 3\nwithin = 11\n",
    );
    home.run(&["evaluate", "e.toml"]).status(2).says(&[
        "e.toml:3: unknown key `sample`; did you mean `samples`?",
        "e.toml:4: within = 11: expected a number above 0, at most 10",
    ]);
    home.write(
        "ok.toml",
        format!("scenarios = [\"{CUT_IN}\"]\nmodels = [\"reference/geometry\"]\n"),
    );
    home.run(&["evaluate", "ok.toml", "--samples", "0", "--set", "steps=3"])
        .status(2)
        .says(&[
            "--samples = 0: expected a whole number from 1 to 1000",
            "--set steps: unknown key `steps`",
        ]);
    let beside = home.run(&["evaluate", "ok.toml", CUT_IN]);
    beside
        .status(2)
        .says(&["names its scenarios; give it alone"]);
    home.run(&["evaluate", "ok.toml", "--retry-failed"])
        .status(2)
        .says(&["has not been run yet"]);
    home.run(&["evaluate", "none.toml"])
        .status(2)
        .says(&["none.toml"]);
    let pinned = "scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nmodels = [\"local/default\"]\ntemplates = [\"safety-ego.md@000000000000\"]\n";
    home.write("pinned.toml", pinned);
    home.run(&["evaluate", "pinned.toml"])
        .status(2)
        .says(&["safety-ego.md", "000000000000"]);
    nothing_is_stored(&home);
}

#[test]
fn the_topic_lists_every_key_and_the_schema_is_one() {
    let home = Home::new();
    let topic = home.run(&["help", "experiments"]).status(0);
    let schema = home
        .run(&["help", "experiments", "--schema", "experiment"])
        .status(0);
    let schema: serde_json::Value = serde_json::from_str(&schema.stdout).unwrap();
    assert!(jsonschema::meta::is_valid(&schema));
    for (key, property) in schema["properties"].as_object().unwrap() {
        assert!(topic.stdout.contains(&format!("\n    {key}")), "{key}");
        assert!(property["description"].is_string(), "{key}");
    }
    home.run(&["help", "experiments", "--schema", "run"])
        .status(2)
        .says(&["unknown schema `run`"]);
}

/// Stores of before have specifications with keys of their own: such a batch is found by its experiment and extended.
#[test]
fn a_batch_with_the_keys_of_before_is_gone_on_with() {
    let home = Home::new();
    home.write(
        "e.toml",
        format!("scenarios = [\"{CUT_IN}\"]\nmodels = [\"reference/geometry\"]\nhistory = 8\n"),
    );
    home.run(&["evaluate", "e.toml"]).status(0);
    let stored = || home.rows("SELECT spec FROM batches").remove(0)["spec"].clone();
    let now: serde_json::Value = serde_json::from_str(&stored().unwrap()).unwrap();
    let before = format!(
        r#"{{"paths":["{CUT_IN}"],"tasks":["safety"],"frames":["ego"],"techniques":["cp+cot+icl"],"models":["reference/geometry"],"samples":1,"history":8,"radius":null,"lead":"1","within":2.0,"temperature":null,"max_tokens":null,"effort":null,"truth":"geometry","truth_files":[],"templates":{},"thresholds":[],"base_url":null,"drawn_from":{}}}"#,
        now["templates"], now["drawn_from"]
    );
    home.rows(&format!("UPDATE batches SET spec = '{before}'"));
    assert_eq!(stored(), Some(before));
    home.run(&["evaluate", "e.toml"])
        .status(0)
        .says(&["going on with b1"]);
    home.run(&["evaluate", "b1", "--set", "leads=0.5"])
        .status(0);
    let list = home
        .run(&["evaluate", "list", "--format=json"])
        .status(0)
        .json();
    assert_eq!(list["leads"], serde_json::json!(["1", "0.5"]));
    home.run(&["evaluate", "b1", "--set", "history=9"])
        .status(2)
        .says(&["b1 keeps what it was begun with", "history"]);
}
