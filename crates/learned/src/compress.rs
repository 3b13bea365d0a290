//! Fewer centres for the same function: its projection onto the pivots of the kernel matrix.
//!
//! ```text
//! f = Σ α_i k(·, x_i)  →  Σ β_p k(·, x_p),   L_Pᵀ β = Lᵀ α,   K ≈ L·Lᵀ
//! ```
//!
//! It is the best approximation of f on these centres in the norm of the kernel's space. The error
//! falls slowly up to a knee and then fast: choose the number by the error of a simulation
//! ([`Compressor::smallest`]), not by itself.

use crate::lssvm::LsSvm;
use crate::solve::dense::{Mat, divide_transposed};
use crate::solve::kernel::Scaled;
use crate::solve::pivoted::LowRank;

/// A trained machine's centres in the order in which they matter.
pub struct Compressor {
    model: LsSvm,
    low: LowRank,
    /// Lᵀα.
    coefficients: Vec<f64>,
    /// The rows of L on the pivots.
    rows: Mat,
}

impl Compressor {
    /// Orders at most `most` centres.
    #[must_use]
    pub fn new(model: &LsSvm, most: usize) -> Self {
        let scale = vec![1.0 / model.sigma2.sqrt(); model.dimension];
        let points = Scaled::new(&model.centres, model.dimension, &scale);
        let low = LowRank::up_to(&points, 1e-13, most);
        let column =
            |k: usize| low.factor().column(k).iter().zip(&model.weights).map(|(l, a)| l * a).sum();
        let coefficients = (0..low.rank()).map(column).collect();
        let rows = low.rows(&low.pivots);
        Self { model: model.clone(), low, coefficients, rows }
    }

    /// Most centres that [`to`](Self::to) can use.
    #[must_use]
    pub fn most(&self) -> usize {
        self.low.rank()
    }

    /// The projection onto the first `count` centres.
    #[must_use]
    pub fn to(&self, count: usize) -> LsSvm {
        let count = count.min(self.most());
        let mut beta = Mat::from_fn(count, 1, |i, _| self.coefficients[i]);
        divide_transposed(&self.rows.view((0, 0), (count, count)), beta.as_view_mut());
        let d = self.model.dimension;
        let centre = |p: &usize| self.model.centres[p * d..(p + 1) * d].iter().copied();
        LsSvm {
            dimension: d,
            centres: self.low.pivots[..count].iter().flat_map(centre).collect(),
            weights: (0..count).map(|i| beta[(i, 0)]).collect(),
            bias: self.model.bias,
            sigma2: self.model.sigma2,
        }
    }

    /// The projection onto the fewest centres, within a tenth, whose error by `judge` is at most
    /// `limit`; `None` where even the most are not enough.
    pub fn smallest(&self, limit: f64, mut judge: impl FnMut(&LsSvm) -> f64) -> Option<LsSvm> {
        let mut meets = |count: usize| Some(self.to(count)).filter(|model| judge(model) <= limit);
        let (mut enough, mut best) = (self.most(), meets(self.most())?);
        let mut few = 0;
        while enough - few > 1.max(enough / 10) {
            let middle = few + (enough - few) / 2;
            match meets(middle) {
                Some(model) => (enough, best) = (middle, model),
                None => few = middle,
            }
        }
        Some(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lssvm::{Samples, Settings};
    use crate::testing::wave;

    #[test]
    fn a_fraction_of_the_centres_gives_the_same_function() {
        let inputs = wave(600 * 2, 1.3);
        let outputs = inputs.chunks_exact(2).map(|x| (2.0 * x[0]).sin() * x[1]).collect();
        let samples = Samples::new(2, inputs, outputs).unwrap();
        let (model, _) = LsSvm::train(&samples, Settings { gamma: 1e4, sigma2: 1.5 }).unwrap();
        let full = model.kernel_sum();
        let probes = wave(200 * 2, 0.61);
        let judge = |few: &LsSvm| {
            let few = few.kernel_sum();
            let mut room = [0.0; 2];
            let mut error = |z: &[f64]| (few.value(z, &mut room), full.value(z, &mut room));
            let all = probes.chunks_exact(2).map(&mut error);
            all.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let compressor = Compressor::new(&model, 300);
        let small = compressor.smallest(1e-4, judge).unwrap();
        assert!(small.count() < 100, "{}", small.count());
        assert!(judge(&small) <= 1e-4);
        assert!(judge(&compressor.to(20)) > judge(&compressor.to(60)));
        assert!(compressor.smallest(-1.0, judge).is_none());
    }
}
