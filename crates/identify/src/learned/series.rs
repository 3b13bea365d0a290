//! A learned hysteresis and the linear part behind it, each made for the other.
//!
//! ```text
//! h = H(u),   y = D·h
//! ```
//!
//! H is trained on y − (D − 1)·h, which is h where y = D·h, then D is fitted to what H simulates; so
//! in turn. A hysteresis that is trained on positions alone takes lag and creep for its own, and is
//! wrong wherever the rate is another.

use learned::lssvm::Settings;

use super::{Arx, Frame, Machine, rms_difference};

/// Least part of the error that a round takes off, or training in turn has ended.
const ROUND: f64 = 1e-4;

/// A record: commands, the position at the end of each, and the position before the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run<'a> {
    /// Held over a sample each.
    pub command: &'a [f64],
    /// At the end of each sample.
    pub position: &'a [f64],
    /// At rest, before the first.
    pub start: f64,
    /// The first sample that is fitted; those before are only simulated.
    pub first: usize,
    /// What is fitted to it.
    pub teaches: Teaches,
}

/// What is fitted to a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Teaches {
    /// Hysteresis and linear part.
    #[default]
    Both,
    /// The hysteresis only.
    Hysteresis,
    /// The linear part only.
    Linear,
}

/// How long hysteresis and linear part are trained in turn, and on how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    /// Most rounds.
    pub rounds: usize,
    /// Most samples that the hysteresis is trained on; of more, every few.
    pub most: usize,
}

impl Turns {
    /// At most so many rounds, on all samples.
    #[must_use]
    pub fn of(rounds: usize) -> Self {
        Self { rounds, most: usize::MAX }
    }
}

/// A hysteresis and its linear part.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// H.
    pub machine: Machine,
    /// D.
    pub linear: Arx,
}

impl Series {
    /// Trains H and D in turn from `first`, a linear part that is known or `b = [1]`, until a round takes
    /// less than 10⁻⁴ of the error over the records off, or over this many rounds; the round of
    /// least error stays. Of the `orders` of
    /// zeros and poles, those that err least are taken.
    ///
    /// # Errors
    /// [`learned::Error`] where samples are too few or not finite, or the training has no exact solution.
    pub fn train(
        frame: &Frame,
        settings: Settings,
        runs: &[Run<'_>],
        (first, orders): (&Arx, &[(usize, usize)]),
        turns: Turns,
    ) -> Result<Self, learned::Error> {
        let rows = rows(runs, turns.most);
        let mut linear = first.clone();
        let mut h: Vec<Vec<f64>> = runs.iter().map(|run| run.position.to_vec()).collect();
        let mut best: Option<(f64, Self)> = None;
        for _ in 0..turns.rounds.max(1) {
            let targets: Vec<Vec<f64>> =
                runs.iter().zip(&h).map(|(run, h)| before(&linear, run, h)).collect();
            let pairs: Vec<(&[f64], &[f64])> =
                runs.iter().zip(&targets).map(|(run, target)| (run.command, &target[..])).collect();
            let samples = frame.samples(&pairs)?.subset(&rows);
            let (machine, _) = Machine::train_on(frame.clone(), &samples, settings)?;
            h = runs.iter().map(|run| machine.simulate(run.command, run.start)).collect();
            let of_linear =
                runs.iter().zip(&h).filter(|(run, _)| run.teaches != Teaches::Hysteresis);
            let records: Vec<(&[f64], &[f64], f64)> =
                of_linear.map(|(run, h)| run.fitted(h)).collect();
            let fits = orders.iter().filter_map(|(zeros, poles)| {
                let fit = Arx::fit_all(&records, *zeros, *poles).ok().filter(Arx::is_stable)?;
                Some((mean_square(&fit, &records), fit))
            });
            if let Some((_, fit)) = fits.min_by(|a, b| a.0.total_cmp(&b.0)) {
                linear = fit;
            }
            let tried = Self { machine, linear: linear.clone() };
            let error = tried.error(runs);
            let least = best.as_ref().map_or(f64::INFINITY, |(least, _)| *least);
            if error < least {
                best = Some((error, tried));
            }
            if error < least && error > (1.0 - ROUND) * least {
                break;
            }
        }
        best.map(|(_, series)| series).ok_or(learned::Error::TooFew { found: 0, needed: 1 })
    }

    /// What the hysteresis would have to give for these records: their positions without what the linear part
    /// adds.
    #[must_use]
    pub fn targets(&self, runs: &[Run<'_>]) -> Vec<Vec<f64>> {
        let of = |run: &Run<'_>| {
            let h = self.machine.simulate(run.command, run.start);
            before(&self.linear, run, &h)
        };
        runs.iter().map(of).collect()
    }

    /// The response from rest with position `start`.
    #[must_use]
    pub fn simulate(&self, command: &[f64], start: f64) -> Vec<f64> {
        self.linear.simulate(&self.machine.simulate(command, start), start)
    }

    /// Root mean square error over records.
    #[must_use]
    pub fn error(&self, runs: &[Run<'_>]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for run in runs {
            let simulated = self.simulate(run.command, run.start);
            let (simulated, position, _) = run.fitted(&simulated);
            sum += rms_difference(simulated, position).powi(2) * position.len() as f64;
            count += position.len();
        }
        let error = (sum / count.max(1) as f64).sqrt();
        if error.is_nan() { f64::INFINITY } else { error }
    }
}

impl<'a> Run<'a> {
    /// A signal of this record and its position, where they are fitted, and the position before.
    fn fitted<'s>(&self, signal: &'s [f64]) -> (&'s [f64], &'a [f64], f64) {
        let before = self.first.checked_sub(1).and_then(|row| self.position.get(row));
        let part = |x: &'s [f64]| x.get(self.first..).unwrap_or(&[]);
        (
            part(signal),
            self.position.get(self.first..).unwrap_or(&[]),
            *before.unwrap_or(&self.start),
        )
    }
}

