//! A frequency response as a table: written, and read from such a table or from one of another program.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use anyhow::{Context, bail, ensure};
use data::{AtomicFile, Column, Log, ReadOptions};
use identify::frequency::{self, Complex, FrequencyResponse as Response};

use crate::results::frequency_response::{Measured, Signal};

/// Standard deviation of a line where the table has none, as a part of its magnitude and of the greatest.
const OF_LINE: f64 = 1e-2;
const OF_GREATEST: f64 = 1e-3;

/// A row per line: frequency; magnitude, phase and standard deviation of each element; coherence, amplitude,
/// and what is not linear, of each output.
pub(super) fn write(measured: &Measured, path: &Path) -> anyhow::Result<()> {
    let cannot = || format!("{} cannot be written", path.display());
    let mut file = AtomicFile::create(path).with_context(cannot)?;
    {
        let mut table = csv::Writer::from_writer(&mut file);
        let mut head = vec!["frequency [Hz]".to_owned()];
        for (output, input) in elements(measured) {
            let name = format!("{}/{}", output.name, input.name);
            let unit = format!("{}/{}", output.unit(), input.unit());
            let parts = [("magnitude", unit.as_str()), ("phase", "rad"), ("deviation", &unit)];
            head.extend(parts.map(|(what, unit)| format!("{what} {name} [{unit}]")));
        }
        for output in &measured.outputs {
            let unit = output.unit();
            let parts =
                [("coherence", "1"), ("amplitude", unit), ("not linear", unit), ("noise", unit)];
            head.extend(parts.map(|(what, unit)| format!("{what} {} [{unit}]", output.name)));
        }
        table.write_record(&head).with_context(cannot)?;
        for line in &measured.response.lines {
            let mut row = vec![line.frequency];
            for o in 0..measured.outputs.len() {
                for i in 0..measured.inputs.len() {
                    let g = line.response[(o, i)];
                    row.extend([g.norm(), g.arg(), line.deviation[(o, i)]]);
                }
            }
            for o in 0..measured.outputs.len() {
                let noise = line.noise.as_ref().map_or(f64::NAN, |noise| noise[o]);
                row.extend([line.coherence[o], line.amplitude[o], line.total[o], noise]);
            }
            let cells = row.iter().map(|x| if x.is_nan() { String::new() } else { x.to_string() });
            table.write_record(cells).with_context(cannot)?;
        }
        table.flush().with_context(cannot)?;
    }
    file.commit().with_context(cannot)
}

/// Output and input of each element of the response, row by row.
fn elements(measured: &Measured) -> impl Iterator<Item = (&Signal, &Signal)> {
    let inputs = &measured.inputs;
    measured.outputs.iter().flat_map(move |output| inputs.iter().map(move |input| (output, input)))
}

/// A response that was read.
pub(crate) struct Table {
    pub(crate) response: Response,
    /// What was assumed, in sentences.
    pub(crate) notes: Vec<String>,
}

/// How the columns of an element name its magnitude and phase, or its parts.
const MAGNITUDES: [&str; 6] = ["magnitude", "mag", "gain", "amplitude", "abs", "modulus"];
const PHASES: [&str; 4] = ["phase", "angle", "arg", "ph"];
const REAL: [&str; 2] = ["real", "re"];
const IMAGINARY: [&str; 3] = ["imag", "imaginary", "im"];
const FREQUENCIES: [&str; 5] = ["frequency", "freq", "f", "omega", "w"];

