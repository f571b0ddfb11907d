//! Columns of a Parquet file of Argoverse 2, whose pages are checked before they are unpacked: the rows of all tracks.
//!
//! Headers are structs of Thrift's compact protocol, as the format of Parquet describes them.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::File;
use std::path::Path;

use nearmiss_base::system;
use nearmiss_scene::scenario::plausibility::MOST_PARTS;
use parquet::basic::Type as PhysicalType;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type,
};
use parquet::file::reader::{FileReader, SerializedFileReader};

use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;

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
        let file = SerializedFileReader::new(file).map_err(|e| {
            report.fail(format!(
                "the file is damaged: not a whole Parquet file ({e})"
            ))
        })?;
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
        check_pages(column.ok_or("it reaches beyond the file")?, MOST_PARTS)
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

/// No page of a scenario of seconds is larger when unpacked, bytes.
const LARGEST_PAGE: i64 = 64 << 20;

/// Encodings whose values are counted in the header and not once more in the data: plain, dictionaries, runs, and
/// streams of bytes.
const ENCODINGS: [i64; 6] = [0, 2, 3, 4, 8, 9];

/// Those of them whose values are places in a dictionary; of the dictionary itself one says the same.
const BY_DICTIONARY: [i64; 2] = [2, 8];

/// Kinds of pages: data, a dictionary, and data in the second version of the format.
const DATA: i64 = 0;

const DICTIONARY: i64 = 2;

const DATA_2: i64 = 3;

/// Structs and lists in each other.
const MAX_DEPTH: usize = 16;

/// Checks the pages of a column; a page has at most `most` values.
///
/// # Errors
/// What is wrong with one of them.
fn check_pages(column: &[u8], most: usize) -> Result<(), String> {
    let mut thrift = Thrift {
        bytes: column,
        at: 0,
    };
    let mut place = 0;
    let mut has_dictionary = false;
    while thrift.at < column.len() {
        place += 1;
        let damaged = || format!("the header of page {place} is damaged");
        let header = thrift.header().ok_or_else(damaged)?;
        let packed = usize::try_from(header.packed).map_err(|_| damaged())?;
        let end = thrift
            .at
            .checked_add(packed)
            .filter(|end| *end <= column.len());
        thrift.at = end.ok_or_else(|| {
            format!("page {place} has {packed} bytes, which reach beyond its column")
        })?;
        if !(0..=LARGEST_PAGE).contains(&header.unpacked) {
            let size = header.unpacked;
            let most = LARGEST_PAGE >> 20;
            return Err(format!(
                "page {place} is to have {size} bytes unpacked; at most {most} MiB are read"
            ));
        }
        if !usize::try_from(header.values).is_ok_and(|values| values <= most) {
            let values = header.values;
            return Err(format!(
                "page {place} is to have {values} values; at most {most} are read"
            ));
        }
        if !ENCODINGS.contains(&header.encoding) {
            return Err(format!(
                "page {place} has encoding {}; plain values and dictionaries are read",
                header.encoding
            ));
        }
        // Others are taken for what they are not.
        match (header.kind, header.of) {
            (DICTIONARY, 7) if place == 1 => has_dictionary = true,
            (DATA, 5) | (DATA_2, 8) => {}
            _ => return Err(format!("page {place} is no page of data")),
        }
        if BY_DICTIONARY.contains(&header.encoding) && !has_dictionary {
            return Err(format!(
                "page {place} needs a dictionary, and there is none"
            ));
        }
    }
    Ok(())
}

/// What the header of a page says.
#[derive(Default)]
struct Header {
    kind: i64,
    /// The field with what there is to say about its kind.
    of: i64,
    unpacked: i64,
    packed: i64,
    values: i64,
    encoding: i64,
}

