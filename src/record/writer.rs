//! Writes a table piece by piece in any of the formats; those by columns have their meaning as metadata.

use std::io::{self, Write};

use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_writer::ArrowWriterOptions;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use strum::{IntoStaticStr, VariantArray};

use super::arrow::{Clock, batch};
use super::table::{Column, Row, Table};
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
    /// A stream of Apache Arrow IPC.
    Arrow,
}

crate::named!(Format);

/// Rows, as far as they can be written without the others.
pub enum Encoded {
    /// Of CSV or JSON.
    Text(Vec<u8>),
    /// Of Parquet and Arrow, which are written by columns.
    Rows(Vec<Row>),
}

impl Table {
    /// Rows in a format, which needs no writer: scenarios are encoded at the same time.
    pub fn encode(&self, format: Format, rows: Vec<Row>) -> Encoded {
        let rows = self.completed(rows);
        match format {
            Format::Csv => Encoded::Text(text::csv_rows(self, &rows)),
            Format::Json => Encoded::Text(text::json_rows(self, &rows)),
            Format::Parquet | Format::Arrow => Encoded::Rows(rows),
        }
    }
}

/// A table in the making.
pub enum TableWriter<W: Write + Send> {
    /// CSV or JSON.
    Text(W),
    /// Parquet or Arrow.
    Columns(Box<ColumnsFile<W>>),
}

impl<W: Write + Send> TableWriter<W> {
    /// Begins the table with its header.
    ///
    /// # Errors
    /// The target cannot be written.
    pub fn begin(mut target: W, format: Format, table: &Table) -> io::Result<Self> {
        Ok(match format {
            Format::Parquet => Self::Columns(Box::new(ColumnsFile::parquet(target, table)?)),
            Format::Arrow => Self::Columns(Box::new(ColumnsFile::arrow(target, table)?)),
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
            (Self::Columns(file), Encoded::Rows(rows)) => file.write(rows),
            _ => Err(io::Error::other("rows of another format than the table's")),
        }
    }

    /// Says something in the metadata of Parquet that is known only behind the rows; other formats have no place for it.
    pub fn note(&mut self, key: &str, value: String) {
        if let Self::Columns(file) = self
            && let Sink::Parquet(file) = &mut file.sink
        {
            file.append_key_value_metadata(metadata(key, value));
        }
    }

    /// Ends the table; it is not yet in its place.
    ///
    /// # Errors
    /// The target cannot be written.
    pub fn finish(self) -> io::Result<W> {
        let mut target = match self {
            Self::Text(target) => target,
            Self::Columns(file) => file.finish()?,
        };
        target.flush().map(|()| target)
    }
}

/// A table by columns in the making: its rows are written by groups.
pub struct ColumnsFile<W: Write + Send> {
    sink: Sink<W>,
    schema: SchemaRef,
    columns: Vec<Column>,
    group: usize,
    waiting: Vec<Row>,
}

enum Sink<W: Write + Send> {
    Parquet(ArrowWriter<W>),
    Arrow(StreamWriter<W>),
}

impl<W: Write + Send> ColumnsFile<W> {
    fn parquet(out: W, table: &Table) -> io::Result<Self> {
        let metadata = table.metadata.iter();
        let entries: Vec<KeyValue> = metadata
            .map(|(key, value)| self::metadata(key, value.clone()))
            .collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("nearmiss version {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata((!entries.is_empty()).then_some(entries));
        let options = ArrowWriterOptions::new()
            .with_properties(properties.build())
            .with_schema_root(table.name.to_string());
        // Parquet has no durations.
        let schema = table.arrow_schema(Clock::Seconds);
        let file = ArrowWriter::try_new_with_options(out, schema.clone(), options);
        let sink = Sink::Parquet(file.map_err(of_parquet)?);
        Ok(Self::new(sink, schema, table))
    }

    fn arrow(out: W, table: &Table) -> io::Result<Self> {
        let schema = table.arrow_schema(Clock::Durations);
        let sink = StreamWriter::try_new(out, &schema).map_err(of_arrow)?;
        Ok(Self::new(Sink::Arrow(sink), schema, table))
    }

    fn new(sink: Sink<W>, schema: SchemaRef, table: &Table) -> Self {
        Self {
            sink,
            schema,
            columns: table.columns.clone(),
            group: table.group,
            waiting: Vec::new(),
        }
    }

    fn write(&mut self, rows: Vec<Row>) -> io::Result<()> {
        self.waiting.extend(rows);
        if self.waiting.len() >= self.group {
            self.write_group()?;
        }
        Ok(())
    }

    fn finish(mut self) -> io::Result<W> {
        self.write_group()?;
        match self.sink {
            Sink::Parquet(file) => file.into_inner().map_err(of_parquet),
            Sink::Arrow(stream) => stream.into_inner().map_err(of_arrow),
        }
    }

    fn write_group(&mut self) -> io::Result<()> {
        let rows = std::mem::take(&mut self.waiting);
        if rows.is_empty() {
            return Ok(());
        }
        let batch = batch(&self.columns, &self.schema, &rows).map_err(of_arrow)?;
        match &mut self.sink {
            Sink::Parquet(file) => file
                .write(&batch)
                .and_then(|()| file.flush())
                .map_err(of_parquet),
            Sink::Arrow(stream) => stream.write(&batch).map_err(of_arrow),
        }
    }
}

fn metadata(key: &str, value: String) -> KeyValue {
    KeyValue::new(format!("nearmiss.{key}"), value)
}

/// What the system said, where it was that: a pipe that is closed is no error of the table.
fn of_arrow(error: ArrowError) -> io::Error {
    match error {
        ArrowError::IoError(_, error) => error,
        error => io::Error::other(error),
    }
}

fn of_parquet(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        error => io::Error::other(error),
    }
}
