//! Modes so narrow that they fall between the lines of a multisine, and still ring after its run-in.
//!
//! Of two periods of the same excitation the steady part is the same, so their difference is a free decay: whatever the
//! input and its hysteresis do. With bins k of its spectrum around a peak, v = exp(−2πj(k − k₀)/N) and the pole
//! z₀ = (1 + δ)·exp(2πj·k₀/N),
//!
//! ```text
//! D(k) = (c₀ + c₁x + c₂x²)/(1 − (1 + δ)·v),   x = (k − k₀)/bins
//! ```
//!
//! which is linear in δ and c once both sides are multiplied by the denominator, and is repeated with the last
//! denominator as weight. δ is that of all realizations, c each one's own. The decay is then taken out of the record. The
//! response between the lines around the mode is that of r/(1 − z₀/z) + a₀ + a₁x, which fits these lines.
//!
//! Sources: C. Sanathanan, J. Koerner, IEEE Trans. Autom. Control 8 (1963) 56–58 (the weights); T. McKelvey, G. Guérin,
//! Non-parametric frequency response estimation using a local rational model, IFAC SYSID 2012 (the local model).

use core::f64::consts::{PI, TAU};

use nalgebra::Complex;
use numerics::fft::Fft;
use numerics::least_squares::Reduced;
use serde::Serialize;

use super::{Line, mean_response, periodic_response};

/// Bins on each side of a peak: many, or few where another one is near.
const BINS: [usize; 2] = [12, 6];
/// By how much a peak of the decay stands out from the bins on each side.
const STANDS_OUT: f64 = 10.0;
/// Peaks that are looked at, the highest first.
const PEAKS: usize = 6;
const ROUNDS: usize = 10;
/// Part of the decay around a peak that its mode may leave.
const LEFT: f64 = 0.1;
/// Distances of lines within which a mode is narrow: its width at half power.
const NARROW: f64 = 4.0;
/// A tone that decays by less within a period is none of the plant.
const DECAYS: f64 = 0.99;
/// The lines around a mode must be explained so much better with it.
const BETTER: f64 = 0.5;
/// Distances of lines on each side of a mode in which the response comes from the fit.
const FITTED: f64 = 2.0;

/// A mode between the lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NarrowMode {
    /// In Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping: f64,
}

/// A pole found in the free decays: its bin, bins on each side, and the decays' amplitudes at their begin.
struct Decay {
    bin: usize,
    bins: usize,
    pole: Complex<f64>,
    amplitudes: Vec<Complex<f64>>,
}

/// The response of a plant from several records, each input and output over some periods of `points` rows of a
/// multisine: the mean at its lines, without the hold of the input, and values between them around each narrow mode;
/// and these modes. Lines about which the records do not agree are left out. Nothing of less than two periods.
#[must_use]
pub fn measured_response(
    records: &[[&[f64]; 2]],
    points: usize,
    lines: usize,
    sample_time: f64,
) -> (Vec<Line>, Vec<NarrowMode>) {
    if points == 0 || records.iter().flatten().any(|signal| signal.len() < 2 * points) {
        return (Vec::new(), Vec::new());
    }
    let decays = decays(records, points, lines);
    let clean = |(n, [input, output]): (usize, &[&[f64]; 2])| {
        let mut output = output.to_vec();
        decays.iter().for_each(|decay| decay.take_out(n, &mut output, points));
        periodic_response([input, &output], points, lines, sample_time)
    };
    let responses: Vec<Vec<Line>> = records.iter().enumerate().map(clean).collect();
    let distance = 1.0 / (points as f64 * sample_time);
    let mut found = mean_response(&responses);
    let mut modes = Vec::new();
    for decay in &decays {
        let Some(near) = decay.response(&found, points, distance) else { continue };
        let Some((first, last)) = near.first().zip(near.last()) else { continue };
        found.retain(|(f, _)| *f < first.0 || *f > last.0);
        found.extend(&near);
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes.push(decay.mode(sample_time));
    }
    (found, modes)
}

/// The decays that two periods of the records differ by.
fn decays(records: &[[&[f64]; 2]], points: usize, lines: usize) -> Vec<Decay> {
    if points < 8 * BINS[0] {
        return Vec::new();
    }
    let fft = Fft::forward(points);
    let spectrum = |[_, output]: &[&[f64]; 2]| {
        let [before, after] = last_two(output, points);
        let difference: Vec<f64> = after.iter().zip(before).map(|(b, a)| b - a).collect();
        fft.of_real(&difference)
    };
    let spectra: Vec<Vec<Complex<f64>>> = records.iter().map(spectrum).collect();
    let most = lines.min(points / 2 - 1);
    let power: Vec<f64> =
        (0..=most).map(|k| spectra.iter().map(|s| s[k].norm_sqr()).sum()).collect();
    let mut peaks: Vec<usize> = (BINS[1] + 1..power.len().saturating_sub(BINS[1] + 1))
        .filter(|k| stands_out(&power, *k))
        .collect();
    peaks.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
    peaks.iter().take(PEAKS).filter_map(|peak| decay(&spectra, *peak, most)).collect()
}

