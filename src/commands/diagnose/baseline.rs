//! The linear model that a diagnosis starts from where none is given.
//!
//! A lag or a delay imitates a loop of hysteresis at one frequency and amplitude. Two plants are identified therefore,
//! a linear one and one with plays; where the plays explain what linear parts do not, delay, lag and mode are those that
//! stand beside them, and the plays are left for the diagnosis to find.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::Context;
use data::{Blueprint, ComponentBlueprint};
use diagnose::{Baseline, Estimate};
use identify::Candidate;
use model::{NodeSpec, unit_on_axis};

use crate::answer::Screen;
use crate::commands::identify::{AxisResult, Identified, Identify};
use crate::inputs::{BlueprintText, LogOptions};

/// Part of each record that the diagnosis holds out.
const HELD_OUT: f64 = 0.3;
/// Part of what the linear plant leaves that the one with plays must leave at most, for its linear parts to be taken.
const WITH_PLAYS: f64 = 0.9;
/// Standard errors of which a tolerance consists, and by which a delay must be seen.
const ERRORS: f64 = 1.0;
const SEEN: f64 = 2.0;
/// Least tolerance: what a linear model of a machine that is none takes into its parameters. Of a damping more.
const LEAST: f64 = 0.1;
const LEAST_OF_DAMPING: f64 = 0.5;

/// The model that was made.
pub(super) struct Made {
    pub(super) text: BlueprintText,
    /// What it is, one per output.
    pub(super) baselines: Vec<Baseline>,
    /// What the user must know of it, in sentences.
    pub(super) notes: Vec<String>,
    /// Run-in that the first rows ask for, in s.
    pub(super) run_in: f64,
    /// Which column belongs to which variable.
    pub(super) map: Vec<String>,
}

/// What it is made from.
pub(super) struct Asked<'a> {
    pub(super) logs: &'a [PathBuf],
    pub(super) inputs: &'a [String],
    pub(super) outputs: &'a [String],
    pub(super) options: &'a LogOptions,
    pub(super) drop: Option<f64>,
}

/// Identifies the linear model of the logs.
pub(super) fn made(asked: &Asked<'_>, screen: &Screen) -> anyhow::Result<Made> {
    let of = |model: &str| {
        let columns = (asked.inputs, asked.outputs);
        let held_out = HELD_OUT;
        Identify::one_model(model, asked.logs, columns, asked.options, (asked.drop, held_out))
            .plant(screen)
    };
    let linear = of("linear").context(
        "without --model a linear one is identified from the logs first, and that failed",
    )?;
    // Logs that suit no plays have none.
    let with_plays = of("prandtl-ishlinskii").ok();
    let mut blueprint = linear.0.blueprint().clone();
    let mut notes = linear.1.notes.clone();
    for (k, axis) in linear.1.axes.iter().enumerate() {
        let beside = with_plays.as_ref().and_then(|(plant, with)| {
            let found = with.axes.get(k)?;
            let is_better = left(found)? < WITH_PLAYS * left(axis)?;
            is_better.then_some((plant.blueprint(), found))
        });
        if let Some((plant, found)) = beside {
            let parts = &mut blueprint.axes[k].components;
            *parts = beside_plays(parts, &plant.axes[k].components, found);
            blueprint.step.clone_from(&plant.step);
            notes.push(format!(
                "{}: plays leave {:.2} times as much as linear parts alone: delay, lag and mode of the linear model are \
                 those beside plays, and no imitation of them",
                axis.name,
                left(found).zip(left(axis)).map_or(1.0, |(with, without)| with / without)
            ));
        }
        let estimates = beside.map_or(axis, |(_, found)| found);
        give_tolerances(&mut blueprint, k, [axis, estimates])?;
    }
    let baselines = baselines(&blueprint, &linear.1)?;
    notes.extend(baselines.iter().map(sentence));
    let names = asked.options.names()?;
    let columns = asked.inputs.iter().zip(asked.outputs).enumerate();
    let map = columns.flat_map(|(k, (input, output))| {
        let column = |name: &String| names.column(name).unwrap_or(name).to_owned();
        [
            format!("command[{}]={}", k + 1, column(input)),
            format!("position[{}]={}", k + 1, column(output)),
        ]
    });
    let (map, run_in) = (map.collect(), linear.1.run_in);
    let text = BlueprintText { text: blueprint.to_toml(), blueprint };
    Ok(Made { text, baselines, notes, run_in, map })
}

/// The candidate that was taken.
fn taken(axis: &AxisResult) -> Option<&Candidate> {
    axis.identification.candidates.iter().find(|candidate| candidate.accepted)
}

/// What the plant leaves on held-out rows.
fn left(axis: &AxisResult) -> Option<f64> {
    taken(axis)?.held_out_rmse
}

