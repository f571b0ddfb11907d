//! The output of a table: standard output or an atomically written file, and its format.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::columnar::Columnar;
use super::table::{Sheet, Table};
use super::text;
use crate::cli::Failure;
use crate::cli::output::Lines;
use crate::formats::commonroad::{NewFile, SaveError};

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Comma-separated, with a header.
    Csv,
    /// One JSON object a line.
    Json,
    /// Apache Parquet, with units and sources as metadata; into a file only.
    Parquet,
}

/// The rows of one scenario, as far as they can be written without the others.
pub enum Encoded {
    Text(Vec<u8>),
    Sheet(Sheet),
}

impl Format {
    /// The format that a file's name asks for.
    pub fn of_name(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "csv" => Some(Self::Csv),
            "json" | "jsonl" | "ndjson" => Some(Self::Json),
            "parquet" => Some(Self::Parquet),
            _ => None,
        }
    }

    /// The format that was asked for, or that the file's name asks for; both must agree.
    pub fn chosen(asked: Option<Self>, file: Option<&Path>) -> Result<Self, Failure> {
        let of_name = file.and_then(Self::of_name);
        match (asked, of_name, file) {
            (None, None, Some(file)) if !file.is_dir() => {
                Err(no_format(file, ".csv, .json, .jsonl, .ndjson and .parquet"))
            }
            (Some(asked), Some(named), Some(file)) if asked != named => {
                Err(Failure::input(format!(
                    "--format {} does not go with the name {}, which is that of {}; leave --format out or name \
                     another file",
                    asked.word(),
                    file.display(),
                    named.word()
                )))
            }
            _ => Ok(asked.or(of_name).unwrap_or(Self::Csv)),
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Json => "json",
            Self::Parquet => "parquet",
        }
    }

    pub fn encode(self, table: &Table, sheet: Sheet) -> Encoded {
        match self {
            Self::Csv => Encoded::Text(text::csv(table, &sheet)),
            Self::Json => Encoded::Text(text::json(table, &sheet)),
            Self::Parquet => Encoded::Sheet(sheet),
        }
    }
}

/// The file that `-o` names; `-` is standard output.
pub fn file_of(output: Option<&Path>) -> Option<&Path> {
    output.filter(|path| *path != Path::new("-"))
}

/// A name that does not say how the file is to be written.
pub fn no_format(file: &Path, known: &str) -> Failure {
    Failure::input(format!(
        "{}: the ending does not say how to write it; the known ones are {known}, and --format says it for any name",
        file.display()
    ))
}

/// Destination of bytes.
pub enum Target {
    Stdout(Lines),
    File(BufWriter<NewFile>),
}

impl Target {
    pub fn begin(path: Option<&Path>, overwrite: bool) -> Result<Self, Failure> {
        let Some(path) = path else {
            return Ok(Self::Stdout(Lines::default()));
        };
        if path.is_dir() {
            return Err(Failure::input(format!(
                "{}: this is a folder; name a file in it",
                path.display()
            )));
        }
        match NewFile::begin(path, overwrite) {
            Ok(file) => Ok(Self::File(BufWriter::new(file))),
            Err(error @ SaveError::Exists(_)) => {
                Err(Failure::input(format!("{error} (--overwrite)")))
            }
            Err(error) => Err(Failure::input(error)),
        }
    }

    /// Puts a file that is flushed in its place.
    pub fn finish(self) -> Result<(), Failure> {
        match self {
            Self::Stdout(_) => Ok(()),
            Self::File(out) => match out.into_inner() {
                Ok(file) => file.finish().map_err(Failure::input),
                Err(error) => Err(Failure::system("the table", &error.into_error())),
            },
        }
    }
}

impl Write for Target {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Stdout(out) => out.write(bytes),
            Self::File(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Stdout(out) => out.flush(),
            Self::File(out) => out.flush(),
        }
    }
}

/// A table in the making.
pub enum TableWriter {
    Text(Target),
    Columnar(Box<Columnar<Target>>),
}

impl TableWriter {
    /// Begins the table with its header.
    pub fn begin(mut target: Target, format: Format, table: &Table) -> io::Result<Self> {
        Ok(match format {
            Format::Parquet => Self::Columnar(Box::new(Columnar::new(target, table)?)),
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
            (Self::Columnar(file), Encoded::Sheet(sheet)) => file.write(sheet),
            _ => Err(io::Error::other("rows of another format than the table's")),
        }
    }

    /// Ends the table; it is not yet in its place.
    pub fn finish(self) -> io::Result<Target> {
        let mut target = match self {
            Self::Text(target) => target,
            Self::Columnar(file) => file.finish()?,
        };
        target.flush().map(|()| target)
    }
}
