//! Tests of the store through its own functions.
#![allow(clippy::unwrap_used)]

mod verdicts;

use super::*;
use nearmiss_scene::verdict::{ParsedAnswer, Task, Verdict};

mod clocks;
mod long_answers;
mod pages;
mod secondary_runs;
mod truths;

pub(super) fn question() -> NewRun {
    let text = |s: &str| s.to_string();
    NewRun {
        sample: 0,
        batch: None,
        scenario: text("ZAM_A-1"),
        scenario_hash: Some(text("h")),
        ego: text("1"),
        task: Task::Collision,
        frame: text("ego"),
        techniques: text("base"),
        window: Some((3, 12)),
        model: text("local/x"),
        provider: text("local"),
        dialect: Some(text("openai_chat")),
        endpoint: text("local (http://127.0.0.1)"),
        address: Some(text("http://127.0.0.1")),
        template: text("t.md"),
        template_version: Some(text("1")),
        template_hash: text("th"),
        messages: text(r#"[{"role":"user","content":"Is it dangerous?"}]"#),
        parameters: text(r#"{"temperature":0.5}"#),
        answer_schema: None,
        images: Vec::new(),
    }
}

fn granted(store: &Store, run: &NewRun, fresh: bool) -> RunId {
    match store.claim(run, fresh).unwrap() {
        Claim::Granted(id) => id,
        other => panic!("{other:?}"),
    }
}

fn answered(store: &Store, run: &NewRun, text: &str) -> RunId {
    let id = granted(store, run, true);
    store.append(id, &[AnswerPiece::Answer(text)]).unwrap();
    let verdict = Verdict {
        task: Task::Collision,
        dangerous: true,
        obstacles: vec![],
        justification: "it brakes".into(),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    };
    let ending = Ending {
        verdict: Some(ParsedAnswer::Verdict(verdict)),
        ..Ending::bare(RunState::Answered)
    };
    store.finish(id, &ending).unwrap();
    id
}

/// Lets the claim on a run expire.
fn abandon(store: &Store, run: RunId) {
    let changed = store
        .lock()
        .execute("UPDATE claims SET until_ms = 0 WHERE run = ?1", [run.0]);
    assert_eq!(changed.unwrap(), 1);
}

#[test]
fn pieces_are_there_at_once_and_put_together_at_the_end() {
    let store = Store::in_memory().unwrap();
    let id = granted(&store, &question(), false);
    let pieces = [AnswerPiece::Reasoning("think "), AnswerPiece::Answer("a")];
    store.append(id, &pieces).unwrap();
    store.append(id, &[AnswerPiece::Answer("b")]).unwrap();
    let running = store.run(id).unwrap().unwrap();
    assert_eq!(
        (running.answer.as_str(), running.ending.state),
        ("ab", RunState::Running)
    );
    let ending = Ending {
        price_source: Some("a table".into()),
        ..Ending::bare(RunState::Answered)
    };
    store.finish(id, &ending).unwrap();
    let done = store.run(id).unwrap().unwrap();
    assert_eq!(
        (done.answer.as_str(), done.reasoning.as_str()),
        ("ab", "think ")
    );
    assert_eq!((&done.ending, &done.question), (&ending, &question()));
    let of = |hash, name, task| store.of_scenario(hash, name, task, 5).unwrap().len();
    assert_eq!(of("h", "other", Task::Collision), 1);
    assert_eq!(of("h", "ZAM_A-1", Task::Safety), 0);
    assert_eq!(
        of("other", "ZAM_A-1", Task::Collision),
        0,
        "another file of that name"
    );
}

#[test]
fn a_whole_answer_is_found_again_and_everything_else_is_not() {
    let store = Store::in_memory().unwrap();
    for state in RunState::ALL.iter().filter(|s| **s != RunState::Running) {
        let id = granted(&store, &question(), true);
        store.finish(id, &Ending::bare(*state)).unwrap();
        let found = store.claim(&question(), false).unwrap();
        match (state, found) {
            (RunState::Answered, Claim::Stored(run)) => assert_eq!(run.id, id),
            (RunState::Answered, other) => panic!("{other:?}"),
            (_, Claim::Granted(next)) => store.finish(next, &Ending::bare(*state)).unwrap(),
            (state, other) => panic!("{state:?}: {other:?}"),
        }
        store.delete(id, true).unwrap();
    }
}

#[test]
fn another_request_or_sample_is_another_question_and_the_newest_answer_counts() {
    let store = Store::in_memory().unwrap();
    answered(&store, &question(), "first");
    let newer = answered(&store, &question(), "second");
    let found = store.claim(&question(), false).unwrap();
    assert!(matches!(found, Claim::Stored(run) if run.id == newer && run.answer == "second"));
    // What people call things does not reach the server.
    let renamed = NewRun {
        scenario: "B".into(),
        model: "house/x".into(),
        ..question()
    };
    assert!(matches!(
        store.claim(&renamed, false).unwrap(),
        Claim::Stored(_)
    ));
    let text = |s: &str| s.to_string();
    for other in [
        NewRun {
            sample: 1,
            ..question()
        },
        NewRun {
            model: text("local/y"),
            ..question()
        },
        NewRun {
            address: Some(text("http://b")),
            ..question()
        },
        NewRun {
            dialect: Some(text("gemini")),
            ..question()
        },
        NewRun {
            messages: text("[]"),
            ..question()
        },
        NewRun {
            parameters: text(r#"{"temperature":0.6}"#),
            ..question()
        },
        NewRun {
            answer_schema: Some(text("{}")),
            ..question()
        },
    ] {
        granted(&store, &other, false);
    }
    // The built-in judge is asked over no network.
    let built_in = NewRun {
        dialect: None,
        address: None,
        ..question()
    };
    answered(&store, &built_in, "a");
    granted(&store, &built_in, false);
}

#[test]
fn two_that_ask_the_same_ask_once_and_a_killed_one_is_interrupted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.sqlite");
    let (a, b) = (Store::open(&path).unwrap(), Store::open(&path).unwrap());
    let id = granted(&a, &question(), false);
    a.append(id, &[AnswerPiece::Answer("so far ")]).unwrap();
    assert_eq!(b.claim(&question(), false).unwrap(), Claim::Taken(id));
    abandon(&a, id);
    let c = Store::open(&path).unwrap();
    let killed = c.run(id).unwrap().unwrap();
    assert_eq!(killed.ending.state, RunState::Interrupted);
    assert_eq!(killed.answer, "so far ");
    let again = granted(&b, &question(), false);
    // It was only asleep: nothing of it is lost.
    a.append(id, &[AnswerPiece::Answer("and on")]).unwrap();
    assert_eq!(a.run(id).unwrap().unwrap().ending.state, RunState::Running);
    a.finish(id, &Ending::bare(RunState::Answered)).unwrap();
    assert_eq!(a.run(id).unwrap().unwrap().answer, "so far and on");
    assert_ne!(again, id);
}

#[test]
fn the_last_piece_and_the_end_are_written_together_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.sqlite");
    let store = Store::open(&path).unwrap();
    let id = granted(&store, &question(), false);
    store.append(id, &[AnswerPiece::Answer("almost ")]).unwrap();
    let (last, ending) = (
        [AnswerPiece::Answer("whole")],
        Ending::bare(RunState::Answered),
    );
    let breaks = "CREATE TEMP TRIGGER breaks BEFORE UPDATE OF state ON main.runs
        BEGIN SELECT RAISE(ABORT, 'as if it were killed here'); END";
    store.lock().execute_batch(breaks).unwrap();
    assert!(store.conclude(id, &last, &ending).is_err());
    let left = store.run(id).unwrap().unwrap();
    assert_eq!(
        (left.answer.as_str(), left.ending.state),
        ("almost ", RunState::Running)
    );
    store.lock().execute_batch("DROP TRIGGER breaks").unwrap();
    store.conclude(id, &last, &ending).unwrap();
    // The next program after one that was killed right now finds the answer.
    drop(store);
    let next = Store::open(&path).unwrap();
    let found = next.claim(&question(), false).unwrap();
    assert!(matches!(found, Claim::Stored(run) if run.answer == "almost whole"));
}

#[test]
fn two_programs_share_a_file_and_those_of_other_versions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep/runs.sqlite");
    let (a, b) = (Store::open(&path).unwrap(), Store::open(&path).unwrap());
    let id = granted(&a, &question(), false);
    assert!(b.run(id).unwrap().is_some());
    a.lock().pragma_update(None, "user_version", 99).unwrap();
    assert!(matches!(
        Store::open(&path),
        Err(StoreError::Newer { found: 99, .. })
    ));
    a.lock().pragma_update(None, "user_version", 12).unwrap();
    assert!(matches!(
        Store::open(&path),
        Err(StoreError::Older { found: 12, .. })
    ));
}