/// Reads the response of these outputs to these inputs, in their units, for commands that are held for `period` in s.
///
/// A table of `frequency-response -o` names each element OUTPUT/INPUT and is one of held commands. Any other table has
/// one element and is one of the machine itself, G(jω): held commands see
/// G(jω)·(1 − exp(−jωT))/(jωT).
///
/// # Errors
/// The file cannot be read, or has no such columns; the message says which are missing.
pub(crate) fn read(
    path: &Path,
    (inputs, outputs): (&[Signal], &[Signal]),
    period: f64,
) -> anyhow::Result<Table> {
    let file = path.display();
    // Rows of frequencies: no column is one of times. Decibels are no unit of a log.
    let mut options = ReadOptions { rate: Some(1.0), ..ReadOptions::default() };
    let mut log = Log::read(path, &options)?;
    let is_decibel = |why: &str| why.contains("\"dB\"");
    let decibels: Vec<String> = log
        .left_out()
        .iter()
        .filter(|left| is_decibel(&left.why))
        .map(|left| left.name.clone())
        .collect();
    if !decibels.is_empty() {
        options.units = decibels.iter().map(|name| (name.clone(), "1".to_owned())).collect();
        log = Log::read(path, &options)?;
    }
    let mut notes = log.notes();
    let all = frequencies(&log, path)?;
    let find = |what: &[&str], element: &str| column(&log, what, element);
    let pairs = outputs.iter().flat_map(|o| inputs.iter().map(move |i| (o, i)));
    let is_own =
        pairs.clone().all(|(o, i)| find(&MAGNITUDES, &format!("{}/{}", o.name, i.name)).is_some());
    ensure!(
        is_own || (inputs.len() == 1 && outputs.len() == 1),
        "{file}: a response of several axes needs columns \"magnitude OUTPUT/INPUT\" and \"phase OUTPUT/INPUT\" for each \
         output and input, as frequency-response -o writes them; the columns are {}",
        names(&log)
    );
    let mut elements = Vec::new();
    for (output, input) in pairs {
        let name = if is_own { format!("{}/{}", output.name, input.name) } else { String::new() };
        let unit = format!("{}/{}", output.unit(), input.unit());
        let values = element(&log, (path, &decibels), &name, &unit, &mut notes)?;
        let deviation = match find(&["deviation", "std"], &name) {
            Some(column) => Some(converted(&log, column, &unit)?),
            None => None,
        };
        elements.push((values, deviation));
    }
    if elements.iter().any(|(_, deviation)| deviation.is_none()) {
        notes.push(format!(
            "{file}: no column \"deviation\": a line counts as known to {} % of its magnitude and {} % of the greatest",
            100.0 * OF_LINE,
            100.0 * OF_GREATEST
        ));
    }
    notes.push(match is_own {
        true => format!("{file}: taken as a response to held commands, one sample each"),
        false => format!(
            "{file}: taken as the response of the machine itself; commands are held for {period} s between the rows of the logs"
        ),
    });
    let greatest = elements.iter().flat_map(|(g, _)| g).map(|g| g.norm()).fold(0.0, f64::max);
    let mut lines = Vec::new();
    let (mut above, mut broken) = (0, 0);
    for (row, frequency) in all.into_iter().enumerate() {
        let held = match is_own {
            true => Complex::new(1.0, 0.0),
            false => frequency::hold(frequency, period),
        };
        let of = |k: usize| elements[k].0[row] * held;
        let deviation = |k: usize| match &elements[k].1 {
            Some(known) => known[row],
            None => OF_LINE * of(k).norm() + OF_GREATEST * greatest,
        };
        let response: Vec<Complex> = (0..elements.len()).map(of).collect();
        let deviation: Vec<f64> = (0..elements.len()).map(deviation).collect();
        let is_finite = response.iter().all(|g| g.re.is_finite() && g.im.is_finite())
            && deviation.iter().all(|d| d.is_finite() && *d >= 0.0);
        if !(is_finite && frequency.is_finite() && frequency > 0.0) {
            broken += 1;
            continue;
        }
        if frequency * period >= 0.5 {
            above += 1;
            continue;
        }
        lines.push((frequency, response, deviation));
    }
    if above > 0 {
        notes.push(format!(
            "{file}: {above} lines at half the logs' sample rate of {} Hz or above are left out",
            1.0 / period
        ));
    }
    if broken > 0 {
        notes.push(format!(
            "{file}: {broken} lines without a frequency above 0 or without numbers are left out"
        ));
    }
    lines.sort_by(|a, b| a.0.total_cmp(&b.0));
    ensure!(
        lines.len() >= LEAST_LINES,
        "{file}: has {} lines that can be used; a fit needs at least {LEAST_LINES}",
        lines.len()
    );
    let response = Response::given((outputs.len(), inputs.len()), lines, period);
    Ok(Table { response, notes })
}

/// Fewest lines that a fit is made of.
const LEAST_LINES: usize = 8;

