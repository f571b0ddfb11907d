//! Changes in words, as on the command line and in names: `rotate:90`, `mirror`, `move:1000,-500`, `renumber:1`.

use std::fmt;
use std::str::FromStr;

use super::Transform;

/// A text that names no change of a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "invalid transform `{text}`: {why}; available: rotate:DEGREES, mirror, move:X,Y (metres), renumber:SEED"
)]
pub struct TransformError {
    /// What was said, at most 40 characters of it.
    pub text: String,
    /// What is wrong with it.
    pub why: &'static str,
}

/// Largest rotation, degrees.
const MOST_DEGREES: f64 = 360.0;

/// Farther from the origin less than a micrometre would be told apart, metres.
const FARTHEST: f64 = 1e6;

impl FromStr for Transform {
    type Err = TransformError;

    fn from_str(text: &str) -> Result<Self, TransformError> {
        let (kind, values) = match text.trim().split_once(':') {
            Some((kind, values)) => (kind, Some(values)),
            None => (text.trim(), None),
        };
        let wrong = |why| TransformError {
            text: text.chars().take(40).collect(),
            why,
        };
        let number = |text: &str, most: f64| {
            let number = text.trim().parse::<f64>().ok();
            number.filter(|n| n.abs() <= most)
        };
        match (kind, values) {
            ("mirror", None) => Ok(Self::Mirror),
            ("mirror", Some(_)) => Err(wrong("mirror takes no value")),
            ("rotate", Some(degrees)) => match number(degrees, MOST_DEGREES) {
                Some(degrees) => Ok(Self::Rotate(degrees.to_radians())),
                None => Err(wrong("expected degrees from -360 to 360")),
            },
            ("move", Some(values)) => {
                let values = values
                    .split_once(',')
                    .map(|(x, y)| (number(x, FARTHEST), number(y, FARTHEST)));
                match values {
                    Some((Some(x), Some(y))) => Ok(Self::Move(x, y)),
                    _ => Err(wrong("expected two numbers of at most 1000000 metres")),
                }
            }
            ("renumber", Some(seed)) => match seed.trim().parse() {
                Ok(seed) => Ok(Self::Renumber(seed)),
                Err(_) => Err(wrong("expected a non-negative whole number")),
            },
            ("rotate" | "move" | "renumber", None) => Err(wrong("expected a value after a colon")),
            _ => Err(wrong("unknown name")),
        }
    }
}

impl fmt::Display for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Radians are not as round as the degrees they were made from.
            Self::Rotate(angle) => {
                write!(f, "rotate:{}", (angle.to_degrees() * 1e9).round() / 1e9)
            }
            Self::Mirror => f.write_str("mirror"),
            Self::Move(x, y) => write!(f, "move:{x},{y}"),
            Self::Renumber(seed) => write!(f, "renumber:{seed}"),
        }
    }
}

impl Transform {
    /// The name under which answers about the changed scene are kept: the scenario's name, and the change in brackets.
    #[must_use]
    pub fn name(&self, scenario: &str) -> String {
        format!("{scenario} [{self}]")
    }

    /// A name taken apart: that of the scenario, and the change if it has one.
    #[must_use]
    pub fn of_name(name: &str) -> (&str, Option<Self>) {
        let parts = name
            .strip_suffix(']')
            .and_then(|rest| rest.rsplit_once(" ["));
        match parts.map(|(scenario, change)| (scenario, change.parse().ok())) {
            Some((scenario, Some(change))) => (scenario, Some(change)),
            _ => (name, None),
        }
    }
}

impl nearmiss_record::fields::Word for Transform {
    /// A move has a comma between its numbers.
    const SEPARATORS: &'static [char] = &[';', ' '];

    fn of_word(word: &str) -> Result<Self, String> {
        word.parse().map_err(|error: TransformError| {
            let hint = if word.contains(',') {
                "; several are separated by semicolons or spaces"
            } else {
                ""
            };
            format!("{error}{hint}")
        })
    }

    fn word(&self) -> String {
        self.to_string()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        for text in [
            "rotate:90",
            "rotate:-37.25",
            "rotate:0.1",
            "mirror",
            "move:1000,-500",
            "move:0.5,0",
            "renumber:1",
            "renumber:18446744073709551615",
        ] {
            let read: Transform = text.parse().unwrap();
            assert_eq!(read.to_string(), text);
            assert_eq!(read.to_string().parse::<Transform>().unwrap(), read);
            let name = read.name("DEU_Bremen-1_10_T-1");
            assert_eq!(
                Transform::of_name(&name),
                ("DEU_Bremen-1_10_T-1", Some(read))
            );
        }
        assert_eq!(Transform::of_name("A [b]"), ("A [b]", None));
        assert_eq!(Transform::of_name("A"), ("A", None));
    }

    #[test]
    fn what_is_no_change_is_refused_with_the_reason() {
        for (text, why) in [
            ("rotate", "after a colon"),
            ("rotate:NaN", "degrees"),
            ("rotate:400", "degrees"),
            ("mirror:x", "takes no value"),
            ("move:1", "two numbers"),
            ("move:1,inf", "two numbers"),
            ("renumber:-1", "non-negative"),
            ("shear:1", "unknown name"),
            ("", "unknown name"),
        ] {
            let error = text.parse::<Transform>().unwrap_err().to_string();
            assert!(
                error.contains(why) && error.contains("rotate:DEGREES"),
                "{error}"
            );
        }
    }
}
