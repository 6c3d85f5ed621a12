//! Rows as a Parquet file.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};
use serde_json::Value;

use super::ExperimentError;
use crate::bench::{Column, ColumnKind, Columns};

/// Returns a Parquet file of rows, in one row group and without compression; every column may be null. The same rows give
/// the same bytes.
///
/// # Errors
/// Fails when the writer refuses the rows.
pub fn parquet_bytes<R: Columns>(rows: &[R]) -> Result<Vec<u8>, ExperimentError> {
    let reason = |error: &dyn ToString| ExperimentError::Parquet { reason: error.to_string() };
    let records: Result<Vec<Value>, _> = rows.iter().map(serde_json::to_value).collect();
    let records = records.map_err(|error| reason(&error))?;
    write_file(R::COLUMNS, &records).map_err(|error| reason(&error))
}

fn write_file(columns: &[Column], records: &[Value]) -> Result<Vec<u8>, ParquetError> {
    let fields: Result<Vec<TypePtr>, _> = columns.iter().map(field).collect();
    let schema = Type::group_type_builder("row").with_fields(fields?).build()?;
    let properties = WriterProperties::builder()
        .set_created_by(concat!("inbye ", env!("CARGO_PKG_VERSION")).to_owned())
        .build();
    let mut bytes = Vec::new();
    let mut file = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for described in columns {
        let Some(column) = group.next_column()? else {
            break;
        };
        let values = || records.iter().map(|record| &record[described.name]);
        match described.kind {
            ColumnKind::Text => write::<ByteArrayType>(column, values(), |value| {
                value.as_str().map(ByteArray::from)
            }),
            ColumnKind::Integer => write::<Int64Type>(column, values(), Value::as_i64),
            ColumnKind::Real => write::<DoubleType>(column, values(), Value::as_f64),
            ColumnKind::Bool => write::<BoolType>(column, values(), Value::as_bool),
        }?;
    }
    group.close()?;
    file.close()?;
    Ok(bytes)
}

fn field(column: &Column) -> Result<TypePtr, ParquetError> {
    let (physical, logical) = match column.kind {
        ColumnKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        ColumnKind::Integer => (Physical::INT64, None),
        ColumnKind::Real => (Physical::DOUBLE, None),
        ColumnKind::Bool => (Physical::BOOLEAN, None),
    };
    let field = Type::primitive_type_builder(column.name, physical)
        .with_logical_type(logical)
        .with_repetition(Repetition::OPTIONAL)
        .build()?;
    Ok(Arc::new(field))
}

/// Writes a column: its values, and for each row whether it has one.
fn write<'v, T: DataType>(
    mut column: SerializedColumnWriter<'_>,
    values: impl Iterator<Item = &'v Value>,
    read: impl Fn(&Value) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let values: Vec<Option<T::T>> = values.map(read).collect();
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let present: Vec<T::T> = values.into_iter().flatten().collect();
    column.typed::<T>().write_batch(&present, Some(&levels), None)?;
    column.close()
}
