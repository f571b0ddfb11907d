//! Tests that unstored answers come back, each once.

#![allow(clippy::unwrap_used)]
use super::*;
use crate::{Claim, RunState};
use nearmiss_scene::verdict::Task;

fn question() -> NewRun {
    let text = |s: &str| s.to_string();
    NewRun {
        sample: 0,
        batch: None,
        scenario: text("ZAM_A-1"),
        scenario_hash: None,
        ego: text("1"),
        task: Task::Collision,
        frame: text("ego"),
        techniques: text("base"),
        window: None,
        model: text("lab/x"),
        provider: text("lab"),
        dialect: Some(text("openai_chat")),
        endpoint: text("lab"),
        address: Some(text("http://127.0.0.1/v1")),
        template: text("t.md"),
        template_version: None,
        template_hash: text("th"),
        messages: text("[]"),
        parameters: text("{}"),
        answer_schema: None,
        images: Vec::new(),
    }
}

fn granted(store: &Store) -> RunId {
    match store.claim(&question(), false).unwrap() {
        Claim::Granted(run) => run,
        other => panic!("{other:?}"),
    }
}

fn files(folder: &Path) -> usize {
    let names = std::fs::read_dir(folder).unwrap().flatten();
    let aside = |name: &str| name.starts_with(NAME.0);
    names
        .filter(|f| aside(&f.file_name().to_string_lossy()))
        .count()
}

#[test]
fn an_answer_that_was_set_aside_ends_its_run_when_the_store_opens() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.sqlite");
    let store = Store::open(&path).unwrap();
    let run = granted(&store);
    store
        .append(run, &[AnswerPiece::Answer("the beg")])
        .unwrap();
    let ending = Ending::bare(RunState::Answered);
    let why = StoreError::Word("the disk is full".into());
    let texts = ("because", "the beginning and the end");
    let unstored = store.set_aside(run, &question(), texts, &ending, None, why);
    let words = unstored.to_string();
    assert!(
        unstored.beside && words.contains("the disk is full"),
        "{words}"
    );
    assert_eq!(files(folder.path()), 1);
    drop(store);

    let store = Store::open(&path).unwrap();
    let kept = store.run(run).unwrap().unwrap();
    assert_eq!((kept.reasoning.as_str(), kept.answer.as_str()), texts);
    assert_eq!(kept.ending.state, RunState::Answered);
    assert!(matches!(store.claim(&question(), false), Ok(Claim::Stored(found)) if found.id == run));
    assert_eq!((files(folder.path()), store.count().unwrap()), (0, 1));
}

#[test]
fn an_answer_of_another_store_is_added_once() {
    let (one, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let store = Store::open(&one.path().join("runs.sqlite")).unwrap();
    let why = StoreError::Word("locked".into());
    let ending = Ending::bare(RunState::Answered);
    let run = granted(&store);
    let rounds = Some(r#"[{"turn":{},"results":[]}]"#.to_string());
    let aside = store.set_aside(run, &question(), ("", "yes"), &ending, rounds.clone(), why);
    let file = aside.file.unwrap();
    for _ in 0..2 {
        std::fs::copy(&file, other.path().join(file.file_name().unwrap())).unwrap();
        let store = Store::open(&other.path().join("runs.sqlite")).unwrap();
        assert_eq!((files(other.path()), store.count().unwrap()), (0, 1));
        let added = store.run(RunId(1)).unwrap().unwrap();
        assert_eq!(added.tool_rounds, rounds);
    }
    // What is no answer stays, and keeps nothing from being opened.
    std::fs::write(other.path().join("unstored-1-2.jsonl"), "{}").unwrap();
    drop(Store::open(&other.path().join("runs.sqlite")).unwrap());
    assert_eq!(files(other.path()), 1);
}

#[test]
fn numbers_that_sqlite_does_not_have_cost_no_answer() {
    let store = Store::in_memory().unwrap();
    let run = granted(&store);
    let mut ending = Ending::bare(RunState::Answered);
    ending.consumed.input_tokens = Some(u64::MAX);
    ending.consumed.output_tokens = Some(34);
    ending.consumed.cost_usd = Some(f64::INFINITY);
    store
        .conclude(run, &[AnswerPiece::Answer("yes")], &ending)
        .unwrap();
    let kept = store.run(run).unwrap().unwrap();
    let consumed = kept.ending.consumed;
    assert_eq!(kept.answer, "yes");
    assert_eq!(
        (consumed.input_tokens, consumed.output_tokens),
        (None, Some(34))
    );
    assert_eq!(consumed.cost_usd, None);
}
