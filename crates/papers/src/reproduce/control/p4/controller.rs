//! The controller of the machine: inverses, leads, PID.

use super::GREATEST_HALF;
use super::PERIOD;
use anyhow::Context;
use components::effects;
use control::Gains;
use data::AxisBlueprint;
use data::Blueprint;
use data::ComponentBlueprint;
use data::Value;

/// The parts of a controller that its rows differ in.
#[derive(Clone, Copy)]
pub(super) struct Parts<'a> {
    /// The plant whose inverse is the feedforward; `None`: no feedforward.
    pub(super) model: Option<&'a Blueprint>,
    pub(super) gains: [Gains; 2],
    /// Greatest command in V.
    pub(super) greatest: f64,
    /// Whether the feedforward makes up for delay and period.
    pub(super) leads: bool,
}

/// A controller from the one that the static model was inverted to.
pub(super) fn controller(inverted: &Blueprint, parts: Parts<'_>) -> anyhow::Result<Blueprint> {
    let mut blueprint = inverted.clone();
    for (number, axis) in blueprint.axes.iter_mut().enumerate() {
        // The identified commands end where the excitation did.
        axis.command.min = Some(0.0.into());
        axis.command.max = Some(parts.greatest.into());
        let plant = parts.model.map(|plant| plant.axes.get(number).context("two axes"));
        let mut chain = match plant.transpose()? {
            Some(plant) => feedforward(plant, parts.greatest, parts.leads)?,
            None => Vec::new(),
        };
        let Gains { kp, ki, kd, derivative_filter } = parts.gains[number];
        chain.push(
            ComponentBlueprint::new("pid")
                .value("kp", kp)
                .value("ki", ki)
                .value("kd", kd)
                .value("derivative_filter", derivative_filter)
                .value("output_min", 0.0)
                .value("output_max", parts.greatest),
        );
        axis.components = chain;
    }
    Ok(blueprint)
}

/// The inverse of an axis' hysteresis, and in front of it what makes up for the delay and the period until the position
/// answers.
pub(super) fn feedforward(
    plant: &AxisBlueprint,
    greatest: f64,
    leads: bool,
) -> anyhow::Result<Vec<ComponentBlueprint>> {
    let late = |c: &ComponentBlueprint| {
        let declaration = components::find(&c.kind)?.declaration();
        (declaration.effect?.name == effects::DELAY.name)
            .then_some(declaration.parameters.first()?.name)
    };
    let own = plant.components.iter().find_map(|c| c.get(late(c)?));
    let delay = if let Some(Value::Number(delay)) = own { *delay } else { 0.0 };
    let lag = PERIOD + delay;
    let lead = ComponentBlueprint::new("reference-lead")
        .value("lag", lag)
        .value("inertia", 0.5 * lag * lag)
        .value("limit", GREATEST_HALF);
    let with_inverse = |c: &ComponentBlueprint| {
        let inverse = components::find(&c.kind)?.inverses().first()?;
        Some((c.clone(), components::find(inverse.kind)?.declaration()))
    };
    let hysteresis = plant.components.iter().find_map(with_inverse);
    let (mut inverse, declaration) = hysteresis.context("the plant has a hysteresis")?;
    inverse.kind = declaration.kind.into();
    inverse.name = "inverse".into();
    inverse.tolerance.clear();
    for (name, end) in [("command_min", 0.0), ("command_max", greatest)] {
        if declaration.parameters.iter().any(|quantity| quantity.name == name) {
            inverse.set(name, end);
        }
    }
    Ok(if leads { vec![lead, inverse] } else { vec![inverse] })
}
