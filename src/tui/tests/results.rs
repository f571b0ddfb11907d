//! The results screen over a store in memory: counting, moving from a cell to its answers, reopening one.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::bench::Bench;
use super::everywhere::seen_in_every_theme;
use super::history_store::{FIRST, Fixture};
use crate::keymap::{Keymap, Preset};
use crate::message::runs::ResultsEvent;
use crate::message::{Effect, Msg};
use crate::screens::results::ResultsScreen;
use crate::tasks::history::Judging;
use crate::tasks::results::answer;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_study::evaluation::Outcome;
use nearmiss_workflow::TruthChoice;

/// Answers what the screen asked for, until nothing is left.
pub(super) fn settle(kept: &mut Fixture) {
    let judging = Judging {
        ego: EgoSelection::Beside,
        thresholds: Arc::new(Thresholds::shipped().clone()),
    };
    loop {
        let effects = std::mem::take(&mut kept.bench.effects);
        let (asks, others): (Vec<_>, Vec<_>) = effects
            .into_iter()
            .partition(|e| matches!(e, Effect::Results(_)));
        kept.bench.effects = others;
        if asks.is_empty() {
            return;
        }
        for ask in asks {
            let Effect::Results(ask) = ask else { continue };
            let going = AtomicBool::new(false);
            let mut news = Vec::new();
            answer(&kept.store, &judging, ask, &going, &mut |said| {
                news.push(said);
            });
            for said in news {
                kept.bench.send(Msg::Results(said));
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
        .send(Msg::Results(ResultsEvent::Read(old, Err("gone".into()))));
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
