//! The noise floor of an output.

use std::ops::Range;

use numerics::median;

use crate::spectrum::{self, Bands};
use crate::thresholds::noise::Thresholds;

/// How the power of the noise is spread over frequency: its density over that of white noise of the
/// same variance is `white·(1 + corner/f)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    /// Part of the variance that is white.
    pub(crate) white: f64,
    /// Frequency in Hz at which the part that grows as 1/f equals the white one.
    pub(crate) corner: f64,
}

impl Shape {
    pub(crate) const WHITE: Self = Self { white: 1.0, corner: 0.0 };

    /// With this white part of the variance between two frequencies; the rest grows as 1/f.
    pub(crate) fn with_white(white: f64, low: f64, high: f64) -> Self {
        let white = white.clamp(Thresholds::LEAST_WHITE, 1.0);
        Self { white, corner: (1.0 / white - 1.0) * (high - low) / (high / low).ln() }
    }

    /// Mean density between two frequencies in Hz.
    pub(crate) fn density(&self, low: f64, high: f64) -> f64 {
        self.white * growth(self.corner, low, high)
    }
}

/// Mean of `1 + corner/f` between two frequencies.
fn growth(corner: f64, low: f64, high: f64) -> f64 {
    1.0 + corner * (high / low).ln() / (high - low)
}

/// Level of the white part (as a standard deviation) and corner in Hz of records at rest: the largest
/// likelihood of their band powers; lines that stand out, as of the mains, do not count.
pub(crate) fn of_rest(records: &[&[f64]], sample: f64) -> Option<(f64, f64)> {
    let longest = records.iter().map(|r| r.len()).max()?;
    if longest < Thresholds::REST_ROWS {
        return None;
    }
    let bands = Bands::new(longest, sample);
    let mut terms: Vec<(usize, f64, f64)> = Vec::new();
    for record in records {
        for (band, powers) in spectrum::lines_of_bands(record, &bands, sample) {
            terms.extend(trimmed(powers).map(|(power, count)| (band, power, count)));
        }
    }
    let nyquist = 0.5 / sample;
    let corners = (0..=48).map(|k| match k {
        0 => 0.0,
        _ => bands.ends[0] * (0.5 * nyquist / bands.ends[0]).powf(f64::from(k) / 48.0),
    });
    let total: f64 = terms.iter().map(|(_, _, n)| n).sum();
    let fitted = corners.map(|corner| {
        let shape = |band: usize| growth(corner, bands.ends[band], bands.ends[band + 1]);
        let level = terms.iter().map(|(b, p, n)| n * p / shape(*b)).sum::<f64>() / total;
        let loss: f64 = terms
            .iter()
            .map(|(b, p, n)| n * ((level * shape(*b)).ln() + p / (level * shape(*b))))
            .sum();
        (loss, level, corner)
    });
    let best = fitted.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.1 > 0.0).then(|| (best.1.sqrt(), best.2))
}

/// Mean and number of the powers without those that stand out.
fn trimmed(mut powers: Vec<f64>) -> Option<(f64, f64)> {
    if powers.is_empty() {
        return None;
    }
    if powers.len() < Thresholds::TRIMMED_LINES {
        let n = powers.len() as f64;
        return Some((powers.iter().sum::<f64>() / n, n));
    }
    powers.sort_by(f64::total_cmp);
    let limit = Thresholds::TRIMMED_ABOVE * powers[powers.len() / 2];
    let kept = powers.partition_point(|p| *p <= limit);
    let mean = powers[..kept].iter().sum::<f64>() / kept as f64;
    let part = Thresholds::TRIMMED_MEAN.max(1.0 - Thresholds::TRIMMED_FALL * kept as f64);
    Some((mean / part, kept as f64))
}

