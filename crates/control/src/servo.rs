//! The servo of an instrument: its plant from a periodic excitation, and better values for its PID law and its notch
//! filters.
//!
//! With the law C(z) = kp + ki·T/(1 − z⁻¹) + kd·(1 − z⁻¹)/T, the notch filters N and the plant P (position per output of the
//! law, read before the output of the same cycle acts), L = C·N·P. For each set of filters and each shape of the law the
//! gain is raised from zero to the largest one with
//!
//! ```text
//! max |1/(1 + L)| ≤ M   for every smaller gain, with the plant's frequencies as measured and 3 % off
//! |P(0)|·√(c² + d²) ≤ noise limit, c = kp + ki·T + kd/T, d = kd/T
//! ```
//!
//! and that with the least error for the reference, Σ |R_k/(1 + L)|², is taken. From a stable plant at gain zero on, such a
//! loop is stable (see `loop_shape`). A filter is tried at each resonance: a peak of |P| that stands out from what is a
//! third of an octave away.
//!
//! Source: K. J. Åström, T. Hägglund, Advanced PID Control, ISA 2006, ch. 7 and 8; multisine: see there.

use core::f64::consts::{PI, TAU};

use identify::frequency::hold;
use nalgebra::Complex;
use numerics::fft::Fft;
use numerics::random::SplitMix64;
use serde::Serialize;

use super::loop_shape::{margins, sensitivity};

mod narrow;

pub use narrow::{NarrowMode, measured_response};

/// Part of the static response from which a peak is a resonance that a loop feels; smaller ones may be noise.
const LOWEST_PEAK: f64 = 0.3;

/// How far from a narrow mode its circle reaches: half widths at half power.
const CIRCLE: f64 = 30.0;
/// Lines whose median is the response at rest.
const LOWEST_LINES: usize = 5;
/// Rounds in which a multisine is clipped, at this part of its greatest value.
const CLIPPINGS: usize = 40;
const CLIP: f64 = 0.8;

/// A notch filter (s² + 2·zeros·ω·s + ω²)/(s² + 2·poles·ω·s + ω²), bilinear with ω kept: frequency in Hz, zeros, poles.
pub type NotchFilter = [f64; 3];

/// A response at one frequency: Hz, position per unit of the input.
pub type Line = (f64, Complex<f64>);

/// What one output of the law does, line by line.
#[derive(Clone, Debug, PartialEq)]
pub struct ServoPlant {
    /// Length of a servo cycle in s.
    pub period: f64,
    /// In Hz, growing.
    pub frequency: Vec<f64>,
    /// Position per output of the law.
    pub response: Vec<Complex<f64>>,
    /// Modes between the lines of its measurement, around which there are more.
    pub narrow: Vec<NarrowMode>,
}

/// The law: kp, ki in 1/s, kd in s, and the filters that are on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ServoLaw {
    /// Proportional.
    pub kp: f64,
    /// Integral, 1/s.
    pub ki: f64,
    /// Derivative, s.
    pub kd: f64,
    /// Filters.
    pub notches: Vec<NotchFilter>,
}

/// What a loop does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ServoVerdict {
    /// Greatest |1/(1 + L)|.
    pub sensitivity: f64,
    /// By how much the gain may grow.
    pub gain_margin: f64,
    /// In degrees.
    pub phase_margin: f64,
    /// Lowest frequency with |L| = 1, in Hz.
    pub bandwidth: f64,
    /// Rms error for the reference, in the unit of the position.
    pub rms_error: f64,
}

/// What a law must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoLimits {
    /// Greatest |1/(1 + L)|.
    pub sensitivity: f64,
    /// Greatest amplification of white sensor noise to the output of the law, as a position.
    pub noise: f64,
}