/// Where the last two periods begin.
fn begin_of_two(signal: &[f64], points: usize) -> usize {
    (signal.len() / points - 2) * points
}

/// The last period but one, and the last.
fn last_two(signal: &[f64], points: usize) -> [&[f64]; 2] {
    let from = begin_of_two(signal, points);
    [&signal[from..from + points], &signal[from + points..from + 2 * points]]
}

/// Whether the power at a bin is the greatest near it, and far above what is usual there.
fn stands_out(power: &[f64], k: usize) -> bool {
    let within = |bins: usize| k.saturating_sub(bins).max(1)..(k + bins + 1).min(power.len());
    let is_highest = power[within(BINS[1])].iter().all(|other| *other <= power[k]);
    let mut surrounding = power[within(4 * BINS[0])].to_vec();
    is_highest
        && numerics::median(&mut surrounding)
            .is_some_and(|usual| power[k] > STANDS_OUT.powi(2) * usual && power[k] > 0.0)
}

/// The pole at a peak, where there is one that decays slowly and explains it.
fn decay(spectra: &[Vec<Complex<f64>>], bin: usize, most: usize) -> Option<Decay> {
    let found = BINS.iter().filter(|bins| bin > **bins && bin + **bins <= most);
    found.filter_map(|bins| decay_within(spectra, bin, *bins)).next()
}

fn decay_within(spectra: &[Vec<Complex<f64>>], bin: usize, bins: usize) -> Option<Decay> {
    let points = spectra.first()?.len();
    let near = |spectrum: &Vec<Complex<f64>>| spectrum[bin - bins..=bin + bins].to_vec();
    let parts: Vec<Vec<Complex<f64>>> = spectra.iter().map(near).collect();
    let turns: Vec<Complex<f64>> = (0..=2 * bins)
        .map(|k| Complex::from_polar(1.0, -TAU * (k as f64 - bins as f64) / points as f64))
        .collect();
    let place = |k: usize| k as f64 / bins as f64 - 1.0;
    let one = Complex::new(1.0, 0.0);
    let mut growth: Option<Complex<f64>> = None;
    for _ in 0..ROUNDS {
        let mut rows = ComplexRows::new(1 + 3 * parts.len());
        for (n, part) in parts.iter().enumerate() {
            let size = part.iter().map(|d| d.norm()).fold(f64::MIN_POSITIVE, f64::max);
            for (k, (d, turn)) in part.iter().zip(&turns).enumerate() {
                let weight =
                    growth.map_or(1.0, |delta| (one - (one + delta) * turn).norm().recip()) / size;
                let mut row = vec![Complex::new(0.0, 0.0); 1 + 3 * parts.len()];
                row[0] = turn * d * weight;
                (0..3).for_each(|power| {
                    row[1 + 3 * n + power] = one * (place(k).powi(power as i32) * weight);
                });
                rows.push(&row, d * (one - turn) * weight);
            }
        }
        growth = Some(rows.solve()?[0]);
    }
    let delta = growth?;
    let pole = (one + delta) * Complex::from_polar(1.0, TAU * bin as f64 / points as f64);
    if pole.norm() >= DECAYS.powf(1.0 / points as f64) {
        return None;
    }
    // What is left of the decays, and how great each one was.
    let (mut amplitudes, mut left, mut all) = (Vec::new(), 0.0, 0.0);
    for part in &parts {
        let basis = |k: usize| [one / (one - (one + delta) * turns[k]), one, one * place(k)];
        let (found, misfit) = fitted(part, basis, |_| 1.0)?;
        amplitudes.push(found[0] / (one - pole.powf(points as f64)));
        left += misfit;
        all += part.iter().map(|d| d.norm_sqr()).sum::<f64>();
    }
    (left <= LEFT.powi(2) * all).then_some(Decay { bin, bins, pole, amplitudes })
}

impl Decay {
    /// Where a bin lies among those around the mode: from −1 to 1.
    fn place(&self, bin: f64) -> f64 {
        (bin - self.bin as f64) / self.bins as f64
    }

    fn mode(&self, sample_time: f64) -> NarrowMode {
        let s = self.pole.ln() / sample_time;
        NarrowMode { frequency_hz: s.norm() / TAU, damping: -s.re / s.norm() }
    }

