//! Writes a table into a target, in any of the formats.

use std::io::{self, Write};
use std::path::Path;

use super::parquet::ParquetFile;
use super::table::{Row, Table};
use super::{Target, text};
use crate::{Failure, Outcome};

/// Formats of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated, with a header.
    Csv,
    /// One JSON object a line.
    Json,
    /// Apache Parquet.
    Parquet,
}

impl Format {
    /// Its word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Json => "json",
            Self::Parquet => "parquet",
        }
    }

    /// Refuses what a terminal or a pipe cannot take.
    pub fn check(self, file: Option<&Path>) -> Outcome {
        match (self, file) {
            (Self::Parquet, None) => Err(Failure::input("Parquet needs a file: -o FILE")),
            _ => Ok(()),
        }
    }
}

/// Rows, as far as they can be written without the others.
pub enum Encoded {
    Text(Vec<u8>),
    Rows(Vec<Row>),
}

impl Table {
    /// Rows in a format, which needs no writer: scenarios are encoded at the same time.
    pub fn encode(&self, format: Format, rows: Vec<Row>) -> Encoded {
        let rows = self.completed(rows);
        match format {
            Format::Csv => Encoded::Text(self.spreadsheet.applied(text::csv_rows(self, &rows))),
            Format::Json => Encoded::Text(text::json_rows(self, &rows)),
            Format::Parquet => Encoded::Rows(rows),
        }
    }
}

/// A table in the making.
pub enum TableWriter {
    Text(Target),
    Parquet(Box<ParquetFile<Target>>),
}

impl TableWriter {
    /// Begins the table with its header.
    pub fn begin(mut target: Target, format: Format, table: &Table) -> io::Result<Self> {
        Ok(match format {
            Format::Parquet => Self::Parquet(Box::new(ParquetFile::new(target, table)?)),
            Format::Csv => {
                target.write_all(&text::csv_header(table))?;
                Self::Text(target)
            }
            Format::Json => Self::Text(target),
        })
    }

    pub fn write(&mut self, rows: Encoded) -> io::Result<()> {
        match (self, rows) {
            (Self::Text(target), Encoded::Text(text)) => target.write_all(&text),
            (Self::Parquet(file), Encoded::Rows(rows)) => file.write(rows),
            _ => Err(io::Error::other("rows of another format than the table's")),
        }
    }

    /// Ends the table; it is not yet in its place.
    pub fn finish(self) -> io::Result<Target> {
        let mut target = match self {
            Self::Text(target) => target,
            Self::Parquet(file) => file.finish()?,
        };
        target.flush().map(|()| target)
    }
}
