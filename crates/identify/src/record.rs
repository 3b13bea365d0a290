//! One record: the command of one axis and its position, sampled uniformly.

use std::path::Path;

use data::{Log, Problems};
use serde::Serialize;

use crate::error::{Error, Problem};

/// Largest distance of a sample from the uniform grid, in periods.
const GRID_TOLERANCE: f64 = 0.02;
/// Relative difference up to which two periods count as one.
const SAME_PERIOD: f64 = 1e-3;
/// Most parts of the shortest period into which records of several rates are divided.
const MOST_PARTS: u32 = 10;
/// Fewest samples of a record.
const FEWEST: usize = 20;

/// One uniformly sampled record of one axis.
///
/// Row k: the input acts from t_k until t_{k+1} (zero-order hold); the output is read at t_k before
/// the input acts.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    name: String,
    start: f64,
    period: f64,
    input_name: String,
    output_name: String,
    input: Vec<f64>,
    output: Vec<f64>,
    rest: Option<f64>,
}

/// The columns of a record as they are given.
#[derive(Clone, Copy, Debug)]
pub struct Columns<'a> {
    /// Name for messages, as in `model_1hz_3v6.csv, record 1`.
    pub name: &'a str,
    /// Time in s.
    pub time: &'a [f64],
    /// Name of the input column.
    pub input_name: &'a str,
    /// The command, in the axis' unit.
    pub input: &'a [f64],
    /// Name of the output column.
    pub output_name: &'a str,
    /// The position, in the axis' unit.
    pub output: &'a [f64],
}

impl Record {
    /// Checks the columns.
    ///
    /// # Errors
    /// Every [`Problem`] that was found: lengths, values that are not finite, a time that is not
    /// uniform, too few samples.
    pub fn new(columns: Columns<'_>) -> Result<Self, Vec<Problem>> {
        let Columns { name, time, input, output, .. } = columns;
        let count = time.len();
        if input.len() != count || output.len() != count {
            return Err(vec![Problem::Lengths {
                record: name.to_owned(),
                time: count,
                input: input.len(),
                output: output.len(),
            }]);
        }
        let mut problems = Vec::new();
        let named = [("time", time), (columns.input_name, input), (columns.output_name, output)];
        for (column, values) in named {
            problems.extend(not_finite(name, column, values));
        }
        if count < FEWEST {
            problems.push(Problem::TooShort {
                record: name.to_owned(),
                part: "in all",
                found: count,
                needed: FEWEST,
            });
        }
        let grid = problems.is_empty().then(|| uniform(name, time));
        match grid {
            Some(Ok((start, period))) => Ok(Self {
                name: name.to_owned(),
                start,
                period,
                input_name: columns.input_name.to_owned(),
                output_name: columns.output_name.to_owned(),
                input: input.to_vec(),
                output: output.to_vec(),
                rest: None,
            }),
            Some(Err(problem)) => Err(vec![problem]),
            None => Err(problems),
        }
    }

    /// The same record of a machine that rested under this command before the first row; without it
    /// the machine is taken to have rested under the first row's command.
    #[must_use]
    pub fn rested_at(self, command: f64) -> Self {
        Self { rest: Some(command), ..self }
    }

    /// The command under which the machine rested before the first row.
    #[must_use]
    pub fn rest(&self) -> f64 {
        self.rest.or(self.input.first().copied()).unwrap_or(0.0)
    }

    /// That command where [`Record::rested_at`] set it.
    #[must_use]
    pub fn given_rest(&self) -> Option<f64> {
        self.rest
    }

    /// Name for messages.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Name of the input column.
    #[must_use]
    pub fn input_name(&self) -> &str {
        &self.input_name
    }

    /// Name of the output column.
    #[must_use]
    pub fn output_name(&self) -> &str {
        &self.output_name
    }

    /// Time of the first row in s.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Sample time in s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period
    }

    /// How many of these periods one of its own takes.
    pub(crate) fn periods(&self, period: f64) -> usize {
        ((self.period / period).round() as usize).max(1)
    }

    /// The command of each row.
    #[must_use]
    pub fn input(&self) -> &[f64] {
        &self.input
    }

    /// The position of each row.
    #[must_use]
    pub fn output(&self) -> &[f64] {
        &self.output
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.input.len()
    }

    /// Whether there are no rows (never so for a checked record).
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.input.is_empty()
    }

    /// Time of row `row` (from 0) in s.
    #[must_use]
    pub fn time(&self, row: usize) -> f64 {
        self.start + row as f64 * self.period
    }

    /// Time from the first row to the last in s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.len().saturating_sub(1) as f64 * self.period
    }

    /// The first row that is at least `time` s after the first, to 1e-6 of a period.
    #[must_use]
    pub fn row_at(&self, time: f64) -> usize {
        let row = (time / self.period - 1e-6).ceil().max(0.0);
        if row < self.len() as f64 { row as usize } else { self.len() }
    }
}

