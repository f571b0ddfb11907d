//! Puts right what servers write that is no JSON: numbers such as `NaN`, and characters that are cut between two events.

use std::fmt::Write;

/// Half of a character beyond the first 65,536, which the next event has the other half of.
#[derive(Debug, Default)]
pub(super) struct HalfCharacter(Option<u16>);

impl HalfCharacter {
    /// The text of an event with `null` for numbers that JSON does not have, and with whole characters: the first half of
    /// one is kept for the next event, and a second half without a first is U+FFFD.
    pub fn mend(&mut self, data: &str) -> String {
        let mut mended = String::with_capacity(data.len());
        let mut rest = data;
        let mut inside = false;
        while let Some(next) = rest.chars().next() {
            if !inside
                && let Some((word, after)) = foreign(rest)
                && !mended.ends_with(|c: char| c.is_ascii_alphanumeric())
            {
                mended.push_str(word);
                rest = after;
                continue;
            }
            let unit = rest
                .strip_prefix("\\u")
                .and_then(|hex| hex.get(..4))
                .and_then(|hex| u16::from_str_radix(hex, 16).ok());
            match (next, unit) {
                (_, Some(unit)) if inside => {
                    self.take(unit, &mut mended);
                    rest = &rest[6..];
                }
                ('\\', _) if inside => {
                    self.alone(&mut mended);
                    let length = 1 + rest[1..].chars().next().map_or(0, char::len_utf8);
                    mended.push_str(&rest[..length]);
                    rest = &rest[length..];
                }
                (next, _) => {
                    inside ^= next == '"';
                    if inside && next != '"' {
                        self.alone(&mut mended);
                    }
                    mended.push(next);
                    rest = &rest[next.len_utf8()..];
                }
            }
        }
        mended
    }

    /// An escaped unit of UTF-16.
    fn take(&mut self, unit: u16, into: &mut String) {
        match (unit, self.0.take()) {
            (0xdc00..=0xdfff, Some(first)) => {
                let both = char::decode_utf16([first, unit]).next();
                into.push(both.and_then(Result::ok).unwrap_or('\u{fffd}'));
            }
            (0xdc00..=0xdfff, None) => into.push('\u{fffd}'),
            (unit, before) => {
                if before.is_some() {
                    into.push('\u{fffd}');
                }
                match unit {
                    0xd800..=0xdbff => self.0 = Some(unit),
                    unit => drop(write!(into, "\\u{unit:04x}")),
                }
            }
        }
    }

    /// Something else follows a first half.
    fn alone(&mut self, into: &mut String) {
        if self.0.take().is_some() {
            into.push('\u{fffd}');
        }
    }
}

/// A number that JSON does not have at the beginning, as JSON, and what follows it.
fn foreign(text: &str) -> Option<(&'static str, &str)> {
    let words = ["NaN", "-Infinity", "Infinity"].into_iter();
    words
        .filter_map(|word| text.strip_prefix(word))
        .map(|after| ("null", after))
        .next()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde_json::Value;

    fn text(half: &mut HalfCharacter, data: &str) -> String {
        let value: Value = serde_json::from_str(&half.mend(data)).unwrap();
        value.as_str().unwrap().to_string()
    }

    #[test]
    fn characters_cut_between_events_are_joined() {
        let mut half = HalfCharacter::default();
        assert_eq!(text(&mut half, r#""a\ud83d""#), "a");
        assert_eq!(text(&mut half, r#""\ude97b""#), "🚗b");
        assert_eq!(
            text(&mut half, r#""\ud83d\ude97 \\u00e9 \u00e9 \" é""#),
            "🚗 \\u00e9 é \" é"
        );
        assert_eq!(text(&mut half, r#""\ude97x\ud83dy""#), "\u{fffd}x\u{fffd}y");
        assert_eq!(text(&mut half, r#""\ud83d\ud83d""#), "\u{fffd}");
        assert_eq!(text(&mut half, r#""z""#), "\u{fffd}z");
    }

    #[test]
    fn numbers_that_json_does_not_have_are_null() {
        let mended = HalfCharacter::default()
            .mend(r#"{"a": NaN, "NaN": -Infinity, "b": [Infinity, "Infinity"]}"#);
        assert_eq!(
            mended,
            r#"{"a": null, "NaN": null, "b": [null, "Infinity"]}"#
        );
    }
}
