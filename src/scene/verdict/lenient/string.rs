//! Where JSON begins and strings end: brackets that are prose, and misplaced quotation marks.

use super::tolerant_reader::Reader;
use super::{Repair, closing, is_bare_key, is_blank, is_quote, skip_blank, window};

/// Bytes looked at behind a quotation mark.
const QUOTE_LOOKAHEAD: usize = 80;

impl Reader<'_> {
    /// The string that begins with the quotation mark `open` at the present place; nothing if the text ends in it.
    pub(super) fn string(&mut self, open: char) -> Option<String> {
        let mut read = String::new();
        self.string_into(open, &mut read).then_some(read)
    }

    /// Reads the same into `read`, as far as it goes; whether it ends before the text does.
    pub(super) fn string_into(&mut self, open: char, read: &mut String) -> bool {
        if open != '"' {
            self.note(Repair::OtherQuotes);
        }
        self.at += open.len_utf8();
        let close = closing(open);
        loop {
            let Some(c) = self.peek() else {
                self.cut();
                return false;
            };
            match c {
                '\\' => self.escape(read),
                '\n' if self.next_line_goes_on() => {
                    self.note(Repair::MissingQuotes);
                    let kept = read.trim_end().trim_end_matches(',').len();
                    read.truncate(kept);
                    return true;
                }
                _ if c == close => {
                    let after = &self.rest()[c.len_utf8()..];
                    if ends_here(after) {
                        self.at += c.len_utf8();
                        return true;
                    }
                    self.note(Repair::InnerQuotes);
                    self.push(read, c);
                }
                _ => {
                    if c.is_control() && (c as u32) < 0x20 {
                        self.note(Repair::ControlCharacters);
                    }
                    self.push(read, c);
                }
            }
        }
    }

    fn push(&mut self, read: &mut String, c: char) {
        read.push(c);
        self.at += c.len_utf8();
    }

    fn escape(&mut self, read: &mut String) {
        let mut chars = self.rest().chars();
        chars.next();
        let Some(c) = chars.next() else {
            self.at = self.text.len();
            return;
        };
        let meant = match c {
            '"' | '\\' | '/' => c,
            'b' => '\u{8}',
            'f' => '\u{c}',
            'n' => '\n',
            'r' => '\r',
            't' => '\t',
            'u' => return self.code(read),
            _ => {
                self.note(Repair::Escapes);
                if !is_quote(c) {
                    read.push('\\');
                }
                c
            }
        };
        read.push(meant);
        self.at += 1 + c.len_utf8();
    }

    /// `\uXXXX`, or two of them for one character.
    fn code(&mut self, read: &mut String) {
        let unit = |text: &str| -> Option<u16> {
            let digits = text.strip_prefix("\\u")?.get(..4)?;
            let hex = digits.bytes().all(|b| b.is_ascii_hexdigit());
            hex.then(|| u16::from_str_radix(digits, 16).ok())?
        };
        // Of a text that is cut here, nothing is meant yet.
        let is_cut = |text: &str| {
            let digits = text.trim_start_matches(['\\', 'u']);
            text.len() < 6 && digits.bytes().all(|b| b.is_ascii_hexdigit())
        };
        if is_cut(self.rest()) {
            self.at = self.text.len();
            return;
        }
        let Some(first) = unit(self.rest()) else {
            self.note(Repair::Escapes);
            read.push_str("\\u");
            self.at += 2;
            return;
        };
        self.at += 6;
        if (0xD800..0xDC00).contains(&first) && is_cut(self.rest()) {
            self.at = self.text.len();
            return;
        }
        let second = unit(self.rest())
            .filter(|s| (0xD800..0xDC00).contains(&first) && (0xDC00..0xE000).contains(s));
        let units = [first, second.unwrap_or(0)];
        let units = if second.is_some() {
            self.at += 6;
            &units[..]
        } else {
            &units[..1]
        };
        for c in char::decode_utf16(units.iter().copied()) {
            read.push(c.unwrap_or_else(|_| {
                self.note(Repair::Escapes);
                char::REPLACEMENT_CHARACTER
            }));
        }
    }

    /// Whether what follows this line break is the next entry or a bracket, so that a quotation mark is missing here.
    fn next_line_goes_on(&self) -> bool {
        let line = window(&self.rest()[1..], QUOTE_LOOKAHEAD).trim_start_matches([' ', '\t', '\r']);
        let Some(first) = line.chars().next() else {
            return false;
        };
        line.starts_with("```") || matches!(first, '}' | ']') || is_key(line)
    }
}

