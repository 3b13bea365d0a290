//! Logs with the FMU that they drive, and how residuals count.

use std::ops::Range;
use std::path::PathBuf;

use anyhow::bail;
use cosim::{Driven, Memory, Value};
use data::Log;
use identify::calibration::Tunable;

use super::asked::Asked;
use crate::results::estimate::{Curves, LogFit};
use crate::results::simulate::OutputFit;
use crate::window::Window;

/// A log, the FMU that it drives, and what is compared.
pub(super) struct Series<'a> {
    pub(super) driven: Driven<'a>,
    held_out: bool,
    /// Of each row of the log, in s.
    time: Vec<f64>,
    compared: Vec<Compared>,
    records: Vec<Judged>,
}

/// A measured output.
struct Compared {
    output: String,
    column: String,
    unit: String,
    /// In the output's unit, over the whole log.
    values: Vec<f64>,
}

/// A record and the rows of it that count.
struct Judged {
    id: i64,
    /// All its rows in the log.
    rows: Range<usize>,
    /// Those that count, in the log; none where the window leaves none.
    window: Option<Range<usize>>,
}

impl<'a> Series<'a> {
    pub(super) fn new(
        driven: Driven<'a>,
        log: &Log,
        compared: Vec<(String, String, String)>,
        window: &Window,
        held_out: bool,
        notes: &mut Vec<String>,
    ) -> anyhow::Result<Self> {
        let mut all = Vec::new();
        for (output, column, unit) in compared {
            let values = match unit.as_str() {
                "" => log.require(&column)?.values.clone(),
                unit => log.convert(&column, unit)?,
            };
            all.push(Compared { output, column, unit, values });
        }
        let judged = |record: &data::Record| Judged {
            id: record.id,
            rows: record.rows.clone(),
            window: window.rows(log.time(), &record.rows),
        };
        let records: Vec<Judged> = log.records().iter().map(judged).collect();
        for record in records.iter().filter(|record| record.window.is_none()) {
            let (id, origin) = (record.id, log.origin());
            notes.push(format!("{origin}: record {id} has no row in the window that is judged"));
        }
        if records.iter().all(|record| record.window.is_none()) {
            bail!("{}: no row is in the window that is judged", log.origin());
        }
        Ok(Series { driven, held_out, time: log.time().to_vec(), compared: all, records })
    }

    /// Runs the FMU through all records, each with the shared values and its own; `number` is that of the
    /// log.
    pub(super) fn simulate(
        &mut self,
        number: usize,
        asked: &[Asked],
        values: &[f64],
    ) -> anyhow::Result<Memory> {
        let mut memory = Memory::new();
        for record in 0..self.records.len() {
            for (asked, value) in asked.iter().zip(values).filter(|(a, _)| a.is_of(number, record))
            {
                self.driven.set(&asked.name, Value::Real(*value))?;
            }
            if let Some(ending) = self.driven.run_one(record, &mut memory)? {
                bail!("FMU `{}` asked for the end of the run at {} s", ending.slave, ending.time);
            }
        }
        Ok(memory)
    }

    /// Residuals of each output in each record, one after the other.
    pub(super) fn lengths(&self) -> Vec<usize> {
        let windows = self.records.iter().filter_map(|record| record.window.clone());
        windows.flat_map(|window| vec![window.len(); self.compared.len()]).collect()
    }