#[test]
fn a_record_is_the_run_again_and_a_changed_one_is_refused() {
    let store = Store::in_memory().unwrap();
    let id = answered(&store, &question(), "an \"answer\"\n");
    store.note(id, "odd").unwrap();
    let run = store.run(id).unwrap().unwrap();
    let line = record_line(&run.to_record(true)).unwrap();
    assert!(line.contains("\"answer_state\":\"superseded\""));
    let back = Run::from_record(&line).unwrap();
    let replayed = Run {
        origin: Origin::Replayed,
        ..run.clone()
    };
    assert_eq!(back, replayed);
    assert_eq!(
        store.add(std::slice::from_ref(&back)).unwrap(),
        0,
        "it is there"
    );
    let other = Store::in_memory().unwrap();
    assert_eq!(other.add(&[back.clone(), back.clone()]).unwrap(), 1);
    let found = other.claim(&question(), false).unwrap();
    assert!(
        matches!(found, Claim::Stored(run) if run.origin == Origin::Replayed && run.notes == "odd")
    );
    let changed = line.replace("0.5", "0.7");
    assert!(matches!(Run::from_record(&changed), Err(RecordError::Key)));
    let newer = line.replace("\"nearmiss_run\":5", "\"nearmiss_run\":6");
    assert!(matches!(
        Run::from_record(&newer),
        Err(RecordError::Newer(6, 5))
    ));
    let odd = line.replace("\"answered\"", "\"pondering\"");
    let error = Run::from_record(&odd).unwrap_err().to_string();
    assert!(error.contains("unknown state `pondering`"), "{error}");
    assert!(Run::from_record("{}").is_err() && Run::from_record("hello").is_err());
}

