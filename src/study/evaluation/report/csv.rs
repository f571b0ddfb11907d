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
        csv(&self.rows())
    }

    /// The lines of [`Report::csv`] as objects.
    #[must_use]
    pub fn rows(&self) -> Vec<Value> {
        self.with_columns(self.cells.iter().map(Cell::json))
    }

    /// The lines of [`Report::pairs_csv`] as objects.
    pub(super) fn pair_rows(&self) -> Vec<Value> {
        self.with_columns(self.pairs.iter().map(json::pair))
    }

    /// The comparisons of ways, one line each; the header alone is not written.
    ///
    /// # Errors
    /// Never in practice: the writer's own words.
    pub fn pairs_csv(&self) -> Result<String, String> {
        csv(&self.pair_rows())
    }

    fn with_columns(&self, objects: impl Iterator<Item = Value>) -> Vec<Value> {
        let with = |mut object: Value| {
            for (name, value) in self.about.columns() {
                object[name] = value;
            }
            object
        };
        objects.map(with).collect()
    }
}

/// Objects as CSV: the table of [`FlatTable::new`].
///
/// # Errors
/// Never in practice: the writer's own words.
pub fn csv(objects: &[Value]) -> Result<String, String> {
    let table = FlatTable::new(objects);
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let wrong = |error: ::csv::Error| error.to_string();
    if !table.columns.is_empty() {
        writer.write_record(&table.columns).map_err(wrong)?;
    }
    for row in &table.rows {
        let cells = row.iter().map(|value| match value {
            Value::Null => String::new(),
            Value::String(text) => clean(text),
            other => other.to_string(),
        });
        writer.write_record(cells).map_err(wrong)?;
    }
    let bytes = writer.into_inner().map_err(|e| e.error().to_string())?;
    String::from_utf8(bytes).map_err(|e| e.to_string())
}

/// Objects as rows of plain values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FlatTable {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// A value for each column: null, a truth value, a number or text.
    pub rows: Vec<Vec<Value>>,
}

impl FlatTable {
    /// Columns of the first object, then of the others. Nested values are flattened: `a.b` is `b` in `a`, intervals
    /// `x_ci` become `x_ci_low` and `x_ci_high`, and other lists are the text `1 2 3`.
    #[must_use]
    pub fn new(objects: &[Value]) -> Self {
        let rows: Vec<Vec<(String, Value)>> = objects.iter().map(flat).collect();
        let mut columns: Vec<String> = Vec::new();
        for (name, _) in rows.iter().flatten() {
            if !columns.contains(name) {
                columns.push(name.clone());
            }
        }
        let of_columns = |row: &Vec<(String, Value)>| {
            let cell = |column: &String| {
                let found = row.iter().find(|(name, _)| name == column);
                found.map_or(Value::Null, |(_, value)| value.clone())
            };
            columns.iter().map(cell).collect()
        };
        Self {
            rows: rows.iter().map(of_columns).collect(),
            columns,
        }
    }
}

fn flat(object: &Value) -> Vec<(String, Value)> {
    let mut found = Vec::new();
    flatten("", object, &mut found);
    found
}

fn flatten(name: &str, value: &Value, into: &mut Vec<(String, Value)>) {
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
            into.push((name.into(), words.join(" ").into()));
        }
        plain => into.push((name.into(), plain.clone())),
    }
}
