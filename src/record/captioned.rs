//! Tables for people that stand in a document: a caption, headings, rows, and notes beneath.

use nearmiss_base::system::visible;

use crate::table::{Cell, Column, Kind, Row};
use crate::text::heading;

/// A table of a document.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CaptionedTable {
    /// Its caption.
    pub caption: String,
    /// Its name for references.
    pub name: String,
    /// Headings, and whether their cells stand to the right, as numbers do.
    pub columns: Vec<(String, bool)>,
    /// The cells, a row each as long as the columns.
    pub rows: Vec<Vec<String>>,
    /// Explanations of its numbers, for tables that stand alone.
    pub notes: Vec<String>,
}

/// Stands where there is no value.
pub const NONE: &str = "–";

impl CaptionedTable {
    /// A table of the columns that have a heading. A number stands with its interval, where it has columns `…_ci_low` and
    /// `…_ci_high`.
    #[must_use]
    pub fn new(
        caption: impl Into<String>,
        name: impl Into<String>,
        columns: &[Column],
        rows: &[Row],
    ) -> Self {
        let is_shown = |(place, column): &(usize, &Column)| {
            let is_empty = |row: &Row| {
                let cell = &row[*place];
                matches!(cell, Cell::None(_) | Cell::Integer(0))
            };
            !(column.title.is_empty() || column.rare && rows.iter().all(is_empty))
        };
        let shown: Vec<(usize, &Column)> = columns.iter().enumerate().filter(is_shown).collect();
        let end = |row: &Row, column: &Column, which: &str| {
            let name = format!("{}_ci_{which}", column.name);
            let place = columns.iter().position(|one| one.name == name)?;
            row[place].number()
        };
        let cell = |row: &Row, (place, column): &(usize, &Column)| {
            let digits = column.decimals.unwrap_or(2);
            match (
                &row[*place],
                end(row, column, "low"),
                end(row, column, "high"),
            ) {
                (Cell::None(_), ..) => NONE.into(),
                (cell, Some(low), Some(high)) => {
                    let value = cell.shown(column);
                    format!("{value} [{low:.digits$}, {high:.digits$}]")
                }
                (cell, ..) => cell.shown(column).into_owned(),
            }
        };
        let row = |row: &Row| shown.iter().map(|one| cell(row, one)).collect();
        let is_number = |column: &Column| !matches!(column.kind, Kind::Text | Kind::Truth);
        Self {
            caption: caption.into(),
            name: name.into(),
            rows: rows.iter().map(row).collect(),
            columns: shown
                .iter()
                .map(|(_, column)| (heading(column), is_number(column)))
                .collect(),
            notes: Vec::new(),
        }
    }

    /// The same with notes beneath it.
    #[must_use]
    pub fn with_notes(self, notes: impl IntoIterator<Item = String>) -> Self {
        let notes = notes.into_iter().collect();
        Self { notes, ..self }
    }

    /// The same, unless it has no rows.
    #[must_use]
    pub fn filled(self) -> Option<Self> {
        (!self.rows.is_empty()).then_some(self)
    }
}

/// A value with the ends of its interval: `0.83 [0.70, 0.91]`.
#[must_use]
pub fn with_interval(value: Option<f64>, interval: Option<(f64, f64)>) -> String {
    match (value, interval) {
        (None, _) => NONE.into(),
        (Some(value), None) => format!("{value:.2}"),
        (Some(value), Some((low, high))) => format!("{value:.2} [{low:.2}, {high:.2}]"),
    }
}

/// Text on one line, with what terminals and browsers would obey shown instead.
pub(crate) fn one_line(text: &str) -> String {
    visible(text)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}
