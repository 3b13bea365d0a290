//! A plan from an SSP.

use std::path::Path;

use modeldescription::ssp::{Annotation, FMU_TYPE, Flat, Implementation, Ssp, SspError};
use modeldescription::xml;

use super::{Coupling, Master, Plan, PlannedConnection, PlannedFmu, PlannedInput, PlannedStart};
use crate::error::Error;
use crate::port::Port;
use crate::unit::Transformations;

/// `type` of the annotation that holds what SSP has no words for: step, algorithm, order.
pub(super) const ANNOTATION: &str = "io.github.piezoloop";

impl Plan {
    pub(super) fn read_ssp(path: &Path) -> Result<Self, Error> {
        let ssp = Ssp::open(path)?;
        let structure = ssp.structure();
        let flat = structure.flatten(ssp.file_name()).map_err(SspError::Problems)?;
        let fmus = fmus(&ssp, &flat).map_err(|reasons| Error::Package {
            path: path.to_path_buf(),
            reason: reasons.join("\n"),
        })?;
        let port = |place: &(String, String)| Port::from((place.0.as_str(), place.1.as_str()));
        let connections = flat.connections.iter().map(|connection| PlannedConnection {
            from: port(&connection.from),
            to: port(&connection.to),
            way: Transformations(connection.way.clone()),
            place: format!("{}:{}", ssp.file_name(), connection.line.0),
        });
        let inputs = flat.inputs.iter().map(|input| PlannedInput {
            column: input.connector.clone(),
            to: port(&input.to),
            way: Transformations(input.way.clone()),
            place: format!("{}:{}", ssp.file_name(), input.line.0),
        });
        let starts = flat.starts.iter().map(|start| PlannedStart {
            to: port(&start.to),
            value: start.value.clone(),
            way: Transformations(vec![start.way.clone()]),
            place: start.place.clone(),
            optional: true,
        });
        let experiment = structure.default_experiment;
        let mut master = Master {
            start: experiment.start_time,
            stop: experiment.stop_time,
            ..Master::default()
        };
        noted(&mut master, &structure.system.annotations);
        let record = record(&structure.system.annotations, &fmus);
        Ok(Plan {
            name: structure.name.clone(),
            origin: path.to_path_buf(),
            connections: connections.collect(),
            inputs: inputs.collect(),
            starts: starts.collect(),
            record,
            fmus,
            master,
            notes: flat.notes,
            undirected: false,
            names: Default::default(),
            _ssp: Some(ssp),
        })
    }
}

fn fmus(ssp: &Ssp, flat: &Flat) -> Result<Vec<PlannedFmu>, Vec<String>> {
    let (mut fmus, mut problems) = (Vec::new(), Vec::new());
    for component in &flat.components {
        let at =
            format!("{}:{}: component \"{}\"", ssp.file_name(), component.line.0, component.path);
        if component.media_type != FMU_TYPE {
            let found = &component.media_type;
            problems.push(format!("{at} is of type {found}; only FMUs ({FMU_TYPE}) are run"));
            continue;
        }
        if !matches!(component.implementation, Implementation::Any | Implementation::CoSimulation) {
            let found = component.implementation;
            problems.push(format!("{at} asks for {found}; only CoSimulation is offered"));
        }
        match ssp.file(&component.source) {
            Ok(path) => {
                let mine = own(&component.annotations);
                let step = mine.and_then(|element| number(element, "step"));
                fmus.push(PlannedFmu { name: component.path.clone(), path, place: at, step });
            }
            Err(why) => problems.push(format!("{at}: {why}")),
        }
    }
    if problems.is_empty() { Ok(fmus) } else { Err(problems) }
}

fn own(annotations: &[Annotation]) -> Option<&xml::Element> {
    annotations.iter().find(|a| a.kind == ANNOTATION).and_then(|a| a.content.as_ref())
}

fn number(element: &xml::Element, name: &str) -> Option<f64> {
    element.attribute(name)?.parse().ok().filter(|number: &f64| number.is_finite())
}

/// What the annotations say: ours, else the step of OMSimulator's.
fn noted(master: &mut Master, annotations: &[Annotation]) {
    let Some(element) = own(annotations) else {
        let foreign = annotations.iter().filter_map(|annotation| annotation.content.as_ref());
        master.step = foreign.filter_map(fixed_step).next();
        return;
    };
    master.step = number(element, "step").filter(|step| *step > 0.0);
    let coupling = element.attribute("algorithm").and_then(Coupling::from_name);
    master.coupling = coupling.unwrap_or_default();
    let slaves = element.children.iter().filter(|child| child.name.ends_with("Slave"));
    master.order = slaves.filter_map(|slave| slave.attribute("name")).map(str::to_owned).collect();
    master.iteration.relaxation = super::relaxation(number(element, "relaxation"));
    if let Some(tolerance) = number(element, "tolerance") {
        master.iteration.tolerance = tolerance;
    }
    if let Some(iterations) = number(element, "iterations") {
        master.iteration.iterations = iterations as usize;
    }
}

/// `FixedStepMaster` of OMSimulator, however deep.
fn fixed_step(element: &xml::Element) -> Option<f64> {
    if element.name.ends_with("FixedStepMaster") {
        return number(element, "stepSize").filter(|step| *step > 0.0);
    }
    element.children.iter().find_map(fixed_step)
}

fn record(annotations: &[Annotation], fmus: &[PlannedFmu]) -> Vec<(Port, String)> {
    let children = own(annotations).map(|e| e.children.as_slice()).unwrap_or_default();
    let records = children.iter().filter(|child| child.name.ends_with("Record"));
    let names = fmus.iter().map(|fmu| fmu.name.clone()).collect();
    let named = records.filter_map(|child| {
        let port = super::port_of(&names, child.attribute("variable")?)?;
        Some((port, child.attribute("name")?.to_owned()))
    });
    named.collect()
}
