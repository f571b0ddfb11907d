//! Lenient JSON: embedded in text, with mistakes of people and Python, possibly truncated.
//!
//! One pass from left to right with bounded look-ahead and depth, linear in any text. Valid JSON is read exactly; every
//! departure from it is reported as a [`Repair`].

mod string;
mod tolerant_reader;

use std::collections::BTreeSet;
use std::fmt;

use serde_json::Value;

use string::Opening;
use tolerant_reader::Reader;

/// Deeper values end the reading of the piece they are in.
const MOST_DEPTH: usize = 48;

/// An object or list found in a text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct JsonPiece {
    /// What it holds; of a broken or cut one, what was complete.
    pub value: Value,
    /// What was put right.
    pub repairs: BTreeSet<Repair>,
    /// How it ends.
    pub end: End,
}

/// How a piece ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// With its own bracket.
    Whole,
    /// With the text.
    CutOff,
    /// With something that is no JSON by any reading.
    Broken,
}

/// All outermost objects and lists of objects in a text, in order; empty ones are left out.
pub(super) fn read(text: &str) -> Vec<JsonPiece> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(step) = text[at..].find(['{', '[']) {
        at += step;
        match string::look(&text[at..]) {
            Opening::No(length) => at += length,
            Opening::Cut => {
                found.push(JsonPiece {
                    value: Value::Null,
                    repairs: BTreeSet::new(),
                    end: End::CutOff,
                });
                break;
            }
            Opening::Yes => {
                let mut reader = Reader::new(text, at);
                let value = reader.outermost();
                at = reader.at();
                let (repairs, end) = reader.finish();
                if !is_empty(&value) || end == End::CutOff {
                    found.push(JsonPiece {
                        value,
                        repairs,
                        end,
                    });
                }
            }
        }
    }
    found
}

/// The last whole object in a text, with mistakes of people and Python put right.
#[must_use]
pub fn object_in(text: &str) -> Option<Value> {
    let whole = |piece: &JsonPiece| piece.end == End::Whole && piece.value.is_object();
    let pieces = read(text).into_iter();
    pieces.rev().find(whole).map(|piece| piece.value)
}

fn is_empty(value: &Value) -> bool {
    match value {
        Value::Object(map) => map.is_empty(),
        Value::Array(items) => items.iter().all(is_empty),
        Value::Null => true,
        _ => false,
    }
}

/// A departure from JSON whose meaning is plain all the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::verdict) enum Repair {
    /// `//`, `/* */` or `#`.
    Comments,
    /// A comma before a bracket, or two commas.
    ExtraCommas,
    /// No comma between two entries.
    MissingCommas,
    /// `{{` and `}}`, as templates escape braces.
    DoubledBraces,
    /// `'…'` or typographic quotation marks.
    OtherQuotes,
    /// A quotation mark is missing.
    MissingQuotes,
    /// Quotation marks inside a string, without a backslash.
    InnerQuotes,
    /// A key without quotation marks.
    BareKeys,
    /// Text without quotation marks.
    BareWords,
    /// `None`, `True`, `False` and the like.
    Literals,
    /// NaN or an infinity.
    NotANumber,
    /// `+1`, `.5`, `1.`, `007`.
    Numbers,
    /// Line breaks or other control characters in a string.
    ControlCharacters,
    /// A backslash before something that needs none.
    Escapes,
    /// A key without a value.
    MissingValues,
    /// `(…)` for a list, or a bracket of one kind closed by another or not at all.
    Brackets,
    /// A duplicate key with different values.
    DoubledKeys,
}

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Comments => "comments were skipped",
            Self::ExtraCommas => "superfluous commas were skipped",
            Self::MissingCommas => "missing commas were added",
            Self::DoubledBraces => "doubled braces were read as single ones",
            Self::OtherQuotes => "other quotation marks were read as \"",
            Self::MissingQuotes => "missing quotation marks were added",
            Self::InnerQuotes => "quotation marks inside strings were kept",
            Self::BareKeys => "unquoted keys were read",
            Self::BareWords => "unquoted strings were read",
            Self::Literals => "None, True or False were read as null, true or false",
            Self::NotANumber => "invalid numbers were read as null",
            Self::Numbers => "numbers in other notations were read",
            Self::ControlCharacters => "line breaks inside strings were kept",
            Self::Escapes => "unknown escapes were kept",
            Self::MissingValues => "missing values were read as null",
            Self::Brackets => "brackets were corrected",
            Self::DoubledKeys => "for duplicate keys the last value was used",
        })
    }
}

/// Bytes of white space at the beginning of a text, with those that only typesetters know.
fn skip_blank(text: &str) -> usize {
    text.len() - text.trim_start_matches(is_blank).len()
}

/// White space, and what has no width.
fn is_blank(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\u{feff}' | '\u{200b}')
}

/// Whether a character can open a string.
fn is_quote(c: char) -> bool {
    matches!(c, '"' | '\'' | '“' | '”' | '‘' | '’')
}

/// The character that closes what another one opened.
fn closing(open: char) -> char {
    match open {
        '“' | '”' => '”',
        '‘' | '’' => '’',
        other => other,
    }
}

/// Longest key without quotation marks.
const LONGEST_KEY: usize = 64;

/// Whether a text begins with a word or a few that could be a key, perhaps the end of a quotation, and a colon.
fn is_bare_key(text: &str) -> bool {
    bare_key(text).is_some()
}

