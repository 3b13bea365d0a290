//! Gaussian process with squared exponential kernel.
//!
//! ```text
//! k(x, x') = σ_f² exp(−½ Σ (x_d − x'_d)²/l_d²),   y = mean + f(x) + noise of variance σ_n²
//! ln p(y) = −½ yᵀC⁻¹y − ½ ln|C| − ½ n ln 2π,      C = K + σ_n² I
//! ```
//!
//! Reference: C. Rasmussen, C. Williams, Gaussian Processes for Machine Learning, MIT Press 2006.

mod ascent;
mod likelihood;

pub use likelihood::{Likelihood, likelihood};

use crate::lssvm::{LsSvm, Samples};
use crate::solve::dense::{Mat, divide, view};
use crate::solve::kernel::Scaled;
use crate::solve::pivoted::LowRank;
use crate::solve::{factorise, solve_factored};
use crate::{Compressor, Deviation, Error, KernelSum};

/// What the centres of a deviation may leave of the kernels, as a part of the noise's variance.
const PART_OF_NOISE: f64 = 0.05;

/// What a kernel needs. With one length it is the same for all inputs; with one per input the
/// marginal likelihood weighs them (ARD).
#[derive(Clone, Debug, PartialEq)]
pub struct Hyperparameters {
    /// σ_f.
    pub signal: f64,
    /// σ_n.
    pub noise: f64,
    /// l_d.
    pub lengths: Vec<f64>,
}

/// How the hyperparameters are sought.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// Where to begin.
    pub start: Hyperparameters,
    /// Most evaluations of the likelihood.
    pub evaluations: usize,
    /// Most samples that the likelihood is computed on: every k-th one. All are trained on.
    pub most_samples: usize,
}

/// A trained process.
#[derive(Clone, Debug)]
pub struct GaussianProcess {
    dimension: usize,
    points: Vec<f64>,
    weights: Vec<f64>,
    mean: f64,
    parameters: Hyperparameters,
    /// Cholesky factor of C, for the variance.
    factor: Vec<f64>,
}

impl Hyperparameters {
    pub(crate) fn check(&self, dimension: usize) -> Result<(), Error> {
        let rule = "must be positive and finite";
        let named = [("signal", self.signal), ("noise", self.noise)];
        let lengths = self.lengths.iter().map(|l| ("length", *l));
        for (name, value) in named.into_iter().chain(lengths) {
            // Also refuses NaN.
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::Setting { name, value, rule });
            }
        }
        if self.lengths.len() != 1 && self.lengths.len() != dimension {
            let value = self.lengths.len() as f64;
            let rule = "lengths; give one, or one for each input";
            return Err(Error::Setting { name: "number of lengths", value, rule });
        }
        Ok(())
    }

    fn length(&self, k: usize) -> f64 {
        self.lengths.get(k).or(self.lengths.first()).copied().unwrap_or(1.0)
    }

    /// What the inputs are multiplied with, so that the kernel is exp(−‖·‖²).
    fn scale(&self, dimension: usize) -> Vec<f64> {
        (0..dimension).map(|k| core::f64::consts::FRAC_1_SQRT_2 / self.length(k)).collect()
    }
}

impl GaussianProcess {
    /// Trains with given hyperparameters.
    ///
    /// # Errors
    /// [`Error::Setting`], [`Error::IllPosed`], [`Error::Unconverged`].
    pub fn train(samples: &Samples, parameters: &Hyperparameters) -> Result<Self, Error> {
        let (n, d) = (samples.count(), samples.dimension());
        parameters.check(d)?;
        let points = Scaled::new(samples.inputs(), d, &parameters.scale(d));
        let mean = samples.outputs().iter().sum::<f64>() / n as f64;
        let y: Vec<f64> = samples.outputs().iter().map(|y| y - mean).collect();
        let lambda = (parameters.noise / parameters.signal).powi(2);
        let mut factor = vec![0.0; n * n];
        points.fill_lower(&mut factor);
        factorise(&mut factor, n, lambda)?;
        let mut weights = y.clone();
        solve_factored(&factor, n, &mut weights);
        let rest = |weights: &[f64]| -> Vec<f64> {
            points.products([weights, weights], lambda)[0]
                .iter()
                .zip(&y)
                .map(|(p, y)| y - p)
                .collect()
        };
        let mut change = rest(&weights);
        solve_factored(&factor, n, &mut change);
        weights.iter_mut().zip(&change).for_each(|(w, c)| *w += c);
        let size = y.iter().map(|y| y * y).sum::<f64>().max(f64::MIN_POSITIVE);
        let residual = (rest(&weights).iter().map(|r| r * r).sum::<f64>() / size).sqrt();
        let limit = crate::lssvm::MOST_RESIDUAL;
        if residual.is_nan() || residual > limit {
            return Err(Error::Unconverged { residual, limit, lambda });
        }
        let (points, parameters) = (samples.inputs().to_vec(), parameters.clone());
        Ok(Self { dimension: d, points, weights, mean, parameters, factor })
    }

