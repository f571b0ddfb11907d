//! What a newcomer meets first: where the keys are, what is asked and at what price, what runs, what signs mean.

use std::time::Duration;

use super::bench::{Bench, answer};
use super::side_by_side::{sized, two};
use crate::features::batch::BatchScreen;
use crate::features::batch::request::EstimateBatch;
use crate::features::results::ResultsScreen;
use crate::keymap::Keymap;
use crate::message::Msg;
use crate::model::Update;
use crate::model::{Column, Model, Pane};

fn said(model: &Model) -> String {
    let last = model.toasts.last();
    last.map_or(String::new(), |toast| toast.text.clone())
}

fn pass(bench: &mut Bench, seconds: f64) {
    bench.send(Msg::Passed(Duration::from_secs_f64(seconds)));
}

#[test]
fn after_editing_the_keys_are_back_in_the_list() {
    let mut bench = Bench::bundled();
    bench.press("e x esc");
    assert_eq!(bench.model.focus, Pane::Scenarios);
    bench.press("* j *");
    assert_eq!(bench.model.marks.count(&bench.model.list), 2);
    bench.press("tab tab");
    assert_eq!(bench.model.focus, Pane::Prompt);
    bench.press("enter esc");
    assert_eq!(bench.model.focus, Pane::Prompt, "it was there before");
    bench.press("*");
    let words = said(&bench.model);
    assert!(words.contains("select others in the list"), "{words}");
}

#[test]
fn without_marks_the_dialog_says_that_it_asks_all() {
    let mut bench = Bench::bundled();
    bench.press("space a a");
    let all = bench.model.list.visible.len();
    let words = format!("No scenario is marked: this asks all {all}. * marks");
    assert!(bench.frame(120, 40).contains(&words));
    bench.press("esc * space a a");
    assert!(!bench.frame(120, 40).contains("No scenario is marked"));
}

#[test]
fn what_cannot_be_asked_is_not_offered() {
    let mut bench = Bench::bundled();
    bench.press("space a a");
    let card = bench.model.card.as_ref().unwrap();
    let mut counts = card.counts.clone();
    counts.looked = card.batch.entries.len();
    counts.refused = Some("LAB_KEY is not set".into());
    let id = card.id;
    bench.send(Msg::reply::<EstimateBatch>((id, Update::Ended(Ok(counts)))));
    for (columns, rows) in [(80, 24), (120, 40)] {
        let frame = bench.frame(columns, rows);
        assert!(frame.contains("LAB_KEY is not set"), "{frame}");
        assert!(!frame.contains("Enter ask"), "{frame}");
    }
    bench.effects.clear();
    bench.press("enter");
    assert!(bench.effects.is_empty() && bench.model.screens.is_top::<BatchScreen>());
}

#[test]
fn a_running_search_keeps_its_key_and_the_title_its_place() {
    let mut bench = Bench::bundled();
    let name = bench.model.opened.as_ref().unwrap().name.clone();
    bench.press("space g g");
    for seconds in [0.0, 10.0] {
        pass(&mut bench, seconds);
        let frame = bench.frame(80, 24);
        let (first, last) = (frame.lines().next(), frame.lines().last());
        assert!(last.is_some_and(|l| l.contains("Esc cancel")), "{frame}");
        assert!(first.is_some_and(|l| l.contains(&name)), "{frame}");
    }
}

#[test]
fn with_nothing_to_rate_no_rating_is_offered() {
    let mut bench = sized(Bench::bundled(), 120, 40);
    let column = Column::from(answer("lab/small", true, 301));
    bench.model.answers.columns.push(column);
    bench.press("space o b");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("1 complete answer of a model;"), "{frame}");
    let footer = frame.lines().last().unwrap_or_default();
    assert!(
        !footer.contains("best") && !footer.contains("tie"),
        "{footer}"
    );
    assert!(footer.contains("Esc"), "{footer}");
}

#[test]
fn countries_are_found_by_their_names() {
    let mut bench = Bench::bundled();
    let countries = |bench: &Bench| {
        let places = bench.model.list.visible.iter();
        let rows = places.map(|place| bench.model.list.rows[*place].country().to_string());
        rows.collect::<std::collections::BTreeSet<_>>()
    };
    let all = bench.model.list.visible.len();
    for filter in ["zamunda", "country:zamunda"] {
        bench.press("/");
        bench.type_text(filter);
        bench.press("enter");
        let found = bench.model.list.visible.len();
        assert_eq!(countries(&bench), ["ZAM".to_string()].into(), "{filter}");
        assert!(found > 0 && found <= all);
    }
    bench.press("/");
    bench.type_text("!zamunda");
    bench.press("enter");
    assert!(!countries(&bench).contains("ZAM"));
}

#[test]
fn the_best_match_opens_when_typing_rests() {
    let mut bench = Bench::bundled();
    let before = bench.model.list.opened;
    bench.press("/");
    bench.type_text("merge");
    assert_eq!(bench.model.list.opened, before, "nothing opens at a key");
    assert!(bench.model.moves());
    pass(&mut bench, 1.0);
    assert_ne!(bench.model.list.opened, before);
    bench.type_text("qqq");
    pass(&mut bench, 1.0);
    let open = bench.model.opened.as_ref().unwrap().name.clone();
    let list = bench.frame(200, 60);
    assert!(list.contains("no match; Esc clears the"), "{list}");
    assert!(list.matches(&open).count() > 1, "{list}");
}

#[test]
fn help_on_the_list_begins_with_its_signs() {
    let mut bench = Bench::bundled();
    bench.press("?");
    let frame = bench.frame(120, 40);
    let signs = frame.find("signs in the list").unwrap();
    assert!(signs < frame.find("here: in the list").unwrap(), "{frame}");
    assert!(frame.contains("0 contact"), "{frame}");
}

#[test]
fn menus_open_side_by_side_and_in_the_editor() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c space");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("Space · menu"), "{frame}");
    bench.press("o r");
    assert!(bench.model.screens.is_top::<ResultsScreen>());
    bench.press("esc");
    assert!(bench.model.compare.open && bench.model.screens.is_empty());
    bench.press("esc e f8 a a");
    assert!(bench.model.screens.is_top::<BatchScreen>());
    assert!(
        bench
            .effects
            .iter()
            .any(|effect| { matches!(effect.request(), Some(EstimateBatch { .. })) })
    );
    bench.press("esc f8 w w");
    assert!(bench.model.prompt.editing);
    assert_eq!(bench.model.focus, Pane::Prompt);
    // A space is text there.
    let before = bench.model.prompt.text();
    bench.press("space");
    assert_ne!(bench.model.prompt.text(), before);
}

#[test]
fn blind_menus_stay_shut() {
    let mut bench = sized(two(), 120, 40);
    bench.press("space o b space");
    assert!(bench.model.look.pending.is_empty() && bench.model.compare.open);
    assert!(said(&bench.model).contains("rate first"));
}

#[test]
fn menus_spell_out_what_they_switch_and_how_it_stands() {
    let mut bench = Bench::bundled();
    bench.press("space a");
    let frame = bench.frame(120, 40);
    assert!(
        frame.contains("contextual prompting on/off (on)"),
        "{frame}"
    );
    assert!(frame.contains("discard draft"), "{frame}");
}

#[test]
fn a_keymap_file_may_still_say_reset_template() {
    let map = Keymap::parse("keymap.toml", "[global]\nreset-template = \"f9\"\n").unwrap();
    let key = map.key_of(crate::action::Action::DiscardDraft);
    assert_eq!(key, "F9");
}
