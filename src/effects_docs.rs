//! docs/effects.md: one section per component, written from the registry.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write;

use anyhow::{Context, anyhow};
use data::{Blueprint, ComponentBlueprint};
use model::{Conversion, Declaration, Phenomenon, Within};
use report::{Axis, Figure, XyLoop};

use crate::effects;

const HEAD: &str = "# Effects and components\n\n\
Generated from the registry by `piezoloop effects-docs docs`; a test compares it.\n\n\
A component with an *effect* can be disabled by its start value `enabled`. The figure of an effect shows position over \
command for an axis of 0.1 um/V, without the effect (measured colour) and with it at its default strength \
(`rigs/effects.toml`): the last of ten loops of 0 to 100 V at 20 Hz. For an effect below 5 % of the stroke it shows \
the change of the position instead. *Default strength* is the greatest and the rms change of the position over all ten \
loops, in percent of the stroke of 10 um; for a hysteresis model it is the difference from the straight line through \
its stroke.\n\n\
*In a rig* is the same at the strength that the effect has in the truth rig of a machine: the change of axis 1 when the \
effect is removed, over ten loops of the complete command range with 500 internal steps each (the other axes a quarter \
of a loop ahead), in percent of the stroke.\n";

/// Internal step, loops and hits of a loop of the trial.
const PERIOD: f64 = 1e-4;
const LOOP: usize = 500;
const LOOPS: usize = 10;

/// The pages: name of the file, its text.
pub(crate) fn pages() -> anyhow::Result<BTreeMap<String, String>> {
    let library = effects::library()?;
    let mut pages = BTreeMap::new();
    let mut text = String::from(HEAD);
    text.push_str(&catalogue());
    let machines = machines()?;
    for component in components::COMPONENTS {
        let declaration = component.declaration();
        text.push_str(&section(declaration));
        for machine in &machines {
            text.push_str(&machine.without(declaration)?);
        }
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
    let inverses = learned::COMPONENTS.iter().filter(|c| c.declaration().kind == d.kind);
    let cancelled: Vec<String> = inverses
        .flat_map(|component| component.inverses())
        .map(|inverse| format!("[{0}](#{0}) ({1})", inverse.kind, inverse.undoing.name()))
        .collect();
    if !cancelled.is_empty() {
        text.push_str(&format!(
            "Compensated in front of the machine by {}.\n\n",
            cancelled.join(", ")
        ));
    }
    text.push_str(
        "| parameter | unit | start | least | greatest | meaning |\n|---|---|---|---|---|---|\n",
    );
    let bound = |x: f64| if x.is_finite() { x.to_string() } else { String::new() };
    let start = |x: Option<f64>| x.map_or_else(|| "required".to_owned(), |x| x.to_string());
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
    let setting = |k: usize| format!("`{}`", d.structure.get(k).map_or("", |s| s.name));
    for q in d.parameters {
        let (least, greatest) = match q.within {
            Within::Any => (bound(q.min), bound(q.max)),
            Within::Commands => ("of the commands".to_owned(), "of the commands".to_owned()),
            Within::Settings(least, greatest) => {
                (least.map_or_else(|| bound(q.min), setting), setting(greatest))
            }
        };
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} | {} |",
            q.name,
            q.unit,
            start(q.start),
            least,
            greatest,
            q.description
        );
    }
    text.push('\n');
    if let Some(effect) = d.effect {
        let _ = writeln!(
            text,
            "* Effect: `{}`.\n* In the residual: {}.\n* Looks like: {}.\n* Distinguished by: {}.\n",
            effect.name,
            effect.signature,
            effect.confused_with.iter().map(|e| format!("`{e}`")).collect::<Vec<_>>().join(", "),
            effect.experiment
        );
    }
    text
}

/// Which components stand for which effect of the signal path.
fn catalogue() -> String {
    let mut text = String::from(
        "\n## Effects of the signal path and their components\n\n| effect | components | \
         remark |\n|---|---|---|\n",
    );
    for Phenomenon { name, remark } in components::phenomena::PHENOMENA {
        let all = components::COMPONENTS.iter().map(|component| component.declaration());
        let kinds = all.filter(|d| d.phenomena.iter().any(|own| own.name == *name));
        let kinds: Vec<_> = kinds.map(|d| format!("[{0}](#{0})", d.kind)).collect();
        let _ = writeln!(text, "| {name} | {} | {remark} |", kinds.join(", "));
    }
    text
}

/// A truth rig and its first axis over the loops.
struct Machine {
    name: &'static str,
    blueprint: Blueprint,
    positions: Vec<f64>,
    stroke: f64,
}

/// All truth rigs.
fn machines() -> anyhow::Result<Vec<Machine>> {
    let mut machines = Vec::new();
    for rig in rigs::RIGS.iter().filter(|rig| rig.name.ends_with("-truth")) {
        let blueprint = Blueprint::parse(rig.blueprint, rig.name)?;
        let positions = loops(&blueprint)?;
        let fold =
            |start: f64, pick: fn(f64, f64) -> f64| positions.iter().copied().fold(start, pick);
        let stroke = fold(f64::NEG_INFINITY, f64::max) - fold(f64::INFINITY, f64::min);
        machines.push(Machine { name: rig.name, blueprint, positions, stroke });
    }
    Ok(machines)
}

