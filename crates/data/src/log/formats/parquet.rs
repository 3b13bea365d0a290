//! Apache Parquet, by crate `parquet`.

use std::collections::HashMap;
use std::fs::File;
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::budget::Budget;
use super::{arrow, broken, half};
use crate::log::group::{Group, Raw, Refusal};
use crate::log::ticks::{Base, Start};

/// The columns of numbers and truth values, of durations (in s) and of timestamps (in s after the first one; the
/// first such column is the time where none is called `time`). Units are key-value metadata,
/// `unit:position[1]` = `um`; a missing value is a gap.
pub(super) fn read(path: &Path, budget: &mut Budget) -> Result<Vec<Group>, Refusal> {
    let refuse = |error: ParquetError| broken("Parquet", error);
    let file = File::open(path).map_err(|error| broken("Parquet", error))?;
    let reader = SerializedFileReader::new(file).map_err(refuse)?;
    let about = reader.metadata().file_metadata();
    let schema = about.schema_descr();
    let pairs = about.key_value_metadata().map_or(&[][..], Vec::as_slice);
    let named = pairs.iter().filter_map(|pair| Some((pair.key.as_str(), pair.value.as_deref()?)));
    let named: HashMap<&str, &str> = named.collect();
    let mut durations =
        named.get("ARROW:schema").map(|text| arrow::durations(text)).unwrap_or_default();
    durations.extend(named.get("pandas").map(|text| durations_of(text)).unwrap_or_default());
    let mut group = Group::new(about.schema().name(), Vec::new());
    let mut columns = Vec::new();
    for at in 0..schema.num_columns() {
        let column = schema.column(at);
        match why_not(&column) {
            Some(why) => group.leave_out(column.path().string(), why),
            None => {
                let meaning = Meaning::of(&column, durations.get(column.name()).copied());
                let present = column.max_def_level();
                let values = Vec::new();
                columns.push(Reading { at, present, meaning, first: None, base: None, values });
            }
        }
    }
    let rows = reader.metadata().row_groups().iter().map(|rows| rows.num_rows());
    let rows = rows.filter_map(|rows| u64::try_from(rows).ok()).fold(0, u64::saturating_add);
    budget.take(rows, 8 * columns.len() as u64)?;
    for rows in 0..reader.num_row_groups() {
        let rows = reader.get_row_group(rows).map_err(refuse)?;
        for column in &mut columns {
            let packed = rows.metadata().column(column.at).uncompressed_size();
            if u64::try_from(packed).is_ok_and(|size| size > budget.left()) {
                return Err(budget.refusal());
            }
            column.append(&*rows).map_err(refuse)?;
        }
    }
    let has_time = columns.iter().any(|column| schema.column(column.at).name() == "time");
    let mut dated = columns.iter().position(|column| column.meaning.ticks().is_some());
    dated = dated.filter(|_| !has_time);
    for (at, column) in columns.into_iter().enumerate() {
        let own = schema.column(column.at).name().to_owned();
        let unit = match column.meaning.ticks() {
            Some(_) => Some("s".to_owned()),
            None => named.get(format!("unit:{own}").as_str()).map(|unit| (*unit).to_owned()),
        };
        let name = if dated == Some(at) { "time".into() } else { own };
        let start = column.base.filter(|base| !base.is_none()).map_or(Start::None, Start::Long);
        group.columns.push(Raw::new(name, unit, column.values).after(start));
    }
    Ok(vec![group])
}

/// Why a column is no signal.
fn why_not(column: &ColumnDescriptor) -> Option<&'static str> {
    if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
        return Some("is nested");
    }
    let logical = column.logical_type_ref();
    if matches!(logical, Some(LogicalType::Date | LogicalType::Time { .. })) {
        return Some("holds dates");
    }
    if matches!(logical, Some(LogicalType::Decimal { .. }))
        || column.converted_type() == ConvertedType::DECIMAL
    {
        return Some("holds decimal numbers");
    }
    match column.physical_type() {
        Physical::BOOLEAN
        | Physical::INT96
        | Physical::INT32
        | Physical::INT64
        | Physical::FLOAT
        | Physical::DOUBLE => None,
        Physical::FIXED_LEN_BYTE_ARRAY if is_half(column) => None,
        _ => Some("holds texts"),
    }
}

