//! The editor of templates: typing, moving, undoing.

use std::time::Duration;

use crate::features::help::HelpScreen;
use crate::features::palette::Palette;
use crate::features::picker::PickerScreen;
use crate::features::prompt::request::KeepDraft;
use crate::features::scenarios::request::{Find, Found};
use crate::message::{Effect, Mouse, Msg};
use crate::model::{EntryLine, Notice, PromptPane};
use crate::tests::bench::Bench;
use crate::tests::history::three;
use crate::tests::side_by_side::{sized, two};
use nearmiss_ask::prompts::Library;
use nearmiss_settings::Keys;

pub fn with(keys: Keys) -> Bench {
    let mut bench = Bench::empty();
    bench.model.prompt = PromptPane::new(keys);
    bench.send(Msg::reply::<Find>(Found::All(Ok(
        nearmiss_formats::bundled().into(),
    ))));
    bench.press("e");
    bench.model.prompt.editor.go(0, 0, false);
    bench
}

/// The text of the line with the cursor.
pub fn line(bench: &Bench) -> String {
    let (row, _) = bench.model.prompt.editor.cursor();
    bench
        .model
        .prompt
        .text()
        .split('\n')
        .nth(row)
        .unwrap()
        .into()
}

pub fn copied(bench: &Bench) -> Option<&str> {
    bench.effects.iter().rev().find_map(|e| match e {
        Effect::Copy(text) => Some(text.as_str()),
        _ => None,
    })
}

pub fn kept(bench: &Bench) -> Vec<(&str, Option<&str>)> {
    let kept = bench.effects.iter().filter_map(|e| match e.request() {
        Some(KeepDraft { file, draft, .. }) => Some((file.as_str(), draft.as_deref())),
        _ => None,
    });
    kept.collect()
}

