//! What a simulation gives.

use std::fmt;
use std::io::{self, Write};
use std::ops::Range;
use std::path::PathBuf;

use cli::{Answer, rounded};
use cosim::Memory;
use data::Fit;
use serde::Serialize;

use crate::messages::FmuMessage;
use crate::times::RunTimes;

/// What was simulated.
#[derive(Serialize)]
pub(crate) struct Simulated {
    pub(crate) model: String,
    pub(crate) records: usize,
    pub(crate) rows: usize,
    pub(crate) start_s: f64,
    pub(crate) stop_s: f64,
    pub(crate) fits: Vec<OutputFit>,
    pub(crate) run: Option<PathBuf>,
    /// Records that an FMU ended itself.
    pub(crate) endings: Vec<EarlyEnd>,
    /// Columns of the log that neither feed an input nor measure an output.
    pub(crate) unused_columns: Vec<String>,
    /// Inputs that no column feeds.
    pub(crate) unfed_inputs: Vec<String>,
    /// What FMUs said, each message once.
    pub(crate) messages: Vec<FmuMessage>,
    /// How long the FMUs took.
    pub(crate) times: RunTimes,
    pub(crate) notes: Vec<String>,
    #[serde(skip)]
    pub(crate) signals: Memory,
    #[serde(skip)]
    pub(crate) measured: Vec<(String, Vec<f64>)>,
}

impl Answer for Simulated {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for note in &self.notes {
            writeln!(out, "note: {note}")?;
        }
        writeln!(
            out,
            "{}: {} in {}, {} s to {} s",
            self.model,
            data::counted(self.rows, "row"),
            data::counted(self.records, "record"),
            rounded(self.start_s),
            rounded(self.stop_s)
        )?;
        for fit in &self.fits {
            writeln!(out, "  {fit}")?;
        }
        match &self.run {
            Some(run) => writeln!(out, "{}: written", run.display()),
            None => Ok(()),
        }
    }
}

/// A run that an FMU ended before its stop time.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct EarlyEnd {
    pub(crate) fmu: String,
    pub(crate) record: usize,
    pub(crate) time_s: f64,
}

impl EarlyEnd {
    pub(crate) fn note(&self) -> String {
        let Self { fmu, record, time_s } = self;
        let record = if *record == 0 { String::new() } else { format!(" in record {record}") };
        format!("FMU `{fmu}` asked for the end of the run at {time_s} s{record}")
    }
}

/// The fit of one output in one record; for a loop, of a position to its reference.
#[derive(Serialize)]
pub(crate) struct OutputFit {
    pub(crate) output: String,
    pub(crate) against: String,
    pub(crate) record: i64,
    pub(crate) unit: String,
    pub(crate) samples: usize,
    pub(crate) first_row: usize,
    pub(crate) last_row: usize,
    pub(crate) offset: f64,
    pub(crate) rmse: f64,
    pub(crate) range: f64,
    pub(crate) nrmse_percent: Option<f64>,
    pub(crate) max_error: f64,
    pub(crate) fit_percent: Option<f64>,
    /// Without the offset taken out.
    pub(crate) raw_rmse: f64,
    pub(crate) raw_max_error: f64,
}

impl OutputFit {
    pub(crate) fn new(
        output: &str,
        against: &str,
        record: i64,
        unit: &str,
        rows: &Range<usize>,
        measured: &[f64],
        simulated: &[f64],
    ) -> anyhow::Result<Self> {
        let fit = Fit::of(measured, simulated)?;
        let raw = measured.iter().zip(simulated).map(|(y, s)| (s - y).abs()).fold(0.0, f64::max);
        Ok(Self {
            output: output.to_owned(),
            against: against.to_owned(),
            record,
            unit: unit.to_owned(),
            samples: fit.samples,
            first_row: rows.start + 1,
            last_row: rows.end,
            offset: fit.offset,
            rmse: fit.rmse,
            range: fit.range,
            nrmse_percent: Some(100.0 * fit.nrmse).filter(|v| v.is_finite()),
            max_error: fit.max_error,
            fit_percent: Some(fit.fit_percent).filter(|v| v.is_finite()),
            raw_rmse: fit.raw_rmse,
            raw_max_error: raw,
        })
    }
}

impl fmt::Display for OutputFit {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |p: Option<f64>| p.map_or("-".to_owned(), |p| format!("{p:.3} %"));
        write!(
            out,
            "{} against {}, record {}, rows {} to {}: rmse {:.5} {u} = {} of range, max {:.5} {u}, offset {:.5} {u} removed; with the offset rmse {:.5} {u}, max {:.5} {u}",
            self.output,
            self.against,
            self.record,
            self.first_row,
            self.last_row,
            self.rmse,
            percent(self.nrmse_percent),
            self.max_error,
            self.offset,
            self.raw_rmse,
            self.raw_max_error,
            u = self.unit
        )
    }
}
