//! Stored answers beside new ones.

use super::answers::{asking, stored_of};
use super::bench::{Bench, answer, no_verdict};
use super::events;
use crate::features::answers::{Ask, LoadStored};
use crate::message::{Effect, Msg};
use crate::model::ShownAnswer;
use nearmiss_store::{Origin, RunId};
use nearmiss_study::evaluation::{Answer, JudgeOutcome, MissingVerdict, StoredOrigin};

#[test]
fn shift_r_asks_anew_and_an_answer_of_the_store_says_so() {
    let mut bench = asking();
    bench.press("shift-r");
    let fresh = |bench: &Bench| match bench.effects.last().and_then(Effect::request) {
        Some(Ask { fresh, .. }) => *fresh,
        other => panic!("{other:?}"),
    };
    assert!(fresh(&bench));
    bench.press("r");
    assert!(!fresh(&bench));
    let (id, _) = bench.asked();
    let past = StoredOrigin {
        created_ms: 0,
        origin: Origin::Asked,
        sample: 0,
    };
    let stored = Answer {
        run: Some(RunId(7)),
        past: Some(past),
        ..answer("lab/small", true, 301)
    };
    bench.send(events::answered(id, Ok(Box::new(stored.clone()))));
    let frame = bench.frame(120, 40);
    assert!(frame.contains("run 7, asked 19"), "{frame}");
    let columns = bench.model.answers.columns.len();
    bench.press("r");
    let (id, _) = bench.asked();
    bench.send(events::answered(id, Ok(Box::new(stored))));
    assert_eq!(
        bench.model.answers.columns.len(),
        columns,
        "the same run is shown once"
    );
    assert_eq!(bench.model.answers.column().and_then(|c| c.ask), Some(id));
}

#[test]
fn recorded_answers_of_several_models_and_ways_stand_side_by_side() {
    let mut bench = Bench::bundled();
    let of = bench
        .effects
        .iter()
        .find_map(|e| match e.request() {
            Some(LoadStored(of)) => Some(of.clone()),
            _ => None,
        })
        .unwrap();
    assert!(of.recorded && of.name.starts_with("ZAM_"));
    let past = StoredOrigin {
        created_ms: 0,
        origin: Origin::Recorded,
        sample: 0,
    };
    let ways = ["ego · base", "cartesian · cot", "ego · cp+cot+icl"];
    let stored = ways.iter().flat_map(|how| {
        ["gemini", "openai", "deepseek"].map(|name| Answer {
            past: Some(past),
            how: (*how).into(),
            window: None,
            ..answer(&format!("recorded/{name}"), true, 301)
        })
    });
    bench.send(Msg::reply::<LoadStored>((of, stored.collect())));
    assert_eq!(bench.model.answers.columns.len(), 9);
    let shows = |bench: &Bench, words: &[&str]| {
        let frame = bench.frame(200, 50);
        for word in words {
            assert!(frame.contains(word), "{word}: {frame}");
        }
    };
    let names = ["gemini", "openai", "deepse"];
    shows(&bench, &names);
    shows(
        &bench,
        &["record", "recorded by others", "all", "base", "unknown"],
    );
    bench.press("] ] ] ] ] ] ] ]");
    shows(&bench, &["cart", "cot"]);
    // Asked as it would be asked now, one of each model.
    let first = &bench.model.answers.columns[..3];
    assert!(first.iter().all(|c| c.how == "ego · cp+cot+icl"));
}

#[test]
fn runs_that_reached_no_model_do_not_come_back() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let refused = || no_verdict("lab/x", "");
    bench.send(Msg::reply::<LoadStored>((
        of.clone(),
        vec![refused(), refused()],
    )));
    assert!(bench.model.answers.columns.is_empty());
    assert_eq!(bench.model.answers.shown, ShownAnswer::Reference);
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![refused(), answer("lab/x", true, 301)],
    )));
    assert_eq!(bench.model.answers.columns.len(), 1);
    assert!(
        bench.frame(120, 40).contains("yes ="),
        "the older answer of that model is not hidden by the newer failure"
    );
}

#[test]
fn what_broke_off_does_not_hide_a_whole_answer() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let cancelled = Answer {
        judged: JudgeOutcome::Missing(MissingVerdict::Cancelled),
        text: "the beg".into(),
        ..answer("lab/a", true, 301)
    };
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![cancelled, answer("lab/a", true, 301)],
    )));
    let columns = &bench.model.answers.columns;
    assert_eq!(columns.len(), 1);
    assert!(columns[0].answer().is_some_and(Answer::arrived));
}

#[test]
fn answers_to_other_prompts_are_told_apart() {
    let mut bench = Bench::bundled();
    let of = stored_of(&bench);
    let mine = Answer {
        how: "ego · base · mine 3fa2c1".into(),
        ..answer("lab/a", true, 301)
    };
    bench.send(Msg::reply::<LoadStored>((
        of,
        vec![mine, answer("lab/a", true, 301)],
    )));
    assert_eq!(bench.model.answers.columns.len(), 2);
    let frame = bench.frame(200, 60);
    let row = frame
        .lines()
        .find(|line| line.contains("prompt    "))
        .unwrap_or_else(|| panic!("{frame}"));
    assert!(
        row.contains("mine 3fa2c1") && row.contains("shipped"),
        "{row}"
    );
    assert!(
        !frame.contains("│frame   "),
        "frame and techniques are the same: {frame}"
    );
}
