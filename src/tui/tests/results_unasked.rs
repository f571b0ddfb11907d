//! The results screen with questions that were not or cannot be asked.

use super::counted::{YES, item, labelled, spec};
use super::history_store::{FIRST, Fixture};
use super::results::{counts, press};
use crate::action::Scope;
use nearmiss_store::{BatchId, ItemState, NewItem, SplitPart};
use nearmiss_study::evaluation::batch::{AnswerSet, BatchPart, Experiment, Spec, Split};

/// An older batch with an answer, a question that waits and one that cannot be asked; and a newer one in which nothing
/// can be asked.
fn two() -> (Fixture, [BatchId; 2]) {
    let mut kept = Fixture::new();
    let run = kept.add(FIRST, "lab/small", true, YES);
    let none = |scenario: &str| NewItem {
        unaskable: Some("no recorded ego".into()),
        ..item(scenario, (true, None), None)
    };
    let older = [
        item(FIRST, (false, None), None),
        item("ZAM_Waits-1_1_T-1", (true, None), None),
        none("ZAM_Never-1_1_T-1"),
    ];
    let begin = |items: &[NewItem]| kept.store.begin_batch(&spec().to_json(), None, items);
    let batches = [
        begin(&older).unwrap(),
        begin(&[none("ZAM_Never-2_1_T-1")]).unwrap(),
    ];
    let state = ItemState::Answered;
    let set = kept
        .store
        .set_item(batches[0], 0, None, state, Some(run), None);
    set.unwrap();
    (kept, batches)
}

#[test]
fn what_was_not_asked_is_no_answer_and_the_newest_batch_with_answers_opens() {
    let (mut kept, [older, newer]) = two();
    press(&mut kept, "space o r");
    let results = &kept.bench.model.results;
    assert_eq!(
        results.counting,
        Some(AnswerSet::Batch(older, BatchPart::Plain))
    );
    assert_eq!((results.rows.len(), results.unasked), (1, 2));
    assert_eq!(counts(&kept, 0), [0, 1, 0, 0, 0, 0, 0]);
    let frame = kept.bench.frame(200, 60);
    assert!(frame.contains("2 questions not asked"), "{frame}");
    press(&mut kept, "b");
    let frame = kept.bench.frame(200, 60);
    // The same numbers as of `evaluate list`.
    for (batch, _) in kept.store.batches().unwrap() {
        let name = format!("batch {}  ", batch.id);
        let mut lines = frame.lines();
        let line = lines.find(|l| l.contains(&name) && l.contains(" of "));
        let done = if batch.id == older {
            "1 of 3"
        } else {
            "0 of 1"
        };
        assert!(line.unwrap().contains(done), "{frame}");
    }
    kept.bench.model.results.choosing = None;
    kept.bench.model.results.chosen = Some(AnswerSet::Batch(newer, BatchPart::Plain));
    press(&mut kept, "esc space o r");
    let results = &kept.bench.model.results;
    assert_eq!((results.rows.len(), results.unasked), (0, 1));
    let frame = kept.bench.frame(80, 24);
    assert!(frame.contains("1 not asked"), "{frame}");
}

#[test]
fn who_does_not_name_the_obstacle_is_told_apart() {
    let (mut kept, ..) = labelled();
    press(&mut kept, "space o r");
    let results = &kept.bench.model.results;
    assert_eq!(counts(&kept, 0)[..4], [1, 1, 1, 0], "a yes is a yes");
    let naming = results.rows[0].naming();
    assert_eq!((naming.windows, naming.found), (1, 0));
    let frame = kept.bench.frame(200, 60);
    let head = frame.lines().position(|line| line.contains("names right"));
    let row = frame.lines().nth(head.unwrap() + 1).unwrap();
    let numbers: Vec<&str> = row
        .trim_end_matches(['│', '┃', ' '])
        .split_whitespace()
        .collect();
    // The claims of answers that a test wrote were not checked.
    assert_eq!(numbers[numbers.len() - 3..], ["0.00", "0.00", "–"], "{row}");
    assert!(!kept.bench.frame(80, 24).contains("names right"));
    press(&mut kept, "right enter");
    let frame = kept.bench.frame(80, 24);
    assert_eq!(
        frame.matches("yes, obstacle not named").count(),
        1,
        "{frame}"
    );
}

#[test]
fn the_help_on_this_screen_begins_with_its_keys() {
    let (mut kept, ..) = labelled();
    press(&mut kept, "space o r");
    press(&mut kept, "?");
    let frame = kept.bench.frame(80, 24);
    let all = Scope::ALL.iter();
    let (_, _, name) = all
        .clone()
        .find(|(scope, ..)| *scope == Scope::Results)
        .unwrap();
    let at = |name: &str| frame.find(name);
    assert!(at(name).is_some(), "{frame}");
    let (_, _, first) = all.clone().next().unwrap();
    assert!(
        at(first).is_none_or(|first| at(name) < Some(first)),
        "{frame}"
    );
}

#[test]
fn of_a_locked_test_split_the_progress_is_shown_and_when_complete_its_figures() {
    let mut kept = Fixture::new();
    let run = kept.add(FIRST, "lab/small", true, YES);
    let of = |scenario: &str, part| NewItem {
        split: Some(part),
        ..item(scenario, (true, None), None)
    };
    let items = [
        of("ZAM_Dev-1_1_T-1", SplitPart::Dev),
        of(FIRST, SplitPart::Test),
        of("ZAM_Waits-1_1_T-1", SplitPart::Test),
    ];
    let spec = Spec {
        experiment: Experiment {
            split: Some(Split { test: 0.5, seed: 1 }),
            ..spec().experiment
        },
        ..spec()
    };
    let batch = kept
        .store
        .begin_batch(&spec.to_json(), None, &items)
        .unwrap();
    let answered = |kept: &Fixture, place: u64, run| {
        let state = ItemState::Answered;
        let set = kept.store.set_item(batch, place, None, state, run, None);
        set.unwrap();
    };
    answered(&kept, 1, Some(run));
    let chosen = |part| Some(AnswerSet::Batch(batch, BatchPart::Split(part)));
    press(&mut kept, "space o r");
    assert_eq!(
        kept.bench.model.results.counting,
        chosen(SplitPart::Dev),
        "dev comes first"
    );
    kept.bench.model.results.chosen = chosen(SplitPart::Test);
    press(&mut kept, "esc space o r");
    assert!(kept.bench.model.results.rows.is_empty());
    let frame = kept.bench.frame(160, 24);
    assert!(
        frame.contains("test split: 1 of 2 answered, locked"),
        "{frame}"
    );
    kept.bench.model.results.chosen = Some(AnswerSet::Everything);
    press(&mut kept, "esc space o r");
    assert!(
        kept.bench.model.results.rows.is_empty(),
        "neither among all answers"
    );
    answered(&kept, 2, None);
    kept.bench.model.results.chosen = chosen(SplitPart::Test);
    press(&mut kept, "esc space o r");
    assert_eq!(kept.bench.model.results.rows.len(), 1);
    assert_eq!(kept.bench.model.results.locked, None);
}
