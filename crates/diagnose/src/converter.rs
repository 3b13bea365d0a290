//! Converters whose steps the residual shows: it is then a periodic function of what is converted.

use std::f64::consts::TAU;

use numerics::fft::Fft;
use numerics::{Complex, median};

use surround::{Span, code};

use crate::thresholds::search::Thresholds;

/// Places where the residual of a model is looked at.
pub(crate) struct Converted {
    /// Rows at each place of what is converted.
    places: Vec<Place>,
    rows: f64,
    /// Sum and sum of squares of the residual.
    sums: (f64, f64),
    /// Periods over the range of the lines that stand out most, the strongest first.
    lines: Vec<f64>,
}

/// Rows whose signal is the same but for a small part of the range.
struct Place {
    /// The signal over the width of its range.
    at: f64,
    count: f64,
    /// Sum of the residual.
    sum: f64,
    /// Sum of its squares.
    squares: f64,
}

impl Place {
    /// Counts as at most so many rows. Rows of a plateau tell the same again and again: a few of them
    /// would stand as lines of all periods before what the moving rows show.
    fn limit(&mut self, most: f64) {
        if self.count > most {
            let part = most / self.count;
            self.count = most;
            self.sum *= part;
            self.squares *= part;
        }
    }
}

/// Steps of which some are missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gaps {
    /// Of so many codes one is missing.
    pub(crate) every: u32,
    /// Which of them is missing.
    pub(crate) missing: u32,
    /// Steps over the range.
    pub(crate) steps: f64,
    /// Phase of the steps.
    pub(crate) phase: f64,
}

impl Converted {
    /// Of these rows of a signal and a residual.
    pub(crate) fn new(
        signal: &[f64],
        span: Span,
        residual: &[f64],
        rows: impl Iterator<Item = usize>,
    ) -> Self {
        let first = (span.centre - span.half) / (2.0 * span.half);
        let width = 1.0 / Thresholds::CONVERTER_PLACES as f64;
        let at = |k: usize| first + (k as f64 + 0.5) * width;
        let mut places: Vec<Place> = (0..Thresholds::CONVERTER_PLACES)
            .map(|k| Place { at: at(k), count: 0.0, sum: 0.0, squares: 0.0 })
            .collect();
        for row in rows {
            let (x, r) = (signal[row] / (2.0 * span.half) - first, residual[row]);
            let place = &mut places[((x / width) as usize).min(Thresholds::CONVERTER_PLACES - 1)];
            place.count += 1.0;
            place.sum += r;
            place.squares += r * r;
        }
        let mut counts: Vec<f64> =
            places.iter().map(|place| place.count).filter(|count| *count > 0.0).collect();
        counts.sort_unstable_by(f64::total_cmp);
        let most =
            Thresholds::CONVERTER_OFTEN * counts.get(counts.len() / 2).copied().unwrap_or_default();
        places.iter_mut().for_each(|place| place.limit(most));
        let sum = |of: fn(&Place) -> f64| places.iter().map(of).sum();
        let (rows, sums) = (sum(|p| p.count), (sum(|p| p.sum), sum(|p| p.squares)));
        let mut seen = Self { places, rows, sums, lines: Vec::new() };
        seen.lines = seen.strongest();
        seen
    }

    /// Power and angle of the residual's part with this many periods over the range.
    fn power(&self, periods: f64) -> (f64, f64) {
        let (mut s, mut c) = (0.0, 0.0);
        for place in self.places.iter().filter(|place| place.count > 0.0) {
            let (sin, cos) = (TAU * periods * place.at).sin_cos();
            s += place.sum * sin;
            c += place.sum * cos;
        }
        (s * s + c * c, s.atan2(c))
    }

    /// Powers at all multiples of [`Thresholds::CONVERTER_FINE`].
    fn powers(&self) -> Vec<f64> {
        let length = (Thresholds::CONVERTER_PLACES as f64 / Thresholds::CONVERTER_FINE) as usize;
        let mut sums: Vec<f64> = self.places.iter().map(|place| place.sum).collect();
        sums.resize(length, 0.0);
        let lines = Fft::forward(length).of_real(&sums);
        let count = (Thresholds::CONVERTER_STEPS as f64 / Thresholds::CONVERTER_FINE) as usize;
        lines.iter().take(count + 1).map(Complex::norm_sqr).collect()
    }

    /// The powers that stand out of those around them, and zero for the others: what is slow over the
    /// range is no converter's.
    fn standing_out(&self) -> Vec<f64> {
        let powers = self.powers();
        let over = |k: usize| {
            let end = (k + Thresholds::CONVERTER_BESIDE + 1).min(powers.len());
            let mut nearby = powers[k.saturating_sub(Thresholds::CONVERTER_BESIDE)..end].to_vec();
            let stands_out = median(&mut nearby)
                .is_some_and(|median| powers[k] > Thresholds::CONVERTER_OVER * median);
            if stands_out { powers[k] } else { 0.0 }
        };
        (0..powers.len()).map(over).collect()
    }

