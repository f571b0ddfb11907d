//! The cells of a report as CSV: one line a cell, flat, nothing rounded.

use serde_json::Value;

use super::document::clean;

/// Objects as CSV: the columns are those of the first object and then of the others; what has parts of its own is
/// flattened, `a.b` being `b` in `a`, and lists are written `1 2 3`.
pub(super) fn csv(objects: &[Value]) -> Result<String, String> {
    let rows: Vec<Vec<(String, String)>> = objects.iter().map(flat).collect();
    let mut columns: Vec<&String> = Vec::new();
    for (name, _) in rows.iter().flatten() {
        if !columns.contains(&name) {
            columns.push(name);
        }
    }
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let wrong = |error: ::csv::Error| error.to_string();
    if !columns.is_empty() {
        writer.write_record(&columns).map_err(wrong)?;
    }
    for row in &rows {
        let cell = |column: &&String| {
            let found = row.iter().find(|(name, _)| name == *column);
            found.map_or("", |(_, value)| value)
        };
        writer
            .write_record(columns.iter().map(cell))
            .map_err(wrong)?;
    }
    let bytes = writer.into_inner().map_err(|e| e.error().to_string())?;
    String::from_utf8(bytes).map_err(|e| e.to_string())
}

fn flat(object: &Value) -> Vec<(String, String)> {
    let mut found = Vec::new();
    flatten("", object, &mut found);
    found
}

fn flatten(name: &str, value: &Value, into: &mut Vec<(String, String)>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let name = match name {
                    "" => key.clone(),
                    _ => format!("{name}.{key}"),
                };
                flatten(&name, value, into);
            }
        }
        Value::Array(items) if items.iter().any(Value::is_object) => {
            for (i, item) in items.iter().enumerate() {
                flatten(&format!("{name}.{i}"), item, into);
            }
        }
        Value::Array(items) => {
            let words: Vec<String> = items.iter().map(Value::to_string).collect();
            into.push((name.into(), words.join(" ")));
        }
        Value::Null => into.push((name.into(), String::new())),
        Value::String(text) => into.push((name.into(), clean(text))),
        other => into.push((name.into(), other.to_string())),
    }
}
