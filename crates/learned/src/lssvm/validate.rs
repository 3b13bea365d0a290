//! Cross-validation without training each fold from the start.
//!
//! A smooth kernel has a low rank: each fold is r × r algebra. Otherwise all folds come from one
//! inverse. Both give what training each fold would.

use crate::Error;
use crate::lssvm::bordered::{Bordered, held_out_errors};
use crate::lssvm::low_rank::Sums;
use crate::lssvm::{Folds, LsSvm, Samples, Settings};
use crate::solve::kernel::{Scaled, kernels_of_distances};
use crate::solve::pivoted::LowRank;

/// Samples in parts. Distances are computed once for all σ².
pub struct Validation {
    /// In the order of the parts.
    samples: Samples,
    ranges: Vec<std::ops::Range<usize>>,
    order: Vec<usize>,
    /// Lower half of the squared distances.
    distances: Vec<f64>,
}

/// A model that does not know some samples, and their indices.
pub type FoldModel<'a> = (LsSvm, &'a [usize]);

/// Remainder of a factor, as a part of λ.
const TOLERANCE: f64 = 1e-7;

/// Remainder of the errors that a search looks at, as a part of λ.
const TOLERANCE_OF_SEARCH: f64 = 1e-6;

impl Validation {
    /// Prepares the samples.
    ///
    /// # Errors
    /// [`Error::TooFew`] where there are not two parts with samples.
    pub fn new(samples: &Samples, folds: &Folds) -> Result<Self, Error> {
        let (order, ranges) = folds.order();
        let filled = ranges.iter().filter(|r| !r.is_empty()).count();
        if filled < 2 || order.iter().any(|i| *i >= samples.count()) {
            return Err(Error::TooFew { found: filled, needed: 2 });
        }
        Ok(Self { samples: samples.subset(&order), ranges, order, distances: Vec::new() })
    }

    /// Number of parts.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.ranges.len()
    }

    fn points(&self, sigma2: f64) -> Scaled {
        self.samples.scaled(sigma2)
    }

    fn omega(&mut self, sigma2: f64) -> Vec<f64> {
        let n = self.samples.count();
        if self.distances.is_empty() {
            self.distances = vec![0.0; n * n];
            self.points(1.0).fill_distances(&mut self.distances);
        }
        let mut omega = vec![0.0; n * n];
        kernels_of_distances(&self.distances, n, 1.0 / sigma2, &mut omega);
        omega
    }

    /// A factor for all these γ, where it is cheaper than the whole matrix.
    fn low_rank(&self, sigma2: f64, largest_gamma: f64, part: f64) -> Option<LowRank> {
        let most = self.samples.count() / 3;
        LowRank::until(&self.points(sigma2), part / largest_gamma, most)
    }

    /// Mean square of the errors one step ahead over all parts, for each γ at one σ².
    ///
    /// # Errors
    /// [`Error::Setting`], [`Error::IllPosed`].
    pub fn one_step(&mut self, sigma2: f64, gammas: &[f64]) -> Result<Vec<f64>, Error> {
        for gamma in gammas {
            Settings { gamma: *gamma, sigma2 }.check()?;
        }
        let largest = gammas.iter().copied().fold(0.0, f64::max);
        let low = self.low_rank(sigma2, largest, TOLERANCE_OF_SEARCH);
        let n = self.samples.count();
        gammas
            .iter()
            .map(|gamma| {
                let lambda = 1.0 / gamma;
                let sum = match &low {
                    Some(low) => self.low_rank_errors(low, lambda)?,
                    None => {
                        let omega = self.omega(sigma2);
                        let y = self.samples.outputs();
                        let errors = held_out_errors(omega, lambda, y, &self.ranges)?;
                        errors.iter().map(|e| e * e).sum()
                    }
                };
                Ok(sum / n as f64)
            })
            .collect()
    }

    /// Sum of squares of the errors one step ahead.
    fn low_rank_errors(&self, low: &LowRank, lambda: f64) -> Result<f64, Error> {
        let y = self.samples.outputs();
        let sums = Sums::new(low, y, lambda);
        let mut sum = 0.0;
        for part in &self.ranges {
            let ill = Error::IllPosed { samples: y.len() - part.len(), lambda };
            let fit = sums.without(part).ok_or(ill)?;
            let values = fit.values(low.factor().rows(part.start, part.len()));
            sum += values.iter().zip(&y[part.clone()]).map(|(f, y)| (f - y).powi(2)).sum::<f64>();
        }
        Ok(sum)
    }

    /// The models that do not know one part each, with the indices of that part: to be judged in
    /// simulation mode. Where the rank is low they stand on the pivots, which gives the same
    /// function with fewer centres.
    ///
    /// # Errors
    /// [`Error::Setting`], [`Error::IllPosed`].
    pub fn models(
        &mut self,
        sigma2: f64,
        gammas: &[f64],
    ) -> Result<Vec<Vec<FoldModel<'_>>>, Error> {
        for gamma in gammas {
            Settings { gamma: *gamma, sigma2 }.check()?;
        }
        let largest = gammas.iter().copied().fold(0.0, f64::max);
        let low = self.low_rank(sigma2, largest, TOLERANCE);
        let mut all = Vec::new();
        for gamma in gammas {
            let settings = Settings { gamma: *gamma, sigma2 };
            all.push(match &low {
                Some(low) => self.low_rank_models(low, settings)?,
                None => self.dense_models(settings)?,
            });
        }
        let held_out = |part: usize| &self.order[self.ranges[part].clone()];
        let with_parts = |models: Vec<LsSvm>| {
            models.into_iter().enumerate().map(|(k, model)| (model, held_out(k))).collect()
        };
        Ok(all.into_iter().map(with_parts).collect())
    }

    fn low_rank_models(&self, low: &LowRank, settings: Settings) -> Result<Vec<LsSvm>, Error> {
        let (y, lambda) = (self.samples.outputs(), 1.0 / settings.gamma);
        let sums = Sums::new(low, y, lambda);
        let pivots = self.samples.subset(&low.pivots);
        let model = |part: &std::ops::Range<usize>| {
            let ill = Error::IllPosed { samples: y.len() - part.len(), lambda };
            let fit = sums.without(part).ok_or(ill)?;
            Ok(LsSvm {
                dimension: pivots.dimension(),
                centres: pivots.inputs().to_vec(),
                weights: fit.on_pivots(low),
                bias: fit.bias,
                sigma2: settings.sigma2,
            })
        };
        self.ranges.iter().map(model).collect()
    }

    fn dense_models(&mut self, settings: Settings) -> Result<Vec<LsSvm>, Error> {
        let lambda = 1.0 / settings.gamma;
        let omega = self.omega(settings.sigma2);
        let bordered = Bordered::new(omega, lambda, self.samples.outputs())?;
        let n = self.samples.count();
        let model = |part: &std::ops::Range<usize>| {
            let gone: Vec<usize> = part.clone().collect();
            let kept: Vec<usize> = (0..part.start).chain(part.end..n).collect();
            let ill = Error::IllPosed { samples: kept.len(), lambda };
            let (weights, bias) = bordered.without(&kept, &gone).ok_or(ill)?;
            Ok(LsSvm {
                dimension: self.samples.dimension(),
                centres: self.samples.subset(&kept).inputs().to_vec(),
                weights,
                bias,
                sigma2: settings.sigma2,
            })
        };
        self.ranges.iter().map(model).collect()
    }
}