/// Rows `first` up to and without `end`, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Rows {
    /// First row.
    pub first: usize,
    /// The row behind the last.
    pub end: usize,
}

impl Rows {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.end.saturating_sub(self.first)
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// These rows of a column; shorter where the column ends.
    #[must_use]
    pub fn of<'a>(&self, column: &'a [f64]) -> &'a [f64] {
        let end = self.end.min(column.len());
        column.get(self.first.min(end)..end).unwrap_or(&[])
    }
}

/// Every record of a log: the columns `input` and `output` in the units of an axis. A column without
/// a unit is taken to be in the axis' unit.
///
/// # Errors
/// [`Error::Log`] with a missing column or a unit that does not convert, both columns at once;
/// [`Error::Unsuitable`] with every problem of every record.
pub fn records_of(
    log: &Log,
    (input, command_unit): (&str, &str),
    (output, position_unit): (&str, &str),
) -> Result<Vec<Record>, Error> {
    let columns = [log.convert(input, command_unit), log.convert(output, position_unit)];
    let [Ok(inputs), Ok(outputs)] = columns else {
        let wrong = columns.into_iter().filter_map(Result::err).flatten().collect();
        return Err(Error::Log(Problems::new(wrong)));
    };
    let mut records = Vec::new();
    let mut problems = Vec::new();
    for part in log.records() {
        let rows = part.rows.clone();
        // The file's name is enough to tell records apart; its folders make tables unreadable.
        let file = Path::new(log.origin()).file_name();
        let file = file.map_or_else(|| log.origin().into(), |name| name.to_string_lossy());
        let name = if log.records().len() > 1 {
            format!("{file}, record {} (from row {})", part.id, rows.start + 1)
        } else {
            file.into_owned()
        };
        let found = Record::new(Columns {
            name: &name,
            time: &log.time()[rows.clone()],
            input_name: input,
            input: &inputs[rows.clone()],
            output_name: output,
            output: &outputs[rows],
        });
        match found {
            Ok(record) => records.push(record),
            Err(found) => problems.extend(found),
        }
    }
    if problems.is_empty() { Ok(records) } else { Err(Error::Unsuitable(problems)) }
}

/// The longest period of which every record's is a multiple: the shortest one's, or a small part of it.
///
/// # Errors
/// [`Error::Unsuitable`] with every record whose period is no multiple of the shortest one's, or where there is none.
pub(crate) fn common_period(records: &[Record]) -> Result<f64, Error> {
    let finest = records.iter().map(Record::period).fold(f64::INFINITY, f64::min);
    if records.is_empty() {
        return Err(Error::Unsuitable(vec![Problem::NoRecord]));
    }
    let off = |record: &Record, period: f64| {
        let times = record.period / period;
        (times / times.round() - 1.0).abs() > SAME_PERIOD
    };
    let suits = |period: &f64| !records.iter().any(|record| off(record, *period));
    (1..=MOST_PARTS).map(|parts| finest / f64::from(parts)).find(suits).ok_or_else(|| {
        let others = records.iter().filter(|record| off(record, finest)).map(|record| {
            let (record, period) = (record.name.clone(), record.period);
            Problem::OtherPeriod { record, period, first: finest }
        });
        Error::Unsuitable(others.collect())
    })
}

fn not_finite(record: &str, column: &str, values: &[f64]) -> Option<Problem> {
    let bad: Vec<usize> = (0..values.len()).filter(|&i| !values[i].is_finite()).collect();
    bad.first().map(|&at| Problem::NotFinite {
        record: record.to_owned(),
        row: at + 1,
        column: column.to_owned(),
        value: values[at],
        count: bad.len(),
    })
}

/// Start and period of the grid that the times lie on.
fn uniform(record: &str, time: &[f64]) -> Result<(f64, f64), Problem> {
    let (start, last) = (time[0], time[time.len() - 1]);
    let period = (last - start) / (time.len() - 1) as f64;
    let off = |(row, time): (usize, &f64)| (row, (time - start) / period - row as f64);
    let worst = time
        .iter()
        .enumerate()
        .map(off)
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .unwrap_or((0, 0.0));
    if period > 0.0 && worst.1.abs() <= GRID_TOLERANCE {
        return Ok((start, nearest_decimal(period)));
    }
    Err(Problem::NotUniform {
        record: record.to_owned(),
        row: worst.0 + 1,
        time: time[worst.0],
        off: worst.1,
        period,
    })
}

