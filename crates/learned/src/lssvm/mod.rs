//! Least-squares support vector machine with bias and radial basis kernel.
//!
//! ```text
//! f(x) = b + Σ α_i exp(−‖x_i − x‖²/σ²),   [0 1ᵀ; 1 Ω + I/γ] [b; α] = [0; y]
//! ```
//!
//! Reference: J. Suykens, T. Van Gestel, J. De Brabanter, B. De Moor, J. Vandewalle, Least Squares
//! Support Vector Machines, World Scientific 2002. (LS-SVMlab writes exp(−‖·‖²/(2σ²)).)

mod bordered;
mod folds;
mod low_rank;
mod prune;
mod settings;
mod validate;

pub use folds::Folds;
pub use prune::{Pruned, Pruning, Round, prune};
pub use settings::Settings;
pub use validate::{FoldModel, Validation, leave_one_out};

use crate::solve::kernel::Scaled;
use crate::solve::{Route, solve};
use crate::{Error, KernelSum};

/// Greatest exact residual, relative to the outputs about their mean, of a training that counts.
pub const MOST_RESIDUAL: f64 = 1e-6;

/// Samples: inputs of `dimension` numbers one after the other, and one output for each.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    dimension: usize,
    inputs: Vec<f64>,
    outputs: Vec<f64>,
}

impl Samples {
    /// Checks them.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::TooFew`] below two, [`Error::NotFinite`].
    pub fn new(dimension: usize, inputs: Vec<f64>, outputs: Vec<f64>) -> Result<Self, Error> {
        if dimension == 0 || inputs.len() != dimension * outputs.len() {
            let (inputs, outputs) = (inputs.len(), outputs.len());
            return Err(Error::Shape { inputs, dimension, outputs });
        }
        if outputs.len() < 2 {
            return Err(Error::TooFew { found: outputs.len(), needed: 2 });
        }
        for (what, values) in [("input number", &inputs), ("output number", &outputs)] {
            if let Some(index) = values.iter().position(|x| !x.is_finite()) {
                return Err(Error::NotFinite { what, index, value: values[index] });
            }
        }
        Ok(Self { dimension, inputs, outputs })
    }

    /// Number of samples.
    #[must_use]
    pub fn count(&self) -> usize {
        self.outputs.len()
    }
    /// Numbers of one input.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.dimension
    }
    /// All inputs, one after the other.
    #[must_use]
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }
    /// One input.
    #[must_use]
    pub fn input(&self, index: usize) -> &[f64] {
        &self.inputs[index * self.dimension..(index + 1) * self.dimension]
    }
    /// All outputs.
    #[must_use]
    pub fn outputs(&self) -> &[f64] {
        &self.outputs
    }

    /// Rows of every k-th sample, at most `most` of them.
    #[must_use]
    pub fn rows_at_most(&self, most: usize) -> Vec<usize> {
        let every = self.count().div_ceil(most.max(1)).max(1);
        (0..self.count()).step_by(every).collect()
    }

    /// The samples with these indices, in this order.
    #[must_use]
    pub fn subset(&self, indices: &[usize]) -> Self {
        Self {
            dimension: self.dimension,
            inputs: indices.iter().flat_map(|i| self.input(*i).iter().copied()).collect(),
            outputs: indices.iter().map(|i| self.outputs[*i]).collect(),
        }
    }

    pub(crate) fn scaled(&self, sigma2: f64) -> Scaled {
        Scaled::new(&self.inputs, self.dimension, &vec![1.0 / sigma2.sqrt(); self.dimension])
    }
}

/// A trained machine: its support vectors are the samples it was trained on, or those that are left.
#[derive(Clone, Debug, PartialEq)]
pub struct LsSvm {
    /// Numbers of one input.
    pub dimension: usize,
    /// Support vectors, one after the other.
    pub centres: Vec<f64>,
    /// α.
    pub weights: Vec<f64>,
    /// b.
    pub bias: f64,
    /// σ².
    pub sigma2: f64,
}

/// What a training says about itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// How the system was solved.
    pub route: Route,
    /// ‖(Ω + I/γ)·α + b·1 − y‖ / ‖y − mean‖, with kernels computed anew.
    pub residual: f64,
}

