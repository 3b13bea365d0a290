//! Signals of different times on one uniform grid.

use super::quality::median;
use super::{Column, GIVE_A_RATE, Log, RATES, SampleTime};
use crate::{Problem, Problems, counted};

/// Onto which uniform times a log is brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resample {
    /// The times of the group with the shortest sample time.
    Fastest,
    /// Times at this rate in Hz.
    Rate(f64),
}

/// Most rows that are created.
const MOST_ROWS: f64 = 1e9;
/// Bytes that any log may become, and how many times its own a larger one, as binary files may.
const FREE: f64 = 268_435_456.0;
const EXPANSION: f64 = 100.0;

/// Most rows of a log of so many columns of numbers, made of so many numbers, in the memory that the
/// caller allows.
fn most_rows(memory: Option<u64>, numbers: usize, columns: usize) -> f64 {
    let bytes = memory.map_or((EXPANSION * 8.0 * numbers as f64).max(FREE), |given| given as f64);
    (bytes / 8.0 / (columns + 1) as f64).floor().min(MOST_ROWS)
}

/// The uniform times that begin at `start`.
#[derive(Clone, Copy)]
struct Grid {
    start: f64,
    period: f64,
    rows: usize,
}

impl Grid {
    fn of(
        origin: &str,
        period: f64,
        (start, end): (f64, f64),
        most: f64,
    ) -> Result<Self, Problems> {
        let problem = |rule: String, way_out: &str| {
            Problems::from(Problem::new(origin, rule, way_out).at("--resample"))
        };
        if !RATES.contains(&period) {
            return Err(problem(format!("a sample time of {period} s is none"), GIVE_A_RATE));
        }
        if start > end {
            let rule = format!(
                "the groups have no time in common: one begins at {start} s, another ends at {end} s"
            );
            return Err(problem(rule, "choose one: --group NAME"));
        }
        // An instant within 1e-9 sample times of the end is the end.
        let rows = ((end - start) / period + 1e-9).floor() + 1.0;
        if rows > most {
            let rule = format!(
                "{rows:e} rows from {start} s to {end} s are too many, there is memory for {most}; is time in us?"
            );
            let way_out = "give a lower rate: --resample=HZ, the unit of time: --unit time=us, or more memory: --log-memory MB";
            return Err(problem(rule, way_out));
        }
        Ok(Self { start, period, rows: rows as usize })
    }

    fn times(self) -> impl Iterator<Item = f64> {
        // A whole number of Hz gives the times that a reader of decimals would give.
        let rate = (1.0 / self.period).round();
        let integer = (self.start * rate).round();
        let is_exact =
            (rate * self.period - 1.0).abs() < 1e-12 && (integer - self.start * rate).abs() < 1e-9;
        (0..self.rows).map(move |row| match is_exact {
            true => (integer + row as f64) / rate,
            false => self.start + row as f64 * self.period,
        })
    }

    /// The values of a signal with these times; straight lines between its samples, or held until the next.
    fn signal(self, time: &[f64], values: &[f64], is_held: bool) -> Vec<f64> {
        let mut row = 0;
        let near = 1e-9 * self.period;
        self.times()
            .map(|at| {
                while row + 1 < time.len() && time[row + 1] <= at + near {
                    row += 1;
                }
                let (Some(before), Some(next)) = (time.get(row), time.get(row + 1)) else {
                    return values[row];
                };
                let part = ((at - before) / (next - before)).clamp(0.0, 1.0);
                if is_held || at - before <= near {
                    values[row]
                } else {
                    values[row] + part * (values[row + 1] - values[row])
                }
            })
            .collect()
    }
}

/// Whether a signal is held between its samples: whole numbers only, as states and switches have.
fn is_held(values: &[f64]) -> bool {
    values.iter().all(|value| value.fract() == 0.0)
}

/// The usual sample time of a record in s.
fn period(log: &Log) -> f64 {
    let uniform = log
        .records()
        .first()
        .and_then(|record| log.sample_time(record, SampleTime::TOLERANCE).ok());
    uniform.map_or_else(
        || {
            let mut all: Vec<f64> = log.time().windows(2).map(|pair| pair[1] - pair[0]).collect();
            median(&mut all).unwrap_or(f64::INFINITY)
        },
        |grid| grid.period,
    )
}

