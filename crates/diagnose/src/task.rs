//! From a request to one task per output: data in SI, model as a chain, noise.

mod auxiliaries;
mod noise_floor;

use std::sync::Arc;

use components::effects::SENSOR_QUANTISATION;
use data::{CheckedBlueprint, Log, NameMap, inner_steps};
use model::{Causality, Unit};

use self::auxiliaries::auxiliaries;
use self::noise_floor::floor;
use crate::base::{Base, Part};
use crate::between::Course;
use crate::coupled::{self, Coupled};
use crate::data_set::{DataSet, RecordRows};
use crate::error::Error;
use crate::gap::NoiseFloor;
use crate::request::{Model, Noise, Request};
use crate::steps::Steps;
use crate::tap;
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

/// An input or output of the model.
#[derive(Clone, Debug)]
pub(crate) struct Port {
    pub(crate) name: String,
    pub(crate) alias: Option<String>,
    pub(crate) unit: String,
    pub(crate) si: Unit,
    pub(crate) range: (f64, f64),
}

impl Port {
    /// Name in reports.
    pub(crate) fn label(&self) -> &str {
        self.alias.as_deref().unwrap_or(&self.name)
    }

    /// Whether a user may call it so.
    pub(crate) fn is(&self, name: &str) -> bool {
        self.name == name || self.alias.as_deref() == Some(name)
    }

    /// The port's column in a log.
    pub(crate) fn column<'a>(&'a self, names: &'a NameMap, log: &Log) -> Option<&'a str> {
        let alias = self.alias.as_deref();
        let mapped = names.column(&self.name).or_else(|| names.column(alias?));
        if let Some(column) = mapped {
            return log.column(column).map(|_| column);
        }
        [Some(self.name.as_str()), alias]
            .into_iter()
            .flatten()
            .find(|name| log.column(name).is_some())
    }
}

/// All tasks of a request.
pub(crate) fn tasks(request: &Request) -> Result<Vec<Task>, Error> {
    check(request)?;
    match &request.model {
        Model::Blueprint(blueprint) => white(request, blueprint),
        Model::Fmu(path) => crate::fmu::tasks(request, path),
    }
}

fn check(request: &Request) -> Result<(), Error> {
    let option = |option, value: String, message: &str| {
        Err(Error::Option { option, value, message: message.to_owned() })
    };
    if request.logs.is_empty() {
        return option("--log", String::new(), "give at least one measured log");
    }
    if !(request.gain_tolerance.is_finite() && request.gain_tolerance > 0.0) {
        let value = request.gain_tolerance.to_string();
        return option("--gain-tolerance", value, "must be above zero, as in 0.01");
    }
    if !(request.accuracy.is_finite() && (0.0..1.0).contains(&request.accuracy)) {
        let value = request.accuracy.to_string();
        return option("--accuracy", value, "must be a part of the range from 0 to 1, as in 0.01");
    }
    for name in &request.without {
        if components::effects::find(name).is_none() {
            let known: Vec<&str> = components::effects::EFFECTS.iter().map(|e| e.name).collect();
            let near = data::nearest(name, known.iter().copied())
                .map_or_else(String::new, |n| format!("did you mean {n}? "));
            let message = format!("is no effect; {near}effects are {}", known.join(", "));
            return option("--without", name.clone(), &message);
        }
    }
    if let Noise::Given(all) = &request.noise {
        for (_, sigma) in all {
            if !(sigma.is_finite() && *sigma > 0.0) {
                return option("--noise", sigma.to_string(), "a standard deviation is above zero");
            }
        }
    }
    Ok(())
}

fn white(request: &Request, blueprint: &CheckedBlueprint) -> Result<Vec<Task>, Error> {
    let system = blueprint.system();
    let port = |name: String| {
        let reference = system.variables().find(&name)?;
        let v = system.variables().get(reference)?;
        Some(Port {
            name,
            alias: v.alias.clone(),
            unit: v.unit.clone(),
            si: v.si,
            range: (v.min, v.max),
        })
    };
    let model = &blueprint.spec().name;
    if system.variables().with(Causality::Input).any(|(_, v)| v.name.starts_with("reference")) {
        let message = "is a controller; give the plant's blueprint".to_owned();
        return Err(Error::Model { model: model.clone(), message });
    }
    let axes = 1..=blueprint.spec().axes.len();
    let inputs: Vec<Port> = axes.clone().filter_map(|k| port(format!("command[{k}]"))).collect();
    let outputs: Vec<Port> = axes.filter_map(|k| port(format!("position[{k}]"))).collect();
    let mut unknown = check_names(request, model, &inputs, &outputs)?;
    let chosen = choose(request, model, &outputs)?;
    let step = Some(blueprint.spec().period);
    let tuned = (&request.tolerances[..], request.gain_tolerance);
    let mut all = coupled::tasks(request, blueprint, (&inputs, &outputs), &chosen)?;
    let is_coupled = |index: &usize| all.iter().any(|p: &Task| p.axis == index + 1);
    let apart: Vec<usize> = chosen.into_iter().filter(|index| !is_coupled(index)).collect();
    for index in apart {
        let base = Base::white(blueprint, (index + 1, Part::Axis), tuned.0, tuned.1)?;
        match tap::monitor(request, &inputs[index]) {
            Some(monitor) if base.joint().is_none() => {
                let ports = (&inputs[..], &outputs[..]);
                all.extend(tap::cut(request, ports, index, &base, step, &monitor)?);
            }
            monitor => {
                let mut task = assemble(request, &inputs, &outputs, index, index, base, step)?;
                task.warnings.extend(monitor.map(|m| coupled::not_cut(&m)));
                all.push(task);
            }
        }
    }
    if let Some(first) = all.first_mut() {
        first.warnings.append(&mut unknown);
    }
    Ok(all)
}