    fn strongest(&self) -> Vec<f64> {
        let over = self.standing_out();
        let is_peak = |k: &usize| {
            let beside = k - Thresholds::CONVERTER_WIDE
                ..(k + Thresholds::CONVERTER_WIDE + 1).min(over.len());
            over[*k] > 0.0 && over[beside].iter().all(|other| *other <= over[*k])
        };
        let mut all: Vec<usize> = (8..over.len()).filter(is_peak).collect();
        all.sort_by(|a, b| over[*b].total_cmp(&over[*a]).then(a.cmp(b)));
        all.truncate(Thresholds::CONVERTER_LINES);
        let fine = |k: &usize| {
            let near =
                (-8..=8).map(|i| Thresholds::CONVERTER_FINE * *k as f64 + 0.03 * f64::from(i));
            near.max_by(|a, b| self.power(*a).0.total_cmp(&self.power(*b).0))
        };
        all.iter().filter_map(fine).collect()
    }

    /// The periods that stand out most, as steps over the range and phase, to start from.
    pub(crate) fn steps(&self) -> Vec<(f64, f64)> {
        let start = |steps: f64| {
            // The rounding error −Σ sin(2πk(u/q − p))/(πk) has its first harmonic at this angle.
            let phase = 0.25 + self.power(steps).1 / TAU;
            [0.0, 0.25, -0.25].map(|shift| (steps, (phase + shift).rem_euclid(1.0)))
        };
        self.lines.iter().take(3).copied().flat_map(start).collect()
    }

    /// Steps of which some are missing, where the residual shows them: each line may be any harmonic of a
    /// pattern that repeats over every few steps.
    pub(crate) fn gaps(&self) -> Option<Gaps> {
        let mut best: Option<(f64, Gaps)> = None;
        for line in &self.lines {
            for (every, harmonic) in
                Thresholds::CONVERTER_CODES.iter().flat_map(|n| (1..=*n).map(move |j| (*n, j)))
            {
                let (codes, harmonic) = (f64::from(every), f64::from(harmonic));
                let patterns = line / harmonic;
                if !(1.0..=Thresholds::CONVERTER_STEPS as f64).contains(&(patterns * codes))
                    || patterns < 1.0
                {
                    continue;
                }
                let fine = Thresholds::CONVERTER_NEAR / codes;
                let nearby = (Thresholds::CONVERTER_KNOWN / harmonic / fine).ceil() as i32;
                for k in -nearby..=nearby {
                    let steps = (patterns + fine * f64::from(k)) * codes;
                    let found = self.pattern(every, steps);
                    if best.as_ref().is_none_or(|(share, _)| found.0 > *share) {
                        best = Some(found);
                    }
                }
            }
        }
        let (share, gaps) = best?;
        (share * self.rows > Thresholds::CONVERTER_SHOWN).then_some(gaps)
    }

    /// The phase and the missing code that explain most of the residual's power, and which part, with this
    /// many steps over the range: the residual folded over the pattern, against what the steps do wrong.
    fn pattern(&self, every: u32, steps: f64) -> (f64, Gaps) {
        let bins = Thresholds::CONVERTER_BINS * every as usize;
        let (mut count, mut sum) = (vec![0.0; bins], vec![0.0; bins]);
        for place in self.places.iter().filter(|place| place.count > 0.0) {
            let folded = (place.at * steps / f64::from(every)).rem_euclid(1.0) * bins as f64;
            let bin = (folded as usize).min(bins - 1);
            count[bin] += place.count;
            sum[bin] += place.sum;
        }
        let (n, (r1, r2)) = (self.rows, self.sums);
        let error: Vec<f64> = (0..bins)
            .map(|bin| (bin as f64 + 0.5) / Thresholds::CONVERTER_BINS as f64)
            .map(|x| code(x, every, 0) + 0.5 - x)
            .collect();
        let share = |turn: usize| {
            let (mut e1, mut e2, mut er) = (0.0, 0.0, 0.0);
            for (bin, (count, sum)) in count.iter().zip(&sum).enumerate() {
                let e = error[(bin + bins - turn) % bins];
                e1 += count * e;
                e2 += count * e * e;
                er += e * sum;
            }
            let (ee, rr, er) = (e2 - e1 * e1 / n, r2 - r1 * r1 / n, er - e1 * r1 / n);
            if er > 0.0 && ee > 0.0 && rr > 0.0 { er * er / (ee * rr) } else { 0.0 }
        };
        let shares = (0..bins).map(|turn| (share(turn), turn));
        let (share, turn) = shares.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        let phase = (turn % Thresholds::CONVERTER_BINS) as f64 / Thresholds::CONVERTER_BINS as f64;
        (share, Gaps { every, missing: (turn / Thresholds::CONVERTER_BINS) as u32, steps, phase })
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
        let mut random = numerics::random::SplitMix64::new(5);
        let mut noise = || random.uniform() - 0.5;
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
    fn plateaus_do_not_hide_the_steps() {
        let q = 1.7;
        // Half of the rows stand at a few places, where the model is off by something else.
        let (mut signal, mut residual) = residuals(|u| q * (u / q).round() - u);
        for level in 0..8 {
            signal.extend([6.0 + 12.0 * f64::from(level); 500]);
            residual.extend([if level % 3 == 0 { 4.0 } else { -3.0 }; 500]);
        }
        let span = Span::of(signal.iter().copied());
        let seen = Converted::new(&signal, span, &residual, 0..signal.len());
        let (steps, _) = seen.steps()[0];
        assert!((steps * q / (2.0 * span.half) - 1.0).abs() < 0.01, "{steps}");
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
            let (share, _) = seen.pattern(gaps.every, gaps.steps);
            assert!(share > 0.6, "{share}");
        }
    }
}
