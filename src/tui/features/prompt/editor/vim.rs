//! Vim's normal mode where the crate has none of it: counts, operators over any motion, text objects.

use edtui::actions::{Execute, SwitchMode};
use edtui::clipboard::ClipboardTrait;
use edtui::{EditorMode, Index2};

use super::{Change, Editor, Shared};
use crate::keymap::{Code, Key, editor_input};

/// A command that is not whole yet.
#[derive(Debug, Default)]
pub struct Pending {
    /// The digits before the next key.
    count: usize,
    /// `d`, `c` or `y`, and its own count.
    operator: Option<(char, usize)>,
    /// `i` or `a` of a text object, `f` or `t` before a character, or `g`.
    prefix: Option<char>,
}

/// The last change, for `.`.
#[derive(Debug, Default, Clone, Copy)]
pub enum LastChange {
    /// The crate made it and repeats it.
    #[default]
    Crate,
    /// A key, so many times.
    Key(char, usize),
    /// An operator, its count, and what it was over.
    Operator(char, usize, Option<char>, char),
}

/// What became of a key of the normal mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NormalKey {
    /// It waits for more, or moved the cursor.
    Taken,
    /// The text changed.
    Changed,
    /// It is for the crate.
    Left,
}

/// No count is larger: a key is repeated so often.
const MOST: usize = 9999;

impl Editor {
    /// Forgets a command that is not whole; says whether there was one.
    pub fn forget_pending(&mut self) -> bool {
        let was = self.is_pending();
        self.pending = Pending::default();
        was
    }

    /// Whether a command is not whole.
    #[must_use]
    pub fn is_pending(&self) -> bool {
        let Pending {
            count,
            operator,
            prefix,
        } = &self.pending;
        *count > 0 || operator.is_some() || prefix.is_some()
    }

    /// A character in the normal mode.
    pub fn normal_key(&mut self, c: char) -> NormalKey {
        let is_digit = c.is_ascii_digit() && (c != '0' || self.pending.count > 0);
        if is_digit && self.pending.prefix.is_none() {
            let digit = c as usize - '0' as usize;
            self.pending.count = (self.pending.count * 10 + digit).min(MOST);
            return NormalKey::Taken;
        }
        let count = self.pending.count;
        match (self.pending.operator, self.pending.prefix, c) {
            (None, None, 'd' | 'c' | 'y') => {
                self.pending.operator = Some((c, count.max(1)));
                self.pending.count = 0;
                NormalKey::Taken
            }
            (Some(_), None, 'i' | 'a' | 'f' | 't' | 'g') => {
                self.pending.prefix = Some(c);
                NormalKey::Taken
            }
            (None, None, 'g') if count > 0 => {
                self.pending.prefix = Some(c);
                NormalKey::Taken
            }
            (Some((operator, times)), prefix, _) => {
                self.pending = Pending::default();
                self.operate(operator, times * count.max(1), prefix, c)
            }
            (None, prefix, _) => {
                self.pending = Pending::default();
                let to_line = c == 'G' || (prefix, c) == (Some('g'), 'g');
                match count {
                    0 if c == '.' => self.repeat(1),
                    0 if c == 'p' && self.puts_below() => {
                        self.put_below(1);
                        NormalKey::Changed
                    }
                    0 => {
                        if "xXpPJ~DCiaoIAOsSr".contains(c) {
                            self.last_change = LastChange::Crate;
                        }
                        NormalKey::Left
                    }
                    _ if to_line => {
                        self.go(count - 1, 0, false);
                        NormalKey::Taken
                    }
                    _ if c == 'p' && self.puts_below() => {
                        self.put_below(count);
                        NormalKey::Changed
                    }
                    _ if "iaoIAO".contains(c) => {
                        self.last_change = LastChange::Crate;
                        NormalKey::Left
                    }
                    _ if "ftvV/:*".contains(c) => NormalKey::Left,
                    _ if c == 'u' => self.undo_times(count),
                    _ if c == '.' => self.repeat(count),
                    _ => {
                        let did = self.feed(c, count);
                        if did == NormalKey::Changed {
                            self.last_change = LastChange::Key(c, count);
                        }
                        did
                    }
                }
            }
        }
    }

    fn undo_times(&mut self, times: usize) -> NormalKey {
        let done = (0..times).take_while(|_| self.undo(true)).count();
        if done > 0 {
            NormalKey::Changed
        } else {
            NormalKey::Taken
        }
    }

    /// Makes the last change again.
    fn repeat(&mut self, times: usize) -> NormalKey {
        match self.last_change {
            LastChange::Crate => self.feed('.', times),
            LastChange::Key(c, count) => self.feed(c, if times > 1 { times } else { count }),
            LastChange::Operator(operator, count, prefix, c) => {
                self.operate(operator, if times > 1 { times } else { count }, prefix, c)
            }
        }
    }

