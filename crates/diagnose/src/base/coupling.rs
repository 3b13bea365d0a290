//! Couplings as the chain of one of their axes has them.

use data::CheckedBlueprint;
use model::{ComponentRef, CouplingSpec, NodeSpec, TransferPath, Unit};

use super::{Base, Part, Standing};
use crate::chain::{ComponentNode, Front, Joint, OtherWay};
use crate::error::Error;

/// The couplings that act on this axis: components of it in a section of their own. Those of several axes stand behind a
/// motion or a front, which is then what is looked at.
pub(super) fn couplings_of(
    blueprint: &CheckedBlueprint,
    (number, part): (usize, Part),
) -> Vec<(Standing, &NodeSpec, &data::ComponentBlueprint)> {
    let spec = blueprint.spec();
    let mut all = Vec::new();
    let couplings = spec.connections.couplings.iter().zip(&blueprint.blueprint().couplings);
    for (k, (coupling, given)) in couplings.enumerate() {
        let is_of_several = coupling.axes.len() > 1;
        if !coupling.axes.contains(&(number - 1))
            || (is_of_several && (part != Part::Axis || !coupling.node.enabled))
        {
            continue;
        }
        let place = blueprint.before_coupling(coupling, number - 1);
        let standing = Standing { place, coupling: Some(k) };
        all.push((standing, &coupling.node, &given.component));
    }
    all
}

/// Whether the axes of a coupling can be looked at as sums of ways: it is the only one of each.
///
/// # Errors
/// Why they cannot.
pub(crate) fn is_sum(blueprint: &CheckedBlueprint, coupling: &CouplingSpec) -> Result<(), String> {
    let couplings = blueprint.spec().connections.couplings.iter();
    let touches = |c: &&CouplingSpec| {
        c.node.enabled && c.axes.iter().any(|axis| coupling.axes.contains(axis))
    };
    if couplings.filter(touches).count() > 1 {
        return Err("another coupling acts on the same axes".to_owned());
    }
    match way(&coupling.node, 0, 1) {
        Some(_) => Ok(()),
        None => Err(format!("{} is no sum of linear ways", coupling.node.name)),
    }
}

fn way(node: &NodeSpec, to: usize, from: usize) -> Option<TransferPath> {
    node.component.way(&node.structure, to, from)
}

/// How a coupling with these values in SI acts on axis number `axis`, the other axes as the blueprint has them.
///
/// # Errors
/// [`Error`]: a coupling that is no sum, or an axis that reads other signals than its own.
pub(super) fn joint(
    blueprint: &CheckedBlueprint,
    (number, axis): (usize, usize),
    values: &[f64],
) -> Result<Joint, Error> {
    let coupling = &blueprint.spec().connections.couplings[number];
    let refused = |reason: &str| refused(blueprint, &coupling.node.name, reason);
    is_sum(blueprint, coupling).map_err(|reason| refused(&reason))?;
    let place_in = |axis: usize| coupling.axes.iter().position(|own| *own == axis);
    let no_way = || refused("it has no way from one of its axes to another");
    let to = place_in(axis).ok_or_else(no_way)?;
    let node = |from: usize| -> Result<(ComponentNode, Vec<usize>), Error> {
        let TransferPath { component, structure, takes } =
            way(&coupling.node, to, from).ok_or_else(no_way)?;
        let values = takes.iter().map(|k| values[*k]).collect();
        let component = ComponentRef::Static(component);
        Ok((ComponentNode::new(component, structure, values), takes))
    };
    let own = node(to)?;
    let mut others = Vec::new();
    for (from, other) in coupling.axes.iter().enumerate().filter(|(from, _)| *from != to) {
        let (way, takes) = node(from)?;
        let front = Base::white(blueprint, (other + 1, Part::Front(number)), &[], 1.0)?;
        let chain = front.compose(&[]);
        let theta = vec![0.0; chain.parameters.len()];
        let front = Front::new(chain, theta);
        let place = if *other < axis { *other } else { *other - 1 };
        others.push((OtherWay { axis: *other, place, front, way }, takes));
    }
    Ok(Joint::of(number, own, others))
}

/// That coupled axes are not looked at one by one.
pub(crate) fn refused(blueprint: &CheckedBlueprint, coupling: &str, reason: &str) -> Error {
    Error::Joined {
        model: blueprint.spec().name.clone(),
        reason: format!("couples its axes (coupling {coupling}), and {reason}"),
    }
}

/// The unit of an axis' motion in front of its couplings.
pub(crate) fn motion_unit(blueprint: &CheckedBlueprint, axis: usize) -> Unit {
    Unit::parse(motion_text(blueprint, axis)).unwrap_or(Unit::ONE)
}

/// The text of that unit.
pub(crate) fn motion_text(blueprint: &CheckedBlueprint, axis: usize) -> &str {
    let spec = blueprint.spec();
    let own = spec.connections.motion_units.get(axis).and_then(Option::as_deref);
    own.unwrap_or(&spec.axes[axis].position_unit)
}
