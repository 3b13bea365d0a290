//! Times that were written with too few digits.
//!
//! At 6.4 kHz six digits put rows of the second second up to 3 % of a sample time away from where they were
//! read. A model that moves on a grid of its own would see every second input a step late. Where all
//! of a record's times are those of a uniform grid but for the rounding of their digits (or to single
//! precision), they are taken as the grid's.

use super::{Log, Record, SampleTime};

/// Distance from the grid, in sample times, below which times are as good as doubles are.
const EXACT: f64 = 1e-6;

/// A record whose times were rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounded {
    /// Number of the record.
    pub record: i64,
    /// The sample time of the grid that was taken, in s.
    pub period: f64,
    /// The greatest distance of a time as it was written, as a part of the sample time.
    pub distance: f64,
}

impl Log {
    /// The records whose times were taken as those of a uniform grid when the file was read, as they
    /// were rounded.
    #[must_use]
    pub fn rounded(&self) -> &[Rounded] {
        &self.rounded
    }

    /// A sentence about the records whose times were rounded, for notes.
    #[must_use]
    pub fn note_on_times(&self) -> Option<String> {
        let first = self.rounded.first()?;
        let worst = self.rounded.iter().map(|r| r.distance).fold(0.0, f64::max);
        Some(format!(
            "{}: times were written with too few digits, up to {:.1} % of a sample off; they are taken as one \
             every {} s",
            self.origin,
            100.0 * worst,
            first.period
        ))
    }

    /// The log with the times of all rounded records on their uniform grids.
    pub(super) fn with_times_on_grids(mut self) -> Self {
        for record in self.records.clone() {
            let Ok(grid) = self.sample_time(&record, SampleTime::TOLERANCE) else { continue };
            if grid.jitter > EXACT && self.is_rounded(&record, &grid) {
                let times = self.time[record.rows.clone()].iter_mut();
                times.zip(0u32..).for_each(|(t, k)| *t = grid.start + f64::from(k) * grid.period);
                let (period, distance) = (grid.period, grid.jitter);
                self.rounded.push(Rounded { record: record.id, period, distance });
            }
        }
        self
    }

    /// Whether each time is the grid's but for the digits that all times of its size were written with, or for
    /// single precision.
    fn is_rounded(&self, record: &Record, grid: &SampleTime) -> bool {
        let time = &self.time[record.rows.clone()];
        let at = |k: usize| grid.start + k as f64 * grid.period;
        // The start was rounded as well: as much again.
        let single = |(k, t): (usize, &f64)| {
            f64::from(*t as f32) == *t && (t - at(k)).abs() <= f64::from(f32::EPSILON) * t.abs()
        };
        if time.iter().enumerate().all(single) {
            return true;
        }
        // Decimals by power of ten.
        let mut most = std::collections::BTreeMap::<i32, usize>::new();
        let size = |t: f64| if t == 0.0 { i32::MIN } else { t.abs().log10().floor() as i32 };
        for t in time {
            let text = t.to_string();
            let decimals = text.split_once('.').map_or(0, |(_, behind)| behind.len());
            let most = most.entry(size(*t)).or_default();
            *most = decimals.max(*most);
        }
        time.iter().enumerate().all(|(k, t)| {
            let decimals = most.get(&size(*t)).copied().unwrap_or(0) as i32;
            (t - at(k)).abs() <= 1.0001 * 10f64.powi(-decimals)
        })
    }
}
