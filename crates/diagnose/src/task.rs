//! One output, ready to be diagnosed: data in SI, model as a chain, noise.

mod auxiliaries;
mod noise_floor;

use std::sync::Arc;

use components::effects::SENSOR_QUANTISATION;
use data::{Log, inner_steps};
use model::Unit;

use self::auxiliaries::auxiliaries;
use self::noise_floor::floor;
use crate::axis_group::Group;
use crate::base::Base;
use crate::between::Course;
use crate::data_set::{DataSet, RecordRows};
use crate::error::Error;
use crate::gap::NoiseFloor;
use crate::port::{Port, column, unit_text};
use crate::request::Request;
use crate::steps::Steps;
use crate::thresholds::base::Thresholds;

/// One output, ready to be diagnosed.
#[derive(Clone)]
pub(crate) struct Task {
    /// Name in reports: the short name where there is one.
    pub(crate) output: String,
    /// Unit of the output.
    pub(crate) unit: String,
    /// SI per unit.
    pub(crate) factor: f64,
    /// Number of the axis, from 1.
    pub(crate) axis: usize,
    /// Name of the driven input.
    pub(crate) input: String,
    pub(crate) command_unit: String,
    pub(crate) command_factor: f64,
    pub(crate) base: Base,
    pub(crate) data: DataSet,
    pub(crate) noise: NoiseFloor,
    /// Corner of the noise in Hz, where a record at rest tells.
    pub(crate) rest_corner: Option<f64>,
    /// Steps in which the reading moves, where its values show them.
    pub(crate) steps: Option<Steps>,
    /// Least and greatest command that may be played, in its unit.
    pub(crate) command_range: (f64, f64),
    pub(crate) warnings: Vec<String>,
    /// How the logs are read.
    pub(crate) course: Course,
    /// Most effects that are looked for.
    pub(crate) max_effects: usize,
    /// Whether how the logs are read is known: no effect is named then that imitates another, and not several in a faint gap.
    /// Before, such names point to a wrong reading.
    pub(crate) reading_is_known: bool,
    /// The axes with which it is coupled, where it is a motion.
    pub(crate) coupled: Option<Arc<Coupled>>,
}

/// A group of axes that static couplings join, all of which are looked at.
pub(crate) struct Coupled {
    pub(crate) group: Group,
    /// The reading of each axis as a function of its position, which is put in place of the command.
    pub(crate) readings: Vec<Task>,
}

