//! Keeps a number and its unit on one line, wherever text is wrapped.

use std::borrow::Cow;

use ratatui::buffer::Buffer;
use ratatui::text::{Line, Text};

/// A blank at which no line is broken.
const NO_BREAK: char = '\u{a0}';

/// What stands behind a number.
const UNITS: [&str; 21] = [
    "m", "s", "ms", "cm", "km", "h", "min", "m/s", "m/s²", "m/s³", "m/s^2", "km/h", "Hz", "%", "°",
    "rad", "degrees", "metres", "meters", "seconds", "second",
];

/// Words that are not broken between a number and its unit.
#[must_use]
pub fn unbroken(words: &str) -> Cow<'_, str> {
    let is_inside = |at: &usize| {
        let is_number = words[..*at].ends_with(|c: char| c.is_ascii_digit());
        is_number && begins_with_unit(&words[at + 1..])
    };
    let blanks = words.match_indices(' ').map(|(at, _)| at);
    let mut joined = String::new();
    let mut from = 0;
    for at in blanks.filter(is_inside) {
        joined.push_str(&words[from..at]);
        joined.push(NO_BREAK);
        from = at + 1;
    }
    if from == 0 {
        return Cow::Borrowed(words);
    }
    joined.push_str(&words[from..]);
    Cow::Owned(joined)
}

fn begins_with_unit(words: &str) -> bool {
    let word = words.split(char::is_whitespace).next().unwrap_or_default();
    let end = |c: char| c.is_ascii_punctuation() && c != '%';
    UNITS.contains(&word.trim_end_matches(end))
}

/// The same of a styled line.
#[must_use]
pub fn line(mut line: Line<'_>) -> Line<'_> {
    for span in &mut line.spans {
        if let Cow::Owned(joined) = unbroken(&span.content) {
            span.content = joined.into();
        }
    }
    line
}

/// The same of styled text.
#[must_use]
pub fn text(mut text: Text<'_>) -> Text<'_> {
    text.lines = text.lines.into_iter().map(line).collect();
    text
}

/// Words on lines of so many columns.
#[must_use]
pub fn wrap<'o>(words: &str, options: impl Into<textwrap::Options<'o>>) -> Vec<String> {
    let joined = unbroken(words);
    let lines = textwrap::wrap(&joined, options).into_iter();
    lines.map(|line| line.replace(NO_BREAK, " ")).collect()
}

/// Whether a character takes one column; a line of such that is no longer than its room is not broken.
#[must_use]
pub fn is_plain(c: char) -> bool {
    c.is_ascii() || c == NO_BREAK
}

/// What was drawn, with plain blanks: so it is copied from the screen.
pub fn plain_blanks(buffer: &mut Buffer) {
    for cell in &mut buffer.content {
        if cell.symbol().starts_with(NO_BREAK) {
            cell.set_symbol(" ");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_units() {
        assert_eq!(unbroken("-12.69 m, behind"), "-12.69\u{a0}m, behind");
        assert_eq!(unbroken("(8.9 m/s)."), "(8.9\u{a0}m/s).");
        assert_eq!(unbroken("5 %"), "5\u{a0}%");
        let untouched = ["in front", "301 is 3 moves", "1 2 3", "m s"];
        assert_eq!(untouched.map(unbroken), untouched);
        assert_eq!(wrap("at step 17 (1.7 s)", 15), ["at step 17", "(1.7 s)"]);
    }
}
