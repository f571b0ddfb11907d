//! A row of a table, with errors that name table, row and column.

use std::fmt::Write;

use rusqlite::Row;
use rusqlite::types::ValueRef;

use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::{At, Report};

/// The key of a row: eight bytes in nuPlan.
pub type Token = u64;

/// A row of a table. Its first column is its key, by which errors name it.
pub struct Record<'r> {
    pub(super) row: &'r Row<'r>,
    pub(super) report: &'r Report,
    pub(super) table: &'r str,
    pub(super) columns: &'r [&'r str],
}

impl Record<'_> {
    fn value(&self, column: usize) -> ValueRef<'_> {
        self.row.get_ref(column).unwrap_or(ValueRef::Null)
    }

    /// The place of a column, for errors.
    pub fn at(&self, column: usize) -> At<'_> {
        let key = match self.value(0) {
            ValueRef::Integer(number) => number.to_string(),
            ValueRef::Text(text) => String::from_utf8_lossy(text).chars().take(40).collect(),
            ValueRef::Blob(bytes) => hex(bytes),
            _ => "?".into(),
        };
        let (table, column) = (self.table, self.columns.get(column).unwrap_or(&""));
        let column = column.trim_start_matches('?');
        self.report
            .at(format!("table {table}, row {key}, column {column}"))
    }

    /// Whether a column has nothing.
    pub fn is_empty(&self, column: usize) -> bool {
        self.value(column) == ValueRef::Null
    }

    /// A number.
    pub fn number(&self, column: usize) -> Result<f64, ReadError> {
        let value = match self.value(column) {
            ValueRef::Integer(value) => value as f64,
            ValueRef::Real(value) => value,
            other => return Err(self.wrong(column, other, "a number")),
        };
        if value.abs() < 1e6 {
            Ok(value)
        } else {
            self.at(column).number(value)
        }
    }

    /// A number, where there is one.
    pub fn optional_number(&self, column: usize) -> Result<Option<f64>, ReadError> {
        if self.is_empty(column) {
            Ok(None)
        } else {
            self.number(column).map(Some)
        }
    }

    /// A whole number.
    pub fn whole(&self, column: usize) -> Result<i64, ReadError> {
        match self.value(column) {
            ValueRef::Integer(value) => Ok(value),
            ValueRef::Real(value) if value.fract() == 0.0 && value.abs() < 1e15 => Ok(value as i64),
            other => Err(self.wrong(column, other, "a whole number")),
        }
    }

    /// A whole number, where there is one; keys of other tables are text in some files.
    pub fn optional_whole(&self, column: usize) -> Result<Option<i64>, ReadError> {
        match self.value(column) {
            ValueRef::Null => Ok(None),
            ValueRef::Text(text) => {
                let text = String::from_utf8_lossy(text);
                Ok(text.trim().parse::<f64>().ok().map(|value| value as i64))
            }
            _ => self.whole(column).map(Some),
        }
    }

    /// A text; nothing where there is none.
    pub fn text(&self, column: usize) -> String {
        match self.value(column) {
            ValueRef::Text(text) => String::from_utf8_lossy(text).into_owned(),
            ValueRef::Integer(value) => value.to_string(),
            _ => String::new(),
        }
    }

    /// Bytes.
    pub fn bytes(&self, column: usize) -> Result<&[u8], ReadError> {
        match self.value(column) {
            ValueRef::Blob(bytes) => Ok(bytes),
            other => Err(self.wrong(column, other, "a geometry")),
        }
    }

    /// The key of a row.
    pub fn token(&self, column: usize) -> Result<Token, ReadError> {
        let value = self.value(column);
        let bytes = match value {
            ValueRef::Blob(bytes) => <[u8; 8]>::try_from(bytes).ok(),
            _ => None,
        };
        let token = bytes.map(Token::from_be_bytes);
        token.ok_or_else(|| self.wrong(column, value, "a token of 8 bytes"))
    }

    /// The key of a row, where there is one.
    pub fn optional_token(&self, column: usize) -> Result<Option<Token>, ReadError> {
        if self.is_empty(column) {
            Ok(None)
        } else {
            self.token(column).map(Some)
        }
    }

    fn wrong(&self, column: usize, found: ValueRef<'_>, wanted: &str) -> ReadError {
        let found = match found {
            ValueRef::Null => "it is empty".to_string(),
            ValueRef::Integer(value) => format!("`{value}`"),
            ValueRef::Real(value) => format!("`{value}`"),
            ValueRef::Text(text) => {
                let text: String = String::from_utf8_lossy(text).chars().take(40).collect();
                format!("`{text}`")
            }
            ValueRef::Blob(bytes) => format!("{} bytes", bytes.len()),
        };
        self.at(column).fail(format!("{found}, not {wanted}"))
    }
}

fn hex(bytes: &[u8]) -> String {
    let all = bytes.iter().take(16);
    all.fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}