/// One of several multisines of amplitude 1 with the same lines and other phases: at first random, then led to a small
/// crest factor by clipping. The power of line k falls with 1/k, so that low lines stand above what hysteresis, creep and
/// drift add there.
///
/// Source: R. Pintelon, J. Schoukens, System Identification, 2nd ed., IEEE Press 2012, ch. 4 and 5; clipping: E. Van der
/// Ouderaa, J. Schoukens, J. Renneboog, IEEE Trans. Instrum. Meas. 37 (1988) 145–147.
#[must_use]
pub fn multisine(points: usize, lines: usize, realization: u64) -> Vec<f64> {
    let lines = lines.min((points.max(1) - 1) / 2);
    let mut random = SplitMix64::from_state(realization);
    let mut spectrum = vec![Complex::new(0.0, 0.0); points];
    let line = |k: usize, phase: f64| Complex::from_polar((k as f64).sqrt().recip(), phase);
    let set = |spectrum: &mut [Complex<f64>], k: usize, value: Complex<f64>| {
        spectrum[k] = value;
        spectrum[points - k] = value.conj();
    };
    (1..=lines).for_each(|k| set(&mut spectrum, k, line(k, TAU * random.uniform())));
    let (forward, inverse) = (Fft::forward(points), Fft::inverse(points));
    for round in 0..=CLIPPINGS {
        inverse.process(&mut spectrum);
        let greatest = spectrum.iter().map(|x| x.re.abs()).fold(1e-300, f64::max);
        if round == CLIPPINGS {
            return spectrum.iter().map(|x| x.re / greatest).collect();
        }
        let clipped: Vec<f64> =
            spectrum.iter().map(|x| x.re.clamp(-CLIP * greatest, CLIP * greatest)).collect();
        let found = forward.of_real(&clipped);
        spectrum.fill(Complex::new(0.0, 0.0));
        (1..=lines).for_each(|k| set(&mut spectrum, k, line(k, found[k].arg())));
    }
    Vec::new()
}

/// The mean of several responses over the same lines. A line is left out if its mean is uncertain (a standard error of
/// more than 20 % of the line and 5 % of the static response): noise, or what hysteresis adds to it.
#[must_use]
pub(crate) fn mean_response(responses: &[Vec<Line>]) -> Vec<Line> {
    let count = responses.len() as f64;
    let shortest = responses.iter().map(Vec::len).min().unwrap_or(0);
    let lines: Vec<(f64, Complex<f64>, f64)> = (0..shortest)
        .map(|k| {
            let mean = responses.iter().map(|lines| lines[k].1).sum::<Complex<f64>>() / count;
            let square = responses.iter().map(|lines| (lines[k].1 - mean).norm_sqr()).sum::<f64>();
            (responses[0][k].0, mean, (square / (count * (count - 1.0).max(1.0))).sqrt())
        })
        .collect();
    let rest = static_size(&lines.iter().map(|(_, mean, _)| *mean).collect::<Vec<_>>());
    let is_certain =
        |mean: &Complex<f64>, error: f64| error <= (0.2 * mean.norm()).max(0.05 * rest);
    lines
        .into_iter()
        .filter(|(_, g, error)| is_certain(g, *error))
        .map(|(f, g, _)| (f, g))
        .collect()
}

