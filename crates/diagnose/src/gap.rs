//! The answer, as `gap.json` holds it.
//!
//! Absent values are null and never left out; no number is infinite or not a number.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::between::{Between, Reading};

/// Name and version of the schema.
pub const SCHEMA: &str = "piezoloop.gap/1";

/// What the gap between a machine and its model is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Always [`SCHEMA`].
    pub schema: String,
    /// The answer in one sentence.
    pub sentence: String,
    /// The verdict; of several outputs the worst.
    pub verdict: Verdict,
    /// The effects that are named, of all outputs, the one that explains most first.
    pub effects: Vec<NamedEffect>,
    /// The best partial answer of each output that is `unknown`: no name, but what one effect alone would do.
    #[serde(default)]
    pub partial: Vec<Partial>,
    /// Where the gap lies.
    #[serde(rename = "where")]
    pub place: Place,
    /// How much of it goes, on rows that were not used, for the output of [`Place`].
    pub shrink: Shrink,
    /// Parameters of the model as they were re-tuned under their tolerance, by name.
    pub retuned: BTreeMap<String, Retuned>,
    /// What is left.
    pub leftover: Leftover,
    /// What to measure next; null where nothing is undecided.
    pub next_experiment: Option<NextExperiment>,
    /// All candidates that were tried, best first.
    pub candidates: Vec<Tried>,
    /// Verdict and shrink of each output.
    pub outputs: Vec<OutputGap>,
    /// What the gap was made from.
    pub provenance: Provenance,
    /// The linear models that were identified from the logs, one per output, where no model was given.
    #[serde(default)]
    pub baseline: Vec<Baseline>,
    /// What the reader must know before trusting the rest.
    pub warnings: Vec<String>,
}

impl Gap {
    /// The named effects of each output, the output of [`place`](Self::place) first.
    #[must_use]
    pub fn by_output(&self) -> Vec<(&str, Vec<&NamedEffect>)> {
        let mut all: Vec<(&str, Vec<&NamedEffect>)> = Vec::new();
        for effect in &self.effects {
            match all.iter_mut().find(|(output, _)| *output == effect.output) {
                Some((_, own)) => own.push(effect),
                None => all.push((&effect.output, vec![effect])),
            }
        }
        all.sort_by(|(a, _), (b, _)| {
            let is_main = |output: &str| output == self.place.output;
            is_main(b).cmp(&is_main(a)).then(a.cmp(b))
        });
        all
    }
}

/// The verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model explains the logs down to the noise.
    Adequate,
    /// It does once parameters are re-tuned within their tolerance.
    Retune,
    /// Effects are missing that are known by name.
    Effects,
    /// Something is missing that no candidate explains.
    Unknown,
    /// The logs do not move the machine enough to tell.
    InsufficientExcitation,
}

impl Verdict {
    /// Whether the logs are explained: by effects, or because none is needed.
    #[must_use]
    pub const fn is_explained(self) -> bool {
        matches!(self, Self::Effects | Self::Retune | Self::Adequate)
    }
}

/// One effect that the model lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedEffect {
    /// Identifier, as in `creep`.
    pub effect: String,
    /// Output that shows it.
    pub output: String,
    /// Further outputs that show the same cause.
    #[serde(default)]
    pub also: Vec<String>,
    /// Stage on the signal path.
    pub stage: String,
    /// Probability that the name is right, given the data and this library.
    pub probability: f64,
    /// The smallest set of names with a probability of at least 0.95, the most probable first.
    pub set: Vec<String>,
    /// `lag`, `gain`, `slow`, `static_map` or null.
    pub group: Option<String>,
    /// Fitted parameters by name.
    pub parameters: BTreeMap<String, Estimate>,
    /// Part of the held-out gap's power that goes with this effect alone (given the others).
    pub explained: f64,
}

/// What the best single effect would do for an output of which none is named.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Partial {
    /// The effect, its probability far from certain, and the part of the held-out gap's power that would go.
    pub effect: NamedEffect,
    /// Held-out root mean square of the re-tuned model.
    pub rms_before: f64,
    /// Held-out root mean square with the effect as a model can predict it.
    pub rms_after: f64,
    /// Unit of both.
    pub unit: String,
    /// Fraction with the course of a drift taken from the rows around each row, where the candidate is a drift that no
    /// model predicts. Null otherwise.
    #[serde(default)]
    pub own_course: Option<f64>,
}

/// An estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard deviation; null where the data do not say.
    pub std: Option<f64>,
    /// Unit.
    pub unit: String,
}