impl LsSvm {
    /// Trains on all samples with `γ` and `σ²`.
    ///
    /// # Errors
    /// [`Error::Setting`] for a γ or σ² that is not positive, [`Error::IllPosed`],
    /// [`Error::Unconverged`] where the exact residual is above [`MOST_RESIDUAL`].
    pub fn train(samples: &Samples, settings: Settings) -> Result<(Self, Report), Error> {
        settings.check()?;
        let lambda = 1.0 / settings.gamma;
        let points = samples.scaled(settings.sigma2);
        let y = samples.outputs();
        let ones = vec![1.0; samples.count()];
        let solved = solve(&points, lambda, [y, &ones])?;
        let [a, c] = solved.x;
        let bias = a.iter().sum::<f64>() / c.iter().sum::<f64>();
        let weights: Vec<f64> = a.iter().zip(&c).map(|(a, c)| a - bias * c).collect();
        let residual = residual(&points, lambda, &weights, bias, y);
        // A NaN is no solution either.
        if residual.is_nan() || residual > MOST_RESIDUAL {
            return Err(Error::Unconverged { residual, limit: MOST_RESIDUAL, lambda });
        }
        let model = Self {
            dimension: samples.dimension(),
            centres: samples.inputs().to_vec(),
            weights,
            bias,
            sigma2: settings.sigma2,
        };
        Ok((model, Report { route: solved.route, residual }))
    }

    /// Number of support vectors.
    #[must_use]
    pub fn count(&self) -> usize {
        self.weights.len()
    }

    /// The model ready to be evaluated.
    #[must_use]
    pub fn kernel_sum(&self) -> KernelSum {
        let sigma = [self.sigma2.sqrt()];
        KernelSum::new(self.dimension, &self.centres, &self.weights, &sigma, self.bias)
    }
}

/// ‖(K + λ)α + b − y‖ / ‖y − mean‖; relative to the outputs' size where they do not vary.
fn residual(points: &Scaled, lambda: f64, weights: &[f64], bias: f64, y: &[f64]) -> f64 {
    let [product, _] = points.products([weights, weights], lambda);
    let rest: f64 = product.iter().zip(y).map(|(p, y)| (p + bias - y).powi(2)).sum();
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let spread: f64 = y.iter().map(|y| (y - mean).powi(2)).sum();
    let size: f64 = y.iter().map(|y| y * y).sum();
    let scale = if spread > 1e-20 * size { spread } else { size.max(f64::MIN_POSITIVE) };
    (rest / scale).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wave;

    pub(crate) fn samples(n: usize, d: usize) -> Samples {
        let inputs = wave(n * d, 1.3);
        let f = |x: &[f64]| (2.0 * x[0]).sin() + 0.3 * x.iter().map(|x| x * x).sum::<f64>();
        let outputs = inputs.chunks_exact(d).map(f).collect();
        Samples::new(d, inputs, outputs).unwrap()
    }

    #[test]
    fn the_kkt_system_holds() {
        for n in [40, 500] {
            let samples = samples(n, 2);
            let settings = Settings { gamma: 1e3, sigma2: 0.8 };
            let (model, report) = LsSvm::train(&samples, settings).unwrap();
            assert!(report.residual < 1e-8, "{report:?}");
            let sum: f64 = model.weights.iter().sum();
            let size: f64 = model.weights.iter().map(|w| w.abs()).sum();
            assert!(sum.abs() < 1e-6 * size, "{sum} {size}");
            // y − f(x) = α/γ.
            let (f, mut room) = (model.kernel_sum(), [0.0; 2]);
            for i in 0..n {
                let error = samples.outputs()[i] - f.value(samples.input(i), &mut room);
                assert!((error - model.weights[i] / 1e3).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn what_cannot_be_trained_is_an_error() {
        assert!(matches!(Samples::new(2, vec![0.0; 3], vec![0.0]), Err(Error::Shape { .. })));
        let broken = Samples::new(1, vec![0.0, f64::NAN], vec![0.0, 1.0]);
        assert!(matches!(broken, Err(Error::NotFinite { index: 1, .. })));
        let twice = Samples::new(1, vec![0.5; 50], wave(50, 0.4)).unwrap();
        let hopeless = LsSvm::train(&twice, Settings { gamma: 1e18, sigma2: 1.0 });
        assert!(
            matches!(hopeless, Err(Error::IllPosed { .. } | Error::Unconverged { .. })),
            "{hopeless:?}"
        );
        for (gamma, sigma2) in [(0.0, 1.0), (1.0, -1.0), (f64::NAN, 1.0)] {
            let result = LsSvm::train(&twice, Settings { gamma, sigma2 });
            assert!(matches!(result, Err(Error::Setting { .. })));
        }
    }
}
