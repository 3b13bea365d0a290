//! A black box as a task: which input drives which output, which parameters may be off.

use std::collections::BTreeMap;
use std::path::Path;

use cosim::{Fmu, Worker};
use model::{Unit, UnitError};
use modeldescription::variable::{Causality, DataType, Number, Variable};
use surround::Span;

use crate::base::{Base, BaseParameter, Part, tolerance};
use crate::black_box::{BlackBox, Entry, Own, Times, inner_step};
use crate::chain::{ComponentNode, Node};
use crate::data_set::RecordData;
use crate::error::Error;
use crate::formula::Slot;
use crate::port::{Port, check_names, choose};
use crate::request::Request;
use crate::task::{Task, assemble, check_rows};
use crate::thresholds::base::Thresholds;

/// Opens an FMU, to run in this process or in others.
pub(crate) fn open(path: &Path, worker: Option<&Worker>) -> Result<Fmu, Error> {
    Ok(match worker {
        Some(worker) => Fmu::open_isolated(path, worker)?,
        None => Fmu::open(path)?,
    })
}

/// All tasks of a black box.
pub(crate) fn tasks(request: &Request, path: &Path) -> Result<Vec<Task>, Error> {
    let fmu = open(path, request.worker.as_ref())?;
    let description = fmu.description();
    let model = description.model_name.clone();
    let ports = |causality: Causality| -> Vec<Port> {
        numbers(&fmu, causality).iter().map(|v| port(v, &fmu)).collect()
    };
    let (inputs, outputs) = (ports(Causality::Input), ports(Causality::Output));
    if inputs.is_empty() {
        let message = "has no real input that a log could drive".to_owned();
        return Err(Error::Model { model, message });
    }
    let first = &request.logs[0];
    let fed: Vec<usize> =
        (0..inputs.len()).filter(|k| inputs[*k].column(&request.names, first).is_some()).collect();
    let Some(&main) = fed.first() else {
        let names: Vec<&str> = inputs.iter().map(Port::label).collect();
        return Err(Error::Log {
            log: first.origin().to_owned(),
            message: format!(
                "no column is an input of {model}; inputs are {}: name one with --map {}=COLUMN",
                names.join(", "),
                names[0]
            ),
        });
    };
    let mut unknown = check_names(request, &model, &inputs, &outputs)?;
    let chosen = choose(request, &model, &outputs)?;
    let mut all: Vec<Task> = Vec::new();
    for output in chosen {
        // As many inputs as outputs: a machine of axes, each with its own input.
        let input = if fed.len() == outputs.len() { fed[output] } else { main };
        all.push(task(request, path, &inputs, &outputs, input, output)?);
    }
    if let Some(first) = all.first_mut() {
        first.warnings.append(&mut unknown);
    }
    Ok(all)
}

fn task(
    request: &Request,
    path: &Path,
    inputs: &[Port],
    outputs: &[Port],
    input: usize,
    output: usize,
) -> Result<Task, Error> {
    let fmu = open(path, request.worker.as_ref())?;
    let possible = tuned(request, &fmu);
    let mut names = vec![inputs[input].name.clone()];
    names.extend(
        inputs.iter().enumerate().filter(|(k, _)| *k != input).map(|(_, p)| p.name.clone()),
    );
    let slots = BTreeMap::from([
        (Slot::Command, 0),
        (Slot::Amplifier, 0),
        (Slot::BeforeActuator, 0),
        (Slot::AfterActuator, 1),
        (Slot::BeforeMechanics, 1),
        (Slot::AfterMechanics, 1),
        (Slot::Reading, 1),
    ]);
    let base = Base { slots, ..Base::empty(Part::Axis, request.gain_tolerance) };
    let mut task = assemble(request, inputs, outputs, input, output, base, None)?;
    let times: Times = task.data.times().collect();
    if let Some(step) = inner_step(fmu.description()) {
        for record in &task.data.records {
            check_rows(&record.name, &times[&record.rows.start], step)?;
        }
    }
    let units = (inputs[input].si, outputs[output].si);
    let mut node = BlackBox::new(fmu, names, outputs[output].name.clone(), units, times);
    // Said once, in full, before a failure only means a bad candidate.
    let mut out = vec![0.0; task.data.command.len()];
    for record in &task.data.records {
        let range = record.hits.clone();
        let x = &task.data.command[range.clone()];
        node.try_run(&[], record, x, &mut out[range])?;
    }
    let longest = task.data.records.iter().max_by_key(|r| r.rows.len());
    let command = task.data.command_span;
    let own = |p: &BaseParameter| Own { name: p.name.clone(), start: p.value, value: p.value };
    node.parameters = possible.iter().map(own).collect();
    let mut tuned = longest.map_or_else(Vec::new, |record| heard(possible, &node, record, command));
    for (k, p) in tuned.iter_mut().enumerate() {
        p.indices = vec![(k, p.deviation)];
    }
    node.parameters = tuned.iter().map(own).collect();
    task.base.parameters.clone_from(&tuned);
    let modes: Option<(Entry, _)> = longest.and_then(|record| {
        let mode = node.entry(record, command)?;
        let moved = tuned.iter().enumerate().map(|(k, p)| {
            let with = node.with(k, p.deviation).entry(record, command)?;
            Some((with.frequency - mode.frequency, with.damping - mode.damping))
        });
        Some((mode, moved.map(Option::unwrap_or_default).collect()))
    });
    task.base.memory = longest.and_then(|record| {
        let first = task.data.command[record.hits.start];
        node.memory(record, command, first, modes.as_ref().map(|(entry, _)| *entry))
    });
    task.base.nodes.push(Node::BlackBox(node));
    if let Some((mode, moved)) = modes {
        open_up(&mut task.base, (mode.frequency, mode.damping), moved);
    }
    Ok(task)
}

