//! The result of an identification.

use data::CheckedBlueprint;
use serde::Serialize;

use crate::judge::Figures;

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
    part in any fit of parameters, and only decide whether a lag or a mode is kept";

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
    /// The same on the rows held out.
    pub baseline_held_out: Figures,
    /// Simulated position of every row, without offset.
    #[serde(skip)]
    pub simulation: Vec<f64>,
    /// Measured less simulated position of every row, less the offset of the rows held out.
    #[serde(skip)]
    pub residual: Vec<f64>,
    /// The same for the straight line.
    #[serde(skip)]
    pub baseline_residual: Vec<f64>,
}

/// A model structure that was tried.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Its components in the order of the signal path.
    pub structure: String,
    /// Root mean square error of the simulation over all rows held out, an offset per record taken
    /// out; `None` where the fit failed.
    pub held_out_rmse: Option<f64>,
    /// Whether it is the plant that was returned.
    pub accepted: bool,
    /// Why, or why not.
    pub reason: String,
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
