//! The function that every learned model here is: a bias and a weighted sum of kernels.

use pulp::{Arch, Simd, WithSimd};

use crate::simd::{Block, LANES, distance4, distance8, exp4, groups, minus4};

/// `f(z) = bias + Σ w_i exp(−‖x_i − z‖²/σ²)`, ready to be evaluated: no allocation, no branch, vectors
/// as wide as the machine has them.
#[derive(Clone, Debug)]
pub struct KernelSum {
    /// Centres divided by σ: for each 32 of them one block per coordinate.
    centres: Vec<Block>,
    weights: Vec<Block>,
    scale: Vec<f64>,
    dimension: usize,
    count: usize,
    bias: f64,
    arch: Arch,
}

impl KernelSum {
    /// `centres` holds one point after the other, `dimension` numbers each; as many `weights`.
    ///
    /// One σ for every coordinate, or one for all of them. Points that are incomplete are left out.
    #[must_use]
    pub fn new(
        dimension: usize,
        centres: &[f64],
        weights: &[f64],
        sigma: &[f64],
        bias: f64,
    ) -> Self {
        let sigma = |k: usize| sigma.get(k).or(sigma.first()).copied().unwrap_or(1.0);
        let scale: Vec<f64> = (0..dimension).map(|k| 1.0 / sigma(k)).collect();
        let count = weights.len().min(centres.len() / dimension.max(1));
        let mut sum = Self {
            centres: blocks(dimension, count, |i, k| centres[i * dimension + k] * scale[k]),
            weights: blocks(1, count, |i, _| weights[i]),
            scale,
            dimension,
            count,
            bias,
            arch: Arch::new(),
        };
        sum.weights.shrink_to_fit();
        sum
    }

    /// Number of coordinates.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of centres.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The value at `z`. `room` holds at least as many numbers as `z`; it is overwritten.
    ///
    /// Coordinates that are missing count as 0, further ones are left out.
    #[must_use]
    pub fn value(&self, z: &[f64], room: &mut [f64]) -> f64 {
        let count = room.len().min(self.dimension);
        let scaled = &mut room[..count];
        for (k, scaled) in scaled.iter_mut().enumerate() {
            *scaled = z.get(k).copied().unwrap_or(0.0) * self.scale[k];
        }
        let job =
            Value { centres: &self.centres, weights: &self.weights, z: scaled, d: self.dimension };
        self.bias + dispatch(self.arch, job)
    }

    /// 1/σ of each coordinate.
    #[must_use]
    pub fn scale(&self) -> &[f64] {
        &self.scale
    }
}

/// Runs on the vectors of this machine; inside WebAssembly on single numbers, so that its C needs no header
/// for vectors and gives the same bits everywhere.
#[inline(always)]
fn dispatch<J: WithSimd>(arch: Arch, job: J) -> J::Output {
    #[cfg(target_family = "wasm")]
    {
        let _ = arch;
        job.with_simd(pulp::Scalar)
    }
    #[cfg(not(target_family = "wasm"))]
    arch.dispatch(job)
}

/// Blocks of 32 points, coordinate by coordinate; the last one is filled up with zeros.
pub(crate) fn blocks(d: usize, n: usize, at: impl Fn(usize, usize) -> f64) -> Vec<Block> {
    let mut all = vec![Block::ZERO; n.div_ceil(LANES) * d];
    for i in 0..n {
        for k in 0..d {
            all[i / LANES * d + k].0[i % LANES] = at(i, k);
        }
    }
    all
}

/// Coordinates from which two groups are summed at once: 15 % less time for 57 of them, 5 % more for 6.
const TOGETHER: usize = 16;

/// The weighted sum of kernels at a scaled point.
pub(crate) struct Value<'a> {
    pub(crate) centres: &'a [Block],
    pub(crate) weights: &'a [Block],
    pub(crate) z: &'a [f64],
    pub(crate) d: usize,
}

impl WithSimd for Value<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) -> f64 {
        let mut sum = [s.splat_f64s(0.0); 4];
        for (rows, weights) in self.centres.chunks_exact(self.d.max(1)).zip(self.weights) {
            let weights = S::as_simd_f64s(&weights.0).0;
            for h in (0..groups::<S>()).step_by(2) {
                // A block of the widest machine is one group. No closures here: they are not compiled for it.
                let pair = if groups::<S>() > 1 && self.d >= TOGETHER {
                    distance8(s, rows, self.z, h)
                } else {
                    let low = distance4(s, rows, self.z, h);
                    let is_last = groups::<S>() == 1;
                    [low, if is_last { low } else { distance4(s, rows, self.z, h + 1) }]
                };
                for (g, distance) in pair.into_iter().enumerate().take(groups::<S>()) {
                    let e = exp4(s, minus4(s, distance));
                    for i in 0..4 {
                        sum[i] = s.mul_add_e_f64s(weights[4 * (h + g) + i], e[i], sum[i]);
                    }
                }
            }
        }
        let [a, b, c, d] = sum;
        s.reduce_sum_f64s(s.add_f64s(s.add_f64s(a, b), s.add_f64s(c, d)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_sum_of_the_kernels_for_every_number_of_centres() {
        for (n, d) in [(0, 2), (1, 1), (31, 3), (32, 6), (33, 2), (551, 6)] {
            let centres: Vec<f64> = (0..n * d).map(|i| libm::sin(1.7 * i as f64)).collect();
            let weights: Vec<f64> = (0..n).map(|i| libm::cos(0.9 * i as f64)).collect();
            let sigma: Vec<f64> = (0..d).map(|k| 0.7 + 0.3 * k as f64).collect();
            let sum = KernelSum::new(d, &centres, &weights, &sigma, 0.25);
            let z: Vec<f64> = (0..d).map(|k| 0.3 - 0.1 * k as f64).collect();
            let kernel = |i: usize| {
                let squares =
                    (0..d).map(|k| ((centres[i * d + k] - z[k]) / sigma[k]).powi(2)).sum::<f64>();
                weights[i] * libm::exp(-squares)
            };
            let expected = 0.25 + (0..n).map(kernel).sum::<f64>();
            let value = sum.value(&z, &mut vec![0.0; d]);
            assert!((value - expected).abs() < 1e-12, "{n} × {d}: {value} {expected}");
            assert_eq!((sum.count(), sum.dimension()), (n, d));
        }
    }
}
