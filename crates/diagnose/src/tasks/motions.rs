//! The tasks of axes that static couplings join: their motions.

use std::sync::Arc;

use data::CheckedBlueprint;
use model::CouplingSpec;

use crate::axis_group::Group;
use crate::base::coupling::{is_sum, motion_text, motion_unit, refused};
use crate::base::{Base, Part};
use crate::error::Error;
use crate::port::Port;
use crate::request::Request;
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
pub(super) fn not_cut(monitor: &str) -> String {
    format!("the column {monitor} is not used: coupled axes are not cut at a monitor")
}

/// The tasks of the axes that couplings join: their motions, worked out of the readings of all of them.
///
/// # Errors
/// [`Error`]: couplings that cannot be inverted, or a log without a column for one of their outputs.
pub(super) fn tasks(
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
