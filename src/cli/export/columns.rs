//! Columns of exported tables: those of the store's records, nested JSON as text.

use serde_json::Value;

use crate::store::Run;

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Text,
    Integer,
    Number,
    Truth,
}

pub struct Column {
    pub name: &'static str,
    pub kind: Kind,
}

const fn text(name: &'static str) -> Column {
    let kind = Kind::Text;
    Column { name, kind }
}

const fn integer(name: &'static str) -> Column {
    let kind = Kind::Integer;
    Column { name, kind }
}

const fn number(name: &'static str) -> Column {
    let kind = Kind::Number;
    Column { name, kind }
}

const fn truth(name: &'static str) -> Column {
    let kind = Kind::Truth;
    Column { name, kind }
}

/// Every column, in order; the store's own schema says what they mean.
pub const COLUMNS: [Column; 48] = [
    integer("id"),
    integer("created_ms"),
    integer("updated_ms"),
    text("origin"),
    text("source"),
    text("scenario"),
    text("scenario_hash"),
    text("ego"),
    text("task"),
    text("frame"),
    text("techniques"),
    integer("window_first"),
    integer("window_last"),
    text("model"),
    text("model_returned"),
    text("provider"),
    text("dialect"),
    text("endpoint"),
    text("address"),
    text("template"),
    text("template_version"),
    text("template_hash"),
    text("key"),
    integer("sample"),
    text("batch"),
    text("state"),
    truth("dangerous"),
    text("justification"),
    text("verdict"),
    text("reading"),
    text("answer"),
    text("reasoning"),
    text("finish"),
    text("error"),
    integer("input_tokens"),
    integer("output_tokens"),
    integer("reasoning_tokens"),
    integer("cached_tokens"),
    number("cost_usd"),
    text("price_source"),
    integer("first_chunk_ms"),
    integer("duration_ms"),
    text("messages"),
    text("parameters"),
    text("answer_schema"),
    text("notes"),
    truth("pinned"),
    integer("deleted_ms"),
];

/// The value of one column of one run; `Value::Null` if absent.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell(pub Value);

impl Cell {
    /// As text; nothing is empty, and JSON stays JSON.
    pub fn text(&self) -> String {
        match &self.0 {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        }
    }
}

/// The cells of a run, one for each column.
pub fn cells(run: &Run) -> impl Iterator<Item = Cell> + use<> {
    let record = run.to_record();
    let verdict = record["verdict"].clone();
    COLUMNS.iter().map(move |column| {
        let value = match column.name {
            "window_first" => &record["window"][0],
            "window_last" => &record["window"][1],
            "dangerous" => [&verdict["collision"], &verdict["safety_critical"]]
                .into_iter()
                .find(|said| said.is_boolean())
                .unwrap_or(&Value::Null),
            "justification" => &verdict["justification"],
            name => &record[name],
        };
        Cell(value.clone())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_is_there_twice() {
        for (place, column) in COLUMNS.iter().enumerate() {
            assert!(
                COLUMNS[..place].iter().all(|c| c.name != column.name),
                "{}",
                column.name
            );
        }
    }
}
