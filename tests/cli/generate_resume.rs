//! `generate` in bulk: what an earlier run has made is taken over, and what an interrupt or a closed pipe leaves.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::generate::says;
use super::plan::{NO_PROBLEM, lines};
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};
use super::{CUT_IN, bundled_xml};

/// Very few motions and plans: what is made need not be good.
const FEW: [&str; 3] = ["--candidates", "6", "--set=replan=10"];

fn report(home: &Home, name: &str) -> Value {
    let bytes = std::fs::read(home.files().join(name)).unwrap();
    serde_json::from_slice(&bytes).unwrap()
}

/// Names of files in a folder with this ending.
fn named(home: &Home, folder: &str, ending: &str) -> BTreeSet<String> {
    let all = std::fs::read_dir(home.files().join(folder)).unwrap();
    let names = all.map(|e| e.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(ending)).collect()
}

#[test]
fn what_an_earlier_run_has_made_is_taken_over_and_not_attacked() {
    let home = Home::new();
    let xml = bundled_xml(CUT_IN);
    home.write("all/first.xml", &xml);
    let told = [
        &["generate", "all", "-o", "all", "--format=json"][..],
        &FEW[..],
    ]
    .concat();
    let with = |more: &[&str]| home.run(&[&told[..], more].concat());
    let ended = with(&["--report", "r.json"]);
    let before = ended.json();
    assert_eq!(before["taken_over"], false);
    assert_eq!(before["scenario"], "first");
    assert!(before["drive"].is_string() && before["safe_before"].is_boolean());
    for refused in before["rejected"].as_array().unwrap() {
        assert!(refused["attacker"].is_i64() && refused["manoeuvre"].is_string());
    }
    let counted = |line: &Value| {
        let counts = line["refused"].as_object().unwrap().values();
        counts.map(|n| n.as_u64().unwrap()).sum::<u64>()
    };
    let rejected = before["rejected"].as_array().unwrap().len() as u64;
    assert!(rejected > 0 && counted(&before) == rejected);
    let figures = report(&home, "r.json");
    // The second time there is more in the folder: what cannot be driven, papers that are none, and the variant itself.
    home.write("all/without.xml", NO_PROBLEM);
    home.write("all/notes.json", "[]");
    let twice = with(&["--report", "r.json"]).status(2);
    twice.says(&["r.json", "--resume"]);
    let ended = with(&["--report", "r.json", "--resume"]).says(&[
        "1 variant of earlier runs is skipped",
        "notes.json: not reused",
        "planning problem",
    ]);
    let after = lines(&ended);
    assert_eq!(after.len(), 2);
    let mut again = after[0].clone();
    assert_eq!(again["taken_over"], true);
    again["taken_over"] = false.into();
    assert_eq!(again, before);
    assert_eq!(named(&home, "all", "_trajectory.csv").len(), 1);
    let together = report(&home, "r.json");
    assert_eq!(together["taken_over"], 1);
    assert_eq!(together["scenarios"], 2);
    for same in ["driven", "refused", "manoeuvres", "drives", "candidates"] {
        assert_eq!(together[same], figures[same], "{same}");
    }
    // Another seed may make another variant.
    std::fs::remove_file(home.files().join("all/notes.json")).unwrap();
    let one = ["generate", "all/first.xml", "-o", "all", "--format=json"];
    let other = [&one[..], &FEW[..], &["--resume", "--seed", "2"]].concat();
    let other = home.run(&other).json();
    assert_eq!(other["taken_over"], false);
    assert_ne!(other["id"], before["id"]);
    // A variant that was changed by hand does not count as made here.
    let variant = home.files().join(before["variant"].as_str().unwrap());
    let mut changed = std::fs::read_to_string(&variant).unwrap();
    changed.push('\n');
    std::fs::write(&variant, changed).unwrap();
    let ended = home
        .run(&[&one[..], &FEW[..], &["--resume"]].concat())
        .says(&["changed after generation"]);
    assert_eq!(ended.json()["taken_over"], false);
}