/// Whether a column holds floating-point numbers of 16 bits.
fn is_half(column: &ColumnDescriptor) -> bool {
    matches!(column.logical_type_ref(), Some(LogicalType::Float16))
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
    /// By the column's type, and by what pandas or Arrow say of it where they wrote the file: Parquet itself has no
    /// durations.
    fn of(column: &ColumnDescriptor, duration: Option<f64>) -> Self {
        let seconds = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1e-3,
            TimeUnit::MICROS => 1e-6,
            TimeUnit::NANOS => 1e-9,
        };
        match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(instant)), _) => Self::Instant(seconds(&instant.unit)),
            (Some(LogicalType::Integer(number)), _) if !number.is_signed => Self::Unsigned,
            // Spark and Impala write instants so, and nothing else.
            _ if column.physical_type() == Physical::INT96 => Self::Instant(1e-9),
            (_, ConvertedType::TIMESTAMP_MILLIS) => Self::Instant(1e-3),
            (_, ConvertedType::TIMESTAMP_MICROS) => Self::Instant(1e-6),
            (
                _,
                ConvertedType::UINT_8
                | ConvertedType::UINT_16
                | ConvertedType::UINT_32
                | ConvertedType::UINT_64,
            ) => Self::Unsigned,
            _ => duration.map_or(Self::Signed, Self::Duration),
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

/// Seconds per tick of the columns that pandas calls `timedelta64[…]`.
fn durations_of(pandas: &str) -> HashMap<String, f64> {
    let about: serde_json::Value = serde_json::from_str(pandas).unwrap_or_default();
    let columns = about["columns"].as_array().map_or(&[][..], Vec::as_slice);
    let durations = columns.iter().filter_map(|column| {
        let kind = column["numpy_type"].as_str()?;
        let tick = match kind.strip_prefix("timedelta64[")?.strip_suffix(']')? {
            "s" => 1.0,
            "ms" => 1e-3,
            "us" => 1e-6,
            "ns" => 1e-9,
            _ => return None,
        };
        let name = column["field_name"].as_str().or(column["name"].as_str())?;
        Some((name.to_owned(), tick))
    });
    durations.collect()
}

/// A column that is read.
struct Reading {
    at: usize,
    /// Level of a value that is not missing.
    present: i16,
    meaning: Meaning,
    /// The first tick of a column of instants.
    first: Option<i64>,
    /// What is taken off a column of whole numbers.
    base: Option<Base>,
    values: Vec<f64>,
}

impl Reading {
    /// Appends the column's values of a row group; a missing one is NaN.
    fn append(&mut self, group: &dyn RowGroupReader) -> Result<(), ParquetError> {
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let Self { at, present, meaning, first, base, values } = self;
        let present = *present;
        match group.get_column_reader(*at)? {
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
                    Meaning::Signed => off(i128::from(*value), base),
                    Meaning::Unsigned => off(i128::from(value.cast_unsigned()), base),
                    // The difference is exact; the ticks since 1970 are not, as doubles. Division by a whole number
                    // gives the decimals that a text would have.
                    Meaning::Instant(tick) => after(*value, first, *tick),
                    Meaning::Duration(tick) => *value as f64 / (1.0 / *tick).round(),
                })
            }
            ColumnReader::Int96ColumnReader(reader) => {
                read_all(reader, rows, present, values, |value| {
                    after(value.to_nanos(), first, 1e-9)
                })
            }
            ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                read_all(reader, rows, present, values, |value| match *value.data() {
                    [low, high] => half::number(u16::from_le_bytes([low, high])),
                    _ => f64::NAN,
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

/// A whole number without the base of its column.
fn off(integer: i128, base: &mut Option<Base>) -> f64 {
    base.get_or_insert_with(|| Base::of(integer)).off(integer)
}

/// Seconds after the first instant of a column.
fn after(ticks: i64, first: &mut Option<i64>, tick: f64) -> f64 {
    let from = *first.get_or_insert(ticks);
    ticks.wrapping_sub(from) as f64 / (1.0 / tick).round()
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
