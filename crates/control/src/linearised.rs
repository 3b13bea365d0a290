//! The plant as its controller sees it: hysteresis replaced by its steepest slope, sampled with the
//! controller's hold.

use components::actuator::ACTUATOR_GAIN;
use components::hysteresis::play::Plays;
use model::{AxisSpec, ComponentRef, Connections, Conversion, Kind, NodeSpec, System, SystemSpec};

use super::learned_axis::LearnedAxis;

/// Longest step response that is simulated, in samples.
const LONGEST: usize = 1 << 17;
/// Shortest.
const SHORTEST: usize = 1 << 6;
/// Largest change over the second half of a step response that has settled, relative to its end.
const SETTLED: f64 = 1e-3;

/// What one axis of a plant is made of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Actuation {
    /// Plays, or a straight line.
    Operator(Operator),
    /// A learned hysteresis.
    Learned(Box<LearnedAxis>),
}

impl Actuation {
    /// The steepest slope in position per command.
    pub(crate) fn slope(&self) -> f64 {
        match self {
            Self::Operator(operator) => operator.slope(),
            Self::Learned(learned) => learned.slope,
        }
    }

    /// The same of the actuator alone, without the gains of other components.
    fn own_slope(&self) -> f64 {
        match self {
            Self::Operator(operator) => operator.own_slope,
            Self::Learned(learned) => learned.own_slope,
        }
    }

    /// Position at rest under this command, after a monotonic move from the virgin state.
    pub(crate) fn at_rest(&self, command: f64) -> f64 {
        match self {
            Self::Operator(operator) => operator.at_rest(command),
            Self::Learned(learned) => learned.at_rest(command),
        }
    }

    /// Positions at the two bounds of the command, each after the other was visited.
    pub(crate) fn reach(&self, bounds: (f64, f64)) -> (f64, f64) {
        match self {
            Self::Operator(operator) => operator.reach(bounds),
            Self::Learned(learned) => learned.reach,
        }
    }

    /// Modes that a learned linear part has.
    pub(crate) fn modes(&self) -> Vec<(f64, f64)> {
        match self {
            Self::Operator(_) => Vec::new(),
            Self::Learned(learned) => learned.modes(),
        }
    }
}

/// Plays, or a straight line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Operator {
    /// Thresholds of the whole axis at rest, in the command's unit; one 0 for a linear actuator.
    pub(crate) r: Vec<f64>,
    /// Weights of the whole axis at rest, in position per command.
    pub(crate) w: Vec<f64>,
    /// Position at zero command in the virgin state.
    pub(crate) offset: f64,
    /// Whether the actuator is linear.
    pub(crate) linear: bool,
    /// Steepest slope of the actuator alone.
    own_slope: f64,
}

impl Operator {
    /// The steepest slope: all plays moving.
    pub(crate) fn slope(&self) -> f64 {
        self.w.iter().sum()
    }

    fn at_rest(&self, command: f64) -> f64 {
        let plays = self.r.iter().zip(&self.w);
        let sum: f64 =
            plays.map(|(r, w)| w * command.signum() * (command.abs() - r).max(0.0)).sum();
        self.offset + sum
    }

    fn reach(&self, (low, high): (f64, f64)) -> (f64, f64) {
        let plays = Plays { r: &self.r, w: &self.w };
        let mut state = vec![0.0; self.r.len()];
        plays.rest(low, &mut state);
        let top = plays.step(high, &mut state);
        let bottom = plays.step(low, &mut state);
        (self.offset + bottom, self.offset + top)
    }
}

/// The actuation of an axis, with the gains of the linear components before and behind the actuator
/// put into its weights and thresholds: `g P_r[a u] = g a P_{r/a}[u]` for a > 0.
///
/// # Errors
/// Every reason why the axis has no inverse.
pub(crate) fn operator(axis: &AxisSpec) -> Result<Operator, Vec<String>> {
    let Some(at) = actuator_of(axis) else {
        return Err(vec![
            "no component turns its command into a position; add a hysteresis model".to_owned(),
        ]);
    };
    let (before, after) = (&axis.components[..at], &axis.components[at + 1..]);
    let (first, last) = (product_of_gains(before), product_of_gains(after));
    let node = &axis.components[at];
    let (mut r, mut w, offset, linear) = match node.component.declaration().kind {
        "prandtl-ishlinskii" => {
            (values(node, "r"), values(node, "w"), values(node, "offset"), false)
        }
        "actuator-gain" => (vec![0.0], values(node, "gain"), values(node, "offset"), true),
        other => {
            return Err(vec![format!(
                "{} is a {other}, for which there is no inverse here; use prandtl-ishlinskii, \
                 lssvm-stops or actuator-gain",
                node.name
            )]);
        }
    };
    let own_slope = w.iter().sum();
    for r in &mut r {
        *r /= first;
    }
    for w in &mut w {
        *w *= first * last;
    }
    let offset = last * offset.first().copied().unwrap_or(0.0);
    let found = Operator { r, w, offset, linear, own_slope };
    let reasons = obstacles(&found, first, &node.name);
    if reasons.is_empty() { Ok(found) } else { Err(reasons) }
}

