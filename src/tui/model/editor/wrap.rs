//! Soft wrapping of long lines, between words where possible.

use std::ops::Range;

use unicode_width::UnicodeWidthChar;

/// Columns of a tab.
const TAB: usize = 4;

/// Columns that a character takes; what cannot be shown takes the one of its sign.
#[must_use]
pub fn width_of(c: char) -> usize {
    match c {
        '\t' => TAB,
        _ => c.width().unwrap_or(1),
    }
}

/// The characters of each row of the screen; at least one row, and none is empty but that of an empty line.
#[must_use]
pub fn rows(line: &[char], width: usize) -> Vec<Range<usize>> {
    let width = width.max(TAB);
    let mut rows = Vec::new();
    let (mut start, mut used, mut space) = (0, 0, None);
    for (i, &c) in line.iter().enumerate() {
        let wide = width_of(c);
        if used + wide > width {
            let end = space.filter(|&at| at > start).unwrap_or(i);
            rows.push(start..end);
            start = end;
            used = line[start..i].iter().map(|&c| width_of(c)).sum();
            space = None;
        }
        used += wide;
        if c == ' ' {
            space = Some(i + 1);
        }
    }
    rows.push(start..line.len());
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrapped(text: &str, width: usize) -> Vec<String> {
        let line: Vec<char> = text.chars().collect();
        let rows = rows(&line, width);
        rows.into_iter().map(|r| line[r].iter().collect()).collect()
    }

    #[test]
    fn between_words_and_inside_long_ones() {
        assert_eq!(wrapped("", 10), [""]);
        assert_eq!(wrapped("one two three", 8), ["one two ", "three"]);
        assert_eq!(wrapped("abcdefghij", 4), ["abcd", "efgh", "ij"]);
        assert_eq!(wrapped("漢字漢字", 5), ["漢字", "漢字"]);
        assert_eq!(wrapped("a\tb", 5), ["a\t", "b"]);
    }
}