/// Whether a string can end where this follows its quotation mark: never no in valid JSON.
fn ends_here(after: &str) -> bool {
    let near = window(after, QUOTE_LOOKAHEAD);
    let Some(c) = near.chars().next() else {
        return true;
    };
    if c == ',' {
        // In an object a key must follow, in a list a value; in a sentence words do.
        let next = near[1..].trim_start_matches(is_blank);
        let Some(c) = next.chars().next() else {
            return true;
        };
        return is_quote(c)
            || "{[(}])-/#,".contains(c)
            || c.is_ascii_digit()
            || near[1..]
                .split(|c| !is_blank(c))
                .next()
                .is_some_and(|s| s.contains('\n'))
            || ["true", "false", "null", "None", "True", "False"]
                .iter()
                .any(|word| next.starts_with(word))
            || is_bare_key(next);
    }
    if !is_blank(c) {
        return "]}):;`".contains(c) || near.starts_with("//") || near.starts_with("/*");
    }
    let next = near.trim_start_matches(is_blank);
    let blank = &near[..near.len() - next.len()];
    let Some(c) = next.chars().next() else {
        return true;
    };
    blank.contains('\n')
        || ",]}):;`#".contains(c)
        || next.starts_with("//")
        || next.starts_with("/*")
        || is_key(next)
}

/// Whether a text begins with a key in quotation marks and its colon.
fn is_key(text: &str) -> bool {
    let Some(quote) = text.chars().next().filter(|c| is_quote(*c)) else {
        return false;
    };
    let inner = &text[quote.len_utf8()..];
    is_bare_key(inner) && inner.contains(closing(quote))
}

/// Longest first key, bytes.
const WINDOW: usize = 400;

/// Meaning of a bracket.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Opening {
    /// It opens an object with a key, or a list of such objects or of lists.
    Yes,
    /// It opens no object or list; this many bytes can be skipped.
    No(usize),
    /// The text ends before this can be told.
    Cut,
}

/// Looks at the bracket at the beginning of `text`.
pub(super) fn look(text: &str) -> Opening {
    // A run of braces is one opening; passing over all of it at once keeps the search linear.
    let bracket = text.as_bytes()[0];
    let mut run = 0;
    while text.as_bytes().get(run) == Some(&bracket) {
        run += 1;
        run += skip_blank(&text[run..]);
    }
    let rest = &text[run..];
    if bracket == b'[' {
        return if rest.is_empty() {
            Opening::No(run)
        } else if rest.starts_with('{') {
            let braces = rest.len() - rest.trim_start_matches('{').len();
            look_at_key(rest, braces).map_no(run)
        } else if run > 1 || rest.starts_with('(') {
            let number = |c: char| c.is_ascii_digit() || "-+.([".contains(c);
            if rest.trim_start_matches(['(', '[']).starts_with(number) {
                Opening::Yes
            } else {
                Opening::No(run)
            }
        } else {
            Opening::No(run)
        };
    }
    look_at_key(text, run).map_no(run)
}

impl Opening {
    fn map_no(self, length: usize) -> Self {
        match self {
            Self::No(_) => Self::No(length),
            other => other,
        }
    }
}

/// Whether a key and a colon follow the first `from` bytes, possibly after comments.
fn look_at_key(text: &str, from: usize) -> Opening {
    let mut rest = window(&text[from..], WINDOW);
    let cut = from + rest.len() == text.len();
    loop {
        rest = &rest[skip_blank(rest)..];
        let past = if rest.starts_with("//") || rest.starts_with('#') {
            rest.find('\n')
        } else if rest.starts_with("/*") {
            rest.find("*/").map(|p| p + 2)
        } else {
            break;
        };
        match past {
            Some(past) => rest = &rest[past..],
            None => return Opening::No(0),
        }
    }
    let unknown = if cut { Opening::Cut } else { Opening::No(0) };
    let Some(first) = rest.chars().next() else {
        return unknown;
    };
    if first == '}' {
        return Opening::Yes;
    }
    let colon_after = |rest: &str| {
        let rest = &rest[skip_blank(rest)..];
        rest.starts_with(':')
    };
    if is_quote(first) {
        let inner = &rest[first.len_utf8()..];
        return match inner.find([closing(first), '\n']) {
            Some(p) => {
                let close = inner[p..].chars().next().map_or(0, char::len_utf8);
                let after = &inner[p + close..];
                if colon_after(after) || is_bare_key(inner) {
                    Opening::Yes
                } else if after[skip_blank(after)..].is_empty() {
                    unknown
                } else {
                    Opening::No(0)
                }
            }
            None if is_bare_key(inner) => Opening::Yes,
            None => unknown,
        };
    }
    if is_bare_key(rest) {
        Opening::Yes
    } else {
        Opening::No(0)
    }
}
