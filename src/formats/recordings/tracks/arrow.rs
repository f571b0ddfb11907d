//! Rows of tables in columns: Parquet and Arrow IPC, files and streams.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_cast::{CastOptions, cast_with_options};
use arrow_schema::{DataType, Field, TimeUnit};
use nearmiss_base::system;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};

use super::batch::{Batch, Values, Wanted};
use super::text::{BadCell, unread};

/// Rows that are taken at once.
const ROWS: usize = 1 << 16;

/// A row group of a file of tracks is never larger when unpacked, bytes.
const LARGEST_GROUP: i64 = 2 << 30;

/// How Parquet begins.
pub const PARQUET: &[u8] = b"PAR1";

/// A file in columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Parquet.
    Parquet,
    /// A file of Arrow IPC (Feather).
    ArrowFile,
    /// A stream of Arrow IPC.
    ArrowStream,
}

impl Form {
    /// What a file is that begins so.
    pub fn detect(head: &[u8]) -> Option<Self> {
        if head.starts_with(PARQUET) {
            return Some(Self::Parquet);
        }
        if head.starts_with(b"ARROW1") {
            return Some(Self::ArrowFile);
        }
        head.starts_with(&[0xff; 4]).then_some(Self::ArrowStream)
    }

    /// Why the columns of a file that begins so cannot be read; nothing where they can, and of what may be no table.
    pub fn damage(head: &[u8], path: &Path) -> Option<String> {
        let form = Self::detect(head).filter(|form| *form != Self::ArrowStream)?;
        form.names(path).err()
    }

    /// The names of the columns, those of structs as `position.x`.
    ///
    /// # Errors
    /// The file is damaged.
    pub fn names(self, path: &Path) -> Result<Vec<String>, String> {
        let schema = guarded(|| match self {
            Self::Parquet => Ok(Arc::clone(parquet(path)?.schema())),
            Self::ArrowFile => Ok(arrow_file(path)?.schema()),
            Self::ArrowStream => Ok(arrow_stream(path)?.schema()),
        })?;
        let mut names = Vec::new();
        for field in schema.fields() {
            flatten(field, "", &mut names);
        }
        Ok(names)
    }

    /// Reads all rows.
    ///
    /// # Errors
    /// The file is damaged, or a column cannot be what is wanted.
    pub fn read(
        self,
        path: &Path,
        wanted: &[Wanted],
        take: &mut dyn FnMut(Batch) -> Result<(), BadCell>,
    ) -> Result<(), BadCell> {
        let mut row = 1;
        let mut each = |rows: RecordBatch| {
            let batch = batch(&rows, wanted, row)?;
            row += rows.num_rows();
            take(batch)
        };
        match self {
            Self::Parquet => {
                let reader = guarded(|| projected(parquet(path)?, wanted));
                all(reader.map_err(unread)?, &mut each)
            }
            Self::ArrowFile => all(guarded(|| arrow_file(path)).map_err(unread)?, &mut each),
            Self::ArrowStream => all(guarded(|| arrow_stream(path)).map_err(unread)?, &mut each),
        }
    }
}

/// The rows of each row group of a Parquet file.
///
/// # Errors
/// The file is damaged.
pub fn row_groups(path: &Path) -> Result<Vec<usize>, String> {
    guarded(|| {
        let file = parquet(path)?;
        let groups = file.metadata().row_groups().iter();
        Ok(groups
            .map(|g| usize::try_from(g.num_rows()).unwrap_or(0))
            .collect())
    })
}

/// Reads the rows of one row group of a Parquet file, of which `first` is the first, from 1.
///
/// # Errors
/// As [`Form::read`].
pub fn read_group(
    path: &Path,
    group: usize,
    first: usize,
    wanted: &[Wanted],
    take: &mut dyn FnMut(Batch) -> Result<(), BadCell>,
) -> Result<(), BadCell> {
    let reader = guarded(|| projected(parquet(path)?.with_row_groups(vec![group]), wanted));
    let mut row = first;
    all(reader.map_err(unread)?, &mut |rows: RecordBatch| {
        let batch = batch(&rows, wanted, row)?;
        row += rows.num_rows();
        take(batch)
    })
}

/// A reader of the wanted columns alone.
fn projected(
    builder: ParquetRecordBatchReaderBuilder<File>,
    wanted: &[Wanted],
) -> Result<ParquetRecordBatchReader, String> {
    let groups = builder.metadata().row_groups();
    if groups.iter().any(|g| g.total_byte_size() > LARGEST_GROUP) {
        let most = LARGEST_GROUP >> 30;
        return Err(format!("a row group of more than {most} GiB"));
    }
    let root = |wanted: &Wanted| {
        let first = wanted.name.split('.').next().unwrap_or_default();
        let fields = builder.schema().fields();
        let named = |name: &str| fields.iter().position(|f| f.name() == name);
        named(&wanted.name).or_else(|| named(first))
    };
    let roots: Vec<usize> = wanted.iter().filter_map(root).collect();
    let mask = ProjectionMask::roots(builder.parquet_schema(), roots);
    let some = builder.with_projection(mask).with_batch_size(ROWS);
    some.build().map_err(|error| damaged(&error))
}

fn open(path: &Path) -> Result<File, String> {
    system::open_file(path).map_err(|error| system::error_text(&error))
}

