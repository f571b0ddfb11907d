//! `evaluate --resume` with more leads and changed scenes, and labels that do not fit the scenarios.

use serde_json::Value;

use super::batches::{home as home_with, telling};
use super::support::program::{Ended, Home};
use super::support::server::Server;
use super::{BUNDLED, CUT_IN};

const HARD_BRAKING: &str = "ZAM_HardBraking-1_1_T-1";

/// Says yes to the first question and no to all others.
async fn yes_first() -> Server {
    Server::answering(|number, request| {
        let key = match String::from_utf8_lossy(&request.body).contains("safety_critical") {
            true => "safety_critical",
            false => "collision",
        };
        let yes = number == 0;
        let text = format!(r#"{{"{key}": {yes}, "obstacles": [], "justification": "so"}}"#);
        Some(telling(&text))
    })
    .await
}

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

fn labels(home: &Home) -> String {
    let rows = BUNDLED.map(|(name, collides)| format!("{name},{}\n", u8::from(collides)));
    let text = format!("scenario,label\n{}", rows.concat());
    home.write("truth.csv", text).display().to_string()
}

fn begin(home: &Home, more: &[&str]) -> Ended {
    let truth = labels(home);
    let all = [
        &["evaluate", HARD_BRAKING, CUT_IN, "--truth", &truth],
        &["--model", "lab/tiny", "--frame", "cartesian"][..],
        &["--concurrency", "1", "--json"],
        more,
    ];
    run(home, &all.concat())
}

fn resume(home: &Home, more: &[&str]) -> Ended {
    let all = [&["evaluate", "--resume", "last", "--json"], more];
    run(home, &all.concat())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn leads_and_changes_that_are_added_come_to_the_same_as_when_they_are_there_from_the_beginning()
 {
    let whole = yes_first().await;
    let home = home_with(whole.base_url());
    let wanted = begin(&home, &["--lead", "0.5,1", "--transform", "mirror"]);
    let wanted = wanted.status(0).json();
    assert_eq!(whole.requests().len(), 5);

    let server = yes_first().await;
    let home = home_with(server.base_url());
    begin(&home, &["--lead", "0.5"]).status(0);
    let dry = resume(&home, &["--add-lead", "1", "--dry-run"]).status(0);
    assert_eq!(dry.json()["requests"], 1, "the collision at another lead");
    resume(&home, &["--add-transform", "mirror"]).status(0);
    assert_eq!(server.requests().len(), 4);
    let document = resume(&home, &["--add-lead", "1,0.5"]).status(0).json();
    assert_eq!(document, wanted);
    assert_eq!(server.requests().len(), 5, "nothing is asked twice");
    let again = resume(&home, &["--add-lead", "0.5,1", "--add-transform", "mirror"]);
    assert_eq!(again.status(0).json(), wanted);
    assert_eq!(server.requests().len(), 5);
    let list = run(&home, &["evaluate", "--list"]).status(0).stdout;
    for words in [
        "5 of 5 answered",
        "lead 0.5,1 · mirror",
        &format!("2 scenarios: {HARD_BRAKING}, {CUT_IN} · truth: labels of "),
        "truth.csv",
    ] {
        assert!(list.contains(words), "{words}: {list}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_lead_beside_windows_at_the_end_of_the_recordings_leaves_the_table_as_it_was() {
    let server = yes_first().await;
    let home = home_with(server.base_url());
    let plain = begin(&home, &[]).status(0).json();
    let more = resume(&home, &["--add-lead", "1"]).status(0).json();
    assert_eq!(server.requests().len(), 3);
    assert_eq!(more["cells"], plain["cells"]);
    let leads: Vec<_> = more["lead"].as_array().unwrap().iter().collect();
    assert_eq!(leads.len(), 1, "{leads:?}");
    assert_eq!(
        (&leads[0]["lead"], &leads[0]["n"]),
        (&1.0.into(), &1.into())
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_cannot_be_added_is_said() {
    let server = yes_first().await;
    let home = home_with(server.base_url());
    begin(&home, &["--task", "collision"]).status(0);
    resume(&home, &["--add-lead", "1"])
        .status(2)
        .says(&["--add-lead", "--task safety"]);
    begin(&home, &["--add-lead", "1"])
        .status(2)
        .says(&["need a batch: --resume ID"]);
    begin(&home, &["--add-transform", "mirror"])
        .status(2)
        .says(&["need a batch: --resume ID"]);
    let zero = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--concurrency",
        "0",
    ];
    run(&home, &zero).status(2).says(&[
        "--concurrency",
        "expected a whole number of requests, at least 1",
    ]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn labels_that_cannot_be_of_the_scenario_are_refused_with_their_line() {
    let server = yes_first().await;
    let home = home_with(server.base_url());
    let plain = begin(&home, &[]).status(0).json();
    let wrong = home.write(
        "wrong.csv",
        format!("scenario,obstacle_id\n{HARD_BRAKING},none\n{CUT_IN},4711\n"),
    );
    let wrong = wrong.display().to_string();
    let words = [
        "wrong.csv, line 3: ",
        CUT_IN,
        "has no obstacle 4711; it has 301",
    ];
    let models = ["--model", "lab/other"];
    let batch = ["evaluate", HARD_BRAKING, CUT_IN, "--truth", &wrong];
    run(&home, &[&batch[..], &models].concat())
        .status(2)
        .says(&words);
    run(&home, &batch).status(2).says(&words);
    resume(&home, &["--truth", &wrong]).status(2).says(&words);
    let after: Value = resume(&home, &[]).status(0).json();
    assert_eq!(after, plain, "its truth is as it was");
    assert_eq!(home.rows("SELECT id FROM batches").len(), 1);
    assert_eq!(server.requests().len(), 2);
    let truth = labels(&home);
    run(&home, &["evaluate", CUT_IN, "--truth", &truth])
        .status(0)
        .says(&["the truth speaks of 7 scenarios that are not among these, such as ZAM_"]);
    let word = home.write("word.csv", format!("scenario,label\n{CUT_IN},perhaps\n"));
    let word = word.display().to_string();
    run(&home, &["evaluate", CUT_IN, "--truth", &word])
        .status(2)
        .says(&["line 2: `perhaps` is no label: it is one of"]);
}
