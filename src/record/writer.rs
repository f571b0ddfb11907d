//! Writes a table piece by piece in any of the formats, Parquet among them: typed columns, their meaning as metadata.

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
use strum::{IntoStaticStr, VariantArray};

use super::table::{Cell, Column, Kind, Row, Table};
use super::text;

/// Formats of tables for other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Format {
    /// Comma-separated, with a header.
    Csv,
    /// One JSON object a line.
    Json,
    /// Apache Parquet.
    Parquet,
}

crate::named!(Format);

/// Rows, as far as they can be written without the others.
pub enum Encoded {
    /// Of CSV or JSON.
    Text(Vec<u8>),
    /// Of Parquet, which is written by columns.
    Rows(Vec<Row>),
}

impl Table {
    /// Rows in a format, which needs no writer: scenarios are encoded at the same time.
    pub fn encode(&self, format: Format, rows: Vec<Row>) -> Encoded {
        let rows = self.completed(rows);
        match format {
            Format::Csv => Encoded::Text(text::csv_rows(self, &rows)),
            Format::Json => Encoded::Text(text::json_rows(self, &rows)),
            Format::Parquet => Encoded::Rows(rows),
        }
    }
}

/// A table in the making.
pub enum TableWriter<W: Write + Send> {
    /// CSV or JSON.
    Text(W),
    /// Parquet.
    Parquet(Box<ParquetFile<W>>),
}

impl<W: Write + Send> TableWriter<W> {
    /// Begins the table with its header.
    ///
    /// # Errors
    /// The target cannot be written.
    pub fn begin(mut target: W, format: Format, table: &Table) -> io::Result<Self> {
        Ok(match format {
            Format::Parquet => Self::Parquet(Box::new(ParquetFile::new(target, table)?)),
            Format::Csv => {
                target.write_all(&text::csv_header(table))?;
                Self::Text(target)
            }
            Format::Json => Self::Text(target),
        })
    }

    /// Writes rows that [`Table::encode`] made for the same format.
    ///
    /// # Errors
    /// The target cannot be written, or the rows are for another format.
    pub fn write(&mut self, rows: Encoded) -> io::Result<()> {
        match (self, rows) {
            (Self::Text(target), Encoded::Text(text)) => target.write_all(&text),
            (Self::Parquet(file), Encoded::Rows(rows)) => file.write(rows),
            _ => Err(io::Error::other("rows of another format than the table's")),
        }
    }

    /// Ends the table; it is not yet in its place.
    ///
    /// # Errors
    /// The target cannot be written.
    pub fn finish(self) -> io::Result<W> {
        let mut target = match self {
            Self::Text(target) => target,
            Self::Parquet(file) => file.finish()?,
        };
        target.flush().map(|()| target)
    }
}

/// A Parquet file in the making.
pub struct ParquetFile<W: Write + Send> {
    file: SerializedFileWriter<W>,
    columns: Vec<Column>,
    group: usize,
    waiting: Vec<Row>,
}

impl<W: Write + Send> ParquetFile<W> {
    /// Begins a file of this table.
    ///
    /// # Errors
    /// Two columns have one name.
    pub fn new(out: W, table: &Table) -> io::Result<Self> {
        let entries = table
            .metadata
            .iter()
            .map(|(key, value)| KeyValue::new(format!("nearmiss.{key}"), value.clone()));
        let entries: Vec<KeyValue> = entries.collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("nearmiss version {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata((!entries.is_empty()).then_some(entries));
        let schema = schema(table).map_err(io::Error::other)?;
        let file = SerializedFileWriter::new(out, schema, Arc::new(properties.build()));
        Ok(Self {
            file: file.map_err(io::Error::other)?,
            columns: table.columns.clone(),
            group: table.group,
            waiting: Vec::new(),
        })
    }

    /// Takes rows; they are written by groups.
    ///
    /// # Errors
    /// The target cannot be written.
    pub fn write(&mut self, rows: Vec<Row>) -> io::Result<()> {
        self.waiting.extend(rows);
        if self.waiting.len() >= self.group {
            self.write_group().map_err(io::Error::other)?;
        }
        Ok(())
    }

    /// Writes the last rows and the footer.
    ///
    /// # Errors
    /// The target cannot be written.
    pub fn finish(mut self) -> io::Result<W> {
        self.write_group()
            .and_then(|()| self.file.into_inner())
            .map_err(io::Error::other)
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let rows = std::mem::take(&mut self.waiting);
        if rows.is_empty() {
            return Ok(());
        }
        let mut group = self.file.next_row_group()?;
        for (place, column) in self.columns.iter().enumerate() {
            let Some(mut writer) = group.next_column()? else {
                break;
            };
            write_cells(writer.untyped(), column, rows.iter().map(|row| &row[place]))?;
            writer.close()?;
        }
        group.close().map(drop)
    }
}

fn schema(table: &Table) -> Result<TypePtr, ParquetError> {
    let columns = table
        .columns
        .iter()
        .map(|column| {
            let (physical, logical) = match column.kind {
                Kind::Text => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
                Kind::Integer => (PhysicalType::INT64, None),
                Kind::Number | Kind::Float => (PhysicalType::DOUBLE, None),
                Kind::Truth => (PhysicalType::BOOLEAN, None),
            };
            let repetition = if column.optional {
                Repetition::OPTIONAL
            } else {
                Repetition::REQUIRED
            };
            let builder = Type::primitive_type_builder(&column.name, physical)
                .with_repetition(repetition)
                .with_logical_type(logical);
            builder.build().map(Arc::new)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let root = Type::group_type_builder(table.name).with_fields(columns);
    root.build().map(Arc::new)
}

fn write_cells<'a>(
    writer: &mut ColumnWriter<'_>,
    column: &Column,
    cells: impl Iterator<Item = &'a Cell>,
) -> Result<(), ParquetError> {
    macro_rules! write {
        ($writer:expr, $values:expr) => {{
            let (values, levels) = definition_levels($values);
            $writer.write_batch(&values, column.optional.then_some(&levels[..]), None)?
        }};
    }
    match writer {
        ColumnWriter::ByteArrayColumnWriter(writer) => {
            // The same text often comes again in the next row; it is kept once.
            let mut last: Option<(&Cell, ByteArray)> = None;
            write!(
                writer,
                cells.map(|cell| {
                    if !last.as_ref().is_some_and(|(known, _)| *known == cell) {
                        let text = cell.text(column.kind)?;
                        last = Some((cell, ByteArray::from(&*text)));
                    }
                    last.as_ref().map(|(_, bytes)| bytes.clone())
                })
            )
        }
        ColumnWriter::Int64ColumnWriter(writer) => write!(
            writer,
            cells.map(|cell| match cell {
                Cell::Integer(number) => Some(*number),
                _ => None,
            })
        ),
        ColumnWriter::DoubleColumnWriter(writer) => write!(writer, cells.map(Cell::number)),
        ColumnWriter::BoolColumnWriter(writer) => write!(
            writer,
            cells.map(|cell| match cell {
                Cell::Truth(truth) => Some(*truth),
                _ => None,
            })
        ),
        _ => {
            let message = format!("the values of {} do not fit its type", column.name);
            return Err(ParquetError::General(message));
        }
    };
    Ok(())
}

/// The values that are there, and for every place whether one is (1) or not (0).
fn definition_levels<T>(values: impl Iterator<Item = Option<T>>) -> (Vec<T>, Vec<i16>) {
    let (mut found, mut levels) = (Vec::new(), Vec::new());
    for value in values {
        levels.push(i16::from(value.is_some()));
        found.extend(value);
    }
    (found, levels)
}
