//! Spectra of residuals: powers in bands, lines, coherence.

use std::ops::Range;

use numerics::fft::Fft;
use numerics::spectrum::windowed;
use numerics::{Complex, median};

use crate::thresholds::search::Thresholds;

/// Bands of frequency, even on a logarithmic scale.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bands {
    /// Ends in Hz, increasing.
    pub(crate) ends: Vec<f64>,
}

impl Bands {
    /// Bands that a stretch of this many rows can show.
    pub(crate) fn new(rows: usize, sample: f64) -> Self {
        let length = (rows.max(8) as f64) * sample;
        let (low, high) = (1.0 / length, 0.5 / sample);
        let ends = (0..=Thresholds::BANDS)
            .map(|k| low * (high / low).powf(k as f64 / Thresholds::BANDS as f64))
            .collect();
        Self { ends }
    }

    /// Number of the band of a frequency.
    fn of(&self, frequency: f64) -> Option<usize> {
        let last = self.ends.len().checked_sub(2)?;
        let first = *self.ends.first()?;
        if frequency < first * (1.0 - 1e-9) {
            return None;
        }
        Some(self.ends[1..].partition_point(|end| *end < frequency).min(last))
    }
}

/// Power density of a signal over frequency, one-sided, such that white noise of variance 1 has the
/// density 1; with a Hann window, the mean taken out.
pub(crate) fn density(signal: &[f64]) -> Vec<f64> {
    let n = signal.len();
    if n < 8 {
        return Vec::new();
    }
    let spectrum = windowed(signal);
    // Σ w² = 3n/8 for a Hann window.
    let scale = 8.0 / (3.0 * n as f64);
    spectrum[..=n / 2].iter().map(|c| c.norm_sqr() * scale).collect()
}

/// What has to go into a linear system to give this signal, the system at rest before (Wiener's
/// deconvolution): `E = R H*/(|H|² + noise)`, with the power of the signal's noise over that of what is
/// sought, both taken as white. `response` is the system's answer to one row of 1, as long as the signal.
pub(crate) fn deconvolve(signal: &[f64], response: &[f64], noise: f64) -> Vec<f64> {
    // As much again of zeros, so that the end does not run into the beginning.
    let length = 2 * signal.len();
    if length == 0 {
        return Vec::new();
    }
    let transform = Fft::forward(length);
    let spectrum = |values: &[f64]| {
        let mut padded = values.to_vec();
        padded.resize(length, 0.0);
        transform.of_real(&padded)
    };
    let mut sought = spectrum(signal);
    for (r, h) in sought.iter_mut().zip(spectrum(response)) {
        *r *= h.conj() / (h.norm_sqr() + noise);
    }
    Fft::inverse(length).process(&mut sought);
    sought.iter().take(signal.len()).map(|c| c.re / length as f64).collect()
}

/// The densities of the lines in each band that has any.
pub(crate) fn lines_of_bands(signal: &[f64], bands: &Bands, sample: f64) -> Vec<(usize, Vec<f64>)> {
    let mut all: Vec<(usize, Vec<f64>)> = Vec::new();
    // The first line is what the window leaves of the mean.
    for (k, power) in density(signal).into_iter().enumerate().skip(2) {
        let Some(band) = bands.of(k as f64 / (signal.len() as f64 * sample)) else { continue };
        match all.last_mut() {
            Some((last, lines)) if *last == band => lines.push(power),
            _ => all.push((band, vec![power])),
        }
    }
    all
}

/// Mean density in each band; NaN where a band has no line.
pub(crate) fn band_powers(signal: &[f64], bands: &Bands, sample: f64) -> Vec<f64> {
    let density = density(signal);
    let count = bands.ends.len().saturating_sub(1);
    let (mut sums, mut counts) = (vec![0.0; count], vec![0.0; count]);
    for (k, power) in density.iter().enumerate().skip(1) {
        let frequency = k as f64 / (signal.len() as f64 * sample);
        if let Some(band) = bands.of(frequency) {
            sums[band] += power;
            counts[band] += 1.0;
        }
    }
    sums.iter().zip(&counts).map(|(s, c)| if *c > 0.0 { s / c } else { f64::NAN }).collect()
}

