//! The screen of results, and questions of a batch that were not asked.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::action::Scope;
use crate::features::history::request::Judging;
use crate::features::results::ResultsScreen;
use crate::features::results::request::{ResultsCommand, ResultsEvent, answer};
use crate::keymap::{Keymap, Preset};
use crate::message::Msg;
use crate::tests::bench::Bench;
use crate::tests::counted::{YES, item, labelled, spec};
use crate::tests::everywhere::seen_in_every_theme;
use crate::tests::history::{FIRST, Fixture, requests};
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::{BatchId, ItemState, NewItem, SplitPart};
use nearmiss_study::evaluation::Outcome;
use nearmiss_study::evaluation::batch::{AnswerSet, BatchPart, Experiment, Spec, Split};
use nearmiss_workflow::TruthChoice;

/// Answers what the screen asked for, until nothing is left.
pub(super) fn settle(kept: &mut Fixture) {
    let judging = Judging {
        ego: EgoSelection::Beside,
        thresholds: Arc::new(Thresholds::shipped().clone()),
    };
    loop {
        let effects = std::mem::take(&mut kept.bench.effects);
        let (asks, others) = requests(effects);
        kept.bench.effects = others;
        if asks.is_empty() {
            return;
        }
        for ask in asks {
            let going = AtomicBool::new(false);
            let mut news = Vec::new();
            answer(&kept.store, &judging, ask, &going, &mut |said| {
                news.push(said);
            });
            for said in news {
                kept.bench.send(Msg::reply::<ResultsCommand>(said));
            }
        }
    }
}

pub(super) fn press(kept: &mut Fixture, keys: &str) {
    for key in keys.split_whitespace() {
        kept.press(key);
        settle(kept);
    }
}

/// Two models: one says yes and no on the bundled scenario, and yes on one that is not there; one says no.
pub(super) fn four() -> Fixture {
    let mut kept = Fixture::new();
    kept.add(FIRST, "lab/small", true, "the lead car brakes hard");
    kept.add(
        "ZAM_Lost-1_1_T-1\u{1b}[2J",
        "lab/small",
        true,
        "something is near",
    );
    kept.add(FIRST, "lab/large", false, "there is room to brake");
    press(&mut kept, "space o r");
    kept
}

pub(super) fn counts(kept: &Fixture, row: usize) -> [u32; 7] {
    Outcome::ALL.map(|outcome| kept.bench.model.results.rows[row].count(outcome))
}

#[test]
fn answers_are_compared_with_the_recording_or_the_judge_and_the_screen_names_which() {
    let mut kept = four();
    let results = &kept.bench.model.results;
    let models: Vec<_> = results
        .rows
        .iter()
        .map(|row| row.configuration.model.as_str())
        .collect();
    assert_eq!(models, ["lab/large", "lab/small"]);
    let of = |kept: &Fixture, model: &str| {
        let mut rows = kept.bench.model.results.rows.iter();
        counts(
            kept,
            rows.position(|row| row.configuration.model == model)
                .unwrap(),
        )
    };
    let (large, small) = (of(&kept, "lab/large"), of(&kept, "lab/small"));
    // Whatever is true about the scenario, no is right or yes is, whichever obstacle is named.
    assert_eq!(large[2] + large[3], 1, "{large:?}");
    assert_eq!(small[0] + small[1], 1, "{small:?}");
    assert_eq!((small[0], small[4]), (large[2], 1), "{small:?}");
    let frame = kept.bench.frame(100, 30);
    assert!(frame.contains("truth: labels, else recordings"), "{frame}");
    // The judge's prediction is a truth that is chosen; its own run then counts, and is no row.
    let judged = large[2] == 1;
    kept.add(
        FIRST,
        nearmiss_scene::judge::MODEL,
        !judged,
        "I changed my mind",
    );
    press(&mut kept, "esc space o r");
    assert_eq!(kept.bench.model.results.rows.len(), 3);
    assert_eq!(of(&kept, "lab/large"), large);
    press(&mut kept, "t t");
    assert_eq!(kept.bench.model.results.truth, TruthChoice::Judge);
    assert_eq!(kept.bench.model.results.rows.len(), 2);
    assert_eq!(of(&kept, "lab/large")[2] == 1, !judged);
    let frame = kept.bench.frame(100, 30);
    assert!(frame.contains("truth: built-in judge"), "{frame}");
}