#[test]
fn resume_needs_a_folder_and_replaces_nothing_but_reports() {
    let home = Home::new();
    let resume = ["generate", CUT_IN, "--resume"];
    home.run(&resume).status(2).says(&["--output"]);
    home.write("mine.json", "{\"mine\": 1}");
    let over = [&resume[..], &["-o", "out", "--report", "mine.json"]].concat();
    let said = ["mine.json", "is not a report", "name another file"];
    home.run(&over).status(2).says(&said);
    home.write("file", "");
    let folder = home.run(&["generate", CUT_IN, "-o", "file"]);
    folder.status(2).says(&["-o", "not a folder"]);
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_and_tells_what_is_finished() {
    let home = Home::new();
    let xml = bundled_xml(CUT_IN);
    for i in 0..40 {
        home.write(format!("all/s{i:02}.xml"), &xml);
    }
    let told = [
        "generate",
        "all",
        "-o",
        "out",
        "--format=json",
        "--report",
        "r.json",
    ];
    let child = home.start(&[&told[..], &FEW[..]].concat());
    let begun = Instant::now();
    let made = || home.files().join("out").is_dir() && !named(&home, "out", ".json").is_empty();
    while !made() {
        assert!(
            begun.elapsed() < Duration::from_secs(120),
            "nothing is made"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
    super::long_jobs::interrupt(&child);
    let ended = Ended::of(&child.wait_with_output().unwrap())
        .status(130)
        .says(&["interrupted after", "of 40", "--resume"]);
    let told = lines(&ended);
    let ids = told.iter().map(|line| line["id"].as_str().unwrap());
    let ids: BTreeSet<String> = ids.map(|id| format!("{id}.json")).collect();
    assert_eq!(ids, named(&home, "out", ".json"));
    assert!(!ids.is_empty() && ids.len() < 40);
    let report = report(&home, "r.json");
    assert_eq!(report["interrupted"], true);
    assert_eq!(report["scenarios"], ids.len());
}

/// Asks a model at `url` for one motion of an obstacle.
const ASKED: [&str; 12] = [
    "generate",
    CUT_IN,
    "--model",
    "local/any",
    "--attacker",
    "301",
    "--set=samples=1",
    "--set=retries=0",
    "--set=grades=off",
    "--format=json",
    "-o",
    "out",
];

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_model_wrote_is_taken_over_too() {
    let home = Home::new();
    // What the search found passes the gate also where a model says it. Answers have no negative gaps, which the search
    // uses with most seeds.
    let search = [
        "generate",
        CUT_IN,
        "--attacker",
        "301",
        "--seed",
        "5",
        "--format=json",
    ];
    let searched = tokio::task::block_in_place(|| home.run(&[&search[..], &FEW[..]].concat()));
    let answer = json!({
        "obstacle": 301, "waypoints": null, "justification": "It is near.",
        "manoeuvre": searched.json()["asked"]["manoeuvre"],
    });
    let server = Server::start(says(&answer.to_string(), 1)).await;
    let url = server.base_url().to_owned();
    let told = [&ASKED[..], &["--set=replan=10", "--base-url", &url]].concat();
    let run = |more: &[&str]| {
        let told = [&told[..], more].concat();
        tokio::task::block_in_place(|| home.run(&told)).json()
    };
    let before = run(&[]);
    assert!(before["variant"].is_string(), "{before}");
    assert_eq!(before["model"]["requests"], 1);
    let again = run(&["--resume"]);
    assert_eq!(again["taken_over"], true);
    assert_eq!(again["model"], before["model"]);
    // Another way of asking is another matter, though what was paid for stays.
    let other = run(&["--resume", "--set=feedback=off"]);
    assert_eq!(other["taken_over"], false);
    assert_eq!(other["model"]["from_store"], 1);
    // What is not graded cannot be ranked by grades.
    let told = [&told[..], &["--set=rank=model"]].concat();
    let refused = tokio::task::block_in_place(|| home.run(&told));
    refused.status(2).says(&["rank=model", "grades=off"]);
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_interrupt_does_not_wait_for_a_model() {
    let home = Home::new();
    let server = Server::start(vec![Script::chunked_events().await_close()]).await;
    let told = [&ASKED[..], &["--base-url", server.base_url()]].concat();
    let child = home.start(&told);
    let begun = Instant::now();
    while home.runs().is_empty() {
        assert!(
            begun.elapsed() < Duration::from_secs(120),
            "nothing is asked"
        );
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    super::long_jobs::interrupt(&child);
    let told = Instant::now();
    let ended = tokio::task::block_in_place(|| child.wait_with_output()).unwrap();
    assert!(told.elapsed() < Duration::from_secs(20));
    let ended = Ended::of(&ended).status(130);
    assert_eq!(ended.stdout, "");
    ended.says(&["interrupted after 0 of 1", "--resume"]);
}

#[test]
fn nothing_is_made_for_nobody() {
    let home = Home::new();
    for i in 0..40 {
        home.write(format!("all/s{i:02}.xml"), NO_PROBLEM);
    }
    let told = |more: &[&str]| {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = home.command();
        command
            .args(["generate", "all", "--format=json"])
            .args(more);
        let ended = command.stdout(writer).output().unwrap();
        let ended = Ended::of(&ended);
        ended.stderr.matches("no planning problem").count()
    };
    assert_eq!(told(&[]), 1);
    // Files are read by others.
    assert_eq!(told(&["--report", "r.json"]), 40);
    assert_eq!(report(&home, "r.json")["scenarios"], 40);
}
