//! Runs as Apache Parquet: typed columns, row groups of a few hundred runs.

use std::io;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use super::columns::{COLUMNS, Cell, Column, Kind, cells};
use super::{Runs, Stopped, Target, each};
use crate::cli::parted::parted;

/// Rows that are kept in memory before they are written as a row group.
const GROUP: usize = 512;

type File = SerializedFileWriter<Target>;

/// Writes the runs; returns the target, not yet moved into place.
pub fn write(
    target: Target,
    mut runs: impl Iterator<Item = super::Item>,
) -> Result<Target, Stopped> {
    let created_by = format!("nearmiss version {}", env!("CARGO_PKG_VERSION"));
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(created_by)
        .build();
    let schema = schema().map_err(io::Error::other)?;
    let mut file = File::new(target, schema, Arc::new(properties)).map_err(io::Error::other)?;
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let runs: Runs<'_> = &mut runs;
    each(runs, |run| {
        rows.push(cells(&run).collect());
        if rows.len() >= GROUP {
            group(&mut file, &std::mem::take(&mut rows)).map_err(io::Error::other)?;
        }
        Ok(())
    })?;
    if !rows.is_empty() {
        group(&mut file, &rows).map_err(io::Error::other)?;
    }
    let mut target = file.into_inner().map_err(io::Error::other)?;
    io::Write::flush(&mut target)?;
    Ok(target)
}

fn schema() -> Result<TypePtr, ParquetError> {
    let columns = COLUMNS.iter().map(|column| {
        let (physical, logical) = match column.kind {
            Kind::Text => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            Kind::Integer => (PhysicalType::INT64, None),
            Kind::Number => (PhysicalType::DOUBLE, None),
            Kind::Truth => (PhysicalType::BOOLEAN, None),
        };
        let builder = Type::primitive_type_builder(column.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        builder.build().map(Arc::new)
    });
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    let root = Type::group_type_builder("runs").with_fields(columns);
    root.build().map(Arc::new)
}

fn group(file: &mut File, rows: &[Vec<Cell>]) -> Result<(), ParquetError> {
    let mut group = file.next_row_group()?;
    for (place, column) in COLUMNS.iter().enumerate() {
        let Some(mut writer) = group.next_column()? else {
            break;
        };
        values(writer.untyped(), column, rows.iter().map(|row| &row[place]))?;
        writer.close()?;
    }
    group.close().map(drop)
}

fn values<'a>(
    writer: &mut ColumnWriter<'_>,
    column: &Column,
    cells: impl Iterator<Item = &'a Cell>,
) -> Result<(), ParquetError> {
    match writer {
        ColumnWriter::ByteArrayColumnWriter(writer) => {
            let text = |cell: &Cell| {
                (!cell.0.is_null()).then(|| ByteArray::from(cell.text().into_bytes()))
            };
            let (found, there) = parted(cells.map(text));
            writer.write_batch(&found, Some(&there), None)?;
        }
        ColumnWriter::Int64ColumnWriter(writer) => {
            let (found, there) = parted(cells.map(|cell| cell.0.as_i64()));
            writer.write_batch(&found, Some(&there), None)?;
        }
        ColumnWriter::DoubleColumnWriter(writer) => {
            let (found, there) = parted(cells.map(|cell| cell.0.as_f64()));
            writer.write_batch(&found, Some(&there), None)?;
        }
        ColumnWriter::BoolColumnWriter(writer) => {
            let (found, there) = parted(cells.map(|cell| cell.0.as_bool()));
            writer.write_batch(&found, Some(&there), None)?;
        }
        _ => {
            let message = format!("the values of {} do not fit its type", column.name);
            return Err(ParquetError::General(message));
        }
    }
    Ok(())
}
