//! Steps in which a reading moves, seen from its values alone.
//!
//! A converter behind the noise gives values on a grid `q·(n + p)`. Where the noise is clearly smaller than the step the
//! reading stands still while the machine rests, and jumps by whole steps. What is rounded is off by q/√12 then, whatever the
//! model: no fit shows the steps better than the values do.

use components::linear::quantise;

use crate::data_set::DataSet;
use crate::score::Judged;
use crate::thresholds::noise::Thresholds;

/// The steps of a reading, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steps {
    /// Step q.
    pub(crate) size: f64,
    /// Phase p.
    pub(crate) phase: f64,
    /// Standard deviation of the noise before the rounding, about.
    pub(crate) beside: f64,
}

impl Steps {
    /// The steps of the reading in these rows, where they are seen.
    pub(crate) fn of(data: &DataSet) -> Option<Self> {
        let (size, phase) = grid(&data.y)?;
        let mut moved: Vec<f64> = data
            .records
            .iter()
            .flat_map(|record| data.y[record.rows.clone()].chunks_exact(Thresholds::STRETCH_ROWS))
            .map(|part| {
                let moves = part.windows(2).filter(|w| (w[1] - w[0]).abs() > 0.5 * size).count();
                moves as f64 / (Thresholds::STRETCH_ROWS - 1) as f64
            })
            .collect();
        moved.sort_by(f64::total_cmp);
        // Of rows at rest under noise of σ the part 2σ/(√π·q) is another one than the row before.
        let moved = *moved.get(moved.len() / 4)?;
        let beside =
            (0.5 * std::f64::consts::PI.sqrt() * moved * size).max(Thresholds::GRID_OFF * size);
        (moved < 1.0 - Thresholds::STRETCH_REPEATED).then_some(Self { size, phase, beside })
    }

    /// With this noise before the rounding.
    pub(crate) fn with_noise(self, beside: f64) -> Self {
        Self { beside, ..self }
    }

    /// Standard deviation of what rounding does alone.
    pub(crate) fn rounding(&self) -> f64 {
        self.size / 12f64.sqrt()
    }

    /// Standard deviation of rounding with the noise before it.
    pub(crate) fn sigma(&self) -> f64 {
        self.rounding().hypot(self.beside)
    }

    /// Part of what is left (in this standard deviation) that rounding is, at most 1.
    pub(crate) fn share(&self, left: &Judged, sigma: f64) -> f64 {
        let left = left.held_out.max(left.training) * sigma * sigma;
        (self.rounding().powi(2) / left.max(f64::MIN_POSITIVE)).min(1.0)
    }

    /// Measured less rounded, where `residual` is measured less simulated.
    pub(crate) fn left(&self, y: &[f64], residual: &[f64]) -> Vec<f64> {
        let round = |x: f64| quantise(x, self.size, self.phase);
        y.iter().zip(residual).map(|(y, r)| y - round(y - r)).collect()
    }
}

/// Step and phase of the grid on which values lie.
fn grid(values: &[f64]) -> Option<(f64, f64)> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let far = sorted.first()?.abs().max(sorted.last()?.abs());
    let near = Thresholds::SINGLE_PRECISION * far;
    let mut levels: Vec<f64> = Vec::new();
    for value in &sorted {
        if levels.last().is_none_or(|last| value - last > near) {
            levels.push(*value);
            if levels.len() * Thresholds::GRID_ROWS > values.len() {
                return None;
            }
        }
    }
    if levels.len() < Thresholds::GRID_LEVELS {
        return None;
    }
    let mut gaps: Vec<f64> = levels.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    let first = gaps[gaps.len() / 4];
    // From level to level, so that a small error of the step does not grow over many.
    let mut number = 0.0;
    let numbers: Vec<f64> = std::iter::once(0.0)
        .chain(levels.windows(2).map(|w| {
            number += ((w[1] - w[0]) / first).round();
            number
        }))
        .collect();
    let n = levels.len() as f64;
    let (mean_k, mean_y) = (numbers.iter().sum::<f64>() / n, levels.iter().sum::<f64>() / n);
    let pairs = || numbers.iter().zip(&levels).map(|(k, y)| (k - mean_k, y - mean_y));
    let size = pairs().map(|(k, y)| k * y).sum::<f64>() / pairs().map(|(k, _)| k * k).sum::<f64>();
    if !(size.is_finite() && size > Thresholds::GRID_STEP * near) {
        return None;
    }
    let phase = ((mean_y - size * mean_k) / size).rem_euclid(1.0);
    let is_off = |y: &&f64| {
        let place = *y / size - phase;
        (place - place.round()).abs() > Thresholds::GRID_OFF
    };
    let stray = values.iter().filter(is_off).count() as f64;
    (stray <= Thresholds::GRID_STRAY * values.len() as f64).then_some((size, phase))
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::*;
    use crate::data_set::RecordRows;

    const STEP: f64 = 0.37;
    const PHASE: f64 = 0.3;

    /// A slow reading of noise σ in steps.
    fn reading(sigma: f64) -> DataSet {
        let mut random = SplitMix64::new(11);
        let mut noise = || (0..12).map(|_| random.uniform()).sum::<f64>() - 6.0;
        let smooth = |k: usize| 9.0 * (k as f64 * 1e-3).sin();
        let round = |x: f64| f64::from((STEP * ((x / STEP - PHASE).round() + PHASE)) as f32);
        let y: Vec<f64> = (0..8000).map(|k| round(smooth(k) + sigma * noise())).collect();
        DataSet::new(vec![RecordRows { y, ..RecordRows::still(8000, 0.7) }], &[], None)
    }

    #[test]
    fn steps_of_single_precision_are_seen_where_they_are_larger_than_the_noise() {
        for part in [0.02, 0.1, 0.2] {
            let seen = Steps::of(&reading(part * STEP)).unwrap();
            assert!((seen.size / STEP - 1.0).abs() < 1e-5, "{part}: {seen:?}");
            assert!((seen.phase - PHASE).abs() < 0.01, "{part}: {seen:?}");
            assert!(seen.beside < 0.35 * STEP, "{part}: {seen:?}");
        }
        assert_eq!(Steps::of(&reading(STEP)), None, "hidden in the noise");
    }

    #[test]
    fn a_reading_without_steps_has_none() {
        let mut data = reading(0.1);
        for (k, y) in data.y.iter_mut().enumerate() {
            *y += 1e-3 * (k as f64 * 0.7).sin();
        }
        assert_eq!(Steps::of(&data), None);
    }

    #[test]
    fn what_is_rounded_as_the_reading_leaves_nothing() {
        let data = reading(0.0);
        let steps = Steps::of(&data).unwrap();
        let residual: Vec<f64> =
            data.y.iter().enumerate().map(|(k, y)| y - 9.0 * (k as f64 * 1e-3).sin()).collect();
        let left = steps.left(&data.y, &residual);
        let off = left.iter().filter(|r| r.abs() > 1e-3).count();
        assert!(off < 20, "{off}");
    }
}