/// The rows of all records together that the hysteresis is fitted to, or every few of them.
pub(crate) fn rows(runs: &[Run<'_>], most: usize) -> Vec<usize> {
    let mut begin = 0;
    let mut all = Vec::new();
    for run in runs {
        let count = run.command.len().min(run.position.len());
        if run.teaches != Teaches::Linear {
            all.extend((run.first..count).map(|row| begin + row));
        }
        begin += count;
    }
    let every = all.len().div_ceil(most.max(1)).max(1);
    all.into_iter().step_by(every).collect()
}

fn mean_square(linear: &Arx, records: &[(&[f64], &[f64], f64)]) -> f64 {
    let error = |(h, y, y0): &(&[f64], &[f64], f64)| {
        rms_difference(&linear.simulate(h, *y0), y).powi(2) * y.len() as f64
    };
    records.iter().map(error).sum()
}

/// y − (D − 1)·h.
pub(super) fn before(linear: &Arx, run: &Run<'_>, h: &[f64]) -> Vec<f64> {
    let behind = linear.simulate(h, run.start);
    let with = run.position.iter().zip(h).zip(behind);
    with.map(|((y, h), behind)| y + h - behind).collect()
}

#[cfg(test)]
mod tests {
    use components::hysteresis::play::Plays;
    use learned::features::{Features, StopOperators};

    use super::super::{Recipe, Span};
    use super::*;

    #[test]
    fn a_play_behind_a_lag_is_separated_from_it() {
        let play = |u: &[f64]| -> Vec<f64> {
            let (play, mut state) = (Plays { r: &[1.0], w: &[0.5] }, [0.0]);
            u.iter().map(|u| u + play.step(*u, &mut state)).collect()
        };
        let lag = Arx { b: vec![0.3], a: vec![-0.7] };
        let wave = |top: f64, step: f64| -> Vec<f64> {
            (0..300).map(|k| 0.5 * top * (1.0 - (step * f64::from(k)).cos())).collect()
        };
        let (slow, fast, test) = (wave(6.0, 0.05), wave(6.0, 0.15), wave(6.0, 0.4));
        let truth = |u: &[f64]| lag.simulate(&play(u), 0.0);
        let (y_slow, y_fast) = (truth(&slow), truth(&fast));
        let runs = [
            Run { command: &slow, position: &y_slow, start: 0.0, first: 0, teaches: Teaches::Both },
            Run { command: &fast, position: &y_fast, start: 0.0, first: 0, teaches: Teaches::Both },
        ];
        let stops = StopOperators::new(8, 6.0, 1e-2);
        let pairs = runs.map(|run| (run.command, run.position));
        let mut frame = Frame::new(
            Features::StopOperators(stops),
            Span::UNIT,
            Span::UNIT,
            Recipe::Plain,
            &pairs,
        );
        frame.widths[..8].fill(20.0);
        let settings = Settings { gamma: 1e6, sigma2: 1.0 };
        let first = Arx { b: vec![1.0], a: vec![] };
        let found =
            Series::train(&frame, settings, &runs, (&first, &[(0, 1)]), Turns::of(12)).unwrap();
        assert!((found.linear.a[0] + 0.7).abs() < 0.03, "{:?}", found.linear);
        // Three times as fast as any record: without the linear part it cannot be followed.
        let error = rms_difference(&found.simulate(&test, 0.0), &truth(&test));
        let (alone, _) = Machine::train(frame, &pairs, settings).unwrap();
        let without = rms_difference(&alone.simulate(&test, 0.0), &truth(&test));
        assert!(error < 0.1 && error < 0.1 * without, "{error} {without}");
    }
}