fn description(held: &[String], rate: f64, start: f64, end: f64) -> String {
    let held = match held {
        [] => String::new(),
        names => format!(" ({} held: whole numbers)", names.join(", ")),
    };
    format!(
        "resampled onto {rate} Hz from {start} s to {end} s, straight lines between samples{held}; no filter: what is \
         faster than half the rate folds down"
    )
}

/// Joins groups by name on the times that they have in common.
pub(super) fn groups(
    origin: &str,
    groups: Vec<(String, Log)>,
    resample: Resample,
    memory: Option<u64>,
) -> Result<Log, Problems> {
    let ends = |log: &Log| (log.time().first().copied(), log.time().last().copied());
    let start = groups.iter().filter_map(|(_, log)| ends(log).0).fold(f64::NEG_INFINITY, f64::max);
    let end = groups.iter().filter_map(|(_, log)| ends(log).1).fold(f64::INFINITY, f64::min);
    let period = match resample {
        Resample::Rate(rate) => 1.0 / rate,
        Resample::Fastest => {
            groups.iter().map(|(_, log)| period(log)).fold(f64::INFINITY, f64::min)
        }
    };
    let columns = groups.iter().map(|(_, log)| log.columns.len()).sum();
    let numbers = groups.iter().map(|(_, log)| log.len() * (log.columns.len() + 1)).sum();
    let grid = Grid::of(origin, period, (start, end), most_rows(memory, numbers, columns))?;
    let mut joined = Log::new(origin, grid.times().collect())?;
    let names: Vec<String> = groups
        .iter()
        .map(|(name, log)| format!("\"{name}\" ({})", counted(log.len(), "row")))
        .collect();
    let mut held = Vec::new();
    for (group, log) in groups {
        for column in &log.columns {
            let is_held = is_held(&column.values);
            let values = grid.signal(log.time(), &column.values, is_held);
            let name = match joined.column(&column.name) {
                Some(_) => format!("{group}/{}", column.name),
                None => column.name.clone(),
            };
            if is_held {
                held.push(name.clone());
            }
            joined.names.added(&name, joined.columns.len());
            joined.columns.push(Column { name, values, ..column.clone() });
        }
        joined.remarks.notes.extend(log.remarks.notes);
        joined.remarks.left_out.extend(log.remarks.left_out);
    }
    let last = joined.time().last().copied().unwrap_or(start);
    let how = description(&held, 1.0 / period, start, last);
    joined.remarks.is_joined = true;
    joined.remarks.notes.push(format!("groups {} are joined and {how}", names.join(", ")));
    Ok(joined)
}

impl Log {
    /// The log with each record on a uniform grid of its own.
    pub(super) fn resampled(
        mut self,
        resample: Resample,
        memory: Option<u64>,
    ) -> Result<Self, Problems> {
        let Some(first) = self.records.first() else { return Ok(self) };
        let period = match resample {
            Resample::Rate(rate) => 1.0 / rate,
            Resample::Fastest => period(&self.select(first.rows.clone())),
        };
        let held: Vec<bool> = self.columns.iter().map(|column| is_held(&column.values)).collect();
        let numbers = self.len() * (held.len() + 1);
        let mut left = most_rows(memory, numbers, held.len());
        let (mut time, mut columns, mut records) =
            (Vec::new(), vec![Vec::new(); held.len()], Vec::new());
        for record in &self.records {
            let old = &self.time[record.rows.clone()];
            let (Some(start), Some(end)) = (old.first(), old.last()) else { continue };
            let grid = Grid::of(&self.origin, period, (*start, *end), left)?;
            left -= grid.rows as f64;
            let begin = time.len();
            time.extend(grid.times());
            for ((new, column), held) in columns.iter_mut().zip(&self.columns).zip(&held) {
                new.extend(grid.signal(old, &column.values[record.rows.clone()], *held));
            }
            records.push(super::Record { id: record.id, rows: begin..time.len() });
        }
        let names = self
            .columns
            .iter()
            .zip(&held)
            .filter(|(_, held)| **held)
            .map(|(column, _)| column.name.clone());
        let (start, end) =
            (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0));
        self.remarks.notes.push(description(&names.collect::<Vec<_>>(), 1.0 / period, start, end));
        (self.time, self.records, self.lines) = (time, records, super::Lines::default());
        for (column, values) in self.columns.iter_mut().zip(columns) {
            column.values = values;
        }
        Ok(self)
    }
}
