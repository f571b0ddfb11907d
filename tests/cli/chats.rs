//! Right answers as chats for fine-tuning: which, in which file, and with which origin.

use std::collections::BTreeSet;
use std::path::PathBuf;

use nearmiss::evaluation::batch::Split;
use nearmiss::evaluation::claims;
use nearmiss::store::{
    ClaimCounts, Ending, NewRun, Origin, Run, RunId, RunState, SplitPart, Store,
};
use nearmiss::verdict::{CriticalObstacle, ParsedAnswer, Task, Verdict};
use serde_json::{Value, json};

use super::support::program::Home;

/// An answer about a map of its own: a yes that names obstacle 7, with one right claim.
pub fn answer(n: i64) -> Run {
    let verdict = Verdict {
        task: Task::Safety,
        dangerous: true,
        obstacles: Vec::new(),
        justification: "so".into(),
        critical: Some(vec![CriticalObstacle::new(7)]),
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    };
    let messages = json!([
        { "role": "system", "content": "You are an expert." },
        { "role": "user", "content": format!("question {n}: \u{202e}ü") },
    ]);
    let question = NewRun {
        sample: 0,
        batch: None,
        scenario: format!("ZAM_Made-{n}_1_T-1"),
        scenario_hash: Some(format!("{n:064x}")),
        ego: "1, recorded".into(),
        task: Task::Safety,
        frame: "ego".into(),
        techniques: "base".into(),
        window: Some((3, 12)),
        model: "lab/x".into(),
        provider: "lab".into(),
        dialect: Some("openai_chat".into()),
        endpoint: "lab".into(),
        address: Some("http://127.0.0.1/v1".into()),
        template: "safety-ego.md".into(),
        template_version: None,
        template_hash: "0".repeat(64),
        messages: messages.to_string(),
        parameters: "{}".into(),
        answer_schema: None,
        images: Vec::new(),
    };
    let said = ParsedAnswer::Verdict(verdict);
    Run {
        id: RunId(0),
        created_ms: 1_700_000_000_000 + n,
        updated_ms: 1_700_000_000_000 + n,
        key: question.key(),
        origin: Origin::Asked,
        source: None,
        question,
        answer: "{\"safety_critical\": true}".into(),
        reasoning: format!("thought {n}"),
        verdict_json: Some(serde_json::to_string(&said).unwrap()),
        ending: Ending {
            verdict: Some(said),
            claims: ClaimCounts {
                claims_right: Some(1),
                claims_wrong: Some(0),
                claims_open: Some(0),
                claims_check: Some(claims::CHECK),
                ..ClaimCounts::default()
            },
            ..Ending::bare(RunState::Answered)
        },
        tool_rounds: None,
        most_usd: None,
        notes: String::new(),
        pinned: false,
        deleted_ms: None,
    }
}

/// Sixty right answers, and one of each kind that is no example.
fn filled(home: &Home) -> PathBuf {
    let mut runs: Vec<Run> = (0..60).map(answer).collect();
    runs[7].ending.claims.claims_right = Some(0);
    let mut add = |n: i64, change: &dyn Fn(&mut Run)| {
        let mut run = answer(n);
        change(&mut run);
        run.key = run.question.key();
        runs.push(run);
    };
    // Labelled safe, another obstacle, and without a label.
    add(100, &|_| ());
    add(101, &|_| ());
    add(102, &|_| ());
    add(103, &|run| run.ending.claims.claims_wrong = Some(2));
    add(104, &|run| run.ending.claims = ClaimCounts::default());
    add(105, &|run| {
        (run.ending.verdict, run.verdict_json) = (None, None);
    });
    add(106, &|run| run.ending.state = RunState::Truncated);
    add(107, &|run| run.question.task = Task::Trajectory);
    add(108, &|run| run.question.model = "reference/geometry".into());
    add(109, &|run| run.question.messages = "[]".into());
    add(110, &|run| run.tool_rounds = Some("[]".into()));
    // The same as one of the others, by another way of sampling.
    add(5, &|run| run.question.sample = 1);
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    assert_eq!(store.add(&runs).unwrap(), runs.len());
    let mut labels = String::from("scenario,label,obstacle_id\n");
    for n in (0..60).chain(103..111) {
        labels.push_str(&format!("ZAM_Made-{n}_1_T-1,critical,7\n"));
    }
    labels.push_str("ZAM_Made-100_1_T-1,safe,\nZAM_Made-101_1_T-1,critical,8\n");
    home.write("truth.csv", labels)
}

pub fn read(home: &Home, file: &str) -> String {
    std::fs::read_to_string(home.files().join(file)).unwrap()
}

