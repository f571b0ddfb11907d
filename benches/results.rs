//! The screen of results over 100,000 stored runs, from the key to the first frame that shows a number: everything in
//! the store, and the same as a batch. `NEARMISS_RUNS` says how many runs else.
//!
//! The figures to read: `open/…` in milliseconds, and the peak of the memory, which is printed.

use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use nearmiss::description::Frame;
use nearmiss::evaluation::batch::{Experiment, Spec};
use nearmiss::formats::bundled;
use nearmiss::prompts::Techniques;
use nearmiss::store::{Ending, NewItem, NewRun, Origin, Run, RunId, RunState, Store};
use nearmiss::tui::headless::Stage;
use nearmiss::verdict::{ObstacleRisk, ParsedAnswer, Task, Verdict};

const RUNS: i64 = 100_000;

/// So many scenarios and models; what is more are further samples.
const SCENARIOS: i64 = 211;
const MODELS: i64 = 7;

fn question(n: i64) -> NewRun {
    let words = "Obstacle 301 is ahead of the ego; the longitudinal gap is 12.3 m. ".repeat(24);
    NewRun {
        sample: u32::try_from(n / (SCENARIOS * MODELS)).unwrap_or(0),
        batch: None,
        scenario: format!("ZAM_Bench-{}_1_T-1", n % SCENARIOS),
        scenario_hash: Some(format!("{:064x}", n % SCENARIOS)),
        ego: "1, recorded in ego_trajectory.csv".into(),
        task: Task::Safety,
        frame: "ego".into(),
        techniques: "cp+cot".into(),
        window: Some((3, 12)),
        model: format!("lab/model-{}", n % MODELS),
        provider: "lab".into(),
        dialect: Some("openai_chat".into()),
        endpoint: "lab (http://127.0.0.1/v1/chat/completions)".into(),
        address: Some("http://127.0.0.1/v1/chat/completions".into()),
        template: "safety-ego.md".into(),
        template_version: Some("1".into()),
        template_hash: "0".repeat(64),
        messages: serde_json::json!([{ "role": "user", "content": format!("{n}: {words}") }])
            .to_string(),
        parameters: "{}".into(),
        answer_schema: None,
        images: Vec::new(),
    }
}

fn answered(n: i64) -> Run {
    let question = question(n);
    let dangerous = n % 3 == 0;
    let obstacles = (300..304).map(|id| ObstacleRisk {
        id,
        risk_score: 1,
        reason: "The gap shrinks.".into(),
        written_score: None,
    });
    let said = ParsedAnswer::Verdict(Verdict {
        task: Task::Safety,
        dangerous,
        obstacles: obstacles.collect(),
        justification: format!("Obstacle {n} brakes."),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    });
    let words = "The gap shrinks step by step. ".repeat(20);
    let json = serde_json::json!({
        "safety_critical": dangerous,
        "obstacles": [{ "id": 301, "risk_score": 1, "reason": "The gap shrinks." }],
        "justification": "It brakes.",
    });
    Run {
        id: RunId(0),
        created_ms: 1_700_000_000_000 + n,
        updated_ms: 1_700_000_000_000 + n,
        key: question.key(),
        origin: Origin::Replayed,
        source: None,
        answer: format!("{words}\n{json}"),
        reasoning: String::new(),
        verdict_json: serde_json::to_string(&said).ok(),
        ending: Ending {
            verdict: Some(said),
            ..Ending::bare(RunState::Answered)
        },
        question,
        most_usd: None,
        tool_rounds: None,
        notes: String::new(),
        pinned: false,
        deleted_ms: None,
    }
}

fn item(n: i64) -> NewItem {
    let question = question(n);
    NewItem {
        path: question.scenario.clone(),
        key: question.key(),
        scenario: question.scenario,
        scenario_hash: question.scenario_hash,
        ego: Some(question.ego),
        task: question.task,
        frame: Some(question.frame),
        techniques: Some(question.techniques),
        model: question.model,
        sample: question.sample,
        lead: None,
        window: None,
        transform: None,
        collides: Some(n % 2 == 0),
        obstacle: (n % 2 == 0).then_some(301),
        unaskable: None,
        facts: None,
        scene: None,
        settings: None,
        split: None,
    }
}

fn spec() -> String {
    let spec = Spec {
        experiment: Experiment {
            scenarios: vec!["scenarios".into()],
            tasks: vec![Task::Safety],
            frames: vec![Frame::Ego],
            techniques: vec![Techniques::ALL],
            models: (0..MODELS).map(|n| format!("lab/model-{n}")).collect(),
            ..Experiment::default()
        },
        ..Spec::default()
    };
    spec.to_json()
}

fn filled(path: &Path, runs: i64) -> Store {
    let store = Store::open(path).expect("a store");
    for begin in (0..runs).step_by(1000) {
        let runs: Vec<Run> = (begin..runs.min(begin + 1000)).map(answered).collect();
        assert_eq!(store.add(&runs).expect("added"), runs.len());
    }
    store
}

/// Megabytes that this program takes now, and took at most; nothing where the system does not say.
fn memory() -> Option<(u64, u64)> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let of = |name: &str| {
        let line = status.lines().find(|line| line.starts_with(name))?;
        let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
        Some(kilobytes / 1000)
    };
    Some((of("VmRSS:")?, of("VmHWM:")?))
}

fn stage() -> Stage {
    let entry = bundled().into_iter().next().expect("a bundled scenario");
    Stage::open(&entry, (200, 60)).unwrap_or_else(|error| panic!("{error}"))
}

fn opened(criterion: &mut Criterion, name: &str, store: &Store, runs: i64) {
    let mut stage = stage();
    let before = memory();
    stage.read_results(store);
    let screen = stage.screen();
    println!(
        "{name}: MB before {before:?}, after {:?} (now, at most)",
        memory()
    );
    println!("{}", screen.lines().take(6).collect::<Vec<_>>().join("\n"));
    let digits: String = runs.to_string();
    let bare: String = screen.chars().filter(|c| *c != ',').collect();
    assert!(bare.contains(&format!("{digits} answers")), "{screen}");
    let mut group = criterion.benchmark_group("open");
    group.sample_size(10);
    group.bench_function(name, |b| {
        b.iter(|| {
            stage.press("esc");
            stage.read_results(store);
        });
    });
    group.bench_function(format!("{name}_frame"), |b| {
        b.iter(|| {
            stage.press("right");
            stage.draw();
        });
    });
    group.finish();
}

fn all(criterion: &mut Criterion) {
    let runs = std::env::var("NEARMISS_RUNS")
        .ok()
        .map_or(RUNS, |n| n.parse().expect("NEARMISS_RUNS is a number"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("runs.sqlite");
    let store = filled(&path, runs);
    opened(criterion, "everything", &store, runs);
    let items: Vec<NewItem> = (0..runs).map(item).collect();
    store.begin_batch(&spec(), None, &items).expect("a batch");
    drop(items);
    opened(criterion, "batch", &store, runs);
}

criterion_group!(benches, all);
criterion_main!(benches);