impl Machine {
    /// What the machine is without this component, where it has one that can be left out.
    fn without(&self, declaration: &Declaration) -> anyhow::Result<String> {
        let mut blueprint = self.blueprint.clone();
        let mut count = 0;
        let axis = blueprint.axes.first_mut().map_or(&mut [][..], |axis| &mut axis.components);
        let couplings = blueprint.couplings.iter_mut().map(|c| &mut c.component);
        for component in axis.iter_mut().chain(couplings) {
            if component.kind == declaration.kind && component.enabled {
                (component.enabled, count) = (false, count + 1);
            }
        }
        if count == 0 || !declaration.can_be_disabled() {
            return Ok(String::new());
        }
        let (greatest, rms) = change(&self.positions, &loops(&blueprint)?, self.stroke);
        let (greatest, rms) = (percent(greatest), percent(rms));
        Ok(format!("In `{}`: {greatest} at most, {rms} rms.\n\n", self.name))
    }
}

/// Position of axis 1 over ten loops of the whole range of its command.
fn loops(blueprint: &Blueprint) -> anyhow::Result<Vec<f64>> {
    let mut system = blueprint.check(components::COMPONENTS)?.build();
    let variables = system.variables();
    let inputs =
        variables.as_slice().iter().zip(0u32..).filter(|(v, _)| {
            v.causality == model::Causality::Input && v.name.starts_with("command[")
        });
    let inputs: Vec<(u32, f64, f64)> = inputs.map(|(v, r)| (r, v.min, v.max)).collect();
    let y = variables.find("position[1]").context("an axis has a position")?;
    let period = system.period();
    system.initialise(0.0).map_err(|e| anyhow!(system.explain(&e)))?;
    let mut positions = Vec::with_capacity(LOOPS * LOOP);
    for n in 0..LOOPS * LOOP {
        positions.push(system.get(y).context("in the table")?);
        for (axis, (reference, low, high)) in inputs.iter().enumerate() {
            let ahead = if axis == 0 { 0.0 } else { 0.25 * TAU };
            let part = 0.5 - 0.5 * (TAU * n as f64 / LOOP as f64 + ahead).cos();
            let command = low + (high - low) * part;
            system.set(*reference, command).map_err(|e| anyhow!(system.explain_set(&e)))?;
        }
        let end = (n + 1) as f64 * period;
        system.advance(end).map_err(|e| anyhow!(system.explain(&e)))?;
    }
    Ok(positions)
}

/// Greatest and rms difference in percent of a stroke.
fn change(with: &[f64], without: &[f64], stroke: f64) -> (f64, f64) {
    let errors = with.iter().zip(without).map(|(a, b)| a - b);
    let greatest = errors.clone().map(f64::abs).fold(0.0, f64::max);
    let square = errors.map(|e| e * e).sum::<f64>() / with.len().max(1) as f64;
    (100.0 * greatest / stroke, 100.0 * square.sqrt() / stroke)
}

fn percent(x: f64) -> String {
    if x >= 1e-3 { format!("{x:.3} %") } else { format!("{x:.1e} %") }
}

/// Change in percent of the stroke from which two loops can be told apart by eye.
const VISIBLE: f64 = 5.0;

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
        let (greatest, rms) = change(&with, &without, STROKE);
        Self { command, without, with, greatest, rms }
    }

    fn figure(&self, declaration: &Declaration) -> String {
        let last = (LOOPS - 1) * LOOP;
        let (u, without, with) = (&self.command[last..], &self.without[last..], &self.with[last..]);
        let command = Axis::new("command", "V");
        let figure = if self.greatest < VISIBLE {
            let change: Vec<f64> = with.iter().zip(without).map(|(a, b)| 1e3 * (a - b)).collect();
            let axis = Axis::new("change of the position", "nm");
            XyLoop::new(declaration.kind, command, axis).model("with less without", u, &change)
        } else {
            XyLoop::new(declaration.kind, command, Axis::new("position", "um"))
                .measured("without", u, without)
                .model("with", u, with)
        };
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

    /// Each effect of a truth rig changes its output; by how much its section states, and
    /// `docs_are_current` holds it to that.
    #[test]
    fn every_effect_of_a_truth_rig_acts() {
        for machine in machines().unwrap_or_else(|e| panic!("{e:#}")) {
            for component in components::COMPONENTS {
                let declaration = component.declaration();
                let described = machine.without(declaration).unwrap_or_else(|e| panic!("{e:#}"));
                let idle = described.contains(": 0.0e0 % at most");
                assert!(!idle, "{} in {} changes nothing", declaration.kind, machine.name);
            }
        }
    }
}
