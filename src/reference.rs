//! Reference results: a short run that travels with an FMU in `extra/`, and its repetition.
//!
//! ```text
//! extra/io.github.piezoloop/reference/reference.toml   start, step, rows, tolerance
//!                                     input.csv        time and inputs, row by row
//!                                     output.csv       time and outputs as the packing tool computed them
//! ```
//!
//! Rows are those of a log: u_k acts from t_k until t_{k+1}, y_k is read at t_k.

use std::fs;
use std::path::Path;

use anyhow::{Context, bail};
use cosim::record::Column;
use cosim::{CsvRecorder, Drive, Fmu, InstanceOptions, Memory, Recorder, Signals, Worker};
use data::{Log, ReadOptions};
use modeldescription::PackageBuilder;
use modeldescription::variable::{Causality, DataType, Number};
use serde::{Deserialize, Serialize};

use crate::fmus;

/// Folder below `extra/`.
pub(crate) const FOLDER: &str = "io.github.piezoloop/reference";
/// Format of the files.
const FORMAT: u32 = 1;
/// Rows of a run.
const ROWS: usize = 201;
/// Own steps of the model between two rows.
const STRIDE: f64 = 5.0;
/// Largest difference of an output, in parts of its peak-to-peak value, of a model whose arithmetic is
/// the same on every machine.
pub(crate) const OURS: f64 = 1e-9;
/// Largest difference of an output with an FMU of another vendor inside.
pub(crate) const FOREIGN: f64 = 1e-6;

/// Name, unit and values of a signal.
pub(crate) type Named = (String, String, Vec<f64>);

/// A run with its inputs.
pub(crate) struct Reference {
    pub(crate) time: Vec<f64>,
    pub(crate) inputs: Vec<Named>,
    pub(crate) outputs: Vec<Named>,
    /// Largest difference, in parts of the peak-to-peak value.
    pub(crate) tolerance: f64,
}

/// What `reference.toml` says.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct About {
    format: u32,
    /// Tool that computed the outputs.
    tool: String,
    rows: usize,
    /// Communication step in s.
    step: f64,
    /// Largest difference of an output over its peak-to-peak value.
    tolerance: f64,
}

/// What a repetition gave.
#[derive(Serialize)]
pub(crate) struct Replay {
    pub(crate) rows: usize,
    pub(crate) outputs: Vec<Compared>,
    pub(crate) tolerance: f64,
}

/// One output of a repetition.
#[derive(Serialize)]
pub(crate) struct Compared {
    pub(crate) name: String,
    /// Largest difference over the peak-to-peak value.
    pub(crate) difference: f64,
    /// Time of it in s.
    pub(crate) at: f64,
    pub(crate) is_within: bool,
}

impl Reference {
    /// Runs an FMU under signals of its own making.
    pub(crate) fn of(fmu: &Fmu, tolerance: f64) -> anyhow::Result<Self> {
        let experiment = fmu.description().default_experiment.as_ref();
        let step = STRIDE * experiment.and_then(|e| e.step_size).unwrap_or(1e-3);
        let time: Vec<f64> = (0..ROWS).map(|k| k as f64 * step).collect();
        let inputs = inputs(fmu, &time);
        let outputs = run(fmu, &time, &inputs)?;
        Ok(Self { time, inputs, outputs, tolerance })
    }

    /// Runs a package as far as it has come, as an importer would.
    pub(crate) fn of_package(
        package: &PackageBuilder,
        tolerance: f64,
        worker: Option<&Worker>,
    ) -> anyhow::Result<Self> {
        let folder = tempfile::tempdir().context("no temporary folder can be made")?;
        let file = folder.path().join("model.fmu");
        package.write(&file)?;
        Self::of(&fmus::load(&file, worker)?, tolerance)
    }

