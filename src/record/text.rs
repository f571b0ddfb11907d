//! Tables as text: CSV, JSON with one object a line, or cells in line for people.

use serde_json::{Map, Value};

use crate::table::{Cell, Column, Kind, Row, Table};
use nearmiss_base::system::{columns, escaped_json, pad_end, pad_start, visible};

/// The version of the form of all JSON; it grows when a key goes or changes its meaning.
pub const SCHEMA_VERSION: u32 = 2;

/// An object with its `schema_version` in front; other values as they are.
pub fn versioned(value: Value) -> Value {
    match value {
        Value::Object(fields) => {
            let version = ("schema_version".to_string(), SCHEMA_VERSION.into());
            let mut object = Map::from_iter([version]);
            object.extend(fields);
            Value::Object(object)
        }
        other => other,
    }
}

/// One JSON object as a line that no terminal obeys, with the version of its form.
///
/// # Errors
/// A map in it has keys that JSON does not allow.
pub fn json_line(value: &impl serde::Serialize) -> serde_json::Result<String> {
    let value = versioned(serde_json::to_value(value)?);
    Ok(escaped_json(&value.to_string()) + "\n")
}

/// The header of a CSV table.
pub(crate) fn csv_header(table: &Table) -> Vec<u8> {
    csv(std::iter::once(table.columns.iter().map(|c| &*c.name)))
}

/// The rows of a CSV table; a cell without a value is empty.
pub(crate) fn csv_rows(table: &Table, rows: &[Row]) -> Vec<u8> {
    let guarded = |cell: &Cell, kind: Kind| {
        let text = cell.text(kind).unwrap_or_default();
        if table.for_spreadsheet && matches!(cell, Cell::Text(_)) && begins_formula(&text) {
            format!("'{text}")
        } else {
            text.into_owned()
        }
    };
    csv(rows.iter().map(|row| {
        let cells = row.iter().zip(&table.columns);
        cells.map(|(cell, column)| guarded(cell, column.kind))
    }))
}

/// Whether a spreadsheet would take a text for a formula. Numbers are none, whatever their sign.
pub fn begins_formula(text: &str) -> bool {
    text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.parse::<f64>().is_err()
}

/// Records of CSV, with control characters shown as symbols.
pub fn csv<R>(records: impl IntoIterator<Item = R>) -> Vec<u8>
where
    R: IntoIterator<Item: AsRef<str>>,
{
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    for record in records {
        let cells = record.into_iter();
        let cells = cells.map(|cell| visible(cell.as_ref()).into_owned());
        // Writing records of one length to memory does not fail.
        let _ = writer.write_record(cells);
    }
    writer.into_inner().unwrap_or_default()
}

/// The rows as JSON; `null` stands for no number, infinity included, which JSON does not know.
pub(crate) fn json_rows(table: &Table, rows: &[Row]) -> Vec<u8> {
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&table.columns).map(|(cell, column)| {
            let value = match cell {
                Cell::Text(text) => Value::from(&*visible(text)),
                Cell::Integer(number) => Value::from(*number),
                Cell::Number(number) => Value::from(*number),
                Cell::Truth(truth) => Value::from(*truth),
                Cell::None(_) | Cell::Infinite(_) => Value::Null,
            };
            (column.name.to_string(), value)
        });
        let more = table.json_values.iter();
        let more = more.map(|(name, value)| (name.to_string(), value.clone()));
        let object: Map<String, Value> = cells.chain(more).collect();
        text += &versioned(Value::Object(object)).to_string();
        text.push('\n');
    }
    text.into_bytes()
}

/// How a column is aligned, and how wide it is; wider cells push the ones behind them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words, so many columns of the terminal wide.
    Left(usize),
    /// Numbers.
    Right(usize),
}

/// A line of cells under those of other lines, with `gap` between them; cells without a column are not padded.
pub fn line(gap: &str, columns: &[Align], cells: &[impl AsRef<str>]) -> String {
    let padded = cells.iter().enumerate().map(|(place, cell)| {
        let cell = visible(cell.as_ref());
        match columns.get(place) {
            Some(Align::Left(width)) => pad_end(&cell, *width),
            Some(Align::Right(width)) => pad_start(&cell, *width),
            None => cell.into_owned(),
        }
    });
    let line = padded.collect::<Vec<_>>().join(gap);
    format!("{}\n", line.trim_end())
}

/// Lines of cells, each column as wide as its widest cell; those at the places `right` are aligned to the right.
pub fn lines<R: AsRef<[String]>>(rows: &[R], right: &[usize]) -> impl Iterator<Item = String> {
    let count = rows.iter().map(|row| row.as_ref().len()).max().unwrap_or(0);
    let align = |place: usize| {
        let cells = rows.iter().filter_map(|row| row.as_ref().get(place));
        let width = cells.map(|cell| columns(&visible(cell))).max().unwrap_or(0);
        if right.contains(&place) {
            Align::Right(width)
        } else {
            Align::Left(width)
        }
    };
    let aligned: Vec<Align> = (0..count).map(align).collect();
    rows.iter()
        .map(move |row| line("  ", &aligned, row.as_ref()))
}

/// The columns that have a heading, line by line for people: numbers to the right, texts to the left.
#[derive(Debug, Clone)]
pub struct TextTable {
    /// Where each shown column stands in a row, and how it is set.
    shown: Vec<(usize, Column)>,
    widths: Vec<Align>,
}

impl TextTable {
    /// As wide as the headings; rows that are not known yet may push what is behind them.
    #[must_use]
    pub fn new(columns: &[Column]) -> Self {
        Self::fitted(columns, &[])
    }

    /// As wide as the widest of these rows and the heading.
    #[must_use]
    pub fn fitted(of: &[Column], rows: &[Row]) -> Self {
        let all = of.iter().enumerate();
        let is_empty = |cell: &Cell| matches!(cell, Cell::None(_) | Cell::Integer(0));
        let shown: Vec<(usize, Column)> = all
            .filter(|(_, column)| !column.title.is_empty())
            .filter(|(place, column)| {
                !column.rare || !rows.iter().all(|row| is_empty(&row[*place]))
            })
            .map(|(place, column)| (place, column.clone()))
            .collect();
        let width = |(place, column): &(usize, Column)| {
            let cells = rows
                .iter()
                .map(|row| columns(&visible(&row[*place].shown(column))));
            let width = cells.chain([columns(&heading(column))]).max().unwrap_or(0);
            match column.kind {
                Kind::Text | Kind::Truth => Align::Left(width),
                _ => Align::Right(width),
            }
        };
        Self {
            widths: shown.iter().map(width).collect(),
            shown,
        }
    }

    /// The line of headings.
    #[must_use]
    pub fn header(&self) -> String {
        let titles: Vec<String> = self.shown.iter().map(|(_, c)| heading(c)).collect();
        line("  ", &self.widths, &titles)
    }

    /// The line of a row.
    #[must_use]
    pub fn row(&self, row: &Row) -> String {
        let cells = self
            .shown
            .iter()
            .map(|(place, column)| row[*place].shown(column));
        line("  ", &self.widths, &cells.collect::<Vec<_>>())
    }
}

/// A title with its unit: `took s`.
pub(crate) fn heading(column: &Column) -> String {
    format!("{} {}", column.title, column.unit)
        .trim_end()
        .to_string()
}

/// Rows as a table for people, with headings; empty where there are none.
#[must_use]
pub fn text_table(columns: &[Column], rows: &[Row]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let table = TextTable::fitted(columns, rows);
    let rows = rows.iter().map(|row| table.row(row));
    std::iter::once(table.header()).chain(rows).collect()
}
