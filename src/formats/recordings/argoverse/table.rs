//! Columns of a Parquet file of Argoverse 2: the rows of all tracks.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::File;
use std::path::Path;

use parquet::basic::Type as PhysicalType;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type,
};
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::pages;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::Report;
use nearmiss_base::system;
use nearmiss_scene::scenario::plausibility::limits::MOST_PARTS;

/// The columns that tell a motion forecasting scenario.
const TELLING: [&str; 5] = [
    "track_id",
    "object_type",
    "timestep",
    "position_x",
    "position_y",
];

/// No column of a file of seconds is larger when unpacked, bytes.
const LARGEST_COLUMN: i64 = 64 << 20;

/// Appends the values of a column in a row group with so many rows.
type ReadColumn<'f, T> = dyn FnMut(ColumnReader, usize, &mut Vec<T>) -> Result<(), String> + 'f;

/// A Parquet file.
pub struct Table<'r> {
    file: SerializedFileReader<File>,
    bytes: &'r [u8],
    report: &'r Report,
    /// The columns that were asked for.
    asked: RefCell<BTreeSet<String>>,
}

/// Whether a file that begins with `head` is a scenario of Argoverse 2, or a damaged table that may have been one.
pub fn is_one(path: &Path, head: &[u8]) -> bool {
    match opened(path, head) {
        Some(Ok(columns)) => TELLING.iter().all(|name| columns.iter().any(|c| c == name)),
        Some(Err(_)) => true,
        None => false,
    }
}

/// The columns of a Parquet file that begins with `head`; nothing of any other or a damaged file.
pub fn columns(path: &Path, head: &[u8]) -> Option<Vec<String>> {
    opened(path, head)?.ok()
}

/// The columns of a Parquet file, or that it is damaged; nothing of any other file.
fn opened(path: &Path, head: &[u8]) -> Option<parquet::errors::Result<Vec<String>>> {
    if !head.starts_with(b"PAR1") {
        return None;
    }
    let file = SerializedFileReader::new(system::open_file(path).ok()?);
    Some(file.map(|file| names(&file)))
}

fn names(file: &SerializedFileReader<File>) -> Vec<String> {
    let schema = file.metadata().file_metadata().schema_descr();
    schema
        .columns()
        .iter()
        .map(|c| c.name().to_string())
        .collect()
}

impl<'r> Table<'r> {
    /// Opens a file, which has these bytes.
    pub fn open(path: &Path, bytes: &'r [u8], report: &'r Report) -> Result<Self, ReadError> {
        let file = system::open_file(path).map_err(|error| ReadError::io(report.file(), &error))?;
        let file = SerializedFileReader::new(file)
            .map_err(|e| report.fail(format!("not a whole Parquet file ({e})")))?;
        let table = Self {
            file,
            bytes,
            report,
            asked: RefCell::default(),
        };
        let rows = table.rows();
        if usize::try_from(rows).is_ok_and(|rows| rows <= MOST_PARTS) {
            return Ok(table);
        }
        Err(report.fail(format!("{rows} rows; at most {MOST_PARTS} are read")))
    }

    /// Tells of the columns that were not asked for.
    pub fn tell_unused(&self) {
        let asked = self.asked.borrow();
        let rows = usize::try_from(self.rows()).unwrap_or(0);
        for name in names(&self.file)
            .iter()
            .filter(|name| !asked.contains(*name))
        {
            self.report.unused_times(format!("column {name}"), rows, 0);
        }
    }

    pub fn rows(&self) -> i64 {
        let groups = self.file.metadata().row_groups().iter();
        groups.map(|g| g.num_rows()).fold(0, i64::saturating_add)
    }

    /// A column of numbers, whole or not; nothing where it is not there.
    pub fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, ReadError> {
        let found = self.column(name, RowSelection::All, &mut append_numbers);
        found.map_err(|what| self.fail(name, &what))
    }

    /// A column of numbers that must be there.
    pub fn needed_numbers(&self, name: &str) -> Result<Vec<f64>, ReadError> {
        let found = self.numbers(name)?;
        found.ok_or_else(|| self.report.fail(format!("the column `{name}` is missing")))
    }

    /// The number in the first row of a column; nothing where it is not there.
    pub fn first_number(&self, name: &str) -> Result<Option<f64>, ReadError> {
        let found = self
            .column(name, RowSelection::First, &mut append_numbers)
            .map_err(|what| self.fail(name, &what))?;
        Ok(found.and_then(|values| values.first().copied()))
    }

    /// The text in the first row of a column; nothing where it is not there.
    pub fn first_text(&self, name: &str) -> Result<Option<String>, ReadError> {
        let found = self
            .column(name, RowSelection::First, &mut append_texts)
            .map_err(|what| self.fail(name, &what))?;
        Ok(found.and_then(|texts| Some(texts.first()?.as_str().to_string())))
    }

    /// A column of texts that must be there.
    pub fn needed_texts(&self, name: &str) -> Result<Vec<Text>, ReadError> {
        let found = self
            .column(name, RowSelection::All, &mut append_texts)
            .map_err(|what| self.fail(name, &what))?;
        found.ok_or_else(|| self.report.fail(format!("the column `{name}` is missing")))
    }

    fn fail(&self, column: &str, what: &str) -> ReadError {
        self.report.at(format!("column {column}")).fail(what)
    }