/// The errors of leaving each sample out, in closed form: `α_i / [A⁻¹]_ii` of the bordered matrix.
///
/// # Errors
/// [`Error::Setting`], [`Error::IllPosed`].
pub fn leave_one_out(samples: &Samples, settings: Settings) -> Result<Vec<f64>, Error> {
    settings.check()?;
    let (n, lambda) = (samples.count(), 1.0 / settings.gamma);
    let points = samples.scaled(settings.sigma2);
    let y = samples.outputs();
    if let Some(low) = LowRank::until(&points, TOLERANCE * lambda, n / 3) {
        let l = low.factor();
        let fit =
            super::low_rank::Fit::of(l, y, lambda).ok_or(Error::IllPosed { samples: n, lambda })?;
        let weights = fit.weights(l, y, lambda);
        let diagonal = fit.inverse_diagonal(l, lambda);
        return Ok(weights.iter().zip(diagonal).map(|(a, k)| a / k).collect());
    }
    let mut omega = vec![0.0; n * n];
    points.fill_lower(&mut omega);
    let bordered = Bordered::new(omega, lambda, y)?;
    Ok((0..n).map(|i| bordered.alpha[i] / bordered.at(i, i)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wave;

    fn samples(n: usize, d: usize) -> Samples {
        let inputs = wave(n * d, 1.3);
        let outputs = inputs.chunks_exact(d).map(|x| (2.0 * x[0]).sin() + x[1] * x[1]);
        let outputs = outputs.zip(wave(n, 0.77)).map(|(y, e)| y + 0.05 * e).collect();
        Samples::new(d, inputs, outputs).unwrap()
    }

    /// Trains every fold from the start.
    fn by_hand(samples: &Samples, folds: &Folds, settings: Settings) -> Vec<f64> {
        let mut errors = vec![0.0; samples.count()];
        for part in folds.parts() {
            let kept: Vec<usize> = (0..samples.count()).filter(|i| !part.contains(i)).collect();
            let (model, _) = LsSvm::train(&samples.subset(&kept), settings).unwrap();
            let (f, mut room) = (model.kernel_sum(), vec![0.0; samples.dimension()]);
            for i in part {
                errors[*i] = samples.outputs()[*i] - f.value(samples.input(*i), &mut room);
            }
        }
        errors
    }

    const ROUGH: Settings = Settings { gamma: 300.0, sigma2: 0.02 };
    const SMOOTH: Settings = Settings { gamma: 1e3, sigma2: 4.0 };

    #[test]
    fn all_folds_agree_with_trainings_from_the_start() {
        for settings in [ROUGH, SMOOTH] {
            let samples = samples(150, 3);
            for folds in [Folds::blocks(150, 10), Folds::interleaved(150, 5)] {
                let errors = by_hand(&samples, &folds, settings);
                let expected = errors.iter().map(|e| e * e).sum::<f64>() / 150.0;
                let mut validation = Validation::new(&samples, &folds).unwrap();
                let found = validation.one_step(settings.sigma2, &[settings.gamma]).unwrap();
                assert!((found[0] / expected - 1.0).abs() < 1e-5, "{} {expected}", found[0]);
                let models = validation.models(settings.sigma2, &[settings.gamma]).unwrap();
                let mut room = [0.0; 3];
                for (model, part) in &models[0] {
                    let f = model.kernel_sum();
                    for i in *part {
                        let error = samples.outputs()[*i] - f.value(samples.input(*i), &mut room);
                        assert!((error - errors[*i]).abs() < 1e-6, "{error} {}", errors[*i]);
                    }
                }
            }
        }
    }

    #[test]
    fn leaving_one_out_needs_no_training() {
        for settings in [ROUGH, SMOOTH] {
            let samples = samples(60, 3);
            let expected = by_hand(&samples, &Folds::blocks(60, 60), settings);
            let found = leave_one_out(&samples, settings).unwrap();
            for (a, b) in expected.iter().zip(found) {
                assert!((a - b).abs() < 1e-6, "{a} {b}");
            }
        }
    }
}
