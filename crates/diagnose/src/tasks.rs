//! From a request to its tasks, one per output.

mod motions;

use data::CheckedBlueprint;
use model::Causality;

use crate::base::{Base, Part};
use crate::error::Error;
use crate::port::{Port, check_names, choose};
use crate::request::{Model, Noise, Request};
use crate::tap;
use crate::task::{Task, assemble};

/// All tasks of a request.
pub(crate) fn of(request: &Request) -> Result<Vec<Task>, Error> {
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
    let mut all = motions::tasks(request, blueprint, (&inputs, &outputs), &chosen)?;
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
                task.warnings.extend(monitor.map(|m| motions::not_cut(&m)));
                all.push(task);
            }
        }
    }
    if let Some(first) = all.first_mut() {
        first.warnings.append(&mut unknown);
    }
    Ok(all)
}