/// The decimal number of few digits that `period` is within rounding of: times are written with a
/// finite number of digits, and 0.005 is meant where 0.00500000000000003 comes out.
fn nearest_decimal(period: f64) -> f64 {
    (2..=9)
        .filter_map(|digits| format!("{period:.digits$e}").parse::<f64>().ok())
        .find(|short| (short / period - 1.0).abs() < 1e-9)
        .unwrap_or(period)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns<'a>(time: &'a [f64], input: &'a [f64], output: &'a [f64]) -> Columns<'a> {
        Columns { name: "log", time, input_name: "u", input, output_name: "y", output }
    }

    fn grid(count: usize) -> Vec<f64> {
        (0..count).map(|k| 1.0 + k as f64 * 0.005).collect()
    }

    #[test]
    fn a_uniform_record_is_taken_with_its_grid() {
        let (time, values) = (grid(101), vec![1.0; 101]);
        let record = Record::new(columns(&time, &values, &values)).expect("good");
        assert_eq!((record.start(), record.period(), record.len()), (1.0, 0.005, 101));
        assert_eq!(record.duration(), 0.5);
        assert_eq!(record.row_at(0.25), 50);
        assert_eq!(record.row_at(0.2501), 51);
        assert_eq!(record.row_at(9.0), 101);
    }

    #[test]
    fn every_bad_value_is_named_with_its_row() {
        let (time, mut input, mut output) = (grid(50), vec![0.0; 50], vec![0.0; 50]);
        input[7] = f64::NAN;
        input[9] = f64::NAN;
        output[3] = f64::INFINITY;
        let problems = Record::new(columns(&time, &input, &output)).expect_err("bad");
        let text: Vec<String> = problems.iter().map(ToString::to_string).collect();
        assert_eq!(text.len(), 2);
        assert!(
            text[0].contains("row 8: u = NaN") && text[0].contains("2 such values"),
            "{text:?}"
        );
        assert!(text[1].contains("row 4: y = inf"), "{text:?}");
    }

    #[test]
    fn a_gap_in_time_is_refused_and_named() {
        let mut time = grid(60);
        for t in &mut time[30..] {
            *t += 0.1;
        }
        let values = vec![0.0; 60];
        let problems = Record::new(columns(&time, &values, &values)).expect_err("gap");
        assert!(matches!(problems[0], Problem::NotUniform { row: 30 | 31, .. }), "{problems:?}");
    }

    #[test]
    fn lengths_and_short_records_are_refused() {
        let (time, values) = (grid(19), vec![0.0; 19]);
        let short = Record::new(columns(&time, &values, &values)).expect_err("short");
        assert!(matches!(short[0], Problem::TooShort { found: 19, .. }));
        let uneven = Record::new(columns(&time, &values[1..], &values)).expect_err("uneven");
        assert!(matches!(uneven[0], Problem::Lengths { input: 18, .. }));
    }

    #[test]
    fn records_of_a_log_are_in_the_units_of_the_axis() {
        let rows: String = (0..60)
            .map(|k| format!("{},{},{},{}\n", k / 30, f64::from(k % 30) * 0.1, k, 2 * k))
            .collect();
        let text = format!("record,time,u [mV],y [nm]\n{rows}");
        let log = Log::parse(text.as_bytes(), "a.csv", &data::ReadOptions::default());
        let log = log.unwrap_or_else(|e| panic!("{e}"));
        let records = records_of(&log, ("u", "V"), ("y", "um")).expect("good");
        assert_eq!(records.len(), 2);
        assert_eq!(records[1].name(), "a.csv, record 1 (from row 31)");
        assert!((records[1].input()[0] - 0.03).abs() < 1e-15);
        assert!((records[1].output()[0] - 0.06).abs() < 1e-15);
        let wrong = records_of(&log, ("v", "V"), ("y", "K")).expect_err("both wrong").to_string();
        assert!(wrong.contains("is no column") && wrong.contains("does not convert"), "{wrong}");
    }

    #[test]
    fn rounded_times_give_the_period_that_was_meant() {
        let time: Vec<f64> =
            (0..5000).map(|k| (f64::from(k) / 6400.0 * 1e6).round() / 1e6).collect();
        let values = vec![0.0; 5000];
        let record = Record::new(columns(&time, &values, &values)).expect("uniform");
        assert!((record.period() * 6400.0 - 1.0).abs() < 1e-6);
    }
}
