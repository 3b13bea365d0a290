//! The rows of a least squares whose offset is eliminated.

use crate::methods::{FitContext, Method};

/// The rows of one record, the offset eliminated by taking the weighted mean from both sides.
pub(super) struct Centred {
    columns: Vec<Vec<f64>>,
    target: Vec<f64>,
    /// Of the map behind everything.
    slope: Vec<f64>,
    /// Sum of the slopes' squares; none where the static map is tied to the offset.
    total: Option<f64>,
    means: Vec<f64>,
    target_mean: f64,
}

impl Centred {
    pub(super) fn new(
        method: &dyn Method,
        (scene, shape): (&FitContext, &[f64]),
        columns: Vec<Vec<f64>>,
        output: &[f64],
    ) -> Self {
        let unmapped = method.unmapped(scene, shape, output);
        let (target, slope): (Vec<f64>, Vec<f64>) = match unmapped {
            Some(pairs) => pairs.into_iter().unzip(),
            None => (output.to_vec(), vec![1.0; output.len()]),
        };
        let total = slope.iter().map(|s| s * s).sum();
        let total = (!method.anchored()).then_some(total);
        let (means, target_mean) = (Vec::new(), 0.0);
        let mut all = Self { columns, target, slope, total, means, target_mean };
        all.means = all.columns.iter().map(|c| all.mean(c)).collect();
        all.target_mean = all.mean(&all.target);
        all
    }

    /// The offset of these values.
    fn mean(&self, values: &[f64]) -> f64 {
        let sum = || values.iter().zip(&self.slope).map(|(v, s)| v * s * s).sum::<f64>();
        self.total.map_or(0.0, |total| sum() / total)
    }

    /// The row of the least squares, where the first weight is `least` plus an unknown that is not negative.
    pub(super) fn row(&self, k: usize, least: f64) -> impl Iterator<Item = f64> + '_ {
        let slope = self.slope[k];
        let columns = self.columns.iter().zip(&self.means);
        let columns = columns.map(move |(c, mean)| slope * (c[k] - mean));
        let known = if least > 0.0 { columns.clone().next() } else { None };
        let target = slope * (self.target[k] - self.target_mean);
        columns.chain([target - known.map_or(0.0, |first| least * first)])
    }

    /// Appends what these weights leave of each row; the offset.
    pub(super) fn leave(&self, x: &[f64], least: f64, residual: &mut Vec<f64>) -> f64 {
        let rows = self.target.iter().zip(&self.slope).enumerate();
        let sum = |k: usize| self.columns.iter().zip(x).map(|(c, x)| c[k] * x).sum::<f64>();
        let centred = |k: usize| {
            let columns = self.columns.iter().zip(&self.means).zip(x);
            columns.map(|((c, mean), x)| (c[k] - mean) * x).sum::<f64>()
        };
        // Both are the same numbers but for the last bits. Where a log hardly determines a shape, its search ends
        // elsewhere for other bits, so each kind of method keeps its own.
        if least > 0.0 {
            let left: Vec<f64> = rows.clone().map(|(k, (y, _))| y - sum(k)).collect();
            let offset = self.mean(&left);
            residual.extend(left.iter().map(|e| e - offset));
            return offset;
        }
        residual.extend(rows.map(|(k, (y, slope))| slope * (y - self.target_mean - centred(k))));
        self.target_mean - self.means.iter().zip(x).map(|(mean, x)| mean * x).sum::<f64>()
    }
}
