//! The actuation of an axis whose hysteresis was learned, with the discrete linear part behind it.

use data::CheckedBlueprint;
use learned::features::{Features, StopOperators};
use model::{AxisSpec, NodeSpec, Undoing};
use nalgebra::Complex;

use crate::linearised::{is_discrete, product_of_gains, setting, values};
use crate::probe::is_actuator;
use identify::learned::{Arx, Frame, Machine, Recipe, Span, inverse, inverse::Purpose};

/// Where a command that shows slopes turns round, as parts of its range.
const TURNS: [f64; 9] = [0.0, 1.0, 0.0, 0.8, 0.2, 0.6, 0.4, 1.0, 0.0];
/// Its steps over the whole range, and over the chord of a slope.
const STEPS: (usize, usize) = (100, 5);
/// Steps that lead to rest.
const REST: usize = 100;
/// Damping ratio below which a pair of poles counts as a mode, and its greatest turn per sample.
const MODE: (f64, f64) = (0.5, 0.9 * core::f64::consts::PI);

/// A learned hysteresis from the axis' command to its position at rest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LearnedAxis {
    pub(crate) forward: Machine,
    /// The discrete linear part behind it; b = [1] where there is none.
    pub(crate) linear: Arx,
    /// Sample time of both in s.
    pub(crate) period: f64,
    /// Commands within the axis' bounds that the model was shown.
    commands: [f64; 2],
    /// Steepest chord, in position per command.
    pub(crate) slope: f64,
    /// Positions at the ends of the commands, each after the other end was visited.
    pub(crate) reach: (f64, f64),
}

/// The sample time of the first learned hysteresis of a plant, in s.
pub(crate) fn sample_time(axes: &[AxisSpec]) -> Option<f64> {
    axes.iter().find_map(|axis| sample_time_of(&axis.components[actuator_of(axis)?]))
}

fn actuator_of(axis: &AxisSpec) -> Option<usize> {
    axis.components.iter().position(is_actuator)
}

/// The sample time of a component whose inverse is learned.
fn sample_time_of(node: &NodeSpec) -> Option<f64> {
    let mut inverses = node.component.inverses().iter();
    let learned = inverses.any(|inverse| inverse.undoing == Undoing::Learned);
    setting(node, "sample_time").filter(|_| learned)
}

impl LearnedAxis {
    /// The axis number `index` of a plant for a controller of this period; `None` where its actuator was
    /// not learned.
    ///
    /// # Errors
    /// Every reason why it has no inverse.
    pub(crate) fn of(
        plant: &CheckedBlueprint,
        index: usize,
        period: f64,
    ) -> Result<Option<Self>, Vec<String>> {
        let axis = &plant.spec().axes[index];
        let Some(at) = actuator_of(axis) else { return Ok(None) };
        let node = &axis.components[at];
        let Some(own) = sample_time_of(node) else { return Ok(None) };
        let refuse = |reason: String| Err(vec![reason]);
        if (own - period).abs() > 1e-9 * own {
            return refuse(format!(
                "{} was learned with a sample time of {own} s, and the controller has {period} s: a learned inverse works at the sample time of the model only; leave --period out, or resample the log and identify again",
                node.name
            ));
        }
        let behind = &axis.components[at + 1..];
        let discrete = |n: &&NodeSpec| n.enabled && is_discrete(n);
        let mut linear = Arx { b: vec![1.0], a: Vec::new() };
        for part in behind.iter().filter(discrete) {
            let other = part.structure.first().copied().unwrap_or(own);
            if (other - own).abs() > 1e-9 * own {
                return refuse(format!(
                    "{} has a sample time of {other} s, {} of {own} s; give both the same",
                    part.name, node.name
                ));
            }
            linear = linear.then(&Arx { b: values(part, "b"), a: values(part, "a") });
        }
        let before = product_of_gains(&axis.components[..at]);
        let after = product_of_gains(behind) * linear.gain();
        if !(before.is_finite() && before > 0.0 && after.is_finite() && after > 0.0) {
            return refuse(format!(
                "the gain before {0} is {before}, that behind it at rest {after}, and a learned model is turned \
                 round only by positive ones",
                node.name
            ));
        }
        let forward = machine(plant, index, node, (before, after)).map_err(|e| vec![e])?;
        let Span { low, high } = forward.frame.command;
        let commands = [axis.command_range.0.max(low), axis.command_range.1.min(high)];
        if commands[0] >= commands[1] {
            return refuse(format!(
                "the command's bounds are {} to {}, but the model was shown {low} to {high}; give bounds within \
                 these",
                axis.command_range.0, axis.command_range.1
            ));
        }
        let (least, slope) = slopes(&forward, commands);
        if least.is_nan() || least <= 0.0 {
            return refuse(format!(
                "{} falls where its command rises (a chord of {least:.3e} in position per command), so there is no \
                 inverse; identify it from a longer or a quieter log",
                node.name
            ));
        }
        let reach = reach(&forward, commands);
        Ok(Some(Self { forward, linear, period, commands, slope, reach }))
    }