/// Corner in Hz of the noise under residuals whose white part has the variance `white`: from the
/// quietest records of each band, as what is driven by the command differs between records.
pub(crate) fn corner_under(
    residual: &[f64],
    records: impl Iterator<Item = Range<usize>>,
    white: f64,
    sample: f64,
) -> f64 {
    let rows: Vec<Range<usize>> = records.collect();
    let Some(longest) = rows.iter().map(Range::len).max() else { return 0.0 };
    let bands = Bands::new(longest, sample);
    let count = bands.ends.len() - 1;
    let mut powers: Vec<Vec<f64>> = vec![Vec::new(); count];
    for rows in rows {
        for (band, lines) in spectrum::lines_of_bands(&residual[rows], &bands, sample) {
            if lines.len() >= Thresholds::COLOUR_LINES {
                powers[band].push(lines.iter().sum::<f64>() / lines.len() as f64);
            }
        }
    }
    let nyquist = 0.5 / sample;
    let mut corners: Vec<f64> = (0..count)
        .filter(|band| {
            bands.ends[band + 1] < Thresholds::COLOUR_BELOW * nyquist && !powers[*band].is_empty()
        })
        .map(|band| {
            let mut all = powers[band].clone();
            all.sort_by(f64::total_cmp);
            let quiet = all[(all.len() - 1) / 4];
            let one = growth(1.0, bands.ends[band], bands.ends[band + 1]) - 1.0;
            (quiet / white - 1.0).max(0.0) / one
        })
        .collect();
    corners.sort_by(f64::total_cmp);
    let middle = corners.get(corners.len() / 2).copied().unwrap_or(0.0);
    let low = bands.ends[0];
    middle.min(Thresholds::MOST_COLOUR * (nyquist - low) / (nyquist / low).ln())
}

/// Variance between two frequencies over that of the white part.
pub(crate) fn coloured(corner: f64, low: f64, high: f64) -> f64 {
    growth(corner, low, high)
}

/// Standard deviation of white noise from second differences: `median |Δ²y| / (0.6745·√6)`. Signals
/// that move smoothly cancel; a lower bound where the noise is coloured. A reading that is rounded so
/// coarsely that most second differences are zero gives the rounding's own `q/√12`.
pub(crate) fn second_differences(
    y: &[f64],
    records: impl Iterator<Item = Range<usize>>,
) -> Option<f64> {
    let mut all: Vec<f64> = Vec::new();
    for rows in records {
        let y = &y[rows];
        all.extend(y.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()));
    }
    if all.len() < Thresholds::DIFFERENCES {
        return None;
    }
    let sigma = median(&mut all)? / (0.6745 * 6f64.sqrt());
    if sigma > 0.0 {
        return Some(sigma);
    }
    let step = all.iter().copied().filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    step.is_finite().then(|| step / 12f64.sqrt())
}

/// Standard deviation of white noise of a residual from its differences at the highest order that still sees the noise
/// only: fourth differences, whose weights square to 70.
pub(crate) fn fourth_differences(
    r: &[f64],
    records: impl Iterator<Item = Range<usize>>,
) -> Option<f64> {
    let mut all: Vec<f64> = Vec::new();
    for rows in records {
        let r = &r[rows];
        all.extend(
            r.windows(5).map(|w| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs()),
        );
    }
    if all.len() < Thresholds::DIFFERENCES {
        return None;
    }
    median(&mut all).filter(|m| *m > 0.0).map(|median| median / (0.6745 * 70f64.sqrt()))
}

/// What does not repeat, where records repeat their command.
pub(crate) struct Repeats {
    /// Differences of neighbouring periods over √2, which have the noise's variance, a straight line taken
    /// out of each.
    pub(crate) parts: Vec<Vec<f64>>,
}

impl Repeats {
    /// Of an output over these records; `None` where no command repeats.
    ///
    /// The first period is not settled: with three or more it is left out, of two its first half.
    pub(crate) fn of(
        command: &[f64],
        y: &[f64],
        records: impl Iterator<Item = Range<usize>>,
    ) -> Option<Self> {
        let mut parts = Vec::new();
        for rows in records {
            // The first row is the rest under its own command; what moved the others is the row before.
            let rows = (rows.start + 1).min(rows.end)..rows.end;
            let (u, y) = (&command[rows.clone()], &y[rows]);
            let Some(period) = period_of(u) else { continue };
            let last = y.len() - period;
            let mut from = if last + 1 < 2 * period { period / 2 } else { period };
            while from + 8 < last {
                let end = ((from / period + 1) * period).min(last);
                let d: Vec<f64> = (from..end).map(|k| y[k + period] - y[k]).collect();
                parts.push(level(&d));
                from = end;
            }
        }
        let count: usize = parts.iter().map(Vec::len).sum();
        (count > Thresholds::REPEATED_ROWS).then_some(Self { parts })
    }

    /// The repeats' standard deviation.
    pub(crate) fn sigma(&self) -> Option<f64> {
        let squares: f64 = self.parts.iter().flatten().map(|d| d * d).sum();
        let freedom: f64 = self.parts.iter().map(|d| d.len() as f64 - 2.0).sum();
        Some((squares / freedom).sqrt()).filter(|s| *s > 0.0)
    }

