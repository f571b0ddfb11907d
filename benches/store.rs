//! The store with 100,000 runs, beside a plain SELECT by the primary key in the same file.
//!
//! The figures to read: `lookup/by_key` over `lookup/primary_key`, `list/newest_100` in milliseconds, and what a piece
//! of an answer costs alone (`write/append_1`) and in company (`write/append_20`).
//! `history/open` is what opening the history of runs reads: a list, its length, and the newest run whole.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group, criterion_main};
use nearmiss::store::{
    AnswerPiece, Claim, Cursor, Edge, Ending, Filter, NewRun, Origin, Run, RunId, RunState, Store,
};
use nearmiss::verdict::{ParsedAnswer, Task, Verdict};

const RUNS: i64 = 100_000;

fn question(n: i64) -> NewRun {
    let words =
        "Obstacle 301 is ahead of the ego; the longitudinal gap is 12.3 m and shrinks. ".repeat(24);
    NewRun {
        sample: 0,
        batch: None,
        scenario: format!("ZAM_Bench-{}_1_T-1", n % 211),
        scenario_hash: Some(format!("{:064x}", n % 211)),
        ego: "1, recorded in ego_trajectory.csv".into(),
        task: Task::Collision,
        frame: "ego".into(),
        techniques: "cp+cot".into(),
        window: Some((3, 12)),
        model: format!("lab/model-{}", n % 7),
        provider: "lab".into(),
        dialect: Some("openai_chat".into()),
        endpoint: "lab (http://127.0.0.1/v1/chat/completions)".into(),
        address: Some("http://127.0.0.1/v1/chat/completions".into()),
        template: "collision-ego.md".into(),
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
    let said = ParsedAnswer::Verdict(Verdict {
        task: Task::Collision,
        dangerous: n % 3 == 0,
        obstacles: Vec::new(),
        justification: format!("Obstacle {n} brakes."),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    });
    Run {
        id: RunId(0),
        created_ms: 1_700_000_000_000 + n,
        updated_ms: 1_700_000_000_000 + n,
        key: question.key(),
        origin: Origin::Replayed,
        source: None,
        answer: format!(
            "{} So obstacle {n} matters.",
            "The gap shrinks step by step. ".repeat(20)
        ),
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

fn filled(path: &Path) -> Store {
    let store = Store::open(path).expect("a store");
    for begin in (0..RUNS).step_by(1000) {
        let runs: Vec<Run> = (begin..begin + 1000).map(answered).collect();
        assert_eq!(store.add(&runs).expect("added"), runs.len());
    }
    store
}

fn reading(criterion: &mut Criterion, store: &Store, path: &Path) {
    let plain = rusqlite::Connection::open(path).expect("a database");
    let mut statement = plain
        .prepare("SELECT answer FROM runs WHERE id = ?1")
        .expect("a statement");
    let mut next = 0;
    let mut number = move || {
        next = (next + 7919) % RUNS;
        next
    };
    let mut group = criterion.benchmark_group("lookup");
    group.bench_function("primary_key", |b| {
        b.iter(|| {
            let id = number() + 1;
            let answer: String = statement.query_row([id], |row| row.get(0)).expect("a run");
            black_box(answer.len())
        });
    });
    group.bench_function("by_key", |b| {
        b.iter_batched(
            || question(number()),
            |question| {
                store
                    .answer_to(&question)
                    .expect("readable")
                    .expect("a run")
            },
            criterion::BatchSize::SmallInput,
        );
    });
    group.finish();

    let mut group = criterion.benchmark_group("list");
    group.sample_size(20);
    let newest = Filter::default();
    let of_model = Filter {
        model: Some("model-3".into()),
        ..Filter::default()
    };
    let rare = Filter {
        words: Some("obstacle 77777".into()),
        ..Filter::default()
    };
    let dangerous = Filter {
        verdict: Some(nearmiss::store::Decision::Dangerous),
        ..Filter::default()
    };
    for (name, filter) in [
        ("newest_100", newest),
        ("newest_100_of_a_model", of_model),
        ("newest_100_dangerous", dangerous),
        ("words", rare),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| store.list(&filter, 100).expect("a list"))
        });
    }
    group.bench_function("of_scenario", |b| {
        let hash = format!("{:064x}", 5);
        b.iter(|| {
            store
                .of_scenario(&hash, "", Task::Collision, 100)
                .expect("runs")
        });
    });
    group.finish();
}

/// What the workbench does when its history of runs is opened, and while one types or scrolls there.
fn history(criterion: &mut Criterion, path: &Path) {
    let mut group = criterion.benchmark_group("history");
    group.sample_size(10);
    let all = Filter::default();
    group.bench_function("open", |b| {
        b.iter(|| {
            let store = Store::open(path).expect("a store");
            let page = store.page(&all, Edge::Newest, 100).expect("a page");
            let run = RunId(page.rows[0].run);
            let run = store.run(run).expect("readable").expect("a run");
            let count = store.count_to(&all, u64::MAX).expect("a count");
            assert_eq!((page.rows.len(), count), (100, 100_000));
            black_box(run)
        });
    });
    let store = Store::open(path).expect("a store");
    let middle = Edge::Older(Cursor {
        created_ms: 1_700_000_000_000 + RUNS / 2,
        run: RUNS / 2,
    });
    group.bench_function("page_in_the_middle", |b| {
        b.iter(|| store.page(&all, middle, 100).expect("a page"));
    });
    group.bench_function("oldest", |b| {
        b.iter(|| store.page(&all, Edge::Oldest, 100).expect("a page"));
    });
    for (name, line) in [("common_word", "obst"), ("rare_word", "77777")] {
        let filter = Filter::read(line).expect("a filter");
        group.bench_function(name, |b| {
            b.iter(|| store.page(&filter, Edge::Newest, 100).expect("a page"));
        });
    }
    group.finish();
}

fn writing(criterion: &mut Criterion, store: &Store) {
    let Claim::Granted(run) = store.claim(&question(-1), true).expect("a claim") else {
        panic!("fresh questions are granted");
    };
    let token = [AnswerPiece::Answer(" obstacle")];
    let tokens = [AnswerPiece::Answer(" obstacle"); 20];
    let mut group = criterion.benchmark_group("write");
    group.bench_function("append_1", |b| {
        b.iter(|| store.append(run, &token).expect("kept"))
    });
    group.bench_function("append_20", |b| {
        b.iter(|| store.append(run, &tokens).expect("kept"))
    });
    group.sample_size(20);
    let ending = Ending::bare(RunState::Answered);
    group.bench_function("begin_append_finish", |b| {
        b.iter(|| {
            let Claim::Granted(run) = store.claim(&question(-2), true).expect("a claim") else {
                panic!("fresh questions are granted");
            };
            store.append(run, &tokens).expect("kept");
            store.finish(run, &ending).expect("kept");
        });
    });
    group.finish();
}

fn all(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("runs.sqlite");
    let begun = std::time::Instant::now();
    let store = filled(&path);
    let megabytes = path.metadata().map_or(0, |data| data.len()) / 1_000_000;
    println!(
        "{RUNS} runs, {megabytes} MB, added in {:.1} s",
        begun.elapsed().as_secs_f64()
    );
    reading(criterion, &store, &path);
    history(criterion, &path);
    writing(criterion, &store);
}

criterion_group!(benches, all);
criterion_main!(benches);
