//! `evaluate` in bulk: one rule for every judge, budgets, labels that are missing, and what cannot be asked.

use super::batches::{home as home_with, telling};
use super::support::program::{Ended, Home};
use super::support::server::Server;
use super::{CUT_IN, bundled_xml};

const RED_LIGHT: &str = "ZAM_RedLight-1_1_T-1";
const HARD_BRAKING: &str = "ZAM_HardBraking-1_1_T-1";
const SAYS: &str = r#"{"collision": true, "obstacles": [], "justification": "so"}"#;

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

#[test]
fn a_yes_is_a_yes_and_whom_it_names_is_counted_apart() {
    let home = Home::new();
    for (who, named) in [("301", 1.0), ("307", 0.0)] {
        let text =
            format!("scenario,label,obstacle_id\n{RED_LIGHT}.xml,critical,{who}\n{CUT_IN},no,\n");
        let truth = home.write("truth.csv", text).display().to_string();
        let all = [
            "evaluate",
            RED_LIGHT,
            CUT_IN,
            "--model",
            "reference/geometry",
        ];
        let all = [&all[..], &["--set", "leads=0.1", "--truth", &truth]].concat();
        let alone = home
            .run(&[&all[..], &["--format", "json"]].concat())
            .status(0)
            .json()["cells"][0]
            .clone();
        let batch = home
            .run(&[&all[..], &["--samples", "1", "--format=json"]].concat())
            .status(0)
            .json()["cells"][0]
            .clone();
        for (name, count) in [("tp", 1), ("fn", 0)] {
            assert_eq!(alone[name], count, "{alone}");
        }
        for name in [
            "tp",
            "fp",
            "fn",
            "tn",
            "f1",
            "naming_recall",
            "naming_precision",
        ] {
            assert_eq!(alone[name], batch[name], "{name}: {alone} {batch}");
        }
        assert_eq!(alone["naming_recall"], named);
    }
    let table = home.run(&["evaluate", "last"]).status(0).stdout;
    assert!(table.contains("Obstacle named"), "{table}");
}

#[test]
fn the_layout_of_folders_is_a_truth_of_the_built_in_judge_too() {
    let home = Home::new();
    for (half, name) in [("collision", CUT_IN), ("normal", HARD_BRAKING)] {
        let folder = format!("Scenarios/{half}_scenarios");
        for ending in ["xml", "ego_trajectory.csv"] {
            let from = std::path::Path::new("scenarios").join(format!("{name}.{ending}"));
            home.write(
                format!("{folder}/{name}.{ending}"),
                std::fs::read(from).unwrap(),
            );
        }
    }
    let options = [
        "--model",
        "reference/geometry",
        "--set",
        "leads=0.5",
        "--truth",
        "layout",
    ];
    let all = [
        &["evaluate", "Scenarios"],
        &options[..],
        &["--format", "json"],
    ]
    .concat();
    let document = home.run(&all).status(0).json();
    assert_eq!(document["asked"]["truth"], serde_json::json!(["layout"]));
    assert_eq!(
        (&document["collisions"], &document["safe"]),
        (&1.into(), &1.into())
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_budget_that_is_too_small_is_said_before_and_leaves_questions_unasked() {
    let server = Server::answering(|_, _| Some(telling(SAYS))).await;
    let home = home_with(server.base_url());
    let price = "[[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 1\noutput = 1000\n";
    let config = home.config().join("config.toml");
    let text = std::fs::read_to_string(&config).unwrap() + price;
    home.write(config, text);
    let all = [
        "evaluate",
        CUT_IN,
        HARD_BRAKING,
        "--model",
        "lab/tiny",
        "--task",
        "collision",
    ];
    let bounds = ["--set", "max_tokens=100", "--budget"];
    let with = |budget, more: &[&str]| run(&home, &[&all[..], &bounds, &[budget], more].concat());
    let dry = with("0.15", &["--dry-run"]).status(0).stdout;
    assert!(dry.contains("0.15 USD, too little"), "{dry}");
    assert_eq!(
        with("0.15", &["--dry-run", "--format=json"]).json()["within_budget"],
        false
    );
    assert_eq!(
        with("5", &["--dry-run", "--format=json"]).json()["within_budget"],
        true
    );
    let ended = with("0.15", &["--format=json"]).status(1);
    let cell = ended.json()["cells"][0].clone();
    assert_eq!(
        (&cell["failed"], &cell["unasked"]),
        (&0.into(), &1.into()),
        "{cell}"
    );
    assert_eq!(server.requests().len(), 1);
    let runs = home.rows("SELECT id FROM runs WHERE deleted_ms IS NULL");
    assert_eq!(runs.len(), 1, "what was not sent is no run");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_can_never_be_asked_is_named_and_is_no_reason_to_try_again() {
    let server = Server::answering(|_, _| Some(telling(SAYS))).await;
    let home = home_with(server.base_url());
    for name in ["a", "b", "c", "d", "e"] {
        home.write(format!("in/{name}.xml"), bundled_xml(CUT_IN));
    }
    let all = [
        "evaluate",
        "in",
        HARD_BRAKING,
        "--model",
        "lab/tiny",
        "--task",
        "collision",
    ];
    let ended = run(&home, &all).status(0);
    ended.says(&[
        "5 questions cannot be asked:",
        "5 × no recorded ego: add --ego planner",
    ]);
    let ended = run(&home, &["evaluate", "last"]).status(0);
    assert!(
        !ended.stderr.contains("asks them again"),
        "{}",
        ended.stderr
    );
    assert_eq!(server.requests().len(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_batch_is_stays_and_another_truth_is_said() {
    let server = Server::answering(|_, _| Some(telling(SAYS))).await;
    let home = home_with(server.base_url());
    let all = [
        "evaluate",
        CUT_IN,
        HARD_BRAKING,
        "--model",
        "lab/tiny",
        "--set",
        "leads=paper",
    ];
    run(&home, &all).status(0);
    let list = run(&home, &["evaluate", "list"]).stdout;
    assert!(list.contains("lead end"), "{list}");
    let resume = |more: &[&str]| run(&home, &[&["evaluate", "last"], more].concat());
    resume(&[CUT_IN])
        .status(2)
        .says(&["a stored batch keeps its scenarios", "start a new batch"]);
    resume(&["--task", "collision", "--set", "history=5"])
        .status(2)
        .says(&[
            "tasks, history cannot be changed",
            "models, techniques, leads, transforms",
        ]);
    let truth = home
        .write("truth.csv", format!("scenario,label\n{CUT_IN},yes\n"))
        .display()
        .to_string();
    resume(&["--truth", &truth]).status(1).says(&[
        "b1: the truth is from now on: labels from ",
        "it was: exact geometry",
        &format!("no label for 1 scenario: {HARD_BRAKING}"),
        "1 scenario without a label",
    ]);
}
