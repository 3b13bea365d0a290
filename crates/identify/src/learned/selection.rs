//! σ² and γ of a machine, by what it does on rows that it was not trained on.
//!
//! A machine whose own outputs are fed back is judged in simulation mode: what it errs one step ahead does not say
//! whether it runs off. So each part that was held out is simulated from what was measured before it, with the
//! machine's own outputs from there on.

use learned::features::Features;
use learned::lssvm::{Folds, LsSvm, Samples, Settings, Validation, leave_one_out};
use learned::tune::{
    Annealing, Best, Simplex, Swarm, coupled_annealing, grid_then_simplex, nelder_mead,
    particle_swarm,
};

use super::{Frame, Machine, rms_difference};

/// What settings are judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// So many blocks of successive rows, each held out once and simulated.
    CrossValidation(usize),
    /// Each sample held out once, one step ahead.
    LeaveOneOut,
    /// The last third of each record, simulated by a machine of the rest.
    HeldOut,
}

/// How settings are sought within their bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seek {
    /// A grid and a simplex.
    Grid,
    /// A particle swarm: 30 particles over 100 iterations, inertia 0.9 to 0.4, c1 = c2 = 2.
    Swarm,
    /// Coupled simulated annealing, then a simplex.
    Annealing,
}

/// Settings that were found.
#[derive(Clone, Debug, PartialEq)]
pub struct Selected {
    /// σ² and γ.
    pub settings: Settings,
    /// Root mean square error on what was held out, in units of the output.
    pub error: f64,
    /// How many settings were tried.
    pub evaluations: usize,
    /// Whether a bound keeps them from going on.
    pub at_bound: bool,
}

/// Records of command and output.
pub type Records<'a> = [(&'a [f64], &'a [f64])];

/// ln σ² and ln γ within which they are sought where nothing else is known.
pub const BOUNDS: [(f64, f64); 2] = [(-2.0, 9.0), (-2.0, 18.0)];

/// Judges settings of machines in one frame; distances are computed once.
struct Judge<'a> {
    frame: &'a Frame,
    records: &'a Records<'a>,
    samples: Samples,
    /// Rows of the samples, counted through all records.
    rows: Vec<usize>,
    selection: Selection,
    validation: Option<Validation>,
}

impl<'a> Judge<'a> {
    fn new(
        frame: &'a Frame,
        records: &'a Records<'a>,
        selection: Selection,
        most: usize,
    ) -> Result<Self, learned::Error> {
        let all = frame.samples(records)?;
        let rows = all.rows_at_most(most);
        let samples = all.subset(&rows);
        let validation = match selection {
            Selection::CrossValidation(parts) => {
                Some(Validation::new(&samples, &Folds::blocks(samples.count(), parts))?)
            }
            Selection::LeaveOneOut | Selection::HeldOut => None,
        };
        Ok(Self { frame, records, samples, rows, selection, validation })
    }

    /// Mean square error for each γ at one σ²; what cannot be solved is infinitely bad.
    fn errors(&mut self, sigma2: f64, gammas: &[f64]) -> Vec<f64> {
        match self.selection {
            Selection::CrossValidation(_) => {
                let one = |judge: &mut Self, gamma: f64| judge.cross_validated(sigma2, gamma);
                gammas.iter().map(|gamma| one(self, *gamma).unwrap_or(f64::INFINITY)).collect()
            }
            Selection::LeaveOneOut => {
                let span = self.frame.output.high - self.frame.output.low;
                let of = |gamma: &f64| {
                    let errors = leave_one_out(&self.samples, Settings { gamma: *gamma, sigma2 });
                    let square =
                        |e: Vec<f64>| e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64;
                    errors.map_or(f64::INFINITY, |e| square(e) * span * span)
                };
                gammas.iter().map(of).collect()
            }
            Selection::HeldOut => {
                let of = |gamma: &f64| self.held_out(Settings { gamma: *gamma, sigma2 });
                gammas.iter().map(of).collect()
            }
        }
    }

    fn cross_validated(&mut self, sigma2: f64, gamma: f64) -> Option<f64> {
        let models = self.validation.as_mut()?.models(sigma2, &[gamma]).ok()?;
        let models = models.into_iter().next()?;
        let (mut sum, mut count) = (0.0, 0);
        for (model, held) in models {
            let first = *self.rows.get(*held.first()?)?;
            let last = *self.rows.get(*held.last()?)?;
            let mut begin = 0;
            for (command, output) in self.records {
                let (from, to) = (first.max(begin), (last + 1).min(begin + output.len()));
                if from < to {
                    let rows = from - begin..to - begin;
                    let own = self.frame.simulate_rows(&model, command, output, rows.clone());
                    sum += own.iter().zip(&output[rows]).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
                    count += own.len();
                }
                begin += output.len();
            }
        }
        (count > 0).then(|| sum / count as f64)
    }

