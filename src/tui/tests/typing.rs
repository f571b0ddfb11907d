//! Input lines: Ctrl-U clears them and Ctrl-W deletes the last word, everywhere.

use super::bench::Bench;
use super::editing::with;
use super::history_store::three;
use super::side_by_side::{sized, two};
use crate::features::help::HelpScreen;
use crate::features::palette::Palette;
use crate::features::picker::PickerScreen;
use crate::model::EntryLine;
use nearmiss_settings::Keys;

#[test]
fn the_filter_of_the_list_is_cleared_and_what_it_was_before_stays_until_then() {
    let mut bench = Bench::bundled();
    let all = bench.model.list.lines.len();
    bench.press("/");
    bench.type_text("zam tag:x y");
    bench.press("ctrl-w ctrl-w");
    assert_eq!(bench.model.list.filter, "zam ");
    bench.press("enter / right");
    bench.type_text("q");
    assert_eq!(bench.model.list.filter, "zam q");
    bench.press("ctrl-u");
    assert_eq!(bench.model.list.filter, "");
    assert!(
        bench.model.list.filtering.is_some(),
        "it is still typed into"
    );
    assert_eq!(bench.model.list.lines.len(), all);
}

#[test]
fn the_search_of_the_history_is_cleared_and_refuses_what_is_no_filter() {
    let mut kept = three();
    kept.press("/");
    kept.type_text("brakes lab");
    kept.press("ctrl-w");
    assert_eq!(kept.bench.model.history.line, "brakes ");
    assert_eq!(kept.rows(), [1]);
    kept.press("enter /");
    kept.press("ctrl-u");
    assert_eq!(kept.rows(), [3, 2, 1]);
    kept.type_text("bogus:thing");
    for size in [(80, 24), (120, 30)] {
        let frame = kept.bench.frame(size.0, size.1);
        assert!(
            frame.contains("unknown filter `bogus:`; available: model:"),
            "{frame}"
        );
    }
    assert_eq!(kept.rows(), [3, 2, 1], "and it holds nothing back");
}

#[test]
fn lines_of_overlays_and_of_the_editor_are_cleared() {
    let mut bench = Bench::bundled();
    bench.press(":");
    bench.type_text("no such thing");
    bench.press("ctrl-w");
    let text = |bench: &Bench| {
        let screens = &bench.model.screens;
        let palette = screens.find::<PickerScreen<Palette>>();
        let help = screens.find::<HelpScreen>().map(|help| &help.typed);
        let typed = palette.map(|list| &list.picker.text).or(help);
        typed.expect("one of them is open").clone()
    };
    assert_eq!(text(&bench), "no such ");
    bench.press("ctrl-u");
    assert_eq!(text(&bench), "");
    bench.press("esc ?");
    bench.type_text("pane x");
    bench.press("ctrl-w");
    assert_eq!(text(&bench), "pane ");
    let mut bench = with(Keys::Plain);
    bench.press("ctrl-a");
    assert!(matches!(&bench.model.prompt.entry, Some(EntryLine::SaveAs(name)) if name.len() > 4));
    bench.press("ctrl-u m i n e");
    let entry = &bench.model.prompt.entry;
    assert!(
        matches!(entry, Some(EntryLine::SaveAs(name)) if name == "mine"),
        "{entry:?}"
    );
    let mut bench = sized(two(), 120, 40);
    bench.press("space o c w");
    bench.type_text("it is");
    bench.press("ctrl-w 3");
    let marking = bench.model.compare.marking.as_ref().unwrap();
    assert_eq!(marking.text, "it 3");
}

#[test]
fn a_run_of_the_built_in_judge_says_what_it_looked_at() {
    let mut kept = three();
    kept.add(
        "ZAM_Lost-1_1_T-1",
        nearmiss_scene::judge::MODEL,
        false,
        "all is far",
    );
    kept.press("esc ctrl-r");
    kept.press("g g");
    let frame = kept.bench.frame(140, 40);
    let row = |name: &str| {
        let mut lines = frame.lines();
        let line = lines.find(|line| line.contains(name));
        line.unwrap_or_else(|| panic!("{name}: {frame}"))
            .to_string()
    };
    assert!(
        row("task  ").contains("safety") && row("asked with").contains("exact geometry"),
        "{frame}"
    );
    assert!(
        row("steps  ").contains("20 to 29"),
        "safety is judged from the window: {frame}"
    );
}
