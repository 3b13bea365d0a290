//! A controller along a reference of the user's own: what it asks of each command, and what is left.

use data::CheckedBlueprint;
use identify::Error;
use serde::Serialize;

use crate::closed_loop::simulate_loop;
use crate::linearised::{setting, values};

/// A command counts as beyond a limit from this part of its range on.
const BEYOND: f64 = 1e-6;

/// One axis along a reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Along {
    /// Name of the axis.
    pub axis: String,
    /// Root mean square of reference less position, behind a preview by that much later, in parts of the reference's range.
    pub error: f64,
    /// The greatest of these differences, the same.
    pub greatest: f64,
    /// Least and greatest command that the feedforward asks for; `None` where there is no feedforward.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub asked: Option<(f64, f64)>,
    /// When it asks for them, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub asked_at: Option<(f64, f64)>,
    /// The command's bounds.
    pub limits: (f64, f64),
    /// Part of the time for which it asks for more than they allow: there no controller follows.
    pub beyond: f64,
}

/// By how many periods an axis of a controller follows its reference input late.
pub(crate) fn late(controller: &CheckedBlueprint, axis: usize) -> usize {
    let spec = controller.spec();
    let joined = spec.connections.couplings.iter().filter(|c| c.axes.contains(&axis));
    let nodes = joined.map(|c| &c.node).chain(&spec.axes[axis].components);
    let previews = nodes.filter(|node| node.enabled).filter_map(|node| {
        setting(node, "preview").or_else(|| values(node, "preview").first().copied())
    });
    (previews.sum::<f64>() / spec.period).round() as usize
}

/// Runs plant and controller along `references[axis][point]`, `period` s apart.
///
/// # Errors
/// [`Error::Model`] where the two do not fit together or one leaves its range.
pub fn along(
    plant: &CheckedBlueprint,
    controller: &CheckedBlueprint,
    references: &[Vec<f64>],
    period: f64,
) -> Result<Vec<Along>, Error> {
    let run = simulate_loop(plant, controller, references, period)?;
    let feeds = |axis: usize| {
        let nodes = &controller.spec().axes[axis].components;
        nodes.iter().any(|node| {
            node.component.declaration().conversion == model::Conversion::PositionToCommand
        })
    };
    let one = |(axis, reference): (usize, &Vec<f64>)| {
        let late = late(controller, axis);
        let errors =
            || reference.iter().zip(run.position[axis].iter().skip(late)).map(|(r, p)| r - p);
        let range = extent(reference).map_or(0.0, |(low, high)| reference[high] - reference[low]);
        let count = reference.len().max(1) as f64;
        let judged = reference.len().saturating_sub(late).max(1) as f64;
        let limits = controller.spec().axes[axis].command_range;
        let room = BEYOND * (limits.1 - limits.0);
        let asked = run.feedforward[axis].as_slice();
        let ends = extent(asked).filter(|_| feeds(axis));
        let is_beyond = |u: &&f64| **u < limits.0 - room || **u > limits.1 + room;
        let outside = if ends.is_some() { asked.iter().filter(is_beyond).count() } else { 0 };
        Along {
            axis: controller.spec().axes[axis].name.clone(),
            error: (errors().map(|e| e * e).sum::<f64>() / judged).sqrt() / range,
            greatest: errors().map(f64::abs).fold(0.0, f64::max) / range,
            asked: ends.map(|(low, high)| (asked[low], asked[high])),
            asked_at: ends.map(|(low, high)| (low as f64 * period, high as f64 * period)),
            limits,
            beyond: outside as f64 / count,
        }
    };
    Ok(references.iter().enumerate().map(one).collect())
}

/// Where the least and the greatest of these are.
fn extent(values: &[f64]) -> Option<(usize, usize)> {
    let by = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
    Some(((0..values.len()).min_by(by)?, (0..values.len()).max_by(by)?))
}
