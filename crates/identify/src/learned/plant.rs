//! A plant that is learned from records: a machine, and the linear part behind it.
//!
//! What the [`Family`] of machines does not choose is the same for all: what a record shows of the hysteresis, the
//! linear part that is made for it in turn ([`Series`]), the projection on the fewest centres that err hardly
//! more, and the components. Offsets of records are those of the static model.

mod narx;
mod process;
mod stops;
mod term;

use data::ComponentBlueprint;
use model::Table;

use learned::Deviation;
use learned::lssvm::{Pruning, Settings, prune};

use super::family::Family;
use super::series::rows;
use super::{Arx, Frame, Machine, Run, Series, Span, Teaches, Turns};
use crate::error::Error;
use crate::fit::response::LinearPart;
use crate::identification::{DeviationOutput, Predicted};
use crate::observer::Observer;
use crate::record::{Record, Rows};
use crate::settings::{FeatureChoice, Learning};

/// Most samples that a machine is trained on.
const SAMPLES: usize = 1500;
/// Most centres that stay, and the part of the error that this may add.
const CENTRES: (usize, f64) = (1000, 0.02);
/// Most rows whose deviation a process predicts: each costs as many operations as it has samples, squared.
const PREDICTED: usize = 200;
/// Zeros and poles of D.
const ORDERS: [(usize, usize); 2] = [(2, 2), (3, 3)];

/// What is learned from.
pub(crate) struct TrainingSet<'a> {
    pub(crate) family: Family,
    pub(crate) records: &'a [Record],
    pub(crate) fitted: &'a [Rows],
    pub(crate) judged: &'a [Rows],
    /// Of each record, in position.
    pub(crate) offsets: &'a [f64],
    /// Of the records, in s.
    pub(crate) period: f64,
    /// What the other methods found; whole periods of its delay stay in front, its lag and mode are where D
    /// begins.
    pub(crate) known: LinearPart,
    pub(crate) stops: usize,
    pub(crate) learning: Learning,
    /// Whether there is a linear part behind.
    pub(crate) dynamic: bool,
}

/// The components of a learned plant, and the table of the first.
pub(crate) struct Learned {
    pub(crate) chain: Vec<ComponentBlueprint>,
    pub(crate) table: Table,
    /// Whole periods of delay in front of it.
    pub(crate) delay: usize,
    /// Numbers that were learned.
    pub(crate) numbers: usize,
    /// Of a process: what it says of its own errors.
    pub(crate) predicted: Option<Predicted>,
}

/// What a family sees of the records.
struct FitContext<'a> {
    runs: &'a [Run<'a>],
    /// Ranges of all of them.
    command: Span,
    position: Span,
    period: f64,
    stops: usize,
    learning: Learning,
    dynamic: bool,
    /// Where D begins.
    first: Arx,
    /// Of a lag in D, in Hz, where creep is fitted with it.
    bandwidth: f64,
}

/// Reports the progress: done and total. An error where the observer asks to stop.
type Stage<'a> = dyn FnMut(usize, usize) -> Result<(), Error> + 'a;

fn failed(error: learned::Error) -> Error {
    Error::Learned { message: error.to_string() }
}

impl<'a> FitContext<'a> {
    fn pairs(&self) -> Vec<(&'a [f64], &'a [f64])> {
        self.runs.iter().map(|run| (run.command, run.position)).collect()
    }

    /// The first two thirds of what is fitted, to try settings on, and the rest, to judge them.
    fn parts(&self) -> (Vec<Run<'a>>, Vec<Run<'a>>) {
        let part = |run: &Run<'a>| {
            let cut = run.first + 2 * (run.position.len() - run.first) / 3;
            let (command, position) = (&run.command[..cut], &run.position[..cut]);
            (Run { command, position, ..*run }, Run { first: cut, ..*run })
        };
        self.runs.iter().map(part).unzip()
    }

    fn orders(&self) -> &'static [(usize, usize)] {
        if self.dynamic { &ORDERS } else { &[] }
    }

    /// Hysteresis and linear part in turn.
    fn in_turn(
        &self,
        frame: &Frame,
        settings: learned::lssvm::Settings,
        rounds: usize,
    ) -> Result<Series, Error> {
        let orders = self.orders();
        let turns = Turns { rounds: if self.dynamic { rounds } else { 1 }, most: SAMPLES };
        Series::train(frame, settings, self.runs, (&self.first, orders), turns).map_err(failed)
    }
}

