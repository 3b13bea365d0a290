//! Experiments and their spectra, period by period.

use numerics::fft::Fft;

use super::Complex;
use crate::error::{Error, Problem};

/// One record of all inputs and outputs on a uniform grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Name for messages, as in `mirror.csv, record 1`.
    pub name: String,
    /// One signal per input.
    pub inputs: Vec<Vec<f64>>,
    /// One signal per output.
    pub outputs: Vec<Vec<f64>>,
}

/// Greatest difference between two periods of an input, as a part of its rms.
const SAME: f64 = 0.02;
/// Most periods that are looked for.
const MOST_PERIODS: usize = 256;

impl Experiment {
    /// Samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.inputs.first().map_or(0, Vec::len)
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn check(&self, first: &Self) -> Result<(), Problem> {
        let count = self.len();
        let all = || self.inputs.iter().chain(&self.outputs);
        let other = all().map(Vec::len).find(|length| *length != count);
        let shape = (self.inputs.len(), self.outputs.len());
        if let Some(output) = other {
            let record = self.name.clone();
            return Err(Problem::Lengths { record, time: count, input: count, output });
        }
        if shape != (first.inputs.len(), first.outputs.len()) {
            let (input, output) = shape;
            let record = self.name.clone();
            return Err(Problem::Lengths { record, time: first.inputs.len(), input, output });
        }
        for (number, values) in (1..).zip(all()) {
            if let Some(row) = values.iter().position(|x| !x.is_finite()) {
                return Err(Problem::NotFinite {
                    record: self.name.clone(),
                    row: row + 1,
                    column: format!("signal {number}"),
                    value: values[row],
                    count: values.iter().filter(|x| !x.is_finite()).count(),
                });
            }
        }
        Ok(())
    }

    /// The `count` samples from `first` on.
    #[must_use]
    pub fn part(&self, first: usize, count: usize) -> Self {
        let cut = |signals: &[Vec<f64>]| -> Vec<Vec<f64>> {
            signals.iter().map(|s| s.iter().skip(first).take(count).copied().collect()).collect()
        };
        let name = self.name.clone();
        Self { name, inputs: cut(&self.inputs), outputs: cut(&self.outputs) }
    }
}

/// Samples of one period of the inputs, where the record consists of at least two whole ones.
#[must_use]
pub fn period_of(experiment: &Experiment) -> Option<usize> {
    let count = experiment.len();
    (2..=MOST_PERIODS)
        .rev()
        .filter(|periods| count.is_multiple_of(*periods) && count / periods >= 8)
        .map(|periods| count / periods)
        .find(|&period| experiment.inputs.iter().all(|u| repeats(u, period)))
}

fn repeats(u: &[f64], period: usize) -> bool {
    let mean = u.iter().sum::<f64>() / u.len().max(1) as f64;
    let power: f64 = u.iter().map(|x| (x - mean).powi(2)).sum();
    let (a, b) = (&u[period..], &u[..u.len() - period]);
    let change: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    let share = a.len() as f64 / u.len() as f64;
    power > 0.0 && change <= SAME * SAME * share * power
}

/// Spectra of one experiment, lines 0 to N/2, mean over its periods.
pub(super) struct Spectra {
    /// Per input, per line.
    pub(super) inputs: Vec<Vec<Complex>>,
    /// Per output, per line.
    pub(super) outputs: Vec<Vec<Complex>>,
    /// Variance of the outputs' means over the periods; `None` with one period.
    pub(super) noise: Option<Vec<Vec<f64>>>,
}

/// Spectra of whole periods; those of all samples where `period` is the length.
pub(super) fn spectra(experiment: &Experiment, period: usize) -> Result<Spectra, Error> {
    let count = experiment.len() / period;
    if count == 0 {
        return Err(Error::Unsuitable(vec![Problem::TooShort {
            record: experiment.name.clone(),
            part: "in all",
            found: experiment.len(),
            needed: period,
        }]));
    }
    let transform = Fft::forward(period);
    let half = period / 2;
    let one = |x: &[f64]| -> Vec<Complex> {
        let mut line = transform.of_real(x);
        line.truncate(half + 1);
        line
    };
    let mean_and_noise = |signal: &[f64]| {
        let all: Vec<Vec<Complex>> = signal.chunks_exact(period).take(count).map(one).collect();
        let scale = 1.0 / count as f64;
        let mean: Vec<Complex> =
            (0..=half).map(|k| all.iter().map(|y| y[k]).sum::<Complex>() * scale).collect();
        let freedom = (count.max(2) - 1) as f64 * count as f64;
        let noise: Vec<f64> = (0..=half)
            .map(|k| all.iter().map(|y| (y[k] - mean[k]).norm_sqr()).sum::<f64>() / freedom)
            .collect();
        (mean, noise)
    };
    let inputs = experiment.inputs.iter().map(|u| mean_and_noise(u).0).collect();
    let (outputs, noise): (Vec<_>, Vec<_>) =
        experiment.outputs.iter().map(|y| mean_and_noise(y)).unzip();
    Ok(Spectra { inputs, outputs, noise: (count > 1).then_some(noise) })
}
