//! One axis as its controller sees it: maps without memory, an actuator, linear parts, and what nothing but
//! feedback acts against. What a component is, is found out by running it.

use components::effects;
use model::{AxisSpec, NodeSpec};
use numerics::random::SplitMix64;

use crate::curve::Curve;
use crate::probe::{Probe, is_actuator};

/// Inputs of one trial.
const TRIAL: usize = 64;
/// Part of the height by which a sum of answers may differ from the answer to the sum, and an answer from that
/// at rest.
const SAME: (f64, f64) = (1e-6, 1e-4);
/// Parts of the range over which a component is tried: all of it, and little.
const SWINGS: [f64; 2] = [0.25, 1e-4];
/// A small step of the actuator in parts of its range, and the part of it that is there after one sample where it
/// answers at once.
const SMALL: f64 = 0.05;
const AT_ONCE: f64 = 0.9;
/// Where a command that shows slopes turns round, as parts of its range.
const TURNS: [f64; 11] = [0.0, 1.0, 0.0, 1.0, 0.0, 0.8, 0.2, 0.6, 0.4, 1.0, 0.0];
/// Least and most steps over the whole range, and steps in a chord's.
const STEPS: (usize, usize, usize) = (200, 2000, 20);
/// Part of the steps over the range for which a position in stairs stands still, and a stair over the mean step.
const STILL: f64 = 0.3;
const JUMP: f64 = 1.4;
/// Most inner steps of all ways: some seconds of work.
const MOST_STEPS: f64 = 1e8;
/// Time of one way over the range in s.
pub(crate) const WAY: f64 = 0.5;

/// Steps of one way: as fine as the samples, within bounds.
pub(crate) fn steps_of(way: f64, period: f64) -> usize {
    ((way / period).round() as usize).clamp(STEPS.0, STEPS.1)
}

/// What a component does to the path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Nature {
    /// A map without memory.
    Static,
    /// Linear, with memory.
    Linear,
    /// Linear and slow: it is undone by itself, or left to feedback.
    Creep,
    /// Not linear, with memory, or moving by itself.
    Left,
}

/// A component beside the actuator.
#[derive(Clone)]
pub(crate) struct Part {
    pub(crate) node: NodeSpec,
    pub(crate) nature: Nature,
    /// Least and greatest value in front of it.
    pub(crate) range: [f64; 2],
}

/// One axis, taken apart.
#[derive(Clone)]
pub(crate) struct Path {
    pub(crate) axis: AxisSpec,
    pub(crate) before: Vec<Part>,
    pub(crate) actuator: NodeSpec,
    pub(crate) after: Vec<Part>,
    /// Least and greatest command of the actuator.
    pub(crate) bounds: [f64; 2],
    /// From the command to the actuator at rest, and from there to the position; creep left out.
    pub(crate) maps: [Curve; 2],
    /// What the axis does at rest, command by command.
    pub(crate) sweep: Sweep,
    /// The actuator's own impulse response to a small step, of sum 1; [1] where it answers at once.
    pub(crate) own: Vec<f64>,
    /// What is left to feedback, and what it costs.
    pub(crate) left: Vec<String>,
    pub(crate) times: (f64, f64),
}

/// A slow run over the range.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sweep {
    pub(crate) command: Vec<f64>,
    pub(crate) position: Vec<f64>,
    /// Steepest chord, with the sign of the mean one.
    pub(crate) slope: f64,
    /// Flattest chord, the same.
    pub(crate) least_slope: f64,
    /// From end to end.
    pub(crate) mean_slope: f64,
    /// Whether the position falls somewhere while the command leads it up.
    pub(crate) curls: bool,
    /// Least and greatest position, each after the other end was visited.
    pub(crate) reach: (f64, f64),
    /// Greatest of the stairs in which the position moves, in parts of the reach.
    pub(crate) stair: Option<f64>,
}

