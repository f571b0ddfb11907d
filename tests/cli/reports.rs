//! `report` of batches: which truth counts, the built-in judge beside them, and questions that were not asked.

use nearmiss::formats::bundled;
use nearmiss::store::{Claim, Ending, RunId, RunState, Store};
use nearmiss::tui::headless::Stage;
use nearmiss::verdict::{ParsedAnswer, Task, Verdict};
use serde_json::{Value, json};

use super::batches::{home as home_with, telling};
use super::support::program::{Ended, Home};
use super::support::server::{Recorded, Server};
use super::{BUNDLED, CUT_IN};

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// A server that says yes about half of the scenarios, to the same question always the same.
pub async fn half_of_them() -> Server {
    let said = |request: &Recorded| {
        let sum: u32 = request.body.iter().map(|byte| u32::from(*byte)).sum();
        let key = if String::from_utf8_lossy(&request.body).contains("safety_critical") {
            "safety_critical"
        } else {
            "collision"
        };
        json!({ key: sum.is_multiple_of(2), "obstacles": [], "justification": "so" }).to_string()
    };
    Server::answering(move |_, request| Some(telling(&said(request)))).await
}

const RED_LIGHT: &str = "ZAM_RedLight-1_1_T-1";

/// The row of all answers of a model to a task.
fn whole<'a>(report: &'a Value, model: &str, task: &str) -> &'a Value {
    let cells = report["cells"].as_array().unwrap();
    let is =
        |cell: &&Value| cell["label"] == "all" && cell["model"] == model && cell["task"] == task;
    cells.iter().find(is).unwrap()
}

