//! The linear model that a diagnosis starts from where none is given.
//!
//! A lag or a delay imitates a loop of hysteresis at one frequency and amplitude. Two plants are identified therefore,
//! a linear one and one with plays; where the plays explain what linear parts do not, delay, lag and mode are those that
//! stand beside them, and the plays are left for the diagnosis to find.

mod response;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use cli::Screen;
use components::effects;
use data::{Blueprint, CheckedBlueprint, ComponentBlueprint};
use diagnose::{Baseline, Between, Estimate, Reading};
use identify::Candidate;
use model::{Component, Conversion, Effect, NodeSpec, unit_on_axis};

use super::thresholds::Thresholds;
use crate::commands::identify::Identify;
use crate::inputs::{BlueprintText, LogOptions};
use crate::results::identify::{AxisResult, Identified};

/// The model that was made.
pub(super) struct Generated {
    pub(super) text: BlueprintText,
    /// What it is, one per output.
    pub(super) baselines: Vec<Baseline>,
    /// What the user must know of it, in sentences.
    pub(super) notes: Vec<String>,
    /// Run-in that the first rows ask for, in s.
    pub(super) run_in: f64,
    /// How the logs were read.
    pub(super) readings: (Between, Reading),
    /// Which column belongs to which variable.
    pub(super) map: Vec<String>,
}

impl Generated {
    /// With another linear model, and what it is.
    pub(super) fn with(&self, mut blueprint: Blueprint, what: &str) -> anyhow::Result<Self> {
        let checked = blueprint.clone().check(learned::COMPONENTS)?;
        for (axis, spec) in blueprint.axes.iter_mut().zip(&checked.spec().axes) {
            for (part, node) in axis.components.iter_mut().zip(&spec.components) {
                for (name, _, _) in fitted(node).filter(|(_, _, value)| *value != 0.0) {
                    part.tolerance.entry(name.to_owned()).or_insert(least_tolerance(name));
                }
            }
        }
        let names: Vec<&str> = self.baselines.iter().map(|b| b.output.as_str()).collect();
        let baselines = in_numbers(&blueprint, &names)?;
        let mut notes = self.notes.clone();
        let all = baselines.iter();
        notes.extend(
            all.map(|b| format!("{}: the linear model is {what}: {}", b.output, numbers(b))),
        );
        let text = BlueprintText { text: blueprint.to_toml(), blueprint };
        let (run_in, readings, map) = (self.run_in, self.readings, self.map.clone());
        Ok(Self { text, baselines, notes, run_in, readings, map })
    }
}

/// The model without its dynamics; none where it has none.
pub(super) fn gains_alone(blueprint: &Blueprint) -> Option<Blueprint> {
    let mut gains = blueprint.clone();
    for axis in &mut gains.axes {
        axis.components.retain(|part| components::find(&part.kind).is_some_and(is_gain));
    }
    let has_all = gains.axes.iter().all(|axis| !axis.components.is_empty());
    (has_all && gains != *blueprint).then_some(gains)
}

/// What it is made from.
pub(super) struct Asked<'a> {
    pub(super) logs: &'a [PathBuf],
    pub(super) inputs: &'a [String],
    pub(super) outputs: &'a [String],
    pub(super) options: &'a LogOptions,
    pub(super) drop: Option<f64>,
    /// What is said of the commands between the rows, and of the instants of the readings.
    pub(super) readings: (Option<Between>, Option<Reading>),
    /// The table of a frequency response, with the most modes that are fitted to it.
    pub(super) response: Option<(&'a Path, usize)>,
}

/// The linear model: fitted to the frequency response, or identified from the logs.
pub(super) fn identified(asked: &Asked<'_>, screen: &Screen) -> anyhow::Result<Generated> {
    match asked.response {
        Some((table, most)) => response::of_response(asked, table, most),
        None => of_logs(asked, screen),
    }
}

/// A plant that was identified, and what was found out.
type Found = (CheckedBlueprint, Identified);

