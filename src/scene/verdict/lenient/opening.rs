//! Decides whether a bracket opens JSON, or is prose, mathematics or code.

use super::text::{closing, is_bare_key, is_quote, skip_blank, window};

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