/// The gain of a linear plant with the delay, lag and mode that stand beside plays.
fn beside_plays(
    linear: &[ComponentBlueprint],
    with_plays: &[ComponentBlueprint],
    found: &AxisResult,
) -> Vec<ComponentBlueprint> {
    let is_seen = |part: &&ComponentBlueprint| {
        let delay = found.identification.parameters.iter().find(|p| p.name == "delay.delay");
        let deviation = |p: &identify::Estimate| p.deviation.map(|d| p.value > SEEN * d);
        part.kind != "delay" || delay.and_then(deviation).unwrap_or(false)
    };
    let of = |kind: &str| with_plays.iter().find(|part| part.kind == kind).filter(is_seen).cloned();
    let gain = linear.iter().find(|part| part.kind == "actuator-gain").cloned();
    [of("delay"), of("amplifier-lag"), gain, of("mode")].into_iter().flatten().collect()
}

/// Gives each fitted parameter of an axis its tolerance, from the first identification that has an estimate of it.
fn give_tolerances(
    blueprint: &mut Blueprint,
    axis: usize,
    sources: [&AxisResult; 2],
) -> anyhow::Result<()> {
    let checked = blueprint.clone().check(learned::COMPONENTS)?;
    let spec = &checked.spec().axes[axis];
    for (part, node) in blueprint.axes[axis].components.iter_mut().zip(&spec.components) {
        part.tolerance.clear();
        for (name, _, value) in fitted(node) {
            // The other source knows delay, lag and mode; the gain is that of the linear plant.
            let order = if part.kind == "actuator-gain" { [0, 1] } else { [1, 0] };
            let deviation = order.iter().find_map(|k| {
                let all = &sources[*k].identification.parameters;
                let is_own = |p: &&identify::Estimate| {
                    p.name.rsplit('.').next() == Some(name)
                        && (p.value - value).abs() <= 1e-6 * value.abs()
                };
                all.iter().find(is_own)?.deviation
            });
            let least = if name == "damping" { LEAST_OF_DAMPING } else { LEAST };
            let relative = deviation.map_or(0.0, |d| ERRORS * d / value.abs());
            if value != 0.0 {
                part.tolerance.insert(name.to_owned(), relative.max(least));
            }
        }
    }
    Ok(())
}

/// Name, unit and value of each scalar parameter of a component that is fitted.
fn fitted(node: &NodeSpec) -> impl Iterator<Item = (&'static str, &'static str, f64)> {
    let declaration = node.component.declaration();
    let mut at = 0;
    declaration.parameters.iter().enumerate().filter_map(move |(index, quantity)| {
        let length = declaration.length(index, &node.structure);
        let value = node.values.get(at).copied();
        at += length;
        value.filter(|_| quantity.fit && length == 1).map(|v| (quantity.name, quantity.unit, v))
    })
}

/// The models in numbers.
fn baselines(blueprint: &Blueprint, linear: &Identified) -> anyhow::Result<Vec<Baseline>> {
    let checked = blueprint.clone().check(learned::COMPONENTS)?;
    let axes = checked.spec().axes.iter().zip(&blueprint.axes).zip(&linear.axes).enumerate();
    let all = axes.map(|(k, ((spec, given), found))| {
        let mut parameters = BTreeMap::new();
        for (node, part) in spec.components.iter().zip(&given.components) {
            for (name, unit, value) in fitted(node) {
                let std = part.tolerance.get(name).map(|relative| relative * value.abs());
                let unit = unit_on_axis(unit, &spec.command_unit, &spec.position_unit);
                let path = format!("axis[{}].{}.{name}", k + 1, node.name);
                parameters.insert(path, Estimate { value, std, unit });
            }
        }
        let kinds: Vec<&str> = given.components.iter().map(|part| part.kind.as_str()).collect();
        let taken = taken(found);
        Baseline {
            output: found.name.clone(),
            structure: kinds.join(", "),
            parameters,
            nrmse: [taken.and_then(|c| c.fitted_nrmse), taken.and_then(|c| c.held_out_nrmse)],
        }
    });
    Ok(all.collect())
}

fn sentence(baseline: &Baseline) -> String {
    let number = |x: f64| report::format_number(x, 4);
    let with_std = |std: Option<f64>| std.map_or(String::new(), |s| format!(" ± {}", number(s)));
    let parameters = baseline
        .parameters
        .iter()
        .map(|(name, p)| format!("{name} = {}{} {}", number(p.value), with_std(p.std), p.unit));
    let left = baseline.nrmse[1].map_or(String::new(), |part| {
        format!(
            "; linear parts alone leave {} % of the range on the other rows",
            number(100.0 * part)
        )
    });
    format!(
        "{}: no --model was given; a linear one is identified from the first {:.0} % of the logs: {} ({}){left}",
        baseline.output,
        100.0 * (1.0 - HELD_OUT),
        baseline.structure,
        parameters.collect::<Vec<_>>().join(", ")
    )
}
