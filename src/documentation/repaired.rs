//! The page of a repaired FMU: what was put around the original, and how it is switched.

use diagnose::Repaired;
use modeldescription::variable::Variable;
use report::{Diagram, Lane, Look, Report, Section, Table, Verdict};

use super::{figures, provenance, variables, with_reference};
use crate::reference::Reference;

/// The page of a repaired FMU; `original` is where the original's own page lies, if it has one.
pub(crate) fn repaired(
    wrapped: &Repaired,
    original: Option<&str>,
    reference: Option<&Reference>,
) -> anyhow::Result<String> {
    let description = &wrapped.description;
    let repair = &wrapped.repair;
    let names: Vec<&str> = repair.effects.iter().map(|effect| effect.name.as_str()).collect();
    if names.is_empty() {
        return preset(wrapped, original, reference);
    }
    let sentence = format!(
        "{} with {} added: what a diagnosis against measured logs has found.",
        description.model_name,
        names.join(", ")
    );
    let title = format!("{}, repaired", description.model_name);
    let mut page = Report::new("repaired", title, Verdict::neutral(sentence));
    page = page.provenance(
        provenance(description, "")
            .remark("SHA-256 of the original", repair.original.sha256.as_str()),
    );
    let mut section = Section::new("What was added")
        .paragraph(
            "The original lies untouched in resources/inner. This FMU takes its place: its inputs, outputs and \
             parameters are here under the same names. Each effect has a switch; with all of them off, the \
             outputs are the original's, bit by bit.",
        )
        .diagram(diagram(wrapped))
        .table(effects(wrapped))
        .paragraph(format!(
            "Communication steps longer than {} s are divided where effects are on. Directional derivatives are \
             offered where the original offers them. Not offered, whatever the original offers: adjoint \
             derivatives, derivatives by time, event mode (the original handles its events itself), model \
             exchange.",
            report::format_number(repair.step, 6)
        ));
    if let Some(path) = original {
        section = section.paragraph(format!("The original's own page: {path}"));
    }
    page = figures(page, description).section(section);
    for section in variables::sections(description) {
        page = page.section(section);
    }
    Ok(with_reference(page, reference).to_html()?)
}

/// The page of an FMU that only begins with other values.
fn preset(
    wrapped: &Repaired,
    original: Option<&str>,
    reference: Option<&Reference>,
) -> anyhow::Result<String> {
    let description = &wrapped.description;
    let sentence =
        format!("{} with start values that were estimated from logs.", description.model_name);
    let title = format!("{}, with other start values", description.model_name);
    let mut page = Report::new("preset", title, Verdict::neutral(sentence));
    page = page.provenance(
        provenance(description, "")
            .remark("SHA-256 of the original", wrapped.repair.original.sha256.as_str()),
    );
    let mut section = Section::new("What is other").paragraph(
        "The original lies untouched in resources/inner. It is given the start values of this FMU when it is \
         instantiated and after a reset; what an importer sets counts after that.",
    );
    if let Some(path) = original {
        section = section.paragraph(format!("The original's own page: {path}"));
    }
    page = figures(page, description).section(section);
    for section in variables::sections(description) {
        page = page.section(section);
    }
    Ok(with_reference(page, reference).to_html()?)
}

/// Effects before and behind the original, path by path.
fn diagram(wrapped: &Repaired) -> Diagram {
    let repair = &wrapped.repair;
    let mut diagram = Diagram::new("The original and the effects around it");
    for (number, output) in repair.outputs.iter().enumerate() {
        let mut lane = Lane::new(format!("To {}", output.name));
        for (k, input) in repair.inputs.iter().enumerate() {
            let mut before: Vec<_> = pieces(wrapped, surround::Side::Input, k).collect();
            if before.is_empty() && k > 0 {
                continue;
            }
            before.sort_by_key(|(place, _)| *place);
            lane = lane.stage(Look::Signal, input.name.as_str(), report::format_unit(&input.unit));
            for (_, effect) in before {
                lane = stage(lane, effect);
            }
        }
        lane = lane.stage(Look::Shared, description(wrapped), "the original, untouched");
        let mut behind: Vec<_> = pieces(wrapped, surround::Side::Output, number).collect();
        behind.sort_by_key(|(place, _)| *place);
        // An effect before the mode is three blocks: the mode out, the effect, the mode in again.
        behind.dedup_by(|a, b| std::ptr::eq(a.1, b.1));
        for (_, effect) in behind {
            lane = stage(lane, effect);
        }
        lane = lane.stage(Look::Signal, output.name.as_str(), report::format_unit(&output.unit));
        diagram = diagram.lane(lane);
    }
    diagram
}

fn description(wrapped: &Repaired) -> &str {
    &wrapped.description.model_name
}

fn stage(lane: Lane, effect: &surround::Effect) -> Lane {
    let look = if effect.enabled { Look::Box } else { Look::Off };
    lane.stage(look, effect.name.as_str(), effect.description.as_str())
}

/// Place and effect of each block on a side of a port.
fn pieces(
    wrapped: &Repaired,
    side: surround::Side,
    port: usize,
) -> impl Iterator<Item = (u32, &surround::Effect)> {
    wrapped.repair.effects.iter().flat_map(move |effect| {
        let own =
            effect.blocks.iter().filter(move |piece| piece.side == side && piece.port == port);
        own.map(move |piece| (piece.place, effect))
    })
}

/// The switches and parameters of the effects.
fn effects(wrapped: &Repaired) -> Table {
    let own: Vec<&Variable> = wrapped
        .description
        .variables
        .iter()
        .filter(|v| {
            let name = v.name.split('.').next();
            wrapped.repair.effects.iter().any(|effect| Some(effect.name.as_str()) == name)
        })
        .collect();
    variables::table("Switches and parameters of what was added", &wrapped.description, &own)
}