/// The key at the beginning of a text that has no quotation mark before it, and its bytes up to the colon.
fn bare_key(text: &str) -> Option<(&str, usize)> {
    let mut end = 0;
    for c in text.chars() {
        let inside = c.is_alphanumeric() || matches!(c, '_' | '-' | '$');
        if !(inside || c == ' ' && end > 0) || end > LONGEST_KEY {
            break;
        }
        end += c.len_utf8();
    }
    let key = text[..end].trim_end();
    let mut rest = &text[end..];
    let mut length = end;
    if let Some(quote) = rest.chars().next().filter(|c| is_quote(*c)) {
        rest = &rest[quote.len_utf8()..];
        length += quote.len_utf8();
    }
    let near = window(rest, LONGEST_KEY);
    let blank = near.len() - near.trim_start_matches([' ', '\t']).len();
    let letter = key.chars().any(char::is_alphanumeric);
    (letter && rest[blank..].starts_with(':') && !rest[blank..].starts_with("://"))
        .then_some((key, length + blank))
}

/// The first bytes of a text, about `most` of them.
fn window(text: &str, most: usize) -> &str {
    let mut end = text.len().min(most);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}

/// An answer whose JSON begins with its justification, taken apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReasonedAnswer {
    /// The justification as text, as far as it has arrived.
    pub reasons: String,
    /// The answer without it; empty until the justification is whole.
    pub rest: String,
}

/// How the answer that is asked for begins.
const KEY: &str = "\"justification\"";

/// Takes an answer apart whose JSON, perhaps in a fence, begins with its justification; `None` for all others. Every
/// beginning of such an answer gives the beginning of its reasons.
#[must_use]
pub fn reasons_first(answer: &str) -> Option<ReasonedAnswer> {
    let brace = start(answer)?;
    let mut at = brace;
    for part in ["{", KEY, ":"] {
        let rest = &answer[at..];
        if !rest.starts_with(part) {
            return part.starts_with(rest).then(ReasonedAnswer::empty);
        }
        at += part.len();
        at += skip_blank(&answer[at..]);
    }
    if at == answer.len() {
        return Some(ReasonedAnswer::empty());
    }
    if !answer[at..].starts_with('"') {
        return None;
    }
    let mut reader = Reader::new(answer, at);
    let mut reasons = String::new();
    if !reader.string_into('"', &mut reasons) {
        let rest = String::new();
        return Some(ReasonedAnswer { reasons, rest });
    }
    let rest = answer[reader.at()..].trim_start();
    let after = rest.strip_prefix(',').unwrap_or(rest);
    let rest = if after.is_empty() {
        String::new()
    } else {
        // A line that follows keeps its own beginning.
        format!("{}{{{}", &answer[..brace], after.trim_start_matches(' '))
    };
    Some(ReasonedAnswer { reasons, rest })
}

impl ReasonedAnswer {
    fn empty() -> Self {
        Self {
            reasons: String::new(),
            rest: String::new(),
        }
    }
}

/// Where the JSON begins: after blanks and the first line of a fence.
fn start(answer: &str) -> Option<usize> {
    let mut at = skip_blank(answer);
    if answer[at..].starts_with("```") {
        let line = answer[at..].split_inclusive('\n').next()?;
        let word = line.trim_matches(['`', '\n', '\r', ' ']);
        if !["", "json"].contains(&word) {
            return None;
        }
        at += line.len();
        at += skip_blank(&answer[at..]);
    }
    (at < answer.len()).then_some(at)
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod reasons_tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    const ANSWER: &str = "```json\n{\n  \"justification\": \"1. \\\"Car\\\" 7 is 2\\u00a0m ahead \\ud83d\\ude97.\\n2. It \
         closes.\",\n  \"obstacles\": [],\n  \"collision\": true\n}\n```";
    const REASONS: &str = "1. \"Car\" 7 is 2\u{a0}m ahead 🚗.\n2. It closes.";

    #[test]
    fn reasons_are_text_and_the_rest_stays_json() {
        let apart = reasons_first(ANSWER).unwrap();
        assert_eq!(apart.reasons, REASONS);
        let wanted = "```json\n{\n  \"obstacles\": [],\n  \"collision\": true\n}\n```";
        assert_eq!(apart.rest, wanted);
        let bare = reasons_first("{\"justification\":\"so\",\"collision\":true}").unwrap();
        assert_eq!(
            (bare.reasons.as_str(), bare.rest.as_str()),
            ("so", "{\"collision\":true}")
        );
        for other in [
            "It closes.\n{\"justification\": \"so\"}",
            "{\"collision\": true, \"justification\": \"so\"}",
            "{\"justification\": null}",
            "```python\n{\"justification\": \"so\"}",
            "",
        ] {
            assert_eq!(reasons_first(other), None, "{other}");
        }
    }

    #[test]
    fn what_arrives_only_grows() {
        let mut before = ReasonedAnswer::empty();
        let begin = ANSWER.find('{').unwrap() + 1;
        for end in begin..=ANSWER.len() {
            let now = reasons_first(&ANSWER[..end]).unwrap();
            let grows = now.reasons.starts_with(&before.reasons);
            assert!(grows, "{end}: {before:?} {now:?}");
            assert!(REASONS.starts_with(&now.reasons), "{end}: {now:?}");
            assert!(
                now.rest.is_empty() || now.reasons == REASONS,
                "{end}: {now:?}"
            );
            before = now;
        }
        assert_eq!(before.reasons, REASONS);
    }
}
