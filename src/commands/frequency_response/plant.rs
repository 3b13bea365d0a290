//! The plant of a measured response: fitted over held inputs, and judged in simulation.

use std::path::{Path, PathBuf};

use anyhow::Context;
use data::CheckedBlueprint;
use identify::frequency::{
    Choice, Experiment, FrequencyResponse as Response, PlantNames, RationalSettings, choose_held,
};
use serde::Serialize;

use super::Signal;
use crate::commands::identify::identifier;

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
    let mut unit = |signal: &Signal, usual: &str| match &signal.unit {
        Some(unit) => unit.clone(),
        None => {
            let name = &signal.name;
            notes.push(format!(
                "column {name} has no unit, taken as {usual}; say another with --unit {name}=UNIT"
            ));
            usual.to_owned()
        }
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
        let simulated = simulated(&checked, experiment, source.sample_time)?;
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

/// The outputs of the plant at each row, at rest under the first one before.
fn simulated(
    plant: &CheckedBlueprint,
    experiment: &Experiment,
    sample_time: f64,
) -> anyhow::Result<Vec<Vec<f64>>> {
    let mut system = plant.build();
    let find = |name: &str, k: usize| {
        let variable = format!("{name}[{}]", k + 1);
        system.variables().find(&variable).with_context(|| format!("the plant has no {variable}"))
    };
    let each = |name: &'static str, count: usize| {
        (0..count).map(|k| find(name, k)).collect::<anyhow::Result<Vec<_>>>()
    };
    let commands = each("command", experiment.inputs.len())?;
    let positions = each("position", experiment.outputs.len())?;
    let mut outputs = vec![Vec::with_capacity(experiment.len()); positions.len()];
    for row in 0..experiment.len() {
        for (command, input) in commands.iter().zip(&experiment.inputs) {
            system
                .set(*command, input[row.saturating_sub(1)])
                .map_err(|e| anyhow::anyhow!("{}", system.explain_set(&e)))?;
        }
        let moved = if row == 0 {
            system.initialise(0.0)
        } else {
            system.advance(row as f64 * sample_time).map(|_| ())
        };
        moved.map_err(|e| anyhow::anyhow!("{}", system.explain(&e)))?;
        for (position, output) in positions.iter().zip(&mut outputs) {
            output.push(system.get(*position).unwrap_or(f64::NAN));
        }
    }
    Ok(outputs)
}
