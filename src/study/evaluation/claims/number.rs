//! Numbers with units in text.

use std::ops::Range;

/// The unit behind a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    None,
    Metre,
    Second,
    Speed,
    Acceleration,
    /// One that no claim is made in.
    Other,
}

/// A number in a text.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    pub value: f64,
    pub decimals: u8,
    pub unit: Unit,
    /// The number with its unit, bytes.
    pub span: Range<usize>,
}

impl Number {
    /// The whole number that it is, also when it is written as 30674.0.
    pub fn whole(&self) -> Option<i64> {
        let fits = self.value.fract() == 0.0 && self.value.abs() < 1e15;
        (fits && matches!(self.unit, Unit::None)).then_some(self.value as i64)
    }
}

/// Longer names first.
const UNITS: &[(&str, Unit)] = &[
    ("meters per second squared", Unit::Acceleration),
    ("metres per second squared", Unit::Acceleration),
    ("meters per second", Unit::Speed),
    ("metres per second", Unit::Speed),
    ("m/s²", Unit::Acceleration),
    ("m/s^2", Unit::Acceleration),
    ("m/s2", Unit::Acceleration),
    ("m/s", Unit::Speed),
    ("km/h", Unit::Other),
    ("mph", Unit::Other),
    ("meters", Unit::Metre),
    ("metres", Unit::Metre),
    ("meter", Unit::Metre),
    ("metre", Unit::Metre),
    ("seconds", Unit::Second),
    ("second", Unit::Second),
    ("secs", Unit::Second),
    ("sec", Unit::Second),
    ("ms", Unit::Other),
    ("km", Unit::Other),
    ("cm", Unit::Other),
    ("rad", Unit::Other),
    ("degrees", Unit::Other),
    ("°", Unit::Other),
    ("%", Unit::Other),
    ("m", Unit::Metre),
    ("s", Unit::Second),
];

/// What TeX may have between a number and its unit.
const TEX: &[&str] = &["\\,", "\\;", "\\ ", "\\text{", "\\mathrm{", "\\"];

/// Names of quantities whose unit goes without saying.
const NAMED: &[(&[&str], Unit)] = &[
    (&["velocity", "speed"], Unit::Speed),
    (&["acceleration", "deceleration"], Unit::Acceleration),
    (&["dtclong", "dtclat"], Unit::Metre),
    (&["ttclong", "ttclat"], Unit::Second),
];

/// Gives numbers without a unit that of the quantity whose name stands right before them: "velocity (2.743)",
/// "DTClat is 0.0"; `lower` is the text in lower case. A whole number may be an id or a score.
pub fn name_units(lower: &str, all: &mut [Number]) {
    for number in all {
        if number.unit != Unit::None || number.decimals == 0 {
            continue;
        }
        let markup = ['*', ' ', '`', ':', '=', '('];
        let before = lower[..number.span.start].trim_end_matches(markup);
        let before = [" is", " of"]
            .iter()
            .find_map(|word| before.strip_suffix(word))
            .unwrap_or(before);
        let named = |(names, _): &&(&[&str], Unit)| {
            names.iter().any(|name| {
                let rest = before.strip_suffix(name);
                rest.is_some_and(|rest| !rest.ends_with(char::is_alphanumeric))
            })
        };
        if let Some((_, unit)) = NAMED.iter().find(named) {
            number.unit = *unit;
        }
    }
}

/// All numbers of a text, in its order.
pub fn numbers(text: &str) -> Vec<Number> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        if !bytes[at].is_ascii_digit() {
            at += 1;
            continue;
        }
        let mut end = at;
        while end < bytes.len() && bytes[end].is_ascii_digit() {
            end += 1;
        }
        let mut decimals = 0;
        if bytes.get(end) == Some(&b'.') && bytes.get(end + 1).is_some_and(u8::is_ascii_digit) {
            let point = end;
            end += 1;
            while end < bytes.len() && bytes[end].is_ascii_digit() {
                end += 1;
            }
            decimals = u8::try_from(end - point - 1).unwrap_or(u8::MAX);
        }
        let before = text[..at].chars().next_back();
        // Part of a name, a version, a date.
        let inside = before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '.');
        let (start, sign) = sign(text, at);
        if !inside && let Ok(value) = text[at..end].parse::<f64>() {
            let (unit, stop) = unit(text, end);
            if let Some(unit) = unit {
                found.push(Number {
                    value: sign * value,
                    decimals,
                    unit,
                    span: start..stop,
                });
            }
        }
        at = end;
    }
    found
}

/// Where a number begins with its sign; a dash behind something is none.
fn sign(text: &str, at: usize) -> (usize, f64) {
    let mut back = text[..at].char_indices().rev();
    let Some((place, dash @ ('-' | '−' | '–' | '+'))) = back.next() else {
        return (at, 1.0);
    };
    let behind = back.next().map(|(_, c)| c);
    let range = behind.is_some_and(|c| c.is_alphanumeric() || matches!(c, ')' | ']' | '%' | '°'));
    match (range, dash) {
        (true, _) => (at, 1.0),
        (_, '+') => (place, 1.0),
        _ => (place, -1.0),
    }
}

/// The unit behind a number, and where it ends; `None` for digits that go on as a word.
fn unit(text: &str, end: usize) -> (Option<Unit>, usize) {
    let rest = &text[end..];
    // Markup and TeX may stand between: `3.2** m`, `3.2\,m`, `3.2 \, \text{m}`.
    let mut tail = rest.trim_start_matches([' ', '\u{a0}', '*', '`', '$']);
    while let Some(further) = TEX.iter().find_map(|tex| tail.strip_prefix(tex)) {
        tail = further.trim_start_matches([' ', '\u{a0}', '*', '`', '$']);
    }
    let skipped = rest.len() - tail.len();
    let lower = |n: usize| tail.get(..n).map(str::to_lowercase);
    for (name, unit) in UNITS {
        let fits = lower(name.len()).is_some_and(|t| t == *name);
        let after = tail.get(name.len()..).and_then(|t| t.chars().next());
        let ends = after.is_none_or(|c| !c.is_alphanumeric() && !matches!(c, '/' | '^' | '²'))
            || name.ends_with('²');
        if fits && ends {
            return (Some(*unit), end + skipped + name.len());
        }
    }
    let next = rest.chars().next();
    let goes_on = next.is_some_and(|c| c.is_alphanumeric() || c == '_');
    (Some(Unit::None).filter(|_| !goes_on), end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_signs_digits_and_units() {
        let text = "30674.0 at −4.12 m, 6.83m/s, **4.98s**, 1.5 m/s², 2-3 s, v2.1x, 7 meters, id_3, 12.3m/s2 5 m/s/x";
        let seen: Vec<_> = numbers(text)
            .iter()
            .map(|n| (n.value, n.decimals, n.unit, &text[n.span.clone()]))
            .collect();
        use Unit::{Acceleration, Metre, None, Second, Speed};
        assert_eq!(
            seen,
            [
                (30674.0, 1, None, "30674.0"),
                (-4.12, 2, Metre, "−4.12 m"),
                (6.83, 2, Speed, "6.83m/s"),
                (4.98, 2, Second, "4.98s"),
                (1.5, 1, Acceleration, "1.5 m/s²"),
                (2.0, 0, None, "2"),
                (3.0, 0, Second, "3 s"),
                (7.0, 0, Metre, "7 meters"),
                (12.3, 1, Acceleration, "12.3m/s2"),
                (5.0, 0, None, "5"),
            ]
        );
    }
}
