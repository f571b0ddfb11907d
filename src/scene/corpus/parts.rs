//! Reads columns of an index: Parquet parts in folders `shard=…`, row by row, in bounded memory.

use std::fs::File;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use parquet::basic::Type as PhysicalType;
use parquet::column::reader::ColumnReader;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};

use super::events::ScenarioDriven;
use crate::metrics::SEVERITY_NAMES;
use nearmiss_base::system;

/// Why an index cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum IndexError {
    /// A file or folder cannot be read.
    #[error("{}: {why}", path.display())]
    Io {
        /// Which one.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// A folder without parts.
    #[error("{}: no index here (shard=…/part-….parquet); `nearmiss corpus index PATH… -o FOLDER` makes one", .0.display())]
    NoIndex(PathBuf),
    /// `nearmiss corpus index` has it open.
    #[error("{}: this index is still being written; read it when `nearmiss corpus index` has ended", .0.display())]
    BeingWritten(PathBuf),
    /// A part that is no whole Parquet file.
    #[error("{}: not a whole Parquet file ({why}); remove it, and write it again with `nearmiss corpus index PATH… -o FOLDER --resume`", part.display())]
    Damaged {
        /// The part.
        part: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// A Parquet file of something else.
    #[error("{}: not a part of an index: {why}; `nearmiss corpus index PATH… -o FOLDER` makes one", part.display())]
    Foreign {
        /// The file.
        part: PathBuf,
        /// What is missing or wrong.
        why: String,
    },
    /// A part that another version wrote.
    #[error("{}: written by nearmiss {version}, but this is nearmiss {}; run `nearmiss corpus index` again with --overwrite", part.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The part.
        part: PathBuf,
        /// That version.
        version: String,
    },
    /// A part whose severities are others: risk scores, as before there were grades.
    #[error("{}: its severities are of another scale than {}; run `nearmiss corpus index` again with --overwrite", .0.display(), SEVERITY_NAMES.join(", "))]
    OtherSeverities(PathBuf),
    /// A part without what its egos met and how far they drove, as before these were measured.
    #[error("{}: it has no events and no hours driven; run `nearmiss corpus index` again with --overwrite", .0.display())]
    NoEvents(PathBuf),
}

/// The parts of an index in a folder, in order.
///
/// # Errors
/// The folder cannot be read, or has no parts.
pub fn part_files(folder: &Path) -> Result<Vec<PathBuf>, IndexError> {
    let listed = |folder: &Path| -> Result<Vec<PathBuf>, IndexError> {
        let failed = |e: &std::io::Error| IndexError::Io {
            path: folder.to_path_buf(),
            why: system::error_text(e),
        };
        let entries = std::fs::read_dir(folder).map_err(|e| failed(&e))?;
        let mut paths = Vec::new();
        for entry in entries {
            paths.push(entry.map_err(|e| failed(&e))?.path());
        }
        paths.sort();
        Ok(paths)
    };
    let is_partition = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("shard=") && path.is_dir()
    };
    let mut found = Vec::new();
    for partition in listed(folder)?.into_iter().filter(is_partition) {
        let files = listed(&partition)?.into_iter();
        found.extend(files.filter(|file| file.extension().is_some_and(|x| x == "parquet")));
    }
    if found.is_empty() {
        Err(IndexError::NoIndex(folder.to_path_buf()))
    } else {
        Ok(found)
    }
}

/// An opened part of an index.
pub struct Part {
    path: PathBuf,
    reader: SerializedFileReader<File>,
}

/// The columns that are read, by name.
#[derive(Debug, Clone, Copy, Default)]
pub struct Columns<'a> {
    /// Texts.
    pub texts: &'a [&'a str],
    /// Integers.
    pub integers: &'a [&'a str],
    /// Numbers, which rows may lack: measures.
    pub numbers: &'a [&'a str],
}

impl<'a> Columns<'a> {
    /// Columns that every row has.
    #[must_use]
    pub fn new(texts: &'a [&'a str], integers: &'a [&'a str]) -> Self {
        Self {
            texts,
            integers,
            numbers: &[],
        }
    }
}

/// A row of a part: the wanted columns, in the order in which they were asked for.
pub struct PartRow<'a> {
    path: &'a Path,
    at: usize,
    texts: &'a [Vec<ByteArray>],
    integers: &'a [Vec<i64>],
    numbers: &'a [Vec<Option<f64>>],
}