/// Size of the response at rest: the median of the lowest lines.
fn static_size(response: &[Complex<f64>]) -> f64 {
    let mut sizes: Vec<f64> = response.iter().take(LOWEST_LINES).map(|g| g.norm()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
}

/// Output over input at the lines 1 to `lines` of a periodic excitation, continuous: without the hold of the input over
/// a sample time. The first period is run-in, the others are averaged.
#[must_use]
pub(crate) fn periodic_response(
    [input, output]: [&[f64]; 2],
    points: usize,
    lines: usize,
    sample_time: f64,
) -> Vec<Line> {
    let mean = |signal: &[f64]| -> Vec<f64> {
        let periods = (signal.len() / points).max(2) - 1;
        let sum = |k: usize| (1..=periods).map(|p| signal[p * points + k]).sum::<f64>();
        (0..points).map(|k| sum(k) / periods as f64).collect()
    };
    let fft = Fft::forward(points);
    let [u, y] = [input, output].map(|signal| fft.of_real(&mean(signal)));
    let line = |k: usize| {
        let frequency = k as f64 / (points as f64 * sample_time);
        (frequency, y[k] / u[k] / hold(frequency, sample_time))
    };
    (1..=lines).map(line).filter(|(_, response)| response.is_finite()).collect()
}

impl ServoPlant {
    /// From a continuous response per volt: `scale` is the voltage per output of the law.
    #[must_use]
    pub fn new(lines: &[Line], narrow: &[NarrowMode], scale: f64, period: f64) -> Self {
        let below = lines.iter().filter(|(f, _)| f * period < 0.5);
        let (frequency, response) = below.map(|(f, g)| (*f, g * hold(*f, period) * scale)).unzip();
        ServoPlant { period, frequency, response, narrow: narrow.to_vec() }
    }

    /// The response at a frequency, between the lines along a straight line.
    fn at(&self, frequency: f64) -> Complex<f64> {
        let next = self.frequency.partition_point(|f| *f < frequency);
        match (next.checked_sub(1), self.response.get(next)) {
            (Some(last), Some(response)) => {
                let [from, to] = [self.frequency[last], self.frequency[next]];
                let share = (frequency - from) / (to - from);
                self.response[last] * (1.0 - share) + response * share
            }
            // The static part.
            (None, Some(response)) => Complex::new(response.norm() * response.re.signum(), 0.0),
            (Some(last), None) => self.response[last],
            (None, None) => Complex::new(0.0, 0.0),
        }
    }

    /// Frequencies of resonances, the highest peak first.
    #[must_use]
    pub fn resonances(&self) -> Vec<f64> {
        let third = 2.0_f64.powf(1.0 / 3.0);
        let size = |f: f64| self.at(f).norm();
        let rest = static_size(&self.response);
        let mut peaks: Vec<(f64, f64)> = Vec::new();
        for (k, response) in self.response.iter().enumerate() {
            let (f, height) = (self.frequency[k], response.norm());
            let near = self.frequency.partition_point(|g| *g < f / 1.1);
            let far = self.frequency.partition_point(|g| *g <= f * 1.1);
            let is_highest = self.response[near..far].iter().all(|other| other.norm() <= height);
            let stands_out = height > 1.25 * size(f / third) && height > 1.25 * size(f * third);
            if is_highest && stands_out && height > LOWEST_PEAK * rest {
                peaks.push((height, f));
            }
        }
        peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
        peaks.into_iter().map(|(_, f)| f).collect()
    }

    /// Fewer lines: all around the resonances, others evenly over the logarithm; every one on the circle of a narrow mode.
    fn thinned(&self, resonances: &[f64]) -> Self {
        let mut thin =
            ServoPlant { frequency: vec![], response: vec![], narrow: vec![], ..self.clone() };
        let mut last = 0.0;
        for (f, response) in self.frequency.iter().zip(&self.response) {
            let is_near = resonances.iter().any(|peak| (f / peak - 1.0).abs() < 0.15);
            let is_on_circle = self
                .narrow
                .iter()
                .any(|mode| (f / mode.frequency_hz - 1.0).abs() < CIRCLE * mode.damping);
            if is_on_circle || f / last > if is_near { 1.002 } else { 1.015 } {
                thin.frequency.push(*f);
                thin.response.push(*response);
                last = *f;
            }
        }
        thin
    }

    fn shifted(&self, factor: f64) -> Self {
        let frequency: Vec<f64> = self.frequency.iter().map(|f| f * factor).collect();
        let keep = frequency.partition_point(|f| f * self.period < 0.499);
        ServoPlant {
            period: self.period,
            frequency: frequency[..keep].to_vec(),
            response: self.response[..keep].to_vec(),
            narrow: Vec::new(),
        }
    }

    /// The open loop with a law, line by line.
    fn open(&self, law: &ServoLaw) -> Vec<Complex<f64>> {
        let pairs = self.frequency.iter().zip(&self.response);
        pairs.map(|(f, plant)| law.at(*f, self.period) * plant).collect()
    }

    /// What a law does to a reference with these lines: frequency in Hz, mean square.
    #[must_use]
    pub fn judge(&self, law: &ServoLaw, reference: &[(f64, f64)]) -> ServoVerdict {
        let open = self.open(law);
        let (gain_margin, phase_margin) = margins(&open, 1.0, false);
        let crossing = open.iter().position(|l| l.norm() <= 1.0).unwrap_or(open.len().max(1) - 1);
        ServoVerdict {
            sensitivity: sensitivity(&open, 1.0),
            gain_margin,
            phase_margin: phase_margin * 180.0 / PI,
            bandwidth: self.frequency.get(crossing).copied().unwrap_or_default(),
            rms_error: self.error(law, reference),
        }
    }

    fn error(&self, law: &ServoLaw, reference: &[(f64, f64)]) -> f64 {
        let square = |(f, power): &(f64, f64)| {
            power / (1.0 + law.at(*f, self.period) * self.at(*f)).norm_sqr()
        };
        reference.iter().map(square).sum::<f64>().sqrt()
    }

    /// The law with so much less gain that all lines keep the sensitivity; none: a hundredth does not.
    fn within(&self, law: &ServoLaw, most: f64) -> Option<ServoLaw> {
        let open = self.open(law);
        let gains = (0..).map(|k| 0.96_f64.powi(k)).take_while(|gain| *gain > 0.01);
        let mut kept = gains.filter(|gain| sensitivity(&open, *gain) <= most);
        kept.next().map(|gain| law.times(gain))
    }

    /// The law with the least error for the reference under these limits; none: none keeps them. `filters`: how many
    /// notch filters there are, and those that are possible at a frequency.
    #[must_use]
    pub fn design(
        &self,
        reference: &[(f64, f64)],
        limits: ServoLimits,
        filters: impl Fn(f64) -> (usize, Vec<NotchFilter>),
    ) -> Option<(ServoLaw, ServoVerdict)> {
        let resonances = self.resonances();
        let near = self.thinned(&resonances);
        let variants = [near.clone(), near.shifted(0.97), near.shifted(1.03)];
        let slope = static_size(&near.response);
        let mut best: Option<(f64, ServoLaw)> = None;
        for notches in filter_sets(&resonances, filters) {
            for shape in shapes(self.period) {
                let law = ServoLaw { notches: notches.clone(), ..shape };
                let loops: Vec<_> = variants.iter().map(|plant| plant.open(&law)).collect();
                let noise = slope * law.noise(self.period);
                let allowed = |gain: f64| {
                    let keeps = |l: &Vec<Complex<f64>>| sensitivity(l, gain) <= limits.sensitivity;
                    noise * gain <= limits.noise && loops.iter().all(keeps)
                };
                let Some(gain) = largest(allowed, 1e-4 / (slope * self.period)) else { continue };
                let law = law.times(gain);
                let error = near.error(&law, reference);
                let is_better = |error: f64| best.as_ref().is_none_or(|(least, _)| error < *least);
                if !is_better(error) {
                    continue;
                }
                // The lines between those that were looked at until now.
                let Some(law) = self.within(&law, limits.sensitivity) else { continue };
                let error = near.error(&law, reference);
                if is_better(error) {
                    best = Some((error, law));
                }
            }
        }
        let (_, law) = best?;
        let verdict = self.judge(&law, reference);
        Some((law, verdict))
    }
}

impl ServoLaw {
    /// C·N at a frequency in Hz.
    fn at(&self, frequency: f64, period: f64) -> Complex<f64> {
        let back = Complex::from_polar(1.0, -TAU * frequency * period);
        let difference = Complex::new(1.0, 0.0) - back;
        let law = Complex::new(self.ki * period, 0.0) / difference
            + self.kp
            + difference * (self.kd / period);
        self.notches.iter().fold(law, |law, [f, zeros, poles]| {
            // Bilinear, with the filter's frequency kept: s is in units of its angular frequency.
            let s = Complex::new(0.0, (PI * frequency * period).tan() / (PI * f * period).tan());
            let one = Complex::new(1.0, 0.0);
            law * (s * s + s * (2.0 * zeros) + one) / (s * s + s * (2.0 * poles) + one)
        })
    }

    /// Standard deviation of the law's output per standard deviation of white noise.
    fn noise(&self, period: f64) -> f64 {
        let derivative = self.kd / period;
        (self.kp + self.ki * period + derivative).hypot(derivative)
    }

    fn times(&self, gain: f64) -> Self {
        ServoLaw {
            kp: self.kp * gain,
            ki: self.ki * gain,
            kd: self.kd * gain,
            notches: self.notches.clone(),
        }
    }
}

/// Shapes with an integral gain of 1: proportional and derivative parts as times.
fn shapes(period: f64) -> Vec<ServoLaw> {
    let mut shapes = vec![ServoLaw { ki: 1.0, ..ServoLaw::default() }];
    for k in 0..12 {
        let kp = period * 1.8_f64.powi(k);
        for part in [0.0, 0.1, 0.25, 0.5] {
            let kd = part * kp * kp;
            shapes.push(ServoLaw { kp, ki: 1.0, kd, notches: Vec::new() });
        }
    }
    shapes
}

/// No filter, one at the first resonance, one at each of the first two.
fn filter_sets(
    resonances: &[f64],
    filters: impl Fn(f64) -> (usize, Vec<NotchFilter>),
) -> Vec<Vec<NotchFilter>> {
    let mut sets = vec![Vec::new()];
    let Some(first) = resonances.first() else { return sets };
    for off in [1.0, 0.97, 1.03] {
        let (count, ones) = filters(first * off);
        sets.extend(ones.iter().map(|one| vec![*one]));
        if let (Some(second), true) = (resonances.get(1), count > 1) {
            let (_, others) = filters(second * off);
            sets.extend(ones.iter().zip(others).map(|(one, other)| vec![*one, other]));
        }
    }
    sets
}

/// The largest gain up to which all are allowed, from `least` on.
fn largest(allowed: impl Fn(f64) -> bool, least: f64) -> Option<f64> {
    let mut gain = least;
    if !allowed(gain) {
        return None;
    }
    for factor in [1.25, 1.04, 1.01] {
        for _ in 0..100 {
            if !allowed(gain * factor) {
                break;
            }
            gain *= factor;
        }
    }
    Some(gain)
}

/// What of a voltage follows the output of a law that saw this error: volts per output (κ), and the share of the
/// voltage's changes that it explains. Filters act on the voltage's changes too.
#[must_use]
pub fn law_in_record(law: &ServoLaw, [error, voltage]: [&[f64]; 2], period: f64) -> (f64, f64) {
    let mut sum = 0.0;
    let mut last = error.first().copied().unwrap_or_default();
    let mut outputs: Vec<f64> = error
        .iter()
        .map(|e| {
            sum += law.ki * period * e;
            let output = law.kp * e + sum + law.kd * (e - last) / period;
            last = *e;
            output
        })
        .collect();
    for notch in &law.notches {
        filter(&mut outputs, *notch, period);
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let (mean_output, mean_voltage) = (mean(&outputs), mean(voltage));
    let pairs = outputs.iter().zip(voltage).map(|(s, v)| (s - mean_output, v - mean_voltage));
    let (ss, sv, vv) =
        pairs.fold((0.0, 0.0, 0.0), |(ss, sv, vv), (s, v)| (ss + s * s, sv + s * v, vv + v * v));
    let scale = sv / ss;
    (scale, scale * sv / vv)
}

/// A notch filter over a signal, at rest at its first value.
fn filter(signal: &mut [f64], [frequency, zeros, poles]: NotchFilter, period: f64) {
    let k = (PI * frequency * period).tan();
    let norm = 1.0 / (1.0 + 2.0 * poles * k + k * k);
    let [b0, b1, b2] =
        [1.0 + 2.0 * zeros * k + k * k, 2.0 * (k * k - 1.0), 1.0 - 2.0 * zeros * k + k * k]
            .map(|c| c * norm);
    let a2 = (1.0 - 2.0 * poles * k + k * k) * norm;
    let first = signal.first().copied().unwrap_or_default();
    let (mut x1, mut x2, mut y1, mut y2) = (first, first, first, first);
    for value in signal {
        let y = b0 * *value + b1 * (x1 - y1) + b2 * x2 - a2 * y2;
        (x2, x1, y2, y1) = (x1, *value, y1, y);
        *value = y;
    }
}

#[cfg(test)]
mod tests;
