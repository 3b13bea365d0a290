//! How a record begins: the command under which the machine rested before the first row, and the run-in
//! during which it still remembers what nobody recorded.
//!
//! A static Prandtl–Ishlinskii model is fitted to rows well inside the record, where its start hardly
//! matters, and simulated from the first row for each command that the machine may have rested under: the
//! first row's, and zero, as a machine that is switched on. The one that foretells the first rows better
//! is taken. What is still off then, by more than the model is off later, is the run-in, unless a model fitted
//! without these rows foretells the held-out rows worse than one fitted with them: the largest strokes of a record
//! often are its first, and a model that has not seen them knows less.

use serde::Serialize;

use crate::error::Error;
use crate::fit::delay;
use crate::fit::operator::{Operator, Solved};
use crate::fit::residual::mean;
use crate::methods::STATIC;
use crate::record::{Record, Rows};
use crate::settings::{Plan, Settings};

/// Part of the rows fitted on, at their end, that the static model is fitted to here.
const INSIDE: f64 = 0.5;
/// Part of a record's rows, from its first, that a rest is judged by.
const FIRST_ROWS: f64 = 0.1;
/// Fewest rows that a rest is judged by.
const FEWEST: usize = 10;
/// Another rest than the first row's must leave at most this part of the error of the first rows.
const CLEARLY_BETTER: f64 = 0.8;
/// A row belongs to the run-in where its error is this many times the error inside the record.
const OFF: f64 = 4.0;
/// Without a run-in the held-out rows may be foretold this many times worse; more is lost than a start is worth.
const WORSE: f64 = 1.02;
/// Plays of the static model.
const PLAYS: usize = 15;

/// How one record begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Beginning {
    /// Command under which the machine rested before the first row, in the record's unit.
    pub rest: f64,
    /// Time from the first row until the machine has forgotten what was before, in s.
    pub run_in: f64,
}

/// How each record begins, as its first rows show. Where the caller gave a rest, that one is kept; `settings.drop`
/// does not matter.
///
/// # Errors
/// [`Error`], as [`identify`](crate::identify()) has them for records or settings that do not suit.
pub fn beginnings(records: &[Record], settings: &Settings) -> Result<Vec<Beginning>, Error> {
    let settings = Settings { drop: 0.0, plays: PLAYS, thresholds: None, ..settings.clone() };
    let plan = settings.plan(records)?;
    let rows = plan.fitted.iter().map(|rows| Rows { first: inside(*rows), end: rows.end });
    let rows: Vec<Rows> = rows.collect();
    let scene = plan.scene(records);
    let (method, scene, period) = (STATIC, &scene, plan.period);
    let operator = Operator { method, scene, records, rows: &rows, period, substeps: 1 };
    let solved = delay::search(&operator, plan.longest_delay, &mut |_, _| {})?.solved;
    let found = (0..records.len()).map(|k| beginning(&operator, k, &solved));
    let mut found = found.collect::<Result<Vec<_>, _>>()?;
    if found.iter().any(|beginning| beginning.run_in > 0.0) {
        let rested = records.iter().zip(&found).map(|(r, b)| r.clone().rested_at(b.rest));
        let rested: Vec<Record> = rested.collect();
        let error_without = |from: &[f64]| -> Result<f64, Error> {
            let rows = plan.fitted.iter().zip(records).zip(from).map(|((rows, record), from)| {
                Rows { first: ((from / record.period()) as usize).min(rows.end), end: rows.end }
            });
            let rows: Vec<Rows> = rows.collect();
            let operator = Operator { records: &rested, rows: &rows, ..operator };
            held_out_error(&operator, &plan, &operator.solve(solved.linear, &[])?)
        };
        let run_ins: Vec<f64> = found.iter().map(|beginning| beginning.run_in).collect();
        if error_without(&run_ins)? > WORSE * WORSE * error_without(&vec![0.0; found.len()])? {
            found.iter_mut().for_each(|beginning| beginning.run_in = 0.0);
        }
    }
    Ok(found)
}

/// Mean square of what the model is off on the held-out rows, each record's mean taken out.
fn held_out_error(operator: &Operator<'_>, plan: &Plan, solved: &Solved) -> Result<f64, Error> {
    let (mut sum, mut count) = (0.0, 0);
    for (record, rows) in operator.records.iter().zip(&plan.judged) {
        let errors = errors(operator, record, record.rest(), solved)?;
        let errors = rows.of(&errors);
        let offset = mean(errors);
        sum += errors.iter().map(|e| (e - offset).powi(2)).sum::<f64>();
        count += errors.len();
    }
    Ok(sum / count.max(1) as f64)
}

/// What the model is off in each row of a record whose machine rested under this command.
fn errors(
    operator: &Operator<'_>,
    record: &Record,
    rest: f64,
    solved: &Solved,
) -> Result<Vec<f64>, Error> {
    let model = operator.position(solved, record, rest, Rows { first: 0, end: record.len() })?;
    Ok(record.output().iter().zip(model).map(|(y, model)| y - model).collect())
}

fn inside(rows: Rows) -> usize {
    rows.first + ((1.0 - INSIDE) * rows.len() as f64) as usize
}