    /// Level of the white part and corner, as [`of_rest`] has them.
    pub(crate) fn shape(&self, sample: f64) -> Option<(f64, f64)> {
        let parts: Vec<&[f64]> = self.parts.iter().map(Vec::as_slice).collect();
        of_rest(&parts, sample)
    }
}

/// Differences over √2 without their straight line.
fn level(d: &[f64]) -> Vec<f64> {
    let n = d.len() as f64;
    let mean = d.iter().sum::<f64>() / n;
    let centre = 0.5 * (n - 1.0);
    let (mut cross, mut square) = (0.0, 0.0);
    for (k, d) in d.iter().enumerate() {
        let t = k as f64 - centre;
        cross += t * (d - mean);
        square += t * t;
    }
    let slope = cross / square.max(1.0);
    let line = |k: usize| mean + slope * (k as f64 - centre);
    d.iter().enumerate().map(|(k, d)| (d - line(k)) * std::f64::consts::FRAC_1_SQRT_2).collect()
}

/// The shortest shift at which a signal repeats, over a third of its length at least: to half a thousandth of its range, as a command
/// that was measured does, where it moves by a tenth of it in between.
fn period_of(u: &[f64]) -> Option<usize> {
    let (low, high) =
        u.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let range = high - low;
    let close = Thresholds::REPEATED_NEAR * range;
    if close.is_nan() || close <= 0.0 {
        return None;
    }
    (8..=2 * u.len() / 3).find(|shift| {
        // A few places first, then all.
        let same = |k: usize| (u[k] - u[k + shift]).abs() <= close;
        let last = u.len() - shift;
        let moves = |k: usize| (u[k] - u[k + shift / 2]).abs() > Thresholds::REPEATED_MOVES * range;
        (0..16).all(|k| same(k * (last - 1) / 15)) && (0..last).all(same) && (0..last).any(moves)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<f64> {
        let mut random = numerics::random::SplitMix64::new(7);
        (0..n).map(|_| random.normal()).collect()
    }

    #[test]
    fn three_estimates_of_one_noise() {
        let n = 20_000;
        let u: Vec<f64> =
            (0..n).map(|k| (std::f64::consts::TAU * (k % 1000) as f64 / 1000.0).sin()).collect();
        let y: Vec<f64> = u.iter().zip(noise(n)).map(|(u, e)| 3.0 * u + 0.01 * e).collect();
        let all = || std::iter::once(0..n);
        let repeats = Repeats::of(&u, &y, all()).unwrap();
        let (white, corner) = repeats.shape(1e-4).unwrap();
        for sigma in [
            second_differences(&y, all()),
            fourth_differences(&y, all()),
            repeats.sigma(),
            Some(white * coloured(corner, 0.5, 5e3).sqrt()),
        ] {
            assert!((sigma.unwrap() / 0.01 - 1.0).abs() < 0.05, "{sigma:?}");
        }
    }

    #[test]
    fn two_periods_of_a_rich_command_tell_its_noise() {
        // No difference of neighbours cancels what fills the whole band; the transient is in the first half.
        let n = 8192;
        let one = noise(n);
        let played = |k: usize| one[k % n];
        let u: Vec<f64> = (0..2 * n).map(|k| played(k.saturating_sub(1))).collect();
        let y: Vec<f64> = u
            .iter()
            .zip(noise(3 * n).split_off(n))
            .enumerate()
            .map(|(k, (u, e))| 3.0 * u + 0.01 * e + 5.0 * (-(k as f64) / 100.0).exp())
            .collect();
        let all = || std::iter::once(0..2 * n);
        assert!(second_differences(&y, all()).unwrap() > 1.0);
        let sigma = Repeats::of(&u, &y, all()).unwrap().sigma().unwrap();
        assert!((sigma / 0.01 - 1.0).abs() < 0.05, "{sigma}");
    }

    #[test]
    fn signals_that_do_not_repeat_have_no_period() {
        let u: Vec<f64> = (0..3000).map(|k| (f64::from(k).powi(2) * 1e-3).sin()).collect();
        assert_eq!(period_of(&u), None);
        assert_eq!(period_of(&[1.0; 100]), None);
        let ramp: Vec<f64> = (0..30_000).map(f64::from).collect();
        assert_eq!(period_of(&ramp), None);
    }
}
