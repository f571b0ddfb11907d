//! Whole recordings, safe or of high risk, and risk scores as the truth.

use std::collections::BTreeMap;

use nearmiss::formats::bundled;
use nearmiss::metrics::{Context, MEASURES, Series};
use nearmiss::scenario::Scene;
use serde_json::{Value, json};

use super::CUT_IN;
use super::batches::{home as home_with, telling};
use super::support::program::{Ended, Home};
use super::support::server::Server;

const RED_LIGHT: &str = "ZAM_RedLight-1_1_T-1";

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// The bundled scenes with an ego, by name.
fn scenes() -> BTreeMap<String, Scene> {
    let scene = |entry: nearmiss::formats::Entry| {
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap()?;
        Some((entry.name.clone(), Scene::new(scenario, ego)))
    };
    bundled().into_iter().filter_map(scene).collect()
}

/// The lowest risk score at these steps, by the registry of measures.
fn lowest(scene: &Scene, steps: std::ops::RangeInclusive<i64>) -> u8 {
    let risk = MEASURES.iter().filter(|m| m.id == "risk").collect();
    let series = Series::from_context(&Context::new(scene), risk);
    let mut lowest = 5;
    for &id in series.obstacles() {
        for (step, reading) in scene.steps().zip(series.row("risk", id)) {
            if let Some(score) = reading.value().filter(|_| steps.contains(&step)) {
                lowest = lowest.min(score as u8);
            }
        }
    }
    lowest
}

