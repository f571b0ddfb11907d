//! Keys, chords and footers.

use std::time::Duration;

use crate::features::answers::{Ask, LoadStored};
use crate::features::help::HelpScreen;
use crate::message::{Effect, Msg};
use crate::model::{Model, Pane};
use crate::tests::answers::stored_of;
use crate::tests::bench::{Bench, answer};
use crate::tests::history::three;
use crate::tests::results::{four, press};

fn quits(bench: &Bench) -> bool {
    bench.effects.iter().any(|e| matches!(e, Effect::Quit))
}

fn said(bench: &Bench) -> String {
    let toasts = bench.model.toasts.iter();
    toasts
        .map(|t| t.text.clone())
        .collect::<Vec<_>>()
        .join("\n")
}

fn sized(columns: u16, rows: u16) -> Bench {
    let mut bench = Bench::bundled();
    bench.send(Msg::Resize(columns, rows));
    let of = stored_of(&bench);
    let answers = vec![
        answer("lab/small", false, 301),
        answer("lab/large", true, 301),
    ];
    bench.send(Msg::reply::<LoadStored>((of, answers)));
    bench.press("x");
    bench.frame(columns, rows);
    bench
}

/// How many windows are open, that of answers side by side among them.
fn windows(model: &Model) -> usize {
    model.screens.iter().count() + usize::from(model.compare.open)
}

/// What opens a window, whether it is typed into, and a few keys that do something on it.
const WINDOWS: [(&str, bool, &str); 26] = [
    ("?", true, ""),
    (":", true, ""),
    ("m", true, ""),
    ("c", true, ""),
    ("space s t", true, ""),
    ("space p m", true, ""),
    ("space l s", true, ""),
    ("space l t", true, ""),
    ("space o p", true, ""),
    ("space a p", true, ""),
    ("space o e", true, ""),
    ("space a n", true, ""),
    ("space o i", false, ""),
    ("space o v", false, ""),
    ("space o d", false, ""),
    ("space e d", false, ""),
    ("space o s", false, ""),
    ("space o j", false, ""),
    ("space o h", false, "/ e"),
    ("space o r", false, "b"),
    ("space o c", false, "w"),
    ("space o b", false, "w shift-b"),
    ("space m l", false, ""),
    ("space a a", false, "y n"),
    ("space l i", true, ""),
    ("space l c", false, ""),
];

#[test]
fn esc_and_q_close_every_window_and_no_other_key_does() {
    for (opens, typed, own) in WINDOWS {
        let open = || {
            let mut bench = sized(120, 40);
            bench.press(opens);
            assert_eq!(windows(&bench.model), 1, "{opens}");
            bench
        };
        let mut bench = open();
        bench.press("esc");
        assert_eq!(windows(&bench.model), 0, "esc on {opens}");
        let mut bench = open();
        bench.press("q");
        let left = usize::from(typed);
        assert_eq!(windows(&bench.model), left, "q on {opens}");
        assert!(!quits(&bench), "{opens}");
        let mut bench = open();
        for key in "abcdefghijklmnoprstuvwxyz0123456789%!@&#;,.<>[]()+-*$".chars() {
            let key = key.to_string();
            if own.split(' ').any(|own| own == key) {
                continue;
            }
            bench.press(&key);
            assert!(windows(&bench.model) > 0, "{key} closes {opens}");
            // What it began or opened on top is left again.
            if !bench.model.look.pending.is_empty() || windows(&bench.model) > 1 {
                bench.press("esc");
            }
            assert_eq!(windows(&bench.model), 1, "{key} on {opens}");
            assert!(!quits(&bench), "{key} on {opens}");
        }
    }
}

#[test]
fn q_closes_one_window_after_the_other_and_then_quits() {
    let mut bench = sized(120, 40);
    bench.press("space o r space o i");
    assert_eq!(
        windows(&bench.model),
        1,
        "a full screen has no place for other windows"
    );
    bench.press("space o j");
    assert_eq!(windows(&bench.model), 2);
    bench.press("q q");
    assert_eq!(windows(&bench.model), 0);
    assert!(!quits(&bench));
    bench.press("q");
    assert!(quits(&bench));
}

