//! Support vectors are taken out where that changes the model least (Algorithm 1 of the laser beam
//! paper, eqs. (9) and (10)).
//!
//! Each round ranks the samples by `|α_i (1/γ − 1/k_ii)|`, `k_ii = [A⁻¹]_ii` of the bordered matrix,
//! drops the lowest 5 %, trains again on the others and lets the caller judge the model (in
//! simulation mode on all training samples). It ends where the judgement reaches τ or no more than
//! N_min support vectors are left, with the last model that met τ.
//!
//! Training again is a Schur complement of the inverse, or r × r algebra where the kernel has a low
//! rank: the same numbers as a training from the start, which ends the work once, with its residual.

use crate::Error;
use crate::lssvm::bordered::Bordered;
use crate::lssvm::low_rank::Fit;
use crate::lssvm::{LsSvm, Report, Samples, Settings};
use crate::solve::pivoted::LowRank;

/// When pruning ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pruning {
    /// Greatest judgement that is accepted (τ).
    pub most_error: f64,
    /// Least number of support vectors (N_min).
    pub least_count: usize,
    /// Part that each round drops.
    pub part: f64,
}

impl Default for Pruning {
    fn default() -> Self {
        Self { most_error: f64::INFINITY, least_count: 40, part: 0.05 }
    }
}

/// One round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Support vectors left.
    pub count: usize,
    /// What the caller's judgement was.
    pub error: f64,
}

/// A pruned model.
#[derive(Clone, Debug, PartialEq)]
pub struct Pruned {
    /// The last model that met τ, trained from the start on its support vectors.
    pub model: LsSvm,
    /// Indices of its support vectors.
    pub kept: Vec<usize>,
    /// Of that training.
    pub report: Report,
    /// All rounds, the unpruned model first.
    pub rounds: Vec<Round>,
}

/// Prunes; `judge` gives the error of a model, as a rule that of its simulation. A judgement that is
/// not a number counts as too large.
///
/// # Errors
/// [`Error::Setting`], also where the unpruned model does not meet τ; [`Error::IllPosed`], [`Error::Unconverged`].
pub fn prune(
    samples: &Samples,
    settings: Settings,
    pruning: Pruning,
    mut judge: impl FnMut(&LsSvm) -> f64,
) -> Result<Pruned, Error> {
    settings.check()?;
    if !(pruning.part > 0.0 && pruning.part < 1.0) {
        let rule = "must be more than 0 and less than 1";
        return Err(Error::Setting { name: "part", value: pruning.part, rule });
    }
    let (all, _) = LsSvm::train(samples, settings)?;
    let error = judge(&all);
    if error.is_nan() || error >= pruning.most_error {
        let rule = "is the error of the unpruned model, and not below the limit; raise the limit";
        return Err(Error::Setting { name: "error", value: error, rule });
    }
    let mut rounds = vec![Round { count: samples.count(), error }];
    let mut kept: Vec<usize> = (0..samples.count()).collect();
    let mut state = State::new(samples, settings)?;
    while kept.len() > pruning.least_count {
        let left = ((1.0 - pruning.part) * kept.len() as f64).floor() as usize;
        if left < pruning.least_count.max(2) {
            break;
        }
        let dropped = lowest(&state.scores(samples, settings)?, kept.len() - left);
        let stay: Vec<usize> = (0..kept.len()).filter(|i| !dropped[*i]).collect();
        let gone: Vec<usize> = (0..kept.len()).filter(|i| dropped[*i]).collect();
        let next: Vec<usize> = stay.iter().map(|i| kept[*i]).collect();
        state.take_out(samples, settings, &stay, &gone, &next)?;
        let (alpha, bias) = state.solution();
        let model = LsSvm {
            dimension: samples.dimension(),
            centres: next.iter().flat_map(|i| samples.input(*i).iter().copied()).collect(),
            weights: alpha.to_vec(),
            bias,
            sigma2: settings.sigma2,
        };
        let error = judge(&model);
        rounds.push(Round { count: next.len(), error });
        if error.is_nan() || error >= pruning.most_error {
            break;
        }
        kept = next;
    }
    let (model, report) = LsSvm::train(&samples.subset(&kept), settings)?;
    Ok(Pruned { model, kept, report, rounds })
}

/// Which are the `count` of least absolute value.
fn lowest(scores: &[f64], count: usize) -> Vec<bool> {
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|a, b| scores[*a].abs().total_cmp(&scores[*b].abs()));
    let mut lowest = vec![false; scores.len()];
    order.iter().take(count).for_each(|i| lowest[*i] = true);
    lowest
}

/// What a round knows of the samples that are left.
enum State {
    Dense(Bordered),
    Low { low: LowRank, kept: Vec<usize>, fit: Fit, alpha: Vec<f64> },
}

/// Remainder of a factor that ranks the samples as the exact matrix does, as a part of λ.
const TOLERANCE: f64 = 1e-7;

impl State {
    fn new(samples: &Samples, settings: Settings) -> Result<Self, Error> {
        let (n, lambda) = (samples.count(), 1.0 / settings.gamma);
        let points = samples.scaled(settings.sigma2);
        let y = samples.outputs();
        if let Some(low) = LowRank::until(&points, TOLERANCE * lambda, n / 8)
            && let Some(fit) = Fit::of(low.factor(), y, lambda)
        {
            let alpha = fit.weights(low.factor(), y, lambda);
            return Ok(Self::Low { kept: (0..n).collect(), low, fit, alpha });
        }
        let mut omega = vec![0.0; n * n];
        points.fill_lower(&mut omega);
        Ok(Self::Dense(Bordered::new(omega, lambda, y)?))
    }