/// Frequencies at which what is left answers to what is simulated more than beside them, those first at which the
/// answer holds the most power: Welch's estimate over segments of all stretches. Starts of fits, no findings: in noise some
/// lines stand out, too.
pub(crate) fn resonances(
    simulated: &[f64],
    left: &[f64],
    stretches: impl Iterator<Item = Range<usize>>,
    sample: f64,
) -> Vec<f64> {
    let stretches: Vec<Range<usize>> = stretches.collect();
    let most = stretches.iter().map(Range::len).max().unwrap_or(0) / Thresholds::SEGMENTS;
    let length = (Thresholds::SEGMENT_SHORTEST..=Thresholds::SEGMENT_LONGEST)
        .rev()
        .find(|n| n.is_power_of_two() && *n <= most);
    let Some(length) = length else { return Vec::new() };
    let half = length / 2;
    let (mut cross, mut drive, mut power) =
        (vec![Complex::default(); half], vec![0.0; half], vec![0.0; half]);
    let mut segments = 0.0;
    for rows in stretches {
        let mut from = rows.start;
        while from + length <= rows.end {
            let [x, r] = [simulated, left].map(|signal| windowed(&signal[from..from + length]));
            for k in 0..half {
                cross[k] += r[k] * x[k].conj();
                drive[k] += x[k].norm_sqr();
                power[k] += r[k].norm_sqr();
            }
            (from, segments) = (from + half, segments + 1.0);
        }
    }
    let answer = |k: usize| cross[k].norm() / drive[k].max(f64::MIN_POSITIVE);
    let explained = |k: usize| cross[k].norm() * answer(k);
    let answers: Vec<f64> = (0..half).map(answer).collect();
    let mut peaks: Vec<(f64, usize)> = Vec::new();
    for k in 4..half.saturating_sub(Thresholds::PEAK_BESIDE) {
        let beside = &answers[k - Thresholds::PEAK_BESIDE..=k + Thresholds::PEAK_BESIDE];
        let is_peak = beside.iter().all(|a| *a <= answers[k]);
        // Noise alone is coherent by one over the segments.
        if !is_peak || explained(k) < Thresholds::PEAK_COHERENT / segments * power[k] {
            continue;
        }
        let width =
            ((Thresholds::PEAK_MEDIAN * k as f64) as usize).max(2 * Thresholds::PEAK_BESIDE);
        let mut neighbours =
            answers[k.saturating_sub(width).max(1)..(k + width).min(half)].to_vec();
        if median(&mut neighbours)
            .is_some_and(|median| answers[k] > Thresholds::PEAK_ABOVE * median)
        {
            peaks.push((
                (k - Thresholds::PEAK_BESIDE..=k + Thresholds::PEAK_BESIDE).map(explained).sum(),
                k,
            ));
        }
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let step = 1.0 / (length as f64 * sample);
    peaks.iter().take(Thresholds::RESONANCES).map(|(_, k)| step * *k as f64).collect()
}

/// Frequencies of the lines that stand out of their surroundings most, strongest first.
pub(crate) fn lines(signal: &[f64], sample: f64, most: usize) -> Vec<f64> {
    let density = density(signal);
    let n = density.len();
    if n < Thresholds::LINE_SPECTRUM {
        return Vec::new();
    }
    let (least, most_beside) = Thresholds::LINE_BESIDE_LINES;
    let width = (n / Thresholds::LINE_BESIDE).clamp(least, most_beside);
    let mut found: Vec<(f64, usize)> = Vec::new();
    for k in 3..n - 2 {
        let is_peak = density[k] >= density[k - 1] && density[k] > density[k + 1];
        if !is_peak {
            continue;
        }
        let mut neighbours = density[k.saturating_sub(width).max(1)..(k + width).min(n)].to_vec();
        let ratio = density[k] / median(&mut neighbours).unwrap_or(0.0).max(Thresholds::LINE_FLOOR);
        if ratio > Thresholds::LINE_ABOVE {
            found.push((ratio, k));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let step = 1.0 / (signal.len() as f64 * sample);
    found.iter().take(most).map(|(_, k)| step * refined(&density, *k)).collect()
}

/// Place of a peak between lines, for a Hann window.
fn refined(density: &[f64], k: usize) -> f64 {
    let (a, b, c) = (density[k - 1].sqrt(), density[k].sqrt(), density[k + 1].sqrt());
    // Ratio of neighbours under a Hann window: shift = (2r − 1)/(1 + r).
    let (other, sign) = if c > a { (c, 1.0) } else { (a, -1.0) };
    let ratio = other / b.max(f64::MIN_POSITIVE);
    k as f64 + sign * ((2.0 * ratio - 1.0) / (1.0 + ratio)).clamp(-0.5, 0.5)
}

/// Squared coherence of two signals over the power of the first: Welch, about 16 segments that
/// overlap by half; the bias of incoherent signals is taken off.
pub(crate) fn coherence(residual: &[f64], input: &[f64]) -> Option<f64> {
    let n = residual.len().min(input.len());
    let length = 2 * (n / 17);
    if length < Thresholds::COHERENCE_ROWS {
        return None;
    }
    let (mut rr, mut uu) = (vec![0.0; length / 2], vec![0.0; length / 2]);
    let mut ru = vec![Complex::new(0.0, 0.0); length / 2];
    let mut segments = 0.0_f64;
    let mut from = 0;
    while from + length <= n {
        let a = windowed(&residual[from..from + length]);
        let b = windowed(&input[from..from + length]);
        for k in 1..length / 2 {
            rr[k] += a[k].norm_sqr();
            uu[k] += b[k].norm_sqr();
            ru[k] += a[k] * b[k].conj();
        }
        segments += 1.0;
        from += length / 2;
    }
    let total: f64 = rr.iter().sum();
    let bias = 1.0 / (0.6 * segments).max(1.0);
    let coherent: f64 = (1..length / 2)
        .filter(|k| rr[*k] > 0.0 && uu[*k] > 0.0)
        .map(|k| {
            let raw = ru[k].norm_sqr() / (rr[k] * uu[k]);
            rr[k] * ((raw - bias) / (1.0 - bias)).max(0.0)
        })
        .sum();
    (total > 0.0).then(|| coherent / total)
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::*;

    #[test]
    fn what_went_through_a_system_comes_back() {
        // A ringing system, and steps in its input, which its output hardly shows.
        let response: Vec<f64> =
            (0..300).map(f64::from).map(|k| 0.1 * (-0.01 * k).exp() * (0.5 * k).sin()).collect();
        let input: Vec<f64> = (0..300).map(|k| f64::from((k / 7) % 3) - 1.0).collect();
        let output: Vec<f64> =
            (0..300).map(|n| (0..=n).map(|k| response[k] * input[n - k]).sum::<f64>()).collect();
        let rms = |a: &[f64], b: &[f64]| {
            let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
            (squares / a.len() as f64).sqrt()
        };
        // The end has not come out of the system yet.
        let back = deconvolve(&output, &response, 1e-6);
        assert!(rms(&back[..250], &input[..250]) < 0.05, "{}", rms(&back[..250], &input[..250]));
        // All is noise: nothing is sought.
        let none = deconvolve(&output, &response, 1e9);
        assert!(none.iter().all(|e| e.abs() < 1e-3));
    }

    #[test]
    fn white_noise_has_the_density_of_its_variance() {
        let mut random = SplitMix64::new(1);
        let noise: Vec<f64> = (0..4096).map(|_| random.normal()).collect();
        let density = density(&noise);
        let mean = density[1..].iter().sum::<f64>() / (density.len() - 1) as f64;
        assert!((mean - 1.0).abs() < 0.1, "{mean}");
    }

    #[test]
    fn a_line_is_found_where_it_is() {
        let signal: Vec<f64> = (0..3000)
            .map(|k| (std::f64::consts::TAU * 33.37 * f64::from(k) * 1e-3).sin())
            .collect();
        let noise = |k: usize| ((k * 7919) % 1000) as f64 * 1e-3 - 0.5;
        let signal: Vec<f64> = signal.iter().enumerate().map(|(k, s)| s + noise(k)).collect();
        let found = lines(&signal, 1e-3, 3);
        assert!((found[0] - 33.37).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn coherence_tells_driven_from_not_driven() {
        let u: Vec<f64> = (0..8000).map(|k| (f64::from(k * k % 4001) * 0.37).sin()).collect();
        let other: Vec<f64> =
            (0..8000).map(|k| (f64::from(k * 31 % 3989).powi(2) * 0.11).sin()).collect();
        let driven: Vec<f64> = u.windows(2).map(|w| w[0] - 0.5 * w[1]).collect();
        assert!(coherence(&driven, &u).unwrap() > 0.9);
        assert!(coherence(&other, &u).unwrap() < 0.2);
    }

    #[test]
    fn the_first_resonance_is_where_what_is_left_answers() {
        use surround::{Block, Signals};

        let (rows, sample) = (20_000, 1e-3);
        for (seed, frequency) in
            (0..10).flat_map(|seed| [31.0, 120.0, 260.0].map(|frequency| (seed, frequency)))
        {
            let mut random = SplitMix64::new(seed);
            let mut noise = || (0..rows).map(|_| random.uniform() - 0.5).collect::<Vec<f64>>();
            let (simulated, other) = (noise(), noise());
            let found = |left: &[f64]| {
                resonances(&simulated, left, [0..rows / 2, rows / 2..rows].into_iter(), sample)
            };
            let mut mode = vec![0.0; rows];
            let block = Block::SecondOrder.prepare(&[frequency, 0.02], sample).unwrap();
            block.run(Signals::path(&simulated), &mut mode);
            let left: Vec<f64> = mode.iter().zip(&other).map(|(m, n)| 0.1 * m + 0.3 * n).collect();
            let first = found(&left)[0];
            assert!((first / frequency - 1.0).abs() < 0.03, "seed {seed}: {frequency} {first}");
        }
    }
}
