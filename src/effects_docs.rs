//! docs/effects.md: one section per component, written from the registry.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write;

use anyhow::{Context, anyhow};
use data::{Blueprint, ComponentBlueprint};
use model::{Conversion, Declaration};
use report::{Axis, Figure, XyLoop};

use crate::effects;

const HEAD: &str = "# Effects and components\n\n\
Written from the registry by `piezoloop effects-docs docs`; a test compares it.\n\n\
A component with an *effect* can be switched off by its start value `enabled`. The figure of an \
effect shows the position over the command of an axis of 0.1 um/V without (measured colour) and with it \
at its default strength (`rigs/effects.toml`): the last of ten loops of 0 to 100 V at 20 Hz. \
*Default strength* is the greatest and the rms change of the position over all ten loops, in percent \
of the stroke of 10 um; for a hysteresis model that against the straight line through its stroke.\n";

/// Internal step, loops and hits of a loop of the trial.
const PERIOD: f64 = 1e-4;
const LOOP: usize = 500;
const LOOPS: usize = 10;

/// The pages: name of the file, its text.
pub(crate) fn pages() -> anyhow::Result<BTreeMap<String, String>> {
    let library = effects::library()?;
    let mut pages = BTreeMap::new();
    let mut text = String::from(HEAD);
    for component in components::COMPONENTS {
        let declaration = component.declaration();
        text.push_str(&section(declaration));
        let Some(trial) = trial(&library, declaration.kind)? else { continue };
        let file = format!("effects/{}.svg", declaration.kind);
        let _ = writeln!(
            text,
            "Default strength: {:.3} % at most, {:.3} % rms.\n\n![{}]({file})\n",
            trial.greatest, trial.rms, declaration.kind
        );
        pages.insert(file, trial.figure(declaration));
    }
    pages.insert("effects.md".to_owned(), text);
    Ok(pages)
}

fn section(d: &Declaration) -> String {
    let mut text = format!(
        "\n## {}\n\n{}. Stage: {}.\n\n    {}\n\nSource: {}.\n\n",
        d.kind,
        d.summary,
        d.stage.name(),
        d.equation,
        d.reference
    );
    text.push_str(
        "| parameter | unit | start | least | greatest | meaning |\n|---|---|---|---|---|---|\n",
    );
    let bound = |x: f64| if x.is_finite() { x.to_string() } else { String::new() };
    let start = |x: Option<f64>| x.map_or_else(|| "must be given".to_owned(), |x| x.to_string());
    for s in d.structure {
        let _ = writeln!(
            text,
            "| `{}` (structure) | {} | {} | {} | {} | {} |",
            s.name,
            s.unit,
            s.start.map_or_else(|| "by its lists".to_owned(), |x| x.to_string()),
            bound(s.min),
            bound(s.max),
            s.description
        );
    }
    for q in d.parameters {
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} | {} |",
            q.name,
            q.unit,
            start(q.start),
            bound(q.min),
            bound(q.max),
            q.description
        );
    }
    text.push('\n');
    if let Some(effect) = d.effect {
        let _ = writeln!(
            text,
            "* Effect: `{}`.\n* In the residual: {}.\n* Looks like: {}.\n* Told apart by: {}.\n",
            effect.name,
            effect.signature,
            effect.confused_with.iter().map(|e| format!("`{e}`")).collect::<Vec<_>>().join(", "),
            effect.experiment
        );
    }
    text
}

/// What an effect does to a loop.
struct Trial {
    command: Vec<f64>,
    without: Vec<f64>,
    with: Vec<f64>,
    /// In percent of the stroke.
    greatest: f64,
    rms: f64,
}