    fn solution(&self) -> (&[f64], f64) {
        match self {
            Self::Dense(bordered) => (&bordered.alpha, bordered.bias),
            Self::Low { fit, alpha, .. } => (alpha, fit.bias),
        }
    }

    /// `α_i (1/γ − 1/k_ii)`.
    fn scores(&self, samples: &Samples, settings: Settings) -> Result<Vec<f64>, Error> {
        let lambda = 1.0 / settings.gamma;
        let score = |alpha: f64, k: f64| alpha * (lambda - 1.0 / k);
        let all: Vec<f64> = match self {
            Self::Dense(b) => (0..b.count()).map(|i| score(b.alpha[i], b.at(i, i))).collect(),
            Self::Low { low, kept, fit, alpha } => {
                let diagonal = fit.inverse_diagonal(low.rows(kept).as_view(), lambda);
                alpha.iter().zip(diagonal).map(|(a, k)| score(*a, k)).collect()
            }
        };
        match all.iter().all(|s| s.is_finite()) {
            true => Ok(all),
            false => Err(Error::IllPosed { samples: samples.count(), lambda }),
        }
    }

    fn take_out(
        &mut self,
        samples: &Samples,
        settings: Settings,
        stay: &[usize],
        gone: &[usize],
        next: &[usize],
    ) -> Result<(), Error> {
        let lambda = 1.0 / settings.gamma;
        let ill = || Error::IllPosed { samples: samples.count(), lambda };
        match self {
            Self::Dense(bordered) => *bordered = bordered.take_out(stay, gone).ok_or_else(ill)?,
            Self::Low { low, kept, fit, alpha } => {
                let rows = low.rows(next);
                let y: Vec<f64> = next.iter().map(|i| samples.outputs()[*i]).collect();
                *fit = Fit::of(rows.as_view(), &y, lambda).ok_or_else(ill)?;
                *alpha = fit.weights(rows.as_view(), &y, lambda);
                *kept = next.to_vec();
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wave;

    /// Algorithm 1 with a training from the start in every round and the inverse of the bordered
    /// matrix by elimination.
    fn by_hand(samples: &Samples, settings: Settings, rounds: usize) -> Vec<usize> {
        let mut kept: Vec<usize> = (0..samples.count()).collect();
        for _ in 0..rounds {
            let part = samples.subset(&kept);
            let n = part.count();
            let kernel = |i: usize, j: usize| {
                let squares = part.input(i).iter().zip(part.input(j)).map(|(a, b)| (a - b).powi(2));
                (-squares.sum::<f64>() / settings.sigma2).exp()
            };
            let a = crate::solve::dense::Mat::from_fn(n + 1, n + 1, |i, j| match (i, j) {
                (0, 0) => 0.0,
                (0, _) | (_, 0) => 1.0,
                _ => kernel(i - 1, j - 1) + if i == j { 1.0 / settings.gamma } else { 0.0 },
            });
            let inverse = a.lu().try_inverse().unwrap();
            let alpha: Vec<f64> = (1..=n)
                .map(|i| (1..=n).map(|j| inverse[(i, j)] * part.outputs()[j - 1]).sum())
                .collect();
            let scores: Vec<f64> = (0..n)
                .map(|i| alpha[i] * (1.0 / settings.gamma - 1.0 / inverse[(i + 1, i + 1)]))
                .collect();
            let left = (0.95 * n as f64).floor() as usize;
            let dropped = lowest(&scores, n - left);
            kept = (0..n).filter(|i| !dropped[*i]).map(|i| kept[i]).collect();
        }
        kept
    }

    #[test]
    fn the_same_support_vectors_stay_as_by_training_again() {
        // A rough kernel takes the Schur complements, a smooth one the low rank.
        for (sigma2, d) in [(0.01, 3), (30.0, 2)] {
            let inputs = wave(240 * d, 1.3);
            let outputs = inputs.chunks_exact(d).map(|x| (2.0 * x[0]).sin() + x[1] * x[1]);
            let outputs: Vec<f64> =
                outputs.zip(wave(240, 0.77)).map(|(y, e)| y + 0.05 * e).collect();
            let samples = Samples::new(d, inputs, outputs).unwrap();
            let settings = Settings { gamma: 1e3, sigma2 };
            let dense = matches!(State::new(&samples, settings).unwrap(), State::Dense(_));
            assert_eq!(dense, sigma2 < 1.0);
            let pruning = Pruning { least_count: 110, ..Pruning::default() };
            let pruned = prune(&samples, settings, pruning, |_| 0.0).unwrap();
            let rounds = pruned.rounds.len() - 1;
            assert!(rounds > 10);
            assert_eq!(pruned.kept, by_hand(&samples, settings, rounds));
            assert_eq!(pruned.model.count(), pruned.rounds.last().unwrap().count);
        }
    }

    #[test]
    fn the_last_model_that_met_the_limit_is_returned() {
        let inputs = wave(200, 1.3);
        let outputs = inputs.iter().map(|x| (3.0 * x).sin()).collect();
        let samples = Samples::new(1, inputs, outputs).unwrap();
        let settings = Settings { gamma: 1e4, sigma2: 0.5 };
        let limit = Pruning { most_error: 0.5, ..Pruning::default() };
        let judge = |model: &LsSvm| if model.count() >= 150 { 0.1 } else { 0.6 };
        let pruned = prune(&samples, settings, limit, judge).unwrap();
        assert!(pruned.model.count() >= 150);
        assert_eq!(pruned.rounds.last().unwrap().error, 0.6);
        let never = prune(&samples, settings, Pruning { most_error: 0.05, ..limit }, judge);
        assert!(matches!(never, Err(Error::Setting { name: "error", .. })));
    }
}
