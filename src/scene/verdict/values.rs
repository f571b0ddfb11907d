//! Parses values as models write them: ids, scores, yes and no, nothing; and keys in any spelling.

use serde_json::{Map, Value};

pub(super) type Object = Map<String, Value>;

/// Words for nothing.
const NOTHING: [&str; 12] = [
    "",
    "-",
    "–",
    "none",
    "null",
    "nil",
    "nan",
    "na",
    "n/a",
    "nobody",
    "not applicable",
    "not available",
];

/// A key without case, underscores and the like.
pub(super) fn plain(key: &str) -> String {
    let letters = key.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// The value of the first of `names` (in [`plain`] spelling, without a plural s) that is a key here.
pub(super) fn get<'a>(object: &'a Object, names: &[&str]) -> Option<&'a Value> {
    let matching = |wanted: &str| {
        object.iter().find(|(key, _)| {
            let key = plain(key);
            key == wanted || key.strip_suffix('s') == Some(wanted)
        })
    };
    names
        .iter()
        .find_map(|name| matching(name))
        .map(|(_, value)| value)
}

/// The object, then those one key further in, and so on to the third level.
pub(super) fn levels(object: &Object) -> [Vec<&Object>; 3] {
    let first = vec![object];
    let second = further(&first);
    let third = further(&second);
    [first, second, third]
}

fn further<'a>(outer: &[&'a Object]) -> Vec<&'a Object> {
    let values = outer.iter().flat_map(|object| object.values());
    values.filter_map(Value::as_object).collect()
}

/// The first of `names` that is a key of the object or of one inside it, the nearest level first.
pub(super) fn find<'a>(object: &'a Object, names: &[&str]) -> Option<&'a Value> {
    let levels = levels(object);
    levels.iter().flatten().find_map(|o| get(o, names))
}

/// Whether a value means nothing.
pub(super) fn is_nothing(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::String(text) => {
            let text = text.trim().trim_end_matches('.').to_lowercase();
            NOTHING.contains(&text.as_str())
        }
        Value::Array(items) => items.iter().all(is_nothing),
        Value::Object(map) => map.values().all(is_nothing),
        // The custom of programs for "no one".
        Value::Number(number) => number.as_i64() == Some(-1),
        Value::Bool(said) => !said,
    }
}

/// An obstacle's id as a model writes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Id {
    /// This one.
    Is(i64),
    /// Something else than one id.
    Unclear(String),
}

/// One id: a whole number, also as text, with `.0`, or after a word as in `Obstacle 7`, `car_7`. Several numbers in one
/// text are none: `31, 325` may be two ids or one with a separator of thousands.
pub(super) fn id(value: &Value) -> Id {
    let unclear = || Id::Unclear(short(value));
    match value {
        Value::Number(number) => {
            let whole = number.as_i64().or_else(|| as_integer(number.as_f64()?));
            whole.filter(|id| *id >= 0).map_or_else(unclear, Id::Is)
        }
        Value::String(text) => {
            let word = |c: char| c.is_alphabetic() || c.is_whitespace() || "_-#:.".contains(c);
            let number = text.trim().trim_start_matches(word);
            let digits = number.split('(').next().unwrap_or(number).trim_end();
            let digits = match digits.split_once('.') {
                Some((before, zeros)) if zeros.bytes().all(|b| b == b'0') => before,
                _ => digits,
            };
            let digits_only = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
            let id = digits_only.then(|| digits.parse().ok()).flatten();
            id.map_or_else(unclear, Id::Is)
        }
        _ => unclear(),
    }
}

fn as_integer(number: f64) -> Option<i64> {
    (number.fract() == 0.0 && number.abs() < 1e15).then_some(number as i64)
}

/// A finite number, also as text, also with a unit behind it.
pub(super) fn number(value: &Value) -> Option<f64> {
    let found = match value {
        Value::Number(number) => number.as_f64()?,
        Value::String(text) => {
            let text = text.trim();
            let unit = |c: char| c.is_whitespace() || c.is_alphabetic() || "/²^°".contains(c);
            let bare = text.trim_end_matches(unit);
            text.parse().or_else(|_| bare.parse()).ok()?
        }
        _ => return None,
    };
    found.is_finite().then_some(found)
}

/// A risk score: 0 to 5, also as text, also with or as the name of its level; between two scores the nearer one.
pub(super) fn score(value: &Value) -> Option<u8> {
    let number = number(value).or_else(|| {
        let text = value.as_str()?.trim().to_lowercase();
        let level = LEVELS
            .iter()
            .find(|(name, _)| text.starts_with(name))
            .map(|(_, score)| f64::from(*score));
        level.or_else(|| text.split([' ', '(', '/', ':']).next()?.parse().ok())
    })?;
    (0.0..=5.0).contains(&number).then(|| number.round() as u8)
}

/// Levels of risk and their scores.
pub(super) const LEVELS: [(&str, u8); 6] = [
    ("collision", 0),
    ("extreme", 1),
    ("high", 2),
    ("medium", 3),
    ("low", 4),
    ("negligible", 5),
];

