//! Units of formulas: powers of metres and seconds; radians count as numbers.

use std::fmt;

/// A unit as powers of metres and seconds; a number has none of either.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Unit {
    metres: i32,
    seconds: i32,
}

/// The names in units, with the powers of metres and seconds.
const NAMES: [(&str, Unit); 3] = [
    ("m", Unit::new(1, 0)),
    ("s", Unit::new(0, 1)),
    ("rad", Unit::new(0, 0)),
];

/// Superscripts of powers.
const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

impl Unit {
    const fn new(metres: i32, seconds: i32) -> Self {
        Self { metres, seconds }
    }

    /// A unit such as `m/s²`, `m/s^2`, `1/s` or nothing.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        if text.is_empty() || text == "1" {
            return Some(Self::default());
        }
        let (sign, rest) = match text.strip_prefix("1/") {
            Some(rest) => (-1, rest),
            None => (1, text),
        };
        let (unit, length) = Self::beginning(rest, sign)?;
        (length == rest.len()).then_some(unit)
    }

    /// The unit that a text begins with, and its length in bytes.
    pub fn at_start_of(text: &str) -> Option<(Self, usize)> {
        Self::beginning(text, 1)
    }

    fn beginning(text: &str, first_sign: i32) -> Option<(Self, usize)> {
        let (mut unit, mut end, mut sign) = (Self::default(), 0, first_sign);
        let mut rest = text.trim_start();
        loop {
            let letters = rest.find(|c: char| !is_of_name(c)).unwrap_or(rest.len());
            let known = NAMES.iter().find(|(name, _)| *name == &rest[..letters]);
            let Some((_, of_name)) = known else { break };
            let (power, length) = power(&rest[letters..]);
            unit = unit.times(of_name.power(sign.saturating_mul(power)));
            rest = &rest[letters + length..];
            end = text.len() - rest.len();
            let next = rest.trim_start();
            if let Some(over) = next.strip_prefix('/') {
                (rest, sign) = (over.trim_start(), -1);
            } else if let Some(times) = next.strip_prefix('·') {
                (rest, sign) = (times.trim_start(), 1);
            } else {
                break;
            }
        }
        (end > 0).then_some((unit, end))
    }

    /// Whether it is that of a plain number.
    pub fn is_none(self) -> bool {
        self == Self::default()
    }

    /// The product of two.
    pub fn times(self, other: Self) -> Self {
        Self {
            metres: self.metres.saturating_add(other.metres),
            seconds: self.seconds.saturating_add(other.seconds),
        }
    }

    /// A whole power.
    pub fn power(self, power: i32) -> Self {
        Self {
            metres: self.metres.saturating_mul(power),
            seconds: self.seconds.saturating_mul(power),
        }
    }

    /// The square root, where its powers are even.
    pub fn root(self) -> Option<Self> {
        let is_even = self.metres % 2 == 0 && self.seconds % 2 == 0;
        is_even.then(|| Self::new(self.metres / 2, self.seconds / 2))
    }

    /// The unit in words: `no unit` for a number.
    pub fn words(self) -> String {
        match self.to_string() {
            none if none.is_empty() => "no unit".into(),
            unit => unit,
        }
    }
}

/// Whether a name may have this character.
pub fn is_of_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '.'
}

/// The power at the start of a text, `²` or `^2`, else 1, and its length in bytes.
fn power(text: &str) -> (i32, usize) {
    let first = text.chars().next();
    if let Some(digit) = first.and_then(|c| SUPERSCRIPTS.iter().position(|s| *s == c)) {
        return (digit as i32, SUPERSCRIPTS[digit].len_utf8());
    }
    let digit = text
        .strip_prefix('^')
        .and_then(|rest| rest.chars().next()?.to_digit(10));
    digit.map_or((1, 0), |digit| (digit as i32, 2))
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = [("m", self.metres), ("s", self.seconds)];
        let above: Vec<String> = named
            .iter()
            .filter(|(_, power)| *power > 0)
            .map(raised)
            .collect();
        let below: String = { named.iter() }
            .filter(|(_, power)| *power < 0)
            .map(|one| format!("/{}", raised(one)))
            .collect();
        let is_over_one = above.is_empty() && !below.is_empty();
        write!(
            f,
            "{}{}{below}",
            if is_over_one { "1" } else { "" },
            above.join("·")
        )
    }
}

fn raised((name, power): &(&str, i32)) -> String {
    let digits = power.unsigned_abs().to_string();
    let superscript = |c: char| SUPERSCRIPTS[c.to_digit(10).unwrap_or(0) as usize];
    match digits.as_str() {
        "1" => (*name).into(),
        digits => name
            .chars()
            .chain(digits.chars().map(superscript))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::metrics::MEASURES;

    #[test]
    fn units_are_read_as_they_are_written() {
        for text in [
            "", "m", "s", "m/s", "m/s²", "s²", "1/s", "1/m/s", "m·s", "m³/s",
        ] {
            assert_eq!(Unit::parse(text).unwrap().to_string(), text);
        }
        assert_eq!(Unit::parse("m/s^2"), Unit::parse("m/s²"));
        assert_eq!(Unit::parse("rad"), Unit::parse(""));
        assert_eq!(Unit::parse("km"), None);
        assert_eq!(Unit::parse("m/"), None);
        assert_eq!(Unit::at_start_of(" m / speed").unwrap().1, 2);
        let shipped = MEASURES
            .iter()
            .map(|measure| measure.unit)
            .filter(|unit| *unit != "rad");
        shipped.for_each(|unit| assert_eq!(Unit::parse(unit).unwrap().to_string(), unit));
    }
}