impl Path {
    /// Takes an axis apart; the first `count` components stand in front of a coupling.
    ///
    /// # Errors
    /// Why it has no actuator, no bounds, or cannot be run.
    pub(crate) fn of(axis: &AxisSpec, count: usize, times: (f64, f64)) -> Result<Self, String> {
        let nodes: Vec<&NodeSpec> =
            axis.components.iter().take(count).filter(|node| node.enabled).collect();
        let Some(at) = nodes.iter().position(|node| is_actuator(node)) else {
            return Err(
                "no component turns its command into a position; add a hysteresis model".into()
            );
        };
        let (low, high) = axis.command_range;
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(format!(
                "the command's bounds are {low} to {high}, and a controller needs limits; give min and \
                 max of the command"
            ));
        }
        let mut left = Vec::new();
        let mut looked = Look { axis, times, left: &mut left };
        let (before, bounds) = looked.parts(&nodes[..at], true, [low, high])?;
        let actuator = nodes[at].clone();
        let own = sweep_of(axis, &actuator, &Curve::identity(), &Curve::identity(), bounds, times)?;
        let span = extent(&own.position);
        let (after, _) = looked.parts(&nodes[at + 1..], false, span)?;
        let maps =
            [looked.at_rest(&before, true, [low, high])?, looked.at_rest(&after, false, span)?];
        let sweep = sweep_of(axis, &actuator, &maps[0], &maps[1], [low, high], times)?;
        if !(sweep.slope.is_finite() && sweep.mean_slope != 0.0 && sweep.mean_slope.is_finite()) {
            return Err(format!(
                "the command moves nothing between its bounds {low} to {high}; check {} and the components around it",
                actuator.name
            ));
        }
        if sweep.curls {
            left.push(format!(
                "{}: the position falls somewhere while the command rises; there a position has several \
                 commands and no inverse is exact",
                actuator.name
            ));
        }
        if let Some(stair) = sweep.stair {
            left.push(format!(
                "{}: the position moves in stairs of up to {:.2} % of the range; no command leads between them, and \
                 up to half a stair is left",
                actuator.name,
                100.0 * stair
            ));
        }
        let own = own_response(axis, &actuator, bounds, times)?;
        Ok(Self {
            axis: axis.clone(),
            before,
            actuator,
            after,
            bounds,
            maps,
            sweep,
            own,
            left,
            times,
        })
    }

    /// All linear components with memory, in the order of the path.
    pub(crate) fn linear(&self) -> Vec<NodeSpec> {
        let parts = self.before.iter().chain(&self.after);
        parts.filter(|p| p.nature == Nature::Linear).map(|p| p.node.clone()).collect()
    }

    /// What the axis answers to commands, one a period, at the end of each; creep and linear parts left out.
    pub(crate) fn answers(&self, command: &[f64]) -> Result<Vec<f64>, String> {
        let nodes = std::slice::from_ref(&self.actuator);
        let mut probe = Probe::new(&self.axis, nodes, false, self.times)?;
        let driven: Vec<f64> = command.iter().map(|u| self.maps[0].value(*u)).collect();
        Ok(probe.run(&driven)?.iter().map(|y| self.maps[1].value(*y)).collect())
    }

    /// Position at rest under a command, after a monotonic move from the virgin state.
    pub(crate) fn at_rest(&self, command: f64) -> Result<f64, String> {
        let mut probe =
            Probe::new(&self.axis, std::slice::from_ref(&self.actuator), false, self.times)?;
        Ok(self.maps[1].value(probe.rest(self.maps[0].value(command))?))
    }
}

/// How an actuator answers small steps up and down about the middle of its commands.
fn own_response(
    axis: &AxisSpec,
    actuator: &NodeSpec,
    [low, high]: [f64; 2],
    times: (f64, f64),
) -> Result<Vec<f64>, String> {
    let mut probe = Probe::new(axis, std::slice::from_ref(actuator), false, times)?;
    let (middle, small) = (0.5 * (low + high), SMALL * (high - low));
    let mut before = probe.rest(middle)?;
    for _ in 0..TRIAL {
        before = probe.step(middle)?;
    }
    let mut answer = [0.0; TRIAL];
    for (command, sign) in [(middle + small, 1.0), (middle, -1.0)] {
        let from = before;
        for value in &mut answer {
            before = probe.step(command)?;
            *value += sign * (before - from);
        }
    }
    let end = answer[TRIAL - 1];
    if !(end.abs() > 0.0 && end.is_finite()) || answer[0] / end >= AT_ONCE {
        return Ok(vec![1.0]);
    }
    let last = std::iter::once(&0.0).chain(&answer);
    Ok(answer.iter().zip(last).map(|(now, last)| (now - last) / end).collect())
}

/// The commands of a sweep between these bounds, with the row at which each way begins.
fn sweep_command([low, high]: [f64; 2], steps: usize) -> (Vec<f64>, Vec<usize>) {
    let mut command = vec![low];
    let mut legs = vec![0];
    for turn in TURNS.windows(2) {
        let count = ((turn[1] - turn[0]).abs() * steps as f64).round() as usize;
        command.extend((1..=count).map(|k| {
            low + (high - low) * (turn[0] + (turn[1] - turn[0]) * k as f64 / count as f64)
        }));
        legs.push(command.len() - 1);
    }
    (command, legs)
}