    /// Whether `p` puts whole lines below the last one, where the crate puts them above.
    fn puts_below(&self) -> bool {
        self.clip.borrow().text.starts_with('\n') && self.state.cursor.row + 1 == self.line_count()
    }

    fn put_below(&mut self, times: usize) {
        let lines = self.clip.borrow().text.repeat(times);
        let end = self.text.len();
        let row = self.line_count();
        self.splice(end..end, &lines);
        self.go(row, 0, false);
    }

    /// Gives a key to the crate so many times.
    fn feed(&mut self, c: char, times: usize) -> NormalKey {
        let mut changed = false;
        for _ in 0..times {
            let before = self.state.cursor;
            let did = editor_input(Key::plain(Code::Char(c)))
                .is_some_and(|input| self.input(input, Change::Whole));
            changed |= did;
            if !did && self.state.cursor == before {
                break;
            }
        }
        if changed {
            NormalKey::Changed
        } else {
            NormalKey::Taken
        }
    }

    /// An operator over a motion or an object. What the crate knows it does itself, so that `.` repeats it.
    fn operate(
        &mut self,
        operator: char,
        times: usize,
        prefix: Option<char>,
        c: char,
    ) -> NormalKey {
        let is_known = match (operator, prefix) {
            ('d' | 'c', None) => c == 'w' || c == 'W' || (c == 'd' && operator == 'd'),
            ('d' | 'c', Some('i')) => c == 'w',
            ('d' | 'c', Some('f' | 't')) => true,
            ('y', None) => c == 'y',
            _ => false,
        };
        if times == 1 && is_known {
            self.last_change = LastChange::Crate;
            let keys = [Some(operator), prefix, Some(c)];
            let mut changed = false;
            for key in keys.into_iter().flatten() {
                changed |= self.feed(key, 1) == NormalKey::Changed;
            }
            return if changed {
                NormalKey::Changed
            } else {
                NormalKey::Taken
            };
        }
        let begin = self.state.cursor;
        let range = match (prefix, c) {
            (None, _) if c == operator => Some(self.rows(begin.row, begin.row + times - 1)),
            (None, 'j') => Some(self.rows(begin.row, begin.row + times)),
            (None, 'k') => Some(self.rows(begin.row.saturating_sub(times), begin.row)),
            (None, 'G') => Some(self.rows(begin.row, usize::MAX)),
            (Some('g'), 'g') => Some(self.rows(0, begin.row)),
            (Some('i' | 'a'), _) => self.object(prefix == Some('a'), c),
            (Some('f' | 't'), _) => self.until(prefix == Some('t'), c, times),
            (None, _) => self.moved(operator, c, times),
            _ => None,
        };
        self.state.cursor = begin;
        let Some((range, by_lines)) = range.filter(|(range, _)| !range.is_empty()) else {
            return NormalKey::Taken;
        };
        let words = self.text[range.clone()].to_string();
        let kept = if by_lines {
            format!("\n{}", words.trim_end_matches('\n'))
        } else {
            words
        };
        Shared(self.clip.clone()).set_text(kept);
        if operator == 'y' {
            return NormalKey::Taken;
        }
        self.last_change = LastChange::Operator(operator, times, prefix, c);
        // A changed line stays, empty.
        let rest = if operator == 'c' && by_lines {
            "\n"
        } else {
            ""
        };
        let start = range.start;
        self.splice(range, rest);
        self.state.cursor = Self::place(&self.text, start.min(self.text.len()));
        if operator == 'c' {
            SwitchMode(EditorMode::Insert).execute(&mut self.state);
        }
        self.clamp();
        NormalKey::Changed
    }

    /// Whole lines, with the last line break.
    fn rows(&self, first: usize, last: usize) -> (std::ops::Range<usize>, bool) {
        let end = match last.min(self.line_count() - 1) + 1 {
            end if end < self.line_count() => self.byte(Index2::new(end, 0)),
            _ => self.text.len(),
        };
        (self.byte(Index2::new(first, 0))..end, true)
    }

    /// From the cursor to where a motion leads.
    fn moved(
        &mut self,
        operator: char,
        c: char,
        times: usize,
    ) -> Option<(std::ops::Range<usize>, bool)> {
        let begin = self.byte(self.state.cursor);
        // To change a word leaves the space behind it.
        let c = if operator == 'c' && c == 'w' { 'e' } else { c };
        if !"hlwbe0_^${}%".contains(c) {
            return None;
        }
        let row = self.state.cursor.row;
        self.feed(c, times);
        let mut end = self.byte(self.state.cursor);
        let length = self.state.lines.len_col(self.state.cursor.row).unwrap_or(0);
        let at_last = self.state.cursor.col + 1 >= length;
        let is_inclusive =
            "e$%".contains(c) || (c == 'w' && at_last && self.state.cursor.row == row);
        if is_inclusive && end >= begin {
            end += self.text[end..]
                .chars()
                .next()
                .filter(|c| *c != '\n')
                .map_or(0, char::len_utf8);
        }
        Some((begin.min(end)..begin.max(end), false))
    }

