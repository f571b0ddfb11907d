//! Reads a planner's answers: the message in a line, or what is wrong with it and where.

use serde_json::Value;

use super::protocol::{Answer, OLDEST_PROTOCOL, PROTOCOL, Ready};
use super::{Fault, PlannerFault};

/// Longest text of a planner that is shown, characters.
const MAX_TEXT: usize = 300;

/// The answer in a line.
pub(super) fn answer(line: &str) -> Result<Answer, Fault> {
    let error = match serde_json::from_str(line) {
        Ok(answer) => return Ok(answer),
        Err(error) => error,
    };
    // What is no number of JSON stands there as text then, and can be named with its place.
    let object = serde_json::from_str::<Value>(&with_quoted_infinities(line))
        .ok()
        .filter(Value::is_object);
    let Some(object) = object else {
        let details = if line.trim_start().starts_with('{') {
            format!("no JSON: {error}: {}", shown(line))
        } else {
            format!("{error}: {}; logs belong on standard error", shown(line))
        };
        return Err(Fault::new(PlannerFault::Nonsense, details));
    };
    Err(match wrong_value(&object) {
        Some(wrong) if wrong.not_finite => Fault::new(PlannerFault::NotFinite, wrong.words),
        Some(wrong) => Fault::new(PlannerFault::Nonsense, wrong.words),
        None => Fault::new(PlannerFault::Nonsense, format!("{error}: {}", shown(line))),
    })
}

/// The answer to `hello`.
pub(super) fn ready(line: &str) -> Result<Ready, Fault> {
    // Another version may have another form: its number is looked at first.
    let said: Option<u64> = serde_json::from_str::<serde_json::Value>(line)
        .ok()
        .and_then(|value| value.get("protocol")?.as_u64());
    let spoken = u64::from(OLDEST_PROTOCOL)..=u64::from(PROTOCOL);
    if let Some(version) = said.filter(|version| !spoken.contains(version)) {
        let ours = if OLDEST_PROTOCOL == PROTOCOL {
            PROTOCOL.to_string()
        } else {
            format!("{OLDEST_PROTOCOL} to {PROTOCOL}")
        };
        let details = format!("version {version}; nearmiss speaks {ours}");
        return Err(Fault::new(PlannerFault::WrongVersion, details));
    }
    match answer(line)? {
        Answer::Ready(ready) => Ok(ready),
        Answer::Error(refusal) => Err(Fault::new(PlannerFault::Refused, shown(&refusal.message))),
        Answer::Trajectory(_) => {
            let details = "`trajectory` in answer to `hello`";
            Err(Fault::new(PlannerFault::Nonsense, details))
        }
    }
}

/// Text of a planner as it may be shown: without control characters, and not long.
pub(super) fn shown(text: &str) -> String {
    let mut chars = text
        .trim()
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c });
    let mut words: String = chars.by_ref().take(MAX_TEXT).collect();
    if chars.next().is_some() {
        words.push('…');
    }
    words
}

/// What a field holds.
#[derive(Clone, Copy)]
enum Holds {
    Number,
    Whole,
    Text,
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
}

