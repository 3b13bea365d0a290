//! The plant of a measured response: fitted over held inputs, and judged in simulation.

use std::path::{Path, PathBuf};

use anyhow::Context;
use identify::frequency::{
    Choice, Experiment, FrequencyResponse as Response, HeldPlant, Level, PlantNames,
    RationalSettings, choose_held, refined, relative, softened,
};
use identify::simulate_axes;

use crate::commands::identify::{identifier, usual_unit};
use crate::results::frequency_response::{
    Plant, PlantError, PlantLevel, PlantSoftening, Signal, SofteningMode,
};

/// What a plant is fitted to.
pub(super) struct Source<'a> {
    pub(super) experiments: &'a [Experiment],
    pub(super) sample_time: f64,
    pub(super) response: &'a Response,
    /// All levels, where the modes are to follow the amplitude.
    pub(super) levels: &'a [(usize, Level)],
    /// Whether the modes of one level are refined.
    pub(super) refine: bool,
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
    let (held, mut choice) = choose_held(source.response, source.sample_time, settings, most)
        .context("no plant can be fitted")?;
    let held = if source.refine || !source.levels.is_empty() {
        last_fit(source, held, &mut choice, notes)?
    } else {
        held
    };
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
    let softening = softening_of(&held, source.levels);
    Ok((Plant { blueprint: file.to_owned(), modes, delay_s, softening, errors, checked }, choice))
}

/// The plant of least output error from one whose poles were found: at the level, or following the amplitude.
fn last_fit(
    source: &Source<'_>,
    held: HeldPlant,
    choice: &mut Choice,
    notes: &mut Vec<String>,
) -> anyhow::Result<HeldPlant> {
    let rms = rms_of(source.experiments);
    let plant = if source.levels.is_empty() {
        let level = Level { response: source.response.clone(), rms };
        refined(&level, &held).unwrap_or_else(|error| {
            notes.push(format!("the modes are those found first, not refined: {error}"));
            held
        })
    } else {
        let levels: Vec<Level> = source.levels.iter().map(|(_, level)| level.clone()).collect();
        if levels.len() == 2 {
            notes.push(
                "two levels do not tell by which power of the amplitude the modes follow it: 1 is taken"
                    .to_owned(),
            );
        }
        softened(&levels, &held).context("no modes that follow the amplitude can be fitted")?
    };
    // The model that is reported is that of the response that is reported.
    let amplitude = plant.softening.as_ref().map_or(1.0, |softening| {
        let shown = source.levels.iter().find(|(_, level)| level.response == *source.response);
        shown.map_or(1.0, |(_, level)| relative(&level.rms, &softening.rms))
    });
    choice.model = plant.at_amplitude(amplitude).rational();
    choice.misfit = source.response.misfit(&choice.model);
    Ok(plant)
}

fn softening_of(held: &HeldPlant, levels: &[(usize, Level)]) -> Option<PlantSoftening> {
    let softening = held.softening.as_ref()?;
    let laws = softening.shift.iter().zip(&softening.growth);
    Some(PlantSoftening {
        exponent: softening.exponent,
        levels: levels
            .iter()
            .map(|(experiments, level)| PlantLevel {
                experiments: *experiments,
                rms: level.rms.clone(),
            })
            .collect(),
        modes: held
            .modes
            .iter()
            .zip(laws)
            .map(|(mode, (shift, growth))| SofteningMode {
                frequency: mode.frequency,
                damping: mode.damping,
                frequency_shift: *shift,
                damping_growth: *growth,
            })
            .collect(),
    })
}

/// Rms of each input about its mean, over all experiments.
pub(super) fn rms_of(experiments: &[Experiment]) -> Vec<f64> {
    let inputs = experiments.first().map_or(0, |e| e.inputs.len());
    let count = experiments.len().max(1) as f64;
    let of = |k: usize| experiments.iter().map(|e| deviation(&e.inputs[k]).powi(2)).sum::<f64>();
    (0..inputs).map(|k| (of(k) / count).sqrt()).collect()
}

/// Root mean square about the mean.
fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}
