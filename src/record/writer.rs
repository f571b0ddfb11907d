//! Writes a table piece by piece, in any of the formats.

use std::io::{self, Write};

use strum::{IntoStaticStr, VariantArray};

use crate::parquet::ParquetFile;
use crate::table::{Row, Table};
use crate::text;

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
