//! Converters whose steps the residual shows: it is then a periodic function of what is converted.

use std::f64::consts::TAU;

use crate::block::Span;

/// Most rows that are looked at.
const ROWS: usize = 4000;
/// Most steps over the range.
const STEPS: usize = 1024;
/// Resolution of the search, in periods over the range.
const FINE: f64 = 0.25;
/// Codes of which one is missing.
const CODES: [u32; 8] = [3, 4, 5, 6, 8, 10, 12, 16];
/// Part of the residual's power that steps with missing codes must show to be tried.
const SHOWN: f64 = 0.03;

/// Places where the residual of a model is looked at.
pub(crate) struct Converted {
    /// What is converted, over its range, and the residual.
    places: Vec<(f64, f64)>,
}

/// Steps of which some are missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gaps {
    /// Of so many codes one is missing.
    pub(crate) every: u32,
    /// Which one.
    pub(crate) missing: u32,
    /// Steps over the range.
    pub(crate) steps: f64,
    /// Phase of the steps.
    pub(crate) phase: f64,
}

/// The code below x (in steps), or the one before where it is missing.
pub(crate) fn code(x: f64, every: u32, missing: u32) -> f64 {
    let code = x.floor();
    if code.rem_euclid(f64::from(every)) == f64::from(missing) { code - 1.0 } else { code }
}

impl Converted {
    /// Of these rows of a signal and a residual; the rows are thinned evenly.
    pub(crate) fn new(
        signal: &[f64],
        span: Span,
        residual: &[f64],
        rows: impl Iterator<Item = usize>,
    ) -> Self {
        let rows: Vec<usize> = rows.collect();
        let stride = rows.len().div_ceil(ROWS).max(1);
        let place = |k: &usize| (signal[*k] / (2.0 * span.half), residual[*k]);
        Self { places: rows.iter().step_by(stride).map(place).collect() }
    }

    /// Power and angle of the residual's part with this many periods over the range.
    fn power(&self, periods: f64) -> (f64, f64) {
        let (mut s, mut c) = (0.0, 0.0);
        for (x, r) in &self.places {
            let (sin, cos) = (TAU * periods * x).sin_cos();
            s += r * sin;
            c += r * cos;
        }
        (s * s + c * c, s.atan2(c))
    }

    /// Powers at all multiples of [`FINE`]: each place turns on by its own angle.
    fn powers(&self) -> Vec<f64> {
        let count = (STEPS as f64 / FINE) as usize;
        let mut powers = vec![0.0; count + 1];
        // Few places at a time stay in the cache; their sums are kept for all periods.
        let mut sums = vec![(0.0, 0.0); count + 1];
        for places in self.places.chunks(8) {
            let mut turn = [(1.0, 0.0); 8];
            let mut at = [(0.0, 0.0); 8];
            for (k, (x, r)) in places.iter().enumerate() {
                let (sin, cos) = (TAU * FINE * x).sin_cos();
                (turn[k], at[k]) = ((cos, sin), (*r, 0.0));
            }
            for sum in &mut sums {
                let (mut c, mut s) = (0.0, 0.0);
                for ((a, b), at) in turn.iter().zip(&mut at) {
                    let (x, y) = *at;
                    c += x;
                    s += y;
                    *at = (x * a - y * b, x * b + y * a);
                }
                sum.0 += c;
                sum.1 += s;
            }
        }
        for (power, (c, s)) in powers.iter_mut().zip(sums) {
            *power = c * c + s * s;
        }
        powers
    }

    /// The powers that stand out of those around them, and zero for the others: what is slow over the
    /// range is no converter's.
    fn standing_out(&self) -> Vec<f64> {
        /// Periods on either side.
        const AROUND: usize = 40;
        /// Over the median of those.
        const OVER: f64 = 12.0;
        let powers = self.powers();
        let over = |k: usize| {
            let end = (k + AROUND + 1).min(powers.len());
            let mut around = powers[k.saturating_sub(AROUND)..end].to_vec();
            let middle = around.len() / 2;
            let median = *around.select_nth_unstable_by(middle, f64::total_cmp).1;
            if powers[k] > OVER * median { powers[k] } else { 0.0 }
        };
        (0..powers.len()).map(over).collect()
    }

    /// The periods that stand out most, as steps over the range and phase, to start from.
    pub(crate) fn steps(&self) -> Vec<(f64, f64)> {
        /// A line is so wide at most.
        const WIDE: usize = 4;
        let over = self.standing_out();
        let is_peak = |k: &usize| {
            let beside = k - WIDE..(k + WIDE + 1).min(over.len());
            over[*k] > 0.0 && over[beside].iter().all(|other| *other <= over[*k])
        };
        let mut all: Vec<usize> = (8..over.len()).filter(is_peak).collect();
        all.sort_by(|a, b| over[*b].total_cmp(&over[*a]).then(a.cmp(b)));
        all.iter()
            .take(3)
            .flat_map(|k| {
                let coarse = FINE * *k as f64;
                let fine = (-8..=8).map(move |i| coarse + 0.03 * f64::from(i));
                let best = fine.map(|s| (self.power(s), s)).max_by(|a, b| a.0.0.total_cmp(&b.0.0));
                // The rounding error −Σ sin(2πk(u/q − p))/(πk) has its first harmonic at this angle.
                best.into_iter().flat_map(|((_, angle), s)| {
                    let phase = 0.25 + angle / TAU;
                    [0.0, 0.25, -0.25].map(|shift| (s, (phase + shift).rem_euclid(1.0)))
                })
            })
            .collect()
    }

