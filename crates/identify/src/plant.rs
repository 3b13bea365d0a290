//! From fitted numbers to a blueprint.

use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, Value};
use model::{Kind, Table};

use crate::error::Error;
use crate::fit::coordinates::Deviations;
use crate::fit::response::LinearPart;
use crate::methods::Chain;
use crate::record::Record;
use crate::settings::{MOST_DELAY, Target};

/// A plant with one axis.
pub(crate) struct Plant<'a> {
    /// What turns the command into a position, offset included.
    pub(crate) chain: &'a Chain,
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
        chain.extend(self.chain.hysteresis.iter().cloned());
        if let Some(shape) = linear.mode {
            let mode = ComponentBlueprint::new("mode")
                .value("frequency", shape.frequency)
                .value("damping", shape.damping);
            let mode = tolerance(mode, "frequency", shape.frequency, self.deviations.frequency);
            chain.push(tolerance(mode, "damping", shape.damping, self.deviations.damping));
        }
        chain.extend(self.chain.reading.iter().cloned());
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
