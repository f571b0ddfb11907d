//! Tables as text: CSV, JSON with one object a line, or cells in line for people.

use serde_json::{Map, Value};

use super::table::{Cell, Row, Table};
use super::visible;
use crate::json;
use nearmiss_base::system::{columns, pad_end, pad_start};

/// The header of a CSV table.
pub fn csv_header(table: &Table) -> Vec<u8> {
    csv(std::iter::once(table.columns.iter().map(|c| &*c.name)))
}

/// The rows of a CSV table; a cell without a value is empty.
pub fn csv_rows(table: &Table, rows: &[Row]) -> Vec<u8> {
    csv(rows.iter().map(|row| {
        let cells = row.iter().zip(&table.columns);
        cells.map(|(cell, column)| cell.text(column.kind).unwrap_or_default())
    }))
}

/// Records of CSV, with control characters shown as symbols.
pub fn csv<R>(records: impl IntoIterator<Item = R>) -> Vec<u8>
where
    R: IntoIterator<Item: AsRef<str>>,
{
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in records {
        let cells = record.into_iter().map(|cell| visible(cell.as_ref()));
        // Writing records of one length to memory does not fail.
        let _ = writer.write_record(cells);
    }
    writer.into_inner().unwrap_or_default()
}

/// The rows as JSON; `null` stands for no number, infinity included, which JSON does not know.
pub fn json_rows(table: &Table, rows: &[Row]) -> Vec<u8> {
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&table.columns).map(|(cell, column)| {
            let value = match cell {
                Cell::Text(text) => Value::from(visible(text)),
                Cell::Integer(number) => Value::from(*number),
                Cell::Number(number) => Value::from(*number),
                Cell::Truth(truth) => Value::from(*truth),
                Cell::None(_) | Cell::Infinite(_) => Value::Null,
            };
            (column.name.to_string(), value)
        });
        let more = table
            .json_values
            .iter()
            .map(|(name, value)| (name.to_string(), value.clone()));
        let mut object = json::versioned(Value::Object(cells.chain(more).collect::<Map<_, _>>()));
        json::with_old_names(&mut object, table.json_keys);
        text += &object.to_string();
        text.push('\n');
    }
    text.into_bytes()
}

/// How a column is aligned, and how wide it is; wider cells push the ones behind them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    Left(usize),
    Right(usize),
}

/// A line of cells under those of other lines, with `gap` between them; cells without a column are not padded.
pub fn line(gap: &str, columns: &[Align], cells: &[impl AsRef<str>]) -> String {
    let padded = cells.iter().enumerate().map(|(place, cell)| {
        let cell = visible(cell.as_ref());
        match columns.get(place) {
            Some(Align::Left(width)) => pad_end(&cell, *width),
            Some(Align::Right(width)) => pad_start(&cell, *width),
            None => cell,
        }
    });
    let line = padded.collect::<Vec<_>>().join(gap);
    format!("{}\n", line.trim_end())
}

/// Lines of cells, each column as wide as its widest cell; those at the places `right` are aligned to the right.
pub fn lines<const N: usize>(
    rows: &[[String; N]],
    right: &[usize],
) -> impl Iterator<Item = String> {
    let aligned: [Align; N] = std::array::from_fn(|place| {
        let widths = rows.iter().map(|row| columns(&visible(&row[place])));
        let width = widths.max().unwrap_or(0);
        if right.contains(&place) {
            Align::Right(width)
        } else {
            Align::Left(width)
        }
    });
    rows.iter().map(move |row| line("  ", &aligned, row))
}