#[test]
fn lists_are_narrowed_down_by_words_and_columns() {
    let store = Store::in_memory().unwrap();
    let a = answered(&store, &question(), "The car in front brakes hard.");
    let other = NewRun {
        scenario: "ZAM_Merge-1".into(),
        model: "lab/big".into(),
        ..question()
    };
    answered(&store, &other, "Nothing OR anything \"quoted\"");
    let runs = |filter: Filter| {
        let found = store.list(&filter, 10).unwrap();
        assert_eq!(found.len(), store.numbers(&filter).unwrap().len());
        found.into_iter().map(|s| s.run).collect::<Vec<_>>()
    };
    let words = |words: &str| {
        runs(Filter {
            words: Some(words.into()),
            ..Filter::default()
        })
    };
    assert_eq!(runs(Filter::default()), [2, 1], "the newest first");
    assert_eq!(words("BRAK front"), [1]);
    assert_eq!(words("\"quoted"), [2]);
    assert_eq!(words("OR AND"), [] as [i64; 0]);
    assert_eq!(words("ZAM_Merge-1"), [2]);
    let excerpt = store
        .list(
            &Filter {
                words: Some("hard".into()),
                ..Filter::default()
            },
            1,
        )
        .unwrap();
    assert_eq!(
        excerpt[0].excerpt.as_deref(),
        Some("The car in front brakes [hard].")
    );
    assert_eq!(
        runs(Filter {
            model: Some("BIG".into()),
            ..Filter::default()
        }),
        [2]
    );
    assert_eq!(
        runs(Filter {
            scenario: Some("a-1".into()),
            ..Filter::default()
        }),
        [1]
    );
    assert_eq!(
        runs(Filter {
            verdict: Some(Decision::Dangerous),
            ..Filter::default()
        }),
        [2, 1]
    );
    assert!(
        runs(Filter {
            verdict: Some(Decision::Safe),
            ..Filter::default()
        })
        .is_empty()
    );
    assert!(
        runs(Filter {
            state: Some(StateFilter::Stored(RunState::Failed)),
            ..Filter::default()
        })
        .is_empty()
    );
    assert!(
        runs(Filter {
            before_ms: Some(5),
            ..Filter::default()
        })
        .is_empty()
    );
    store.pin(a, true).unwrap();
    assert!(matches!(store.delete(a, true), Err(StoreError::Pinned(id)) if id == a));
    store.pin(a, false).unwrap();
    store.delete(a, true).unwrap();
    assert_eq!(runs(Filter::default()), [2]);
    assert_eq!(
        runs(Filter {
            deleted: true,
            ..Filter::default()
        }),
        [1]
    );
    store.delete(a, false).unwrap();
    assert_eq!(runs(Filter::default()), [2, 1]);
    assert!(matches!(
        store.pin(RunId(9), true),
        Err(StoreError::NoRun(RunId(9)))
    ));
}

#[test]
fn the_view_speaks_plain_words() {
    let store = Store::in_memory().unwrap();
    answered(&store, &question(), "a");
    let sql = "SELECT scenario||' '||dangerous||' '||justification||' '||state FROM answers";
    let words: String = store.lock().query_row(sql, [], |row| row.get(0)).unwrap();
    assert_eq!(words, "ZAM_A-1 yes it brakes answered");
}
