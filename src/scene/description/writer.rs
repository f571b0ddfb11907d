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
    /// The time step of the recording it holds at; `None` for what holds always.
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
    /// In the unit that the text names.
    Real(f64),
}

/// Decimals of seconds.
const TIME: usize = 2;

/// Decimals of degrees.
const DEGREES: usize = 1;

/// Quantities of which 0 has a meaning of its own, so that only a true 0 is written as one.
const TRUE_ZERO: [&str; 7] = [
    "distance", "gap_long", "gap_lat", "ttc", "ttc_long", "ttc_lat", "time_gap",
];

/// How the first line of a description begins whose times count from the end of its window.
const RELATIVE: &str = "Times are relative to the end of the described window: t = ";

/// Whether the times in these descriptions or messages count from the end of the window, not from time step 0.
#[must_use]
pub fn has_relative_times(text: &str) -> bool {
    text.contains(RELATIVE)
}

/// A description that grows.
pub(super) struct Writer {
    done: Description,
    precision: usize,
    /// The step that times are relative to; `None` where they count from time step 0 and steps are named.
    now: Option<i64>,
    step: Option<i64>,
    of: Subject,
}

impl Writer {
    /// Numbers get `precision` decimals.
    pub fn new(precision: usize) -> Self {
        Self {
            done: Description::default(),
            precision,
            now: None,
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
    pub fn text(&mut self, words: &str) -> &mut Self {
        self.done.text.push_str(words);
        self
    }

    /// Metres, seconds, m/s or m/s².
    pub fn number(&mut self, quantity: &'static str, value: f64) -> &mut Self {
        self.fixed(quantity, value, decimals(quantity, value, self.precision))
    }

    /// An angle, radians; written between −π and π with one more decimal.
    pub fn angle(&mut self, quantity: &'static str, value: f64) -> &mut Self {
        let value = nearmiss_base::geometry::normalize_angle(value);
        self.fixed(quantity, value, self.precision + 1)
    }

    /// An angle, degrees.
    pub fn degrees(&mut self, quantity: &'static str, value: f64) -> &mut Self {
        self.fixed(quantity, value, DEGREES)
    }

    /// From here on times are relative to the step `now`, and the first line says so.
    pub fn relative_to(&mut self, now: i64) -> &mut Self {
        self.now = Some(now);
        self.about(Subject::Scene, Some(now))
            .text(RELATIVE)
            .fixed("time", 0.0, TIME)
            .text(" s is now.\n")
    }

    /// Whether times are relative.
    pub fn is_relative(&self) -> bool {
        self.now.is_some()
    }

    /// Seconds from now, or since time step 0, until `step` of a recording with steps of `dt` seconds.
    pub fn time(&mut self, step: i64, dt: f64) -> &mut Self {
        let steps = step.saturating_sub(self.now.unwrap_or(0));
        self.fixed("time", steps as f64 * dt, TIME)
    }

    /// The number that [`Writer::number`] writes for this one.
    pub fn written(&self, quantity: &str, value: f64) -> f64 {
        written(value, decimals(quantity, value, self.precision))
    }

    /// A count, a time step or an id.
    pub fn integer(&mut self, quantity: &'static str, value: i64) -> &mut Self {
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

/// Decimals of a number: more than usual where a small one would be written as 0 and must not be.
fn decimals(quantity: &str, value: f64, usual: usize) -> usize {
    if value == 0.0 || !value.is_finite() || !TRUE_ZERO.contains(&quantity) {
        return usual;
    }
    let is_zero = |decimals: &usize| fixed(value, *decimals).parse() == Ok(0.0);
    (usual..).find(|d| !is_zero(d)).unwrap_or(usual)
}

/// Degrees, more than −180 and up to 180, as they are written.
pub(super) fn degrees(radians: f64) -> f64 {
    let degrees = nearmiss_base::geometry::normalize_angle(radians).to_degrees();
    // Rounded to the decimals of the text, both ends are the same direction.
    if degrees < -180.0 + 0.5 * 10_f64.powi(-(DEGREES as i32)) {
        180.0
    } else {
        degrees
    }
}

/// The number that is written for these degrees.
pub(super) fn written_degrees(degrees: f64) -> f64 {
    written(degrees, DEGREES)
}

/// The number that is written for this one with so many decimals.
pub(super) fn written(value: f64, decimals: usize) -> f64 {
    fixed(value, decimals).parse().unwrap_or(value)
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
    fn only_a_true_zero_is_written_as_one_where_that_means_contact() {
        let told = |quantity, value| {
            let mut w = Writer::new(2);
            w.number(quantity, value);
            assert_eq!(
                w.finish().text.parse(),
                Ok(Writer::new(2).written(quantity, value))
            );
            let mut w = Writer::new(2);
            w.number(quantity, value);
            w.finish().text
        };
        assert_eq!(told("distance", 0.004), "0.004");
        assert_eq!(told("gap_long", -0.000_26), "-0.0003");
        assert_eq!(told("gap_lat", 0.0), "0.00");
        assert_eq!(told("distance", 1.004), "1.00");
        assert_eq!(told("velocity", 0.004), "0.00");
    }

    #[test]
    fn half_a_turn_has_one_name() {
        let half = std::f64::consts::PI - 1e-7;
        for radians in [half, -half] {
            assert_eq!(fixed(degrees(radians), DEGREES), "180.0");
        }
        assert_eq!(fixed(degrees(-3.13), DEGREES), "-179.3");
    }

    #[test]
    fn a_number_knows_where_it_stands_and_whose_it_is() {
        let mut w = Writer::new(1);
        w.about(Subject::Obstacle(7), Some(3))
            .text("² gap ")
            .number("gap_long", -1.26)
            .text(" m");
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