/// The linear model of one output, made from the logs of the diagnosis themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    /// Output.
    pub output: String,
    /// Components in the order of the signal path.
    pub structure: String,
    /// Their fitted parameters by the names of the model; `std` is the tolerance (1 σ) that the diagnosis gives them.
    pub parameters: BTreeMap<String, Estimate>,
    /// Root mean square that it leaves on the rows it was fitted to and on the others, over their range; null where
    /// there is none.
    pub nrmse: [Option<f64>; 2],
}

/// Where the gap lies, after the re-tune and before any effect is added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The output with the largest gap over its noise.
    pub output: String,
    /// Stage of the most probable effect; null where none is named.
    pub stage: Option<String>,
    /// Bands of frequency with their share of the gap's power, the largest first.
    pub bands: Vec<BandShare>,
    /// Records with their share of the gap's power.
    pub records: Vec<RecordShare>,
    /// How the gap goes with the amplitude.
    pub amplitude: Option<String>,
    /// Whether it depends on the direction of motion.
    pub branch: Option<String>,
    /// How it goes with time.
    pub time: Option<String>,
    /// Whether the command causes it.
    pub input_driven: Option<bool>,
    /// Squared coherence of the gap with the inputs and the auxiliary columns, by column.
    pub coherence: BTreeMap<String, f64>,
}

/// A band's share of the gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BandShare {
    /// Lower and upper end in Hz.
    pub hz: [f64; 2],
    /// Share of the gap's power, noise taken off.
    pub share: f64,
    /// Level over the noise in dB before and after the effects are added.
    pub over_noise_db: [f64; 2],
}

/// A record's share of the gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordShare {
    /// Name: the log's file and the record's number.
    pub record: String,
    /// Share of the gap's power.
    pub share: f64,
    /// Root mean square of the residual before and after, in the output's unit.
    pub rms: [f64; 2],
}

/// How much of the gap goes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shrink {
    /// Unit of the root mean squares.
    pub unit: String,
    /// Root mean square of the held-out residual of the re-tuned model.
    pub rms_before: f64,
    /// Root mean square of the held-out residual with the effects added.
    pub rms_after: f64,
    /// Standard deviation of the noise.
    pub noise_floor: f64,
    /// `1 − (rms_after² − noise²)/(rms_before² − noise²)`, at most 1; 0 without an effect; null
    /// where there is no gap to shrink.
    pub fraction: Option<f64>,
    /// 95 % prediction interval of `fraction` for a new record of the kinds held out.
    pub ci95: Option<[f64; 2]>,
    /// Root mean square of the held-out residual of the model as it came, before any re-tune.
    pub rms_as_given: f64,
    /// `rms_as_given` over the range of the measured output; what `--fail-above` looks at.
    pub relative_gap: f64,
    /// Figures per held-out stretch.
    pub holdout: Vec<HeldOut>,
    /// Figures with complete records left out of the fit; null where logs were given to be held out,
    /// where there are less than three records, or where no effect is named.
    pub second_opinion: Option<SecondOpinion>,
    /// `fraction` with the effects' formulas as they were found, where a repaired blueprint was written:
    /// the other figures are then those of the model that was handed back. Null else.
    pub as_found: Option<f64>,
    /// Offset that all records share, which is part of the repaired model, in the output's unit; null where they share
    /// none.
    #[serde(default)]
    pub offset: Option<f64>,
    /// Root mean square of the held-out rows as they stand, no record's own offset taken out: of the model as it
    /// came, and of the one with effects, re-tune and the shared offset. Null where they could not be simulated.
    #[serde(default)]
    pub rms_as_it_stands: Option<[f64; 2]>,
    /// `fraction` with the course of a drift taken from the rows around each row. No model predicts such a course, so that
    /// the other figures leave it out. Null without one.
    #[serde(default)]
    pub own_course: Option<f64>,
}

/// What goes in records that were left out of the fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SecondOpinion {
    /// Which records were left out.
    pub split: String,
    /// Fraction of the gap that goes, over all records.
    pub fraction: f64,
    /// Whether it is at least half of what goes on the rows that were held out.
    pub agrees: bool,
    /// Figures per record.
    pub records: Vec<HeldOut>,
}

/// One held-out stretch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Name of the record.
    pub record: String,
    /// First and last row, from 1, within the record.
    pub rows: [usize; 2],
    /// Root mean square before.
    pub rms_before: f64,
    /// Root mean square after.
    pub rms_after: f64,
    /// Fraction of the gap that goes; null where there was none.
    pub fraction: Option<f64>,
}

/// A parameter after the re-tune.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Retuned {
    /// As the model has it.
    pub from: f64,
    /// After the re-tune, with the effects added.
    pub to: f64,
    /// One standard deviation of its tolerance.
    pub tolerance: f64,
    /// Unit.
    pub unit: String,
    /// Whether it stopped at three standard deviations: it is out of tolerance.
    pub at_limit: bool,
}

