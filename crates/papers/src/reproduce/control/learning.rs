//! Iterative learning over the passes of a reference: a correction of the reference, by the loop's own
//! response.
//!
//! ```text
//! r_{j+1} = r_j + step·Q·E_j/T,   T = Y/R of a small multisine on the reference
//! ```
//!
//! Each correction is played twice, faded in over a quarter of the first pass, and judged on the second.
//! All passes are one experiment from the first rest on: noise, creep and drift go on from pass to pass.
//! A pass that errs more than the best one before is taken back, and the step is halved. The pass
//! that is judged plays the best correction once more.

use data::Blueprint;
use identify::frequency::Complex;
use numerics::fft::Fft;

use super::bed::{Bed, Tracked};

/// What is learned, and how.
pub struct Learning<'a> {
    /// Rows that lead to the first pass, per axis.
    pub lead: &'a [Vec<f64>],
    /// One pass, per axis; the first row follows the last.
    pub pass: &'a [Vec<f64>],
    /// Turns of a reference that repeats within the pass: what does not repeat with it is noise.
    pub turns: usize,
    /// Rows of the pass that are judged.
    pub judged: usize,
    /// Sample time in s.
    pub period: f64,
    /// Rows that the controller sees ahead.
    pub preview: usize,
    /// Passes with learning.
    pub passes: usize,
    /// Amplitude of the multisine, as a part of the pass' range.
    pub probe: f64,
    /// Highest frequency in Hz that is probed and corrected. What is faster turns the reference around between two
    /// rows, and an inverse hysteresis jumps at each turn.
    pub band: f64,
}

/// What learning gave.
pub struct Learned {
    /// All passes; `from` is the first row of the judged one. Errors are those of the wanted path.
    pub run: Tracked,
    /// First row of the judged pass.
    pub from: usize,
    /// Root mean square error of each pass over all axes.
    pub errors: Vec<f64>,
    /// How many passes were taken back.
    pub rejected: usize,
}

impl Learned {
    /// What happened, pass by pass.
    pub(super) fn described(&self, what: &str) -> String {
        let errors: Vec<String> =
            self.errors.iter().map(|e| report::format_number(*e, 3)).collect();
        format!(
            "{what}, learning: rms errors of the passes {} um; {} taken back, the last one plays the best \
             correction again",
            errors.join(", "),
            self.rejected
        )
    }
}

/// Least magnitude of T at which something is learned.
const ANSWER: f64 = 0.15;
/// Least drive that is divided by.
const SMALL: f64 = 1e-6;
/// Passes without and with the multisine that are compared.
const WITHOUT: usize = 1;
const WITH: usize = 3;

/// a/b; 0 where b is smaller than `least`.
fn quotient(a: Complex, b: Complex, least: f64) -> Complex {
    if b.norm_sqr() < least * least { Complex::default() } else { a / b }
}

/// The waves of a pass: sums of x with e^(−j2πkm/n) for k from 0 to n/2.
struct Waves {
    forward: Fft,
    back: Fft,
}

impl Waves {
    fn new(n: usize) -> Self {
        Self { forward: Fft::forward(n), back: Fft::inverse(n) }
    }

    fn of(&self, x: &[f64]) -> Vec<Complex> {
        let mut all = self.forward.of_real(x);
        all.truncate(x.len() / 2 + 1);
        all
    }

    /// The signal of these waves; the ones behind them are 0.
    fn back(&self, waves: &[Complex]) -> Vec<f64> {
        let n = self.back.len();
        let mut all = vec![Complex::default(); n];
        for (k, wave) in waves.iter().enumerate() {
            all[k] = *wave;
            all[(n - k) % n] = if k == 0 || 2 * k == n { *wave } else { wave.conj() };
        }
        self.back.process(&mut all);
        all.into_iter().map(|x| x.re / n as f64).collect()
    }
}

/// A multisine of this amplitude (root mean square), of every wave that is this axis' in turn.
fn multisine(
    (n, highest): (usize, usize),
    (axis, axes): (usize, usize),
    amplitude: f64,
) -> Vec<f64> {
    let own: Vec<usize> = (1..=highest.min(n / 2 - 1)).filter(|k| k % axes == axis).collect();
    let one = amplitude * (2.0 / own.len().max(1) as f64).sqrt();
    let value = |m: usize| {
        let wave = |(number, k): (usize, &usize)| {
            // Schroeder's phases keep the crest low.
            let phase = std::f64::consts::PI * (number * number) as f64 / own.len() as f64;
            (std::f64::consts::TAU * (k * m % n) as f64 / n as f64 + phase).sin()
        };
        one * own.iter().enumerate().map(wave).sum::<f64>()
    };
    (0..n).map(value).collect()
}

/// The response from drive to answer over frequency: at each wave the mean over its neighbours, without those
/// where the reference itself is large and does not quite repeat.
fn response(
    answer: &[Complex],
    drive: &[Complex],
    reference: &[Complex],
    axes: usize,
) -> Vec<Complex> {
    let most = drive.iter().map(|x| x.norm()).fold(0.0, f64::max);
    let weight = |k: usize| {
        let own = drive[k].norm();
        if own < 0.1 * most {
            0.0
        } else {
            1.0 / (1.0 + (0.01 * reference[k].norm() / own).powi(2))
        }
    };
    let reach = axes;
    let mean = |k: usize| {
        let near = k.saturating_sub(reach)..(k + reach + 1).min(drive.len());
        let (sum, complete) = near.fold((Complex::default(), 0.0), |(sum, complete), j| {
            let w = weight(j);
            (sum + w * quotient(answer[j], drive[j], SMALL), complete + w)
        });
        if complete == 0.0 { sum } else { sum / complete }
    };
    (0..drive.len()).map(mean).collect()
}

