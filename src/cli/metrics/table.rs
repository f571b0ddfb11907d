//! A table of measures independent of its format: columns, and the values of one scenario.

use crate::metrics::Thresholds;

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub name: &'static str,
    pub kind: Kind,
    /// Of SI; empty where there is none.
    pub unit: &'static str,
    /// Where its definition comes from, or what it is.
    pub source: &'static str,
}

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Text,
    Integer,
    Number {
        form: Form,
        /// Whether cells may lack a finite number.
        lacking: bool,
    },
}

/// Number format in text; both parse back to the same number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// `3`
    Shortest,
    /// `3.0`
    WithPoint,
}

/// The values of a column in one scenario.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// The same text in every row.
    Same(String),
    Text(Vec<&'static str>),
    Integer(Vec<i64>),
    Number(Vec<Cell>),
}

/// A number, or why there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell {
    /// Finite.
    Value(f64),
    /// No number, for this reason.
    None(&'static str),
    /// No number, for this reason; the convention writes infinity where the format can.
    Infinite(&'static str),
}

impl Cell {
    /// A value that has to be finite.
    pub fn finite(value: f64) -> Self {
        if value.is_finite() {
            Self::Value(value)
        } else {
            Self::None("beyond all numbers")
        }
    }

    /// What formats that know infinity hold.
    pub fn number(self) -> Option<f64> {
        match self {
            Self::Value(value) => Some(value),
            Self::None(_) => None,
            Self::Infinite(_) => Some(f64::INFINITY),
        }
    }

    /// Why there is no finite number.
    pub fn reason(self) -> Option<&'static str> {
        match self {
            Self::Value(_) => None,
            Self::None(why) | Self::Infinite(why) => Some(why),
        }
    }
}

impl Form {
    pub fn text(self, value: f64) -> String {
        match self {
            Self::Shortest => value.to_string(),
            Self::WithPoint => format!("{value:?}"),
        }
    }
}

/// The rows of one scenario, by column.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    pub rows: usize,
    pub values: Vec<Values>,
}

/// Contents of a written column: values, or the reasons for missing ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pub name: String,
    /// Which column.
    pub place: usize,
    pub kind: Kind,
    pub reasons: bool,
}

/// The columns of a table as they are written.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub convention: &'static str,
    /// Changes by a threshold file, described; `None` if the table needs no thresholds.
    pub thresholds: Option<Vec<String>>,
    pub columns: Vec<Column>,
    pub fields: Vec<Field>,
}

impl Table {
    /// A table with these columns, and, after them, the reasons if they are wanted.
    pub fn new(convention: &'static str, columns: Vec<Column>, reasons: bool) -> Self {
        let placed = || columns.iter().enumerate();
        let values = placed().map(|(place, column)| Field {
            name: column.name.to_string(),
            place,
            kind: column.kind,
            reasons: false,
        });
        let lacking = placed().filter(|(_, column)| {
            reasons && matches!(column.kind, Kind::Number { lacking: true, .. })
        });
        let reasons = lacking.map(|(place, column)| Field {
            name: format!("{}_reason", column.name),
            place,
            kind: Kind::Text,
            reasons: true,
        });
        let fields = values.chain(reasons).collect();
        Self {
            convention,
            thresholds: None,
            columns,
            fields,
        }
    }

    /// The same, of values worked out with these thresholds.
    pub fn under(self, thresholds: &Thresholds) -> Self {
        Self {
            thresholds: Some(
                thresholds
                    .changes()
                    .iter()
                    .map(ToString::to_string)
                    .collect(),
            ),
            ..self
        }
    }
}