/// A Gaussian process from a position and its derivatives to the command that leads to it at the end of a period.
///
/// # Errors
/// [`Error::Learned`] where the training has no exact solution; [`Error::Stopped`].
pub fn learned_inverse(
    command: &[f64],
    position: &[f64],
    period: f64,
    observer: &mut dyn Observer,
) -> Result<Machine, Error> {
    let mut stage = |done: usize, total: usize| {
        observer.progress("inverse by a Gaussian process", done, total);
        if observer.stopped() { Err(Error::Stopped) } else { Ok(()) }
    };
    let start = command.first().copied().unwrap_or(0.0);
    // What is asked for is the position, what is answered the command.
    let run = Run { command: position, position: command, start, first: 0, teaches: Teaches::Both };
    let scene = FitContext {
        runs: &[run],
        command: Span::of(position),
        position: Span::of(command),
        period,
        stops: 0,
        learning: Learning::default(),
        dynamic: false,
        first: none(),
        bandwidth: 0.0,
    };
    Ok(process::learn(&scene, &mut stage)?.0.machine)
}

fn none() -> Arx {
    Arx { b: vec![1.0], a: Vec::new() }
}

impl TrainingSet<'_> {
    /// Learns the plant, whose table is that of the file `name`.
    ///
    /// # Errors
    /// [`Error::Learned`] where the training has no exact solution; [`Error::Stopped`].
    pub(crate) fn learn(&self, name: &str, observer: &mut dyn Observer) -> Result<Learned, Error> {
        let mut stage = |done: usize, total: usize| {
            observer.progress(self.family.stage(), done, total);
            if observer.stopped() { Err(Error::Stopped) } else { Ok(()) }
        };
        let middle = self.offsets.iter().sum::<f64>() / self.offsets.len().max(1) as f64;
        let positions: Vec<Vec<f64>> = (self.records.iter().zip(self.fitted))
            .zip(self.offsets)
            .map(|((record, rows), offset)| {
                record.output()[..rows.end].iter().map(|y| y - (offset - middle)).collect()
            })
            .collect();
        let delays: Vec<usize> = self.delays();
        let commands: Vec<Vec<Vec<f64>>> =
            delays.iter().map(|delay| self.commands(*delay)).collect();
        let all_runs: Vec<Vec<Run<'_>>> =
            commands.iter().map(|commands| self.runs(commands, &positions)).collect();
        let scenes: Vec<FitContext<'_>> = delays
            .iter()
            .zip(&all_runs)
            .zip(&commands)
            .map(|((delay, runs), commands)| FitContext {
                runs,
                command: Span::of(&commands.concat()),
                position: Span::of(&positions.concat()),
                period: self.period,
                stops: self.stops,
                learning: self.learning,
                dynamic: self.dynamic,
                first: if self.dynamic { sampled(&self.known, self.period) } else { none() },
                bandwidth: self.bandwidth(*delay),
            })
            .collect();
        let last = &scenes[scenes.len() - 1];
        self.check_learning()?;
        let at = scenes.len() - 1;
        if self.family == Family::Term {
            return Ok(Learned { delay: delays[at], ..term::learn(last, name, &mut stage)? });
        }
        let (mut predicted, mut process) = (None, None);
        let (number, series, settings) = match self.family {
            Family::StopOperators => {
                let (number, series, settings) = stops::learn(&scenes, &mut stage)?;
                (number, series, Some(settings))
            }
            Family::Narx => {
                let (series, settings) = narx::learn(last, &mut stage)?;
                (at, series, Some(settings))
            }
            Family::Term | Family::Process => {
                let (series, trained) = process::learn(last, &mut stage)?;
                let deviation = self.learning.deviation.then(|| trained.deviation()).transpose()?;
                predicted = self.predicted((&trained, deviation.as_ref()), delays[at], middle);
                process = deviation.map(|deviation| (trained, deviation));
                (at, series, None)
            }
        };
        let series = match (self.learning.prune, settings) {
            (Some(most), Some(settings)) => pruned(&series, settings, &all_runs[number], most)?,
            _ => series,
        };
        let (runs, commands) = (&all_runs[number], &commands[number]);
        let error = series.error(runs);
        let Series { machine, linear } = series;
        let simulated: Vec<Vec<f64>> =
            runs.iter().map(|run| machine.simulate(run.command, run.start)).collect();
        let own: Vec<(&[f64], &[f64])> =
            commands.iter().zip(&simulated).map(|(u, h)| (&u[..], &h[..])).collect();
        let machine = match self.learning.prune {
            Some(_) => machine,
            None => machine.compress(&own, CENTRES.0, CENTRES.1 * error).unwrap_or(machine),
        };
        let mut table = machine.table().map_err(|message| Error::Learned { message })?;
        let mut component = machine.component(false, name, self.period);
        if let Some((trained, deviation)) = &process {
            let widths = &table.values()[1..table.columns()];
            let rows = [table.values(), &deviation.table(widths)].concat();
            table =
                Table::new(table.columns(), rows).map_err(|message| Error::Learned { message })?;
            component = component
                .value("deviation_centres", deviation.count() as f64)
                .value("signal", trained.signal())
                .value("noise", trained.noise());
        }
        let mut chain = vec![component];
        if linear != none() {
            chain.push(
                ComponentBlueprint::new("arx")
                    .value("sample_time", self.period)
                    .value("b", &linear.b[..])
                    .value("a", &linear.a[..]),
            );
        }
        let of_d = if linear == none() { 0 } else { linear.b.len() + linear.a.len() };
        let numbers = table.values().len() + of_d;
        Ok(Learned { chain, delay: delays[number], numbers, table, predicted })
    }

    /// What a process says of its errors on the rows held out; `None` where there are none.
    fn predicted(
        &self,
        (trained, few): (&process::TrainedProcess, Option<&Deviation>),
        delay: usize,
        middle: f64,
    ) -> Option<Predicted> {
        let count: usize = self.judged.iter().map(Rows::len).sum();
        let every = count.div_ceil(PREDICTED).max(1);
        let mut deviations = Vec::new();
        let (mut within, mut apart) = (0, 0.0_f64);
        for ((record, rows), offset) in self.records.iter().zip(self.judged).zip(self.offsets) {
            let command: Vec<f64> = std::iter::repeat_n(record.rest(), 1 + delay)
                .chain(record.input().iter().copied())
                .take(rows.end)
                .collect();
            let position: Vec<f64> =
                record.output()[..rows.end].iter().map(|y| y - (offset - middle)).collect();
            let looked: Vec<usize> = (rows.first..rows.end).step_by(every).collect();
            let found = trained.judged(few, (&command, &position), &looked)?;
            let mean = found.iter().map(|row| row.error).sum::<f64>() / found.len().max(1) as f64;
            let is_within = |row: &&process::Row| (row.error - mean).abs() <= 1.96 * row.deviation;
            within += found.iter().filter(is_within).count();
            let each = found.iter().filter_map(|row| Some(row.few? / row.deviation - 1.0));
            apart = each.fold(apart, |m, x| m.max(x.abs()));
            deviations.extend(found.iter().map(|row| row.deviation));
        }
        deviations.sort_by(f64::total_cmp);
        let rows = deviations.len();
        let greatest = *deviations.last()?;
        let within = within as f64 / rows as f64;
        let (median, noise) = (deviations[rows / 2], trained.noise());
        let output = few.map(|few| DeviationOutput { centres: few.count(), apart });
        Some(Predicted { rows, median, greatest, noise, within, output })
    }

    /// Refuses choices that the family has not.
    fn check_learning(&self) -> Result<(), Error> {
        let name = self.family.name();
        let refused = |what: &str| Err(Error::Learned { message: format!("{name} {what}") });
        match (self.family, self.learning.features) {
            (Family::StopOperators | Family::Narx | Family::Term, FeatureChoice::Inputs(_)) => {
                refused("takes no number of inputs; 2, 6, 9 and 12 belong to gp")
            }
            (Family::Narx | Family::Process | Family::Term, FeatureChoice::Rate) => {
                refused("takes no rate beside its inputs; the rate belongs to lssvm-stops")
            }
            (
                Family::StopOperators | Family::Narx | Family::Process,
                FeatureChoice::Command | FeatureChoice::Position | FeatureChoice::Both,
            ) => refused("has its own inputs; command, position and both belong to lssvm-term"),
            (Family::StopOperators | Family::Narx | Family::Term, _) if self.learning.deviation => {
                refused("predicts no standard deviation; --deviation belongs to gp")
            }
            (Family::Process, _) if self.learning.prune.is_some() => {
                refused("is not pruned: each of its samples has its own weight; leave --prune out")
            }
            (Family::Process, _) if self.learning.selection.is_some() => {
                refused("finds its hyperparameters by the marginal likelihood; leave --select out")
            }
            _ => Ok(()),
        }
    }

    /// Whole periods of delay that may stand in front of the hysteresis. What is none or little is rather a lag.
    fn delays(&self) -> Vec<usize> {
        let found = (self.known.delay / self.period + 1e-6) as usize;
        let is_open = self.family == Family::StopOperators && self.dynamic && found > 0;
        is_open.then_some(0).into_iter().chain([found]).collect()
    }

    /// Bandwidth in Hz at which the linear part begins behind so many periods of delay: slow signals are as late behind a lag of τ as
    /// after a delay of τ.
    fn bandwidth(&self, delay: usize) -> f64 {
        let open = self.known.delay - delay as f64 * self.period;
        let lag = 1.0 / (core::f64::consts::TAU * open.max(self.period));
        self.known.bandwidth.unwrap_or(lag)
    }

    /// What the hysteresis of each record is under at each row: at rest, then the command of the row before, late.
    fn commands(&self, delay: usize) -> Vec<Vec<f64>> {
        let of = |(record, rows): (&Record, &Rows)| {
            let rest = std::iter::repeat_n(record.rest(), 1 + delay);
            rest.chain(record.input().iter().copied()).take(rows.end).collect()
        };
        self.records.iter().zip(self.fitted).map(of).collect()
    }

    fn runs<'s>(&self, commands: &'s [Vec<f64>], positions: &'s [Vec<f64>]) -> Vec<Run<'s>> {
        let of = |((command, position), rows): ((&'s Vec<f64>, &'s Vec<f64>), &Rows)| Run {
            command,
            position,
            start: position.first().copied().unwrap_or(0.0),
            first: rows.first,
            teaches: Teaches::Both,
        };
        commands.iter().zip(positions).zip(self.fitted).map(of).collect()
    }
}

