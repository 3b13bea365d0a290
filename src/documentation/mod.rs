//! The page `documentation/index.html` inside an FMU: what the model is, its signal paths, its
//! variables, how it behaves.

mod repaired;
mod variables;

use data::{AxisBlueprint, Blueprint, ComponentBlueprint};
use model::Kind;
use modeldescription::ModelDescription;
use report::{
    Diagram, KeyFigure, Lane, Look, Provenance, Report, Section, Table, TimeSeries, Verdict,
};

pub(crate) use repaired::repaired;

use crate::reference::Reference;

/// The page of a packed blueprint.
pub(crate) fn page(
    blueprint: &Blueprint,
    description: &ModelDescription,
    reference: Option<&Reference>,
) -> anyhow::Result<String> {
    let kind = match blueprint.kind {
        Kind::Plant => "plant",
        Kind::Controller => "controller",
    };
    let sentence = match blueprint.description.as_str() {
        "" => format!("A {kind} of {} axes.", blueprint.axes.len()),
        text if text.ends_with('.') => text.to_owned(),
        text => format!("{text}."),
    };
    let mut page = Report::new(kind, blueprint.name.as_str(), Verdict::neutral(sentence));
    page = page.provenance(provenance(description, &blueprint.source));
    page = figures(page, description);
    let step = description.default_experiment.as_ref().and_then(|e| e.step_size);
    let section = Section::new("What it does").diagram(diagram(blueprint));
    let mut section = section.table(parts(blueprint));
    if let Some(step) = step {
        section = section.paragraph(format!(
            "Internal step {} s. It is right for any communication step: the model steps on its own grid, and \
             its outputs are those of the last hit. Linear parts are exact at any step.",
            report::format_number(step, 6)
        ));
    }
    page = page.section(section);
    for section in variables::sections(description) {
        page = page.section(section);
    }
    Ok(with_reference(page, reference).to_html()?)
}

/// Numbers of variables, and the platforms' common facts.
fn figures(page: Report, description: &ModelDescription) -> Report {
    let count =
        |causality| description.variables.iter().filter(|v| v.causality == causality).count();
    use modeldescription::variable::Causality::{Input, Output, Parameter};
    let version = description.fmi_version.text();
    page.key_figure(KeyFigure::new("Standard", format!("FMI {version}"), "").note("co-simulation"))
        .key_figure(KeyFigure::new("Inputs", count(Input), ""))
        .key_figure(KeyFigure::new("Outputs", count(Output), ""))
        .key_figure(KeyFigure::new("Parameters", count(Parameter), ""))
}

fn provenance(description: &ModelDescription, source: &str) -> Provenance {
    let mut all = Provenance::new("piezoloop", crate::VERSION);
    let described = [
        ("Model version", description.version.as_deref()),
        ("Author", description.author.as_deref()),
        ("Copyright", description.copyright.as_deref()),
        ("Licence", description.license.as_deref()),
        ("Source", Some(source)),
        ("GUID", Some(description.instantiation_token.as_str())),
    ];
    for (name, text) in described {
        if let Some(text) = text.filter(|text| !text.is_empty()) {
            all = all.remark(name, text);
        }
    }
    all
}

/// The signal path of each axis, as its blueprint says it.
fn diagram(blueprint: &Blueprint) -> Diagram {
    let plant = blueprint.kind == Kind::Plant;
    let mut diagram = Diagram::new("Signal paths");
    for (number, axis) in (1..).zip(&blueprint.axes) {
        diagram = diagram.lane(lane(blueprint, axis, number, plant));
    }
    diagram
}

fn lane(blueprint: &Blueprint, axis: &AxisBlueprint, number: usize, plant: bool) -> Lane {
    let name = if axis.name.is_empty() { format!("axis{number}") } else { axis.name.clone() };
    let mut lane = Lane::new(format!("Axis {name}"));
    let signal = |lane: Lane, what: &str, signal: &data::SignalBlueprint, unit: &str| {
        let unit = if signal.unit.is_empty() { unit } else { &signal.unit };
        let short = if signal.name.is_empty() { "" } else { &*format!("{}, ", signal.name) };
        let detail = format!("{short}{}", report::format_unit(unit));
        lane.stage(Look::Signal, format!("{what}[{number}]"), detail.trim_end_matches(", "))
    };
    let couplings: Vec<_> =
        blueprint.couplings.iter().filter(|c| c.axes.contains(&axis.name)).collect();
    let position = axis.position.unit.as_str();
    lane = if plant {
        signal(lane, "command", &axis.command, &axis.command.unit)
    } else {
        let lane = signal(lane, "reference", &axis.reference, position);
        let lane = signal(lane, "measured", &axis.measured, position);
        // The coordinator turns coordinates into axes before the laws see them.
        couplings.iter().fold(lane, |lane, c| component(lane, &c.component, true))
    };
    let mut placed = vec![!plant; couplings.len()];
    for part in &axis.components {
        lane = component(lane, part, false);
        for (coupling, placed) in couplings.iter().zip(&mut placed) {
            let own = if part.name.is_empty() { &part.kind } else { &part.name };
            if !*placed && coupling.after == *own {
                lane = component(lane, &coupling.component, true);
                *placed = true;
            }
        }
    }
    for (coupling, _) in couplings.iter().zip(&placed).filter(|(_, placed)| !**placed) {
        lane = component(lane, &coupling.component, true);
    }
    if plant {
        signal(lane, "position", &axis.position, position)
    } else {
        signal(lane, "command", &axis.command, &axis.command.unit)
    }
}

fn component(lane: Lane, part: &ComponentBlueprint, shared: bool) -> Lane {
    let kind = part.kind.as_str();
    let name = if part.name.is_empty() { kind } else { &part.name };
    let look = match (part.enabled, shared) {
        (false, _) => Look::Off,
        (true, true) => Look::Shared,
        (true, false) => Look::Box,
    };
    lane.stage(look, name, if name == kind { "" } else { kind })
}

/// What each type of component does.
fn parts(blueprint: &Blueprint) -> Table {
    let axes = blueprint.axes.iter().flat_map(|axis| &axis.components);
    let all = axes.chain(blueprint.couplings.iter().map(|coupling| &coupling.component));
    let mut known: Vec<&str> = Vec::new();
    let mut table = Table::new("What the parts are", ["type", "what it is", "equation"]);
    for part in all {
        let found = learned::COMPONENTS.iter().find(|c| c.declaration().kind == part.kind);
        let Some(declaration) = found.map(|c| c.declaration()) else { continue };
        if !known.contains(&declaration.kind) {
            known.push(declaration.kind);
            table = table.row([declaration.kind, declaration.summary, declaration.equation]);
        }
    }
    table
}

/// What the reference results look like, and where they are.
fn with_reference(page: Report, reference: Option<&Reference>) -> Report {
    let Some(reference) = reference else { return page };
    let mut figure = TimeSeries::new("Reference run: inputs and outputs", &reference.time);
    for (name, unit, values) in &reference.inputs {
        figure = figure.reference(name.as_str(), unit, values);
    }
    for (name, unit, values) in &reference.outputs {
        figure = figure.model(name.as_str(), unit, values);
    }
    page.section(
        Section::new("Reference results")
            .paragraph(format!(
                "The folder extra/{} holds a run with its inputs and outputs, which the command below repeats and \
                 compares: each output within {} of its peak-to-peak value.",
                crate::reference::FOLDER,
                report::format_number(reference.tolerance, 3)
            ))
            .code("piezoloop check model.fmu")
            .figure(figure),
    )
}
