//! What is left beside the noise: how accurate an answer is.
//!
//! No formula follows a machine down to the noise of its sensor. The residual of a candidate is taken as noise
//! and a discrepancy of a size s and a time τ of its own, whose correlation falls as exp(−t/τ). With sample time
//! T and a = exp(−T/τ) its density over that of white noise of variance 1, at frequency f, is
//!
//! ```text
//! D(f) = (1 − a²)/(1 − 2a·cos(2πfT) + a²),        S(f) = noise(f) + s²·D(f)
//! ```
//!
//! Size and time are those of the largest likelihood of the lines P of the periodogram (P. Whittle, Ark. Mat. 2
//! (1953) 423–434), `−ln L = Σ (ln S + P/S)`.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::noise::Shape;
use crate::spectrum::{self, Bands};
use crate::thresholds::answer::Thresholds;

/// The discrepancy of a residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Discrepancy {
    /// Standard deviation over that of the noise; 0 where the noise is all.
    pub(crate) size: f64,
    /// Correlation time in s.
    pub(crate) time: f64,
}

/// Lines of a band of all records: frequency, density of the noise, sum of their powers, number.
struct Lines {
    frequency: f64,
    noise: f64,
    power: f64,
    count: f64,
}

/// The discrepancy of residuals in standard deviations of a noise of this shape.
pub(crate) fn of(
    residual: &[f64],
    records: impl Iterator<Item = Range<usize>>,
    shape: Shape,
    sample: f64,
) -> Discrepancy {
    let rows: Vec<Range<usize>> = records.collect();
    let longest = rows.iter().map(Range::len).max().unwrap_or(0);
    let bands = Bands::new(longest, sample);
    let mut lines: Vec<Lines> = bands
        .ends
        .windows(2)
        .map(|ends| Lines {
            frequency: (ends[0] * ends[1]).sqrt(),
            noise: shape.density(ends[0], ends[1]),
            power: 0.0,
            count: 0.0,
        })
        .collect();
    for rows in rows {
        for (band, powers) in spectrum::lines_of_bands(&residual[rows], &bands, sample) {
            lines[band].power += powers.iter().sum::<f64>();
            lines[band].count += powers.len() as f64;
        }
    }
    lines.retain(|l| l.count > 0.0);
    let loss = |size: f64, time: f64| {
        let of_line = |l: &Lines| {
            let s = l.noise + size * size * density(time, l.frequency, sample);
            l.count * s.ln() + l.power / s
        };
        2.0 / Thresholds::HANN_LINES * lines.iter().map(of_line).sum::<f64>()
    };
    let largest = lines.iter().map(|l| l.power / l.count).fold(1.0, f64::max).sqrt();
    let length = longest as f64 * sample;
    let times = logarithmic(sample, length.max(2.0 * sample), Thresholds::DISCREPANCY_TIMES);
    let all = times.flat_map(|time| {
        logarithmic(Thresholds::DISCREPANCY_LEAST, 10.0 * largest, Thresholds::DISCREPANCY_SIZES)
            .map(move |size| (size, time))
    });
    let with = all.map(|(size, time)| (loss(size, time), size, time));
    let best = with.min_by(|a, b| a.0.total_cmp(&b.0));
    let most = loss(0.0, sample) - Thresholds::DISCREPANCY_BRINGS;
    let (_, size, time) = best.filter(|best| best.0 < most).unwrap_or((0.0, 0.0, sample));
    Discrepancy { size, time }
}

fn logarithmic(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| low * (high / low).powf(k as f64 / (count - 1) as f64))
}

/// Density over that of white noise of the same variance.
fn density(time: f64, frequency: f64, sample: f64) -> f64 {
    let a = (-sample / time).exp();
    (1.0 - a * a) / (1.0 - 2.0 * a * (TAU * frequency * sample).cos() + a * a)
}

#[cfg(test)]
mod tests {
    use numerics::random::SplitMix64;

    use super::*;

    const SEEDS: std::ops::Range<u64> = 0..15;
    const SAMPLE: f64 = 1e-3;

    /// White noise of 1 and a discrepancy of this size and time.
    fn residual(seed: u64, (size, time): (f64, f64), rows: usize) -> Vec<f64> {
        let mut random = SplitMix64::new(seed);
        let a = (-SAMPLE / time).exp();
        let mut slow = 0.0;
        (0..rows)
            .map(|_| {
                slow = a * slow + (1.0 - a * a).sqrt() * random.normal();
                size * slow + random.normal()
            })
            .collect()
    }

    fn found(residual: &[f64]) -> Discrepancy {
        let half = residual.len() / 2;
        of(residual, [0..half, half..residual.len()].into_iter(), Shape::WHITE, SAMPLE)
    }

    #[test]
    fn size_and_time_are_those_of_what_is_left() {
        for truth in [(2.0, 0.03), (0.7, 0.02), (8.0, 0.01)] {
            let mut sizes = Vec::new();
            for seed in SEEDS {
                let d = found(&residual(seed, truth, 20_000));
                assert!((d.time / truth.1).ln().abs() < 0.6, "seed {seed}, {truth:?}: {d:?}");
                sizes.push(d.size / truth.0);
            }
            // The slowest has some 300 independent values in a log, and times lie on a grid: one log may be off by 30 %.
            sizes.sort_by(f64::total_cmp);
            let (middle, ends) = (sizes[sizes.len() / 2], [sizes[0], sizes[sizes.len() - 1]]);
            assert!((middle - 1.0).abs() < 0.15, "{truth:?}: {sizes:?}");
            assert!(ends.iter().all(|size| (size - 1.0).abs() < 0.4), "{truth:?}: {sizes:?}");
        }
        // White noise has none, or by chance one of some hundredths of its power.
        let sizes: Vec<f64> = SEEDS.map(|s| found(&residual(s, (0.0, 0.1), 20_000)).size).collect();
        assert!(sizes.iter().filter(|size| **size == 0.0).count() >= 12, "{sizes:?}");
        assert!(sizes.iter().all(|size| *size < 0.2), "{sizes:?}");
    }
}
