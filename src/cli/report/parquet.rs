//! Reports as Apache Parquet: the rows of CSV in typed columns, with provenance as metadata.

use std::path::Path;

use serde_json::{Value, json};

use crate::Outcome;
use crate::output::{self, Cell, Column, Format, Kind, Table, TableWriter, Target};
use nearmiss_study::evaluation::Provenance;
use nearmiss_study::evaluation::report::FlatTable;

/// Columns of words, which have this type in reports without a value of theirs, too.
const WORDS: [&str; 12] = [
    "label",
    "task",
    "frame",
    "techniques",
    "technique",
    "model",
    "settings",
    "template",
    "template_hash",
    "batch",
    "truth",
    "split",
];

/// Writes the lines of a report.
pub fn write(
    (file, target): (Option<&Path>, Target),
    objects: &[Value],
    provenance: Option<&Provenance>,
) -> Outcome {
    let flat = FlatTable::new(objects);
    let columns = flat.columns.iter().enumerate().map(|(place, name)| Column {
        name: name.clone().into(),
        ..Column::new(
            "",
            kind(name, flat.rows.iter().map(|row| &row[place])),
            "",
            "",
        )
        .optional()
    });
    let mut table = Table::new("report", columns.collect());
    table
        .metadata
        .push(("version", env!("CARGO_PKG_VERSION").into()));
    if let Some(provenance) = provenance {
        let provenance = json!(provenance).to_string();
        table.metadata.push(("provenance", provenance));
    }
    let rows = flat.rows.iter().map(|row| {
        let cells = row.iter().zip(&table.columns);
        cells
            .map(|(value, column)| cell(value, column.kind))
            .collect()
    });
    let rows = table.encode(Format::Parquet, rows.collect());
    let written = TableWriter::begin(target, Format::Parquet, &table).and_then(|mut writer| {
        writer.write(rows)?;
        writer.finish()
    });
    match output::written(file, written)? {
        Some(target) => target.finish(),
        None => Ok(()),
    }
}

/// The type that all values of a column have.
fn kind<'a>(name: &str, values: impl Iterator<Item = &'a Value>) -> Kind {
    let mut found = None;
    for value in values {
        let kind = match value {
            Value::Null => continue,
            Value::Bool(_) => Kind::Truth,
            Value::Number(number) if number.is_f64() => Kind::Float,
            Value::Number(_) => Kind::Integer,
            _ => Kind::Text,
        };
        found = match found {
            None => Some(kind),
            Some(known) if known == kind => Some(kind),
            Some(Kind::Integer | Kind::Float) if [Kind::Integer, Kind::Float].contains(&kind) => {
                Some(Kind::Float)
            }
            Some(_) => Some(Kind::Text),
        };
    }
    found.unwrap_or(if WORDS.contains(&name) {
        Kind::Text
    } else {
        Kind::Float
    })
}

fn cell(value: &Value, kind: Kind) -> Cell {
    match (kind, value) {
        (_, Value::Null) => Cell::None(""),
        (Kind::Float, value) => value.as_f64().map_or(Cell::None(""), Cell::Number),
        (Kind::Text, Value::String(text)) => text.clone().into(),
        (Kind::Text, other) => other.to_string().into(),
        (_, value) => Cell::from_json(value),
    }
}
