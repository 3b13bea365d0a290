//! Apache Parquet, by crate `parquet`.

use std::fs::File;
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::broken;
use crate::log::group::{Group, Raw, Refusal};

/// The columns of numbers and truth values, of durations (in s) and of timestamps (in s after the first one; the
/// first such column is the time where none is called `time`). Units are key-value metadata,
/// `unit:position[1]` = `um`; a missing value is a gap.
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
    let pandas = about.key_value_metadata().and_then(|pairs| {
        pairs.iter().find(|pair| pair.key == "pandas").and_then(|pair| pair.value.clone())
    });
    let (mut columns, mut dated, mut first) = (Vec::new(), None, None);
    for at in 0..schema.num_columns() {
        let column = schema.column(at);
        let is_flat = column.max_rep_level() == 0 && column.path().parts().len() == 1;
        let logical = column.logical_type_ref();
        let is_date = matches!(logical, Some(LogicalType::Date | LogicalType::Time { .. }))
            || matches!(logical, Some(LogicalType::Decimal { .. }))
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
        let meaning = Meaning::of(&column, pandas.as_deref());
        let mut values = Vec::new();
        for group in 0..reader.num_row_groups() {
            let group = reader.get_row_group(group).map_err(refuse)?;
            let mut cells = Cells { values: &mut values, meaning: &meaning, first: &mut first };
            cells.append(&*group, at, column.max_def_level()).map_err(refuse)?;
        }
        let mut unit = unit_of(column.name());
        if meaning.ticks().is_some() {
            unit = Some("s".into());
            dated.get_or_insert(columns.len());
        }
        columns.push(Raw::new(column.name(), unit, values));
        first = None;
    }
    if let (Some(at), false) = (dated, columns.iter().any(|raw| raw.name == "time")) {
        columns[at].name = "time".into();
    }
    Ok(vec![Group::new(about.schema().name(), columns)])
}

/// What the whole numbers of a column mean.
enum Meaning {
    /// Numbers with a sign.
    Signed,
    /// Numbers without one, which Parquet stores with the bits of signed ones.
    Unsigned,
    /// Parts of a second since some date: s per tick.
    Instant(f64),
    /// Parts of a second: s per tick.
    Duration(f64),
}

impl Meaning {
    /// By the column's type, and by what pandas says of it where it wrote the file: Parquet itself has no durations.
    fn of(column: &ColumnDescriptor, pandas: Option<&str>) -> Self {
        let seconds = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1e-3,
            TimeUnit::MICROS => 1e-6,
            TimeUnit::NANOS => 1e-9,
        };
        match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(instant)), _) => Self::Instant(seconds(&instant.unit)),
            (Some(LogicalType::Integer(number)), _) if !number.is_signed => Self::Unsigned,
            (_, ConvertedType::TIMESTAMP_MILLIS) => Self::Instant(1e-3),
            (_, ConvertedType::TIMESTAMP_MICROS) => Self::Instant(1e-6),
            (
                _,
                ConvertedType::UINT_8
                | ConvertedType::UINT_16
                | ConvertedType::UINT_32
                | ConvertedType::UINT_64,
            ) => Self::Unsigned,
            _ => pandas
                .and_then(|text| duration_of(text, column.name()))
                .map_or(Self::Signed, Self::Duration),
        }
    }

    /// Seconds per tick.
    fn ticks(&self) -> Option<f64> {
        match self {
            Self::Instant(tick) | Self::Duration(tick) => Some(*tick),
            Self::Signed | Self::Unsigned => None,
        }
    }
}

/// Seconds per tick of a column that pandas calls `timedelta64[…]`.
fn duration_of(pandas: &str, name: &str) -> Option<f64> {
    let about: serde_json::Value = serde_json::from_str(pandas).ok()?;
    let columns = about["columns"].as_array()?;
    let own = columns.iter().find(|c| c["field_name"] == name || c["name"] == name)?;
    match own["numpy_type"].as_str()?.strip_prefix("timedelta64[")?.strip_suffix(']')? {
        "s" => Some(1.0),
        "ms" => Some(1e-3),
        "us" => Some(1e-6),
        "ns" => Some(1e-9),
        _ => None,
    }
}

/// Where the cells of one column go.
struct Cells<'a> {
    values: &'a mut Vec<f64>,
    meaning: &'a Meaning,
    /// The first tick of a column of instants.
    first: &'a mut Option<i64>,
}

impl Cells<'_> {
    /// Appends the column's values of a row group; a missing one is NaN.
    fn append(
        &mut self,
        group: &dyn RowGroupReader,
        column: usize,
        present: i16,
    ) -> Result<(), ParquetError> {
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let (meaning, first, values) = (self.meaning, &mut *self.first, &mut *self.values);
        match group.get_column_reader(column)? {
            ColumnReader::BoolColumnReader(reader) => {
                read_all(reader, rows, present, values, |value| f64::from(u8::from(*value)))
            }
            ColumnReader::Int32ColumnReader(reader) => {
                read_all(reader, rows, present, values, |value| match meaning {
                    Meaning::Unsigned => f64::from(value.cast_unsigned()),
                    _ => f64::from(*value) * meaning.ticks().unwrap_or(1.0),
                })
            }
            ColumnReader::Int64ColumnReader(reader) => {
                read_all(reader, rows, present, values, |value| match meaning {
                    Meaning::Signed => *value as f64,
                    Meaning::Unsigned => value.cast_unsigned() as f64,
                    // The difference is exact; the ticks since 1970 are not, as doubles. Division by a whole number
                    // gives the decimals that a text would have.
                    Meaning::Instant(tick) => {
                        let from = *first.get_or_insert(*value);
                        value.wrapping_sub(from) as f64 / (1.0 / tick).round()
                    }
                    Meaning::Duration(tick) => *value as f64 / (1.0 / tick).round(),
                })
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
}

fn read_all<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    rows: usize,
    present: i16,
    values: &mut Vec<f64>,
    mut convert: impl FnMut(&T::T) -> f64,
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
        let mut cells = cells.iter().map(&mut convert);
        if present == 0 {
            values.extend(cells);
        } else {
            let present = levels.iter().map(|level| *level == present);
            values.extend(present.map(|is| is.then(|| cells.next()).flatten().unwrap_or(f64::NAN)));
        }
    }
    Ok(())
}