impl PartRow<'_> {
    /// A text.
    ///
    /// # Errors
    /// It is not UTF-8.
    pub fn text(&self, column: usize) -> Result<&str, IndexError> {
        let text = self.texts[column][self.at].as_utf8();
        text.map_err(|e| damaged(self.path, &e))
    }

    /// An integer.
    #[must_use]
    pub fn integer(&self, column: usize) -> i64 {
        self.integers[column][self.at]
    }

    /// A number, where the row has it.
    #[must_use]
    pub fn number(&self, column: usize) -> Option<f64> {
        self.numbers[column][self.at]
    }

    /// A severity.
    ///
    /// # Errors
    /// It is none.
    pub fn severity(&self, column: usize) -> Result<u8, IndexError> {
        let number = self.integer(column);
        let severity = u8::try_from(number)
            .ok()
            .filter(|one| usize::from(*one) < SEVERITY_NAMES.len());
        severity.ok_or_else(|| self.foreign(format!("severity {number} is not 0 to 5")))
    }

    /// The error for a value of this row that no index has.
    #[must_use]
    pub fn foreign(&self, why: String) -> IndexError {
        foreign(self.path, why)
    }
}

/// Rows that are in memory at once.
const BLOCK: usize = 4096;

/// The key of the version in the metadata of a part.
const VERSION: &str = "nearmiss.version";

/// The key of how far it looked.
const RADIUS: &str = "nearmiss.radius";

/// The key of what its egos met.
const DRIVEN: &str = "nearmiss.driven";

/// The key of the names of its severities.
const SEVERITIES: &str = "nearmiss.severities";

impl Part {
    /// Opens a part.
    ///
    /// # Errors
    /// It is no whole Parquet file, no part of an index, or another version wrote it or with other severities.
    pub fn open(path: &Path) -> Result<Self, IndexError> {
        let io = |e: &std::io::Error| IndexError::Io {
            path: path.to_path_buf(),
            why: system::error_text(e),
        };
        system::check_file(path).map_err(|e| io(&e))?;
        let file = File::open(path).map_err(|e| io(&e))?;
        let reader = SerializedFileReader::new(file).map_err(|e| damaged(path, &e))?;
        let known = |key: &str| known(&reader, key);
        match known(VERSION) {
            Some(version) if version == env!("CARGO_PKG_VERSION") => {
                if known(SEVERITIES).is_some_and(|names| names == SEVERITY_NAMES.join(",")) {
                    Ok(Self {
                        path: path.to_path_buf(),
                        reader,
                    })
                } else {
                    Err(IndexError::OtherSeverities(path.to_path_buf()))
                }
            }
            Some(version) => Err(IndexError::OtherVersion {
                part: path.to_path_buf(),
                version: visible(&version),
            }),
            None => Err(foreign(path, "nearmiss did not write it".into())),
        }
    }

    /// How many rows it has.
    #[must_use]
    pub fn rows(&self) -> u64 {
        let rows = self.reader.metadata().file_metadata().num_rows();
        u64::try_from(rows).unwrap_or(0)
    }

    /// Pairs farther apart were not looked at, metres.
    #[must_use]
    pub fn radius(&self) -> Option<f64> {
        known(&self.reader, RADIUS)?.parse().ok()
    }

    /// What the egos of its scenarios met, and how far they drove.
    ///
    /// # Errors
    /// It does not say so, or not as this version does.
    pub fn driven(&self) -> Result<Vec<ScenarioDriven>, IndexError> {
        let text =
            known(&self.reader, DRIVEN).ok_or_else(|| IndexError::NoEvents(self.path.clone()))?;
        serde_json::from_str(&text).map_err(|e| foreign(&self.path, visible(&e.to_string())))
    }