/// How the record of this index begins.
fn beginning(operator: &Operator<'_>, index: usize, solved: &Solved) -> Result<Beginning, Error> {
    let (record, rows) = (&operator.records[index], operator.rows[index]);
    let errors = |rest: f64| -> Result<Vec<f64>, Error> {
        let all = errors(operator, record, rest, solved)?;
        let offset = mean(rows.of(&all));
        Ok(all.into_iter().map(|e| e - offset).collect())
    };
    let rms = |e: &[f64]| mean(&e.iter().map(|e| e * e).collect::<Vec<_>>()).sqrt();
    let count = ((FIRST_ROWS * rows.end as f64) as usize).max(FEWEST).min(rows.first);
    let mut rest = record.rest();
    let mut error = errors(rest)?;
    if record.given_rest().is_none() && rest != 0.0 {
        let other = errors(0.0)?;
        if rms(&other[..count]) < CLEARLY_BETTER * rms(&error[..count]) {
            (rest, error) = (0.0, other);
        }
    }
    let usual = rms(rows.of(&error));
    let last_off = error[..rows.first].iter().rposition(|e| e.abs() > OFF * usual);
    // The first row is read before any command acts; alone it says nothing of a run-in.
    let run_in =
        last_off.filter(|row| *row > 0).map_or(0.0, |row| (row + 1) as f64 * record.period());
    Ok(Beginning { rest, run_in })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Columns;
    use components::hysteresis::play::{Drive, Threshold, play};

    const PERIOD: f64 = 1e-3;
    const THRESHOLDS: [f64; 4] = [0.0, 4.0, 10.0, 20.0];
    const WEIGHTS: [f64; 4] = [0.06, 0.02, 0.02, 0.03];

    /// What a machine of plays answers that rested at `rest`.
    fn answers(input: &[f64], rest: f64, thresholds: &[f64], weights: &[f64]) -> Vec<f64> {
        let mut plays: Vec<f64> =
            thresholds.iter().map(|r| play(Drive(rest), Threshold(*r), 0.0)).collect();
        let mut held = rest;
        let mut answer = |u: &f64| {
            let mut y = 0.0;
            for ((p, r), w) in plays.iter_mut().zip(thresholds).zip(weights) {
                *p = play(Drive(held), Threshold(*r), *p);
                y += w * *p;
            }
            held = *u;
            y
        };
        input.iter().map(&mut answer).collect()
    }

    fn record_of(input: &[f64], output: &[f64]) -> Record {
        let time: Vec<f64> = (0..input.len()).map(|k| k as f64 * PERIOD).collect();
        let (input_name, output_name) = ("u", "y");
        Record::new(Columns { name: "a", time: &time, input_name, input, output_name, output })
            .unwrap()
    }

    /// A sine from 20 to 80 V on a machine of four plays that rested at `rest`, and drifts by `settling` (um) at first.
    fn record(rest: f64, settling: f64) -> Record {
        let input: Vec<f64> = (0..8000)
            .map(|k| 50.0 + 30.0 * (2.0 * std::f64::consts::PI * f64::from(k) * PERIOD).sin())
            .collect();
        let mut output = answers(&input, rest, &THRESHOLDS, &WEIGHTS);
        for (k, y) in output.iter_mut().enumerate() {
            *y += settling * (-(k as f64) * PERIOD / 0.2).exp();
            *y += 2e-3 * ((k * 7919 % 1013) as f64 / 1013.0 - 0.5);
        }
        record_of(&input, &output)
    }

    fn found(record: Record) -> Beginning {
        beginnings(&[record], &Settings::default()).unwrap()[0]
    }

    #[test]
    fn the_command_that_a_machine_rested_under_is_found() {
        assert_eq!(found(record(0.0, 0.0)).rest, 0.0);
        assert_eq!(found(record(50.0, 0.0)).rest, 50.0);
        // What the caller gave is kept.
        assert_eq!(found(record(0.0, 0.0).rested_at(50.0)).rest, 50.0);
    }

    #[test]
    fn the_largest_strokes_are_no_run_in_where_the_held_out_rows_need_them() {
        // One stroke of 100 V, smaller ones, then strokes of 90 V on a machine of five plays.
        let (thresholds, weights) = ([0.0, 5.0, 15.0, 30.0, 45.0], [0.05, 0.02, 0.02, 0.02, 0.03]);
        let high =
            |k: u32| [100.0, 60.0, 55.0, 50.0].get(k as usize / 1000).copied().unwrap_or(90.0);
        let triangle = |k: u32| 1.0 - (f64::from(k % 1000) / 500.0 - 1.0).abs();
        let input: Vec<f64> = (0..8000).map(|k| high(k) * triangle(k)).collect();
        let played = record_of(&input, &answers(&input, 0.0, &thresholds, &weights));
        assert_eq!(found(played), Beginning { rest: 0.0, run_in: 0.0 });
    }

    #[test]
    fn a_run_in_lasts_until_the_error_is_that_of_the_rest() {
        assert!(found(record(50.0, 0.0)).run_in <= 0.01);
        let run_in = found(record(50.0, 1.0)).run_in;
        // 1 um·exp(-t/0.2 s) falls to a few nm within some 1.2 s.
        assert!((0.4..1.6).contains(&run_in), "{run_in}");
    }
}