    /// Simulated and measured values of an output in each record that counts.
    fn pairs<'s>(
        &'s self,
        compared: &'s Compared,
        run: &'s Memory,
    ) -> impl Iterator<Item = Option<(&'s Judged, &'s [f64], &'s [f64])>> {
        let simulated = run.values(&compared.output);
        self.records.iter().zip(run.records()).filter_map(move |(record, rows)| {
            let window = record.window.clone()?;
            let first = rows.start + (window.start - record.rows.start);
            let part = simulated.and_then(|all| all.get(first..first + window.len()));
            Some(part.zip(compared.values.get(window)).map(|(s, y)| (record, s, y)))
        })
    }

    /// The weighted residuals, in the order of [`Series::lengths`]; none where rows are missing.
    pub(super) fn residuals(&self, run: &Memory, weights: &Weights) -> Option<Vec<f64>> {
        let mut parts: Vec<Vec<Vec<f64>>> = vec![Vec::new(); self.records.len()];
        for compared in &self.compared {
            let weight = weights.of(&compared.output);
            for (number, pair) in self.pairs(compared, run).enumerate() {
                let (_, s, y) = pair?;
                parts[number].push(s.iter().zip(y).map(|(s, y)| (s - y) / weight).collect());
            }
        }
        Some(parts.concat().concat())
    }

    /// How well each output of each record fits.
    pub(super) fn fits(
        &self,
        log: PathBuf,
        before: &Memory,
        after: &Memory,
    ) -> anyhow::Result<Vec<LogFit>> {
        let mut fits = Vec::new();
        for compared in &self.compared {
            for (old, new) in self.pairs(compared, before).zip(self.pairs(compared, after)) {
                let (Some((_, old, _)), Some((record, s, y))) = (old, new) else { continue };
                let window = record.window.clone().unwrap_or_default();
                let Compared { output, column, unit, .. } = compared;
                let of = |s: &[f64]| OutputFit::new(output, column, record.id, unit, &window, y, s);
                let rmse_at_start = of(old)?.raw_rmse;
                let (log, held_out) = (log.clone(), self.held_out);
                let curves = Curves {
                    time: self.time.get(window.clone()).unwrap_or_default().to_vec(),
                    measured: y.to_vec(),
                    start: old.to_vec(),
                    estimated: s.to_vec(),
                };
                fits.push(LogFit { log, held_out, rmse_at_start, fit: of(s)?, curves });
            }
        }
        Ok(fits)
    }
}

/// What the residuals of each output are divided by.
pub(super) struct Weights(pub(super) Vec<(String, f64)>);

impl Weights {
    /// The range of what was measured; 1 where it rests.
    pub(super) fn by_range(series: &[Series<'_>]) -> Self {
        let mut weights: Vec<(String, f64)> = Vec::new();
        for compared in series.iter().flat_map(|one| &one.compared) {
            let ends = compared
                .values
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
            let range = ends.1 - ends.0;
            match weights.iter_mut().find(|(output, _)| *output == compared.output) {
                Some((_, weight)) => *weight = weight.max(range),
                None => weights.push((compared.output.clone(), range)),
            }
        }
        weights
            .iter_mut()
            .filter(|(_, weight)| *weight <= 0.0)
            .for_each(|(_, weight)| *weight = 1.0);
        Weights(weights)
    }

    /// The root of the mean square of what a run leaves, which is not taken for less than a part in 1e9
    /// of the range.
    pub(super) fn by_rest(series: &[Series<'_>], runs: &[Memory]) -> Self {
        let mut weights = Weights::by_range(series);
        for (output, weight) in &mut weights.0 {
            let (mut squares, mut count) = (0.0, 0_usize);
            for (one, run) in series.iter().zip(runs) {
                for compared in one.compared.iter().filter(|compared| compared.output == *output) {
                    for (_, s, y) in one.pairs(compared, run).flatten() {
                        squares += s.iter().zip(y).map(|(s, y)| (s - y).powi(2)).sum::<f64>();
                        count += s.len();
                    }
                }
            }
            *weight = (squares / count.max(1) as f64).sqrt().max(1e-9 * *weight);
        }
        weights
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    fn of(&self, output: &str) -> f64 {
        self.0.iter().find(|(name, _)| name == output).map_or(1.0, |(_, weight)| *weight)
    }
}

/// Further starts: within finite bounds spread over them, else from half to twice the scale about the
/// start. They are the same in every run (additive recurrence of the golden ratio).
pub(super) fn starts(tunables: &[Tunable], count: usize) -> Vec<Vec<f64>> {
    let golden = 0.618_033_988_749_894_9_f64;
    let point = |number: usize| {
        let coordinate = |(k, t): (usize, &Tunable)| {
            let part = (golden.powi(k as i32 + 1) * number as f64 + 0.5).fract();
            let (low, high) = if t.lower.is_finite() && t.upper.is_finite() {
                (t.lower, t.upper)
            } else if t.start != 0.0 {
                (0.5 * t.start, 2.0 * t.start)
            } else {
                (-t.scale, t.scale)
            };
            (low + part * (high - low)).clamp(t.lower, t.upper)
        };
        tunables.iter().enumerate().map(coordinate).collect()
    };
    (1..count).map(point).collect()
}