#[test]
fn digits_are_counts_before_motions() {
    let mut bench = sized(80, 24);
    bench.press("home 5 right");
    assert_eq!(bench.model.clock.step(), 5);
    bench.press("1 0 right 3 left");
    assert_eq!(bench.model.clock.step(), 12);
    bench.press("0");
    assert_eq!(bench.model.clock.step(), 0, "0 alone is the first step");
    bench.press("2 .");
    assert_eq!(bench.model.clock.step(), 20);
    // In the list: lines, and a line by its number; only the last one is opened.
    let before = bench.model.list.selected;
    bench.effects.clear();
    bench.press("3 j");
    assert_eq!(bench.model.list.selected, before + 3);
    bench.press("2 g g");
    assert_eq!(bench.model.list.selected, 1);
    bench.press("1 g g");
    // The count is in the footer until Esc takes it away, and nothing else.
    bench.press("/ z esc 1 0");
    let frame = bench.frame(80, 24);
    assert!(frame.lines().last().unwrap().contains(" 10 "), "{frame}");
    bench.press("esc");
    assert_eq!(bench.model.look.count, None);
    let techniques = bench.model.techniques;
    bench.press("1 2 3 esc right");
    assert_eq!(bench.model.techniques, techniques);
    // A count is no reason to ask so many times.
    bench.effects.clear();
    bench.press("4 r");
    let asked = bench
        .effects
        .iter()
        .filter(|e| matches!(e.request(), Some(Ask { .. })));
    assert!(asked.count() <= 1);
    // Obstacles, and scrolled text.
    let mut bench = sized(80, 24);
    bench.press("n");
    let ranking = bench.model.opened.as_ref().unwrap().ranking.clone();
    let place = |bench: &Bench| ranking.iter().position(|&o| Some(o) == bench.model.picked);
    let first = place(&bench).unwrap();
    bench.press("2 n");
    assert_eq!(place(&bench), Some((first + 2) % ranking.len()));
    bench.press("? 3 down");
    assert!(bench.frame(80, 24).contains('3'), "digits are typed there");
}

#[test]
fn old_keys_say_where_they_went() {
    let mut bench = sized(80, 24);
    bench.press("%");
    assert!(bench.model.screens.is_empty());
    assert_eq!(said(&bench), "% does nothing now: results is Space o r");
    bench.press("esc shift-u");
    assert!(said(&bench).contains("switch-variant is Space g o"));
    let text = "[global]\nresults = [\"%\"]\n";
    bench.model.look.keymap = crate::keymap::Keymap::parse("keymap.toml", text).unwrap();
    bench.press("%");
    assert!(!bench.model.screens.is_empty(), "the user's binding wins");
}

#[test]
fn jumps_are_gone_back_and_forward() {
    let mut bench = sized(120, 40);
    bench.press("home");
    let worst = {
        bench.press("x");
        bench.model.clock.step()
    };
    assert!(worst > 0);
    bench.press("end");
    let end = bench.model.clock.step();
    bench.press("ctrl-o");
    assert_eq!(bench.model.clock.step(), worst);
    bench.press("alt-left");
    assert_eq!(bench.model.clock.step(), 0);
    bench.press("2 alt-right");
    assert_eq!(bench.model.clock.step(), end);
    // Into the scenario that was open before, at its step and obstacle.
    bench.press("x right n");
    let (first, picked) = (bench.model.list.opened, bench.model.picked);
    bench.press("down");
    assert_ne!(bench.model.list.opened, first);
    bench.press("ctrl-o");
    let model = &bench.model;
    assert_eq!((model.list.opened, model.picked), (first, picked));
    assert_eq!(model.clock.step(), worst + 1);
    assert_eq!(model.list.current(), first);
    bench.press("alt-right");
    assert_ne!(bench.model.list.opened, first);
    bench.press("alt-right");
    assert!(said(&bench).contains("no later place"), "{}", said(&bench));
}

#[test]
fn the_menu_leaves_the_selected_line_in_sight() {
    for (columns, rows) in [(80, 24), (120, 40), (200, 60)] {
        for lead in ["space", "space o", "space a", "space l", "space g", "g"] {
            for before in ["", "z", "z shift-g", "tab", "tab tab tab tab"] {
                let mut bench = sized(columns, rows);
                bench.press(before);
                let selected = bench.model.list.current();
                let name = bench.model.list.rows[selected.unwrap()].entry.name.clone();
                bench.frame(columns, rows);
                bench.press(lead);
                let frame = bench.frame(columns, rows);
                let listed = bench.model.focus == Pane::Scenarios;
                assert!(
                    !listed || frame.contains(&format!("▸ {name}")),
                    "{lead}\n{frame}"
                );
                assert!(lead != "space" || frame.contains("m map …"), "{frame}");
                bench.press("esc");
                assert!(bench.model.look.pending.is_empty());
            }
        }
    }
}

