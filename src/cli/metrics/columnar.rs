//! Tables as Apache Parquet: typed columns, their meaning as metadata.

use std::collections::HashMap;
use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};
use serde_json::json;

use super::table::{Field, Kind, Sheet, Table, Values};
use crate::cli::parted::parted;

/// Rows that are kept in memory before they are written as a row group.
const GROUP: usize = 65_536;

/// A Parquet file in the making.
pub struct Columnar<W: Write + Send> {
    file: SerializedFileWriter<W>,
    fields: Vec<Field>,
    waiting: Vec<Sheet>,
}

impl<W: Write + Send> Columnar<W> {
    pub fn new(out: W, table: &Table) -> io::Result<Self> {
        let version = env!("CARGO_PKG_VERSION");
        let entry = |key: &str, value: String| KeyValue::new(format!("nearmiss.{key}"), value);
        let columns: Vec<_> = table
            .columns
            .iter()
            .map(|c| json!({ "name": c.name, "unit": c.unit, "source": c.source }))
            .collect();
        let mut entries = vec![
            entry("version", version.into()),
            entry("convention", table.convention.into()),
            entry("columns", json!(columns).to_string()),
        ];
        if let Some(changed) = &table.thresholds {
            entries.push(entry("thresholds_changed", json!(changed).to_string()));
        }
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("nearmiss version {version}"))
            .set_key_value_metadata(Some(entries));
        let schema = schema(&table.fields).map_err(io::Error::other)?;
        let file = SerializedFileWriter::new(out, schema, Arc::new(properties.build()));
        Ok(Self {
            file: file.map_err(io::Error::other)?,
            fields: table.fields.clone(),
            waiting: Vec::new(),
        })
    }

    pub fn write(&mut self, sheet: Sheet) -> io::Result<()> {
        self.waiting.push(sheet);
        if self.waiting.iter().map(|s| s.rows).sum::<usize>() >= GROUP {
            self.write_group().map_err(io::Error::other)?;
        }
        Ok(())
    }

    pub fn finish(mut self) -> io::Result<W> {
        self.write_group()
            .and_then(|()| self.file.into_inner())
            .map_err(io::Error::other)
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let sheets = std::mem::take(&mut self.waiting);
        if sheets.iter().all(|s| s.rows == 0) {
            return Ok(());
        }
        let mut group = self.file.next_row_group()?;
        let mut words = Words::default();
        for field in &self.fields {
            let Some(mut column) = group.next_column()? else {
                break;
            };
            for sheet in &sheets {
                write_values(column.untyped(), field, sheet, &mut words)?;
            }
            column.close()?;
        }
        group.close().map(drop)
    }
}

fn schema(fields: &[Field]) -> Result<TypePtr, ParquetError> {
    let columns = fields.iter().map(|field| {
        let (physical, logical, optional) = match field.kind {
            Kind::Text => (
                PhysicalType::BYTE_ARRAY,
                Some(LogicalType::String),
                field.reasons,
            ),
            Kind::Integer => (PhysicalType::INT64, None, false),
            Kind::Number { lacking, .. } => (PhysicalType::DOUBLE, None, lacking),
        };
        let repetition = if optional {
            Repetition::OPTIONAL
        } else {
            Repetition::REQUIRED
        };
        let column = Type::primitive_type_builder(&field.name, physical)
            .with_repetition(repetition)
            .with_logical_type(logical);
        column.build().map(Arc::new)
    });
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    let root = Type::group_type_builder("measures").with_fields(columns);
    root.build().map(Arc::new)
}

/// Words that come again and again, each kept once.
#[derive(Default)]
struct Words(HashMap<&'static str, ByteArray>);

impl Words {
    fn get(&mut self, word: &'static str) -> ByteArray {
        self.0
            .entry(word)
            .or_insert_with(|| ByteArray::from(word))
            .clone()
    }
}

fn write_values(
    writer: &mut ColumnWriter<'_>,
    field: &Field,
    sheet: &Sheet,
    words: &mut Words,
) -> Result<(), ParquetError> {
    match (writer, &sheet.values[field.place]) {
        (ColumnWriter::ByteArrayColumnWriter(writer), Values::Same(text)) => {
            let all = vec![ByteArray::from(text.as_str()); sheet.rows];
            writer.write_batch(&all, None, None)?;
        }
        (ColumnWriter::ByteArrayColumnWriter(writer), Values::Text(texts)) => {
            let all: Vec<_> = texts.iter().map(|text| words.get(text)).collect();
            writer.write_batch(&all, None, None)?;
        }
        (ColumnWriter::ByteArrayColumnWriter(writer), Values::Number(cells)) => {
            let (reasons, there) = parted(cells.iter().map(|cell| cell.reason()));
            let reasons: Vec<_> = reasons.into_iter().map(|why| words.get(why)).collect();
            writer.write_batch(&reasons, Some(&there), None)?;
        }
        (ColumnWriter::Int64ColumnWriter(writer), Values::Integer(numbers)) => {
            writer.write_batch(numbers, None, None)?;
        }
        (ColumnWriter::DoubleColumnWriter(writer), Values::Number(cells)) => {
            let (numbers, there) = parted(cells.iter().map(|cell| cell.number()));
            let optional = matches!(field.kind, Kind::Number { lacking: true, .. });
            writer.write_batch(&numbers, optional.then_some(&there[..]), None)?;
        }
        _ => {
            let message = format!("the values of {} do not fit its type", field.name);
            return Err(ParquetError::General(message));
        }
    }
    Ok(())
}