    /// From the cursor to a character of the line, or up to it.
    fn until(&self, before: bool, c: char, times: usize) -> Option<(std::ops::Range<usize>, bool)> {
        let begin = self.byte(self.state.cursor);
        let line = self.text[begin..].split('\n').next()?;
        let mut found = line.char_indices().skip(1).filter(|(_, other)| *other == c);
        let (at, _) = found.nth(times - 1)?;
        let end = if before { at } else { at + c.len_utf8() };
        Some((begin..begin + end, false))
    }

    /// A text object around the cursor: a word, a paragraph, or what stands between quotes or brackets.
    fn object(&self, around: bool, c: char) -> Option<(std::ops::Range<usize>, bool)> {
        let at = self.byte(self.state.cursor);
        let row = self.state.cursor.row;
        if c == 'p' {
            let is_empty = |row: &usize| self.lines().nth(*row).is_none_or(Vec::is_empty);
            let first = (0..row)
                .rev()
                .take_while(|row| !is_empty(row))
                .last()
                .unwrap_or(row);
            let last = (row + 1..self.line_count())
                .take_while(|row| !is_empty(row))
                .last();
            let end = last.unwrap_or(row) + usize::from(around);
            return Some(self.rows(first, end));
        }
        let begin = self.byte(Index2::new(row, 0));
        let line = self.text[begin..].split('\n').next()?;
        let inside = at - begin;
        if c == 'w' {
            let class = |c: char| match c {
                _ if c.is_whitespace() => 0,
                _ if c.is_alphanumeric() || c == '_' => 1,
                _ => 2,
            };
            let here = class(line[inside..].chars().next()?);
            let back = line[..inside].char_indices().rev();
            let start = back
                .take_while(|(_, c)| class(*c) == here)
                .last()
                .map_or(inside, |(at, _)| at);
            let ahead = |from: usize, kind| {
                let run: usize = line[from..]
                    .chars()
                    .take_while(|c| class(*c) == kind)
                    .map(char::len_utf8)
                    .sum();
                from + run
            };
            let mut end = ahead(inside, here);
            if around {
                end = ahead(end, 0);
            }
            return Some((begin + start..begin + end, false));
        }
        let (open, close) = match c {
            '"' | '\'' | '`' => (c, c),
            '(' | ')' | 'b' => ('(', ')'),
            '[' | ']' => ('[', ']'),
            '{' | '}' | 'B' => ('{', '}'),
            '<' | '>' => ('<', '>'),
            _ => return None,
        };
        let (start, end) = if open == close {
            let places: Vec<usize> = line.match_indices(open).map(|(at, _)| begin + at).collect();
            let pair = places.chunks_exact(2).find(|pair| pair[1] >= at)?;
            (pair[0], pair[1])
        } else {
            self.brackets(at, open, close)?
        };
        Some(if around {
            (start..end + close.len_utf8(), false)
        } else {
            (start + open.len_utf8()..end, false)
        })
    }

    /// The innermost pair of brackets around a byte, over lines.
    fn brackets(&self, at: usize, open: char, close: char) -> Option<(usize, usize)> {
        let mut depth = 0_usize;
        let here = self.text[at..].chars().next()?;
        let before = self.text[..at].char_indices().rev();
        let from = (here == open).then_some(at);
        let start = from.or_else(|| {
            before.clone().find_map(|(at, c)| {
                depth += usize::from(c == close);
                let is_it = c == open && depth == 0;
                depth -= usize::from(c == open && depth > 0);
                is_it.then_some(at)
            })
        })?;
        let mut depth = 0_usize;
        let behind = self.text[start + open.len_utf8()..].char_indices();
        let end = behind
            .map(|(at, c)| (start + open.len_utf8() + at, c))
            .find_map(|(at, c)| {
                depth += usize::from(c == open);
                let is_it = c == close && depth == 0;
                depth -= usize::from(c == close && depth > 0);
                is_it.then_some(at)
            })?;
        Some((start, end))
    }

