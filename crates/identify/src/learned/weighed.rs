//! Widths, hysteresis and linear part, each made for the others.
//!
//! A flexible machine takes a mode or a lag for a shape of its own, and no turn takes it away again. So it begins
//! stiff, with widths at which it is nearly a sum of its operators and of the command: what is dynamic has nowhere to
//! go but into the linear part. Then, in turn, stops are projected on the command where that makes what is curved a curve
//! of one input, and the widths are chosen by the evidence of what the linear part leaves.

use super::series::rows;
use super::{EvidenceWeighted, Frame, Run, Series, Turns, weigh_samples};
use learned::lssvm::Settings;

/// Turns with the stiff machine, and with each choice of widths.
const STIFF: usize = 20;
const LOOSE: [usize; 3] = [20, 20, 20];

/// How widths are sought.
#[derive(Clone, Copy)]
pub struct Widths<'a> {
    /// Group of an input; one factor each.
    pub group: &'a dyn Fn(usize) -> usize,
    /// Factors of a stiff machine, and its γ.
    pub stiff: (&'a [f64], f64),
    /// Evaluations of the evidence behind its grid, and most samples it looks at.
    pub search: (usize, usize),
    /// Greatest γ.
    pub greatest: f64,
}

impl Series {
    /// Trains hysteresis and linear part in turn, first stiff, then with widths by the evidence; that of least
    /// error over the records, and what the evidence chose for it. Without `orders` there is no linear
    /// part to find, and one choice is enough. `first` as in [`train`](Self::train).
    ///
    /// # Errors
    /// [`learned::Error`] where samples are too few or not finite, or the training has no exact solution.
    pub fn train_weighed(
        frame: &Frame,
        widths: Widths<'_>,
        runs: &[Run<'_>],
        (first, orders): (&super::Arx, &[(usize, usize)]),
        most: usize,
    ) -> Result<(Self, EvidenceWeighted), learned::Error> {
        let fitted = rows(runs, usize::MAX);
        let weigh = |targets: &[Vec<f64>], start: (&[f64], f64)| {
            let pairs: Vec<(&[f64], &[f64])> =
                runs.iter().zip(targets).map(|(run, target)| (run.command, &target[..])).collect();
            let frame = frame.projected(&pairs, &fitted);
            let samples = frame.samples(&pairs)?.subset(&fitted);
            Ok(weigh_samples(&frame, &samples, widths.group, start, widths.search, widths.greatest))
        };
        if orders.is_empty() {
            let targets: Vec<Vec<f64>> = runs.iter().map(|run| run.position.to_vec()).collect();
            let found = weigh(&targets, widths.stiff)?;
            let turns = Turns { rounds: 1, most };
            let series = Self::train(&found.frame, found.settings, runs, (first, orders), turns)?;
            return Ok((series, found));
        }
        let (factors, gamma) = widths.stiff;
        let settings = Settings { gamma, sigma2: 1.0 };
        let stiff = frame.stretched(widths.group, factors);
        let turns = |rounds| Turns { rounds, most };
        let mut series = Self::train(&stiff, settings, runs, (first, orders), turns(STIFF))?;
        let mut at =
            EvidenceWeighted { frame: stiff, settings, factors: factors.to_vec(), evaluations: 0 };
        let mut best = (series.error(runs), series.clone(), at.clone());
        for rounds in LOOSE {
            at = weigh(&series.targets(runs), (&at.factors, at.settings.gamma))?;
            let start = (&series.linear, orders);
            series = Self::train(&at.frame, at.settings, runs, start, turns(rounds))?;
            let error = series.error(runs);
            if error < best.0 {
                best = (error, series.clone(), at.clone());
            }
        }
        Ok((best.1, best.2))
    }
}

#[cfg(test)]
mod tests {
    use components::hysteresis::play::Plays;
    use learned::features::{Features, StopOperators};

    use super::super::{Arx, Recipe, Span, Teaches, rms_difference, weigh};
    use super::*;

    #[test]
    fn a_stiff_start_leaves_the_mode_to_the_linear_part() {
        // Plays behind a resonance; one chirp teaches, with the rate as an input that could take the mode's place.
        let mode = Arx { b: vec![0.04, 0.04], a: vec![-1.82, 0.90] };
        let plays = |u: &[f64]| -> Vec<f64> {
            let (plays, mut state) = (Plays { r: &[0.2, 0.5, 1.0, 2.0], w: &[0.1; 4] }, [0.0; 4]);
            u.iter().map(|u| u + plays.step(*u, &mut state)).collect()
        };
        let truth = |u: &[f64]| mode.simulate(&plays(u), 0.0);
        let chirp: Vec<f64> = (0..900)
            .map(|k| {
                let t = f64::from(k);
                2.5 * (1.0 - ((0.02 + 0.0001 * t) * t).cos())
            })
            .collect();
        let y = truth(&chirp);
        // Smaller loops than any of the chirp's.
        let test: Vec<f64> = (0..400)
            .map(|k| {
                let t = f64::from(k);
                1.5 * (1.0 - (0.05 * t).cos()) + 0.5 * (1.0 - (0.17 * t).cos())
            })
            .collect();
        let run =
            Run { command: &chirp, position: &y, start: 0.0, first: 0, teaches: Teaches::Both };
        let stops = StopOperators::new(12, 5.0, 1e-3).rated(300.0);
        let pairs = [(&chirp[..], &y[..])];
        let frame = Frame::new(
            Features::StopOperators(stops),
            Span::UNIT,
            Span::UNIT,
            Recipe::Plain,
            &pairs,
        );
        let group = |input: usize| input.saturating_sub(11);
        let nothing = Arx { b: vec![1.0], a: vec![] };
        let start = (&nothing, &[(2, 2)][..]);
        let stiff: (&[f64], f64) = (&[100.0, 10.0, 20.0], 1e5);
        let widths = Widths { group: &group, stiff, search: (40, 300), greatest: f64::INFINITY };
        let (series, found) =
            Series::train_weighed(&frame, widths, &[run], start, usize::MAX).unwrap();
        let error = |series: &Series| rms_difference(&series.simulate(&test, 0.0), &truth(&test));
        let weighed = weigh(&frame, &pairs, &group, stiff, (40, 300), f64::INFINITY).unwrap();
        let loose =
            Series::train(&weighed.frame, weighed.settings, &[run], start, Turns::of(40)).unwrap();
        let (ours, theirs) = (error(&series), error(&loose));
        assert!(ours < 0.03 && ours < 0.1 * theirs, "{ours} {theirs} {:?}", found.factors);
        assert!((series.linear.a[0] + 1.82).abs() < 0.02, "{:?}", series.linear);
    }
}