fn extent(values: &[f64]) -> [f64; 2] {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    [least, values.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}

fn sweep_of(
    axis: &AxisSpec,
    actuator: &NodeSpec,
    before: &Curve,
    after: &Curve,
    bounds: [f64; 2],
    (step, period): (f64, f64),
) -> Result<Sweep, String> {
    let steps = steps_of(WAY, period);
    let rows = (WAY / steps as f64 / period).round().max(1.0);
    let own = rows * period;
    let mut probe = Probe::new(axis, std::slice::from_ref(actuator), false, (step, own))?;
    let (command, legs) = sweep_command(bounds, steps);
    let inner = command.len() as f64 * own / step;
    if inner > MOST_STEPS {
        return Err(format!(
            "ways over the range of {WAY} s each are {inner:.1e} steps of {step} s; at most {MOST_STEPS:.0e} are \
             taken: give a longer period"
        ));
    }
    let driven: Vec<f64> = command.iter().map(|u| before.value(*u)).collect();
    let position: Vec<f64> = probe.run(&driven)?.iter().map(|y| after.value(*y)).collect();
    let (ends, chord) = ([legs[3], legs[4]], steps / STEPS.2);
    let mean = (position[ends[0]] - position[ends[1]]) / (bounds[1] - bounds[0]);
    let (mut slope, mut least) = (0.0_f64, f64::INFINITY);
    for leg in legs[2..].windows(2) {
        for k in leg[0]..leg[1] - chord {
            let rise = (position[k + chord] - position[k]) / (command[k + chord] - command[k]);
            let along = rise * mean.signum();
            slope = slope.max(along);
            least = least.min(along);
        }
    }
    let (a, b) = (position[ends[0]], position[ends[1]]);
    let stair = stair_of(&position[legs[2]..=legs[4]], (a - b).abs());
    Ok(Sweep {
        command,
        position,
        slope: slope * mean.signum(),
        least_slope: least.max(0.0) * mean.signum(),
        mean_slope: mean,
        curls: least < -1e-3 * slope,
        reach: (a.min(b), a.max(b)),
        stair,
    })
}

/// The greatest stair of a position on its way over the range, in parts of it, where it mostly stands still and then
/// jumps.
fn stair_of(position: &[f64], range: f64) -> Option<f64> {
    let jumps = || position.windows(2).map(|p| (p[1] - p[0]).abs() / range);
    let count = position.len().saturating_sub(1).max(1) as f64;
    let still = jumps().filter(|jump| *jump < 1e-9).count() as f64 / count;
    let greatest = jumps().fold(0.0, f64::max);
    let mean = jumps().sum::<f64>() / count;
    (still > STILL && greatest > JUMP * mean).then_some(greatest)
}

/// Looks at the components of an axis.
struct Look<'a> {
    axis: &'a AxisSpec,
    times: (f64, f64),
    left: &'a mut Vec<String>,
}

impl Look<'_> {
    /// The parts of a chain whose input is within `range`, and the range behind it.
    fn parts(
        &mut self,
        nodes: &[&NodeSpec],
        of_the_command: bool,
        mut range: [f64; 2],
    ) -> Result<(Vec<Part>, [f64; 2]), String> {
        let mut parts = Vec::new();
        for node in nodes {
            let part = self.part(node, of_the_command, range)?;
            if part.nature != Nature::Left && part.nature != Nature::Creep {
                let map = self.at_rest(std::slice::from_ref(&part), of_the_command, range)?;
                range = extent(&map.value);
            }
            parts.push(part);
        }
        Ok((parts, range))
    }

    fn probe(&self, nodes: &[NodeSpec], of_the_command: bool) -> Result<Probe, String> {
        Probe::new(self.axis, nodes, of_the_command, self.times)
    }

    fn part(
        &mut self,
        node: &NodeSpec,
        of_the_command: bool,
        range: [f64; 2],
    ) -> Result<Part, String> {
        let mut probe = self.probe(std::slice::from_ref(node), of_the_command)?;
        let (nature, cost) = nature(&mut probe, node, range)?;
        if let Some(cost) = cost {
            self.left.push(format!("{}: {cost}", node.name));
        } else if nature == Nature::Creep && node.component.inverses().is_empty() {
            let inside = 0.5 * (range[0] + range[1]);
            let mut probe = self.probe(std::slice::from_ref(node), of_the_command)?;
            let from = probe.rest(inside)?;
            let first = probe.step(range[1])? - from;
            let end = probe.rest(range[1])? - from;
            self.left.push(format!(
                "{}: creep without an inverse, left to feedback; the position continues to move by {:.2} % of a step",
                node.name,
                100.0 * (end / first - 1.0).abs()
            ));
        }
        Ok(Part { node: node.clone(), nature, range })
    }

    /// What parts do at rest, without creep and what is left to feedback.
    fn at_rest(
        &self,
        parts: &[Part],
        of_the_command: bool,
        range: [f64; 2],
    ) -> Result<Curve, String> {
        at_rest(self.axis, parts, of_the_command, range, self.times)
    }
}