    /// Puts the files into a package.
    pub(crate) fn pack(&self, package: &mut PackageBuilder) -> anyhow::Result<()> {
        let about = About {
            format: FORMAT,
            tool: format!("Piezoloop {}", crate::VERSION),
            rows: self.time.len(),
            step: self.time.get(1).copied().unwrap_or(0.0),
            tolerance: self.tolerance,
        };
        let text = toml::to_string(&about)?;
        package.extra(&format!("{FOLDER}/reference.toml"), text.into_bytes())?;
        for (name, columns) in [("input.csv", &self.inputs), ("output.csv", &self.outputs)] {
            package.extra(&format!("{FOLDER}/{name}"), table(&self.time, columns)?)?;
        }
        Ok(())
    }
}

/// A table of numbers that read back to the bit.
fn table(time: &[f64], columns: &[Named]) -> anyhow::Result<Vec<u8>> {
    let heads: Vec<Column> =
        columns.iter().map(|(name, _, _)| Column { name: name.clone(), unit: None }).collect();
    let mut recorder = CsvRecorder::new(Vec::new());
    recorder.begin(0, &heads, time.len())?;
    let mut row = vec![0.0; columns.len()];
    for (k, t) in time.iter().enumerate() {
        row.iter_mut().zip(columns).for_each(|(cell, (_, _, values))| *cell = values[k]);
        recorder.row(*t, &row)?;
    }
    recorder.end()?;
    Ok(recorder.into_inner()?)
}

/// Two tones for each real input, within its bounds; truth values are on.
fn inputs(fmu: &Fmu, time: &[f64]) -> Vec<Named> {
    let names = fmu.names(Causality::Input);
    let length = time.last().copied().unwrap_or(1.0);
    let mut all = Vec::new();
    for (number, name) in names.into_iter().enumerate() {
        let Ok(variable) = fmu.variable(&name) else { continue };
        let properties = fmu.description().properties(&variable);
        let (start, unit) = (start_of(&variable), properties.unit.clone().unwrap_or_default());
        let values = match variable.data_type {
            DataType::Boolean => vec![1.0; time.len()],
            kind if kind.is_float() => {
                let bound = |number: Option<Number>| number.map(Number::as_f64);
                let (low, high) = match (bound(properties.min), bound(properties.max)) {
                    (Some(low), Some(high)) => (low, high),
                    _ => (start - 1.0, start + 1.0),
                };
                let phase = number as f64;
                let turns = |n: f64, t: f64| std::f64::consts::TAU * (n * t / length) + phase;
                let wave = |t: f64| 0.3 * turns(3.0, t).sin() + 0.15 * turns(17.0, t).cos();
                // From the start value into the middle of the range.
                let rise = |t: f64| (8.0 * t / length).min(1.0);
                let middle = 0.5 * (low + high);
                let at = |t: f64| start + rise(t) * (middle - start + 0.8 * (high - low) * wave(t));
                time.iter().map(|t| short(at(*t).clamp(low, high))).collect()
            }
            _ => vec![start; time.len()],
        };
        all.push((name, unit, values));
    }
    all
}

