//! `nearmiss report`: the recorded answers of the paper beside what is expected of them, and runs of the store.
//!
//! The recorded answers are not part of this repository: `../shared`, or what `NEARMISS_SHARED` names, holds
//! `data/from-words-to-collisions`; without it the test of them says so and ends.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

use std::collections::BTreeMap;
use std::path::PathBuf;

use nearmiss::store::{Consumed, Ending, NewRun, Origin, Run, RunId, RunState, Store};
use nearmiss::verdict::{ParsedAnswer, Task, Verdict};
use serde_json::Value;

use support::program::Home;
use support::recorded::folder;

/// The cell of an expected count such as `collision agent cart_icl gemini`, among those of a report.
fn cell<'a>(cells: &'a [Value], name: &str) -> &'a Value {
    let words: Vec<&str> = name.split(' ').collect();
    let [label, kind, method, engine] = words[..] else {
        panic!("{name}")
    };
    let (frame, technique) = method.split_once('_').unwrap();
    let wanted = [
        ("label", label),
        (
            "task",
            if kind == "agent" {
                "safety"
            } else {
                "collision"
            },
        ),
        ("frame", if frame == "cart" { "cartesian" } else { "ego" }),
        (
            "techniques",
            match technique {
                "ablation" => "cp",
                "cot" => "cp+cot",
                "icl" => "cp+cot+icl",
                other => other,
            },
        ),
        (
            "model",
            match engine {
                "gemini" => "recorded/gemini-1.5-pro",
                "openai" => "recorded/gpt-4o",
                _ => "recorded/deepseek-chat",
            },
        ),
    ];
    let is = |cell: &&Value| wanted.iter().all(|(key, value)| cell[*key] == *value);
    let mut found = cells.iter().filter(is);
    let cell = found.next().unwrap_or_else(|| panic!("no cell {name}"));
    assert!(found.next().is_none(), "{name}");
    cell
}

#[test]
fn the_papers_recorded_answers_are_counted_as_expected() {
    let Some(root) = folder() else { return };
    let home = Home::new();
    let ended = home.run(&["report", "--paper", root.to_str().unwrap(), "--format=json"]);
    let report: Value = serde_json::from_str(&ended.status(0).stdout).unwrap();
    let cells = report["cells"].as_array().unwrap();
    let expected = std::fs::read_to_string(root.join("EXPECTED_recorded.json")).unwrap();
    let expected: BTreeMap<String, BTreeMap<String, i64>> =
        serde_json::from_str(&expected).unwrap();
    assert!(expected.len() > 40);
    let mut differences = 0;
    for (name, wanted) in &expected {
        let cell = cell(cells, name);
        let collision = name.starts_with("collision");
        let yes = wanted["flagged"];
        let no = wanted["parsed"] - yes;
        let counts = if collision {
            [yes, 0, no, 0]
        } else {
            [0, yes, 0, no]
        };
        let unparsed = wanted["answers"] - wanted["parsed"];
        let keys = ["tp", "fp", "fn", "tn", "unparsed"];
        for (key, wanted) in keys.into_iter().zip(counts.into_iter().chain([unparsed])) {
            let found = cell[key].as_i64().unwrap();
            differences += i64::from(found != wanted);
            assert!(
                (found - wanted).abs() <= 1,
                "{name} {key}: {found}, expected {wanted}"
            );
        }
        assert_eq!(cell["n"].as_i64(), Some(wanted["answers"]), "{name}");
        let named = cell["named"].as_i64().unwrap();
        if collision {
            let wanted = wanted["named"];
            assert!(
                (named - wanted).abs() <= 1,
                "{name}: {named}, expected {wanted}"
            );
        }
    }
    println!(
        "{differences} counts differ by one, of {} cells",
        expected.len()
    );

    let rows = report["comparisons"].as_array().unwrap();
    assert_eq!(rows.len(), 28);
    // Table I, Cart and All: 12 of 100 are printed and none of 30 recorded; C(88, 30)/C(100, 30) and what is no
    // likelier add up to 0.016 (scipy 1.17, `hypergeom`).
    let all = rows.iter().find(|r| {
        r["table"] == "I" && r["frame"] == "cartesian" && r["techniques"] == "cp+cot+icl"
    });
    let found = &all.unwrap()["collisions_found"];
    assert_eq!(
        (&found["published"], &found["recorded"]),
        (&0.12.into(), &0.0.into())
    );
    assert_eq!(found["finding"], "differs");
    assert!(
        (found["p"].as_f64().unwrap() - 0.01605551813253967).abs() < 1e-6,
        "{found}"
    );
    // The judge sees the scenarios; its agreement is worked out.
    assert!(
        rows.iter()
            .all(|r| r["reference"]["tp"].as_i64() > Some(25)),
        "{rows:#?}"
    );
}