pub fn said(bench: &Bench) -> String {
    let texts = bench.model.toasts.iter().map(|t| t.text.clone());
    texts.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_draft_that_cannot_be_kept_is_said_before_the_program_ends() {
    let mut bench = with(Keys::Plain);
    bench.press("e x esc");
    bench.send(Msg::reply::<KeepDraft>(Err("the disk is full".into())));
    assert!(
        said(&bench).contains("not kept for the next start: the disk is full"),
        "{}",
        said(&bench)
    );
    let ends = |bench: &Bench| bench.effects.iter().any(|e| matches!(e, Effect::Quit));
    bench.press("q");
    assert!(!ends(&bench), "{}", said(&bench));
    assert!(said(&bench).contains("q again quits without it"));
    // Room again: it is kept, and nothing is asked.
    bench.send(Msg::reply::<KeepDraft>(Ok(None)));
    bench.press("right q");
    assert!(ends(&bench), "{}", said(&bench));
}

#[test]
fn selecting_cutting_and_pasting() {
    let mut bench = with(Keys::Plain);
    bench.press("down shift-end ctrl-x");
    assert_eq!(copied(&bench), Some("name = \"collision-ego\""));
    assert_eq!(line(&bench), "");
    bench.press("ctrl-v");
    assert!(!bench.model.prompt.is_draft());
    bench.press("home shift-right shift-right x");
    assert_eq!(line(&bench), "xme = \"collision-ego\"");
    bench.press("home shift-right ctrl-c");
    assert_eq!(copied(&bench), Some("x"));
    assert!(bench.model.prompt.editing, "with a selection Ctrl-C copies");
    bench.press("alt-a backspace");
    assert_eq!(bench.model.prompt.text(), "");
    bench.press("ctrl-z");
    assert!(bench.model.prompt.text().starts_with("+++\nxme"));
    bench.press("ctrl-c");
    assert!(!bench.model.prompt.editing, "without one it is done");
}

#[test]
fn searching_goes_on_and_back_and_returns() {
    let mut bench = with(Keys::Plain);
    let at = |bench: &Bench| bench.model.prompt.editor.cursor();
    bench.press("ctrl-f");
    bench.type_text("RISK");
    assert!(bench.frame(120, 40).contains("find: RISK▏  0 found"));
    bench.press("backspace backspace backspace backspace");
    bench.type_text("ego");
    let first = at(&bench);
    assert!(bench.frame(120, 40).contains("1 of "));
    bench.press("ctrl-f");
    let second = at(&bench);
    assert!(second > first);
    bench.press("up");
    assert_eq!(at(&bench), first);
    bench.press("up");
    assert!(at(&bench) > second, "before the first comes the last");
    bench.press("esc");
    assert_eq!(at(&bench), (0, 0));
    bench.press("ctrl-f");
    bench.type_text("ego");
    bench.press("enter");
    assert_eq!(
        (at(&bench), bench.model.prompt.entry.is_none()),
        (first, true)
    );
    bench.press("ctrl-f enter");
    assert_eq!(at(&bench), second, "an empty word is the last one again");
    bench.press("ctrl-g 9 9 9 9 enter");
    assert_eq!(at(&bench).0 + 1, bench.model.prompt.editor.line_count());
    bench.press("ctrl-g x enter");
    assert!(said(&bench).contains("`x` is not a line number"));
}

#[test]
fn vim_has_modes_and_its_own_keys() {
    let mut bench = with(Keys::Vim);
    assert!(bench.frame(120, 40).contains("1:1 · normal"));
    bench.press("j");
    bench.type_text("dd");
    assert!(line(&bench).starts_with("version"));
    assert!(copied(&bench).is_some_and(|text| text.contains("collision-ego")));
    bench.press("u");
    assert!(line(&bench).starts_with("name") && !bench.model.prompt.is_draft());
    bench.press("ctrl-r u i X esc");
    assert!(line(&bench).contains('X') && bench.model.prompt.editing);
    bench.press("u shift-g");
    assert!(!bench.model.prompt.is_draft());
    assert!(
        bench.model.prompt.editor.cursor().0 > 10,
        "G goes to the end"
    );
    bench.press("g g j f u");
    assert!(!bench.model.prompt.is_draft(), "the u of fu is no undo");
    bench.press("0 v l l y");
    assert_eq!(copied(&bench), Some("nam"));
    bench.press("/");
    assert!(matches!(bench.model.prompt.entry, Some(EntryLine::Find(_))));
    bench.press("esc esc");
    assert!(!bench.model.prompt.editing);
}

#[test]
fn emacs_keeps_its_keys() {
    let mut bench = with(Keys::Emacs);
    bench.press("ctrl-n ctrl-e");
    assert_eq!(bench.model.prompt.editor.cursor(), (1, line(&bench).len()));
    bench.press("ctrl-a ctrl-f");
    assert_eq!(bench.model.prompt.editor.cursor(), (1, 1));
    assert!(bench.model.prompt.entry.is_none());
    bench.press("ctrl-a ctrl-space ctrl-f ctrl-f ctrl-w");
    assert_eq!(copied(&bench), Some("na"));
    bench.press("ctrl-y");
    assert!(line(&bench).starts_with("name"), "{}", line(&bench));
    bench.press("alt-/");
    assert!(matches!(bench.model.prompt.entry, Some(EntryLine::Find(_))));
    bench.press("esc");
    assert!(bench.frame(120, 40).contains("Alt-/ find"));
}

#[test]
fn a_megabyte_is_pasted_at_once_and_more_is_refused() {
    let mut bench = with(Keys::Plain);
    bench.press("ctrl-g 1 0 enter");
    let before = bench.model.prompt.text();
    let text = "A line of words that the user pastes.\n".repeat(26_000);
    let begun = std::time::Instant::now();
    bench.send(Msg::Paste(text.clone()));
    bench.frame(120, 40);
    bench.type_text("typed");
    bench.frame(120, 40);
    assert!(
        begun.elapsed() < Duration::from_secs(5),
        "{:?}",
        begun.elapsed()
    );
    assert_eq!(
        bench.model.prompt.text().len(),
        before.len() + text.len() + 5
    );
    assert!(bench.model.prompt.waits());
    bench.send(Msg::Passed(Duration::from_millis(400)));
    assert!(
        bench
            .model
            .prompt
            .question
            .as_ref()
            .unwrap()
            .prompt
            .system
            .contains("typed")
    );
    bench.send(Msg::Paste(text));
    assert!(
        said(&bench).contains("larger than 1 MiB"),
        "{}",
        said(&bench)
    );
    bench.press("ctrl-z ctrl-z");
    assert_eq!(bench.model.prompt.text(), before);
}

#[test]
fn control_characters_are_shown_and_not_obeyed() {
    let mut bench = with(Keys::Plain);
    bench.press("ctrl-g 1 0 enter");
    bench.send(Msg::Paste("a\u{1b}]52;c;x\u{7}b\r\nc".into()));
    let text = bench.model.prompt.text();
    assert!(text.contains("a␛]52;c;x␇b\nc"));
    assert!(said(&bench).contains("2 control characters"));
    // A file may have them in spite of that.
    let mut bench = Bench::empty();
    let source = Library::shipped("collision-ego.md").unwrap();
    bench.model.prompt.take_up(
        "collision-ego.md".into(),
        source.replacen("You", "\u{1b}[2JYou", 1),
    );
    bench.send(Msg::reply::<Find>(Found::All(Ok(
        nearmiss_formats::bundled().into(),
    ))));
    bench.press("e ctrl-g 1 0 enter");
    let frame = bench.frame(120, 40);
    assert!(frame.contains("␛[2JYou") && !frame.contains('\u{1b}'));
}

#[test]
fn what_is_beside_the_editor_goes_round_and_takes_its_place_where_it_is_narrow() {
    let mut bench = with(Keys::Plain);
    bench.send(Msg::Resize(120, 40));
    let wide = bench.frame(120, 40);
    assert!(wide.contains("template · collision-ego.md") && wide.contains("rendered · ~"));
    assert!(wide.contains(" · free"));
    bench.press("ctrl-o ctrl-o");
    assert!(
        bench
            .frame(120, 40)
            .contains("same as the shipped collision-ego.md")
    );
    bench.press("ctrl-o");
    bench.send(Msg::Resize(80, 24));
    let narrow = bench.frame(80, 24);
    assert!(narrow.contains("template · ") && !narrow.contains(" rendered · "));
    bench.press("ctrl-o");
    let turned = bench.frame(80, 24);
    assert!(turned.contains(" rendered · ") && !turned.contains("template · "));
    bench.press("ctrl-o ctrl-o ctrl-o");
    assert!(bench.frame(80, 24).contains("template · "));
}

#[test]
fn a_broken_line_is_marked_and_tokens_are_compared() {
    let mut bench = with(Keys::Plain);
    bench.model.model = "lab/small".into();
    bench.press("ctrl-g 1 0 enter");
    bench.type_text("Some more words that the shipped template does not have. ");
    let frame = bench.frame(160, 45);
    assert!(
        frame.contains("(+1") && frame.contains("vs shipped) · price unknown"),
        "{frame}"
    );
    assert!(
        frame.contains("+Some more words that the shipped"),
        "{frame}"
    );
    bench.type_text("{{ oops ");
    let frame = bench.frame(160, 45);
    assert_eq!(bench.model.prompt.error_line, Some(10));
    assert!(
        frame.contains("!10 ") && frame.contains("rendered, last good"),
        "{frame}"
    );
    assert!(frame.contains("! collision-ego.md:10"));
    bench.press(&"backspace ".repeat(8));
    assert!(!bench.frame(160, 45).contains("!10 "));
}

#[test]
fn the_mouse_places_the_cursor_and_selects() {
    use ratatui::layout::Position;
    let mut bench = with(Keys::Plain);
    bench.frame(120, 40);
    let (x, y, ..) = bench.model.prompt.editor.drawn.borrow().area;
    bench.send(Msg::Mouse(Mouse::Press(Position::new(x + 2, y + 1))));
    assert_eq!(bench.model.prompt.editor.cursor(), (1, 2));
    bench.send(Msg::Mouse(Mouse::Drag(Position::new(x + 4, y + 1))));
    assert_eq!(bench.model.prompt.editor.selected(), Some("me"));
    bench.send(Msg::Mouse(Mouse::WheelDown(Position::new(x, y))));
    assert_eq!(bench.model.prompt.editor.cursor().0, 4);
    bench.send(Msg::Mouse(Mouse::WheelDown(Position::new(100, 20))));
    assert!(
        bench.model.prompt.scroll > 0,
        "the wheel acts under the pointer"
    );
    assert!(bench.model.toasts.iter().all(|t| t.kind != Notice::Error));
}

#[test]
fn editor_at_80_by_24() {
    let mut bench = with(Keys::Plain);
    bench.send(Msg::Resize(80, 24));
    bench.press("ctrl-g 1 0 enter");
    bench.type_text("Mine. ");
    insta::assert_snapshot!(bench.frame(80, 24));
}

#[test]
fn editor_at_200_by_60() {
    let mut bench = with(Keys::Plain);
    bench.send(Msg::Resize(200, 60));
    bench.press("ctrl-g 1 0 enter");
    bench.type_text("Mine. {{ oops ");
    insta::assert_snapshot!(bench.frame(200, 60));
}

#[test]
fn source_at_80_by_24() {
    let mut bench = Bench::bundled();
    bench.press("space o s");
    let frame = bench.frame(80, 24);
    assert!(frame.contains("<dynamicObstacle id=\"301\">"), "{frame}");
    insta::assert_snapshot!(frame);
}

#[test]
fn source_at_200_by_60() {
    let mut bench = Bench::bundled();
    bench.press("space o s pagedown esc");
    assert!(bench.model.screens.is_empty());
    bench.press("space o s");
    insta::assert_snapshot!(bench.frame(200, 60));
}

#[test]
fn the_question_is_switched_and_what_is_beside_is_scrolled_while_editing() {
    let mut bench = with(Keys::Plain);
    let (text, cp) = (bench.model.prompt.text(), bench.model.techniques.cp);
    bench.press("alt-1");
    assert_ne!(bench.model.techniques.cp, cp);
    bench.frame(120, 40);
    bench.press("alt-down");
    assert_eq!(bench.model.prompt.scroll, 1);
    assert_eq!(bench.model.prompt.text(), text, "nothing was written");
    bench.press("alt-f");
    assert!(bench.model.prompt.editing);
    assert_ne!(bench.model.prompt.text(), text, "that of the next frame");

    let mut bench = with(Keys::Plain);
    bench.model.size = (80, 24);
    bench.press("ctrl-o");
    bench.frame(80, 24);
    bench.press("down");
    assert_eq!(bench.model.prompt.scroll, 1, "in the editor's place");
    bench.press("x");
    assert!(!bench.model.prompt.turned, "what is written into is seen");
}

#[test]
fn undo_takes_words_back_and_redo_brings_them_again_until_something_is_typed() {
    let mut bench = with(Keys::Plain);
    let before = bench.model.prompt.text();
    bench.press("ctrl-g 1 0 enter");
    bench.type_text("one two");
    let typed = bench.model.prompt.text();
    bench.press("ctrl-z");
    assert!(
        line(&bench).starts_with("one You") || line(&bench).starts_with("one {"),
        "{}",
        line(&bench)
    );
    bench.press("ctrl-z ctrl-z");
    assert_eq!(bench.model.prompt.text(), before);
    assert!(!bench.model.prompt.is_draft());
    bench.press("ctrl-y ctrl-y ctrl-y");
    assert_eq!(bench.model.prompt.text(), typed);
    bench.press("ctrl-z x ctrl-y");
    assert!(said(&bench).contains("nothing to redo"), "{}", said(&bench));
    bench.press("enter backspace ctrl-z");
    assert_eq!(
        bench.model.prompt.text().matches('\n').count(),
        before.matches('\n').count() + 1
    );
}

#[test]
fn a_pause_a_line_or_a_move_ends_what_is_undone_at_once() {
    for keys in [Keys::Plain, Keys::Emacs] {
        let mut bench = with(keys);
        let undo = "alt-z";
        bench.press("ctrl-g 1 0 enter");
        if keys == Keys::Emacs {
            bench.press("alt-g 1 0 enter");
        }
        let text = |bench: &Bench| bench.model.prompt.text();
        let at_start = text(&bench);
        // A second without a key parts what was typed.
        bench.type_text("ab");
        let first = text(&bench);
        bench.model.uptime += Duration::from_millis(1500);
        bench.type_text("cd");
        bench.press(undo);
        assert_eq!(text(&bench), first);
        bench.press(undo);
        assert_eq!(text(&bench), at_start);
        // A run of erasing is one step, apart from the typing before it.
        bench.type_text("word");
        let word = text(&bench);
        bench.press("backspace backspace backspace");
        bench.press(undo);
        assert_eq!(text(&bench), word);
        // A new line, and a move there and back.
        bench.press("enter x left right y");
        bench.press(undo);
        assert!(!text(&bench).contains("xy") && text(&bench).contains("word\nx"));
        bench.press(undo);
        assert!(text(&bench).contains("word\n") && !text(&bench).contains("word\nx"));
        bench.press(undo);
        assert_eq!(text(&bench), word);
        bench.press(undo);
        assert_eq!(text(&bench), at_start);
    }
}

#[test]
fn vim_undoes_words_too() {
    let mut bench = with(Keys::Vim);
    let before = bench.model.prompt.text();
    bench.press("i");
    bench.type_text("one two");
    bench.press("esc u");
    assert!(bench.model.prompt.text().starts_with("one +++"));
    bench.press("u");
    assert_eq!(bench.model.prompt.text(), before);
}

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