    /// Position at rest under this command, after a rise from the model's least one.
    pub(crate) fn at_rest(&self, command: f64) -> f64 {
        let run = self.forward.simulate(&[command; REST], self.forward.frame.output.low);
        run.last().copied().unwrap_or(0.0)
    }

    /// What the inverse is learned for, with waves up to `highest` Hz or what suits the linear part and the
    /// period.
    ///
    /// # Errors
    /// A frequency that does not suit the period.
    pub(crate) fn purpose(&self, highest: Option<f64>) -> Result<Purpose, String> {
        let most = 1.0 / (inverse::SHORTEST * self.period);
        let usual = self.linear.bandwidth(self.period).map_or(most, |band| band.min(most));
        let highest = highest.unwrap_or(usual);
        let limit = 0.1 / self.period;
        if !(highest > 0.0 && highest <= limit) {
            return Err(format!(
                "a band up to {highest} Hz does not suit a sample time of {} s; give one above 0 and up to {limit} \
                 Hz (without --band it is {usual:.4} Hz)",
                self.period
            ));
        }
        Ok(Purpose { period: self.period, commands: self.commands, highest })
    }

    /// Lightly damped pairs of poles of the linear part: frequency in Hz and damping ratio.
    pub(crate) fn modes(&self) -> Vec<(f64, f64)> {
        let pair = |p: Complex<f64>| {
            let s = p.ln() / self.period;
            (s.norm() / core::f64::consts::TAU, -s.re / s.norm())
        };
        let ringing = self.linear.poles().into_iter().filter(|p| p.im > 0.0 && p.arg() < MODE.1);
        ringing.map(pair).filter(|(_, damping)| *damping < MODE.0).collect()
    }
}

/// The machine of a node, from the axis' command to the position at rest.
fn machine(
    plant: &CheckedBlueprint,
    index: usize,
    node: &NodeSpec,
    (before, after): (f64, f64),
) -> Result<Machine, String> {
    let components = &plant.blueprint().axes[index].components;
    let kind = node.component.declaration().kind;
    let table = components.iter().find(|c| c.kind == kind).and_then(|c| plant.table_of(c));
    let table = table.ok_or_else(|| format!("{} has no table that can be read", node.name))?;
    let value = |name: &str| values(node, name).first().copied().unwrap_or(0.0);
    let &[period, count, range, rate_scale, slope, projected] = &node.structure[..] else {
        return Err(format!("{} has not the structure of {kind}", node.name));
    };
    let count = count as usize;
    // The table has the weights.
    let projection = if projected > 0.5 { vec![0.0; count] } else { Vec::new() };
    let features =
        Features::StopOperators(StopOperators { count, range, period, rate_scale, projection });
    let command = Span { low: value("command_low") / before, high: value("command_high") / before };
    let output = Span { low: value("position_low") * after, high: value("position_high") * after };
    let mut frame = Frame::new(features, command, output, Recipe::Plain, &[]);
    frame.slope = slope;
    Machine::of_table(frame, &table)
}

/// Least and greatest slope of the chords over a twentieth of the range, on large and small loops.
fn slopes(forward: &Machine, [low, high]: [f64; 2]) -> (f64, f64) {
    let (steps, chord) = STEPS;
    let mut found = (f64::INFINITY, f64::NEG_INFINITY);
    let mut command = vec![low];
    let mut legs = Vec::new();
    for turn in TURNS.windows(2) {
        let count = ((turn[1] - turn[0]).abs() * steps as f64).round() as usize;
        let from = command.len() - 1;
        let at = |k: usize| {
            low + (high - low) * (turn[0] + (turn[1] - turn[0]) * k as f64 / count as f64)
        };
        command.extend((1..=count).map(at));
        legs.push(from..command.len());
    }
    let position = forward.simulate(&command, forward.frame.output.low);
    for leg in legs {
        for k in leg.start..leg.end - chord {
            let slope = (position[k + chord] - position[k]) / (command[k + chord] - command[k]);
            found = (found.0.min(slope), found.1.max(slope));
        }
    }
    found
}

fn reach(forward: &Machine, [low, high]: [f64; 2]) -> (f64, f64) {
    let part = |k: usize| k as f64 / STEPS.0 as f64;
    let wave = |k: usize| match k / STEPS.0 {
        0 | 2 => part(k % STEPS.0),
        1 | 3 => 1.0 - part(k % STEPS.0),
        _ => 0.0,
    };
    let command: Vec<f64> = (0..=4 * STEPS.0).map(|k| low + (high - low) * wave(k)).collect();
    let position = forward.simulate(&command, forward.frame.output.low);
    (position[4 * STEPS.0], position[3 * STEPS.0])
}