fn parquet(path: &Path) -> Result<ParquetRecordBatchReaderBuilder<File>, String> {
    ParquetRecordBatchReaderBuilder::try_new(open(path)?)
        .map_err(|error| format!("the file is damaged: not a whole Parquet file ({error})"))
}

fn arrow_file(path: &Path) -> Result<arrow_ipc::reader::FileReader<File>, String> {
    arrow_ipc::reader::FileReader::try_new(open(path)?, None)
        .map_err(|error| format!("the file is damaged: not a whole file of Arrow ({error})"))
}

fn arrow_stream(path: &Path) -> Result<arrow_ipc::reader::StreamReader<File>, String> {
    arrow_ipc::reader::StreamReader::try_new(open(path)?, None)
        .map_err(|error| format!("the file is damaged: not a whole stream of Arrow ({error})"))
}

/// Why rows of a file whose columns are known cannot be read.
fn damaged(error: &impl std::fmt::Display) -> String {
    let why = error.to_string();
    let why = why.trim_start_matches("Parquet argument error: ");
    format!("the file is damaged ({why})")
}

/// Crates assert that what is in a file is sound.
fn guarded<T>(read: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    system::crash::contained(read).unwrap_or_else(|| Err("the file is damaged".into()))
}

fn all<E: std::fmt::Display>(
    mut reader: impl Iterator<Item = Result<RecordBatch, E>>,
    each: &mut dyn FnMut(RecordBatch) -> Result<(), BadCell>,
) -> Result<(), BadCell> {
    loop {
        let next = guarded(|| reader.next().transpose().map_err(|error| damaged(&error)));
        match next.map_err(unread)? {
            Some(rows) => each(rows)?,
            None => return Ok(()),
        }
    }
}

fn batch(rows: &RecordBatch, wanted: &[Wanted], first: usize) -> Result<Batch, BadCell> {
    let mut batch = Batch::new(wanted);
    for (place, wanted) in wanted.iter().enumerate() {
        let bad = |message: String| BadCell {
            line: 0,
            column: wanted.name.clone(),
            message,
        };
        let Some(column) = column(rows, &wanted.name) else {
            let mut empty = 0..rows.num_rows();
            empty
                .try_for_each(|_| batch.push(place, "", b','))
                .map_err(bad)?;
            continue;
        };
        match &mut batch.values[place] {
            Values::Numbers(numbers) => *numbers = self::numbers(&column).map_err(bad)?,
            Values::Texts(places, texts) => {
                let column = cast(&column, &DataType::Utf8).map_err(bad)?;
                let column = column.as_string::<i32>();
                places.extend(
                    column
                        .iter()
                        .map(|text| texts.place(text.unwrap_or_default())),
                );
            }
        }
    }
    let last = first + rows.num_rows();
    batch.lines = (first..last)
        .map(|row| u32::try_from(row).unwrap_or(u32::MAX))
        .collect();
    Ok(batch)
}

/// A column, or one within a struct.
fn column(rows: &RecordBatch, name: &str) -> Option<ArrayRef> {
    if let Some(column) = rows.column_by_name(name) {
        return Some(Arc::clone(column));
    }
    let mut keys = name.split('.');
    let mut column = Arc::clone(rows.column_by_name(keys.next()?)?);
    for key in keys {
        let inner = column.as_struct_opt()?.column_by_name(key)?;
        column = Arc::clone(inner);
    }
    Some(column)
}

/// The numbers of a column, times in seconds; NaN where there is none.
fn numbers(column: &ArrayRef) -> Result<Vec<f64>, String> {
    // DuckDB gives durations so.
    if matches!(column.data_type(), DataType::Interval(_)) {
        return numbers(&cast(column, &DataType::Duration(TimeUnit::Microsecond))?);
    }
    let seconds = match column.data_type() {
        DataType::Timestamp(unit, _) | DataType::Duration(unit) => Some(match unit {
            TimeUnit::Second => 1.0,
            TimeUnit::Millisecond => 1e3,
            TimeUnit::Microsecond => 1e6,
            TimeUnit::Nanosecond => 1e9,
        }),
        _ => None,
    };
    if let Some(parts) = seconds {
        let whole = cast(column, &DataType::Int64)?;
        let whole = whole.as_primitive::<Int64Type>();
        let value = |value: Option<i64>| value.map_or(f64::NAN, |v| v as f64 / parts);
        return Ok(whole.iter().map(value).collect());
    }
    let numbers = cast(column, &DataType::Float64)?;
    let numbers = numbers.as_primitive::<Float64Type>();
    Ok(match numbers.null_count() {
        0 => numbers.values().to_vec(),
        _ => numbers.iter().map(|v| v.unwrap_or(f64::NAN)).collect(),
    })
}

fn cast(column: &ArrayRef, to: &DataType) -> Result<ArrayRef, String> {
    let strict = CastOptions {
        safe: false,
        ..CastOptions::default()
    };
    guarded(|| cast_with_options(column, to, &strict).map_err(|error| error.to_string()))
}

fn flatten(field: &Field, name: &str, names: &mut Vec<String>) {
    let name = if name.is_empty() {
        field.name().clone()
    } else {
        format!("{name}.{}", field.name())
    };
    match field.data_type() {
        DataType::Struct(inner) => inner.iter().for_each(|field| flatten(field, &name, names)),
        _ => names.push(name),
    }
}