/// Takes the mode, frequency and damping, out behind the FMU and puts it in again, so that effects can
/// act on what enters it. `moved` is what each of the FMU's parameters does to it at one deviation.
fn open_up(base: &mut Base, (frequency, damping): (f64, f64), moved: Vec<(f64, f64)>) {
    let mode = ComponentNode::mode(frequency, damping);
    let before = base.nodes.len();
    let again = before + 1;
    base.nodes.extend([Node::BeforeMode(mode.clone()), Node::Component(mode)]);
    base.mode = Some(again);
    for (p, (by_frequency, by_damping)) in base.parameters.iter_mut().zip(moved) {
        // What it does says more than its name.
        let share = |by: f64, of: f64| {
            (by / of).abs() > Thresholds::MOVES_MODE * (p.deviation / p.value).abs()
        };
        p.effect = match (share(by_frequency, frequency), share(by_damping, damping)) {
            (true, _) => Some("resonance_shift"),
            (false, true) => Some("damping"),
            (false, false) => p.effect,
        };
        p.also = [before, again]
            .into_iter()
            .flat_map(|node| [(node, 0, by_frequency), (node, 1, by_damping)])
            .collect();
    }
    for slot in [Slot::AfterActuator, Slot::BeforeMechanics] {
        base.slots.insert(slot, again);
    }
    for slot in [Slot::AfterMechanics, Slot::Reading] {
        base.slots.insert(slot, again + 1);
    }
}

/// The real numbers of one causality, an array by its elements.
fn numbers(fmu: &Fmu, causality: Causality) -> Vec<Variable> {
    let names = fmu.names(causality);
    let all = names.iter().filter_map(|name| fmu.variable(name).ok());
    all.filter(|v| matches!(v.data_type, DataType::Float64 | DataType::Float32)).collect()
}

fn port(variable: &Variable, fmu: &Fmu) -> Port {
    let properties = fmu.description().properties(variable);
    let text = properties.unit.unwrap_or_default();
    let si = parse(&text).unwrap_or(Unit::ONE);
    let bound = |b: Option<Number>, none: f64| b.map_or(none, Number::as_f64);
    Port {
        name: variable.name.clone(),
        alias: None,
        unit: text,
        si,
        range: (bound(properties.min, f64::NEG_INFINITY), bound(properties.max, f64::INFINITY)),
    }
}

fn parse(text: &str) -> Result<Unit, UnitError> {
    Unit::parse(if text.is_empty() { "1" } else { text })
}

/// Parameters that the request says may be off, and those that an effect may stand for: these move only where it does.
fn tuned(request: &Request, fmu: &Fmu) -> Vec<BaseParameter> {
    let mut all: Vec<BaseParameter> = Vec::new();
    for v in &numbers(fmu, Causality::Parameter) {
        let Some(value) = start_of(v) else { continue };
        let (deviation, has_tolerance) = tolerance(&v.name, value, None, &request.tolerances);
        let unit = fmu.description().properties(v).unit.unwrap_or_else(|| "1".to_owned());
        let effect = effect_of(&v.name, &unit);
        let alike = all.iter().filter(|p| !p.has_tolerance && p.effect == effect).count();
        let is_free = effect.is_some() && deviation > 0.0 && alike < Thresholds::MOST_OF_ARRAY;
        if !has_tolerance && !is_free {
            continue;
        }
        all.push(BaseParameter {
            name: v.name.clone(),
            unit,
            node: 0,
            indices: Vec::new(),
            also: Vec::new(),
            value,
            deviation,
            has_tolerance,
            effect,
        });
    }
    all
}

/// Those that somebody asked for, and those that the output hears: its answer to a small step changes with them, and the
/// FMU bears it.
fn heard(
    possible: Vec<BaseParameter>,
    node: &BlackBox,
    record: &RecordData,
    command: Span,
) -> Vec<BaseParameter> {
    if possible.iter().all(|p| p.has_tolerance) {
        return possible;
    }
    let still = node.step_answer(record, command);
    let is_heard = |k: usize, p: &BaseParameter| {
        let moved = node.with(k, p.deviation).step_answer(record, command);
        moved.is_some() && moved != still
    };
    let all = possible.into_iter().enumerate();
    all.filter(|(k, p)| p.has_tolerance || is_heard(*k, p)).map(|(_, p)| p).collect()
}

/// What a parameter with this name belongs to: the frequency or the damping of a mode.
fn effect_of(name: &str, unit: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    let has = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
    // The frequency of a filter, of the mains or of the samples is none.
    let is_other = has(&["cut", "corner", "band", "sampl", "mains", "grid"]);
    if has(&["freq", "resonan"]) && !is_other && !matches!(unit, "s" | "1") {
        Some("resonance_shift")
    } else if has(&["damp", "zeta"]) {
        Some("damping")
    } else {
        None
    }
}

fn start_of(variable: &Variable) -> Option<f64> {
    variable.start.as_ref()?.numbers()?.first().map(|n| n.as_f64())
}