    /// Takes the decay out of record `n`: what differs by A·z₀ᵏ is A/(z₀ᴺ − 1)·z₀ᵏ itself.
    fn take_out(&self, n: usize, output: &mut [f64], points: usize) {
        let from = begin_of_two(output, points);
        let gone = self.pole.powf(points as f64) - Complex::new(1.0, 0.0);
        let mut rings = 2.0 * self.amplitudes[n] / gone;
        for y in &mut output[from..] {
            *y -= rings.re;
            rings *= self.pole;
        }
    }

    /// The response close to the mode, from the lines around it; none: it is not narrow, or the lines do not feel it.
    fn response(&self, lines: &[Line], points: usize, distance: f64) -> Option<Vec<Line>> {
        let mode = self.mode(1.0 / (points as f64 * distance));
        let half = mode.damping * mode.frequency_hz;
        if 2.0 * half > NARROW * distance {
            return None;
        }
        let place = |f: f64| self.place(f / distance);
        let near: Vec<&Line> = lines.iter().filter(|(f, _)| place(*f).abs() <= 1.001).collect();
        let one = Complex::new(1.0, 0.0);
        let basis = |f: f64| {
            let back = Complex::from_polar(1.0, -TAU * f / (points as f64 * distance));
            [one / (one - self.pole * back), one, one * place(f)]
        };
        if near.len() < self.bins {
            return None;
        }
        let values: Vec<Complex<f64>> = near.iter().map(|(_, g)| *g).collect();
        let weight = |k: usize| values[k].norm().max(f64::MIN_POSITIVE).recip();
        let (found, with) = fitted(&values, |k| basis(near[k].0), weight)?;
        let (_, without) = fitted(&values, |k| [basis(near[k].0)[1], basis(near[k].0)[2]], weight)?;
        if with > BETTER.powi(2) * without {
            return None;
        }
        let far = FITTED * distance;
        let at = |offset: f64| {
            let f = mode.frequency_hz + offset;
            (f, (0..3).map(|k| found[k] * basis(f)[k]).sum())
        };
        Some(offsets(half, far).into_iter().map(at).collect())
    }
}

/// Distances from a mode: even steps on its circle, farther off each 1.25 times the last.
fn offsets(half: f64, far: f64) -> Vec<f64> {
    let mut side: Vec<f64> = (1..=20).map(|k| half * (PI * f64::from(k) / 45.0).tan()).collect();
    while let Some(last) = side.last().filter(|last| **last * 1.25 < far) {
        side.push(1.25 * last);
    }
    side.retain(|offset| *offset <= far);
    let below = side.iter().rev().map(|offset| -offset);
    below.chain([0.0]).chain(side.iter().copied()).collect()
}

/// Coefficients of the basis with the least weighted squares, and what these leave.
fn fitted<const N: usize>(
    values: &[Complex<f64>],
    basis: impl Fn(usize) -> [Complex<f64>; N],
    weight: impl Fn(usize) -> f64,
) -> Option<(Vec<Complex<f64>>, f64)> {
    let mut rows = ComplexRows::new(N);
    for (k, value) in values.iter().enumerate() {
        rows.push(&basis(k).map(|x| x * weight(k)), value * weight(k));
    }
    let found = rows.solve()?;
    let left = |(k, value): (usize, &Complex<f64>)| {
        let fit: Complex<f64> = basis(k).iter().zip(&found).map(|(x, c)| x * c).sum();
        ((value - fit) * weight(k)).norm_sqr()
    };
    let misfit = values.iter().enumerate().map(left).sum();
    Some((found, misfit))
}

/// A complex system of least squares as a real one.
struct ComplexRows {
    columns: usize,
    rows: Reduced,
}

impl ComplexRows {
    fn new(columns: usize) -> Self {
        ComplexRows { columns, rows: Reduced::new(2 * columns) }
    }

    fn push(&mut self, row: &[Complex<f64>], right: Complex<f64>) {
        self.rows.push(row.iter().flat_map(|x| [x.re, -x.im]).chain([right.re]));
        self.rows.push(row.iter().flat_map(|x| [x.im, x.re]).chain([right.im]));
    }

    fn solve(self) -> Option<Vec<Complex<f64>>> {
        let columns = self.columns;
        let found = self.rows.solve(2 * columns).ok()?.x;
        let numbers: Vec<_> = found.chunks_exact(2).map(|c| Complex::new(c[0], c[1])).collect();
        (numbers.len() == columns && numbers.iter().all(|x| x.is_finite())).then_some(numbers)
    }
}

#[cfg(test)]
mod tests;
