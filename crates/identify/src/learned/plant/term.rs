//! An LS-SVM for the hysteresis term beside a straight line.
//!
//! ```text
//! y = offset + gain·(u + h),   h by model I (u, h), II (y, h) or III (u, y, h), two past values of each signal
//! ```
//!
//! The line is that of least squares. h follows from the measured positions, and σ² and γ are those of least error in
//! simulation, own terms and own positions fed back, on the last third of what is fitted, or by the selection that was asked
//! for; the paper leaves one out.
//!
//! Source: Q. Xu, Identification and Compensation of Piezoelectric Hysteresis Without Modeling Hysteresis Inverse, IEEE Trans.
//! Ind. Electron. 60 (2013) 3927-3937, eqs. (5)-(9). Its mode is not here: at the paper's 20 ms it is 2·10⁻⁵ of the other terms.

use std::ops::Range as Rows;

use data::{ComponentBlueprint, Value};
use learned::features::term::{Range, Term, TermSignals as Signals};
use learned::lssvm::{LsSvm, Pruning, Samples, Settings, leave_one_out, prune};
use learned::{Compressor, KernelSum};
use model::Table;

use super::super::series::rows;
use super::super::{BOUNDS, Run, Seek, Selection, Span, rms_difference, sought};
use super::{CENTRES, FitContext, Learned, SAMPLES, Stage, failed};
use crate::error::Error;
use crate::settings::FeatureChoice;

/// Past values of each signal: m = n = l.
const PAST: usize = 2;
/// Most samples of a machine that is tried.
const TRIED: usize = 600;

/// Its plant; the table is that of the file `name`.
pub(super) fn learn(
    scene: &FitContext<'_>,
    name: &str,
    stage: &mut Stage<'_>,
) -> Result<Learned, Error> {
    let signals = match scene.learning.features {
        FeatureChoice::Command => Signals::Command,
        FeatureChoice::Position => Signals::Position,
        _ => Signals::Both,
    };
    let lesson = TrainingSet::of(scene, signals)?;
    stage(0, 2)?;
    let (selection, seek) = scene.learning.selection.unwrap_or((Selection::HeldOut, Seek::Grid));
    let settings = lesson.settings(selection, seek)?;
    stage(1, 2)?;
    let machine = lesson.machine(settings, scene.learning.prune)?;
    let table = table(&machine)?;
    let numbers = table.values().len() + 2;
    let chain = vec![lesson.component(name, scene.period)];
    Ok(Learned { chain, delay: 0, numbers, table, predicted: None })
}

/// The line, the inputs, and the samples of the records.
struct TrainingSet<'a> {
    runs: &'a [Run<'a>],
    term: Term,
    samples: Samples,
}

