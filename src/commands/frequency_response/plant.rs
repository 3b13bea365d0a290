//! The plant of a measured response: fitted over held inputs, and judged in simulation.

use std::path::{Path, PathBuf};

use anyhow::Context;
use data::CheckedBlueprint;
use identify::frequency::{
    Choice, Experiment, FrequencyResponse as Response, PlantNames, RationalSettings, choose_held,
};
use identify::simulate_axes;
use serde::Serialize;

use super::Signal;
use crate::commands::identify::{identifier, usual_unit};

/// A plant as it is written.
#[derive(Serialize)]
pub(crate) struct Plant {
    pub(crate) blueprint: PathBuf,
    pub(crate) modes: usize,
    pub(crate) delay_s: f64,
    /// Per record and output.
    pub(crate) errors: Vec<PlantError>,
    #[serde(skip)]
    pub(crate) checked: CheckedBlueprint,
}

/// How far the plant is from a record that it was fitted to, driven by its inputs alone.
#[derive(Serialize)]
pub(crate) struct PlantError {
    pub(crate) record: String,
    pub(crate) output: String,
    pub(crate) unit: String,
    /// Root mean square of measured less simulated, the means of both taken out.
    pub(crate) rmse: f64,
    /// The same over the measured output's own.
    pub(crate) relative: f64,
    /// First row that is judged: with periods the second one's, as the simulation starts at rest.
    pub(crate) from_row: usize,
}

/// What a plant is fitted to.
pub(super) struct Source<'a> {
    pub(super) experiments: &'a [Experiment],
    pub(super) sample_time: f64,
    pub(super) response: &'a Response,
    pub(super) inputs: &'a [Signal],
    pub(super) outputs: &'a [Signal],
    pub(super) logs: &'a [PathBuf],
}

/// Fits a plant of at most `most` modes.
pub(super) fn fitted(
    source: &Source<'_>,
    file: &Path,
    settings: &RationalSettings,
    most: usize,
    notes: &mut Vec<String>,
) -> anyhow::Result<(Plant, Choice)> {
    let (held, choice) = choose_held(source.response, source.sample_time, settings, most)
        .context("no plant can be fitted")?;
    let mut unit = |signal: &Signal, usual: &str| {
        signal.unit.clone().unwrap_or_else(|| usual_unit(&signal.name, usual, notes))
    };
    let units: Vec<String> = source.inputs.iter().map(|signal| unit(signal, "V")).collect();
    let outputs = source.outputs.iter().map(|s| (identifier(&s.name), unit(s, "um"))).collect();
    let range = |k: usize| {
        let all = || source.experiments.iter().flat_map(|e| e.inputs[k].iter().copied());
        (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max))
    };
    let inputs = source.inputs.iter().zip(&units).enumerate();
    let logs: Vec<String> = source.logs.iter().map(|log| log.display().to_string()).collect();
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let names = PlantNames {
        model: identifier(&stem),
        description: format!(
            "Modes fitted to the frequency response of {} over {} lines",
            logs.join(", "),
            source.response.lines.len()
        ),
        inputs: inputs
            .map(|(k, (signal, unit))| (identifier(&signal.name), unit.clone(), range(k)))
            .collect(),
        outputs,
    };
    let checked = held.blueprint(&names)?;
    let mut errors = Vec::new();
    for experiment in source.experiments {
        let first = source.response.period.filter(|p| 2 * p <= experiment.len()).unwrap_or(0);
        let time = |row: usize| row as f64 * source.sample_time;
        let rest: Vec<f64> =
            experiment.inputs.iter().map(|u| u.first().copied().unwrap_or(0.0)).collect();
        let simulated = simulate_axes(&checked, &experiment.inputs, &rest, time)?;
        for ((signal, measured), simulated) in
            names.outputs.iter().zip(&experiment.outputs).zip(&simulated)
        {
            let (measured, simulated) = (&measured[first..], &simulated[first..]);
            let error: Vec<f64> = measured.iter().zip(simulated).map(|(y, s)| y - s).collect();
            let rmse = deviation(&error);
            errors.push(PlantError {
                record: experiment.name.clone(),
                output: signal.0.clone(),
                unit: signal.1.clone(),
                rmse,
                relative: rmse / deviation(measured),
                from_row: first + 1,
            });
        }
    }
    let (modes, delay_s) = (held.modes.len(), held.delay);
    Ok((Plant { blueprint: file.to_owned(), modes, delay_s, errors, checked }, choice))
}

/// Root mean square about the mean.
fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}
