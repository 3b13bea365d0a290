//! The linear parts as coordinates of a search.

use numerics::levenberg_marquardt::Unknown;

use crate::record::{Record, Rows};

use super::response::{LinearPart, ModeShape};

/// Highest frequency in parts of the sample rate: above it a mode is seen only through its skirt.
const HIGHEST: f64 = 0.45;
/// Fewest periods of the lowest frequency within the rows fitted on.
const FEWEST_PERIODS: f64 = 4.0;
/// Bounds of a damping ratio.
const DAMPING: (f64, f64) = (1e-4, 2.0);
/// Which linear parts a candidate has beside its delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Structure {
    pub(crate) lag: bool,
    pub(crate) mode: bool,
}

/// Standard deviations of the linear parts' parameters; `None`: not determined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Deviations {
    pub(crate) delay: Option<f64>,
    pub(crate) bandwidth: Option<f64>,
    pub(crate) frequency: Option<f64>,
    pub(crate) damping: Option<f64>,
}

/// Lowest and highest frequency that can be seen in these rows.
pub(crate) fn visible(records: &[Record], rows: &[Rows]) -> (f64, f64) {
    let each = || records.iter().zip(rows);
    let time = |(record, rows): (&Record, &Rows)| rows.len().max(2) as f64 * record.period();
    let lowest = FEWEST_PERIODS / each().map(time).fold(f64::MIN_POSITIVE, f64::max);
    let highest = HIGHEST / each().map(|(r, _)| r.period()).fold(f64::INFINITY, f64::min);
    (lowest.min(0.5 * highest), highest)
}

/// Between the parameters and the coordinates of the search: delay in samples, the rest as natural
/// logarithms.
#[derive(Clone, Copy)]
pub(crate) struct Coordinates {
    pub(crate) structure: Structure,
    pub(crate) period: f64,
}

impl Coordinates {
    pub(crate) fn unknowns(
        &self,
        at: &LinearPart,
        longest_delay: f64,
        range: &(f64, f64),
    ) -> Vec<Unknown> {
        let (low, high) = (range.0.ln(), range.1.ln());
        let longest = longest_delay / self.period;
        let mut unknowns =
            vec![Unknown { start: at.delay / self.period, lower: 0.0, upper: longest }];
        if let Some(bandwidth) = at.bandwidth {
            // A lag may lie far above what is seen of it.
            unknowns.push(Unknown { start: bandwidth.ln(), lower: low, upper: high + 3.0 });
        }
        if let Some(mode) = at.mode {
            unknowns.push(Unknown { start: mode.frequency.ln(), lower: low, upper: high });
            let (lower, upper) = (DAMPING.0.ln(), DAMPING.1.ln());
            unknowns.push(Unknown { start: mode.damping.ln(), lower, upper });
        }
        unknowns
    }

    pub(crate) fn linear(&self, p: &[f64]) -> LinearPart {
        let mut values = p.iter().copied();
        let mut next = || values.next().unwrap_or(0.0);
        let delay = next() * self.period;
        let bandwidth = self.structure.lag.then(|| next().exp());
        let mode = self
            .structure
            .mode
            .then(|| ModeShape { frequency: next().exp(), damping: next().exp() });
        LinearPart { delay, bandwidth, mode }
    }

    pub(crate) fn deviations(&self, at: &LinearPart, deviations: &[Option<f64>]) -> Deviations {
        let mut values = deviations.iter().copied();
        let mut next = |scale: f64| values.next().flatten().map(|d| d * scale);
        let delay = next(self.period);
        let bandwidth = at.bandwidth.and_then(&mut next);
        let frequency = at.mode.and_then(|mode| next(mode.frequency));
        let damping = at.mode.and_then(|mode| next(mode.damping));
        Deviations { delay, bandwidth, frequency, damping }
    }
}
