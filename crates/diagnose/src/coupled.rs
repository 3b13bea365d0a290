//! Axes that static couplings join: the motion of each axis, worked out of the readings of all of them.
//!
//! Behind the axes' motions m stand couplings without memory and one and the same linear filter F on every axis, so
//! that the readings are `y = F(A·m + b)`. Then `A⁻¹·(y − F(b)) = F(m)`: each axis shows alone, and an effect in it
//! is found from all readings at once.

mod together;

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use data::CheckedBlueprint;
use model::CouplingSpec;
use surround::Span;

pub(crate) use self::together::together;
use crate::axis_group::Group;
use crate::base::coupling::{is_sum, motion_text, motion_unit, refused};
use crate::base::{Base, Part};
use crate::candidate::has_gap;
use crate::chain::{Bench, Horizon};
use crate::data_set::Auxiliary;
use crate::error::Error;
use crate::fit::Fitter;
use crate::outcome::Outcome;
use crate::port::Port;
use crate::request::Request;
use crate::score::mean_square;
use crate::stages;
use crate::tap;
use crate::task::{Coupled, Task, assemble};

/// The groups of axes that couplings join, in which one is chosen.
///
/// # Errors
/// [`Error::Joined`]: couplings that cannot be inverted, and why.
fn groups(blueprint: &CheckedBlueprint, chosen: &[usize]) -> Result<Vec<Group>, Error> {
    let joins = |c: &&CouplingSpec| c.node.enabled && c.axes.len() > 1;
    let couplings = || blueprint.spec().connections.couplings.iter().filter(joins);
    let group = |axes: Vec<usize>| {
        let own: Vec<&CouplingSpec> =
            couplings().filter(|c| c.axes.iter().any(|axis| axes.contains(axis))).collect();
        let names: Vec<&str> = own.iter().map(|c| c.node.name.as_str()).collect();
        match Group::of(blueprint, axes, &own) {
            Ok(group) => Ok(Some(group)),
            // Not inverted: each reading is looked at as the sum of what all axes give.
            Err(_) if own.iter().all(|c| is_sum(blueprint, c).is_ok()) => Ok(None),
            Err(reason) => {
                let no_sum = own.iter().find_map(|c| is_sum(blueprint, c).err());
                let reason = no_sum.map_or(reason.clone(), |also| format!("{reason}; {also}"));
                Err(refused(blueprint, &names.join(", "), &reason))
            }
        }
    };
    let is_chosen =
        |axes: &Vec<usize>| axes.len() > 1 && axes.iter().any(|axis| chosen.contains(axis));
    let all = blueprint.coupled_axes().into_iter().filter(is_chosen).map(group);
    all.filter_map(Result::transpose).collect()
}

/// What is said of a monitor in the path of a coupled axis.
pub(crate) fn not_cut(monitor: &str) -> String {
    format!("the column {monitor} is not used: coupled axes are not cut at a monitor")
}

/// The tasks of the axes that couplings join: their motions, worked out of the readings of all of them.
///
/// # Errors
/// [`Error`]: couplings that cannot be inverted, or a log without a column for one of their outputs.
pub(crate) fn tasks(
    request: &Request,
    blueprint: &CheckedBlueprint,
    (inputs, outputs): (&[Port], &[Port]),
    chosen: &[usize],
) -> Result<Vec<Task>, Error> {
    let mut all = Vec::new();
    for group in groups(blueprint, chosen)? {
        let own: Vec<usize> =
            group.axes.iter().copied().filter(|axis| chosen.contains(axis)).collect();
        let mut ports = outputs.to_vec();
        for axis in &group.axes {
            ports[*axis] = Port {
                name: format!("motion[{}]", axis + 1),
                alias: None,
                unit: motion_text(blueprint, *axis).to_owned(),
                si: motion_unit(blueprint, *axis),
                ..outputs[*axis].clone()
            };
        }
        let mut with = request.clone();
        group.add_motions(&mut with, outputs, &ports)?;
        let (step, first) = (Some(blueprint.spec().period), all.len());
        let gain = request.gain_tolerance;
        let mut unused = Vec::new();
        for index in own {
            unused.extend(tap::monitor(request, &inputs[index]).map(|m| not_cut(&m)));
            let base =
                Base::white(blueprint, (index + 1, Part::Motion), &request.tolerances, gain)?;
            all.push(assemble(&with, inputs, &ports, index, index, base, step)?);
        }
        let labels: Vec<&str> = group.axes.iter().map(|axis| outputs[*axis].label()).collect();
        all[first].warnings.push(format!(
            "the axes are coupled ({}): each is judged by its motion in front of that, motion[k], worked out of {} \
             (condition number {:.3}); an effect of a single sensor shows in several motions",
            group.couplings.join(", "),
            labels.join(", "),
            group.condition
        ));
        all[first].warnings.append(&mut unused);
        if all.len() - first == group.axes.len() {
            let reading = |index: &usize| {
                let from = blueprint.spec().axes[*index].components.len();
                let base = Base::reading(from, gain);
                assemble(request, inputs, outputs, *index, *index, base, step)
            };
            let readings = group.axes.iter().map(reading).collect::<Result<_, _>>()?;
            let coupled = Arc::new(Coupled { group, readings });
            all[first..].iter_mut().for_each(|p| p.coupled = Some(Arc::clone(&coupled)));
        }
    }
    Ok(all)
}

