//! What an estimation gives.

use std::io::{self, Write};
use std::path::PathBuf;

use cli::Answer;
use serde::Serialize;

use super::simulate::OutputFit;
use crate::messages::FmuMessage;

/// What was estimated.
#[derive(Serialize)]
pub(crate) struct Estimated {
    pub(crate) model: String,
    pub(crate) parameters: Vec<Found>,
    /// Correlation of each parameter with each, in their order.
    pub(crate) correlation: Vec<Vec<f64>>,
    /// Groups of parameters that the logs do not determine: only together, or one not at all.
    pub(crate) undetermined: Vec<Vec<String>>,
    pub(crate) fits: Vec<LogFit>,
    /// Residuals of an output are divided by this before they are squared.
    pub(crate) weights: Vec<(String, f64)>,
    /// Sum of the squares of the weighted residuals.
    pub(crate) squares: f64,
    pub(crate) residuals: usize,
    /// Sum of squares that each start led to.
    pub(crate) starts: Vec<Option<f64>>,
    pub(crate) runs: usize,
    pub(crate) failed_runs: usize,
    pub(crate) set: Option<PathBuf>,
    /// The FMU that begins with what was found.
    pub(crate) fmu: Option<PathBuf>,
    pub(crate) messages: Vec<FmuMessage>,
    pub(crate) notes: Vec<String>,
}

impl Answer for Estimated {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for note in &self.notes {
            writeln!(out, "note: {note}")?;
        }
        writeln!(out, "{}: {} residuals, {} runs", self.model, self.residuals, self.runs)?;
        for (k, found) in self.parameters.iter().enumerate() {
            let unit = found.unit.as_ref().filter(|unit| *unit != "1");
            let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
            let of = found.of.as_ref().map_or(String::new(), |of| format!(" of {of}"));
            let interval = match found.interval {
                Some([low, high]) => format!("95 % within {low:.6e} to {high:.6e}{unit}"),
                None if found.at_bound => "at its bound".to_owned(),
                None => "not determined".to_owned(),
            };
            let others = self.correlation[k].iter().enumerate().filter(|(l, _)| *l != k);
            let most = others.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            let most = most.filter(|(_, c)| c.abs() > 0.0).map_or(String::new(), |(l, c)| {
                format!(", correlation {c:.3} with {}", self.parameters[l].name)
            });
            writeln!(
                out,
                "  {}{of} = {:.9e}{unit} ({interval}; began with {}{most})",
                found.name, found.value, found.start
            )?;
        }
        for LogFit { log, held_out, rmse_at_start, fit, .. } in &self.fits {
            let how = if *held_out { ", held out" } else { "" };
            writeln!(
                out,
                "  {}{how}: {fit}; rmse with the start values {rmse_at_start:.5}",
                log.display()
            )?;
        }
        let mut written = self.set.iter().chain(&self.fmu);
        written.try_for_each(|file| writeln!(out, "{}: written", file.display()))
    }
}

/// A parameter that was found.
#[derive(Serialize)]
pub(crate) struct Found {
    pub(crate) name: String,
    /// The record that an initial value belongs to.
    pub(crate) of: Option<String>,
    pub(crate) unit: Option<String>,
    pub(crate) start: f64,
    pub(crate) value: f64,
    pub(crate) sigma: Option<f64>,
    /// 95 % interval.
    pub(crate) interval: Option<[f64; 2]>,
    pub(crate) at_bound: bool,
}

/// How well one output of one record fits, before and after.
#[derive(Serialize)]
pub(crate) struct LogFit {
    pub(crate) log: PathBuf,
    pub(crate) held_out: bool,
    pub(crate) rmse_at_start: f64,
    #[serde(flatten)]
    pub(crate) fit: OutputFit,
    /// For the page.
    #[serde(skip)]
    pub(crate) curves: Curves,
}

/// An output over the rows that count: time in s; measured, with the start values, with the estimates.
pub(crate) struct Curves {
    pub(crate) time: Vec<f64>,
    pub(crate) measured: Vec<f64>,
    pub(crate) start: Vec<f64>,
    pub(crate) estimated: Vec<f64>,
}