/// What is left once the effects are added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leftover {
    /// Whether something is left: the mean square is more than 1.15 times the noise's.
    pub present: bool,
    /// Mean square of the held-out residual over the noise's.
    pub over_noise: f64,
    /// Whether it is driven by the command.
    pub input_driven: Option<bool>,
    /// Bands where it lies.
    pub bands: Vec<BandShare>,
    /// The leftover's size and how long it lasts; null where nothing is left.
    #[serde(default)]
    pub discrepancy: Option<Discrepancy>,
    /// The effect that it looks like, though that is not named; null where it looks like none.
    #[serde(default)]
    pub looks_like: Option<String>,
}

/// What no formula of the answer foretells beside the noise: how accurate the answer is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Discrepancy {
    /// Root mean square in the output's unit.
    pub rms: f64,
    /// Root mean square over the range of the measured output.
    pub of_range: f64,
    /// Time in s after which it is another one: its correlation falls as exp(−t/T).
    pub time: f64,
}

/// What to measure next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    /// One sentence.
    pub sentence: String,
    /// The effects that it separates.
    pub separates: Vec<String>,
    /// Name of the signal.
    pub signal: String,
    /// Expected fall of the wrong rival's misfit, in units of the noise's variance; null where it
    /// cannot be predicted.
    pub predicted_gain: Option<f64>,
    /// Sample time in s.
    pub period: Option<f64>,
    /// Columns of the signal to play, by name of the input.
    pub columns: BTreeMap<String, Vec<f64>>,
}

/// A candidate that was tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tried {
    /// Effect.
    pub effect: String,
    /// Output.
    pub output: String,
    /// The formula of the family that fitted best.
    pub formula: String,
    /// Held-out score, 1: down to the noise, 0: no better than the re-tuned model; null where it
    /// was screened out before it was fitted.
    pub score: Option<f64>,
    /// Mean square of the training residual over the noise's.
    pub training: Option<f64>,
    /// Mean square of the held-out residual over the noise's.
    pub holdout: Option<f64>,
    /// Part of the training gap that the first-order test promised.
    pub screening: f64,
    /// Probability for the first slot.
    pub probability: f64,
    /// Whether it is named.
    pub accepted: bool,
    /// Why it has no score; null where it has one.
    #[serde(default)]
    pub left_out: Option<String>,
    /// Fitted parameters.
    pub parameters: BTreeMap<String, Estimate>,
}

/// Verdict and shrink of one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputGap {
    /// Output.
    pub output: String,
    /// The output gap's verdict.
    pub verdict: Verdict,
    /// The output gap's effects.
    pub effects: Vec<String>,
    /// The output gap's figures.
    pub shrink: Shrink,
    /// How the noise was found, and the other estimates of it.
    pub noise: NoiseFloor,
    /// What the command was taken to do between the rows.
    #[serde(default)]
    pub between: Between,
    /// When the readings of rows were taken to be taken.
    #[serde(default)]
    pub reading: Reading,
    /// Seconds by which each reading was found to be later than that, within its row. Null where it was not.
    #[serde(default)]
    pub reading_late: Option<f64>,
}

/// The noise of an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseFloor {
    /// What the diagnosis used.
    pub sigma: f64,
    /// `given`, `rest record`, `periods`, `second differences`, or `steps of the reading`: rounding with the noise
    /// before it.
    pub source: String,
    /// From the second differences of the logs: a lower bound, exact for white noise.
    pub second_differences: Option<f64>,
    /// From the differences between periods of the logs.
    pub periods: Option<f64>,
    /// Frequency in Hz below which the noise grows as 1/f; null where it is white.
    pub corner: Option<f64>,
}

/// What is known of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ModelKind {
    /// Its components: a blueprint.
    #[serde(rename = "white box")]
    WhiteBox,
    /// Its inputs, outputs and parameters: an FMU.
    #[serde(rename = "black box")]
    BlackBox,
}

/// What the answer was made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Tool.
    pub tool: String,
    /// Version.
    pub version: String,
    /// Model.
    pub model: String,
    /// What is known of the model.
    pub kind: ModelKind,
    /// Logs.
    pub logs: Vec<String>,
    /// Logs that were only judged on.
    pub holdout: Vec<String>,
    /// How rows were held out.
    pub split: String,
    /// Seed.
    pub seed: u64,
    /// Effects that were taken out of the library.
    pub without: Vec<String>,
    /// Number of simulations of all records.
    pub simulations: u64,
}
