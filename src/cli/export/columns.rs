//! Columns of exported tables: those of the store's records, nested JSON as text.

use serde_json::Value;

use crate::output::{Cell, Column, Kind, Row, Table};
use nearmiss_scene::verdict::Task;

/// Every column, in order, those of a kind together; the store's own schema says what they mean.
const COLUMNS: &[(Kind, &str)] = &[
    (Kind::Integer, "id created_ms updated_ms"),
    (
        Kind::Text,
        "origin source scenario scenario_hash ego task frame techniques",
    ),
    (Kind::Integer, "window_first window_last"),
    (
        Kind::Text,
        "model model_returned provider dialect endpoint address template template_version template_hash \
         key",
    ),
    (Kind::Integer, "sample"),
    (Kind::Text, "batch state answer_state"),
    (Kind::Truth, "dangerous"),
    (Kind::Float, "probability token_probability"),
    (
        Kind::Text,
        "justification verdict reading answer reasoning finish error",
    ),
    (
        Kind::Integer,
        "input_tokens output_tokens reasoning_tokens cached_tokens",
    ),
    (Kind::Float, "cost_usd most_usd"),
    (Kind::Text, "price_source"),
    (
        Kind::Integer,
        "first_chunk_ms duration_ms claims_right claims_wrong claims_open claims_check",
    ),
    (Kind::Text, "messages parameters answer_schema notes"),
    (Kind::Truth, "pinned"),
    (Kind::Integer, "deleted_ms"),
];

fn columns() -> impl Iterator<Item = Column> {
    COLUMNS.iter().flat_map(|(kind, names)| {
        let names = names.split(' ');
        names.map(|name| Column::new(name, *kind, "", "").optional())
    })
}

/// The table of runs, in row groups of a few hundred, as answers are long.
pub fn table() -> Table {
    let mut table = Table::new("runs", columns().collect());
    table.group = 512;
    table
}

/// The cells of a run's record, one for each column.
pub fn cells(record: &Value) -> Row {
    let verdict = &record["verdict"];
    let cells = columns().map(|column| {
        let value = match &*column.name {
            "window_first" => &record["window"][0],
            "window_last" => &record["window"][1],
            "dangerous" => {
                let said = Task::VERDICTS.map(|task| &verdict[task.key()]);
                said.into_iter()
                    .find(|said| said.is_boolean())
                    .unwrap_or(&Value::Null)
            }
            name @ ("justification" | "probability" | "token_probability") => &verdict[name],
            name => &record[name],
        };
        Cell::from_json(value)
    });
    cells.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_is_there_twice() {
        let names: Vec<_> = columns().map(|column| column.name).collect();
        for (place, name) in names.iter().enumerate() {
            assert!(!names[..place].contains(name), "{name}");
        }
    }
}
