//! Apache Parquet, by crate `parquet`.

use std::fs::File;
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};

use super::tables::{Group, Raw};
use super::{Refusal, broken};

/// The columns of numbers and truth values. Units are key-value metadata, `unit:position[1]` = `um`;
/// a missing value is a gap.
pub(super) fn read(path: &Path) -> Result<Vec<Group>, Refusal> {
    let refuse = |error: ParquetError| broken("Parquet", error);
    let file = File::open(path).map_err(|error| broken("Parquet", error))?;
    let reader = SerializedFileReader::new(file).map_err(refuse)?;
    let about = reader.metadata().file_metadata();
    let schema = about.schema_descr();
    let unit_of = |name: &str| {
        let pairs = about.key_value_metadata()?;
        pairs.iter().find(|pair| pair.key.strip_prefix("unit:") == Some(name))?.value.clone()
    };
    let mut columns = Vec::new();
    for at in 0..schema.num_columns() {
        let column = schema.column(at);
        let is_flat = column.max_rep_level() == 0 && column.path().parts().len() == 1;
        let logical = column.logical_type_ref();
        let is_date = matches!(
            logical,
            Some(LogicalType::Timestamp { .. } | LogicalType::Date | LogicalType::Time { .. })
        ) || matches!(logical, Some(LogicalType::Decimal { .. }))
            || column.converted_type() == ConvertedType::DECIMAL;
        let is_number = matches!(
            column.physical_type(),
            Physical::BOOLEAN
                | Physical::INT32
                | Physical::INT64
                | Physical::FLOAT
                | Physical::DOUBLE
        );
        if !is_flat || !is_number || is_date {
            continue;
        }
        let mut values = Vec::new();
        for group in 0..reader.num_row_groups() {
            let group = reader.get_row_group(group).map_err(refuse)?;
            append(&mut values, &*group, at, column.max_def_level()).map_err(refuse)?;
        }
        columns.push(Raw::new(column.name(), unit_of(column.name()), values));
    }
    Ok(vec![Group { name: about.schema().name().to_owned(), columns }])
}

/// Appends a column's values of a row group; a missing one is NaN.
fn append(
    values: &mut Vec<f64>,
    group: &dyn RowGroupReader,
    column: usize,
    present: i16,
) -> Result<(), ParquetError> {
    let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
    match group.get_column_reader(column)? {
        ColumnReader::BoolColumnReader(reader) => {
            read_all(reader, rows, present, values, |value| f64::from(u8::from(*value)))
        }
        ColumnReader::Int32ColumnReader(reader) => {
            read_all(reader, rows, present, values, |value| f64::from(*value))
        }
        ColumnReader::Int64ColumnReader(reader) => {
            read_all(reader, rows, present, values, |value| *value as f64)
        }
        ColumnReader::FloatColumnReader(reader) => {
            read_all(reader, rows, present, values, |value| f64::from(*value))
        }
        ColumnReader::DoubleColumnReader(reader) => {
            read_all(reader, rows, present, values, |value| *value)
        }
        _ => Err(ParquetError::General("a column changes its type".into())),
    }
}

fn read_all<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    present: i16,
    values: &mut Vec<f64>,
    convert: impl Fn(&T::T) -> f64,
) -> Result<(), ParquetError> {
    let (mut cells, mut levels) = (Vec::new(), Vec::new());
    let mut left = rows;
    while left > 0 {
        cells.clear();
        levels.clear();
        let (read, _, _) = reader.read_records(left, Some(&mut levels), None, &mut cells)?;
        if read == 0 {
            return Err(ParquetError::EOF(format!("{left} rows are missing")));
        }
        left = left.saturating_sub(read);
        let mut cells = cells.iter().map(&convert);
        if present == 0 {
            values.extend(cells);
        } else {
            let present = levels.iter().map(|level| *level == present);
            values.extend(present.map(|is| is.then(|| cells.next()).flatten().unwrap_or(f64::NAN)));
        }
    }
    Ok(())
}
