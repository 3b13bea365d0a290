//! The linear parts of an axis with the hysteresis at its steepest slope, sampled with the controller's hold.

use model::{AxisSpec, NodeSpec, Role};

use crate::probe::{Probe, straight};

/// Damping ratio below which a mode is light.
pub(crate) const LIGHT: f64 = 0.5;
/// Longest step response that is simulated, in samples.
const LONGEST: usize = 1 << 17;
/// Shortest.
const SHORTEST: usize = 1 << 6;
/// Largest change over the second half of a step response that has settled, relative to its end; of the longest
/// one.
const SETTLED: (f64, f64) = (1e-3, 2e-2);

/// The product of the static gains of linear components.
pub(crate) fn product_of_gains(nodes: &[NodeSpec]) -> f64 {
    nodes.iter().map(gain_of).product()
}

/// The static gain of a linear component: its parameter `gain`, else 1.
fn gain_of(node: &NodeSpec) -> f64 {
    if !node.enabled {
        return 1.0;
    }
    values(node, "gain").first().copied().unwrap_or(1.0)
}

/// The values of a parameter of a node; empty where it has none of this name.
pub(crate) fn values(node: &NodeSpec, name: &str) -> Vec<f64> {
    let declaration = node.component.declaration();
    let Some(index) = declaration.parameters.iter().position(|q| q.name == name) else {
        return Vec::new();
    };
    let start: usize = (0..index).map(|i| declaration.length(i, &node.structure)).sum();
    let end = start + declaration.length(index, &node.structure);
    node.values.get(start..end).map(<[f64]>::to_vec).unwrap_or_default()
}

/// The values of the first parameter of a node with this role; empty where it has none.
pub(crate) fn values_of(node: &NodeSpec, role: Role) -> &[f64] {
    let declaration = node.component.declaration();
    declaration.values_of(role, &node.structure, &node.values).unwrap_or_default()
}

/// The value of a structural setting of a node.
pub(crate) fn setting(node: &NodeSpec, name: &str) -> Option<f64> {
    let declared = node.component.declaration().structure;
    let at = declared.iter().position(|setting| setting.name == name)?;
    node.structure.get(at).copied()
}

/// A discrete linear part with a sample time of its own: b, a.
pub(crate) fn is_discrete(node: &NodeSpec) -> bool {
    setting(node, "sample_time").is_some() && !values(node, "b").is_empty()
}

/// Frequencies of the modes among linear parts in Hz, with their damping ratios.
pub(crate) fn modes(nodes: &[NodeSpec]) -> Vec<(f64, f64)> {
    let mode =
        |n: &NodeSpec| Some((*values(n, "frequency").first()?, *values(n, "damping").first()?));
    nodes.iter().filter_map(mode).filter(|(_, damping)| *damping < 1.0).collect()
}

/// The linear parts with the frequencies of their modes multiplied by `shift`.
pub(crate) fn shifted(nodes: &[NodeSpec], shift: f64) -> Vec<NodeSpec> {
    let mut nodes = nodes.to_vec();
    for node in nodes.iter_mut().filter(|node| !values(node, "damping").is_empty()) {
        multiply(node, "frequency", |value| value * shift);
    }
    nodes
}

/// The linear parts with the frequencies of all their modes and the damping of the light ones multiplied.
pub(crate) fn varied(nodes: &[NodeSpec], shift: f64, damping: f64) -> Vec<NodeSpec> {
    let mut nodes = shifted(nodes, shift);
    for node in &mut nodes {
        multiply(node, "second_frequency", |value| value * shift);
        for name in ["damping", "second_damping"] {
            multiply(node, name, |value| if value < LIGHT { value * damping } else { value });
        }
    }
    nodes
}

/// Changes the values of a parameter, where a node has it.
fn multiply(node: &mut NodeSpec, name: &str, change: impl Fn(f64) -> f64) {
    let declaration = node.component.declaration();
    let at = declaration.parameters.iter().position(|q| q.name == name);
    let Some(index) = at else { return };
    let start: usize = (0..index).map(|i| declaration.length(i, &node.structure)).sum();
    let count = declaration.length(index, &node.structure);
    for value in node.values.iter_mut().skip(start).take(count) {
        *value = change(*value);
    }
}

/// The impulse response h_1, h_2, … of linear parts behind a gain, from a command held over a period to the
/// position at the end of that period and of the following ones.
///
/// # Errors
/// Why it cannot be had, and the way out.
pub(crate) fn impulse_response(
    axis: &AxisSpec,
    linear: &[NodeSpec],
    slope: f64,
    times: (f64, f64),
) -> Result<Vec<f64>, String> {
    let nodes: Vec<NodeSpec> =
        std::iter::once(straight(slope)).chain(linear.iter().cloned()).collect();
    let mut probe = Probe::new(axis, &nodes, false, times)?;
    // Small, for parts that are linear for small motions only.
    let size = small(axis);
    let rest = probe.rest(0.0)?;
    settled_impulse(times.1, || Ok((probe.step(size)? - rest) / size))
}

/// A command that is small.
pub(crate) fn small(axis: &AxisSpec) -> f64 {
    let width = axis.command_range.1 - axis.command_range.0;
    if width.is_finite() && width > 0.0 { 1e-3 * width } else { 1.0 }
}

/// The differences of a step response, as far as it settles.
///
/// # Errors
/// That it does not, and the way out; what the machine says.
pub(crate) fn settled_impulse(
    period: f64,
    mut next: impl FnMut() -> Result<f64, String>,
) -> Result<Vec<f64>, String> {
    let mut response: Vec<f64> = Vec::new();
    let mut length = SHORTEST;
    while length <= LONGEST {
        while response.len() < length {
            response.push(next()?);
        }
        let most = if length == LONGEST { SETTLED.1 } else { SETTLED.0 };
        if settled(&response, most) {
            let before = std::iter::once(&0.0).chain(&response);
            return Ok(response.iter().zip(before).map(|(now, before)| now - before).collect());
        }
        length *= 2;
    }
    Err(format!(
        "its response to a step of the command has not settled after {} s; raise the damping, or \
         give the controller a longer period",
        LONGEST as f64 * period
    ))
}

fn settled(response: &[f64], most: f64) -> bool {
    let end = response.last().copied().unwrap_or(0.0);
    let late = &response[response.len() / 2..];
    end != 0.0 && late.iter().all(|y| (y - end).abs() <= most * end.abs())
}

/// What makes up for linear parts to second order in the frequency, 1/G ≈ 1 + lag·s + inertia·s², from the
/// moments of their impulse response.
pub(crate) fn lead_of(impulse: &[f64], period: f64) -> (f64, f64) {
    let sum: f64 = impulse.iter().sum();
    let moment = |power: i32| -> f64 {
        let each = impulse.iter().zip(1..).map(|(h, k)| h * (f64::from(k) * period).powi(power));
        each.sum::<f64>() / sum
    };
    let first = moment(1);
    (first, first * first - 0.5 * moment(2))
}
