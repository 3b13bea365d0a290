//! The result of an identification.

use data::CheckedBlueprint;
use serde::Serialize;

use crate::error::Error;
use crate::judge::{Figures, compare};
use crate::record::{Record, Rows};

/// A plant identified from records, with the evidence for it.
#[derive(Clone, Debug, Serialize)]
pub struct Identification {
    /// The plant, ready to be written.
    #[serde(skip)]
    pub plant: CheckedBlueprint,
    /// Unit of the positions in all figures.
    pub unit: String,
    /// What the figures mean.
    pub rules: &'static str,
    /// Name of the method of the plant.
    pub method: &'static str,
    /// Whether the caller stopped before every method was tried.
    pub stopped: bool,
    /// Agreement with each record.
    pub records: Vec<RecordFit>,
    /// The model structures that were tried, the simplest first.
    pub candidates: Vec<Candidate>,
    /// Every fitted parameter.
    pub parameters: Vec<Estimate>,
}

/// How every figure of an [`Identification`] is made.
pub const RULES: &str = "simulation mode: the plant is built from its blueprint, starts at rest \
    under the record's first command and never sees the measured position; each figure's own \
    constant offset is fitted to its rows and stated; no drift is removed; rows held out take no \
    part in any fit of parameters, and only decide which of the tried structures is returned";

/// Agreement with one record.
#[derive(Clone, Debug, Serialize)]
pub struct RecordFit {
    /// The record.
    pub record: String,
    /// The plant on the rows fitted on.
    pub fitted: Figures,
    /// The plant on the rows held out.
    pub held_out: Figures,
    /// The best straight line without delay on the rows fitted on.
    pub baseline_fitted: Figures,
    /// The best straight line without delay on the rows held out.
    pub baseline_held_out: Figures,
    /// Simulated position of every row, without offset.
    #[serde(skip)]
    pub simulation: Vec<f64>,
    /// Measured less simulated position of every row, less the offset of the rows held out.
    #[serde(skip)]
    pub residual: Vec<f64>,
    /// Measured position of every row less that of the straight line, less its offset of the rows held out.
    #[serde(skip)]
    pub baseline_residual: Vec<f64>,
}

/// A model structure that was tried.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// Name of its method; none for a straight line.
    pub method: Option<&'static str>,
    /// The candidate's components in the order of the signal path.
    pub structure: String,
    /// Root mean square error of the simulation over all rows held out, an offset per record taken
    /// out; `None` where the fit failed.
    pub held_out_rmse: Option<f64>,
    /// Error on the rows held out in parts of their range, the largest of all records.
    pub held_out_nrmse: Option<f64>,
    /// Error on the rows fitted on in parts of their range, the largest of all records.
    pub fitted_nrmse: Option<f64>,
    /// Numbers that were fitted.
    pub parameters: usize,
    /// Time that the fit took, in s.
    pub seconds: f64,
    /// What a Gaussian process says of its own errors; `None` for all others.
    pub predicted: Option<Predicted>,
    /// Whether it is the plant that was returned.
    pub accepted: bool,
    /// Why, or why not.
    pub reason: String,
    /// The plant; `None` where the fit failed.
    #[serde(skip)]
    pub plant: Option<CheckedBlueprint>,
    /// Simulated position of every row of each record, without offset; empty where the fit failed.
    #[serde(skip)]
    pub simulations: Vec<Vec<f64>>,
}

/// The standard deviations that a Gaussian process predicts on rows held out, √(variance of the mean + σ_n²), beside its errors
/// there. It is that of all samples. In the position's unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Predicted {
    /// Rows that were looked at, even over all that are held out.
    pub rows: usize,
    /// Median of the standard deviations.
    pub median: f64,
    /// The greatest one.
    pub greatest: f64,
    /// σ_n.
    pub noise: f64,
    /// Part of the errors, less their mean of each record, within 1.96 standard deviations: 0.95 where the process knows what it does not know.
    pub within: f64,
    /// The plant's output `deviation`, where it was asked for.
    pub output: Option<DeviationOutput>,
}

/// The standard deviation as an output of the plant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeviationOutput {
    /// Samples that it runs on.
    pub centres: usize,
    /// The deviation output's greatest difference from that of all samples on these rows, as a part of it.
    pub apart: f64,
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Name in the plant, as in `hysteresis.w[3]`.
    pub name: String,
    /// Value in `unit`.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard deviation in `unit`, for correlated residuals; `None` where there is none to give.
    pub deviation: Option<f64>,
    /// What the data say about it.
    pub verdict: Verdict,
    /// The other parameter that its error goes with most; `None` where there is none to name.
    pub correlated: Option<Correlation>,
}

/// A correlation with another parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Correlation {
    /// The correlation's name.
    pub with: String,
    /// Correlation coefficient, from −1 to 1.
    pub coefficient: f64,
}

/// What the data say about a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Known to better than half its value.
    Determined,
    /// Its standard deviation is half its value or more.
    Uncertain,
    /// The best value is the bound itself.
    AtBound,
    /// The records do not move this part of the model: any value fits as well.
    NotExcited,
}

impl Identification {
    /// Parameters that the data do not determine.
    pub fn undetermined(&self) -> impl Iterator<Item = &Estimate> {
        self.parameters
            .iter()
            .filter(|p| matches!(p.verdict, Verdict::Uncertain | Verdict::NotExcited))
    }
}

impl RecordFit {
    /// Of one record, with the model's and the straight line's simulation.
    pub(crate) fn of(
        record: &Record,
        fitted: Rows,
        judged: Rows,
        simulation: &[f64],
        line: &[f64],
    ) -> Self {
        let output = record.output();
        let held_out = compare(output, simulation, judged);
        let baseline_held_out = compare(output, line, judged);
        let residual = |simulation: &[f64], offset: f64| {
            output.iter().zip(simulation).map(|(y, s)| y - s - offset).collect()
        };
        Self {
            record: record.name().to_owned(),
            fitted: compare(output, simulation, fitted),
            held_out,
            baseline_fitted: compare(output, line, fitted),
            baseline_held_out,
            simulation: simulation.to_vec(),
            residual: residual(simulation, held_out.offset),
            baseline_residual: residual(line, baseline_held_out.offset),
        }
    }
}

impl Candidate {
    /// A candidate whose fit failed.
    pub(crate) fn failed(method: Option<&'static str>, structure: String, error: &Error) -> Self {
        Self {
            method,
            structure,
            held_out_rmse: None,
            held_out_nrmse: None,
            fitted_nrmse: None,
            parameters: 0,
            seconds: 0.0,
            predicted: None,
            accepted: false,
            reason: error.to_string(),
            plant: None,
            simulations: Vec::new(),
        }
    }
}