    /// Steps of which some are missing, where the residual shows them.
    pub(crate) fn gaps(&self) -> Option<Gaps> {
        let powers = self.standing_out();
        let found = CODES.iter().filter_map(|every| self.gaps_of(*every, &powers));
        let best = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 > SHOWN).then_some(best.1)
    }

    /// One code of `every` missing: the pattern repeats over `every` steps, so that the powers at that
    /// many multiples of its period stand out together. The share of the residual that the best one
    /// explains.
    fn gaps_of(&self, every: u32, powers: &[f64]) -> Option<(f64, Gaps)> {
        /// Parts of FINE between which the period is searched.
        const PARTS: usize = 4;
        let harmonics = every as usize;
        let last = (powers.len() - 1) * PARTS / harmonics;
        let sum = |place: usize| -> f64 {
            (1..=harmonics).map(|j| powers[(j * place + PARTS / 2) / PARTS]).sum()
        };
        let first = (8 * PARTS / harmonics).max(PARTS);
        // Of equal ones the longest period: rows at even distances show each line twice.
        let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1));
        let best = (first..=last).map(|k| (sum(k), k)).max_by(order)?.1;
        let steps = FINE * best as f64 / PARTS as f64 * f64::from(every);
        let fine = (-6..=6).map(|k| steps + 0.05 * f64::from(k) * f64::from(every) / 5.0);
        let mut all: Option<(f64, Gaps)> = None;
        for steps in fine {
            for part in 0..12 {
                let phase = f64::from(part) / 12.0;
                for missing in 0..every {
                    let gaps = Gaps { every, missing, steps, phase };
                    let share = self.share(&gaps);
                    if all.as_ref().is_none_or(|(best, _)| share > *best) {
                        all = Some((share, gaps));
                    }
                }
            }
        }
        all
    }

    /// Part of the residual's power that goes with what these steps do wrong.
    fn share(&self, gaps: &Gaps) -> f64 {
        let (mut n, mut e1, mut e2, mut r1, mut r2, mut er) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (x, r) in self.places.iter().step_by(2) {
            let x = x * gaps.steps - gaps.phase;
            let e = code(x, gaps.every, gaps.missing) + 0.5 - x;
            n += 1.0;
            e1 += e;
            e2 += e * e;
            r1 += r;
            r2 += r * r;
            er += e * r;
        }
        let (ee, rr, er) = (e2 - e1 * e1 / n, r2 - r1 * r1 / n, er - e1 * r1 / n);
        if er > 0.0 && ee > 0.0 && rr > 0.0 { er * er / (ee * rr) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of a converter over places that fill the range, with noise of a tenth of a step. Rows at
    /// even distances would show each line twice.
    fn residuals(error: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let signal: Vec<f64> =
            (0..4000).map(|k| 100.0 * (f64::from(k) * 0.618_033_988_749_895).fract()).collect();
        let mut state = 5u64;
        let mut noise = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let residual = signal.iter().map(|u| error(*u) + 0.3 * noise()).collect();
        (signal, residual)
    }

    #[test]
    fn the_steps_of_a_converter_are_seen() {
        let q = 1.7;
        for p in [0.0, 0.2, 0.6] {
            let (signal, residual) = residuals(|u| q * ((u / q - p).round() + p) - u);
            let span = Span::of(signal.iter().copied());
            let seen = Converted::new(&signal, span, &residual, 0..signal.len());
            let (steps, phase) = seen.steps()[0];
            assert!((steps - 100.0 / q).abs() < 0.1, "{steps}");
            let apart = (phase - p).rem_euclid(1.0);
            assert!(apart.min(1.0 - apart) < 0.05, "{p}: {phase}");
        }
    }

    #[test]
    fn missing_codes_are_seen_and_plain_steps_explain_less() {
        for (every, missing, q) in [(5, 3, 1.3), (8, 0, 0.9), (3, 2, 2.1)] {
            let (signal, residual) =
                residuals(|u| q * (code(u / q - 0.2, every, missing) + 0.7) - u);
            let span = Span::of(signal.iter().copied());
            let seen = Converted::new(&signal, span, &residual, 0..signal.len());
            let gaps = seen.gaps().unwrap();
            assert!((gaps.steps * q / 100.0 - 1.0).abs() < 0.01, "{every}: {gaps:?}");
            assert_eq!(gaps.every, every, "{gaps:?}");
            assert!(seen.share(&gaps) > 0.6, "{}", seen.share(&gaps));
        }
    }
}
