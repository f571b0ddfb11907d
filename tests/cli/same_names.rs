//! Files of one name: tables tell them apart by file and hash, standard error says so, and pinned hashes are of each.

use serde_json::Value;

use super::support::program::Home;
use super::{CUT_IN, bundled_ego, bundled_xml};

/// Two folders with a scenario of the same name each, of other contents.
fn twins(home: &Home) {
    for (folder, from) in [("one", CUT_IN), ("two", "ZAM_Merge-1_1_T-1")] {
        home.write(format!("{folder}/twin.xml"), bundled_xml(from));
        home.write(
            format!("{folder}/twin.ego_trajectory.csv"),
            bundled_ego(from),
        );
    }
}

const SAID: &str = "one/twin.xml and two/twin.xml have the same name, twin";

fn lines(text: &str) -> Vec<Value> {
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    lines.collect()
}

#[test]
fn measures_have_the_file_its_hash_and_the_ego() {
    let home = Home::new();
    twins(&home);
    for convention in [
        &["--convention", "exact"][..],
        &["--convention", "paper"],
        &["--scene"],
    ] {
        let run = home.run(&[&["metrics", "one", "two", "--format=json"], convention].concat());
        let rows = lines(&run.status(0).says(&[SAID]).stdout);
        let mut files: Vec<String> = Vec::new();
        for row in &rows {
            let key = format!("{} {} {}", row["file"], row["hash"], row["ego"]);
            assert_eq!(row["scenario"], "twin");
            if files.last() != Some(&key) {
                files.push(key);
            }
        }
        let [one, two] = files.as_slice() else {
            panic!("{files:?}");
        };
        assert!(one.starts_with("\"one/twin.xml\"") && two.starts_with("\"two/twin.xml\""));
        let hash = |key: &str| key.split(' ').nth(1).unwrap().to_string();
        assert_ne!(hash(one), hash(two));
        assert_eq!(hash(one).len(), 14, "12 digits, quoted");
    }
    // Two egos of one file are told apart, too.
    let ego = |id: &str| {
        let rows = home
            .run(&["metrics", CUT_IN, "--ego", id, "--format=json"])
            .status(0)
            .stdout;
        lines(&rows)[0]["ego"].as_str().unwrap().to_string()
    };
    assert_eq!(ego("301"), "obstacle 301 taken as ego");
    assert_eq!(ego("304"), "obstacle 304 taken as ego");
}

#[test]
fn printed_tables_have_the_file_where_the_name_is_not_enough() {
    let home = Home::new();
    twins(&home);
    let said = home
        .run(&["inspect", "one", "two/twin.xml", CUT_IN])
        .status(0)
        .says(&[SAID]);
    for label in ["one/twin.xml ", "two/twin.xml ", CUT_IN] {
        assert!(said.stdout.contains(label), "{}", said.stdout);
    }
    let rows = lines(
        &home
            .run(&["inspect", "one", "two", "--format=json"])
            .status(0)
            .stdout,
    );
    assert_ne!(rows[0]["hash"], rows[1]["hash"]);
    let driven = home.run(&["plan", "one", "two"]).says(&[SAID]).stdout;
    for label in ["one/twin.xml ", "two/twin.xml "] {
        assert!(driven.contains(label), "{driven}");
    }
    let alone = home.run(&["inspect", "one", CUT_IN]).status(0);
    assert!(!alone.stdout.contains("one/twin.xml") && !alone.stderr.contains("same name"));
}

#[test]
fn an_experiment_pins_each_of_them() {
    let home = Home::new();
    twins(&home);
    let ask = [
        "evaluate",
        "one",
        "two",
        "--model",
        "reference/geometry",
        "--task",
        "collision,safety",
        "--write-experiment",
        "e.toml",
    ];
    home.run(&ask).status(0);
    let text = std::fs::read_to_string(home.files().join("e.toml")).unwrap();
    assert!(
        text.contains("\"one/twin\" = ") && text.contains("\"two/twin\" = "),
        "{text}"
    );
    let run = || home.run(&["evaluate", "e.toml", "--dry-run"]);
    run().status(0);
    // Exchanged, each still has contents that one of them was written with.
    let (one, two) = (
        home.files().join("one/twin.xml"),
        home.files().join("two/twin.xml"),
    );
    let both = [std::fs::read(&one).unwrap(), std::fs::read(&two).unwrap()];
    std::fs::write(&one, &both[1]).unwrap();
    std::fs::write(&two, &both[0]).unwrap();
    run().status(2).says(&["one/twin.xml has the hash"]);
}

#[test]
fn several_scenarios_are_described_one_below_the_other() {
    let home = Home::new();
    let both = home
        .run(&["prompt", "describe", CUT_IN, "ZAM_Merge-1_1_T-1"])
        .status(0)
        .stdout;
    assert!(
        both.starts_with(&format!("# {CUT_IN} (bundled)\n")),
        "{both}"
    );
    assert!(both.contains("\n# ZAM_Merge-1_1_T-1 (bundled)\nTimes are relative"));
    let each = home
        .run(&[
            "prompt",
            "describe",
            CUT_IN,
            "ZAM_Merge-1_1_T-1",
            "--format=json",
        ])
        .status(0)
        .stdout;
    assert_eq!(lines(&each).len(), 2);
    home.run(&["prompt", "describe", CUT_IN, "nowhere.xml"])
        .status(1)
        .says(&["nowhere.xml", "1 of 2 scenarios could not be described"]);
    home.run(&[
        "prompt",
        "describe",
        CUT_IN,
        "ZAM_Merge-1_1_T-1",
        "-o",
        "a.txt",
    ])
    .status(2)
    .says(&["-o takes the description of one scenario"]);
}

#[test]
fn a_template_with_a_name_of_its_own_is_compared_with_the_one_it_was_copied_from() {
    let home = Home::new();
    home.run(&["prompt", "copy", "safety-ego", "--as", "mine"])
        .status(0);
    let diff = home.run(&["prompt", "diff", "mine"]).status(0).stdout;
    assert!(diff.starts_with("--- shipped/safety-ego.md\n"), "{diff}");
    assert!(
        diff.contains("\n-name = \"safety-ego\"\n+name = \"mine\"\n"),
        "{diff}"
    );
}

#[test]
fn a_word_that_is_no_file_may_have_been_meant_as_a_command() {
    let home = Home::new();
    home.run(&["frobnicate"])
        .status(2)
        .says(&["frobnicate: no such file, command or bundled scenario"]);
}

#[test]
fn the_ego_that_is_read_has_its_states() {
    let home = Home::new();
    let text = home
        .run(&["inspect", CUT_IN, "--format=json"])
        .status(0)
        .stdout;
    let document: Value = serde_json::from_str(&text).unwrap();
    let ego = &document["ego"];
    let states = ego["states"].as_array().unwrap();
    assert_eq!(states[0]["time_step"], ego["steps"][0]);
    assert_eq!(states[states.len() - 1]["time_step"], ego["steps"][1]);
    assert!(
        states
            .iter()
            .all(|state| state["x"].is_f64() && state["velocity"].is_number())
    );
}
