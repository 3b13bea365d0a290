//! Cubic splines over even knots.

use nalgebra::DMatrix;

/// How far the knots reach beyond the samples, in parts of their range.
const BEYOND: f64 = 0.3;

/// The knots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knots {
    low: f64,
    width: f64,
    intervals: usize,
}

impl Knots {
    /// So many intervals over the range of these samples and some way beyond.
    pub(super) fn about(samples: impl Iterator<Item = f64> + Clone, intervals: usize) -> Self {
        let low = samples.clone().fold(f64::INFINITY, f64::min);
        let high = samples.fold(f64::NEG_INFINITY, f64::max);
        let reach = BEYOND * (high - low).max(1e-9);
        let width = (high - low + 2.0 * reach) / intervals as f64;
        Self { low: low - reach, width, intervals }
    }

    /// Number of splines.
    pub(super) fn count(self) -> usize {
        self.intervals + 3
    }

    /// Adds to the normal equations, whose first columns are these splines, the squares of their curvature and of
    /// themselves, weighed: those without samples are determined by their neighbours, and at the ends by the latter.
    pub(super) fn stiffen(self, normal: &mut DMatrix<f64>, curvature: f64, size: f64) {
        for k in 0..self.count() - 2 {
            for (i, a) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                for (j, b) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                    normal[(k + i, k + j)] += curvature * a * b;
                }
            }
        }
        for k in 0..self.count() {
            normal[(k, k)] += size;
        }
    }

    /// Number of the first of the four splines that are not 0 at x, their values and slopes.
    pub(super) fn at(self, x: f64) -> (usize, [f64; 4], [f64; 4]) {
        let place = ((x - self.low) / self.width).clamp(0.0, self.intervals as f64 - 1e-9);
        let first = place as usize;
        let t = place - first as f64;
        let s = 1.0 - t;
        let values = [
            s * s * s / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
            t * t * t / 6.0,
        ];
        let slopes = [
            -s * s / 2.0,
            (3.0 * t * t - 4.0 * t) / 2.0,
            (4.0 * s - 3.0 * s * s) / 2.0,
            t * t / 2.0,
        ];
        (first, values, slopes.map(|slope| slope / self.width))
    }
}
