//! Models of known quality, played by a server: one that copies the printed risk scores, and one that names everybody.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use super::BUNDLED;
use super::remote::delta;
use super::support::program::{Ended, Home};
use super::support::recorded;
use super::support::server::{Recorded, Script, Server};

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// An answer in one piece.
fn says(text: &str) -> Script {
    let end = "data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n";
    Script::chunked_events()
        .chunk(delta(text))
        .chunk(end)
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

/// The last risk score that the metrics table of a question prints for each obstacle.
fn printed_scores(question: &str) -> BTreeMap<i64, u8> {
    let mut rows = question
        .lines()
        .skip_while(|line| !line.starts_with("t [s],who"));
    let head: Vec<&str> = rows.next().expect("a table").split(',').collect();
    assert_eq!((head[1], head[head.len() - 1]), ("who", "risk"));
    let scored = rows.map_while(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells.len() == head.len()).then_some(cells)
    });
    scored
        .filter(|cells| cells[1] != "ego")
        .map(|cells| {
            let id = cells[1].rsplit(' ').next().unwrap();
            (id.parse().unwrap(), cells[cells.len() - 1].parse().unwrap())
        })
        .collect()
}

/// Who touches the ego within 2 s on its present course closes the gap in less than 3 s: by the table of the rubric the
/// grade of the time is 3 at most, that of the distance 5, their mean 4.
const WITHIN_HORIZON: u8 = 4;

/// What a model says: `copies` grades as printed and names those within the horizon, `spams` says yes and names
/// everybody.
fn answer(request: &Recorded) -> String {
    let body = request.json();
    let messages = body["messages"].as_array().unwrap();
    let rubric = messages[0]["content"].as_str().unwrap();
    assert!(
        rubric.contains("| 3 | medium | 3.0 m | 3.0 s |"),
        "{rubric}"
    );
    let question = messages[messages.len() - 1]["content"].as_str().unwrap();
    let scores = printed_scores(question);
    let is_named = |score: u8| match body["model"].as_str().unwrap() {
        "copies" => score <= WITHIN_HORIZON,
        "spams" => true,
        other => panic!("{other}"),
    };
    let named = scores.iter().filter(|(_, score)| is_named(**score));
    let named: Vec<Value> = named
        .map(|(id, _)| json!({"id": id, "probability": 0.9}))
        .collect();
    let yes = body["model"] == "spams" || !named.is_empty();
    let obstacles = scores
        .iter()
        .map(|(id, score)| json!({"id": id, "risk_score": score, "reason": "printed"}));
    json!({
        "justification": "the scores say so",
        "obstacles": obstacles.collect::<Vec<_>>(),
        "critical_obstacles": named,
        "probability": if yes { 0.9 } else { 0.1 },
        "safety_critical": yes,
    })
    .to_string()
}

/// The cells, leads and report of a batch of both models and the judge.
async fn asked(paths: &[&str], leads: &str) -> (Home, Vec<Value>, Value, Value) {
    let server = Server::answering(|_, request| Some(says(&answer(request)))).await;
    let home = Home::new();
    let config = format!(
        "[provider.lab]\nbase_url = \"{}\"\nkey_env = []\nconcurrency = 8\n",
        server.base_url()
    );
    home.write(home.config().join("config.toml"), config);
    let options = [
        "--set",
        "frames=metrics",
        "--techniques",
        "cp",
        "--truth",
        "auto",
    ];
    let leads = format!("leads={leads}");
    let leads = ["--set", leads.as_str()];
    let all = [&["evaluate"], paths, &options[..], &leads[..]].concat();
    let questions = run(&home, &[&all[..], &["--dry-run=questions"]].concat()).status(0);
    let models = [
        "--model",
        "lab/copies,lab/spams,reference/geometry",
        "--format=json",
    ];
    let batch = run(&home, &[&all[..], &models[..]].concat()).status(0);
    let report = run(&home, &["report", "--batch", "last", "--format=json"]).status(0);
    (home, questions.json_lines(), batch.json(), report.json())
}

/// The row of a model about all its answers.
fn cell<'a>(report: &'a Value, model: &str) -> &'a Value {
    let mut cells = report["cells"].as_array().unwrap().iter();
    cells
        .find(|cell| cell["label"] == "all" && cell["model"] == model)
        .unwrap()
}

