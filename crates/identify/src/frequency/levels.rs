//! Nonlinear distortion at lines that are not excited: the fast method.
//!
//! A random-phase multisine that excites odd lines only, and not all of them, shows even
//! nonlinearities at the even lines and odd ones at the odd lines that were left out (detection
//! lines). What the inputs themselves carry there is taken off with the response.
//!
//! Source: R. Pintelon, J. Schoukens, *System Identification: A Frequency Domain Approach*, 2nd ed.
//! (2012), section 4.2.

use serde::Serialize;

use super::Complex;
use super::excitation::Spectra;
use super::response::{Distortion, FrequencyResponse, Line};

/// Levels of one output, rms over the band in its unit, of one line each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Levels {
    /// What the excited lines hold.
    pub output: f64,
    /// Noise over the mean of all periods; `None` without periods.
    pub noise: Option<f64>,
    /// What is not linear at excited lines: noise and distortion.
    pub total: f64,
    /// Distortion at excited lines: total without noise.
    pub distortion: Option<f64>,
    /// Output at even lines that are not excited, without noise.
    pub even: Option<f64>,
    /// Output at odd lines that are not excited, without noise.
    pub odd: Option<f64>,
}

pub(super) fn distortion(
    all: &[Spectra],
    excited: &[usize],
    lines: &[Line],
    length: usize,
    sample_time: f64,
) -> Distortion {
    let (Some(first), Some(last)) = (excited.first(), excited.last()) else {
        return Distortion::default();
    };
    let mut result = Distortion::default();
    let mut nearest = lines.iter().peekable();
    for k in *first..=*last {
        if excited.binary_search(&k).is_ok() {
            continue;
        }
        let frequency = k as f64 / (length as f64 * sample_time);
        while nearest.len() > 1 && nearest.peek().is_some_and(|line| line.frequency < frequency) {
            nearest.next();
        }
        let Some(line) = nearest.peek() else { break };
        let outputs = line.response.nrows();
        let rest = |s: &Spectra, o: usize| -> Complex {
            let linear: Complex =
                (0..line.response.ncols()).map(|i| line.response[(o, i)] * s.inputs[i][k]).sum();
            s.outputs[o][k] - linear
        };
        let amplitude = |o: usize| {
            let power: f64 = all.iter().map(|s| rest(s, o).norm_sqr()).sum();
            2.0 / length as f64 * (power / all.len() as f64).sqrt()
        };
        let entry = (frequency, (0..outputs).map(amplitude).collect());
        if k.is_multiple_of(2) { result.even.push(entry) } else { result.odd.push(entry) }
    }
    result
}

impl FrequencyResponse {
    /// Levels of an output over the band.
    #[must_use]
    pub fn levels(&self, output: usize) -> Levels {
        let rms = |values: &mut dyn Iterator<Item = f64>| -> Option<f64> {
            let (mut sum, mut count) = (0.0, 0_usize);
            values.for_each(|x| (sum, count) = (sum + x * x, count + 1));
            (count > 0).then(|| (sum / count as f64).sqrt())
        };
        let less = |a: f64, b: f64| (a * a - b * b).max(0.0).sqrt();
        let of = |pick: &dyn Fn(&Line) -> f64| rms(&mut self.lines.iter().map(pick)).unwrap_or(0.0);
        let total = of(&|line| line.total[output]);
        let has_noise = self.lines.iter().all(|line| line.noise.is_some());
        let noise = has_noise.then(|| of(&|line| line.noise.as_ref().map_or(0.0, |n| n[output])));
        let at = |lines: &[(f64, Vec<f64>)]| {
            let level = rms(&mut lines.iter().map(|(_, y)| y[output]))?;
            Some(less(level, noise.unwrap_or(0.0)))
        };
        Levels {
            output: of(&|line| line.amplitude[output]),
            noise,
            total,
            distortion: noise.map(|noise| less(total, noise)),
            even: at(&self.distortion.even),
            odd: at(&self.distortion.odd),
        }
    }
}