/// The series with so many support vectors, by Algorithm 1 of the laser beam paper: judged by what the machine simulates of
/// the hysteresis' share of the records.
fn pruned(
    series: &Series,
    settings: Settings,
    runs: &[Run<'_>],
    most: usize,
) -> Result<Series, Error> {
    let targets = series.targets(runs);
    let records: Vec<(&[f64], &[f64])> =
        runs.iter().zip(&targets).map(|(run, target)| (run.command, &target[..])).collect();
    let frame = &series.machine.frame;
    let samples = frame.samples(&records).map_err(failed)?.subset(&rows(runs, SAMPLES));
    let pruning = Pruning { least_count: most, ..Pruning::default() };
    let judge = |machine: &learned::lssvm::LsSvm| frame.error(machine, &records);
    let found = prune(&samples, settings, pruning, judge).map_err(failed)?;
    let machine = Machine { frame: frame.clone(), machine: found.model };
    Ok(Series { machine, linear: series.linear.clone() })
}

/// Lag and mode under commands that are held over a sample, each sampled exactly by itself.
fn sampled(linear: &LinearPart, period: f64) -> Arx {
    let mut all = Arx { b: vec![1.0], a: Vec::new() };
    if let Some(bandwidth) = linear.bandwidth {
        all = all.then(&Arx::lag(bandwidth, period));
    }
    if let Some(mode) = linear.mode.filter(|mode| mode.damping < 1.0) {
        let omega = std::f64::consts::TAU * mode.frequency;
        let (decay, turn) = (mode.damping * omega, omega * (1.0 - mode.damping.powi(2)).sqrt());
        let e = (-decay * period).exp();
        let (s, c) = (turn * period).sin_cos();
        let ring = decay / turn * s;
        let b = vec![1.0 - e * (c + ring), e * (e + ring - c)];
        all = all.then(&Arx { b, a: vec![-2.0 * e * c, e * e] });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::response::ModeShape;

    #[test]
    fn lag_and_mode_are_sampled_exactly_under_a_held_step() {
        let period = 1e-3;
        let mode = ModeShape { frequency: 60.0, damping: 0.1 };
        let step = vec![1.0; 40];
        let of = |bandwidth: Option<f64>, mode: Option<ModeShape>| {
            let input = [&[0.0][..], &step].concat();
            sampled(&LinearPart { delay: 0.0, bandwidth, mode }, period).simulate(&input, 0.0)
        };
        let (lag, ringing, both) =
            (of(Some(30.0), None), of(None, Some(mode)), of(Some(30.0), Some(mode)));
        let omega = std::f64::consts::TAU * 60.0;
        let (decay, turn) = (0.1 * omega, omega * 0.99_f64.sqrt());
        for k in 1..40 {
            let t = k as f64 * period;
            assert!((lag[k] - (1.0 - (-std::f64::consts::TAU * 30.0 * t).exp())).abs() < 1e-12);
            let truth =
                1.0 - (-decay * t).exp() * ((turn * t).cos() + decay / turn * (turn * t).sin());
            assert!((ringing[k] - truth).abs() < 1e-12, "{k}");
        }
        let last = Arx {
            b: vec![1.0 - (-std::f64::consts::TAU * 0.03).exp()],
            a: vec![-(-std::f64::consts::TAU * 0.03).exp()],
        };
        for (a, b) in last.simulate(&ringing, 0.0).iter().zip(&both) {
            assert!((a - b).abs() < 1e-12, "one behind the other");
        }
    }
}