#[test]
fn right_answers_become_chats_split_by_map_with_their_origin_beside_them() {
    let home = Home::new();
    filled(&home);
    let export = [
        "runs",
        "export",
        "--format",
        "chat",
        "--truth",
        "truth.csv",
        "-o",
        "chats",
        "--validation",
        "0.3",
    ];
    let ended = home.run(&export).status(0);
    ended.says(&[
        "left out 1 answer with a wrong verdict",
        "left out 1 answer that name none of the critical obstacles",
        "left out 1 answer without a known truth",
        "left out 1 answer with wrong claims",
        "left out 1 answer with unchecked claims",
        "left out 2 answers without a whole answer or a verdict",
        "left out 1 answer to tasks without a yes or no",
        "left out 1 answer of the built-in judge",
        "left out 1 answer without stored messages",
        "left out 1 answer that repeat another one",
    ]);
    let manifest: Value = serde_json::from_str(&read(&home, "chats/manifest.json")).unwrap();
    let split = Split {
        test: 0.3,
        seed: Split::SEED,
    };
    let mut all = BTreeSet::new();
    for (place, (file, part)) in [
        ("train.jsonl", SplitPart::Dev),
        ("validation.jsonl", SplitPart::Test),
    ]
    .into_iter()
    .enumerate()
    {
        let text = read(&home, &format!("chats/{file}"));
        let described = &manifest["files"][place];
        assert_eq!(described["file"], file);
        let runs = described["run_ids"].as_array().unwrap();
        assert_eq!(runs.len(), text.lines().count());
        assert!(!runs.is_empty());
        for (line, run) in text.lines().zip(runs) {
            let example: Value = serde_json::from_str(line).unwrap();
            // Nothing but the chat, as trainers want it, and nothing that a terminal obeys.
            assert_eq!(example.as_object().unwrap().len(), 1, "{line}");
            assert!(!line.contains('\u{202e}'), "{line}");
            let turns = example["messages"].as_array().unwrap();
            let roles: Vec<&str> = turns.iter().map(|t| t["role"].as_str().unwrap()).collect();
            assert_eq!(roles, ["system", "user", "assistant"]);
            let n = run.as_i64().unwrap() - 1;
            assert_eq!(turns[1]["content"], format!("question {n}: \u{202e}ü"));
            let told = format!("<think>\nthought {n}\n</think>\n\n{{\"safety_critical\": true}}");
            assert_eq!(turns[2]["content"], told);
            assert_eq!(split.part(&format!("ZAM_Made-{n}_1_T-1")), part);
            assert!(all.insert(n), "each once");
        }
    }
    assert_eq!(all, (0..60).collect());
    assert_eq!(manifest["left_out"]["wrong_claims"], 1);
    assert_eq!(manifest["left_out"]["tools"], 1);
    let files = manifest["files"].as_array().unwrap().iter();
    let without = files.map(|file| file["without_claims"].as_u64().unwrap());
    assert_eq!(without.sum::<u64>(), 1);
    assert_eq!(manifest["truth"], "truth.csv");
    assert!(manifest["provenance"]["models"]["lab/x"].is_array());
    let schema = home.run(&["help", "json", "--schema", "runs-export-chat"]);
    let schema: Value = serde_json::from_str(&schema.status(0).stdout).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let errors: Vec<String> = validator
        .iter_errors(&manifest)
        .map(|error| error.to_string())
        .collect();
    assert!(errors.is_empty(), "{errors:?}");
    // The same answers give the same files, and nothing is replaced unasked.
    let before = read(&home, "chats/train.jsonl");
    home.run(&export).status(2).says(&["--overwrite"]);
    home.run(&[&export[..], &["--overwrite"]].concat())
        .status(0);
    assert_eq!(read(&home, "chats/train.jsonl"), before);
}

/// An answer as `import` reads them from published tables: right, but its question is not known.
#[test]
fn answers_without_messages_are_no_examples_and_nothing_is_written_of_them() {
    let home = Home::new();
    let mut run = answer(1);
    run.question.messages = "[]".into();
    run.key = run.question.key();
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    store.add(&[run]).unwrap();
    drop(store);
    home.write(
        "truth.csv",
        "scenario,label,obstacle_id\nZAM_Made-1_1_T-1,critical,7\n",
    );
    let export = ["runs", "export", "--format", "chat", "-o", "chats"];
    let none = home.run(&export).status(1);
    none.says(&["nothing was written", "--truth CSV"]);
    let known = [&export[..], &["--truth", "truth.csv"]].concat();
    let none = home.run(&known).status(1);
    none.says(&[
        "left out 1 answer without stored messages",
        "nothing was written",
        "can never be examples",
    ]);
    assert!(!home.files().join("chats").exists());
}

#[test]
fn wrong_claims_reasoning_and_the_split_are_chosen() {
    let home = Home::new();
    filled(&home);
    let export = |folder: &str, more: &[&str]| {
        let asked = [
            "runs",
            "export",
            "--format",
            "chat",
            "--truth",
            "truth.csv",
            "-o",
            folder,
        ];
        home.run(&[&asked[..], more].concat())
    };
    let more = [
        "--allow-wrong-claims",
        "2",
        "--validation",
        "0",
        "--reasoning",
    ];
    export("field", &[&more[..], &["field"]].concat()).status(0);
    export("none", &[&more[..], &["none"]].concat()).status(0);
    let field = read(&home, "field/train.jsonl");
    assert_eq!(field.lines().count(), 61);
    assert_eq!(read(&home, "field/validation.jsonl"), "");
    assert!(field.contains("\"reasoning_content\":\"thought 3\"") && !field.contains("<think>"));
    assert!(!read(&home, "none/train.jsonl").contains("thought"));
    // What cannot be is said, and nothing is written.
    export("x", &["model:lab/other"])
        .status(1)
        .says(&["no answer can be an example"]);
    export("x", &["--reasoning", "aloud"])
        .status(2)
        .says(&["aloud", "think"]);
    export("truth.csv", &[])
        .status(2)
        .says(&["truth.csv", "is a file"]);
    home.run(&["runs", "export", "--format", "chat"])
        .status(2)
        .says(&["-o FOLDER"]);
    home.run(&["runs", "export", "--validation", "0.5"])
        .status(2)
        .says(&["--format chat"]);
    assert!(!home.files().join("x").exists());
}
