//! Undo and redo in the editor: by words, pauses, lines and moves.

use std::time::Duration;

use super::bench::Bench;
use super::editing::{line, said, with};
use nearmiss_settings::Keys;

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