/// A field of a message: its name, what it holds, and whether it has to be there.
type Field = (&'static str, Holds, bool);

const READY: [Field; 8] = [
    ("protocol", Holds::Whole, true),
    ("name", Holds::Text, true),
    ("version", Holds::Text, false),
    (
        "reference_point",
        Holds::Word(&["rear_axle", "centre"]),
        false,
    ),
    ("predictions", Holds::Flag, false),
    ("history", Holds::Whole, false),
    ("reusable", Holds::Flag, false),
    ("stateless", Holds::Flag, false),
];

const TRAJECTORY: [Field; 1] = [("step", Holds::Whole, true)];

const ERROR: [Field; 2] = [
    ("message", Holds::Text, true),
    ("infeasible", Holds::Flag, false),
];

const STATE: [Field; 4] = [
    ("x", Holds::Number, true),
    ("y", Holds::Number, true),
    ("heading", Holds::Number, true),
    ("velocity", Holds::Number, true),
];

/// These may also be null.
const OF_STATES: [&str; 3] = ["t", "acceleration", "steering"];

/// The messages that a planner writes.
const TYPES: [&str; 3] = ["ready", "trajectory", "error"];

/// A value that is none of its field.
struct Wrong {
    /// Where it is, what it is, and what it should be.
    words: String,
    /// It is NaN or infinite.
    not_finite: bool,
}

/// The first value of a message that is wrong, with its path.
fn wrong_value(message: &Value) -> Option<Wrong> {
    let kind = ("type", Holds::Word(&TYPES), true);
    if let Some(wrong) = of_fields(message, "", &[kind]) {
        return Some(wrong);
    }
    match message["type"].as_str()? {
        "ready" => of_fields(message, "", &READY),
        "error" => of_fields(message, "", &ERROR),
        _ => of_trajectory(message),
    }
}

fn of_trajectory(message: &Value) -> Option<Wrong> {
    let of_message = of_fields(message, "", &TRAJECTORY);
    of_message
        .or_else(|| optional(message, "", "ms"))
        .or_else(|| {
            let Some(states) = message["states"].as_array() else {
                return Some(wrong("states", message.get("states"), "an array"));
            };
            states.iter().enumerate().find_map(|(place, state)| {
                let path = format!("states[{place}]");
                if !state.is_object() {
                    return Some(wrong(&path, Some(state), "an object"));
                }
                let path = format!("{path}.");
                let mut more = OF_STATES.iter();
                of_fields(state, &path, &STATE)
                    .or_else(|| more.find_map(|name| optional(state, &path, name)))
            })
        })
}

/// A number that may be left out or null.
fn optional(object: &Value, path: &str, name: &'static str) -> Option<Wrong> {
    let there = !object.get(name)?.is_null();
    there
        .then(|| of_fields(object, path, &[(name, Holds::Number, false)]))
        .flatten()
}

fn of_fields(object: &Value, path: &str, fields: &[Field]) -> Option<Wrong> {
    fields.iter().find_map(|(name, holds, needed)| {
        let value = object.get(name);
        let right = match (value, holds) {
            (None, _) => !needed,
            (Some(value), Holds::Number) => value.is_number(),
            (Some(value), Holds::Whole) => value.is_i64() || value.is_u64(),
            (Some(value), Holds::Text) => value.is_string(),
            (Some(value), Holds::Flag) => value.is_boolean(),
            (Some(value), Holds::Word(words)) => {
                value.as_str().is_some_and(|said| words.contains(&said))
            }
        };
        let expected = match holds {
            Holds::Number => "a number".into(),
            Holds::Whole => "a whole number".into(),
            Holds::Text => "text".into(),
            Holds::Flag => "true or false".into(),
            Holds::Word(words) => words.join(" or "),
        };
        (!right).then(|| wrong(&format!("{path}{name}"), value, &expected))
    })
}

fn wrong(path: &str, value: Option<&Value>, expected: &str) -> Wrong {
    let Some(value) = value else {
        return Wrong {
            words: format!("`{path}` is missing"),
            not_finite: false,
        };
    };
    let bare = value.as_str().filter(|text| is_infinite(text));
    match bare {
        Some(text) => Wrong {
            words: format!("`{path}` is {text}"),
            not_finite: true,
        },
        None => Wrong {
            words: format!("`{path}` is {}, expected {expected}", excerpt(value)),
            not_finite: false,
        },
    }
}

/// A value as it may be shown beside its path.
fn excerpt(value: &Value) -> String {
    let text = shown(&value.to_string());
    if text.chars().count() > MAX_EXCERPT {
        text.chars().take(MAX_EXCERPT).chain(['…']).collect()
    } else {
        text
    }
}

/// Characters of a wrong value that are shown.
const MAX_EXCERPT: usize = 40;

/// Whether a word is read as a number that is not finite: NaN, Infinity, or one that is too large.
fn is_infinite(word: &str) -> bool {
    word.parse::<f64>().is_ok_and(|number| !number.is_finite())
}

/// A line of JSON in which NaN, Infinity and numbers that are too large, which JSON has not, are texts.
fn with_quoted_infinities(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    let (mut word, mut inside, mut escaped) = (String::new(), false, false);
    let end = |word: &mut String, out: &mut String| {
        if is_infinite(word) {
            *out += &format!("\"{word}\"")
        } else {
            *out += word
        }
        word.clear();
    };
    for c in line.chars() {
        if !inside && (c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.')) {
            word.push(c);
            continue;
        }
        end(&mut word, &mut out);
        out.push(c);
        match c {
            _ if escaped => escaped = false,
            '\\' if inside => escaped = true,
            '"' => inside = !inside,
            _ => {}
        }
    }
    end(&mut word, &mut out);
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_wrong_value_is_named_with_its_path() {
        let state = r#"{"x":1,"y":2,"heading":0,"velocity":3}"#;
        for (states, fault, words) in [
            (
                r#"{"x":null,"y":2,"heading":0,"velocity":3}"#,
                PlannerFault::Nonsense,
                "`states[1].x` is null, expected a number",
            ),
            (
                r#"{"x":1,"y":NaN,"heading":0,"velocity":3}"#,
                PlannerFault::NotFinite,
                "`states[1].y` is NaN",
            ),
            (
                r#"{"x":1,"y":2,"heading":-Infinity,"velocity":3}"#,
                PlannerFault::NotFinite,
                "`states[1].heading` is -Infinity",
            ),
            (
                r#"{"x":1,"y":2,"heading":0,"velocity":1e999}"#,
                PlannerFault::NotFinite,
                "`states[1].velocity` is 1e999",
            ),
            (
                r#"{"x":1,"y":2,"heading":0,"velocity":3,"t":"soon"}"#,
                PlannerFault::Nonsense,
                r#"`states[1].t` is "soon", expected a number"#,
            ),
            (
                r#"{"x":1,"y":2,"heading":0}"#,
                PlannerFault::Nonsense,
                "`states[1].velocity` is missing",
            ),
            (
                "7",
                PlannerFault::Nonsense,
                "`states[1]` is 7, expected an object",
            ),
        ] {
            let line = format!(r#"{{"type":"trajectory","step":0,"states":[{state},{states}]}}"#);
            let found = answer(&line).unwrap_err();
            assert_eq!(
                (found.fault, found.details.as_str()),
                (fault, words),
                "{line}"
            );
        }
        for (line, words) in [
            (r#"{"type":"trajectory","states":[]}"#, "`step` is missing"),
            (
                r#"{"type":"trajectory","step":1.5,"states":[]}"#,
                "`step` is 1.5, expected a whole number",
            ),
            (
                r#"{"type":"trajectory","step":1,"states":{}}"#,
                "`states` is {}, expected an array",
            ),
            (
                r#"{"type":"go"}"#,
                r#"`type` is "go", expected ready or trajectory or error"#,
            ),
            (r#"{"step":1}"#, "`type` is missing"),
            (r#"{"type":"error"}"#, "`message` is missing"),
        ] {
            let found = answer(line).unwrap_err();
            assert_eq!(
                (found.fault, found.details.as_str()),
                (PlannerFault::Nonsense, words)
            );
        }
        let log = answer("planning NaN ...").unwrap_err();
        assert!(
            log.details.contains("logs belong on standard error"),
            "{log:?}"
        );
        // A name is no number.
        let ready = r#"{"type":"ready","protocol":1,"name":"nan \" inf","version":"NaN"}"#;
        assert!(answer(ready).is_ok());
    }
}
