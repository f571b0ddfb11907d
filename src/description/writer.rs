//! Writes a description in which every number can be traced to its source.

use std::ops::Range;

use serde::Serialize;

/// A scene in words, and where its numbers come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Description {
    /// The words.
    pub text: String,
    /// Every number in `text`, in order.
    pub spans: Vec<Span>,
}

impl std::fmt::Display for Description {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

/// A number in a description.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Span {
    /// Its first byte in the text.
    pub start: usize,
    /// The byte after its last.
    pub end: usize,
    /// The time step it holds at; `None` for what holds always.
    pub step: Option<i64>,
    /// Whose it is.
    #[serde(flatten)]
    pub of: Subject,
    /// What it is: `x`, `heading`, the id of a measure, …
    pub quantity: &'static str,
    /// The number before it was rounded for the text.
    pub value: Value,
}

impl Span {
    /// Where it stands in the text, bytes.
    #[must_use]
    pub fn range(&self) -> Range<usize> {
        self.start..self.end
    }
}

/// Whose a number is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(tag = "of", content = "id", rename_all = "lowercase")]
pub enum Subject {
    /// The scene's as a whole, such as a time.
    Scene,
    /// The ego's.
    Ego,
    /// That of the obstacle with this id, by itself or in relation to the ego.
    Obstacle(i64),
    /// That of the lanelet with this id.
    Lanelet(i64),
}

/// A number as it is known, not as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A count, a time step or an id.
    Whole(i64),
    /// In the SI unit that the text names.
    Real(f64),
}

/// Decimals of seconds.
const TIME: usize = 2;

/// A description that grows.
pub(super) struct Writer {
    done: Description,
    precision: usize,
    step: Option<i64>,
    of: Subject,
}

impl Writer {
    /// Numbers get `precision` decimals.
    pub fn new(precision: usize) -> Self {
        Self {
            done: Description::default(),
            precision,
            step: None,
            of: Subject::Scene,
        }
    }

    /// What is written, whole.
    pub fn finish(self) -> Description {
        self.done
    }

    /// Whose the next numbers are, and when.
    pub fn about(&mut self, of: Subject, step: Option<i64>) -> &mut Self {
        (self.of, self.step) = (of, step);
        self
    }

    /// Words without a number.
    pub fn words(&mut self, words: &str) -> &mut Self {
        self.done.text.push_str(words);
        self
    }

    /// Metres, m/s or m/s².
    pub fn number(&mut self, quantity: &'static str, value: f64) -> &mut Self {
        self.fixed(quantity, value, self.precision)
    }

    /// An angle, radians; written between −π and π with one more decimal.
    pub fn angle(&mut self, quantity: &'static str, value: f64) -> &mut Self {
        let value = crate::geometry::normalize_angle(value);
        self.fixed(quantity, value, self.precision + 1)
    }

    /// Seconds since time step 0.
    pub fn time(&mut self, value: f64) -> &mut Self {
        self.fixed("time", value, TIME)
    }

    /// A count, a time step or an id.
    pub fn whole(&mut self, quantity: &'static str, value: i64) -> &mut Self {
        self.put(quantity, &value.to_string(), Value::Whole(value))
    }

    fn fixed(&mut self, quantity: &'static str, value: f64, decimals: usize) -> &mut Self {
        self.put(quantity, &fixed(value, decimals), Value::Real(value))
    }

    fn put(&mut self, quantity: &'static str, text: &str, value: Value) -> &mut Self {
        let start = self.done.text.len();
        self.done.text.push_str(text);
        self.done.spans.push(Span {
            start,
            end: self.done.text.len(),
            step: self.step,
            of: self.of,
            quantity,
            value,
        });
        self
    }
}

/// A number with so many decimals; never a negative zero.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if zero {
        text.trim_start_matches('-').to_string()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_negative_zero() {
        assert_eq!(fixed(-0.001, 2), "0.00");
        assert_eq!(fixed(-0.006, 2), "-0.01");
    }

    #[test]
    fn a_number_knows_where_it_stands_and_whose_it_is() {
        let mut w = Writer::new(1);
        w.about(Subject::Obstacle(7), Some(3))
            .words("² gap ")
            .number("gap_long", -1.26)
            .words(" m");
        let done = w.finish();
        assert_eq!(done.text, "² gap -1.3 m");
        let span = &done.spans[0];
        assert_eq!(&done.text[span.range()], "-1.3");
        assert_eq!(
            (span.of, span.step, span.value),
            (Subject::Obstacle(7), Some(3), Value::Real(-1.26))
        );
    }
}