#[test]
fn an_experiment_over_the_recorded_answers_gives_the_cells_of_the_papers_tables() {
    let Some(root) = folder() else { return };
    let home = Home::new();
    let root = root.to_str().unwrap();
    let labels = format!(
        "truth = [\"{root}/Results/LLM/Scenario_Collision/ego/annotations.csv\", \
         \"{root}/Results/LLM/Senario_Normal/ego/annotation_normal.csv\"]\n"
    );
    let models = "\"recorded/gemini-1.5-pro\", \"recorded/gpt-4o\", \"recorded/deepseek-chat\"";
    let all = format!(
        "scenarios = [\"{root}/Scenarios\"]\n{labels}protocol = \"paper\"\nmodels = [{models}]\n\
         tasks = [\"collision\", \"safety\"]\nframes = [\"cartesian\", \"ego\"]\n\
         techniques = [\"base\", \"cp\", \"cp+cot\", \"all\"]\n"
    );
    // Without their answers nothing can be asked, and the reason is told; the same batch finds them later.
    let one = "scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nprotocol = \"paper\"\nmodels = [\"recorded/gpt-4o\"]\n";
    home.write("one.toml", one);
    home.run(&["evaluate", "one.toml"])
        .says(&["1 question cannot be asked", "nearmiss runs import"]);
    home.write("paper.toml", all);
    home.run(&["runs", "import", root]).status(0);
    home.run(&["evaluate", "paper.toml"]).status(0);
    let batch = home
        .run(&["report", "--batch", "b2", "--format=json"])
        .status(0);
    let batch: Value = serde_json::from_str(&batch.stdout).unwrap();
    let paper = home
        .run(&["report", "--paper", root, "--format=json"])
        .status(0);
    let paper: Value = serde_json::from_str(&paper.stdout).unwrap();
    let cells = batch["cells"].as_array().unwrap();
    let rows = paper["comparisons"].as_array().unwrap();
    let mut compared = 0;
    for row in rows.iter().filter(|row| !row["recorded"].is_null()) {
        let same = |cell: &&Value| {
            cell["label"] == "all"
                && ["task", "frame", "techniques"]
                    .iter()
                    .all(|key| cell[*key] == row[*key])
                && cell["model"] == row["model"]
        };
        let cell = cells.iter().find(same).unwrap_or_else(|| panic!("{row}"));
        for count in ["tp", "fp", "fn", "tn", "unparsed"] {
            assert_eq!(cell[count], row["recorded"][count], "{count} of {row}");
        }
        compared += 1;
    }
    assert_eq!(compared, 28);
}