fn obstacles(found: &Operator, first: f64, name: &str) -> Vec<String> {
    let mut reasons = Vec::new();
    if !(first.is_finite() && first > 0.0) {
        reasons.push(format!(
            "the gain before {name} is {first}, and a model with plays is turned round only by a \
             positive one; give the amplifier a positive gain"
        ));
    }
    if !found.linear && found.r.first().is_none_or(|r| *r != 0.0) {
        reasons.push(format!(
            "{name}.r[1] = {} is above 0: a small motion of the command moves nothing, so there is \
             no inverse; identify the plant with a first threshold of 0",
            found.r.first().copied().unwrap_or(f64::NAN)
        ));
    }
    if !found.linear && found.w.first().is_none_or(|w| *w <= 0.0) {
        reasons.push(format!(
            "{name}.w[1] = {} is not above 0, so there is no inverse; identify the plant with a \
             least slope above 0",
            found.w.first().copied().unwrap_or(f64::NAN)
        ));
    }
    if found.w.iter().skip(1).any(|w| *w < 0.0) {
        reasons.push(format!("{name} has a negative weight; weights are zero or positive"));
    }
    if found.linear && found.w.first().is_none_or(|w| *w == 0.0) {
        reasons
            .push(format!("{name}.gain is 0: the command moves nothing; give the actuator's gain"));
    }
    reasons
}

pub(crate) fn actuator_of(axis: &AxisSpec) -> Option<usize> {
    let is_actuator =
        |node: &NodeSpec| node.component.declaration().conversion == Conversion::CommandToPosition;
    axis.components.iter().position(is_actuator)
}

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

/// The axis with its actuator replaced by its steepest slope, and the frequencies of its modes
/// multiplied by `shift`.
pub(crate) fn linear_axis(axis: &AxisSpec, actuation: &Actuation, shift: f64) -> AxisSpec {
    let mut linear = axis.clone();
    linear.start = 0.0;
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    (linear.command_range, linear.position_range) = (free, free);
    linear.aliases = Vec::new();
    for node in &mut linear.components {
        let declaration = node.component.declaration();
        match declaration.kind {
            _ if declaration.conversion == Conversion::CommandToPosition => {
                node.component = ComponentRef::Static(&ACTUATOR_GAIN);
                node.structure = Vec::new();
                node.values = vec![actuation.own_slope(), 0.0];
            }
            // The frequency is the mode's first parameter.
            "mode" => {
                if let Some(frequency) = node.values.first_mut() {
                    *frequency *= shift;
                }
            }
            _ => {}
        }
    }
    linear
}

/// Frequencies of the modes of an axis in Hz, with their damping ratios.
pub(crate) fn modes(axis: &AxisSpec) -> Vec<(f64, f64)> {
    let nodes = axis.components.iter().filter(|n| n.enabled);
    let modes = nodes.filter(|n| n.component.declaration().kind == "mode");
    modes
        .filter_map(|n| Some((*values(n, "frequency").first()?, *values(n, "damping").first()?)))
        .collect()
}

/// Time constants of the first-order lags of an axis in s.
pub(crate) fn lags(axis: &AxisSpec) -> Vec<f64> {
    let nodes = axis.components.iter().filter(|n| n.enabled);
    let lags = nodes.filter(|n| n.component.declaration().kind.ends_with("-lag"));
    lags.filter_map(|n| values(n, "bandwidth").first().map(|b| 1.0 / (core::f64::consts::TAU * b)))
        .collect()
}

/// Delays of the axis in s.
pub(crate) fn delays(axis: &AxisSpec) -> Vec<f64> {
    let nodes = axis.components.iter().filter(|n| n.enabled);
    let delays = nodes.filter(|n| n.component.declaration().kind == "delay");
    delays.filter_map(|n| values(n, "delay").first().copied()).collect()
}

/// The impulse response h_1, h_2, … of a linear axis from a command held over `period` to the
/// position at the end of that period and of the following ones.
///
/// # Errors
/// Why it cannot be had, and the way out.
pub(crate) fn impulse_response(axis: AxisSpec, step: f64, period: f64) -> Result<Vec<f64>, String> {
    let spec = SystemSpec {
        name: "linear".to_owned(),
        kind: Kind::Plant,
        period: step,
        axes: vec![axis],
        connections: Connections::default(),
    };
    let mut system = System::new(&spec)
        .map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))?;
    let variable =
        |name: &str| system.variables().find(name).ok_or_else(|| format!("has no {name}"));
    let (command, position) = (variable("command[1]")?, variable("position[1]")?);
    system.initialise(0.0).map_err(|e| system.explain(&e))?;
    system.set(command, 1.0).map_err(|e| system.explain_set(&e))?;
    let mut response: Vec<f64> = Vec::new();
    let mut length = SHORTEST;
    while length <= LONGEST {
        while response.len() < length {
            let time = (response.len() + 1) as f64 * period;
            system.advance(time).map_err(|e| system.explain(&e))?;
            response.push(system.get(position).unwrap_or(f64::NAN));
        }
        if settled(&response) {
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

fn settled(response: &[f64]) -> bool {
    let end = response.last().copied().unwrap_or(0.0);
    let late = &response[response.len() / 2..];
    end != 0.0 && late.iter().all(|y| (y - end).abs() <= SETTLED * end.abs())
}