#[test]
fn the_footer_is_that_of_the_pane_and_the_mode() {
    let mut bench = sized(80, 24);
    let footer = |bench: &Bench| bench.frame(80, 24).lines().last().unwrap().to_string();
    let mut seen = Vec::new();
    for words in ["open", "zoom", "edit", "side by side", "claim", "measure"] {
        let line = footer(&bench);
        assert!(line.contains(words), "{words}: {line}");
        assert!(line.contains("Space menu"), "{line}");
        seen.push(line);
        bench.press("z");
        let line = footer(&bench);
        assert!(line.contains("z shows all panes"), "{line}");
        bench.press("z tab");
    }
    seen.dedup();
    assert_eq!(seen.len(), 6);
    bench.press("home p");
    assert!(footer(&bench).contains("p pause"), "{}", footer(&bench));
    bench.press("p /");
    assert!(footer(&bench).contains("Esc cancel"), "{}", footer(&bench));
}

#[test]
fn a_filter_that_is_opened_again_is_replaced_or_kept_and_esc_goes_back() {
    let mut bench = sized(120, 40);
    let first = bench.model.list.opened;
    let step = bench.model.clock.step();
    bench.press("/ m e r");
    assert!(
        bench.frame(120, 40).contains("risk<3"),
        "its terms are shown"
    );
    bench.send(Msg::Passed(std::time::Duration::from_secs(1)));
    assert_ne!(bench.model.list.opened, first);
    bench.press("esc");
    assert_eq!(bench.model.list.filter, "");
    assert_eq!(
        (bench.model.list.opened, bench.model.clock.step()),
        (first, step)
    );
    bench.press("/ m e r enter / l");
    assert_eq!(bench.model.list.filter, "l");
    bench.press("esc");
    assert_eq!(bench.model.list.filter, "mer");
    bench.press("/ right g e");
    assert_eq!(bench.model.list.filter, "merge");
    bench.press("enter / backspace enter");
    assert_eq!(bench.model.list.filter, "");
    // Where the filter led is a jump.
    bench.press("ctrl-o");
    assert!(bench.model.list.opened.is_some());
}

#[test]
fn the_palette_knows_other_words() {
    for (word, id) in [
        ("figure", "picture"),
        ("screenshot", "picture"),
        ("image", "picture"),
        ("price", "model"),
        ("export", "export-runs"),
        ("accuracy", "results"),
        ("undo", "undo"),
        ("filter", "filter"),
    ] {
        let mut bench = sized(80, 24);
        bench.press(":");
        bench.type_text(word);
        let frame = bench.frame(80, 24);
        let shown = frame.lines().filter(|line| line.contains("  ")).take(9);
        assert!(
            shown.clone().any(|line| line.contains(id)),
            "{word}: {frame}"
        );
    }
    // Each word begins one of the action's; letters within others are no match beside it.
    let mut bench = sized(80, 24);
    bench.press(":");
    bench.type_text("sort s");
    let frame = bench.frame(80, 24);
    assert!(frame.contains("▸ sort "), "{frame}");
    assert!(!frame.contains("pan-left"), "{frame}");
    let mut bench = sized(80, 24);
    bench.press(":");
    bench.type_text("shot");
    let frame = bench.frame(80, 24);
    assert!(
        frame.contains("▸ picture"),
        "a part of `screenshot`: {frame}"
    );
    let mut bench = sized(80, 24);
    bench.press(":");
    let frame = bench.frame(80, 24);
    let mut list = frame.lines().skip(1);
    assert!(!list.any(|line| line.contains('…')), "no sentence is cut");
}

#[test]
fn enter_does_the_main_thing_of_the_pane() {
    let mut bench = sized(120, 40);
    for (focus, done) in [
        (Pane::Map, "details"),
        (Pane::Verdict, "compare"),
        (Pane::Plot, "measures"),
        (Pane::Prompt, "editor"),
    ] {
        bench.model.focus = focus;
        bench.press("enter");
        let model = &bench.model;
        let opened = match done {
            "compare" => model.compare.open,
            "editor" => model.prompt.editing,
            _ => !model.screens.is_empty(),
        };
        assert!(opened, "{done}");
        bench.press("esc");
    }
}