struct Experiment<'a> {
    bed: &'a Bed,
    controller: &'a Blueprint,
    learning: &'a Learning<'a>,
    /// What was added to the reference, pass by pass, axis by axis.
    played: Vec<Vec<Vec<f64>>>,
}

impl Experiment<'_> {
    /// Plays all passes so far, with two of this correction behind them.
    fn play(&mut self, added: Vec<Vec<f64>>) -> anyhow::Result<Tracked> {
        let Learning { lead, pass, period, preview, .. } = *self.learning;
        self.played.extend([added.clone(), added]);
        let fade = (pass[0].len() / 4).max(1);
        let path = |axis: usize, with: bool| -> Vec<f64> {
            let passes = self.played.iter().enumerate().flat_map(|(number, added)| {
                let before = &self.played[number.saturating_sub(1)][axis];
                let change = move |k: usize| {
                    let x = (k as f64 / fade as f64).min(1.0);
                    let part = x * x * (3.0 - 2.0 * x);
                    if with { (1.0 - part) * before[k] + part * added[axis][k] } else { 0.0 }
                };
                pass[axis].iter().enumerate().map(move |(k, r)| r + change(k))
            });
            lead[axis].iter().copied().chain(passes).collect()
        };
        let described: Vec<Vec<f64>> = (0..pass.len()).map(|axis| path(axis, true)).collect();
        let mut run = self.bed.track(self.controller, &described, period, preview)?;
        for axis in 0..pass.len() {
            let wanted = path(axis, false);
            run.error[axis] = wanted.iter().zip(&run.position[axis]).map(|(r, y)| r - y).collect();
            run.reference[axis] = wanted;
        }
        Ok(run)
    }

    /// Rows of a signal in pass `number`.
    fn part<'b>(&self, signal: &'b [f64], number: usize) -> &'b [f64] {
        let rows = self.learning.pass[0].len();
        let from = self.learning.lead[0].len() + number * rows;
        &signal[from..from + rows]
    }

    fn error(&self, run: &Tracked) -> f64 {
        let last = self.played.len() - 1;
        let judged = self.learning.judged;
        let all = run.error.iter().flat_map(|e| &self.part(e, last)[..judged]);
        (all.map(|e| e * e).sum::<f64>() / judged as f64).sqrt()
    }
}

/// Learns over the passes of a loop.
///
/// # Errors
/// What the FMUs report.
pub fn learn(
    bed: &Bed,
    controller: &Blueprint,
    learning: &Learning<'_>,
) -> anyhow::Result<Learned> {
    let (axes, rows) = (learning.pass.len(), learning.pass[0].len());
    let waves = Waves::new(rows);
    let highest = (learning.band * rows as f64 * learning.period) as usize;
    let mut experiment = Experiment { bed, controller, learning, played: Vec::new() };
    let none = || vec![vec![0.0; rows]; axes];
    let before = experiment.play(none())?;
    let probes: Vec<Vec<f64>> = (0..axes)
        .map(|axis| {
            let (low, high) = crate::matching::extremes(&learning.pass[axis]);
            multisine((rows, highest), (axis, axes), learning.probe * (high - low))
        })
        .collect();
    let with = experiment.play(probes.clone())?;
    let responses: Vec<Vec<Complex>> = (0..axes)
        .map(|axis| {
            let y = experiment.part(&with.position[axis], WITH);
            let y0 = experiment.part(&before.position[axis], WITHOUT);
            let change: Vec<f64> = y.iter().zip(y0).map(|(y, y0)| y - y0).collect();
            let (answer, drive) = (waves.of(&change), waves.of(&probes[axis]));
            response(&answer, &drive, &waves.of(&learning.pass[axis]), axes)
        })
        .collect();
    experiment.play(none())?;
    let mut now = none();
    let mut step = 0.8;
    // Error, corrections, and what was left of the last period.
    let mut best: Option<(f64, [Vec<Vec<f64>>; 2])> = None;
    let (mut errors, mut rejected) = (Vec::new(), 0);
    for _ in 0..learning.passes {
        let run = experiment.play(now.clone())?;
        let error = experiment.error(&run);
        errors.push(error);
        let last = experiment.played.len() - 1;
        let seen: Vec<Vec<f64>> =
            run.error.iter().map(|e| experiment.part(e, last).to_vec()).collect();
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, [now.clone(), seen]));
            step = (1.3_f64 * step).min(0.8);
        } else {
            rejected += 1;
            step *= 0.5;
        }
        let Some((_, [from, seen])) = &best else { break };
        for (axis, seen) in seen.iter().enumerate() {
            let found = waves.of(seen);
            let change: Vec<Complex> = found
                .iter()
                .zip(&responses[axis])
                .take(highest + 1)
                .enumerate()
                .map(|(k, (e, t))| {
                    let repeats = k % learning.turns.max(1) == 0;
                    if repeats { quotient(*e, *t, ANSWER) } else { Complex::default() }
                })
                .collect();
            let change = waves.back(&change);
            now[axis] = from[axis].iter().zip(change).map(|(c, d)| c + step * d).collect();
        }
    }
    let chosen = best.map_or_else(none, |(_, [chosen, _])| chosen);
    let run = experiment.play(chosen)?;
    errors.push(experiment.error(&run));
    let from = learning.lead[0].len() + (experiment.played.len() - 1) * rows;
    Ok(Learned { run, from, errors, rejected })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_come_back() {
        for n in [60, 61] {
            let waves = Waves::new(n);
            let x: Vec<f64> = (0..n).map(|k| ((k * k) % 17) as f64).collect();
            let back = waves.back(&waves.of(&x));
            assert!(x.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-9), "{n}");
        }
    }
}