    fn held_out(&self, settings: Settings) -> f64 {
        let cut = |n: usize| 2 * n / 3;
        let (mut begin, mut known) = (0, Vec::new());
        for (_, output) in self.records {
            known.push(begin..begin + cut(output.len()));
            begin += output.len();
        }
        let kept: Vec<usize> = (0..self.rows.len())
            .filter(|k| known.iter().any(|range| range.contains(&self.rows[*k])))
            .collect();
        let Ok((model, _)) = LsSvm::train(&self.samples.subset(&kept), settings) else {
            return f64::INFINITY;
        };
        let (mut sum, mut count) = (0.0, 0);
        for (command, output) in self.records {
            let rows = cut(output.len())..output.len();
            let own = self.frame.simulate_rows(&model, command, output, rows.clone());
            sum += rms_difference(&own, &output[rows]).powi(2) * own.len() as f64;
            count += own.len();
        }
        sum / count.max(1) as f64
    }
}

impl Frame {
    /// Some rows of a record in simulation mode, from what was measured before them.
    fn simulate_rows(
        &self,
        machine: &LsSvm,
        command: &[f64],
        output: &[f64],
        rows: std::ops::Range<usize>,
    ) -> Vec<f64> {
        if !matches!(self.features, Features::Narx(_)) {
            // Nothing is fed back: the memory is that of the commands alone.
            let first = output.first().copied().unwrap_or(0.0);
            let all = self.simulate(machine, &command[..rows.end], first);
            return all.get(rows).unwrap_or(&[]).to_vec();
        }
        let u: Vec<f64> = command[..rows.end].iter().map(|u| self.command.inward(*u)).collect();
        let y: Vec<f64> = output[..rows.start].iter().map(|y| self.output.inward(*y)).collect();
        let mut memory = vec![0.0; self.features.memory()];
        let mut z = vec![0.0; self.features.dimension()];
        let start = output.first().map_or(0.0, |y| self.output.inward(*y));
        self.features.rest(u.first().copied().unwrap_or(0.0), start, &mut memory);
        for (u, y) in u.iter().zip(&y) {
            self.features.step(*u, &mut memory, &mut z);
            self.features.output(*y, &mut memory);
        }
        let f = self.kernel_sum(machine);
        let own = self.features.continue_from(&f, &u[rows.start..], &mut memory, 1e3);
        own.iter()
            .zip(&u[rows.start..])
            .map(|(y, u)| self.output.outward(y + self.slope * u))
            .collect()
    }
}

/// The settings of least error within these bounds of ln σ² and ln γ, on at most so many samples.
///
/// # Errors
/// [`learned::Error`] where samples are too few or not finite.
pub fn select(
    frame: &Frame,
    records: &Records<'_>,
    selection: Selection,
    (seek, bounds): (Seek, &[(f64, f64); 2]),
    most: usize,
) -> Result<Selected, learned::Error> {
    let mut judge = Judge::new(frame, records, selection, most)?;
    let mut row = |s: f64, gammas: &[f64]| -> Vec<f64> {
        let gammas: Vec<f64> = gammas.iter().map(|g| g.exp()).collect();
        judge.errors(s.exp(), &gammas)
    };
    Ok(sought(seek, bounds, &mut row))
}

/// Root mean square errors of these settings on what is held out, in units of the output; infinite where they cannot be
/// solved or run off.
///
/// # Errors
/// [`learned::Error`] where samples are too few or not finite.
pub fn held_out(
    frame: &Frame,
    records: &Records<'_>,
    selection: Selection,
    settings: &[Settings],
    most: usize,
) -> Result<Vec<f64>, learned::Error> {
    let mut judge = Judge::new(frame, records, selection, most)?;
    let errors = settings.iter().map(|s| judge.errors(s.sigma2, &[s.gamma])[0].sqrt());
    Ok(errors.collect())
}

