//! Numbers that were known when a machine was diagnosed and that many effects need.

use serde::{Deserialize, Serialize};

/// Centre and half width of the range of a signal, to bring formulas to numbers near one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Span {
    /// Middle of the range.
    pub centre: f64,
    /// Half the range; above zero.
    pub half: f64,
}

impl Span {
    /// The span of these values; half is 1 where they are constant.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let half = 0.5 * (high - low);
        if half > 0.0 && half.is_finite() {
            Self { centre: 0.5 * (high + low), half }
        } else {
            Self { centre: if low.is_finite() { low } else { 0.0 }, half: 1.0 }
        }
    }

    /// The place of a value in the range, from −1 to 1 within it.
    #[inline]
    #[must_use]
    pub fn unit(self, value: f64) -> f64 {
        (value - self.centre) / self.half
    }
}

/// Plays inside the original: `Σ w·P_r[v]` of the drive v.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Memory {
    /// Thresholds, above zero, in the drive's unit.
    pub r: Vec<f64>,
    /// Weights in the path's unit per the drive's, as many.
    pub w: Vec<f64>,
}

impl Memory {
    /// Threshold and weight of each play.
    pub(crate) fn plays(&self) -> Vec<(f64, f64)> {
        self.r.iter().copied().zip(self.w.iter().copied()).collect()
    }
}