/// Names of `--noise` and `--map` against the model's: one of the first that is unknown is an error, of the second a
/// warning, as one list of pairs may serve several models.
pub(crate) fn check_names(
    request: &Request,
    model: &str,
    inputs: &[Port],
    outputs: &[Port],
) -> Result<Vec<String>, Error> {
    let near = |name: &str, ports: &[&Port]| {
        let names = ports.iter().flat_map(|p| [Some(p.name.as_str()), p.alias.as_deref()]);
        data::nearest(name, names.flatten())
            .map_or_else(String::new, |near| format!("did you mean {near}? "))
    };
    let labels = |ports: &[&Port]| ports.iter().map(|p| p.label()).collect::<Vec<_>>().join(", ");
    if let Noise::Given(all) = &request.noise {
        let known: Vec<&Port> = outputs.iter().collect();
        for name in all.iter().filter_map(|(name, _)| name.as_deref()) {
            // The column of a monitor is an output, too.
            let is_column = request.logs.iter().any(|log| log.column(name).is_some());
            if !is_column && !outputs.iter().any(|port| port.is(name)) {
                return Err(Error::Option {
                    option: "--noise",
                    value: name.to_owned(),
                    message: format!(
                        "is no output of {model}; {}its outputs are {}",
                        near(name, &known),
                        labels(&known)
                    ),
                });
            }
        }
    }
    let known: Vec<&Port> = inputs.iter().chain(outputs).collect();
    let pairs = request.names.iter();
    let unknown =
        pairs.filter(|(name, _)| *name != "time" && !known.iter().any(|port| port.is(name)));
    Ok(unknown
        .map(|(name, column)| {
            format!(
                "--map {name}={column} has no effect: {name} is neither an input nor an output of {model}; {}they are {}",
                near(name, &known),
                labels(&known)
            )
        })
        .collect())
}

/// Numbers of the outputs that are looked at.
pub(crate) fn choose(
    request: &Request,
    model: &str,
    outputs: &[Port],
) -> Result<Vec<usize>, Error> {
    let labels = || outputs.iter().map(Port::label).collect::<Vec<_>>().join(", ");
    for asked in &request.outputs {
        if !outputs.iter().any(|port| port.is(asked)) {
            return Err(Error::Option {
                option: "--outputs",
                value: asked.clone(),
                message: format!("is no output of {model}; its outputs are {}", labels()),
            });
        }
    }
    let is_asked = |port: &Port| {
        request.outputs.is_empty() || request.outputs.iter().any(|asked| port.is(asked))
    };
    let logs = || request.logs.iter().chain(&request.holdout);
    let chosen: Vec<usize> = (0..outputs.len())
        .filter(|k| is_asked(&outputs[*k]))
        .filter(|k| logs().all(|log| outputs[*k].column(&request.names, log).is_some()))
        .collect();
    if chosen.is_empty() {
        let log = &request.logs[0];
        let columns: Vec<&str> = log.columns().iter().map(|c| c.name.as_str()).collect();
        return Err(Error::Log {
            log: log.origin().to_owned(),
            message: format!(
                "no column is an output of {model}; outputs are {}, columns are {}: name one with --map {}=COLUMN",
                labels(),
                columns.join(", "),
                outputs.first().map_or("position[1]", Port::label)
            ),
        });
    }
    Ok(chosen)
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
            if rows.len() - run_in < 60 {
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
        return Err(Error::Log { log, message: "has no record of 60 rows or more".into() });
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

pub(crate) fn unit_text(port: &Port) -> &str {
    if port.unit.is_empty() { "1" } else { &port.unit }
}

/// The values of a port in a log, in the port's unit.
pub(crate) fn column(
    request: &Request,
    port: &Port,
    log: &Log,
    role: &str,
) -> Result<Vec<f64>, Error> {
    let Some(name) = port.column(&request.names, log) else {
        let there: Vec<&str> = log.columns().iter().map(|c| c.name.as_str()).collect();
        return Err(Error::Log {
            log: log.origin().to_owned(),
            message: format!(
                "has no column for the {role} {}; columns are {}: name one with --map {}=COLUMN",
                port.name,
                there.join(", "),
                port.label()
            ),
        });
    };
    Ok(log.convert(name, unit_text(port))?)
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