impl<'a> TrainingSet<'a> {
    fn of(scene: &FitContext<'a>, signals: Signals) -> Result<Self, Error> {
        let runs = scene.runs;
        let (gain, offset) = line(runs).ok_or_else(|| {
            let message = "the command moves the position by nothing on a straight line, beside which the term stands; \
                           take --model lssvm-stops or gp";
            Error::Learned { message: message.to_owned() }
        })?;
        let range = |span: Span| Range { low: span.low, span: span.high - span.low };
        let blank = Range { low: 0.0, span: 1.0 };
        let (command, position) = (range(scene.command), range(scene.position));
        let mut term =
            Term { signals, past: PAST, terms: PAST, gain, offset, command, position, term: blank };
        let of_run = |run: &Run<'_>| {
            let pairs = run.command.iter().zip(run.position);
            pairs.map(|(u, y)| term.term(*u, *y)).collect::<Vec<f64>>()
        };
        term.term = range(Span::of(&runs.iter().flat_map(of_run).collect::<Vec<f64>>()));
        let (mut inputs, mut terms) = (Vec::new(), Vec::new());
        for run in runs {
            let (x, h) = term.of_record(run.command, run.position);
            inputs.extend(x);
            terms.extend(h);
        }
        let samples = Samples::new(term.dimension(), inputs, terms).map_err(failed)?;
        Ok(Self { runs, term, samples })
    }

    /// Parts of each run that are held out together.
    fn parts(&self, selection: Selection) -> Vec<Vec<Rows<usize>>> {
        let (count, from) = match selection {
            Selection::CrossValidation(parts) => (parts, 0),
            _ => (3, 2),
        };
        let part = |k: usize| {
            let of = |run: &Run<'_>| {
                let rows = run.position.len() - run.first;
                run.first + k * rows / count..run.first + (k + 1) * rows / count
            };
            self.runs.iter().map(of).collect()
        };
        (from..count).map(part).collect()
    }

    /// Rows of the samples that teach, at most so many, without those of a part.
    fn taught(&self, most: usize, part: &[Rows<usize>]) -> Vec<usize> {
        let mut begin = 0;
        let gone: Vec<Rows<usize>> = self
            .runs
            .iter()
            .zip(part)
            .map(|(run, part)| {
                let gone = begin + part.start..begin + part.end;
                begin += run.position.len();
                gone
            })
            .collect();
        let known = |row: &usize| !gone.iter().any(|gone| gone.contains(row));
        rows(self.runs, most).into_iter().filter(known).collect()
    }

    /// Mean square error of the simulation of these parts, each from what was measured before it.
    fn error(&self, machine: &LsSvm, part: &[Rows<usize>]) -> f64 {
        let f = kernels(machine);
        let (mut sum, mut count) = (0.0, 0);
        for (run, part) in self.runs.iter().zip(part) {
            let command = &run.command[..part.end];
            let own = self.term.simulate(&f, command, run.position, part.start);
            sum += rms_difference(&own, &run.position[part.clone()]).powi(2) * own.len() as f64;
            count += own.len();
        }
        sum / count.max(1) as f64
    }

    fn settings(&self, selection: Selection, seek: Seek) -> Result<Settings, Error> {
        let all = self.samples.subset(&self.taught(TRIED, &[]));
        let parts: Vec<(Samples, Vec<Rows<usize>>)> = match selection {
            Selection::LeaveOneOut => Vec::new(),
            _ => (self.parts(selection).into_iter())
                .map(|part| (self.samples.subset(&self.taught(TRIED, &part)), part))
                .collect(),
        };
        let error = |settings: Settings| -> f64 {
            if selection == Selection::LeaveOneOut {
                let square = |e: Vec<f64>| e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64;
                return leave_one_out(&all, settings).map_or(f64::INFINITY, square);
            }
            let each = parts.iter().map(|(others, part)| {
                let machine = LsSvm::train(others, settings);
                machine.map_or(f64::INFINITY, |(machine, _)| self.error(&machine, part))
            });
            each.sum()
        };
        let mut row = |s: f64, gammas: &[f64]| -> Vec<f64> {
            gammas.iter().map(|g| error(Settings { sigma2: s.exp(), gamma: g.exp() })).collect()
        };
        let found = sought(seek, &BOUNDS, &mut row);
        if found.error.is_finite() {
            return Ok(found.settings);
        }
        let message =
            "no machine over these records can be solved; resample the log to fewer samples";
        Err(Error::Learned { message: message.to_owned() })
    }

    /// The machine of all samples, pruned where that is asked for, else on the fewest centres that err hardly more.
    fn machine(&self, settings: Settings, most: Option<usize>) -> Result<LsSvm, Error> {
        let all = self.samples.subset(&self.taught(SAMPLES, &[]));
        let rows: Vec<Rows<usize>> =
            self.runs.iter().map(|run| run.first..run.position.len()).collect();
        let judge = |machine: &LsSvm| self.error(machine, &rows).sqrt();
        if let Some(least_count) = most {
            let pruning = Pruning { least_count, ..Pruning::default() };
            return Ok(prune(&all, settings, pruning, judge).map_err(failed)?.model);
        }
        let (machine, _) = LsSvm::train(&all, settings).map_err(failed)?;
        let limit = (1.0 + CENTRES.1) * judge(&machine);
        let few = Compressor::new(&machine, CENTRES.0).smallest(limit, judge);
        Ok(few.unwrap_or(machine))
    }

    fn component(&self, table: &str, period: f64) -> ComponentBlueprint {
        let term = &self.term;
        let inputs = match term.signals {
            Signals::Command => 1.0,
            Signals::Position => 2.0,
            Signals::Both => 3.0,
        };
        let component = ComponentBlueprint::new("lssvm-term")
            .value("table", Value::Text(table.to_owned()))
            .value("sample_time", period)
            .value("past_inputs", term.past as f64)
            .value("past_outputs", term.terms as f64)
            .value("inputs", inputs)
            .value("gain", term.gain)
            .value("offset", term.offset);
        let ends = [("command", term.command), ("h", term.term), ("position", term.position)];
        ends.into_iter().fold(component, |component, (name, range)| {
            component
                .value(&format!("{name}_low"), range.low)
                .value(&format!("{name}_high"), range.low + range.span)
        })
    }
}

/// Slope and height at zero command of the line of least squares through all rows.
fn line(runs: &[Run<'_>]) -> Option<(f64, f64)> {
    let all = || runs.iter().flat_map(|run| run.command.iter().zip(run.position).skip(run.first));
    let count = all().count().max(1) as f64;
    let (u0, y0) = all().fold((0.0, 0.0), |(a, b), (u, y)| (a + u / count, b + y / count));
    let (uy, uu) = all()
        .fold((0.0, 0.0), |(uy, uu), (u, y)| (uy + (u - u0) * (y - y0), uu + (u - u0) * (u - u0)));
    let gain = uy / uu;
    (gain.is_finite() && gain != 0.0).then_some((gain, y0 - gain * u0))
}

fn kernels(machine: &LsSvm) -> KernelSum {
    let sigma = [machine.sigma2.sqrt()];
    KernelSum::new(machine.dimension, &machine.centres, &machine.weights, &sigma, machine.bias)
}

/// Bias and width of each input, then weight and centre of each support vector.
fn table(machine: &LsSvm) -> Result<Table, Error> {
    let d = machine.dimension;
    let mut rows = vec![machine.bias];
    rows.extend(vec![machine.sigma2.sqrt(); d]);
    for (weight, centre) in machine.weights.iter().zip(machine.centres.chunks(d)) {
        rows.push(*weight);
        rows.extend_from_slice(centre);
    }
    Table::new(d + 1, rows).map_err(|message| Error::Learned { message })
}
