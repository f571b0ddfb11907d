//! Reads the reasons of an answer whose JSON begins with them, also while they still arrive.

use super::text::skip_blank;
use super::tolerant_reader::Reader;

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
        format!("{}{{{after}", &answer[..brace])
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
mod tests {
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