/// The trial of a component, where the library has it and it shows on a loop.
fn trial(library: &Blueprint, kind: &str) -> anyhow::Result<Option<Trial>> {
    let declaration = components::find(kind).context("of the registry")?.declaration();
    let on_axis = |axis: &&data::AxisBlueprint| axis.components.iter().any(|c| c.kind == kind);
    let mut with = library.clone();
    if declaration.can_be_disabled() {
        with.axes.truncate(2);
        for axis in &mut with.axes {
            axis.components.iter_mut().for_each(|c| enable(c, kind));
        }
        with.couplings.iter_mut().for_each(|c| enable(&mut c.component, kind));
        let mut without = library.clone();
        without.axes.truncate(2);
        let (command, with) = run(&with)?;
        let (_, without) = run(&without)?;
        return Ok(Some(Trial::new(command, without, with)));
    }
    if declaration.conversion != Conversion::CommandToPosition {
        return Ok(None);
    }
    let Some(axis) = library.axes.iter().skip(1).find(on_axis) else { return Ok(None) };
    (with.axes, with.couplings) = (vec![axis.clone()], Vec::new());
    let (command, with) = run(&with)?;
    let (low, high) = (with[(LOOPS - 1) * LOOP], with[(LOOPS - 1) * LOOP + LOOP / 2]);
    let line = command.iter().map(|u| low + (high - low) * u / 100.0).collect();
    Ok(Some(Trial::new(command, line, with)))
}

fn enable(component: &mut ComponentBlueprint, kind: &str) {
    component.enabled |= component.kind == kind;
}

/// Command and position of the first axis over all loops; the second axis moves in quadrature.
fn run(blueprint: &Blueprint) -> anyhow::Result<(Vec<f64>, Vec<f64>)> {
    let mut system = blueprint.check(components::COMPONENTS)?.build();
    let find = |name: &str| system.variables().find(name);
    let (u, y) = (find("command[1]"), find("position[1]"));
    let (u, y) = (u.context("an axis has a command")?, y.context("an axis has a position")?);
    let neighbour = find("command[2]");
    system.initialise(0.0).map_err(|e| anyhow!(system.explain(&e)))?;
    let (mut commands, mut positions) = (Vec::new(), Vec::new());
    for n in 0..LOOPS * LOOP {
        let angle = TAU * n as f64 / LOOP as f64;
        let command = 50.0 * (1.0 - angle.cos());
        positions.push(system.get(y).context("in the table")?);
        commands.push(command);
        system.set(u, command).map_err(|e| anyhow!(system.explain_set(&e)))?;
        if let Some(neighbour) = neighbour {
            let command = 50.0 * (1.0 + angle.sin());
            system.set(neighbour, command).map_err(|e| anyhow!(system.explain_set(&e)))?;
        }
        let end = (n + 1) as f64 * PERIOD;
        system.advance(end).map_err(|e| anyhow!(system.explain(&e)))?;
    }
    Ok((commands, positions))
}

impl Trial {
    fn new(command: Vec<f64>, without: Vec<f64>, with: Vec<f64>) -> Self {
        const STROKE: f64 = 10.0;
        let errors = with.iter().zip(&without).map(|(a, b)| a - b);
        let greatest = errors.clone().map(f64::abs).fold(0.0, f64::max);
        let square = errors.map(|e| e * e).sum::<f64>() / with.len().max(1) as f64;
        let percent = |x: f64| 100.0 * x / STROKE;
        Self { command, without, with, greatest: percent(greatest), rms: percent(square.sqrt()) }
    }

    fn figure(&self, declaration: &Declaration) -> String {
        let last = (LOOPS - 1) * LOOP;
        let (u, without, with) = (&self.command[last..], &self.without[last..], &self.with[last..]);
        let figure =
            XyLoop::new(declaration.kind, Axis::new("command", "V"), Axis::new("position", "um"))
                .measured("without", u, without)
                .model("with", u, with);
        Figure::from(figure).to_svg()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn docs_are_current() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
        for (file, text) in pages().unwrap_or_else(|e| panic!("{e:#}")) {
            let found = std::fs::read_to_string(folder.join(&file)).unwrap_or_default();
            assert!(found == text, "docs/{file} is not current; run `piezoloop effects-docs docs`");
        }
    }

    /// Each effect at its default strength changes the output; by how much its section states, and
    /// `docs_are_current` holds it to that.
    #[test]
    fn every_effect_acts_at_its_default_strength() {
        let library = effects::library().unwrap_or_else(|e| panic!("{e:#}"));
        for component in components::COMPONENTS {
            let kind = component.declaration().kind;
            let trial = trial(&library, kind).unwrap_or_else(|e| panic!("{kind}: {e:#}"));
            assert!(trial.is_none_or(|t| t.greatest > 1e-3), "{kind} changes nothing");
        }
    }
}