    /// The word under the cursor, or the next one in its line.
    #[must_use]
    pub fn word(&self) -> Option<String> {
        let line = self.lines().nth(self.state.cursor.row)?;
        let is_word = |c: &char| c.is_alphanumeric() || *c == '_';
        let col = self.state.cursor.col.min(line.len());
        let at = col + line[col..].iter().position(is_word)?;
        let start = line[..at]
            .iter()
            .rposition(|c| !is_word(c))
            .map_or(0, |at| at + 1);
        Some(line[start..].iter().take_while(|c| is_word(c)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_settings::Keys;

    /// The text, and the line and column of the cursor, after keys in the normal mode.
    fn after(text: &str, at: (usize, usize), keys: &str) -> (String, (usize, usize)) {
        let mut editor = Editor::new(Keys::Vim, text);
        editor.go(at.0, at.1, false);
        for c in keys.chars() {
            if editor.normal_key(c) == NormalKey::Left {
                editor.feed(c, 1);
            }
        }
        (editor.text().to_string(), editor.cursor())
    }

    #[test]
    fn counts_repeat_motions_and_commands() {
        let ten: String = (1..=10).map(|i| format!("line {i} a b c\n")).collect();
        assert_eq!(after(&ten, (0, 0), "5j").1.0, 5);
        assert_eq!(after(&ten, (0, 0), "9G").1.0, 8);
        assert_eq!(after(&ten, (5, 0), "3gg").1.0, 2);
        assert_eq!(after(&ten, (5, 0), "2k").1.0, 3);
        assert_eq!(after("abcdef", (0, 1), "3x").0, "aef");
        assert_eq!(after("a\nb\nc\nd", (1, 0), "2dd").0, "a\nd");
        assert_eq!(after("a\nb\nc\nd", (0, 0), "dj").0, "c\nd");
        assert_eq!(after("a\nb\nc\nd", (1, 0), "dG").0, "a\n");
        assert_eq!(after("a\nb\nc\nd", (2, 0), "dgg").0, "d");
        assert_eq!(after("one two three four", (0, 0), "d2w").0, "three four");
        assert_eq!(after("one two three four", (0, 0), "2d1w").0, "three four");
        assert_eq!(after("one two", (0, 3), "d$").0, "one");
        assert_eq!(after("one two", (0, 4), "d0").0, "two");
        assert_eq!(after("a.b.c.d", (0, 0), "d2f.").0, "c.d");
        assert_eq!(after("a\nb", (0, 0), "2yyjp").0, "a\nb\na\nb");
        assert_eq!(after("a b c d e f g", (0, 0), "d2w.").0, "e f g");
        assert_eq!(after("abcdefgh", (0, 0), "3x.").0, "gh");
        assert_eq!(after("one two three four", (0, 0), "dw.").0, "three four");
        assert_eq!(after("abcdef", (0, 0), "xxxx2u").0, "cdef");
    }

    #[test]
    fn objects_are_words_paragraphs_quotes_and_brackets() {
        assert_eq!(after("one two three", (0, 5), "daw").0, "one three");
        assert_eq!(after("one two three", (0, 5), "diw").0, "one  three");
        assert_eq!(
            after("say \"some words\" now", (0, 8), "di\"").0,
            "say \"\" now"
        );
        assert_eq!(after("f(a, (b), c)", (0, 2), "di(").0, "f()");
        assert_eq!(after("f(a, (b), c)", (0, 6), "da(").0, "f(a, , c)");
        assert_eq!(after("{{ ego }}", (0, 4), "di{").0, "{{}}");
        assert_eq!(after("a\n\nb\nc\n\nd", (2, 0), "dip").0, "a\n\n\nd");
        assert_eq!(after("a\n\nb\nc\n\nd", (2, 0), "dap").0, "a\n\nd");
    }

    #[test]
    fn to_change_writes_in_place() {
        let mut editor = Editor::new(Keys::Vim, "one two three");
        for c in "c2w".chars() {
            editor.normal_key(c);
        }
        assert_eq!((editor.text(), editor.mode()), (" three", "insert"));
        assert!(editor.write('x'));
        assert_eq!(editor.text(), "x three");
    }

    #[test]
    fn an_insertion_is_the_last_change() {
        for insertion in ["i", "2A", "o", "r"] {
            let mut editor = Editor::new(Keys::Vim, "a b c d e f");
            for c in "d2w".chars().chain(insertion.chars()) {
                editor.normal_key(c);
            }
            let of_crate = matches!(editor.last_change, LastChange::Crate);
            assert!(of_crate, "{insertion}");
        }
    }

    #[test]
    fn the_word_under_the_cursor() {
        let mut editor = Editor::new(Keys::Vim, "the obstacle's id");
        editor.go(0, 6, false);
        assert_eq!(editor.word().as_deref(), Some("obstacle"));
        editor.go(0, 3, false);
        assert_eq!(editor.word().as_deref(), Some("obstacle"));
    }
}
