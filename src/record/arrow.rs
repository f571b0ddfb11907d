//! A table as Arrow: typed columns with their units, in batches that other programs take as they are.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::{
    ArrayRef, BooleanArray, DurationMicrosecondArray, Float64Array, Int64Array, RecordBatch,
    StringArray,
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef, TimeUnit};

use crate::table::{Cell, Column, Kind, Row, Table};

/// How moments of the recording are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Durations since step 0, in microseconds.
    Durations,
    /// Numbers of seconds, for formats without durations.
    Seconds,
}

impl Table {
    /// The schema of its batches: of each field `unit` and `description`, of the whole its metadata as `nearmiss.KEY`.
    #[must_use]
    pub fn arrow_schema(&self, clock: Clock) -> SchemaRef {
        let fields = self.columns.iter().map(|column| {
            let metadata = [("unit", &column.unit), ("description", &column.source)]
                .into_iter()
                .filter(|(_, text)| !text.is_empty())
                .map(|(key, text)| (key.to_string(), text.to_string()));
            Field::new(&*column.name, data_type(column, clock), column.optional)
                .with_metadata(metadata.collect::<HashMap<_, _>>())
        });
        let whole = self.metadata.iter();
        let metadata = whole.map(|(key, value)| (format!("nearmiss.{key}"), value.clone()));
        Arc::new(Schema::new_with_metadata(
            fields.collect::<Vec<_>>(),
            metadata.collect::<HashMap<_, _>>(),
        ))
    }

    /// Rows as a batch of this schema, with their reasons where the table has any.
    ///
    /// # Errors
    /// A column without gaps has one.
    pub fn arrow_batch(
        &self,
        schema: &SchemaRef,
        rows: Vec<Row>,
    ) -> Result<RecordBatch, ArrowError> {
        batch(&self.columns, schema, &self.completed(rows))
    }
}

/// Rows that have all their cells as a batch.
pub(crate) fn batch(
    columns: &[Column],
    schema: &SchemaRef,
    rows: &[Row],
) -> Result<RecordBatch, ArrowError> {
    let typed = columns.iter().zip(schema.fields()).enumerate();
    let arrays = typed.map(|(place, (column, field))| {
        let cells = rows.iter().map(|row| &row[place]);
        array(column, field.data_type(), cells)
    });
    RecordBatch::try_new(schema.clone(), arrays.collect())
}

fn data_type(column: &Column, clock: Clock) -> DataType {
    match column.kind {
        _ if column.on_clock && clock == Clock::Durations => {
            DataType::Duration(TimeUnit::Microsecond)
        }
        Kind::Text => DataType::Utf8,
        Kind::Integer => DataType::Int64,
        Kind::Number | Kind::Float => DataType::Float64,
        Kind::Truth => DataType::Boolean,
    }
}

fn array<'a>(
    column: &Column,
    wanted: &DataType,
    cells: impl Iterator<Item = &'a Cell> + Clone,
) -> ArrayRef {
    match wanted {
        DataType::Duration(_) => {
            let micros = |seconds: f64| (seconds * 1e6).round() as i64;
            Arc::new(DurationMicrosecondArray::from_iter(
                cells.map(|cell| cell.number().map(micros)),
            ))
        }
        DataType::Int64 => Arc::new(Int64Array::from_iter(cells.map(|cell| match cell {
            Cell::Integer(number) => Some(*number),
            _ => None,
        }))),
        DataType::Float64 => Arc::new(Float64Array::from_iter(cells.map(Cell::number))),
        DataType::Boolean => Arc::new(BooleanArray::from_iter(cells.map(|cell| match cell {
            Cell::Truth(truth) => Some(*truth),
            _ => None,
        }))),
        _ => Arc::new(StringArray::from_iter(
            cells.map(|cell| cell.text(column.kind)),
        )),
    }
}
