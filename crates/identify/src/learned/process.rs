//! Gaussian processes as machines.

use learned::gp::{self, GaussianProcess, Hyperparameters};
use learned::lssvm::Samples;

use super::{Frame, Machine};

/// How hyperparameters are sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// σ_f where it begins, in units of the scaled output; σ_n begins at 0.01.
    pub signal: f64,
    /// Most evaluations of the likelihood with one length for all inputs, and with one for each.
    pub evaluations: [usize; 2],
    /// Most samples that the likelihood is computed on.
    pub most_samples: usize,
}

/// One length for all inputs, and from there one for each: the branches of a slow loop are near each other in
/// all inputs but the rate.
///
/// # Errors
/// [`learned::Error`] where the training has no exact solution.
pub fn by_likelihood(
    samples: &Samples,
    search: &Search,
) -> Result<GaussianProcess, learned::Error> {
    let dimension = samples.dimension();
    let lengths = vec![(dimension as f64).sqrt()];
    let start = Hyperparameters { signal: search.signal, noise: 0.01, lengths };
    let [evaluations, each] = search.evaluations;
    let most_samples = search.most_samples;
    let first = gp::Search { start, evaluations, most_samples };
    let (_, found) = GaussianProcess::learn(samples, &first)?;
    let mut start = found.parameters;
    start.lengths = vec![start.lengths[0]; dimension];
    let second = gp::Search { start, evaluations: each, most_samples };
    Ok(GaussianProcess::learn(samples, &second)?.0)
}

impl Machine {
    /// The mean of a process that was trained on samples of the frame.
    #[must_use]
    pub fn of_process(mut frame: Frame, process: &GaussianProcess) -> Self {
        for (width, scale) in frame.widths.iter_mut().zip(process.scales()) {
            *width /= scale;
        }
        Self { frame, machine: process.scaled_machine() }
    }
}