/// The share of the obstacles that the tables of these questions print that are critical: what names drawn at random
/// would have. What was sent is read from the store.
fn base_rate(home: &Home, questions: &[Value]) -> f64 {
    let sent = home.rows(
        "SELECT scenario, window_first, window_last, messages FROM runs WHERE model = 'lab/spams'",
    );
    let asked = |question: &Value| {
        let here = |row: &&BTreeMap<String, Option<String>>| {
            let is = |column: &str, value: String| row[column] == Some(value);
            is("scenario", question["scenario"].as_str().unwrap().into())
                && is("window_first", question["first_step"].to_string())
                && is("window_last", question["last_step"].to_string())
        };
        let mut rows = sent.iter().filter(here);
        let messages = rows.next().expect("it was asked")["messages"].clone();
        let messages: Value = serde_json::from_str(&messages.unwrap()).unwrap();
        let last = messages.as_array().unwrap().last().unwrap();
        last["content"].as_str().unwrap().to_string()
    };
    let critical = |question: &Value| question["critical"].as_array().unwrap().len();
    let printed = questions.iter().map(|q| printed_scores(&asked(q)).len());
    let critical: usize = questions.iter().map(critical).sum();
    critical as f64 / printed.sum::<usize>() as f64
}

fn is_last(report: &Value, model: &str) {
    let models: BTreeSet<&str> = report["cells"]
        .as_array()
        .unwrap()
        .iter()
        .map(|cell| cell["model"].as_str().unwrap())
        .collect();
    assert_eq!(models.len(), 3, "{models:?}");
    for figure in ["specificity", "naming_precision", "accuracy"] {
        let of = |model: &str| cell(report, model)[figure].as_f64().unwrap();
        for other in models.iter().filter(|other| **other != model) {
            assert!(
                of(model) < of(other),
                "{figure}: {} {}",
                of(model),
                of(other)
            );
        }
    }
    assert_eq!(cell(report, model)["specificity"], 0.0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn one_that_names_everybody_is_last() {
    let names = BUNDLED.map(|(name, _)| name);
    let (home, questions, _, report) = asked(&names, "0.5").await;
    let spam = cell(&report, "lab/spams");
    assert_eq!(
        (&spam["recall"], &spam["naming_recall"]),
        (&json!(1.0), &json!(1.0))
    );
    let rate = base_rate(&home, &questions);
    let precision = spam["naming_precision"].as_f64().unwrap();
    assert!((precision - rate).abs() < 1e-9, "{precision} {rate}");
    is_last(&report, "lab/spams");
    let text = run(&home, &["report", "--batch", "last"]).status(0).stdout;
    assert!(text.contains("Names right"), "{text}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn published_collisions_are_found_by_their_printed_scores() {
    let Some(folder) = recorded::folder() else {
        return;
    };
    let folder = folder.join("Scenarios");
    let leads = "0.2,0.5,1,1.5,2";
    let path = folder.display().to_string();
    let (home, questions, batch, report) = asked(&[&path], leads).await;
    let rows: Vec<&Value> = batch["lead"].as_array().unwrap().iter().collect();
    let of = |model: &'static str| rows.iter().filter(move |row| row["model"] == model);
    for row in of("lab/copies") {
        println!(
            "lead {}: copied scores say yes to {} of {} collisions (name {} of {}), to {} of {} safe windows",
            row["lead"],
            row["yes"],
            row["n"],
            row["named"],
            row["named_of"],
            row["false_alarms"],
            row["false_alarms_of"]
        );
        // Scores grade the present: who is to turn or accelerate only later has the lowest one.
        let floor = match row["lead"].as_f64().unwrap() {
            lead if lead <= 1.0 => 0.95,
            lead if lead <= 1.5 => 0.90,
            _ => 0.85,
        };
        assert!(row["yes_rate"].as_f64().unwrap() >= floor, "{row}");
        // It is no spam: some safe windows are called safe.
        assert!(row["false_alarm_rate"].as_f64().unwrap() < 1.0, "{row}");
    }
    assert_eq!((of("lab/copies").count(), of("lab/spams").count()), (5, 5));
    // A yes counts whatever scores stand beside it: it copies the printed ones, too.
    for row in of("lab/spams") {
        for rate in ["yes_rate", "named_rate", "false_alarm_rate"] {
            assert_eq!(row[rate], json!(1.0), "{row}");
        }
    }
    let first = questions.iter().filter(|question| question["lead"] == 0.2);
    let first: Vec<Value> = first.cloned().collect();
    let rate = base_rate(&home, &first);
    let precision = cell(&report, "lab/spams")["naming_precision"]
        .as_f64()
        .unwrap();
    println!("naming precision of the spam {precision:.4}, base rate {rate:.4}");
    assert!((precision - rate).abs() < 1e-9, "{precision} {rate}");
    is_last(&report, "lab/spams");
}