    /// Seeks the hyperparameters of greatest marginal likelihood, then trains on all samples.
    ///
    /// # Errors
    /// [`Error::Setting`], [`Error::IllPosed`], [`Error::Unconverged`].
    pub fn learn(samples: &Samples, search: &Search) -> Result<(Self, Likelihood), Error> {
        let few = samples.subset(&samples.rows_at_most(search.most_samples.max(2)));
        let found = ascent::ascend(&few, &search.start, search.evaluations)?;
        Ok((Self::train(samples, &found.parameters)?, found))
    }

    /// The hyperparameters.
    #[must_use]
    pub fn parameters(&self) -> &Hyperparameters {
        &self.parameters
    }

    /// The mean prediction, ready to be evaluated.
    #[must_use]
    pub fn kernel_sum(&self) -> KernelSum {
        let sigma: Vec<f64> =
            self.parameters.scale(self.dimension).iter().map(|s| 1.0 / s).collect();
        KernelSum::new(self.dimension, &self.points, &self.weights, &sigma, self.mean)
    }

    /// The variance of the noise-free prediction at `z`.
    #[must_use]
    pub fn variance(&self, z: &[f64]) -> f64 {
        let n = self.weights.len();
        let scale = self.parameters.scale(self.dimension);
        let kernel = |i: usize| {
            let x = &self.points[i * self.dimension..(i + 1) * self.dimension];
            let squares = x.iter().zip(z).zip(&scale).map(|((x, z), s)| ((x - z) * s).powi(2));
            libm::exp(-squares.sum::<f64>())
        };
        let mut column = Mat::from_fn(n, 1, |i, _| kernel(i));
        divide(&view(&self.factor, n, n), column.as_view_mut());
        let explained = column.norm_squared();
        self.parameters.signal.powi(2) * (1.0 - explained).max(0.0)
    }