fn run(n: i64, model: &str, dangerous: Option<bool>, state: RunState) -> Run {
    let said = dangerous.map(|dangerous| {
        ParsedAnswer::Verdict(Verdict {
            task: Task::Collision,
            dangerous,
            obstacles: Vec::new(),
            justification: "so".into(),
            critical: None,
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        })
    });
    let question = NewRun {
        sample: 0,
        batch: (n % 2 == 0).then(|| "even".into()),
        scenario: format!("ZAM_Made-{}_1_T-1", n % 8),
        scenario_hash: Some(format!("{:064x}", n % 8)),
        ego: "1, recorded".into(),
        task: Task::Collision,
        frame: "ego".into(),
        techniques: "cp+cot".into(),
        window: Some((3, 12)),
        model: model.into(),
        provider: "lab".into(),
        dialect: Some("openai_chat".into()),
        endpoint: "lab".into(),
        address: Some("http://127.0.0.1/v1".into()),
        template: "t.md".into(),
        template_version: None,
        template_hash: "0".repeat(64),
        messages: serde_json::json!([{ "role": "user", "content": format!("{n} {model}") }])
            .to_string(),
        parameters: "{}".into(),
        answer_schema: None,
        images: Vec::new(),
    };
    Run {
        id: RunId(0),
        created_ms: 1_700_000_000_000 + n,
        updated_ms: 1_700_000_000_000 + n,
        key: question.key(),
        origin: Origin::Asked,
        source: None,
        question,
        answer: "{\"collision\": true, \"obstacles\": [], \"justification\": \"read again\"}"
            .into(),
        reasoning: String::new(),
        verdict_json: said.as_ref().map(|s| serde_json::to_string(s).unwrap()),
        ending: Ending {
            verdict: said,
            consumed: Consumed {
                duration_ms: Some(1000 * (n as u64 + 1)),
                ..Consumed::default()
            },
            ..Ending::bare(state)
        },
        tool_rounds: None,
        most_usd: None,
        notes: String::new(),
        pinned: false,
        deleted_ms: None,
    }
}

/// Eight scenarios, the odd ones collide: three hits and a miss, two false alarms, an answer without a verdict and a
/// failure; one run that was cancelled; and another model that is right about one.
fn filled(home: &Home) -> PathBuf {
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    let says = [
        Some(true),
        Some(true),
        Some(true),
        Some(true),
        None,
        Some(true),
        None,
        Some(false),
    ];
    let mut runs: Vec<Run> = (0..)
        .zip(says)
        .map(|(n, said)| run(n, "lab/x", said, RunState::Answered))
        .collect();
    runs[6].ending.state = RunState::Failed;
    runs[6].answer.clear();
    runs.push(run(8, "lab/x", None, RunState::Cancelled));
    runs.push(run(9, "lab/y", Some(true), RunState::Answered));
    assert_eq!(store.add(&runs).unwrap(), 10);
    let labels: String = (0..8)
        .map(|n| format!("ZAM_Made-{n}_1_T-1,{}\n", n % 2))
        .collect();
    home.write("truth.csv", format!("scenario,label\n{labels}"))
}

fn json(home: &Home, arguments: &[&str]) -> Value {
    let ended = home.run(&[&["report", "--format=json"], arguments].concat());
    serde_json::from_str(&ended.status(0).stdout).unwrap()
}

fn counts(report: &Value, model: &str) -> Vec<i64> {
    let cells = report["cells"].as_array().unwrap();
    let all = cells
        .iter()
        .find(|c| c["label"] == "all" && c["model"] == model)
        .unwrap();
    let keys = [
        "n",
        "tp",
        "fp",
        "fn",
        "tn",
        "unparsed",
        "failed",
        "unlabelled",
    ];
    keys.map(|key| all[key].as_i64().unwrap()).to_vec()
}

#[test]
fn runs_of_the_store_are_counted_once_each() {
    let home = Home::new();
    home.run(&["report"]).status(1).says(&["no matching runs"]);
    filled(&home);
    let report = json(&home, &["--truth", "truth.csv"]);
    // The cancelled one counts as not asked.
    assert_eq!(counts(&report, "lab/x"), [9, 3, 2, 1, 0, 1, 1, 0]);
    assert_eq!(counts(&report, "lab/y"), [1, 1, 0, 0, 0, 0, 0, 0]);
    assert!(report["batch"].is_null() && report["asked"].is_null());
    assert_eq!(report["truth"]["words"], "truth.csv");
    // Who left out much stands first.
    let note = |at: usize| report["notes"][at].as_str().unwrap();
    assert!(
        note(0).starts_with("Without a verdict") && note(0).contains(": 2 of 8 (25 %)"),
        "{}",
        note(0)
    );
    assert!(note(1).starts_with("10 runs"), "{}", note(1));
    let pair = &report["pairs"][0];
    assert_eq!((&pair["differs"], &pair["n"]), (&"model".into(), &1.into()));
    // What was stored counts, unless it is to be read again: then every whole answer says yes.
    let again = json(&home, &["--truth", "truth.csv", "--reread"]);
    assert_eq!(counts(&again, "lab/x"), [9, 4, 3, 0, 0, 0, 1, 0]);
    let even = json(
        &home,
        &[
            "--truth",
            "truth.csv",
            "--batch",
            "even",
            "--runs",
            "model:/x",
        ],
    );
    assert_eq!(counts(&even, "lab/x"), [5, 0, 2, 0, 0, 1, 1, 0]);
    // The truth is unknown: every verdict is counted, and none is right or wrong.
    let unknown = home.run(&["report", "--format=json"]).status(0);
    assert!(
        unknown
            .stderr
            .contains("no ground truth for 10 answers about 8 scenarios"),
        "{}",
        unknown.stderr
    );
    assert!(
        unknown
            .stderr
            .contains("1 question running, cancelled or interrupted; counted as not asked"),
        "{}",
        unknown.stderr
    );
    let unknown: Value = serde_json::from_str(&unknown.stdout).unwrap();
    assert_eq!(counts(&unknown, "lab/x"), [9, 0, 0, 0, 0, 1, 1, 6]);
}