/// Yes or no.
pub(super) fn truth(value: &Value) -> Option<bool> {
    match value {
        Value::Bool(said) => Some(*said),
        Value::Number(number) => match number.as_f64() {
            Some(1.0) => Some(true),
            Some(0.0) => Some(false),
            _ => None,
        },
        Value::String(text) => {
            let text = text.trim().to_lowercase();
            let mut words = text
                .split(|c: char| !c.is_alphanumeric())
                .filter(|word| !word.is_empty());
            let first = words.next()?;
            let said = truth_word(first)?;
            let is_other =
                |word: &str| truth_word(word) == Some(!said) || UNDECIDED.contains(&word);
            let rest = text.trim_start_matches(char::is_alphanumeric);
            // "no idea" and "no way, it is true" decide nothing: what follows a bare no is what there is none of.
            let next = words
                .clone()
                .next()
                .filter(|_| rest.starts_with(char::is_whitespace));
            let is_aside = rest
                .trim_start()
                .starts_with(|c: char| !c.is_alphanumeric());
            let fits = first != "no" || is_aside || next.is_none_or(|next| NONE_OF.contains(&next));
            (fits && !words.any(is_other) && !text.contains("not enough")).then_some(said)
        }
        _ => None,
    }
}

fn truth_word(word: &str) -> Option<bool> {
    match word {
        "true" | "yes" => Some(true),
        "false" | "no" => Some(false),
        _ => None,
    }
}

/// Words with which a yes or no takes itself back.
const UNDECIDED: [&str; 6] = [
    "negative",
    "cannot",
    "unknown",
    "unsure",
    "unclear",
    "insufficient",
];

/// Of what a no says that there is none.
const NONE_OF: [&str; 9] = [
    "collision",
    "collisions",
    "contact",
    "danger",
    "risk",
    "touch",
    "crash",
    "conflict",
    "it",
];

/// A text, where it is one.
pub(super) fn text(value: &Value) -> Option<String> {
    value.as_str().map(|text| text.trim().to_string())
}

/// A value for a note: not longer than a line.
pub(super) fn short(value: &Value) -> String {
    let text = match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_yes_or_no_that_takes_itself_back_is_none() {
        for (text, said) in [
            ("yes", Some(true)),
            (" Yes, it touches", Some(true)),
            ("TRUE", Some(true)),
            ("No.", Some(false)),
            ("no collision", Some(false)),
            ("No, it does not touch", Some(false)),
            ("false (0.35 m)", Some(false)),
            ("false because 2 m remain", Some(false)),
            ("true or false", None),
            ("true|false", None),
            ("true if the distance is 0.00 else false", None),
            ("yes and no", None),
            ("true negative", None),
            ("no idea", None),
            ("no sé", None),
            ("No one can say", None),
            ("No - not enough information", None),
            ("No way, it is true", None),
            ("no doubt: yes", None),
            ("maybe", None),
        ] {
            assert_eq!(truth(&json!(text)), said, "{text}");
        }
    }

    #[test]
    fn ids() {
        let names = [
            json!(7),
            json!(7.0),
            json!("7"),
            json!(" 7.0 "),
            json!("Obstacle 7"),
            json!("vehicle_7"),
            json!("car #7"),
            json!("ID: 7"),
            json!("7 (truck)"),
        ];
        for value in names {
            assert_eq!(id(&value), Id::Is(7), "{value}");
        }
        let unclear = [
            json!("the red car"),
            json!(7.5),
            json!(-7),
            json!("7, 8"),
            json!("7 and 8"),
            json!(true),
            json!("7.5"),
            json!("99999999999999999999"),
            json!(1e300),
        ];
        for value in unclear {
            assert!(matches!(id(&value), Id::Unclear(_)), "{value}");
        }
    }

    #[test]
    fn nothing() {
        let nothing = [
            json!(null),
            json!(""),
            json!("None"),
            json!("N/A"),
            json!([]),
            json!({}),
            json!([null]),
            json!(-1),
            json!("-"),
            json!({"ObstacleID": "none", "OverallRiskScore": null}),
        ];
        for value in nothing {
            assert!(is_nothing(&value), "{value}");
        }
        assert!(!is_nothing(&json!(0)) && !is_nothing(&json!("the red car")));
    }

    #[test]
    fn scores_and_truth() {
        let scores = [
            (json!(1), Some(1)),
            (json!("1"), Some(1)),
            (json!(1.0), Some(1)),
            (json!("1 (extreme)"), Some(1)),
            (json!("Extreme risk"), Some(1)),
            (json!("3/5"), Some(3)),
            (json!(3.6), Some(4)),
            (json!(9), None),
            (json!(-1), None),
            (json!("?"), None),
            (json!(null), None),
        ];
        for (value, wanted) in scores {
            assert_eq!(score(&value), wanted, "{value}");
        }
        for (value, wanted) in [
            (json!(true), Some(true)),
            (json!("Yes, at step 5"), Some(true)),
            (json!("no collision"), Some(false)),
            (json!(0), Some(false)),
            (json!("perhaps"), None),
            (json!("none"), None),
            (json!(2), None),
        ] {
            assert_eq!(truth(&value), wanted, "{value}");
        }
        assert_eq!(number(&json!("12.5 m/s²")), Some(12.5));
        assert_eq!(number(&json!("nan")), None);
    }
}