    /// Checks the pages of a column in a row group.
    fn check(&self, start: i64, length: i64) -> Result<(), String> {
        let start = usize::try_from(start).ok();
        let end = start
            .zip(usize::try_from(length).ok())
            .and_then(|(start, length)| start.checked_add(length));
        let column = start.zip(end).and_then(|(a, b)| self.bytes.get(a..b));
        pages::check(column.ok_or("it reaches beyond the file")?, MOST_PARTS)
    }

    fn column<T>(
        &self,
        name: &str,
        wanted: RowSelection,
        read: &mut ReadColumn<'_, T>,
    ) -> Result<Option<Vec<T>>, String> {
        self.asked.borrow_mut().insert(name.to_string());
        let schema = self.file.metadata().file_metadata().schema_descr();
        let Some(place) = schema.columns().iter().position(|c| c.name() == name) else {
            return Ok(None);
        };
        let described = schema.column(place);
        if described.max_rep_level() > 0 {
            return Err("a list in each row; expected one value".into());
        }
        if described.physical_type() == PhysicalType::INT96 {
            return Err("values of 96 bits; expected numbers".into());
        }
        let mut into = Vec::new();
        for group in 0..self.file.metadata().num_row_groups() {
            let about = self.file.metadata().row_group(group);
            let rows = usize::try_from(about.num_rows()).map_err(|_| "less than no rows")?;
            let rows = match wanted {
                RowSelection::All => rows,
                RowSelection::First if into.is_empty() => rows.min(1),
                RowSelection::First => break,
            };
            if about.column(place).uncompressed_size() > LARGEST_COLUMN {
                return Err(format!("more than {} MiB", LARGEST_COLUMN >> 20));
            }
            let start = about
                .column(place)
                .dictionary_page_offset()
                .unwrap_or_else(|| about.column(place).data_page_offset());
            self.check(start, about.column(place).compressed_size())?;
            let before = into.len();
            // The crate asserts that what is in the pages is sound.
            let done = system::crash::contained(|| {
                let group = self.file.get_row_group(group).map_err(|e| e.to_string())?;
                let reader = group.get_column_reader(place).map_err(|e| e.to_string())?;
                read(reader, rows, &mut into)
            });
            done.unwrap_or_else(|| Err("its values are damaged".into()))?;
            match into.len() - before {
                found if found == rows => {}
                found => {
                    return Err(format!(
                        "{} of {rows} rows have no value",
                        rows - found.min(rows)
                    ));
                }
            }
        }
        Ok(Some(into))
    }
}

/// Which rows of a column.
#[derive(Clone, Copy)]
enum RowSelection {
    All,
    First,
}

/// A text of a row; rows with the same text share its bytes.
pub struct Text(ByteArray);

impl Text {
    pub fn as_str(&self) -> &str {
        // Checked where it was read.
        self.0.as_utf8().unwrap_or_default()
    }

    /// Whether both are the same bytes in memory, which tells without looking at them that they are equal.
    pub fn is_same(&self, other: &Self) -> bool {
        self.shares(&other.0)
    }

    fn shares(&self, bytes: &ByteArray) -> bool {
        std::ptr::eq(self.0.data(), bytes.data())
    }
}

fn append_texts(reader: ColumnReader, rows: usize, into: &mut Vec<Text>) -> Result<(), String> {
    let ColumnReader::ByteArrayColumnReader(reader) = reader else {
        return Err("no texts in it".into());
    };
    let found = values::<ByteArrayType>(reader, rows)?;
    into.reserve(found.len());
    for value in found {
        // Rows of one track follow each other, and share the bytes of a dictionary.
        let checked = into.last().is_some_and(|last| last.shares(&value));
        if !checked {
            value.as_utf8().map_err(|_| "not UTF-8 text")?;
        }
        into.push(Text(value));
    }
    Ok(())
}

fn append_numbers(reader: ColumnReader, rows: usize, into: &mut Vec<f64>) -> Result<(), String> {
    match reader {
        ColumnReader::DoubleColumnReader(r) if into.is_empty() => {
            *into = values::<DoubleType>(r, rows)?;
        }
        ColumnReader::DoubleColumnReader(r) => into.extend(values::<DoubleType>(r, rows)?),
        ColumnReader::FloatColumnReader(r) => {
            into.extend(values::<FloatType>(r, rows)?.into_iter().map(f64::from));
        }
        ColumnReader::Int64ColumnReader(r) => {
            into.extend(values::<Int64Type>(r, rows)?.into_iter().map(|v| v as f64));
        }
        ColumnReader::Int32ColumnReader(r) => {
            into.extend(values::<Int32Type>(r, rows)?.into_iter().map(f64::from));
        }
        ColumnReader::BoolColumnReader(r) => {
            let bools = values::<BoolType>(r, rows)?.into_iter();
            into.extend(bools.map(|b| f64::from(u8::from(b))));
        }
        _ => return Err("no numbers in it".into()),
    }
    Ok(())
}

/// The values of a column in a row group; rows without one are passed over.
fn values<T: DataType>(mut reader: ColumnReaderImpl<T>, rows: usize) -> Result<Vec<T::T>, String> {
    let room = rows.min(MOST_PARTS);
    let (mut values, mut levels) = (Vec::with_capacity(room), Vec::with_capacity(room));
    let mut done = 0;
    while done < rows {
        levels.clear();
        let read = reader.read_records(rows - done, Some(&mut levels), None, &mut values);
        let (records, ..) = read.map_err(|e| e.to_string())?;
        if records == 0 {
            break;
        }
        done += records;
    }
    Ok(values)
}