#[test]
fn every_format_is_written_whole_or_not_at_all() {
    let home = Home::new();
    filled(&home);
    let report = |more: &[&str]| home.run(&[&["report", "--truth", "truth.csv"], more].concat());
    let markdown = report(&[]).status(0).stdout;
    // Three of five: too few for an interval, and the report says so.
    for words in ["|      0.60 |", "Below 10 scenarios no interval"] {
        assert!(markdown.contains(words), "{words}: {markdown}");
    }
    for (name, begin) in [
        ("r.md", "# Accuracy"),
        ("r.tex", "% Accuracy"),
        ("r.csv", "label,task,"),
        ("r.json", "{\"schema_version\":2,\"cells\":["),
        ("r.html", "<!doctype html>"),
    ] {
        report(&["-o", name]).status(0);
        let text = std::fs::read_to_string(home.files().join(name)).unwrap();
        assert!(text.starts_with(begin), "{name}: {text}");
        report(&["-o", name]).status(2).says(&["--overwrite"]);
        report(&["-o", name, "--overwrite"]).status(0);
    }
    let table = std::fs::read_to_string(home.files().join("r.csv")).unwrap();
    assert!(
        table.lines().next().unwrap().ends_with(",batch,truth"),
        "{table}"
    );
    assert!(
        table.lines().nth(1).unwrap().ends_with(",,truth.csv"),
        "{table}"
    );
    // A table of cells has no place for pairs, and says where they go.
    report(&["-o", "r.csv", "--overwrite"])
        .status(0)
        .says(&["comparisons", "--pairs FILE"]);
    let with = ["-o", "q.csv", "--pairs", "pairs.csv"];
    let ended = report(&with).status(0);
    assert!(!ended.stderr.contains("--pairs"), "{}", ended.stderr);
    let pairs = std::fs::read_to_string(home.files().join("pairs.csv")).unwrap();
    assert!(pairs.starts_with("first.task,first.frame,"), "{pairs}");
    assert_eq!(pairs.lines().count(), 2, "{pairs}");
    std::fs::remove_file(home.files().join("q.csv")).unwrap();
    report(&with).status(2).says(&["pairs.csv", "--overwrite"]);
    assert!(!home.files().join("q.csv").exists(), "both or none");
    report(&["-o", "p.csv", "--pairs", "p.csv"])
        .status(2)
        .says(&["--pairs", "another file"]);
    report(&["--overwrite"]).status(2).says(&["-o FILE"]);
    report(&["-o", "r.docx"]).status(2).says(&[".html"]);
    home.run(&["report", "--truth", "nowhere.csv"])
        .status(2)
        .says(&["nowhere.csv"]);
    home.run(&["report", ".", "--runs", "model:x"])
        .status(2)
        .says(&["filters apply to"]);
    // One mistake, one error: what, where, and what to do.
    for (folder, what) in [(".", "no recorded answers"), ("nowhere", "no such folder")] {
        for arguments in [vec!["report", folder], vec!["report", "--paper", folder]] {
            let ended = home.run(&arguments).status(2);
            assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
            ended.says(&[folder, what, "Results/output_validation"]);
        }
    }
}
