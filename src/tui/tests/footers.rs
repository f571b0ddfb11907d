//! Footers: the keys that work where one is, and messages beside them.

use std::time::Duration;

use super::bench::Bench;
use super::history_store::three;
use super::results::{four, press};
use crate::features::help::HelpScreen;
use crate::message::Msg;

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
    // What leaves no room for keys has the line alone.
    let long = "a message that is nearly as long as the line at the bottom of the screen is wide";
    bench.model.tell(long);
    assert_eq!(last(&bench.frame(90, 24)).trim(), long);
}

#[test]
fn lines_of_the_history_say_what_is_typed_and_what_enter_does() {
    let mut kept = three();
    let footer = |kept: &super::history_store::Fixture| last(&kept.bench.frame(80, 24));
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
    let footer = |kept: &super::history_store::Fixture| last(&kept.bench.frame(80, 24));
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
