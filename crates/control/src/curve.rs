//! Maps without memory, sampled: what amplifiers and sensors do at rest, and the way back.

use crate::probe::Probe;

/// Points of a map that is not a straight line.
const POINTS: usize = 129;
/// Largest distance from a straight line, in parts of the height, of what counts as one.
const STRAIGHT: f64 = 1e-6;

/// A map through points, straight between them and beyond.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    pub(crate) at: Vec<f64>,
    pub(crate) value: Vec<f64>,
}

impl Curve {
    /// What changes nothing.
    pub(crate) fn identity() -> Self {
        Self { at: vec![0.0, 1.0], value: vec![0.0, 1.0] }
    }

    /// What a part does at rest between these inputs.
    ///
    /// # Errors
    /// What the model says.
    pub(crate) fn of(probe: &mut Probe, [low, high]: [f64; 2]) -> Result<Self, String> {
        let last = (POINTS - 1) as f64;
        let at: Vec<f64> = (0..POINTS).map(|k| low + (high - low) * k as f64 / last).collect();
        let value = at.iter().map(|u| probe.rest(*u)).collect::<Result<Vec<_>, _>>()?;
        let (first, end) = (value[0], value[POINTS - 1]);
        let line = |k: usize| first + (end - first) * k as f64 / last;
        let height = (end - first).abs();
        let bent = value.iter().enumerate().map(|(k, y)| (y - line(k)).abs()).fold(0.0, f64::max);
        if bent <= STRAIGHT * height {
            return Ok(Self { at: vec![low, high], value: vec![first, end] });
        }
        Ok(Self { at, value })
    }

    /// The map at `u`.
    pub(crate) fn value(&self, u: f64) -> f64 {
        let last = self.at.len() - 1;
        let at = self.at[1..last].partition_point(|x| *x <= u);
        let (x0, x1, y0, y1) = (self.at[at], self.at[at + 1], self.value[at], self.value[at + 1]);
        y0 + (y1 - y0) / (x1 - x0) * (u - x0)
    }

    /// Gain and offset, where it is a straight line.
    pub(crate) fn line(&self) -> Option<(f64, f64)> {
        let (&[x0, x1], &[y0, y1]) = (&self.at[..], &self.value[..]) else { return None };
        let gain = (y1 - y0) / (x1 - x0);
        Some((gain, y0 - gain * x0))
    }

    /// Whether it changes nothing.
    pub(crate) fn is_identity(&self) -> bool {
        let width = self.at[self.at.len() - 1] - self.at[0];
        self.line()
            .is_some_and(|(gain, offset)| (gain - 1.0).abs() < 1e-9 && offset.abs() < 1e-9 * width)
    }

    /// The steepest and the least slope, with the sign of its rise.
    pub(crate) fn slopes(&self) -> (f64, f64) {
        let pairs = self.at.windows(2).zip(self.value.windows(2));
        let slopes = pairs.map(|(x, y)| (y[1] - y[0]) / (x[1] - x[0]));
        slopes.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)))
    }

    /// The way back, where it rises or falls everywhere.
    pub(crate) fn back(&self) -> Option<Self> {
        let (least, greatest) = self.slopes();
        if least > 0.0 {
            return Some(Self { at: self.value.clone(), value: self.at.clone() });
        }
        (greatest < 0.0).then(|| Self {
            at: self.value.iter().rev().copied().collect(),
            value: self.at.iter().rev().copied().collect(),
        })
    }
}