/// Puts one task together: output number `output` as a function of input number `input`.
pub(crate) fn assemble(
    request: &Request,
    inputs: &[Port],
    outputs: &[Port],
    input: usize,
    output: usize,
    base: Base,
    step: Option<f64>,
) -> Result<Task, Error> {
    let (u, y) = (&inputs[input], &outputs[output]);
    let aux = auxiliaries(request, inputs, outputs, input);
    let names: Vec<(String, bool)> = aux.iter().map(|a| (a.column.clone(), a.is_command)).collect();
    let course = request.first_course();
    let mut records = Vec::new();
    let mut warnings = Vec::new();
    let logs = request.logs.iter().map(|log| (log, false));
    let judged = request.holdout.iter().map(|log| (log, true));
    let training = if request.holdout.is_empty() { 1.0 - Thresholds::HELD_OUT } else { 1.0 };
    for (log, is_judged) in logs.chain(judged) {
        warnings.extend(log.notes());
        // One command of several that a coupling joins.
        let absent = |port: &&Port| port.column(&request.names, log).is_none();
        let others = inputs.iter().filter(|_| base.joint().is_some());
        warnings.extend(others.filter(absent).map(|port| {
            format!(
                "{}: has no column for {}, which is taken to rest at 0",
                log.origin(),
                port.label()
            )
        }));
        let training = if is_judged { 0.0 } else { training };
        let command = column(request, u, log, "input")?;
        let measured = column(request, y, log, "output")?;
        let aux: Vec<Vec<f64>> = aux.iter().map(|a| a.values(log)).collect::<Result<_, _>>()?;
        let others: Vec<Vec<f64>> = inputs
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != input && base.has_other_inputs())
            .map(|(_, port)| match port.column(&request.names, log) {
                Some(name) => {
                    let values = log.convert(name, unit_text(port))?;
                    let is_si = base.is_white;
                    let si = |v: &f64| if is_si { port.si.to_si(*v) } else { *v };
                    Ok(values.iter().map(si).collect())
                }
                None => Ok(vec![0.0; log.len()]),
            })
            .collect::<Result<_, Error>>()?;
        for record in log.records() {
            let rows = record.rows.clone();
            let start = log.time()[rows.start];
            // A row that lies on the border up to rounding stays.
            let drop = request.drop.unwrap_or(0.0) * (1.0 - 1e-9);
            let is_run_in = |t: &&f64| *t - start < drop;
            let run_in = log.time()[rows.clone()].iter().take_while(is_run_in).count();
            if rows.len() - run_in < Thresholds::RECORD_ROWS {
                warnings.push(format!(
                    "{}, record {}: {}{} are too few to judge anything; it was left out",
                    log.origin(),
                    record.id,
                    data::counted(rows.len() - run_in, "row"),
                    if run_in > 0 { " after the run-in" } else { "" }
                ));
                continue;
            }
            let part = |v: &[f64]| v[rows.clone()].to_vec();
            let si = |unit: &Unit, v: &[f64]| part(v).iter().map(|x| unit.to_si(*x)).collect();
            let many = log.records().len() > 1;
            let name = if many { format!("{} #{}", file(log), record.id) } else { file(log) };
            records.push(RecordRows {
                name,
                time: log.time()[rows.clone()].to_vec(),
                command: si(&u.si, &command),
                y: si(&y.si, &measured),
                aux: aux.iter().map(|a| part(a)).collect(),
                others: others.iter().map(|o| part(o)).collect(),
                run_in,
                training,
            });
        }
    }
    if records.iter().all(|r| r.training == 0.0) {
        let log = request.logs.first().map_or("the logs", |log| log.origin()).to_owned();
        let message = format!("has no record of {} rows or more", Thresholds::RECORD_ROWS);
        return Err(Error::Log { log, message });
    }
    if let Some(step) = step {
        check_steps(&records, step)?;
    }
    let data = DataSet::new(records, &names, step).played(course);
    let is_asked = !request.without.iter().any(|name| name == SENSOR_QUANTISATION.name);
    let steps = Steps::of(&data).filter(|_| is_asked);
    let (noise, rest_corner, steps) = floor(request, y, &data, steps)?;
    Ok(Task {
        output: y.label().to_owned(),
        unit: unit_text(y).to_owned(),
        factor: y.si.factor,
        axis: output + 1,
        input: u.label().to_owned(),
        command_unit: unit_text(u).to_owned(),
        command_factor: u.si.factor,
        base,
        data,
        noise,
        rest_corner,
        steps,
        command_range: u.range,
        warnings,
        course,
        max_effects: request.max_effects,
        reading_is_known: false,
        coupled: None,
    })
}

fn file(log: &Log) -> String {
    let path = std::path::Path::new(log.origin());
    path.file_name().map_or_else(|| log.origin().to_owned(), |n| n.to_string_lossy().into_owned())
}

pub(crate) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len()).max(1) as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        ab += (a - ma) * (b - mb);
        aa += (a - ma).powi(2);
        bb += (b - mb).powi(2);
    }
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

/// Whether the rows of a record are as far apart as seconds can be.
pub(crate) fn check_rows(record: &str, time: &[f64], step: f64) -> Result<(), Error> {
    inner_steps::check_rows(time, step)
        .map_err(|message| Error::Log { log: record.to_owned(), message })
}

/// Whether the rows are as far apart as seconds can be, and few enough for the grid of the model.
fn check_steps(records: &[RecordRows], step: f64) -> Result<(), Error> {
    for record in records {
        check_rows(&record.name, &record.time, step)?;
    }
    let length = |r: &RecordRows| r.time.last().zip(r.time.first()).map_or(0.0, |(b, a)| b - a);
    let steps = records.iter().map(length).sum::<f64>() / step;
    let most = Thresholds::MOST_STEPS * inner_steps::allowed() as f64;
    if steps > most {
        let log = records.first().map_or_else(String::new, |record| record.name.clone());
        let message = format!(
            "the logs are {steps:.1e} inner steps of {step} s long; at most {most:.1e} are looked at: give shorter \
             logs or a model with a longer step, or allow more with --most-steps N (now {}, a two-hundredth)",
            inner_steps::allowed()
        );
        return Err(Error::Log { log, message });
    }
    Ok(())
}
