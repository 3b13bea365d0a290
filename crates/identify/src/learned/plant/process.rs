//! A Gaussian process over the command and its derivatives.
//!
//! ```text
//! y(t) = f(v, v̇ [, v̈] at t and before),   2, 6 or 9 inputs
//! ```
//!
//! In real time: the inputs know the commands up to t, and y(t) is theirs. Hyperparameters by the gradient of the
//! marginal likelihood; number of inputs and low-pass are those of least simulated error on the last third of
//! what is fitted, by a process that was trained on the rest. It has no memory: what it knows of a loop it
//! knows from its rate. It stands on the straight line of least error, so that it leads on where no sample is near.
//!
//! Source: Gaussian process with high-dimensional input, eqs. (8), (10), (13)-(19).

use learned::Deviation;
use learned::features::{Derivatives, Features};
use learned::gp::GaussianProcess;

use super::super::process::{Search, by_likelihood};
use super::super::series::rows;
use super::super::{Frame, Machine, Recipe, Run, Series};
use super::{FitContext, SAMPLES, Stage, failed, none};
use crate::error::Error;
use crate::settings::FeatureChoice;

const INPUTS: [usize; 3] = [2, 6, 9];
/// Half lengths of the low-pass.
const HALF: [usize; 2] = [0, 3];
/// Cut-off of the filter in cycles per sample.
const CUTOFF: f64 = 0.25;
/// σ_f where the search begins, in ranges of the position.
const SIGNAL: f64 = 1.0;
/// Evaluations with one length and with one each, and most samples looked at: to choose, and in the end.
const CHOOSE: Search = Search { signal: SIGNAL, evaluations: [25, 40], most_samples: 400 };
const LEARN: Search = Search { signal: SIGNAL, evaluations: [40, 80], most_samples: 700 };
/// Most samples of a process that is tried.
const TRIED: usize = 600;

/// Most centres of the standard deviation in the plant: a step takes the square of this number of multiplications.
const DEVIATION: usize = 400;

/// Error and predicted standard deviation of a row, in the position's unit.
pub(super) struct Row {
    pub(super) error: f64,
    /// By all samples.
    pub(super) deviation: f64,
    /// By those that the plant runs on.
    pub(super) few: Option<f64>,
}

/// A process as it was trained, which knows its variance.
pub(super) struct TrainedProcess {
    process: GaussianProcess,
    frame: Frame,
}

impl TrainedProcess {
    /// σ_n in the position's unit.
    pub(super) fn noise(&self) -> f64 {
        self.process.parameters().noise * (self.frame.output.high - self.frame.output.low)
    }

    /// σ_f in the position's unit.
    pub(super) fn signal(&self) -> f64 {
        self.process.parameters().signal * (self.frame.output.high - self.frame.output.low)
    }

    /// The trained process' standard deviation on few centres, as the plant runs it.
    pub(super) fn deviation(&self) -> Result<Deviation, Error> {
        self.process.deviation(DEVIATION).map_err(failed)
    }

    /// Errors at some rows of a record and the standard deviations that are predicted there, by all samples and by these
    /// few.
    pub(super) fn judged(
        &self,
        few: Option<&Deviation>,
        (command, position): (&[f64], &[f64]),
        rows: &[usize],
    ) -> Option<Vec<Row>> {
        let samples = self.frame.samples(&[(command, position)]).ok()?;
        let (mean, d) = (self.process.kernel_sum(), samples.dimension());
        let span = self.frame.output.high - self.frame.output.low;
        let (mut room, mut centres) = (vec![0.0; d], vec![0.0; few.map_or(0, Deviation::count)]);
        let (noise, signal) = (self.process.parameters().noise, self.process.parameters().signal);
        let of = |row: &usize| {
            let z = samples.inputs().get(row * d..(row + 1) * d)?;
            let error = samples.outputs().get(*row)? - mean.value(z, &mut room);
            let deviation = |variance: f64| span * (variance + noise.powi(2)).sqrt();
            let own = few.map(|few| deviation(signal.powi(2) * few.left(z, &mut centres)));
            Some(Row {
                error: span * error,
                deviation: deviation(self.process.variance(z)),
                few: own,
            })
        };
        rows.iter().map(of).collect()
    }
}

pub(super) fn learn(
    scene: &FitContext<'_>,
    stage: &mut Stage<'_>,
) -> Result<(Series, TrainedProcess), Error> {
    let pairs = scene.pairs();
    let (some, rest) = scene.parts();
    let mut best: Option<(f64, Frame)> = None;
    let inputs: Vec<usize> = match scene.learning.features {
        FeatureChoice::Inputs(count) => vec![count],
        _ => INPUTS.to_vec(),
    };
    let total = inputs.len() * HALF.len() + 1;
    let each = inputs.into_iter().flat_map(|inputs| HALF.map(|half| (inputs, half)));
    for (k, (inputs, half)) in each.enumerate() {
        stage(k, total)?;
        let Some(features) = Derivatives::new(inputs, half, CUTOFF, [1.0; 4]) else { continue };
        let features = Features::Derivatives(features);
        let mut frame =
            Frame::new(features, scene.command, scene.position, Recipe::Standardised, &pairs)
                .on_a_line(&pairs);
        frame.causal = true;
        let Ok(process) = train(&frame, &some, &CHOOSE, TRIED) else { continue };
        let machine = Machine::of_process(frame.clone(), &process);
        let error = Series { machine, linear: none() }.error(&rest);
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, frame));
        }
    }
    stage(total - 1, total)?;
    let (_, frame) = best.ok_or_else(|| Error::Learned {
        message:
            "no process over these records has a kernel matrix that can be solved; resample the \
                  log to fewer samples"
                .to_owned(),
    })?;
    let process = train(&frame, scene.runs, &LEARN, SAMPLES)?;
    let machine = Machine::of_process(frame.clone(), &process);
    Ok((Series { machine, linear: none() }, TrainedProcess { process, frame }))
}

fn train(
    frame: &Frame,
    runs: &[Run<'_>],
    search: &Search,
    most: usize,
) -> Result<GaussianProcess, Error> {
    let pairs: Vec<_> = runs.iter().map(|run| (run.command, run.position)).collect();
    let samples = frame.samples(&pairs).map_err(failed)?.subset(&rows(runs, most));
    by_likelihood(&samples, search).map_err(failed)
}