fn lines(text: &str) -> Vec<Value> {
    let lines = text.lines();
    lines
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn a_recording_is_asked_about_as_a_whole() {
    let home = Home::new();
    let mut decisions = [0, 0];
    for (name, scene) in scenes() {
        let asked = [
            "ask",
            &name,
            "--task",
            "recording",
            "--no-store",
            "--format=json",
        ];
        let answer = home.run(&asked).status(0).json();
        let wanted = lowest(&scene, scene.steps().start..=scene.last_step()) <= 1;
        assert_eq!(answer["dangerous"], wanted, "{name}");
        assert_eq!(answer["verdict"]["high_risk"], wanted, "{name}");
        let all = json!([scene.steps().start, scene.last_step()]);
        assert_eq!(answer["window"], all, "{name}");
        decisions[usize::from(wanted)] += 1;
    }
    assert!(decisions.iter().all(|count| *count > 0), "{decisions:?}");
    let words = home
        .run(&["ask", CUT_IN, "--task", "recording", "--no-store"])
        .status(0)
        .stdout;
    assert!(words.contains("high risk"), "{words}");
    for option in [&["--at", "20"][..], &["--history", "5"]] {
        let asked = ["prompt", "show", CUT_IN, "--task", "recording"];
        home.run(&[&asked[..], option].concat())
            .status(2)
            .says(&["whole recording", option[0]]);
    }
    home.run(&[
        "prompt",
        "show",
        CUT_IN,
        "--task",
        "recording",
        "--frame",
        "cartesian",
    ])
    .status(2)
    .says(&["recording", "ego, metrics"]);
}

#[test]
fn the_question_about_a_recording_is_short_and_does_not_hold_its_answer() {
    let home = Home::new();
    let prompt = |more: &[&str]| {
        let asked = [
            "prompt",
            "show",
            RED_LIGHT,
            "--task",
            "recording",
            "--techniques",
            "base",
            "--format=json",
        ];
        home.run(&[&asked[..], more].concat()).status(0).json()
    };
    let user = |document: &Value| {
        document["messages"][1]["content"]
            .as_str()
            .unwrap()
            .to_string()
    };
    let times = |text: &str| {
        let rows = text.lines().filter(|line| line.contains(",ego,"));
        rows.map(|row| row.split(',').next().unwrap().to_string())
            .collect::<Vec<_>>()
    };
    let ego = user(&prompt(&["--frame", "ego"]));
    let (described, nearest) = ego
        .split_once("The nearest moment of each obstacle")
        .unwrap();
    assert!((10..=20).contains(&times(described).len()), "{described}");
    // The bus passes at -3.50 s, between two described times: its nearest moment is told all the same.
    assert!(!times(described).contains(&"-3.50".to_string()));
    assert!(nearest.contains("-3.50,bus 304,"), "{nearest}");
    // An explicit stride holds.
    let every = user(&prompt(&["--frame", "ego", "--set=stride=1"]));
    assert_eq!(times(every.split_once("The nearest").unwrap().0).len(), 61);
    let metrics = user(&prompt(&["--frame", "metrics"]));
    assert!(metrics.contains("min ttc [s]"), "{metrics}");
    for told in [",risk", "risk score", "Contact", "collision"] {
        assert!(!metrics.contains(told) && !ego.contains(told), "{told}");
    }
    let chosen = user(&prompt(&[
        "--frame",
        "metrics",
        "--set=measures=distance,risk",
    ]));
    assert!(chosen.contains(",risk"), "{chosen}");
    let prose = prompt(&["--frame", "ego", "--set=form=prose"]);
    assert!(user(&prose).contains("The nearest moment of each obstacle from t = -6.00 s"));
    let lane = user(&prompt(&["--frame", "ego", "--set=axes=lane"]));
    assert!(
        lane.contains("The nearest moment of each obstacle"),
        "{lane}"
    );
}

#[test]
fn labels_by_risk_score_are_those_of_the_scores_after_each_window() {
    let home = Home::new();
    let scenes = scenes();
    let names: Vec<&str> = scenes.keys().map(String::as_str).collect();
    let asked = [
        "--task",
        "safety,recording,collision",
        "--set",
        "leads=0.5,1",
        "--truth",
        "score",
        "--dry-run=questions",
    ];
    let text = home.run(&[&["evaluate"], &names[..], &asked].concat());
    let mut tasks: BTreeMap<(String, bool), usize> = BTreeMap::new();
    for line in lines(&text.status(0).stdout) {
        let scene = &scenes[line["scenario"].as_str().unwrap()];
        let [first, last] = ["first_step", "last_step"].map(|key| line[key].as_i64().unwrap());
        let task = line["task"].as_str().unwrap();
        let wanted = match task {
            "recording" => {
                assert_eq!((first, last), (scene.steps().start, scene.last_step()));
                lowest(scene, first..=last) <= 1
            }
            "safety" => lowest(scene, last + 1..=last + 20) <= 1,
            _ => lowest(scene, first..=last) == 0,
        };
        assert_eq!(line["label"] == "dangerous", wanted, "{line}");
        assert_eq!(
            line["critical"].as_array().unwrap().is_empty(),
            !wanted,
            "{line}"
        );
        if task == "safety" && !wanted {
            assert!(lowest(scene, first..=last) > 1, "{line}");
        }
        *tasks.entry((task.into(), wanted)).or_default() += 1;
    }
    for task in ["safety", "recording", "collision"] {
        for wanted in [true, false] {
            let key = (task.to_string(), wanted);
            assert!(tasks.contains_key(&key), "{key:?}: {tasks:?}");
        }
    }
}

#[test]
fn the_built_in_judge_is_held_against_the_score_of_the_paper() {
    let home = Home::new();
    let evaluate = |more: &[&str]| {
        home.run(
            &[
                &["evaluate", CUT_IN, RED_LIGHT, "--task", "recording"],
                more,
            ]
            .concat(),
        )
    };
    for own in [&[][..], &["--truth", "score"], &["--truth", "auto"]] {
        evaluate(own)
            .status(2)
            .says(&["--task recording needs --truth", "score:paper"]);
    }
    let counts = evaluate(&["--truth", "score:paper", "--format=json"])
        .status(0)
        .json();
    assert_eq!(
        (&counts["asked"]["tasks"], &counts["asked"]["truth"]),
        (&json!(["recording"]), &json!(["score:paper"]))
    );
    let cell = &counts["cells"][0];
    let cells = ["tp", "fp", "fn", "tn"].map(|key| cell[key].as_u64().unwrap());
    assert_eq!(cells.iter().sum::<u64>(), 2, "{counts}");
    // Leads count from the first moment of extreme risk, which is before the contact.
    let safety = |truth: &str| {
        let asked = [
            "evaluate",
            CUT_IN,
            RED_LIGHT,
            "--set",
            "leads=0.5",
            "--format=json",
        ];
        home.run(&[&asked[..], &["--truth", truth]].concat())
            .status(0)
            .json()
    };
    let (auto, score) = (safety("auto"), safety("score"));
    assert_eq!(score["asked"]["truth"], json!(["score"]));
    // One of them comes near without a contact.
    assert_eq!(
        (&auto["collisions"], &score["collisions"]),
        (&json!(1), &json!(2))
    );
    evaluate(&["--truth", "scores"])
        .status(2)
        .says(&["scores", "score"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn reports_say_where_the_question_holds_the_score_that_is_the_truth() {
    let said = json!({"justification": "so", "obstacles": [], "critical_obstacles": [], "probability": 0.9,
        "safety_critical": true, "high_risk": true})
    .to_string();
    let server = Server::answering(move |_, _| Some(telling(&said))).await;
    let home = home_with(server.base_url());
    let asked = [
        "evaluate",
        CUT_IN,
        RED_LIGHT,
        "--model",
        "lab/tiny,reference/geometry",
        "--task",
        "safety,recording",
        "--techniques",
        "base",
        "--truth",
        "score",
    ];
    let with = |frames: &'static str| [&asked[..], &["--set", frames]].concat();
    run(
        &home,
        &[
            &with("frames=metrics")[..],
            &["--write-experiment", "e.toml"],
        ]
        .concat(),
    )
    .status(0);
    let text = std::fs::read_to_string(home.files().join("e.toml")).unwrap();
    assert!(text.contains("truth = [\"score\"]"), "{text}");
    run(&home, &["evaluate", "e.toml"]).status(0);
    run(&home, &with("frames=ego")).status(0);
    let report = |batch: &str| {
        let asked = ["report", "--batch", batch, "--format=json"];
        run(&home, &asked).status(0).json()
    };
    let notes = |report: &Value| report["notes"].to_string();
    let (metrics, ego) = (report("b1"), report("b2"));
    assert!(
        metrics["truth"]["words"]
            .as_str()
            .unwrap()
            .starts_with("risk score of TTC and MDC"),
        "{metrics}"
    );
    let note =
        "The truth of the safety task is a risk score, and its metrics frame prints risk scores";
    assert!(notes(&metrics).contains(note), "{}", notes(&metrics));
    assert!(
        !notes(&ego).contains("prints risk scores"),
        "{}",
        notes(&ego)
    );
    // Both recordings are of high risk; the judge's answers to that are the truth itself.
    for report in [&metrics, &ego] {
        let cells = report["cells"].as_array().unwrap();
        let of = |model: &str| {
            let is = |cell: &&Value| {
                cell["label"] == "all" && cell["task"] == "recording" && cell["model"] == model
            };
            let cell = cells.iter().find(is).unwrap();
            ["tp", "fp", "fn", "tn"].map(|key| cell[key].as_u64().unwrap())
        };
        assert_eq!(of("lab/tiny"), [2, 0, 0, 0]);
        assert_eq!(of("reference/geometry"), [2, 0, 0, 0]);
    }
    // Stored answers, whatever their batch said.
    let stored = |truth: &str| {
        let asked = [
            "report",
            "--truth",
            truth,
            "--frame",
            "ego",
            "--format=json",
        ];
        run(&home, &asked[..3]);
        run(&home, &["report", "--truth", truth, "--format=json"])
            .status(0)
            .json()
    };
    let by_score = stored("score");
    assert!(notes(&by_score).contains(note), "{}", notes(&by_score));
    assert_eq!(by_score["truth"]["sources"], json!(["score"]));
    run(&home, &["report", "--truth", "score,batch"])
        .status(2)
        .says(&["--truth score stands alone", "batch"]);
    // Another truth of the same answers.
    run(&home, &["evaluate", "b2", "--truth", "score:paper"]);
    let paper = report("b2");
    assert!(
        paper["truth"]["words"]
            .as_str()
            .unwrap()
            .contains("the paper's convention"),
        "{paper}"
    );
    let runs = run(
        &home,
        &["runs", "list", "task:recording", "verdict:dangerous"],
    );
    assert!(runs.status(0).stdout.contains("high risk"));
}

/// A home with a model that calls everything dangerous, and the answers to a question of it.
async fn alarmed() -> (Home, Server) {
    let named = json!([{"id": 301, "probability": 0.9}]);
    let said = json!({"justification": "so", "obstacles": [], "critical_obstacles": named, "probability": 0.9,
        "safety_critical": true, "high_risk": true})
    .to_string();
    let server = Server::answering(move |_, _| Some(telling(&said))).await;
    let home = home_with(server.base_url());
    (home, server)
}

const ASKED: [&str; 7] = [
    "evaluate",
    CUT_IN,
    RED_LIGHT,
    "--model",
    "lab/tiny",
    "--techniques",
    "base",
];

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_score_is_the_truth_of_recordings_with_auto_too_and_reports_and_chats_say_so() {
    let (home, _server) = alarmed().await;
    let options = ["--task", "recording", "--set", "frames=metrics"];
    let measured = ["--set", "measures=distance,risk", "--truth", "auto"];
    run(&home, &[&ASKED[..], &options, &measured].concat()).status(0);
    let note =
        "The truth of the recording task is a risk score, and its metrics frame prints risk scores";
    for asked in [
        &["report", "--batch", "b1", "--format=json"][..],
        &["report", "--format=json"],
    ] {
        let report = run(&home, asked).status(0).json();
        let notes = report["notes"].to_string();
        assert!(notes.contains(note), "{asked:?}: {notes}");
    }
    run(
        &home,
        &["runs", "export", "--format", "chat", "-o", "chats"],
    )
    .status(0);
    let manifest = std::fs::read(home.files().join("chats").join("manifest.json")).unwrap();
    let manifest: Value = serde_json::from_slice(&manifest).unwrap();
    let notes = manifest["notes"].to_string();
    assert!(notes.contains(note), "{notes}");
    // Labels are no score.
    home.write(
        "truth.csv",
        format!("scenario,label\n{CUT_IN},collision\n{RED_LIGHT},safe\n"),
    );
    run(&home, &["evaluate", "b1", "--truth", "truth.csv"]);
    for asked in [
        &["report", "--batch", "b1", "--format=json"][..],
        &["report", "--format=json"],
    ] {
        let notes = run(&home, asked).status(0).json()["notes"].to_string();
        assert!(!notes.contains("prints risk scores"), "{asked:?}: {notes}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn another_truth_leaves_no_critical_obstacles_of_the_one_before() {
    let (home, _server) = alarmed().await;
    let safety = [
        "--task",
        "safety",
        "--set",
        "frames=ego",
        "--set",
        "leads=0.5",
    ];
    run(
        &home,
        &[&ASKED[..], &safety, &["--truth", "score"]].concat(),
    )
    .status(0);
    // The ego comes near there, and touches nothing.
    let critical = || -> Vec<String> {
        let sql = "SELECT json_extract(facts, '$.critical') AS critical FROM items
             WHERE scenario LIKE '%CutIn%' ORDER BY place";
        let rows = home.rows(sql).into_iter();
        rows.filter_map(|row| row["critical"].clone()).collect()
    };
    let by_score = critical();
    assert!(by_score.iter().any(|ids| ids != "[]"), "{by_score:?}");
    // A collision with an unknown obstacle.
    home.write(
        "truth.csv",
        format!("scenario,label\n{CUT_IN},collision\n{RED_LIGHT},collision\n"),
    );
    let resume = |truth: &str| run(&home, &["evaluate", "b1", "--truth", truth]);
    resume("truth.csv");
    assert!(critical().iter().all(|ids| ids == "[]"), "{:?}", critical());
    resume("score");
    assert_eq!(critical(), by_score);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn stored_answers_are_judged_over_the_look_ahead_that_they_were_asked_with() {
    let (home, _server) = alarmed().await;
    let safety = [
        "--task",
        "safety",
        "--set",
        "frames=ego",
        "--set",
        "history=5",
    ];
    let far = ["--set", "leads=3", "--set", "within=4", "--truth", "score"];
    run(&home, &[&ASKED[..], &safety, &far].concat()).status(0);
    let counts = |asked: &[&str]| {
        let report = run(&home, asked).status(0).json();
        let cells = report["cells"].as_array().unwrap().clone();
        let all = cells.iter().find(|cell| cell["label"] == "all").unwrap();
        ["tp", "fp", "fn", "tn"].map(|key| all[key].as_u64().unwrap())
    };
    let own = counts(&["report", "--batch", "b1", "--format=json"]);
    assert!(own[0] > 0, "{own:?}");
    assert_eq!(
        counts(&["report", "--truth", "score", "--format=json"]),
        own
    );
    // Without the batch it is not known how far ahead the question looks.
    home.rows("UPDATE runs SET batch = 'b77'");
    let lost = run(&home, &["report", "--truth", "score", "--format=json"]);
    assert!(
        lost.stderr
            .contains("the batch that says how far ahead they look is not in the store"),
        "{}",
        lost.stderr
    );
}
