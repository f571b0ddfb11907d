//! Drives of planners as egos: evaluated, described, exported, and beside the ideal driver who survives.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

use super::CUT_IN;
use super::support::program::{Ended, Home, skipped};

/// The planner of the manual as a command; nothing without Python.
fn minimal() -> Option<String> {
    let mut python = Command::new("python3");
    let there = python.arg("--version").stdout(Stdio::null()).status();
    if !there.is_ok_and(|status| status.success()) {
        skipped("no python3");
        return None;
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/planners/minimal.py");
    Some(format!("python3 '{}'", file.display()))
}

/// A stored batch about the egos of a planner, answered by the built-in judge.
fn evaluate(home: &Home, ego: &str) -> Ended {
    let asked = [
        "evaluate",
        CUT_IN,
        "--task",
        "safety",
        "--model",
        "reference/geometry",
        "--samples",
        "1",
        "--ego",
        ego,
    ];
    home.run(&asked)
}

fn batches(home: &Home) -> Vec<Value> {
    home.run(&["evaluate", "list", "--format=json"])
        .status(0)
        .json_lines()
}

#[test]
fn egos_of_the_built_in_planner_are_evaluated_and_resumed() {
    let home = Home::new();
    evaluate(&home, "planner")
        .status(0)
        .says(&["egos driven by nearmiss"]);
    let batch = batches(&home).remove(0);
    assert_eq!(batch["planner"]["planner"], "nearmiss");
    assert_eq!(batch["planner"]["settings"]["prediction"], "lane");
    let resumed = home.run(&["evaluate", "last"]);
    resumed.status(0).says(&["nothing to ask"]);
    // The same drives have the same hash; those of other settings have another one.
    let drives = |home: &Home| batches(home)[0]["planner"]["sha256"].clone();
    let first = drives(&home);
    evaluate(&home, "planner").status(0);
    assert_eq!(drives(&home), first);
    std::fs::create_dir_all(home.config()).unwrap();
    let config = home.config().join("config.toml");
    std::fs::write(
        config,
        "[planner]\nprediction = \"recorded\"\nhorizon = 2.0\n",
    )
    .unwrap();
    evaluate(&home, "planner").status(0);
    assert_ne!(drives(&home), first);
    assert_eq!(batches(&home).len(), 3);
    let refused = home.run(&["evaluate", "last", "--ego", "planner"]);
    refused.status(2);
}

#[test]
fn drives_that_are_gone_are_missed() {
    let home = Home::new();
    evaluate(&home, "planner").status(0);
    std::fs::remove_dir_all(home.data().join("drives")).unwrap();
    let more = ["evaluate", "last", "--set", "transforms=mirror"];
    let ended = home.run(&more);
    ended.says(&["1 cannot be asked", "not driven by nearmiss"]);
}

#[test]
fn a_planner_is_an_ego_wherever_one_is_named() {
    let home = Home::new();
    let described = |more: &[&str]| {
        let told = [
            "prompt",
            "describe",
            CUT_IN,
            "--frame",
            "cartesian",
            "--at",
            "20",
        ];
        home.run(&[&told[..], more].concat()).status(0).stdout
    };
    assert_ne!(described(&[]), described(&["--ego", "planner"]));
    let inspected = home.run(&["inspect", CUT_IN, "--ego", "planner"]);
    inspected.status(0).says(&[]);
    let measured = home
        .run(&["metrics", CUT_IN, "--ego", "planner"])
        .status(0)
        .stdout;
    assert_ne!(measured, home.run(&["metrics", CUT_IN]).status(0).stdout);
    let wrong = |ego: &str| {
        home.run(&["prompt", "describe", CUT_IN, "--ego", ego])
            .status(2)
    };
    wrong("planner:nearmis").says(&["no planner of this name", "did you mean `nearmiss`"]);
    wrong("planner:sh -c 'exit 3'").says(&["not driven", "exit status 3"]);
    let ids = home.run(&["evaluate", CUT_IN, "--ego", "7"]).status(2);
    ids.says(&["expected planner or planner:NAME"]);
}

#[test]
fn a_process_drives_the_egos_and_is_named_by_its_version() {
    let Some(planner) = minimal() else { return };
    let home = Home::new();
    let ego = format!("planner:{planner}");
    evaluate(&home, &ego)
        .status(0)
        .says(&["egos driven by minimal 1"]);
    let batch = batches(&home).remove(0);
    assert_eq!(batch["planner"]["said"], "minimal 1");
    assert_eq!(batch["planner"]["planner"], planner.as_str());
    // Nothing is left of the planner that resuming would need.
    home.run(&["evaluate", "last"]).status(0);
    let listed = home.run(&["evaluate", "list"]).status(0).stdout;
    assert!(listed.contains("egos driven by minimal 1"), "{listed}");
}

#[test]
fn drives_are_exported_as_tables() {
    let home = Home::new();
    let table = |name: &str, more: &[&str]| {
        let told = ["plan", CUT_IN, "--planner", "nearmiss", "--table", name];
        home.run(&[&told[..], more].concat()).status(0);
        std::fs::read(home.files().join(name)).unwrap()
    };
    let csv = String::from_utf8(table("drives.csv", &["--planner", "nearmiss"])).unwrap();
    let rows: Vec<&str> = csv.lines().collect();
    // Both, and the three baselines.
    assert_eq!(rows.len(), 6, "{csv}");
    assert!(
        rows[0].starts_with("scenario,file,hash,planner,outcome"),
        "{csv}"
    );
    for column in [
        "outcome",
        "collision_kind",
        "near_misses",
        "mean_jerk",
        "seconds_to_goal",
    ] {
        assert!(rows[0].contains(column), "{csv}");
    }
    assert!(rows[1].contains("goal"), "{csv}");
    let json = String::from_utf8(table("drives.jsonl", &[])).unwrap();
    let drive: Value = serde_json::from_str(json.lines().next().unwrap()).unwrap();
    assert_eq!(
        (&drive["planner"], &drive["outcome"]),
        (&"nearmiss".into(), &"goal".into())
    );
    assert!(drive["median_cycle_ms"].is_number(), "{drive}");
    assert_eq!(&table("drives.parquet", &[])[..4], b"PAR1");
    let unknown = home
        .run(&["plan", CUT_IN, "--table", "drives.xls"])
        .status(2);
    unknown.says(&["known are .csv, .json, .jsonl, .ndjson, .parquet and .arrow"]);
}

#[test]
fn the_good_driver_stands_beside_the_drive_in_a_variant() {
    let home = Home::new();
    let told = [
        "generate",
        CUT_IN,
        "--candidates",
        "40",
        "-o",
        "out",
        "--format=json",
    ];
    let ended = home.run(&told);
    let line = ended.json();
    let Some(variant) = line["variant"].as_str() else {
        panic!("no variant: {line}");
    };
    let good = &line["good_driver"];
    let longest = good["reaction_time"].as_f64();
    let avoidable = line["avoidable"].as_object().unwrap();
    let survived = avoidable.iter().filter(|(_, avoided)| **avoided == true);
    let last = survived
        .filter_map(|(s, _)| s.parse::<f64>().ok())
        .next_back();
    assert_eq!(longest, last, "{line}");
    let render =
        |more: &[&str]| home.run(&[&["render", variant, "--with-certificate"], more].concat());
    if last.is_none() {
        render(&["-o", "x.svg"])
            .status(2)
            .says(&["no ideal driver survives it"]);
        return;
    }
    render(&["--size", "120x160px", "--all", "-o", "film.gif"]).status(0);
    let gif = std::fs::read(home.files().join("film.gif")).unwrap();
    let frames = gif.windows(3).filter(|w| w == b"\x21\xf9\x04").count();
    assert!(frames > 20, "{frames} frames");
    render(&["-o", "both.svg"]).status(0);
    let svg = std::fs::read_to_string(home.files().join("both.svg")).unwrap();
    for words in [
        "nearmiss · gap",
        &format!("ideal driver, {:.1} s", last.unwrap()),
    ] {
        assert!(svg.contains(words), "{words}");
    }
    render(&["9", "-o", "x.svg"])
        .status(2)
        .says(&["expected one of 0.0, 0.5, 1.0, 1.5"]);
    let original = home.run(&["render", CUT_IN, "--with-certificate", "-o", "x.svg"]);
    original
        .status(2)
        .says(&["no manifest of `nearmiss generate`"]);
}

#[test]
fn attacks_are_not_searched_in_traffic_that_reacts() {
    let home = Home::new();
    let told = home
        .run(&["generate", CUT_IN, "--set=traffic=reactive"])
        .status(2);
    told.says(&["--set traffic=reactive is not for `generate`"]);
}

#[test]
fn a_drive_of_a_planner_is_converted_for_simulators() {
    let Some(command) = minimal() else { return };
    let home = Home::new();
    let planner = format!("planner:{command}");
    let written = |ego: &str, file: &str| {
        let asked = ["convert", CUT_IN, "-o", file, "--ego", ego];
        home.run(&asked).status(0);
        std::fs::read_to_string(home.files().join(file)).unwrap()
    };
    let (own, built_in) = (written(&planner, "own.xosc"), written("planner", "in.xosc"));
    assert_eq!(
        built_in,
        written("planned", "in2.xosc").replace("in2.xodr", "in.xodr")
    );
    assert_ne!(own.replace("own.xodr", "in.xodr"), built_in);
    // Where the drive leads is what a player is given.
    let metrics = |file: &str, ego: &[&str]| {
        let asked = [&["metrics", file, "--format", "csv"], ego].concat();
        home.run(&asked).status(0).measures()
    };
    assert_eq!(
        metrics("own.xosc", &[]),
        metrics(CUT_IN, &["--ego", &planner])
    );
}