fn names(log: &Log) -> String {
    log.columns().iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// The column of one of these quantities, of this element where it is named: `magnitude y/u`, `G.real`.
fn column<'a>(log: &'a Log, what: &[&str], element: &str) -> Option<&'a Column> {
    let is = |column: &&Column| {
        let name = column.name.trim();
        match element {
            "" => {
                let lower = name.to_lowercase();
                let words = lower.split(|c: char| !c.is_alphanumeric());
                words.into_iter().any(|word| what.contains(&word))
            }
            element => name
                .strip_suffix(element)
                .is_some_and(|start| what.contains(&start.trim().to_lowercase().as_str())),
        }
    };
    log.columns().iter().find(is)
}

fn unit_of(column: &Column) -> Option<&str> {
    column.unit.as_ref().map(|unit| unit.text.as_str())
}

/// The values of a column in this unit; one that says none has it.
fn converted(log: &Log, column: &Column, unit: &str) -> anyhow::Result<Vec<f64>> {
    // Where a log says no unit, its response has 1 in the place.
    let is_stated = |own: &str| own != "1" && !own.starts_with("1/") && !own.ends_with("/1");
    match unit_of(column).filter(|own| is_stated(own)) {
        Some(own) if own != unit => Ok(log.convert(&column.name, unit)?),
        _ => Ok(column.values.clone()),
    }
}

/// The frequencies in Hz.
fn frequencies(log: &Log, path: &Path) -> anyhow::Result<Vec<f64>> {
    let is_frequency = |column: &&Column| matches!(unit_of(column), Some("Hz" | "kHz" | "rad/s"));
    let found = column(log, &FREQUENCIES, "").or_else(|| log.columns().iter().find(is_frequency));
    let Some(found) = found else {
        bail!(
            "{}: has no column of frequencies; name it frequency, with its unit as in \"frequency [Hz]\"; the columns are {}",
            path.display(),
            names(log)
        );
    };
    let is_angular = ["omega", "w"].contains(&found.name.trim().to_lowercase().as_str());
    let factor = match unit_of(found) {
        Some("rad/s") => 1.0 / TAU,
        None | Some("1") if is_angular => 1.0 / TAU,
        None | Some("1") => 1.0,
        Some(_) => return Ok(log.convert(&found.name, "Hz")?),
    };
    Ok(found.values.iter().map(|f| f * factor).collect())
}

/// An element of the response, line by line.
fn element(
    log: &Log,
    (path, decibels): (&Path, &[String]),
    name: &str,
    unit: &str,
    notes: &mut Vec<String>,
) -> anyhow::Result<Vec<Complex>> {
    let find = |what: &[&str]| column(log, what, name);
    if let (Some(real), Some(imag)) = (find(&REAL), find(&IMAGINARY)) {
        let parts = converted(log, real, unit)?.into_iter().zip(converted(log, imag, unit)?);
        return Ok(parts.map(|(re, im)| Complex::new(re, im)).collect());
    }
    let (Some(magnitude), Some(phase)) = (find(&MAGNITUDES), find(&PHASES)) else {
        bail!(
            "{}: has neither columns of magnitude and phase nor of real and imaginary part{}; the columns are {}",
            path.display(),
            if name.is_empty() { String::new() } else { format!(" of {name}") },
            names(log)
        );
    };
    let is_decibel =
        decibels.contains(&magnitude.name) || magnitude.name.to_lowercase().ends_with("db");
    let size: Vec<f64> = match is_decibel {
        true => {
            notes.push(format!("{}: 0 dB is taken as 1 {unit}", magnitude.name));
            magnitude.values.iter().map(|db| 10_f64.powf(db / 20.0)).collect()
        }
        false => converted(log, magnitude, unit)?,
    };
    let lower = phase.name.to_lowercase();
    let is_degrees = match unit_of(phase) {
        Some(unit) => matches!(unit, "deg" | "°" | "degree" | "degrees"),
        None if lower.contains("deg") => true,
        None if lower.contains("rad") => false,
        // More than two turns in radians are rarer than a quarter in degrees.
        None => {
            let is_degrees = phase.values.iter().any(|p| p.abs() > 4.0 * PI);
            notes.push(format!(
                "{} has no unit, taken as {}",
                phase.name,
                if is_degrees { "degrees" } else { "rad" }
            ));
            is_degrees
        }
    };
    let factor = if is_degrees { PI / 180.0 } else { 1.0 };
    let pairs = size.into_iter().zip(&phase.values);
    Ok(pairs.map(|(size, phase)| Complex::from_polar(size, phase * factor)).collect())
}