fn counts(cell: &Value) -> [u64; 4] {
    ["tp", "fp", "fn", "tn"].map(|name| cell[name].as_u64().unwrap())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_report_of_a_batch_says_what_it_is_of_and_asks_the_judge_itself() {
    let server = half_of_them().await;
    let home = home_with(server.base_url());
    let names = BUNDLED.map(|(name, _)| name);
    let more = ["--model", "lab/tiny", "--task", "collision,safety"];
    run(&home, &[&["evaluate"], &names[..], &more].concat()).status(0);
    let report = || {
        run(&home, &["report", "--batch", "b1", "--format=json"])
            .status(0)
            .json()
    };
    let alone = report();
    assert_eq!(alone["batch"], "b1");
    assert_eq!(alone["asked"]["models"], json!(["lab/tiny"]));
    assert_eq!(alone["asked"]["tasks"], json!(["collision", "safety"]));
    assert!(alone["asked"].get("base_url").is_none(), "{alone}");
    assert_eq!(alone["truth"]["sources"], json!(["auto"]));
    // The judge's answers as the batch asks it, once it does, are the same.
    run(&home, &["evaluate", "b1", "--model", "reference/geometry"]).status(0);
    let asked = report();
    for task in ["collision", "safety"] {
        let [a, b] = [&alone, &asked].map(|report| whole(report, "lab/tiny", task));
        assert_eq!(a["kappa_n"], a["n"], "{a}");
        let [tp, fp, missed, tn] = counts(a);
        assert_eq!((tp + missed, fp + tn), (2, 2), "matched windows: {a}");
        for field in ["kappa", "kappa_n", "agreement_with_reference"] {
            assert_eq!(a[field], b[field], "{task} {field}");
        }
        assert!(a["agreement_with_reference"].as_f64() < Some(1.0), "{a}");
    }
    let csv = run(&home, &["report", "--batch", "b1", "--format", "csv"]).status(0);
    let row: Vec<&str> = csv.stdout.lines().nth(1).unwrap().split(',').collect();
    assert_eq!(
        row[row.len() - 2..],
        [
            "b1",
            "exact geometry of each matched window and the 2 s after it"
        ]
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn without_a_batch_an_answer_is_held_against_the_truth_of_its_own() {
    let server = half_of_them().await;
    let home = home_with(server.base_url());
    let names = BUNDLED.map(|(name, _)| name);
    let more = ["--model", "lab/tiny", "--task", "collision"];
    run(&home, &[&["evaluate"], &names[..], &more].concat()).status(0);
    let count = |arguments: &[&str]| {
        let report = run(&home, &[&["report", "--format=json"], arguments].concat())
            .status(0)
            .json();
        let words = report["truth"]["words"].as_str().unwrap().to_string();
        (counts(whole(&report, "lab/tiny", "collision")), words)
    };
    let (geometry, words) = count(&[]);
    assert!(words.contains("b1, 4 answers: exact geometry"), "{words}");
    let turned: String = BUNDLED
        .iter()
        .map(|(name, collides)| format!("{name},{}\n", u8::from(!collides)))
        .collect();
    let truth = home.write("turned.csv", format!("scenario,label\n{turned}"));
    let truth = truth.to_str().unwrap();
    // The windows keep the truth that was drawn with them until the batch has another one.
    let (kept, words) = count(&["--truth", truth]);
    assert_eq!(kept, geometry);
    assert!(
        words.contains("of drawn windows that of each answer's batch"),
        "{words}"
    );
    run(&home, &["evaluate", "b1", "--truth", truth]).status(0);
    let (own, words) = count(&[]);
    assert!(
        words.contains("b1, 4 answers: labels from") && words.contains("turned.csv"),
        "{words}"
    );
    let [tp, fp, missed, tn] = geometry;
    // Where no bodies touch, a labelled collision is at the end of its recording, after these windows.
    assert_eq!(own, [0, tp + fp, 0, missed + tn]);
    assert_ne!(own, geometry);
    assert_eq!(count(&["--truth", "auto"]).0, own);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_safe_window_long_before_a_collision_stays_safe_whatever_its_scenario_is_called() {
    let server = half_of_them().await;
    let home = home_with(server.base_url());
    run(&home, &["evaluate", RED_LIGHT, "--model", "lab/tiny"]).status(0);
    let truth = home.write("truth.csv", format!("scenario,label\n{RED_LIGHT},yes\n"));
    for arguments in [
        &["--batch", "b1"][..],
        &[],
        &["--truth", "auto"],
        &["--truth", truth.to_str().unwrap()],
    ] {
        let report = run(&home, &[&["report", "--format=json"], arguments].concat()).status(0);
        let [tp, fp, missed, tn] = counts(whole(&report.json(), "lab/tiny", "safety"));
        assert_eq!((tp + missed, fp + tn), (1, 1), "{arguments:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_was_not_asked_and_what_cannot_be_judged_is_said() {
    let server = half_of_them().await;
    let home = home_with(server.base_url());
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let xml = std::fs::read(folder.join(format!("{CUT_IN}.xml"))).unwrap();
    let ego = std::fs::read(folder.join(format!("{CUT_IN}.ego_trajectory.csv"))).unwrap();
    let whole_one = home.write("many/One.xml", &xml);
    home.write("many/One.ego_trajectory.csv", ego);
    home.write("many/Egoless.xml", &xml);
    let arguments = [
        "evaluate",
        "many",
        "--model",
        "lab/tiny",
        "--task",
        "collision",
        "--format=json",
    ];
    let table = run(&home, &arguments).status(0).json();
    let cell = &table["cells"][0];
    let of = |cell: &Value, name: &str| cell[name].as_u64().unwrap();
    let names = ["n", "failed", "unasked", "unlabelled"];
    assert_eq!(names.map(|name| of(cell, name)), [2, 0, 1, 0], "{table}");
    assert_eq!(cell["label"], "all", "{table}");
    let ended = run(&home, &["report", "--batch", "b1", "--format=json"]).status(0);
    let report = ended.says(&["1 cannot be asked"]).json();
    let counted = whole(&report, "lab/tiny", "collision");
    assert_eq!(
        names.map(|name| of(counted, name)),
        [2, 0, 1, 0],
        "{report}"
    );
    assert_eq!(counted["kappa_n"], 1);
    // Without the file no judge can be asked about it, and the report says so.
    std::fs::remove_file(whole_one).unwrap();
    let report = run(&home, &["report", "--batch", "b1", "--format=json"])
        .status(0)
        .json();
    assert!(whole(&report, "lab/tiny", "collision")["kappa_n"].is_null());
    let notes = report["notes"].to_string();
    assert!(
        notes.contains("could not be asked about 2 scenarios"),
        "{notes}"
    );
    assert!(notes.contains("One ("), "{notes}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_report_and_the_results_screen_have_one_answer_to_what_is_true() {
    let server = half_of_them().await;
    let home = home_with(server.base_url());
    for (name, _) in &BUNDLED[..3] {
        for task in ["collision", "safety"] {
            run(&home, &["ask", name, "--task", task, "--model", "lab/tiny"]).status(0);
        }
    }
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    // An answer about a scenario that is nowhere, and one with another text of the template.
    let said = |dangerous| {
        Some(ParsedAnswer::Verdict(Verdict {
            task: Task::Collision,
            dangerous,
            obstacles: Vec::new(),
            justification: String::new(),
            critical: None,
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        }))
    };
    let first = store.run(RunId(1)).unwrap().unwrap().question;
    let mut nowhere = first.clone();
    (nowhere.scenario, nowhere.scenario_hash) = ("ZAM_Nowhere-1_1_T-1".into(), None);
    let mut draft = first;
    (draft.template_version, draft.template_hash) = (None, "1".repeat(64));
    for question in [nowhere, draft] {
        let Claim::Granted(run) = store.claim(&question, true).unwrap() else {
            panic!("fresh questions are granted");
        };
        let ending = Ending {
            verdict: said(true),
            ..Ending::bare(RunState::Answered)
        };
        store.finish(run, &ending).unwrap();
    }
    let report = run(&home, &["report", "--format=json"]).status(0).json();
    let entries = bundled();
    let mut stage = Stage::open(&entries[0], (120, 40)).unwrap();
    stage.list(entries[1..].to_vec());
    stage.read_results(&store);
    let rows = stage.results().into_iter().map(|row| json!(row));
    let rows: Vec<Value> = rows.collect();
    assert_eq!(rows.len(), 3, "{rows:?}");
    let mut unlabelled = 0;
    for row in &rows {
        let same = |cell: &&Value| {
            cell["label"] == "all"
                && ["task", "template", "template_hash"]
                    .iter()
                    .all(|key| cell[*key] == row[*key])
        };
        let cell = report["cells"]
            .as_array()
            .unwrap()
            .iter()
            .find(same)
            .unwrap_or_else(|| panic!("{row} is not in {report}"));
        for key in ["n", "tp", "fp", "fn", "tn", "unlabelled", "f1"] {
            assert_eq!(cell[key], row[key], "{key} {row}");
        }
        unlabelled += row["unlabelled"].as_u64().unwrap();
    }
    assert_eq!(unlabelled, 1, "of the scenario that is nowhere");
    let screen = stage.screen();
    assert!(screen.contains("draft@111111"), "{screen}");
}
