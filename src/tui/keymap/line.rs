//! Editing keys shared by all single-line inputs.

use super::{Code, Key};

/// Writes a character, takes the last one (Backspace), the last word (Ctrl-W) or everything (Ctrl-U); says whether the
/// key was one of these.
pub fn edit_line(line: &mut String, key: Key) -> bool {
    match (key.code, key.writes()) {
        (Code::Backspace, _) => drop(line.pop()),
        (Code::Char('u'), _) if key.ctrl && !key.alt => line.clear(),
        (Code::Char('w'), _) if key.ctrl && !key.alt => without_word(line),
        (_, Some(c)) => line.push(c),
        _ => return false,
    }
    true
}

/// Characters that are pasted into a line at most.
const LINE: usize = 1000;

/// The first line of a pasted text, and no more of it than a line can hold.
#[must_use]
pub fn first_line(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    line.chars().take(LINE).collect()
}

/// Takes the last word and the spaces behind it.
fn without_word(line: &mut String) {
    let words = line.trim_end();
    let start = words
        .char_indices()
        .rev()
        .find(|(_, c)| c.is_whitespace())
        .map_or(0, |(at, space)| at + space.len_utf8());
    line.truncate(start);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn keys_write_and_take_away() {
        let mut line = String::new();
        let mut press = |names: &str| {
            for name in names.split(' ') {
                assert!(edit_line(&mut line, Key::parse(name).unwrap()), "{name}");
            }
            line.clone()
        };
        assert_eq!(press("ü b space c d"), "üb cd");
        assert_eq!(press("space space ctrl-w"), "üb ");
        assert_eq!(press("ctrl-w"), "");
        assert_eq!(press("ctrl-w backspace ctrl-u"), "");
        assert_eq!(press("a space b ctrl-u"), "");
        assert_eq!(press("a b backspace"), "a");
        for other in ["ctrl-a", "alt-u", "enter", "up", "f5"] {
            assert!(!edit_line(&mut line, Key::parse(other).unwrap()), "{other}");
        }
        assert_eq!(line, "a");
    }
}
