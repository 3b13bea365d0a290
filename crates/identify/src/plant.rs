//! From fitted numbers to a blueprint.

use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, Value};
use model::{Kind, Table};

use crate::error::Error;
use crate::fit::linear_part::Deviations;
use crate::fit::response::LinearPart;
use crate::methods::Chain;
use crate::record::Record;
use crate::settings::{MOST_DELAY, Target};

/// What turns the command into a position.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Actuator<'a> {
    /// `gain · u + offset`.
    Linear { gain: f64 },
    /// A Prandtl–Ishlinskii model.
    Plays { r: &'a [f64], w: &'a [f64], relative_deviation: Option<f64> },
    /// Another method's components, offset included.
    Chain(&'a Chain),
}

/// A plant with one axis.
pub(crate) struct Plant<'a> {
    pub(crate) actuator: Actuator<'a>,
    pub(crate) offset: f64,
    pub(crate) linear: LinearPart,
    pub(crate) deviations: Deviations,
    /// Internal step in s.
    pub(crate) step: f64,
    /// The table of what is learned, by the name of its file.
    pub(crate) table: Option<(String, Table)>,
}

impl Plant<'_> {
    /// The checked blueprint of this plant.
    ///
    /// # Errors
    /// [`Error::Model`] with every problem of names, units or bounds of the target.
    pub(crate) fn blueprint(
        &self,
        target: &Target,
        records: &[Record],
        description: String,
    ) -> Result<CheckedBlueprint, Error> {
        let mut axis = with_bounds(target.axis.clone(), records);
        axis.components = self.components();
        let mut blueprint = Blueprint::new(Kind::Plant, &target.model, self.step).axis(axis);
        blueprint.description = description;
        blueprint.source.clone_from(&target.source);
        blueprint.tables.extend(self.table.clone());
        blueprint.check(learned::COMPONENTS).map_err(|problems| Error::Model {
            name: target.model.clone(),
            message: problems.to_string(),
        })
    }

    fn components(&self) -> Vec<ComponentBlueprint> {
        let linear = &self.linear;
        let mut chain = Vec::new();
        // A delay below a millionth of a step is rounding.
        if linear.delay > 1e-6 * self.step {
            let longest = ((2.0 * linear.delay / self.step).ceil() * self.step).min(MOST_DELAY);
            let delay = ComponentBlueprint::new("delay")
                .value("longest", longest.max(linear.delay))
                .value("delay", linear.delay);
            chain.push(tolerance(delay, "delay", linear.delay, self.deviations.delay));
        }
        if let Some(bandwidth) = linear.bandwidth {
            let lag = ComponentBlueprint::new("amplifier-lag").value("bandwidth", bandwidth);
            chain.push(tolerance(lag, "bandwidth", bandwidth, self.deviations.bandwidth));
        }
        match &self.actuator {
            Actuator::Linear { gain } => chain.push(
                ComponentBlueprint::new("actuator-gain")
                    .value("gain", *gain)
                    .value("offset", self.offset),
            ),
            Actuator::Plays { r, w, relative_deviation } => {
                let plays = ComponentBlueprint::new("prandtl-ishlinskii")
                    .value("r", *r)
                    .value("w", *w)
                    .value("offset", self.offset);
                chain.push(match relative_deviation {
                    Some(relative) => plays.tolerance("w", *relative),
                    None => plays,
                });
            }
            Actuator::Chain(parts) => chain.extend(parts.hysteresis.iter().cloned()),
        }
        if let Some(shape) = linear.mode {
            let mode = ComponentBlueprint::new("mode")
                .value("frequency", shape.frequency)
                .value("damping", shape.damping);
            let mode = tolerance(mode, "frequency", shape.frequency, self.deviations.frequency);
            chain.push(tolerance(mode, "damping", shape.damping, self.deviations.damping));
        }
        if let Actuator::Chain(parts) = &self.actuator {
            chain.extend(parts.reading.iter().cloned());
        }
        chain
    }
}

fn tolerance(
    component: ComponentBlueprint,
    name: &str,
    value: f64,
    deviation: Option<f64>,
) -> ComponentBlueprint {
    match deviation {
        Some(deviation) if deviation > 0.0 && value > 0.0 => {
            component.tolerance(name, deviation / value)
        }
        _ => component,
    }
}

/// The axis with the log's range where no bounds were given, and with a start inside.
fn with_bounds(mut axis: AxisBlueprint, records: &[Record]) -> AxisBlueprint {
    let inputs = || records.iter().flat_map(|r| r.input().iter().copied());
    let low = inputs().fold(f64::INFINITY, f64::min);
    let high = inputs().fold(f64::NEG_INFINITY, f64::max);
    if axis.command.min.is_none() {
        axis.command.min = Some(Value::Number(low));
    }
    if axis.command.max.is_none() {
        axis.command.max = Some(Value::Number(high));
    }
    if let (None, Some(Value::Number(min)), Some(Value::Number(max))) =
        (&axis.command.start, &axis.command.min, &axis.command.max)
        && min <= max
    {
        axis.command.start = Some(Value::Number(0.0_f64.clamp(*min, *max)));
    }
    axis
}