fn last(frame: &str) -> String {
    frame.lines().last().unwrap_or_default().to_string()
}

#[test]
fn a_message_stands_beside_the_keys_and_goes_with_the_next_one_once_read() {
    let mut bench = Bench::bundled();
    let footer = |bench: &Bench| last(&bench.frame(120, 40));
    bench.model.tell("saved as rating 1");
    let line = footer(&bench);
    assert!(line.ends_with("saved as rating 1"), "{line}");
    assert!(
        line.contains("Enter open") && line.contains("? help"),
        "{line}"
    );
    bench.press("right");
    assert!(footer(&bench).contains("rating 1"), "not read yet");
    bench.send(Msg::Passed(Duration::from_secs_f64(3.5)));
    assert!(footer(&bench).contains("rating 1"));
    bench.press("right");
    assert!(!footer(&bench).contains("rating 1"));
    bench.model.tell("saved as rating 2");
    bench.send(Msg::Passed(Duration::from_secs_f64(4.5)));
    assert!(!footer(&bench).contains("rating 2"), "without a key, too");
    // A window that opens has the line for its keys.
    bench.model.tell("saved as rating 3");
    bench.send(Msg::Passed(Duration::from_secs_f64(0.5)));
    bench.press("?");
    assert!(!footer(&bench).contains("rating 3"));
    bench.press("esc");
    // What leaves no room for keys has the line alone.
    let long = "a message that is nearly as long as the line at the bottom of the screen is wide";
    bench.model.tell(long);
    assert_eq!(last(&bench.frame(90, 24)).trim(), long);
}

#[test]
fn lines_of_the_history_say_what_is_typed_and_what_enter_does() {
    let mut kept = three();
    let footer = |kept: &super::history::Fixture| last(&kept.bench.frame(80, 24));
    kept.press("/");
    assert!(footer(&kept).contains("type words and filters"));
    kept.press("esc n");
    assert_eq!(footer(&kept).trim(), "type note  Enter save  Esc cancel");
    kept.press("esc e");
    assert_eq!(
        footer(&kept).trim(),
        "type file name  Enter export  Esc cancel"
    );
}

#[test]
fn a_list_behind_a_cell_offers_only_what_works_there() {
    let mut kept = four();
    let footer = |kept: &super::history::Fixture| last(&kept.bench.frame(80, 24));
    let line = footer(&kept);
    assert!(
        line.contains("cell") && line.contains("Esc close"),
        "{line}"
    );
    press(&mut kept, "enter");
    let line = footer(&kept);
    assert!(
        line.contains("Enter open") && line.contains("Esc back"),
        "{line}"
    );
    assert!(!line.contains("cell") && !line.contains("sort"), "{line}");
    press(&mut kept, "b");
    assert_eq!(footer(&kept).trim(), "↑↓ select  Enter choose  Esc back");
}

#[test]
fn the_editor_has_help_and_a_view_in_its_place_scrolls() {
    let mut bench = Bench::bundled();
    bench.model.size = (80, 24);
    bench.press("e");
    assert!(last(&bench.frame(80, 24)).contains("F1 help"));
    bench.press("f1");
    assert!(bench.model.screens.is_top::<HelpScreen>());
    let frame = bench.frame(80, 24);
    assert!(frame.contains("here: in the template editor"), "{frame}");
    bench.press("esc");
    assert!(bench.model.prompt.editing && bench.model.screens.is_empty());
    bench.press("ctrl-o");
    let line = last(&bench.frame(80, 24));
    assert!(
        line.contains("↑↓ scroll") && line.contains("Ctrl-o next view"),
        "{line}"
    );
    assert!(!line.contains("save") && line.contains("F1 help"), "{line}");
}

#[test]
fn help_and_the_way_out_have_their_place_on_every_full_screen() {
    for keys in ["space o h", "space o r", "space o j", "space o c"] {
        let mut bench = Bench::bundled();
        bench.press(keys);
        let line = last(&bench.frame(80, 24));
        assert!(
            line.contains("? help") && line.contains("Esc close"),
            "{keys}: {line}"
        );
    }
}