#[test]
fn from_a_cell_to_its_answers_to_the_scenario_and_back() {
    let mut kept = four();
    press(&mut kept, "enter");
    assert_eq!(kept.bench.model.results.answers().len(), 1);
    press(&mut kept, "esc");
    assert_eq!(kept.bench.model.results.inside, None);
    press(&mut kept, "j right right right right right");
    assert_eq!(kept.bench.model.results.outcome(), Some(Outcome::Open));
    press(&mut kept, "enter");
    let frame = kept.bench.frame(120, 30);
    assert!(
        frame.contains("ZAM_Lost") && frame.contains("nothing to compare"),
        "{frame}"
    );
    assert!(!frame.contains('\u{1b}'));
    // It is not in the list: that is said, and the answers stay.
    press(&mut kept, "enter");
    assert!(kept.bench.model.screens.is_top::<ResultsScreen>());
    assert_eq!(kept.bench.model.screens.iter().count(), 1);
    assert!(
        kept.bench
            .model
            .toasts
            .last()
            .unwrap()
            .text
            .contains("not in the list")
    );
    press(&mut kept, "esc");
    let results = &mut kept.bench.model.results;
    results.column = 0;
    press(&mut kept, "enter enter");
    let model = &kept.bench.model;
    assert!(model.screens.is_empty());
    assert_eq!(model.opened.as_ref().unwrap().name, FIRST);
    assert_eq!(model.answers.column().unwrap().model, "lab/small");
    press(&mut kept, "space o r esc");
    assert!(kept.bench.model.screens.is_empty());
}

#[test]
fn an_empty_cell_and_news_of_an_older_reading_change_nothing() {
    let mut kept = four();
    kept.bench.model.results.column = 7;
    press(&mut kept, "enter");
    assert_eq!(kept.bench.model.results.inside, None);
    let old = kept.bench.model.results.asked;
    press(&mut kept, "esc");
    kept.bench
        .send(Msg::reply::<ResultsCommand>(ResultsEvent::Read(
            old,
            Err("gone".into()),
        )));
    assert_eq!(kept.bench.model.results.error, None);
    assert_eq!(kept.bench.model.results.rows.len(), 2);
}

#[test]
fn the_palette_has_it_and_an_empty_store_says_what_to_do() {
    let mut kept = Fixture::new();
    press(&mut kept, ": r e s u l t s enter");
    let frame = kept.bench.frame(80, 24);
    assert!(frame.contains("no model has been asked yet"), "{frame}");
    let mut bench = Bench::bundled();
    bench.model.look.keymap = Keymap::from_preset(Preset::Vim);
    bench.press("space o r");
    assert!(bench.model.screens.is_top::<ResultsScreen>());
    assert_eq!(bench.model.screens.iter().count(), 1);
}

#[test]
fn how_it_looks_in_every_theme() {
    for (columns, rows) in [(80, 24), (120, 40), (200, 60)] {
        let mut all = String::new();
        for keys in ["", "j right", "j enter j"] {
            let mut kept = four();
            kept.bench.model.size = (columns, rows);
            press(&mut kept, keys);
            let text = seen_in_every_theme("results", &mut kept.bench, (columns, rows), true);
            all.push_str(&text);
            all.push('\n');
        }
        insta::assert_snapshot!(format!("results_at_{columns}_by_{rows}"), all);
    }
}

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

#[test]
fn in_a_narrow_list_names_and_truths_are_whole() {
    let mut kept = four();
    let results = &mut kept.bench.model.results;
    let long = "BEL_Brussels-82_4_T-1";
    for row in &mut results.rows {
        for (place, answer) in row.answers.iter_mut().enumerate() {
            answer.scenario = long.into();
            answer.outcome = [Outcome::FalseNegative, Outcome::TrueNegative][place % 2];
        }
    }
    results.selected = results.rows.len() - 1;
    results.column = 0;
    press(&mut kept, "enter");
    let frame = kept.bench.frame(60, 18);
    assert!(frame.contains(&format!("{long} no, truth: yes")), "{frame}");
    let frame = kept.bench.frame(120, 40);
    assert!(
        frame.contains(&format!("{long} says no, truth: yes")),
        "{frame}"
    );
}

#[test]
fn a_table_says_how_many_rows_are_below() {
    let mut kept = four();
    let rows = &mut kept.bench.model.results.rows;
    let more = std::iter::repeat_n(rows[0].clone(), 30);
    rows.extend(more);
    assert!(kept.bench.frame(80, 24).contains(" more lines "));
    kept.bench.model.results.selected = 31;
    let frame = kept.bench.frame(80, 24);
    assert!(!frame.contains(" more lines "), "{frame}");
}