/// Structs of the compact protocol, one after the other.
struct Thrift<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl Thrift<'_> {
    fn header(&mut self) -> Option<Header> {
        let mut header = Header::default();
        self.fields(0, &mut |path, value| match path {
            (0, 1) => header.kind = value,
            (0, 2) => header.unpacked = value,
            (0, 3) => header.packed = value,
            // Pages of data, of the dictionary, and of data in the second version.
            (of @ (5 | 7 | 8), 1) => (header.of, header.values) = (of, value),
            (5 | 7, 2) | (8, 4) => header.encoding = value,
            _ => {}
        })?;
        Some(header)
    }

    /// Goes through a struct and gives its numbers, and those of the structs in it, each with the field of the outer
    /// struct (0 in the outermost) and its own.
    fn fields(&mut self, outer: i64, take: &mut dyn FnMut((i64, i64), i64)) -> Option<()> {
        let mut id = 0;
        loop {
            let byte = self.byte()?;
            if byte == 0 {
                return Some(());
            }
            id = match byte >> 4 {
                0 => self.number()?,
                more => id + i64::from(more),
            };
            match byte & 0xf {
                4..=6 => take((outer, id), self.number()?),
                12 if outer == 0 => self.fields(id, take)?,
                kind => self.skip(kind, MAX_DEPTH)?,
            }
        }
    }

    fn skip(&mut self, kind: u8, deeper: usize) -> Option<()> {
        let deeper = deeper.checked_sub(1)?;
        match kind {
            // The value of a boolean is its type.
            1 | 2 => Some(()),
            3 => self.pass(1),
            4..=6 => self.varint().map(|_| ()),
            7 => self.pass(8),
            8 => {
                let length = usize::try_from(self.varint()?).ok()?;
                self.pass(length)
            }
            9 | 10 => {
                let byte = self.byte()?;
                let count = match byte >> 4 {
                    15 => self.varint()?,
                    few => u64::from(few),
                };
                for _ in 0..count {
                    match byte & 0xf {
                        1 | 2 => self.pass(1)?,
                        kind => self.skip(kind, deeper)?,
                    }
                }
                Some(())
            }
            12 => loop {
                let byte = self.byte()?;
                if byte == 0 {
                    return Some(());
                }
                if byte >> 4 == 0 {
                    self.varint()?;
                }
                self.skip(byte & 0xf, deeper)?;
            },
            // Headers have no maps.
            _ => None,
        }
    }

    fn pass(&mut self, bytes: usize) -> Option<()> {
        let end = self.at.checked_add(bytes)?;
        self.at = (end <= self.bytes.len()).then_some(end)?;
        Some(())
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// Signs are in the lowest bit.
    fn number(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A page of data: its header and so many bytes.
    fn page(unpacked: &[u8], values: u8, encoding: u8, bytes: usize) -> Vec<u8> {
        let mut page = vec![0x15, 0x00, 0x15];
        page.extend(unpacked);
        page.extend([0x15, bytes as u8 * 2, 0x2c, 0x15, values, 0x15, encoding]);
        // Levels, statistics with a text, and the ends of both structs.
        page.extend([
            0x15, 0x06, 0x15, 0x06, 0x1c, 0x18, 0x02, b'a', b'b', 0x00, 0x00, 0x00,
        ]);
        page.extend(std::iter::repeat_n(7, bytes));
        page
    }

    #[test]
    fn pages_promise_what_can_be_kept() {
        let good = page(&[40], 20, 0, 16);
        assert_eq!(
            check_pages(&[good.clone(), good.clone()].concat(), 10),
            Ok(())
        );
        let error = |column: &[u8], most| check_pages(column, most).unwrap_err();
        // i32::MAX.
        let large = page(&[0xfe, 0xff, 0xff, 0xff, 0x0f], 20, 0, 16);
        let said = error(&[good.clone(), large].concat(), 10);
        assert!(
            said.contains("page 2 is to have 2147483647 bytes"),
            "{said}"
        );
        assert!(error(&good, 9).contains("10 values; at most 9"));
        assert!(error(&page(&[40], 20, 10, 16), 10).contains("encoding 5"));
        assert!(error(&good[..30], 10).contains("reach beyond"));
        assert!(error(&good[..9], 10).contains("is damaged"));
        // Values by a dictionary come after it.
        assert!(error(&page(&[40], 20, 16, 16), 10).contains("page 1 needs a dictionary"));
        let dictionary = [
            &[0x15, 4, 0x15, 8, 0x15, 8, 0x4c, 0x15, 4, 0x15, 0, 0, 0][..],
            &[7; 4],
        ]
        .concat();
        let both = [dictionary.clone(), page(&[40], 20, 16, 16)].concat();
        assert_eq!(check_pages(&both, 10), Ok(()));
        assert!(
            error(&[good.clone(), dictionary].concat(), 10).contains("page 2 is no page of data")
        );
        // Lists in lists.
        let deep: Vec<u8> = [0x19].into_iter().chain([0x19; 100]).collect();
        assert!(error(&deep, 10).contains("is damaged"));
    }
}
