//! The fit of one output of a run.

use std::fmt;
use std::ops::Range;

use data::Fit;
use serde::Serialize;

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
