//! Reports as CSV: one line for each cell or pair of configurations; flat, unrounded.

use serde_json::Value;

use super::document::clean;
use super::{Cell, Report, json};

impl Report {
    /// The cells, one line each, with the batch and the truth as the last columns.
    ///
    /// # Errors
    /// Never in practice: the writer's own words.
    pub fn csv(&self) -> Result<String, String> {
        self.lines(self.cells.iter().map(Cell::json))
    }

    /// The pairs of ways and McNemar's test between them, one line each; the header alone is not written.
    ///
    /// # Errors
    /// Never in practice: the writer's own words.
    pub fn pairs_csv(&self) -> Result<String, String> {
        self.lines(self.pairs.iter().map(json::pair))
    }

    fn lines(&self, objects: impl Iterator<Item = Value>) -> Result<String, String> {
        let with = |mut object: Value| {
            for (name, value) in self.about.columns() {
                object[name] = value;
            }
            object
        };
        csv(&objects.map(with).collect::<Vec<_>>())
    }
}

/// Objects as CSV: columns of the first object, then of the others. Nested values are flattened: `a.b` is `b` in `a`,
/// intervals `x_ci` become `x_ci_low` and `x_ci_high`, and other lists are written `1 2 3`.
///
/// # Errors
/// Never in practice: the writer's own words.
pub fn csv(objects: &[Value]) -> Result<String, String> {
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
        // Where there is no interval, its columns are empty.
        Value::Array(_) | Value::Null if name.ends_with("_ci") => {
            for (i, end) in ["low", "high"].into_iter().enumerate() {
                let value = value.get(i).unwrap_or(&Value::Null);
                flatten(&format!("{name}_{end}"), value, into);
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
