//! Tables as text: CSV, or JSON with one object a line.

use serde_json::{Map, Value, json};

use super::table::{Cell, Field, Kind, Sheet, Table, Values};

/// The header of a CSV table.
pub fn csv_header(table: &Table) -> Vec<u8> {
    records(std::iter::once(
        table.fields.iter().map(|f| f.name.clone()).collect(),
    ))
}

/// The rows of a CSV table; a cell without a number is empty.
pub fn csv(table: &Table, sheet: &Sheet) -> Vec<u8> {
    records((0..sheet.rows).map(|row| {
        let cells = table
            .fields
            .iter()
            .map(|field| match value(field, sheet, row) {
                Scalar::Text(text) => text.to_string(),
                Scalar::Integer(number) => number.to_string(),
                Scalar::Number(cell) => match (cell.number(), field.kind) {
                    (Some(number), Kind::Number { form, .. }) => form.text(number),
                    _ => String::new(),
                },
            });
        cells.collect()
    }))
}

/// The rows as JSON; `null` stands for no number, infinity included, which JSON does not know.
pub fn json(table: &Table, sheet: &Sheet) -> Vec<u8> {
    let mut text = Vec::new();
    for row in 0..sheet.rows {
        let cells = table.fields.iter().map(|field| {
            let cell = match value(field, sheet, row) {
                Scalar::Text("") if field.reasons => Value::Null,
                Scalar::Text(text) => json!(text),
                Scalar::Integer(number) => json!(number),
                Scalar::Number(Cell::Value(number)) => json!(number),
                Scalar::Number(_) => Value::Null,
            };
            (field.name.clone(), cell)
        });
        let object = Value::Object(cells.collect::<Map<_, _>>());
        text.extend_from_slice(object.to_string().as_bytes());
        text.push(b'\n');
    }
    text
}

enum Scalar<'a> {
    Text(&'a str),
    Integer(i64),
    Number(Cell),
}

fn value<'a>(field: &Field, sheet: &'a Sheet, row: usize) -> Scalar<'a> {
    match &sheet.values[field.place] {
        Values::Same(text) => Scalar::Text(text),
        Values::Text(texts) => Scalar::Text(texts[row]),
        Values::Integer(numbers) => Scalar::Integer(numbers[row]),
        Values::Number(cells) if field.reasons => {
            Scalar::Text(cells[row].reason().unwrap_or_default())
        }
        Values::Number(cells) => Scalar::Number(cells[row]),
    }
}

fn records(records: impl Iterator<Item = Vec<String>>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in records {
        // Writing records of one length to memory does not fail.
        let _ = writer.write_record(&record);
    }
    writer.into_inner().unwrap_or_default()
}
