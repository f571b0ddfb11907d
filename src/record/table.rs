//! Tables: typed columns, and rows of cells that each format writes in its own way.

use std::borrow::Cow;

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its key in JSON, CSV and Parquet.
    pub name: Cow<'static, str>,
    /// Of its cells.
    pub kind: Kind,
    /// Whether cells may be without a value.
    pub optional: bool,
    /// Of SI; empty where there is none.
    pub unit: Cow<'static, str>,
    /// Where its definition comes from, or what it is.
    pub source: Cow<'static, str>,
    /// Its heading for people; empty where tables for people leave it out.
    pub title: Cow<'static, str>,
    /// Digits behind the point for people; `None`: as many as the number has.
    pub decimals: Option<usize>,
    /// Which of a noun's tables for people has it; empty where every one has.
    pub table: Cow<'static, str>,
    /// Whether tables for people leave it out where all its values are missing or 0.
    pub rare: bool,
    /// Whether people see a number below its last digit as `< 0.001`, not as 0.
    pub bounded: bool,
    /// Whether it is a moment of the recording, seconds since step 0: Arrow has it as a duration.
    pub on_clock: bool,
}

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Words.
    Text,
    /// Whole numbers.
    Integer,
    /// In text as short as can be: `3`.
    Number,
    /// In text with a point: `3.0`.
    Float,
    /// Yes or no.
    Truth,
}

impl Column {
    /// A column without gaps.
    pub const fn new(
        name: &'static str,
        kind: Kind,
        unit: &'static str,
        source: &'static str,
    ) -> Self {
        Self::with(name, kind, unit, source, false)
    }

    /// A column of moments: seconds since step 0.
    pub const fn clock(name: &'static str, source: &'static str) -> Self {
        Self::with(name, Kind::Number, "s", source, true)
    }

    const fn with(
        name: &'static str,
        kind: Kind,
        unit: &'static str,
        source: &'static str,
        on_clock: bool,
    ) -> Self {
        Self {
            name: Cow::Borrowed(name),
            kind,
            optional: false,
            unit: Cow::Borrowed(unit),
            source: Cow::Borrowed(source),
            title: Cow::Borrowed(""),
            decimals: None,
            table: Cow::Borrowed(""),
            rare: false,
            bounded: false,
            on_clock,
        }
    }

    /// The same with gaps.
    pub fn optional(self) -> Self {
        let optional = true;
        Self { optional, ..self }
    }
}

/// A value of a table, or why there is none.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(Cow<'static, str>),
    /// A whole number.
    Integer(i64),
    /// Finite.
    Number(f64),
    /// Yes or no.
    Truth(bool),
    /// No value, for this reason; empty where none is known.
    None(&'static str),
    /// No number, for this reason; formats that know infinity write it.
    Infinite(&'static str),
}

/// A cell for each column.
pub type Row = Vec<Cell>;

impl Cell {
    /// A number that has to be finite.
    pub fn finite(value: f64) -> Self {
        if value.is_finite() {
            Self::Number(value)
        } else {
            Self::None("out of range")
        }
    }

    /// A JSON value; lists and objects stay JSON, as text.
    pub fn from_json(value: &serde_json::Value) -> Self {
        use serde_json::Value;
        match value {
            Value::Null => Self::None(""),
            Value::Bool(truth) => Self::Truth(*truth),
            Value::String(text) => Self::Text(text.clone().into()),
            Value::Number(number) => match (number.as_i64(), number.as_f64()) {
                (Some(integer), _) => Self::Integer(integer),
                (None, Some(number)) => Self::Number(number),
                (None, None) => Self::Text(number.to_string().into()),
            },
            other => Self::Text(other.to_string().into()),
        }
    }

    /// For people, with the digits of its column; `-` where there is no value.
    pub fn shown(&self, column: &Column) -> Cow<'_, str> {
        match (self, column.decimals) {
            (Self::Number(value), Some(digits)) => {
                let last = 1.0 / 10_f64.powi(i32::try_from(digits).unwrap_or(i32::MAX));
                if column.bounded && *value < last {
                    format!("< {last:.digits$}").into()
                } else {
                    format!("{value:.digits$}").into()
                }
            }
            (Self::Truth(truth), _) => (if *truth { "yes" } else { "no" }).into(),
            _ => self.text(Kind::Number).unwrap_or("-".into()),
        }
    }

    /// As text in a column of this kind; `None` where there is no value.
    pub fn text(&self, kind: Kind) -> Option<Cow<'_, str>> {
        Some(match self {
            Self::Text(text) => Cow::Borrowed(text),
            Self::Integer(number) => number.to_string().into(),
            Self::Number(number) if kind == Kind::Number => number.to_string().into(),
            Self::Number(number) => serde_json::Value::from(*number).to_string().into(),
            Self::Truth(truth) => truth.to_string().into(),
            Self::Infinite(_) => "inf".into(),
            Self::None(_) => return None,
        })
    }

    /// Its number, where it has one that is infinite, too.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Infinite(_) => Some(f64::INFINITY),
            _ => None,
        }
    }

    /// Why there is no finite number, as a cell.
    fn reason(&self) -> Self {
        match self {
            Self::None(why) | Self::Infinite(why) => Self::Text(Cow::Borrowed(why)),
            _ => Self::None(""),
        }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text.into())
    }
}

impl From<&'static str> for Cell {
    fn from(word: &'static str) -> Self {
        Self::Text(word.into())
    }
}

/// The columns of a table, and what formats that describe themselves say of it.
#[derive(Debug, Clone)]
pub struct Table {
    /// What its rows are.
    pub name: &'static str,
    /// Its columns, in order.
    pub columns: Vec<Column>,
    /// The columns whose reasons are columns, too, behind all others.
    reasons: Vec<usize>,
    /// Keys and values of the file's metadata.
    pub metadata: Vec<(&'static str, String)>,
    /// Rows that are kept in memory before they are written as a row group of Parquet or a batch of Arrow.
    pub group: usize,
    /// Whether its CSV is for a spreadsheet, which runs text that begins like a formula.
    pub for_spreadsheet: bool,
    /// Keys and values that every line of JSON has behind the columns.
    pub json_values: Vec<(&'static str, serde_json::Value)>,
}

impl Table {
    /// A table of these columns, without metadata.
    pub fn new(name: &'static str, columns: Vec<Column>) -> Self {
        Self {
            name,
            columns,
            reasons: Vec::new(),
            metadata: Vec::new(),
            group: 65_536,
            for_spreadsheet: false,
            json_values: Vec::new(),
        }
    }

    /// The same with a column behind the others for each that has gaps: why a value is missing.
    pub fn with_reasons(mut self) -> Self {
        for place in 0..self.columns.len() {
            let column = &self.columns[place];
            if column.optional {
                let name = Cow::Owned(format!("{}_reason", column.name));
                let reason = Column::new("", Kind::Text, "", "").optional();
                self.columns.push(Column { name, ..reason });
                self.reasons.push(place);
            }
        }
        self
    }

    /// Rows as CSV with a header.
    #[must_use]
    pub fn csv(&self, rows: Vec<Row>) -> Vec<u8> {
        let mut text = crate::text::csv_header(self);
        text.extend(crate::text::csv_rows(self, &self.completed(rows)));
        text
    }

    /// The rows with their reasons, where the table has any.
    pub(crate) fn completed(&self, mut rows: Vec<Row>) -> Vec<Row> {
        for row in &mut rows {
            let reasons: Row = self.reasons.iter().map(|i| row[*i].reason()).collect();
            row.extend(reasons);
        }
        rows
    }
}