/// The linear model identified from the logs: where nobody says how to read them, with the readings that leave least.
fn of_logs(asked: &Asked<'_>, screen: &Screen) -> anyhow::Result<Generated> {
    let of = |model: &str, readings: (Between, Reading), screen: &Screen| {
        let columns = (asked.inputs, asked.outputs);
        let parts = (asked.drop, diagnose::HELD_OUT);
        Identify::one_model(model, asked.logs, columns, asked.options, parts, readings)
            .plant(screen)
    };
    let (of, usual) = (&of, Between::with_reading(asked.readings.0, asked.readings.1));
    let others: &[(Between, Reading)] = match asked.readings {
        (None, None) => &[(Between::Zoh, Reading::After), (Between::Line, Reading::With)],
        _ => &[],
    };
    let quiet = Screen { quiet: true, ..*screen };
    let (linear, other, with_plays) = std::thread::scope(|scope| {
        let aside = |model, readings| scope.spawn(move || of(model, readings, &quiet));
        let other: Vec<_> = others.iter().map(|r| (*r, aside("linear", *r))).collect();
        let with_plays = aside("prandtl-ishlinskii", usual);
        let linear = of("linear", usual, screen);
        let other = other.into_iter().filter_map(|(r, found)| Some((r, found.join().ok()?.ok()?)));
        // Logs that suit no plays have none.
        (linear, other.collect::<Vec<_>>(), with_plays.join().ok().and_then(Result::ok))
    });
    let usual_one = linear.context(
        "without --model a linear one is identified from the logs first, and that failed",
    )?;
    let mut notes = Vec::new();
    let (readings, linear, with_plays) = match less(&usual_one.1, other) {
        None => (usual, usual_one, with_plays),
        Some((readings, found, times)) => {
            let words = |(between, reading): (Between, Reading)| {
                format!("the command {}, each reading {}", between.words(), reading.words())
            };
            notes.push(format!(
                "the logs are read with {}: with {} a linear model or one with plays would leave {times:.1} times as much \
                 (--between {} --reading {} says otherwise)",
                words(readings),
                words(usual),
                usual.0.name(),
                usual.1.name()
            ));
            (readings, found, of("prandtl-ishlinskii", readings, &quiet).ok())
        }
    };
    let mut blueprint = linear.0.blueprint().clone();
    notes.splice(0..0, linear.1.notes.iter().cloned());
    for (k, axis) in linear.1.axes.iter().enumerate() {
        let beside = with_plays.as_ref().and_then(|(plant, with)| {
            let found = with.axes.get(k)?;
            let is_better = left(found)? < Thresholds::WITH_PLAYS * left(axis)?;
            is_better.then_some((plant.blueprint(), found))
        });
        if let Some((plant, found)) = beside {
            let parts = &mut blueprint.axes[k].components;
            *parts = beside_plays(parts, &plant.axes[k].components, found);
            blueprint.step.clone_from(&plant.step);
            notes.push(format!(
                "{}: the error with plays is {:.2} times that of linear parts alone: delay, lag and mode of the linear model are those found together with plays, so that they do not imitate plays",
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
    let map = columns_of(asked, &|name: &String| names.column(name).unwrap_or(name).to_owned());
    let run_in = linear.1.run_in;
    let text = BlueprintText { text: blueprint.to_toml(), blueprint };
    Ok(Generated { text, baselines, notes, run_in, readings, map })
}

/// Of other readings the one with which the linear models, or those with plays, leave so much less that it is taken; and how
/// many times as much the usual ones leave.
fn less(
    usual: &Identified,
    others: Vec<((Between, Reading), Found)>,
) -> Option<((Between, Reading), Found, f64)> {
    let least = |axis: &AxisResult| {
        let all = axis.identification.candidates.iter().filter_map(|c| c.held_out_rmse);
        all.reduce(f64::min)
    };
    let part = |found: &Identified| -> Option<f64> {
        let axes = found.axes.iter().zip(&usual.axes);
        let parts = axes.map(|(own, usual)| Some((least(own)? / least(usual)?).powi(2)));
        let logs: Vec<f64> = parts.map(|part| part.map(f64::ln)).collect::<Option<_>>()?;
        Some((logs.iter().sum::<f64>() / logs.len().max(1) as f64).exp())
    };
    let mut all: Vec<_> =
        others.into_iter().filter_map(|(r, found)| Some((part(&found.1)?, r, found))).collect();
    all.retain(|(part, ..)| *part < diagnose::READING_LESS);
    let weight = |(part, (between, _), _): &(f64, (Between, Reading), Found)| match between {
        Between::Line => part / Thresholds::STRAIGHT,
        _ => *part,
    };
    let best = all.into_iter().min_by(|a, b| weight(a).total_cmp(&weight(b)))?;
    Some((best.1, best.2, (1.0 / best.0).sqrt()))
}

/// Which column of the logs belongs to which variable of the model.
fn columns_of(asked: &Asked<'_>, column: &dyn Fn(&String) -> String) -> Vec<String> {
    let columns = asked.inputs.iter().zip(asked.outputs).zip(1..);
    let pair = |((input, output), k): ((&String, &String), usize)| {
        [format!("command[{k}]={}", column(input)), format!("position[{k}]={}", column(output))]
    };
    columns.flat_map(pair).collect()
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
    let of = |effect: &Effect| {
        let own = |part: &&ComponentBlueprint| {
            let known = components::find(&part.kind);
            known.and_then(|c| c.declaration().effect).is_some_and(|e| e.name == effect.name)
        };
        with_plays.iter().find(own).cloned()
    };
    let deviation = |p: &identify::Estimate| p.deviation.map(|d| p.value > Thresholds::SEEN * d);
    let delay = found.identification.parameters.iter().find(|p| p.name == "delay.delay");
    let delay = of(&effects::DELAY).filter(|_| delay.and_then(deviation).unwrap_or(false));
    let is_gain = |part: &&ComponentBlueprint| components::find(&part.kind).is_some_and(is_gain);
    let gain = linear.iter().find(is_gain).cloned();
    let (lag, mode) = (of(&effects::AMPLIFIER_BANDWIDTH), of(&effects::EXTRA_MODE));
    [delay, lag, gain, mode].into_iter().flatten().collect()
}

/// Whether a component is an actuator of a gain and an offset, without memory.
fn is_gain(component: &dyn Component) -> bool {
    component.is_affine() && component.declaration().conversion == Conversion::CommandToPosition
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
            let order = if is_gain(&*node.component) { [0, 1] } else { [1, 0] };
            let deviation = order.iter().find_map(|k| {
                let all = &sources[*k].identification.parameters;
                let is_own = |p: &&identify::Estimate| {
                    p.name.rsplit('.').next() == Some(name)
                        && (p.value - value).abs() <= 1e-6 * value.abs()
                };
                all.iter().find(is_own)?.deviation
            });
            let relative = deviation.map_or(0.0, |d| Thresholds::ERRORS * d / value.abs());
            if value != 0.0 {
                part.tolerance.insert(name.to_owned(), relative.max(least_tolerance(name)));
            }
        }
    }
    Ok(())
}

/// The least tolerance of a parameter of this name.
fn least_tolerance(name: &str) -> f64 {
    if name == "damping" { Thresholds::LEAST_OF_DAMPING } else { Thresholds::LEAST }
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
    let names: Vec<&str> = linear.axes.iter().map(|axis| axis.name.as_str()).collect();
    let mut all = in_numbers(blueprint, &names)?;
    for (baseline, found) in all.iter_mut().zip(&linear.axes) {
        let taken = taken(found);
        baseline.nrmse = [taken.and_then(|c| c.fitted_nrmse), taken.and_then(|c| c.held_out_nrmse)];
    }
    Ok(all)
}

/// The models in numbers, without what they leave.
fn in_numbers(blueprint: &Blueprint, names: &[&str]) -> anyhow::Result<Vec<Baseline>> {
    let checked = blueprint.clone().check(learned::COMPONENTS)?;
    let axes = checked.spec().axes.iter().zip(&blueprint.axes).zip(names).enumerate();
    let all = axes.map(|(k, ((spec, given), output))| {
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
        let structure = kinds.join(", ");
        Baseline { output: (*output).to_owned(), structure, parameters, nrmse: [None; 2] }
    });
    Ok(all.collect())
}

/// Structure and parameters of a model.
fn numbers(baseline: &Baseline) -> String {
    let number = |x: f64| report::format_number(x, 4);
    let with_std = |std: Option<f64>| std.map_or(String::new(), |s| format!(" ± {}", number(s)));
    let parameters = baseline
        .parameters
        .iter()
        .map(|(name, p)| format!("{name} = {}{} {}", number(p.value), with_std(p.std), p.unit));
    format!("{} ({})", baseline.structure, parameters.collect::<Vec<_>>().join(", "))
}

fn sentence(baseline: &Baseline) -> String {
    let left = baseline.nrmse[1].map_or(String::new(), |part| {
        format!(
            "; the error of linear parts alone is {} % of the range on the other rows",
            report::format_number(100.0 * part, 4)
        )
    });
    format!(
        "{}: no --model was given; a linear one is identified from the first {:.0} % of the logs: {}{left}",
        baseline.output,
        100.0 * (1.0 - diagnose::HELD_OUT),
        numbers(baseline)
    )
}