/// Six digits are enough for a signal, and make the file small.
fn short(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

fn start_of(variable: &modeldescription::variable::Variable) -> f64 {
    use modeldescription::variable::Start;
    match &variable.start {
        Some(Start::Float(values)) => values.first().copied().unwrap_or(0.0),
        Some(Start::Integer(values)) => values.first().map_or(0.0, |x| *x as f64),
        Some(Start::Boolean(values)) => f64::from(u8::from(values.first() == Some(&true))),
        _ => 0.0,
    }
}

/// The outputs of an FMU under these inputs.
fn run(fmu: &Fmu, time: &[f64], inputs: &[Named]) -> anyhow::Result<Vec<Named>> {
    let slave = fmu.instantiate("reference", &InstanceOptions::default())?;
    let signals =
        inputs.iter().fold(Signals::new(time), |all, (name, _, values)| all.with(name, values));
    let names = fmu.names(Causality::Output);
    let drive = Drive { record: names.clone(), ..Drive::default() };
    let mut memory = Memory::new();
    cosim::simulate_with_inputs(slave, &[signals], &drive, &mut memory)?;
    let series = |name: String| {
        let found = memory.series().iter().find(|series| series.column.name == name);
        found.map(|series| {
            (name, series.column.unit.clone().unwrap_or_default(), series.values.clone())
        })
    };
    Ok(names.into_iter().filter_map(series).collect())
}

/// Whether a package has reference results.
pub(crate) fn has_one(folder: &Path) -> bool {
    folder.join("extra").join(FOLDER).join("reference.toml").is_file()
}

/// Repeats the run of an FMU that has one, and compares.
pub(crate) fn replay(fmu: &Fmu) -> anyhow::Result<Replay> {
    let folder = fmu.package().folder().join("extra").join(FOLDER);
    let file = folder.join("reference.toml");
    let text =
        fs::read_to_string(&file).with_context(|| format!("{} cannot be read", file.display()))?;
    let about: About = toml::from_str(&text).context("reference.toml cannot be understood")?;
    if about.format != FORMAT {
        bail!("reference.toml has format {}; this tool reads {FORMAT}", about.format);
    }
    if !(about.tolerance.is_finite() && about.tolerance > 0.0) {
        bail!("reference.toml: tolerance {} is no positive number", about.tolerance);
    }
    let read = |name: &str| -> anyhow::Result<(Vec<f64>, Vec<Named>)> {
        let log = Log::read(&folder.join(name), &ReadOptions::default())?;
        let columns =
            log.columns().iter().map(|c| (c.name.clone(), String::new(), c.values.clone()));
        Ok((log.time().to_vec(), columns.collect()))
    };
    let (time, wanted) = read("output.csv")?;
    let (grid, inputs) = read("input.csv")?;
    if grid != time || time.len() != about.rows {
        bail!(
            "input.csv has {} rows, output.csv {}, reference.toml says {}",
            grid.len(),
            time.len(),
            about.rows
        );
    }
    let got = run(fmu, &time, &inputs)?;
    let mut outputs = Vec::new();
    for (name, _, values) in &wanted {
        let Some((_, _, own)) = got.iter().find(|(own, _, _)| own == name) else {
            bail!("output.csv has the column \"{name}\", which is no output of the FMU");
        };
        outputs.push(compare(name, &time, values, own, about.tolerance));
    }
    Ok(Replay { rows: time.len(), outputs, tolerance: about.tolerance })
}

fn compare(name: &str, time: &[f64], wanted: &[f64], got: &[f64], tolerance: f64) -> Compared {
    let ends = |values: &[f64]| {
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)))
    };
    let (low, high) = ends(wanted);
    // An output that rests is held against its size, and one that rests at 0 against 1.
    let scale = match high - low {
        range if range > 0.0 => range,
        _ if high != 0.0 => high.abs(),
        _ => 1.0,
    };
    let part = |(wanted, got): (&f64, &f64)| {
        let difference = (wanted - got).abs() / scale;
        if difference.is_nan() { f64::INFINITY } else { difference }
    };
    let worst = wanted.iter().zip(got).map(part).zip(time);
    let (difference, at) =
        worst.fold((0.0, 0.0), |worst, (d, t)| if d > worst.0 { (d, *t) } else { worst });
    let is_within = difference <= tolerance && wanted.len() == got.len();
    Compared { name: name.to_owned(), difference, at, is_within }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_parts_of_the_range() {
        let time = [0.0, 1.0, 2.0];
        let found = compare("y", &time, &[0.0, 10.0, 5.0], &[0.0, 10.0, 5.001], 1e-3);
        assert!((found.difference - 1e-4).abs() < 1e-12 && found.at == 2.0 && found.is_within);
        assert!(!compare("y", &time, &[1.0; 3], &[1.0, 1.01, 1.0], 1e-3).is_within);
        assert!(!compare("y", &time, &[0.0; 3], &[0.0, f64::NAN, 0.0], 1e-3).is_within);
        assert!(!compare("y", &time, &[0.0; 3], &[0.0; 2], 1e-3).is_within);
    }
}
