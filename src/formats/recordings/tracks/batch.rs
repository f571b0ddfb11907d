//! Rows of a table as they are read: numbers and texts of the wanted columns, a few thousand rows at a time.

use std::collections::HashMap;

use super::columns::{Role, is_unit};

/// A column that is wanted, and whether its values are texts.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Its name.
    pub name: String,
    /// Texts rather than numbers.
    pub is_text: bool,
}

/// Rows in their order.
#[derive(Debug, Default)]
pub struct Batch {
    /// Of each wanted column.
    pub values: Vec<Values>,
    /// The line or row of each, from 1.
    pub lines: Vec<u32>,
    /// Numbers with a decimal comma.
    pub commas: usize,
    /// Lines that are the header once more.
    pub headers: usize,
    /// Values of keys that no column has.
    pub unknown: usize,
}

/// Values of a column in a batch.
#[derive(Debug)]
pub enum Values {
    /// NaN where there is none.
    Numbers(Vec<f64>),
    /// Places in the list of different texts.
    Texts(Vec<u32>, Dictionary),
}

/// Different texts, in the order in which they come first.
#[derive(Debug, Default, Clone)]
pub struct Dictionary {
    /// The texts.
    pub texts: Vec<String>,
    places: HashMap<String, u32>,
    last: u32,
}

impl Dictionary {
    /// The place of a text. Rows of a track often follow each other: the last one is looked at first.
    pub fn place(&mut self, text: &str) -> u32 {
        if self
            .texts
            .get(self.last as usize)
            .is_some_and(|last| last == text)
        {
            return self.last;
        }
        self.last = match self.places.get(text) {
            Some(place) => *place,
            None => {
                let place = u32::try_from(self.texts.len()).unwrap_or(u32::MAX);
                self.texts.push(text.to_string());
                self.places.insert(text.to_string(), place);
                place
            }
        };
        self.last
    }
}

impl Batch {
    /// An empty one for these columns.
    pub fn new(wanted: &[Wanted]) -> Self {
        let values = wanted.iter().map(|wanted| {
            if wanted.is_text {
                Values::Texts(Vec::new(), Dictionary::default())
            } else {
                Values::Numbers(Vec::new())
            }
        });
        Self {
            values: values.collect(),
            ..Self::default()
        }
    }

    /// Adds what of a second stands in a column of its own to the times; `roles` are those of the columns.
    pub fn join_times(&mut self, roles: &[Role]) {
        let place = |wanted: Role| roles.iter().position(|role| *role == wanted);
        let (Some(times), Some(rest)) = (place(Role::Time), place(Role::Nanoseconds)) else {
            return;
        };
        let pair = self.values.get_disjoint_mut([times, rest]);
        if let Ok([Values::Numbers(times), Values::Numbers(rest)]) = pair {
            times
                .iter_mut()
                .zip(rest)
                .for_each(|(time, ns)| *time += *ns * 1e-9);
        }
    }

    /// A row's text of a column; empty where its values are numbers.
    pub fn text(&self, column: usize, row: usize) -> &str {
        match &self.values[column] {
            Values::Texts(places, texts) => texts.texts[places[row] as usize].as_str(),
            Values::Numbers(_) => "",
        }
    }

    /// Adds a row's value of a column.
    ///
    /// # Errors
    /// It is no number.
    pub fn push(&mut self, column: usize, text: &str, separator: u8) -> Result<(), String> {
        match &mut self.values[column] {
            Values::Texts(places, texts) => places.push(texts.place(text.trim())),
            Values::Numbers(numbers) => {
                let (value, comma) = number(text, separator)?;
                self.commas += usize::from(comma);
                numbers.push(value);
            }
        }
        Ok(())
    }
}

/// How tables write that there is no value.
const NONE: [&str; 9] = ["", "nan", "NaN", "NA", "N/A", "null", "NULL", "None", "-"];

/// A number; NaN where there is none. And whether it has a decimal comma.
fn number(text: &str, separator: u8) -> Result<(f64, bool), String> {
    if let Some((value, comma)) = crate::recordings::rows::number(text, separator) {
        return if value.is_infinite() {
            Err(format!("`{}` is not finite", shown(text)))
        } else {
            Ok((value, comma))
        };
    }
    match text.trim() {
        none if NONE.contains(&none) => Ok((f64::NAN, false)),
        // Of booleans and of times of a clock some tables have whole columns.
        "true" | "True" => Ok((1.0, false)),
        "false" | "False" => Ok((0.0, false)),
        _ => match clock(text) {
            Some(seconds) => Ok((seconds, false)),
            None => Err(format!(
                "`{}` is not a number{}",
                shown(text),
                instead(text)
            )),
        },
    }
}

/// What to do about a cell that is not a number, where it is a time or a unit.
fn instead(text: &str) -> &'static str {
    let text = text.trim();
    let bare = text.trim_matches(['[', ']', '(', ')']);
    if text.starts_with(|c: char| c.is_ascii_digit()) && text.contains(':') {
        "; write times as ISO 8601, such as 2024-05-01T12:00:00.1"
    } else if is_unit(bare) {
        "; remove a row of units, and say them with the columns: --columns time=COLUMN[ms]"
    } else {
        ""
    }
}

/// Seconds of a time of day or a date with one, such as `2024-05-01T12:00:00.1Z` or `12:00:00.1`.
fn clock(text: &str) -> Option<f64> {
    let text = text.trim();
    if let Ok(instant) = text.parse::<jiff::Timestamp>() {
        return Some(instant.as_nanosecond() as f64 / 1e9);
    }
    if let Ok(date) = text.parse::<jiff::civil::DateTime>() {
        let utc = date.to_zoned(jiff::tz::TimeZone::UTC).ok()?;
        return Some(utc.timestamp().as_nanosecond() as f64 / 1e9);
    }
    let time = text
        .parse::<jiff::civil::Time>()
        .ok()
        .filter(|_| text.contains(':'))?;
    let since = time.duration_since(jiff::civil::Time::midnight());
    Some(since.as_secs_f64())
}

/// The beginning of a cell, for messages.
pub fn shown(text: &str) -> String {
    text.trim().chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn cells_are_numbers_nothing_or_times() {
        let value = |text: &str| number(text, b';').map(|(value, _)| value);
        assert_eq!(value(" 1.5 "), Ok(1.5));
        assert_eq!(value("1,5"), Ok(1.5));
        assert_eq!(value("True"), Ok(1.0));
        assert!(value("").unwrap().is_nan() && value("NaN").unwrap().is_nan());
        assert_eq!(value("00:01:00.5"), Ok(60.5));
        assert_eq!(value("1970-01-01T00:00:01.5Z"), Ok(1.5));
        assert_eq!(value("1970-01-01 00:00:02"), Ok(2.0));
        assert_eq!(value("abc").unwrap_err(), "`abc` is not a number");
        assert!(
            value("10.06.2024 06:13:20")
                .unwrap_err()
                .contains("ISO 8601")
        );
        assert!(value("[m/s]").unwrap_err().contains("row of units"));
        assert!(value("inf").unwrap_err().contains("not finite"));
    }

    #[test]
    fn texts_are_kept_once() {
        let mut texts = Dictionary::default();
        assert_eq!(
            ["a", "b", "a", "b", "b"].map(|t| texts.place(t)),
            [0, 1, 0, 1, 1]
        );
        assert_eq!(texts.texts, ["a", "b"]);
    }
}