/// The least of a function of ln σ² and some ln γ.
pub fn sought(
    seek: Seek,
    bounds: &[(f64, f64); 2],
    row: &mut dyn FnMut(f64, &[f64]) -> Vec<f64>,
) -> Selected {
    let watch: &mut dyn FnMut(usize, f64) -> bool = &mut |_, _| true;
    let best: Best = match seek {
        Seek::Grid => grid_then_simplex(bounds, row, watch),
        Seek::Swarm => {
            let mut one = |p: &[f64]| row(p[0], &p[1..])[0];
            particle_swarm(bounds, Swarm::default(), &mut one, watch)
        }
        Seek::Annealing => {
            let mut one = |p: &[f64]| row(p[0], &p[1..])[0];
            let coarse = coupled_annealing(bounds, Annealing::default(), &mut one, watch);
            let simplex = Simplex { evaluations: 100, ..Simplex::default() };
            nelder_mead(bounds, &coarse.point, simplex, &mut one, watch)
        }
    };
    let near = |(x, (low, high)): (&f64, &(f64, f64))| {
        let edge = 0.01 * (high - low);
        *x < low + edge || *x > high - edge
    };
    Selected {
        settings: Settings { sigma2: best.point[0].exp(), gamma: best.point[1].exp() },
        error: best.value.sqrt(),
        evaluations: best.evaluations,
        at_bound: best.point.iter().zip(bounds).any(near),
    }
}

impl Machine {
    /// The machine of these settings on at most so many samples.
    ///
    /// # Errors
    /// [`learned::Error`] where samples are too few or not finite, or the training has no exact solution.
    pub fn of_selected(
        frame: Frame,
        records: &Records<'_>,
        settings: Settings,
        most: usize,
    ) -> Result<Self, learned::Error> {
        let all = frame.samples(records)?;
        Ok(Self::train_on(frame, &all.subset(&all.rows_at_most(most)), settings)?.0)
    }
}

#[cfg(test)]
mod tests {
    use learned::features::Narx;
    use numerics::random::SplitMix64;

    use super::super::{Recipe, Span};
    use super::*;

    /// A lag with noise in its reading: one step ahead, to copy the last reading is nearly the best.
    fn record(seed: u64) -> (Vec<f64>, Vec<f64>) {
        let (mut x, mut random) = (0.0_f64, SplitMix64::new(seed));
        let u: Vec<f64> = (0..400).map(|k| 0.5 - 0.5 * (0.09 * f64::from(k)).cos()).collect();
        let y = u.iter().map(|u| {
            x += 0.2 * (u - x);
            x + 0.01 * (random.uniform() - 0.5)
        });
        let y = y.collect();
        (u, y)
    }

    #[test]
    fn settings_are_judged_with_their_own_outputs_fed_back() {
        let ((u, y), (v, z)) = (record(1), record(7));
        let records = [(&u[..], &y[..])];
        let narx = Features::Narx(Narx { commands: 2, outputs: 2 });
        let frame = Frame::new(narx, Span::UNIT, Span::UNIT, Recipe::Plain, &records);
        for selection in [Selection::CrossValidation(5), Selection::HeldOut] {
            let found =
                select(&frame, &records, selection, (Seek::Grid, &BOUNDS), 400).expect("settings");
            let machine = Machine::of_selected(frame.clone(), &records, found.settings, 400);
            let machine = machine.expect("a machine");
            let own = rms_difference(&machine.simulate(&v, z[0]), &z);
            assert!(own < 0.02, "{selection:?}: {own} {found:?}");
            // What the selection promises is what a record that it never saw shows.
            assert!(own < 2.0 * found.error && found.error < 2.0 * own, "{own} {found:?}");
        }
        let found = select(&frame, &records, Selection::LeaveOneOut, (Seek::Grid, &BOUNDS), 400);
        let error = found.expect("settings").error;
        assert!(error > 0.002 && error < 0.01, "{error}");
    }

    #[test]
    fn what_stands_at_a_bound_is_reported() {
        let mut row =
            |s: f64, gammas: &[f64]| gammas.iter().map(|g| (g - 3.0).powi(2) - s).collect();
        let found = sought(Seek::Grid, &[(0.0, 4.0), (0.0, 8.0)], &mut row);
        assert!(found.at_bound && (found.settings.sigma2.ln() - 4.0).abs() < 0.05, "{found:?}");
        let mut row = |s: f64, gammas: &[f64]| {
            gammas.iter().map(|g| (g - 3.0).powi(2) + (s - 2.0).powi(2)).collect()
        };
        assert!(!sought(Seek::Swarm, &[(0.0, 4.0), (0.0, 8.0)], &mut row).at_bound);
    }
}
