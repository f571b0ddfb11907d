//! `evaluate BATCH` with more leads and changed scenes, and labels that do not fit the scenarios.

use serde_json::Value;

use super::batches::{home as home_with, telling};
use super::support::program::{Ended, Home, untimed};
use super::support::server::Server;
use super::{BUNDLED, CUT_IN};

const HARD_BRAKING: &str = "ZAM_HardBraking-1_1_T-1";

/// Says yes to the first question and no to all others.
async fn yes_first() -> Server {
    Server::answering(|number, request| {
        let key = if String::from_utf8_lossy(&request.body).contains("safety_critical") {
            "safety_critical"
        } else {
            "collision"
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
        &["--model", "lab/tiny", "--set", "frames=cartesian"][..],
        &["--set", "concurrency=1", "--format=json"],
        more,
    ];
    run(home, &all.concat())
}

fn resume(home: &Home, more: &[&str]) -> Ended {
    let all = [&["evaluate", "last", "--format=json"], more];
    run(home, &all.concat())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn leads_and_changes_that_are_added_come_to_the_same_as_when_they_are_there_from_the_beginning()
 {
    let whole = yes_first().await;
    let home = home_with(whole.base_url());
    let wanted = begin(
        &home,
        &["--set", "leads=0.5,1", "--set", "transforms=mirror"],
    )
    .status(0)
    .json();
    assert_eq!(whole.requests().len(), 5);

    let server = yes_first().await;
    let home = home_with(server.base_url());
    begin(&home, &["--set", "leads=0.5"]).status(0);
    let dry = resume(&home, &["--set", "leads=1", "--dry-run"]).status(0);
    assert_eq!(dry.json()["requests"], 1, "the collision at another lead");
    resume(&home, &["--set", "transforms=mirror"]).status(0);
    assert_eq!(server.requests().len(), 4);
    let document = resume(&home, &["--set", "leads=1,0.5"]).status(0).json();
    assert_eq!(untimed(document), untimed(wanted.clone()));
    assert_eq!(server.requests().len(), 5, "nothing is asked twice");
    let again = resume(
        &home,
        &["--set", "leads=0.5,1", "--set", "transforms=mirror"],
    );
    assert_eq!(untimed(again.status(0).json()), untimed(wanted));
    assert_eq!(server.requests().len(), 5);
    let list = run(&home, &["evaluate", "list"]).status(0).stdout;
    for words in [
        "6 of 6 answered",
        "lead 0.5,1 · mirror",
        &format!("2 scenarios: {HARD_BRAKING}, {CUT_IN} · truth: labels from "),
        "truth.csv",
    ] {
        assert!(list.contains(words), "{words}: {list}");
    }
}

/// What the last batch asks, but for the order.
fn asked(home: &Home) -> Vec<std::collections::BTreeMap<String, Option<String>>> {
    let mut rows = home.rows(
        "SELECT path, task, frame, techniques, model, sample, lead, transform, window_first, window_last, collides, key
         FROM items WHERE batch = (SELECT max(id) FROM batches)",
    );
    rows.sort();
    rows
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_of_two_tasks_asks_what_one_asks_that_was_planned_whole() {
    let names = BUNDLED.map(|(name, _)| name);
    let base = |samples: &'static str, models: &'static str, techniques: &'static str| {
        let options = [
            "--task",
            "collision,safety",
            "--set",
            "frames=cartesian,ego,metrics",
            "--format=json",
            "--samples",
            samples,
            "--model",
            models,
            "--techniques",
            techniques,
        ];
        [&["evaluate"][..], &names, &options].concat()
    };
    let server = yes_first().await;
    let first = base("1", "lab/tiny", "base");
    for (more, added) in [
        (
            base("1", "lab/tiny,lab/second", "base"),
            ["--model", "lab/second"],
        ),
        (base("1", "lab/tiny", "base,icl"), ["--techniques", "icl"]),
        (base("2", "lab/tiny", "base"), ["--samples", "2"]),
        (
            [&first[..], &["--set", "leads=1,0.5"]].concat(),
            ["--set", "leads=0.5"],
        ),
        (
            [&first[..], &["--set", "transforms=mirror"]].concat(),
            ["--set", "transforms=mirror"],
        ),
    ] {
        let whole = home_with(server.base_url());
        run(&whole, &more).status(0);
        let home = home_with(server.base_url());
        run(&home, &first).status(0);
        let few = asked(&home);
        resume(&home, &added).status(0);
        let (all, wanted) = (asked(&home), asked(&whole));
        assert!(few.len() < all.len(), "{added:?}");
        assert_eq!(all.len(), wanted.len(), "{added:?}");
        for (one, wanted) in all.iter().zip(&wanted) {
            assert_eq!(one, wanted, "{added:?}");
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_cannot_be_added_is_said() {
    let server = yes_first().await;
    let home = home_with(server.base_url());
    begin(&home, &["--task", "collision"]).status(0);
    resume(&home, &["--set", "leads=1"])
        .status(2)
        .says(&["leads", "safety task"]);
    begin(&home, &[]).status(0);
    resume(&home, &["--set", "leads=2.5"])
        .status(2)
        .says(&["leads: 2.5", "within = 2 s"]);
    let pinned = ["--set", "templates=safety-cartesian.md@000000000000"];
    resume(&home, &pinned)
        .status(2)
        .says(&["templates cannot be changed"]);
    resume(&home, &["--set", "tune.rounds=2"])
        .status(2)
        .says(&["tune cannot be changed"]);
    begin(&home, &["--samples", "2", "--set", "samples=3"])
        .status(2)
        .says(&["--set samples", "--samples sets it, too"]);
    begin(&home, &["--set", "tool_rounds=4"])
        .status(2)
        .says(&["--set tool_rounds", "set tools = true"]);
    resume(&home, &["--set", "within=3"]).status(2).says(&[
        "within cannot be changed",
        "models, techniques, leads, transforms and samples",
    ]);
    begin(&home, &["--retry-failed"])
        .status(2)
        .says(&["--retry-failed"]);
    let zero = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--set",
        "concurrency=0",
    ];
    run(&home, &zero)
        .status(2)
        .says(&["--set concurrency = 0: expected a whole number from 1"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn labels_that_cannot_be_of_the_scenario_are_refused_with_their_line() {
    let server = yes_first().await;
    let home = home_with(server.base_url());
    let plain = begin(&home, &[]).status(0).json();
    let wrong = home
        .write(
            "wrong.csv",
            format!("scenario,obstacle_id\n{HARD_BRAKING},none\n{CUT_IN},4711\n"),
        )
        .display()
        .to_string();
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
        .says(&["the truth names 7 scenarios that are not among these, such as ZAM_"]);
    let word = home
        .write("word.csv", format!("scenario,label\n{CUT_IN},perhaps\n"))
        .display()
        .to_string();
    run(&home, &["evaluate", CUT_IN, "--truth", &word])
        .status(2)
        .says(&["line 2: `perhaps` is not a label; use one of"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_keeps_its_template_when_another_one_is_in_use() {
    let server = yes_first().await;
    let home = home_with(server.base_url());
    begin(&home, &["--set", "frames=ego"]).status(0);
    let asked = server.requests().len();
    for change in [
        ["prompt", "copy", "safety-ego", "--as", "mine"].as_slice(),
        &["prompt", "use", "mine"],
    ] {
        run(&home, change).status(0);
    }
    resume(&home, &["--samples", "2"]).status(0);
    assert!(server.requests().len() > asked, "it goes on");
    let all = server.requests();
    let told = |at: usize| all[at].json()["messages"][0].to_string();
    assert_eq!(told(0), told(all.len() - 1), "with the same template");
}
