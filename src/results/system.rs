//! What a system's run gives.

use std::io::{self, Write};
use std::path::PathBuf;

use cli::{Answer, rounded};
use cosim::record::Column;
use serde::Serialize;

use super::simulate::EarlyEnd;
use crate::messages::FmuMessage;
use crate::times::RunTimes;

/// What was run.
#[derive(Serialize)]
pub(crate) struct Ran {
    pub(crate) system: String,
    pub(crate) fmus: Vec<String>,
    pub(crate) algorithm: &'static str,
    pub(crate) step_s: f64,
    pub(crate) rows: usize,
    pub(crate) start_s: f64,
    pub(crate) stop_s: f64,
    pub(crate) run: Option<PathBuf>,
    pub(crate) endings: Vec<EarlyEnd>,
    /// Columns of the input table that feed nothing.
    pub(crate) unused_columns: Vec<String>,
    /// Inputs that nothing feeds.
    pub(crate) unfed_inputs: Vec<String>,
    pub(crate) messages: Vec<FmuMessage>,
    /// How long the FMUs took.
    pub(crate) times: RunTimes,
    pub(crate) notes: Vec<String>,
    /// What the page draws.
    #[serde(skip)]
    pub(crate) drawn: Drawn,
}

impl Answer for Ran {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for note in &self.notes {
            writeln!(out, "note: {note}")?;
        }
        writeln!(
            out,
            "{}: {} by {}, {}, {} s to {} s in steps of {} s",
            self.system,
            shown(&self.fmus),
            self.algorithm,
            data::counted(self.rows, "row"),
            rounded(self.start_s),
            rounded(self.stop_s),
            rounded(self.step_s)
        )?;
        match &self.run {
            Some(run) => writeln!(out, "{}: written", run.display()),
            None => Ok(()),
        }
    }
}

/// The names of a system's FMUs, of many the first.
fn shown(fmus: &[String]) -> String {
    const MOST: usize = 10;
    let (first, rest) = fmus.split_at(fmus.len().min(MOST));
    match rest.len() {
        0 => first.join(", "),
        more => format!("{}, and {more} more FMUs", first.join(", ")),
    }
}

/// The recorded variables of a run, for its page: all rows, or of a long run every `stride`-th.
#[derive(Default)]
pub(crate) struct Drawn {
    pub(crate) columns: Vec<Column>,
    pub(crate) time: Vec<f64>,
    /// One list for each column.
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) stride: usize,
    rows: usize,
}

impl Drawn {
    /// The greatest number of values that are kept.
    const MOST: usize = 4_000_000;

    pub(crate) fn begin(&mut self, columns: &[Column]) {
        let values = vec![Vec::new(); columns.len()];
        *self = Drawn { columns: columns.to_vec(), values, stride: 1, ..Drawn::default() };
    }

    pub(crate) fn row(&mut self, time: f64, values: &[f64]) {
        if self.rows.is_multiple_of(self.stride) {
            if self.time.len() * self.values.len() >= Self::MOST {
                self.thin();
            }
            // After thinning this row may be one of those that are left out.
            if self.rows.is_multiple_of(self.stride) {
                self.time.push(time);
                self.values.iter_mut().zip(values).for_each(|(all, value)| all.push(*value));
            }
        }
        self.rows += 1;
    }

    /// Leaves every second row out.
    fn thin(&mut self) {
        for all in self.values.iter_mut().chain([&mut self.time]) {
            *all = all.iter().step_by(2).copied().collect();
        }
        self.stride *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_is_drawn_by_every_nth_row() {
        let column = |name: &str| Column { name: name.into(), unit: None };
        let mut drawn = Drawn::default();
        drawn.begin(&[column("a"), column("b")]);
        let rows = 3 * Drawn::MOST / 2;
        for k in 0..rows {
            drawn.row(k as f64, &[2.0 * k as f64, -(k as f64)]);
        }
        assert_eq!(drawn.stride, 4);
        assert_eq!(drawn.time.len(), rows.div_ceil(4));
        assert!(drawn.time.iter().enumerate().all(|(k, t)| *t == 4.0 * k as f64));
        assert!(drawn.time.iter().zip(&drawn.values[0]).all(|(t, a)| *a == 2.0 * t));
        assert!(drawn.time.iter().zip(&drawn.values[1]).all(|(t, b)| *b == -t));
    }
}
