//! Writes Parquet files of columns.

use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

/// The values of a column.
pub enum Column {
    Text(Vec<String>),
    Whole(Vec<i64>),
    Number(Vec<f64>),
}

/// A file with these columns, compressed as Argoverse's are.
pub fn file(columns: &[(&str, Column)]) -> Vec<u8> {
    compressed(columns, Compression::SNAPPY)
}

/// A file with these columns, compressed so.
pub fn compressed(columns: &[(&str, Column)], compression: Compression) -> Vec<u8> {
    let fields = columns.iter().map(|(name, column)| {
        let (physical, converted) = match column {
            Column::Text(_) => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
            Column::Whole(_) => (Physical::INT64, ConvertedType::NONE),
            Column::Number(_) => (Physical::DOUBLE, ConvertedType::NONE),
        };
        let field = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_converted_type(converted);
        Arc::new(field.build().unwrap())
    });
    let schema = Type::group_type_builder("schema").with_fields(fields.collect());
    let properties = WriterProperties::builder()
        .set_compression(compression)
        .build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(
        &mut bytes,
        Arc::new(schema.build().unwrap()),
        Arc::new(properties),
    )
    .unwrap();
    let mut group = writer.next_row_group().unwrap();
    for (_, column) in columns {
        let mut into = group.next_column().unwrap().unwrap();
        match column {
            Column::Text(values) => {
                let values: Vec<ByteArray> = values.iter().map(|v| v.as_str().into()).collect();
                let levels = vec![1; values.len()];
                into.typed::<ByteArrayType>()
                    .write_batch(&values, Some(&levels), None)
                    .unwrap();
            }
            Column::Whole(values) => {
                let levels = vec![1; values.len()];
                into.typed::<Int64Type>()
                    .write_batch(values, Some(&levels), None)
                    .unwrap();
            }
            Column::Number(values) => {
                let levels = vec![1; values.len()];
                into.typed::<DoubleType>()
                    .write_batch(values, Some(&levels), None)
                    .unwrap();
            }
        }
        into.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    bytes
}