    /// Hands out these columns row by row, until `each` breaks off.
    ///
    /// # Errors
    /// A column is missing or of another type, the part is damaged, or `each` fails.
    pub fn read(
        &self,
        wanted: &Columns<'_>,
        each: &mut dyn FnMut(&PartRow<'_>) -> Result<ControlFlow<()>, IndexError>,
    ) -> Result<ControlFlow<()>, IndexError> {
        let of_texts = self.places(wanted.texts, PhysicalType::BYTE_ARRAY, false)?;
        let of_integers = self.places(wanted.integers, PhysicalType::INT64, false)?;
        let of_numbers = self.places(wanted.numbers, PhysicalType::DOUBLE, true)?;
        let wrong = |e: ParquetError| damaged(&self.path, &e);
        for group in 0..self.reader.num_row_groups() {
            let group = self.reader.get_row_group(group).map_err(wrong)?;
            let mut text_columns = columns(group.as_ref(), &of_texts).map_err(wrong)?;
            let mut integer_columns = columns(group.as_ref(), &of_integers).map_err(wrong)?;
            let mut number_columns = columns(group.as_ref(), &of_numbers).map_err(wrong)?;
            loop {
                let mut block = (Vec::new(), Vec::new(), Vec::new());
                for column in &mut text_columns {
                    let mut values = Vec::new();
                    if let ColumnReader::ByteArrayColumnReader(column) = column {
                        let read = column.read_records(BLOCK, None, None, &mut values);
                        read.map_err(wrong)?;
                    }
                    block.0.push(values);
                }
                for column in &mut integer_columns {
                    let mut values = Vec::new();
                    if let ColumnReader::Int64ColumnReader(column) = column {
                        let read = column.read_records(BLOCK, None, None, &mut values);
                        read.map_err(wrong)?;
                    }
                    block.1.push(values);
                }
                for column in &mut number_columns {
                    block.2.push(numbers(column).map_err(wrong)?);
                }
                let (texts, integers) = (&block.0[..], &block.1[..]);
                let mut lengths = texts
                    .iter()
                    .map(Vec::len)
                    .chain(integers.iter().map(Vec::len))
                    .chain(block.2.iter().map(Vec::len));
                let length = lengths.next().unwrap_or(0);
                if lengths.any(|other| other != length) {
                    let why = ParquetError::General("its columns have different lengths".into());
                    return Err(damaged(&self.path, &why));
                }
                if length == 0 {
                    break;
                }
                for at in 0..length {
                    let row = PartRow {
                        path: &self.path,
                        at,
                        texts,
                        integers,
                        numbers: &block.2,
                    };
                    if each(&row)?.is_break() {
                        return Ok(ControlFlow::Break(()));
                    }
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// The columns of numbers that rows may lack: measures.
    #[must_use]
    pub fn measures(&self) -> Vec<String> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let columns = schema.columns().iter();
        let optional = columns.filter(|c| c.max_def_level() == 1 && c.max_rep_level() == 0);
        let numbers = optional.filter(|c| c.physical_type() == PhysicalType::DOUBLE);
        numbers.map(|c| visible(c.name())).collect()
    }

    /// The places of columns that have a value in every row, or that may lack it.
    fn places(
        &self,
        names: &[&str],
        kind: PhysicalType,
        optional: bool,
    ) -> Result<Vec<usize>, IndexError> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let place = |name: &&str| {
            let mut columns = schema.columns().iter();
            let place = columns
                .position(|column| column.path().parts() == [name.to_string()])
                .ok_or_else(|| foreign(&self.path, format!("it has no column {name}")))?;
            let column = schema.column(place);
            let plain =
                column.max_def_level() == i16::from(optional) && column.max_rep_level() == 0;
            if plain && column.physical_type() == kind {
                Ok(place)
            } else {
                Err(foreign(
                    &self.path,
                    format!("its column {name} has another type"),
                ))
            }
        };
        names.iter().map(place).collect()
    }
}

/// What a part says of itself.
fn known(reader: &SerializedFileReader<File>, key: &str) -> Option<String> {
    let metadata = reader.metadata().file_metadata().key_value_metadata();
    let mut entries = metadata.into_iter().flatten();
    entries.find(|entry| entry.key == key)?.value.clone()
}

fn columns(
    group: &dyn RowGroupReader,
    places: &[usize],
) -> Result<Vec<ColumnReader>, ParquetError> {
    let columns = places.iter().map(|place| group.get_column_reader(*place));
    columns.collect()
}

/// The next numbers of a column, and which rows have none.
fn numbers(column: &mut ColumnReader) -> Result<Vec<Option<f64>>, ParquetError> {
    let ColumnReader::DoubleColumnReader(column) = column else {
        return Ok(Vec::new());
    };
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    column.read_records(BLOCK, Some(&mut levels), None, &mut values)?;
    let mut values = values.into_iter();
    let there = levels.into_iter().map(|level| match level {
        0 => None,
        _ => values.next(),
    });
    Ok(there.collect())
}

fn damaged(part: &Path, why: &ParquetError) -> IndexError {
    IndexError::Damaged {
        part: part.to_path_buf(),
        why: visible(&why.to_string()),
    }
}

fn foreign(part: &Path, why: String) -> IndexError {
    IndexError::Foreign {
        part: part.to_path_buf(),
        why,
    }
}

/// What a file says, without control characters.
fn visible(text: &str) -> String {
    let clean = text.chars().filter(|c| !c.is_control());
    clean.take(200).collect()
}
