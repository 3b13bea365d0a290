//! National Instruments' TDMS, by crate `tdms-rs`.

mod lengths;

use std::path::Path;

use tdms_rs::{DataType, PropertyValue, TdmsChannel, TdmsError, TdmsFile};

use super::broken;
use crate::log::group::{Group, Raw, Refusal};

/// The channels of a group that were sampled at the same times are one group; times come from a channel `time`, else
/// from the waveform properties: `wf_increment`, from `wf_start_offset` on, and `wf_start_time` against the
/// file's first channel: groups of tests that were run one after the other have other times.
pub(super) fn read(path: &Path) -> Result<Vec<Group>, Refusal> {
    let refuse = |error: TdmsError| broken("TDMS", error);
    lengths::check(path)?;
    let file = TdmsFile::open(path).map_err(refuse)?;
    let size = std::fs::metadata(path).map_err(|error| broken("TDMS", error))?.len();
    let (mut groups, mut first_start) = (Vec::new(), None);
    for group in file.groups() {
        let mut sampled: Vec<Sampled> = Vec::new();
        for channel in group.channels() {
            // Memory follows what the file holds, not what it says.
            let bytes = (channel.len() as u64).checked_mul(channel.dtype().itemsize() as u64);
            if bytes.is_none_or(|bytes| bytes > size) {
                return Err(broken("TDMS", format!("{} is longer than the file", channel.name())));
            }
            let Some(values) = values(&channel).map_err(refuse)? else { continue };
            let grid = Grid::of(&channel, &mut first_start);
            let unit = channel.property("unit_string").and_then(|unit| match unit {
                PropertyValue::String(unit) => Some(unit.clone()),
                _ => None,
            });
            let rows = values.len();
            let raw = Raw::new(channel.name(), unit, values);
            let is_same = |s: &&mut Sampled| {
                s.rows == rows && (s.grid == grid || s.grid.is_none() || grid.is_none())
            };
            match sampled.iter_mut().find(is_same) {
                Some(same) => {
                    same.grid = same.grid.or(grid);
                    same.columns.push(raw);
                }
                None => sampled.push(Sampled { grid, rows, columns: vec![raw] }),
            }
        }
        let is_one = sampled.len() == 1;
        for part in sampled {
            let name = match (is_one, part.columns.first()) {
                (false, Some(first)) => format!("{}/{}", group.name(), first.name),
                _ => group.name().to_owned(),
            };
            groups.push(Group::new(name, part.with_times()));
        }
    }
    Ok(groups)
}

/// Channels that were sampled at the same times.
struct Sampled {
    /// `None` where no channel says it.
    grid: Option<Grid>,
    rows: usize,
    columns: Vec<Raw>,
}

impl Sampled {
    /// The columns with a column `time` before them, where there is none and the grid is known.
    fn with_times(mut self) -> Vec<Raw> {
        if let (Some(grid), false) = (self.grid, self.columns.iter().any(|c| c.name == "time")) {
            // A whole number of Hz gives the times that a reader of decimals would give.
            let rate = (1.0 / grid.period).round();
            let is_whole = (rate * grid.period - 1.0).abs() < 1e-12;
            let after =
                |row: usize| if is_whole { row as f64 / rate } else { row as f64 * grid.period };
            let times = (0..self.rows).map(|row| grid.start + after(row)).collect();
            self.columns.insert(0, Raw::new("time", Some("s".into()), times));
        }
        self.columns
    }
}

/// When a channel was sampled: its first sample and its sample time, in s.
#[derive(Clone, Copy, PartialEq)]
struct Grid {
    start: f64,
    period: f64,
}

impl Grid {
    /// `first` is the start of the file's first channel that has one: whole seconds, and parts of 2^-64 s.
    fn of(channel: &TdmsChannel<'_>, first: &mut Option<(i64, u64)>) -> Option<Self> {
        let number = |name| match channel.property(name) {
            Some(PropertyValue::Double(value)) => Some(*value),
            Some(PropertyValue::Float(value)) => Some(f64::from(*value)),
            _ => None,
        };
        let period = number("wf_increment").filter(|period| *period > 0.0)?;
        let mut start = number("wf_start_offset").unwrap_or(0.0);
        if let Some(PropertyValue::TimeStamp((seconds, parts))) = channel.property("wf_start_time")
        {
            let (whole, part) = *first.get_or_insert((*seconds, *parts));
            let parts = (*parts as f64 - part as f64) / 2.0_f64.powi(64);
            start += seconds.saturating_sub(whole) as f64 + parts;
        }
        Some(Self { start, period })
    }
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