/// Where something is left of the motions of a group, looks for it behind the couplings too: in the reading of each
/// axis under the positions that the model gives. The answers that leave less of all readings stay, for as many
/// parameters as they need.
///
/// # Errors
/// [`Error::Model`]: a model that cannot be simulated over the logs.
pub(crate) fn in_readings(
    outcomes: &mut Vec<Outcome>,
    request: &Request,
    count: &AtomicU64,
) -> Result<(), Error> {
    let mut first = 0;
    while first < outcomes.len() {
        let Some(coupled) = outcomes[first].task.coupled.clone() else {
            first += 1;
            continue;
        };
        let members = first..first + coupled.group.axes.len();
        first = members.end;
        let motions = &outcomes[members.clone()];
        if motions.iter().all(|o| !has_gap(&o.found.base, o.adequate)) {
            continue;
        }
        let mut readings = coupled.readings(motions, request, count)?;
        // Without a name there it is no better place to show what is left.
        let has_one = readings.iter().any(|o| !o.found.last.picks.is_empty());
        if has_one && cost_of_readings(&readings) < coupled.cost_of_motions(motions, &readings) {
            let known_warnings = motions.iter().flat_map(|o| o.task.warnings.clone());
            let couplings = coupled.group.couplings.join(", ");
            let why = format!(
                "the gap lies behind the coupling ({couplings}): changes of single readings explain all readings \
                 better than changes of the motions in front of it"
            );
            let known_warnings: Vec<String> = known_warnings.chain([why]).collect();
            readings[0].task.warnings.extend(known_warnings);
            outcomes.splice(members, readings);
        }
    }
    Ok(())
}

impl Coupled {
    /// The readings under the positions that the model as it came gives.
    fn readings(
        &self,
        motions: &[Outcome],
        request: &Request,
        count: &AtomicU64,
    ) -> Result<Vec<Outcome>, Error> {
        let moved = |o: &Outcome| {
            let chain = &o.found.base.chain;
            let mut bench = Bench::new(chain, &o.task.data, Horizon::All, count);
            let given = vec![0.0; chain.parameters.len()];
            bench.keep(&given).ok().map(<[f64]>::to_vec)
        };
        let Some(moved) = motions.iter().map(moved).collect::<Option<Vec<_>>>() else {
            return Ok(Vec::new());
        };
        let mut all = Vec::with_capacity(self.readings.len());
        for (i, reading) in self.readings.iter().enumerate() {
            let mut task = reading.clone();
            task.course = motions[i].task.course;
            let data = &mut task.data;
            for (hit, command) in data.command.iter_mut().enumerate() {
                let sum = moved.iter().enumerate().map(|(j, m)| self.group.matrix[(i, j)] * m[hit]);
                *command = self.group.at_zero[i] + sum.sum::<f64>();
            }
            data.command_span = Span::of(data.command.iter().copied());
            let others = moved.iter().enumerate().filter(|(j, _)| *j != i);
            data.aux = others
                .map(|(j, m)| Auxiliary {
                    name: motions[j].task.output.clone(),
                    is_command: true,
                    hits: m.clone(),
                    span: Span::of(m.iter().copied()),
                })
                .collect();
            task.input = format!("{} of the model", task.output);
            task.command_unit.clone_from(&task.unit);
            task.command_factor = task.factor;
            all.push(stages::of(task, request, count)?);
        }
        Ok(all)
    }

    /// What the answers of the motions leave of the readings and need for it, in twice the logarithm of a likelihood.
    fn cost_of_motions(&self, motions: &[Outcome], readings: &[Outcome]) -> f64 {
        let left = |(i, reading): (usize, &Outcome)| {
            let rows = reading.task.data.y.len();
            let at = |row: usize| {
                let own = motions.iter().enumerate();
                let sum = own.map(|(j, o)| {
                    self.group.matrix[(i, j)] * o.sigma * o.found.last.judged.residual[row]
                });
                (sum.sum::<f64>() / reading.sigma).powi(2)
            };
            let square = (0..rows).map(at).sum::<f64>() / rows.max(1) as f64;
            effective(reading) * square.max(1.0).ln()
        };
        readings.iter().enumerate().map(left).sum::<f64>() + motions.iter().map(needed).sum::<f64>()
    }
}

/// What the answers of the readings leave of them and need for it, in twice the logarithm of a likelihood.
fn cost_of_readings(readings: &[Outcome]) -> f64 {
    let left = |o: &Outcome| {
        let square = mean_square(&o.found.last.judged.residual);
        effective(o) * square.max(1.0).ln()
    };
    readings.iter().map(|o| left(o) + needed(o)).sum()
}

fn effective(o: &Outcome) -> f64 {
    let count = AtomicU64::new(0);
    Fitter { data: &o.task.data, sigma: o.sigma, count: &count, weights: None }.effective()
}

/// What the parameters of an answer count.
fn needed(o: &Outcome) -> f64 {
    let records = o.task.data.records.len();
    let picks = o.found.last.picks.iter();
    let all = picks.map(|(family, k)| o.library[*family].formulas[*k].freedom(records));
    all.sum::<usize>() as f64 * effective(o).ln()
}