    /// The deviation on at most so many of the samples: those that say most of the others, until what they leave is
    /// a twentieth of the noise's variance.
    ///
    /// # Errors
    /// [`Error::IllPosed`].
    pub fn deviation(&self, most: usize) -> Result<Deviation, Error> {
        let (d, scales) = (self.dimension, self.scales());
        let points = Scaled::new(&self.points, d, &scales);
        let lambda = (self.parameters.noise / self.parameters.signal).powi(2);
        let low = LowRank::up_to(&points, PART_OF_NOISE * lambda, most);
        let count = low.rank();
        let own = low.rows(&low.pivots);
        let product = low.factor().transpose() * low.factor();
        let mut evidence: Vec<f64> =
            (0..count * count).map(|at| product[(at % count, at / count)] / lambda).collect();
        factorise(&mut evidence, count, 1.0)?;
        let triangle = |at: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..count).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect()
        };
        let kernels = triangle(&|i, j| own[(i, j)]);
        let evidence = triangle(&|i, j| evidence[j * count + i]);
        let centres: Vec<f64> = low.pivots.iter().flat_map(|i| points.point(*i)).copied().collect();
        Ok(Deviation::new(&scales, centres, kernels, evidence))
    }

    /// The mean as a machine over inputs that are divided by √2 l, so that it can be compressed: its
    /// σ² is 1.
    #[must_use]
    pub fn scaled_machine(&self) -> LsSvm {
        let scale = self.parameters.scale(self.dimension);
        let centres = self.points.iter().enumerate().map(|(i, x)| x * scale[i % self.dimension]);
        LsSvm {
            dimension: self.dimension,
            centres: centres.collect(),
            weights: self.weights.clone(),
            bias: self.mean,
            sigma2: 1.0,
        }
    }

    /// The mean's compressed forms, over inputs divided by √2 l ([`scales`](Self::scales)).
    #[must_use]
    pub fn compressor(&self, most: usize) -> Compressor {
        Compressor::new(&self.scaled_machine(), most)
    }

    /// What inputs are multiplied with for [`scaled_machine`](Self::scaled_machine).
    #[must_use]
    pub fn scales(&self) -> Vec<f64> {
        self.parameters.scale(self.dimension)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wave;

    fn samples(n: usize) -> Samples {
        let inputs = wave(n * 2, 1.3);
        let outputs = inputs.chunks_exact(2).map(|x| 3.0 + (3.0 * x[0]).sin() + 0.1 * x[1]);
        let outputs = outputs.zip(wave(n, 0.77)).map(|(y, e)| y + 0.02 * e).collect();
        Samples::new(2, inputs, outputs).unwrap()
    }

    fn start(lengths: Vec<f64>) -> Hyperparameters {
        Hyperparameters { signal: 1.0, noise: 0.1, lengths }
    }

    #[test]
    fn the_likelihood_rises_and_the_noise_is_found() {
        let samples = samples(200);
        let before = likelihood(&samples, &start(vec![1.0, 1.0])).unwrap();
        let search = Search { start: start(vec![1.0, 1.0]), evaluations: 60, most_samples: 1000 };
        let (process, after) = GaussianProcess::learn(&samples, &search).unwrap();
        assert!(after.value > before.value + 10.0, "{} {}", after.value, before.value);
        // 0.02 · rms of the stand-in for noise, which is 1/√2.
        let noise = process.parameters().noise;
        assert!((0.009..0.02).contains(&noise), "{noise}");
        // The second input matters less.
        let lengths = &process.parameters().lengths;
        assert!(lengths[1] > 2.0 * lengths[0], "{lengths:?}");
        let (f, mut room) = (process.kernel_sum(), [0.0; 2]);
        let error = f.value(&[0.2, 0.3], &mut room) - (3.0 + 0.6_f64.sin() + 0.03);
        assert!(error.abs() < 0.02, "{error}");
    }

    #[test]
    fn the_variance_is_small_at_the_data_and_the_signal_s_far_away() {
        let process = GaussianProcess::train(&samples(100), &start(vec![0.5])).unwrap();
        assert!(process.variance(&[0.1, 0.1]) < 0.02);
        assert!((process.variance(&[50.0, 0.0]) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_deviation_on_few_samples_is_that_of_the_process() {
        let process = GaussianProcess::train(&samples(300), &start(vec![0.7, 1.1])).unwrap();
        let deviation = process.deviation(300).unwrap();
        assert!(deviation.count() < 100, "{}", deviation.count());
        let widths: Vec<f64> = process.scales().iter().map(|s| 1.0 / s).collect();
        let count = deviation.count();
        let again = Deviation::of_table(&deviation.table(&widths), count, &widths).unwrap();
        let few = process.deviation(8).unwrap();
        assert_eq!(few.count(), 8);
        let mut room = vec![0.0; count];
        let mut most = 0.0_f64;
        let noise2 = process.parameters().noise.powi(2);
        for k in 0..200 {
            // The samples lie within 1: beyond, the centres stand for less of the others.
            let (reach, part) = if k % 2 == 0 { (1.0, 0.05) } else { (1.5, 0.25) };
            let [a, b] = [libm::sin(0.7 * f64::from(k)), libm::cos(1.1 * f64::from(k))];
            let z = [reach * a, reach * b];
            let exact = process.variance(&z);
            let found = deviation.left(&z, &mut room);
            let apart = (found - exact).abs();
            assert!(apart < part * (noise2 + exact), "{z:?}: {found} {exact}");
            assert!((again.left(&z, &mut room) - found).abs() < 1e-9);
            // Too few centres do not know what the samples say.
            most = most.max(few.left(&z, &mut room) - exact);
        }
        assert!(most > 0.2, "{most}");
        assert!((deviation.left(&[50.0, 0.0], &mut room) - 1.0).abs() < 1e-12);
        let broken = vec![0.0; deviation.table(&widths).len()];
        assert!(Deviation::of_table(&broken, count, &widths).unwrap_err().contains("diagonal"));
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let samples = samples(60);
        for lengths in [vec![0.7], vec![0.7, 1.4]] {
            let at = start(lengths);
            let full = likelihood(&samples, &at).unwrap();
            for k in 0..full.gradient.len() {
                let moved = |step: f64| {
                    let mut p = at.clone();
                    let slot = match k {
                        0 => &mut p.signal,
                        1 => &mut p.noise,
                        _ => &mut p.lengths[k - 2],
                    };
                    *slot *= step.exp();
                    likelihood(&samples, &p).unwrap().value
                };
                let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                let found = full.gradient[k];
                assert!(
                    (found - expected).abs() < 1e-4 * expected.abs().max(1.0),
                    "{k}: {found} {expected}"
                );
            }
        }
    }
}