/// The parts of an axis behind a coupling, and what they leave to feedback.
///
/// # Errors
/// What the model says.
pub(crate) fn parts_behind(
    axis: &AxisSpec,
    nodes: &[NodeSpec],
    range: [f64; 2],
    times: (f64, f64),
) -> Result<(Vec<Part>, Vec<String>), String> {
    let mut left = Vec::new();
    let nodes: Vec<&NodeSpec> = nodes.iter().filter(|node| node.enabled).collect();
    let (parts, _) = Look { axis, times, left: &mut left }.parts(&nodes, false, range)?;
    Ok((parts, left))
}

/// What parts do at rest, without creep and what is left to feedback.
pub(crate) fn at_rest(
    axis: &AxisSpec,
    parts: &[Part],
    of_the_command: bool,
    range: [f64; 2],
    times: (f64, f64),
) -> Result<Curve, String> {
    let acts = |part: &&Part| matches!(part.nature, Nature::Static | Nature::Linear);
    let nodes: Vec<NodeSpec> = parts.iter().filter(acts).map(|p| p.node.clone()).collect();
    if nodes.is_empty() || range[0] >= range[1] {
        return Ok(Curve::identity());
    }
    Curve::of(&mut Probe::new(axis, &nodes, of_the_command, times)?, range)
}

/// Uniform numbers from -1 to 1 that are the same at every run.
fn numbers(seed: u64) -> Vec<f64> {
    let mut random = SplitMix64::new(seed);
    (0..TRIAL).map(|_| 2.0 * random.uniform() - 1.0).collect()
}

/// What a component is, and what is lost where it is left to feedback.
fn nature(
    probe: &mut Probe,
    node: &NodeSpec,
    [low, high]: [f64; 2],
) -> Result<(Nature, Option<String>), String> {
    let middle = 0.5 * (low + high);
    let height = (probe.rest(high)? - probe.rest(low)?).abs();
    let rest = probe.rest(middle)?;
    let held = probe.run(&[middle; TRIAL])?;
    let moved = held.iter().map(|y| (y - rest).abs()).fold(0.0, f64::max);
    if moved > SAME.0 * height {
        let cost = format!(
            "moves without a command, left to feedback; {:.3} % of the range within {TRIAL} samples",
            100.0 * moved / height.max(f64::MIN_POSITIVE)
        );
        return Ok((Nature::Left, Some(cost)));
    }
    let (first, second) = (numbers(1), numbers(2));
    for swing in SWINGS {
        let wide = swing * (high - low);
        let mut answer = |x: &dyn Fn(usize) -> f64| {
            let u: Vec<f64> = (0..TRIAL).map(|k| middle + wide * x(k)).collect();
            // From rest in the middle.
            probe.rest(middle)?;
            u.iter().map(|u| Ok(probe.step(*u)? - rest)).collect::<Result<Vec<f64>, String>>()
        };
        let a = answer(&|k| first[k])?;
        let b = answer(&|k| second[k])?;
        let both = answer(&|k| first[k] + second[k])?;
        let small = swing * height;
        let off = (0..TRIAL).map(|k| (a[k] + b[k] - both[k]).abs()).fold(0.0, f64::max);
        let is_linear = off <= SAME.0 * small.max(f64::MIN_POSITIVE);
        if swing == SWINGS[0] {
            let mut apart = 0.0_f64;
            for (k, x) in first.iter().enumerate() {
                apart = apart.max((probe.rest(middle + wide * x)? - rest - a[k]).abs());
            }
            if apart <= SAME.1 * height {
                return Ok((Nature::Static, None));
            }
        }
        if is_linear {
            let creeps = node
                .component
                .declaration()
                .effect
                .is_some_and(|effect| effect.name == effects::CREEP.name);
            let cost = (swing < SWINGS[0]).then(|| {
                "is linear for small motions only; the rest is left to feedback".to_owned()
            });
            return Ok((if creeps { Nature::Creep } else { Nature::Linear }, cost));
        }
    }
    let cost =
        "is not linear and has a memory; it has no inverse and is left to feedback".to_owned();
    Ok((Nature::Left, Some(cost)))
}
