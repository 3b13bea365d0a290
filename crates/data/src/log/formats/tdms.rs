//! National Instruments' TDMS, by crate `tdms-rs`.

mod lengths;

use std::path::Path;

use tdms_rs::{DataType, PropertyValue, TdmsChannel, TdmsError, TdmsFile};

use super::tables::{Group, Raw};
use super::{Refusal, broken};

/// Each group is one group; times come from a channel `time`, else from the property
/// `wf_increment`, from `wf_start_offset` on.
pub(super) fn read(path: &Path) -> Result<Vec<Group>, Refusal> {
    let refuse = |error: TdmsError| broken("TDMS", error);
    lengths::check(path)?;
    let file = TdmsFile::open(path).map_err(refuse)?;
    let size = std::fs::metadata(path).map_err(|error| broken("TDMS", error))?.len();
    let groups = file.groups().map(|group| {
        let mut columns = Vec::new();
        let mut grid = None;
        for channel in group.channels() {
            // Memory follows what the file holds, not what it says.
            let bytes = (channel.len() as u64).checked_mul(channel.dtype().itemsize() as u64);
            if bytes.is_none_or(|bytes| bytes > size) {
                return Err(broken("TDMS", format!("{} is longer than the file", channel.name())));
            }
            let Some(values) = values(&channel).map_err(refuse)? else { continue };
            grid = grid.or_else(|| grid_of(&channel));
            let unit = channel.property("unit_string").and_then(|unit| match unit {
                PropertyValue::String(unit) => Some(unit.clone()),
                _ => None,
            });
            columns.push(Raw::new(channel.name(), unit, values));
        }
        let rows = columns.iter().map(|raw| raw.values.len()).max().unwrap_or(0);
        columns.retain(|raw| raw.values.len() == rows);
        if let (Some((start, period)), false) = (grid, columns.iter().any(|c| c.name == "time")) {
            // A whole number of Hz gives the times that a reader of decimals would give.
            let rate = (1.0 / period).round();
            let is_whole = (rate * period - 1.0).abs() < 1e-12;
            let after = |row: usize| if is_whole { row as f64 / rate } else { row as f64 * period };
            let times = (0..rows).map(|row| start + after(row)).collect();
            columns.insert(0, Raw::new("time", Some("s".into()), times));
        }
        Ok(Group { name: group.name().to_owned(), columns })
    });
    groups.collect()
}

/// Start and sample time in s.
fn grid_of(channel: &TdmsChannel<'_>) -> Option<(f64, f64)> {
    let number = |name| match channel.property(name) {
        Some(PropertyValue::Double(value)) => Some(*value),
        Some(PropertyValue::Float(value)) => Some(f64::from(*value)),
        _ => None,
    };
    let period = number("wf_increment").filter(|period| *period > 0.0)?;
    Some((number("wf_start_offset").unwrap_or(0.0), period))
}

/// The values as doubles; `None` for texts, truth values and dates.
fn values(channel: &TdmsChannel<'_>) -> Result<Option<Vec<f64>>, TdmsError> {
    macro_rules! numbers {
        ($($kind:ident => $type:ty),*) => {
            match channel.dtype() {
                $(DataType::$kind => {
                    let mut raw = vec![<$type>::default(); channel.len()];
                    channel.read(0..raw.len(), &mut raw)?;
                    Ok(Some(raw.into_iter().map(|value| value as f64).collect()))
                })*
                _ => Ok(None),
            }
        };
    }
    numbers!(
        I8 => i8, I16 => i16, I32 => i32, I64 => i64, U8 => u8, U16 => u16, U32 => u32,
        U64 => u64, Float => f32, Double => f64
    )
}
