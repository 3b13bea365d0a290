//! Which component does what a block or a force does.

use std::f64::consts::{PI, TAU};

use data::ComponentBlueprint;
use model::{Extension, Shape};
use surround::{Block, Loss, Stepped};

use super::number;
use crate::answer::scale_of;
use crate::chain::Force;
use crate::formula::far_end;
use crate::library::Piece;
use crate::outcome::Outcome;

/// A mode with another force, where a component has it; a unit of its position is `y` m.
pub(super) fn forced(
    y: f64,
    (force, centre, half): (Force, f64, f64),
    p: &[f64],
    mode: &ComponentBlueprint,
) -> Option<ComponentBlueprint> {
    let gain = mode.get("gain").and_then(number).unwrap_or(1.0);
    let new = |by: Extension| {
        let kind = components::find(&mode.kind)?.extended(by)?.declaration().kind;
        let mut component = ComponentBlueprint::new(kind);
        component.name.clone_from(&mode.name);
        for name in ["frequency", "damping"] {
            component.set(name, mode.get(name)?.clone());
        }
        Some(component)
    };
    let far = far_end(centre, half) / y;
    // The stiffness over that at zero.
    let stiffness = |linear: f64, quadratic: f64| {
        Some(
            new(Extension::PositionStiffness)?
                .value("linear", linear)
                .value("quadratic", quadratic)
                .value("centre", 0.0)
                .value("half_range", far),
        )
    };
    match (force, p) {
        // The component hardens about zero, with a static gain of 1.
        (Force::Cubic, &[cubic]) if cubic >= 0.0 && centre.abs() < 0.1 * half && gain == 1.0 => {
            Some(new(Extension::Hardening)?.value("hardening", cubic).value("reference", far))
        }
        (Force::Cubic, &[cubic]) if gain == 1.0 => stiffness(0.0, cubic),
        (Force::Uneven, &[square, cubic]) if gain == 1.0 => stiffness(square, cubic),
        // Dahl's law is LuGre's without a difference between static and sliding friction.
        (Force::Friction, &[size, distance]) if gain == 1.0 => Some(
            new(Extension::Friction)?
                .value("coulomb", size / y)
                .value("stiction", size / y)
                .value("presliding", distance / y)
                .value("stribeck", half / y),
        ),
        // The rate over ω becomes a velocity, and what it damps a part of the damping ratio.
        (Force::Coulomb, &[size, smooth]) if gain == 1.0 => {
            let omega = TAU * mode.get("frequency").and_then(number)?;
            Some(
                new(Extension::NonlinearDamping)?
                    .value("coulomb", size / y)
                    .value("velocity", smooth * omega / y),
            )
        }
        (Force::SpeedDamping, &[ratio]) if gain == 1.0 && ratio >= 0.0 => {
            let omega = TAU * mode.get("frequency").and_then(number)?;
            Some(new(Extension::NonlinearDamping)?.value("growth", 0.5 * ratio / (omega * far)))
        }
        _ => None,
    }
}

/// The components that do what a block does with these values, where there are any.
pub(super) fn components(o: &Outcome, piece: &Piece, p: &[f64]) -> Option<Vec<ComponentBlueprint>> {
    let new = ComponentBlueprint::new;
    let (u, y) = (o.task.command_factor, o.task.factor);
    let step = o.task.data.step;
    let is_sensor = piece.slot == crate::library::Slot::Reading;
    let is_command = piece.slot < crate::library::Slot::AfterActuator;
    let span = o.task.data.command_span;
    let far = 10.0 * (span.half + span.centre.abs());
    let one = |c: ComponentBlueprint| Some(vec![c]);
    match (piece.block.effect()?, p) {
        (Block::Delay, &[delay]) => {
            let longest = ((2.0 * delay / step).ceil() + 1.0) * step;
            one(new("delay").value("longest", longest).value("delay", delay))
        }
        (Block::Lag { order }, &[bandwidth]) => {
            let kind = if is_sensor { "sensor-lag" } else { "amplifier-lag" };
            Some(vec![new(kind).value("bandwidth", bandwidth); *order])
        }
        (Block::SecondOrder, &[frequency, damping]) => {
            let kind = if is_sensor { "sensor-second-order" } else { "amplifier-second-order" };
            one(new(kind).value("frequency", frequency).value("damping", damping))
        }
        (Block::Rounding { half }, &[steps, phase]) => {
            let (kind, factor) =
                if is_sensor { ("sensor-quantisation", y) } else { ("dac-quantisation", u) };
            let converter = new(kind).value("resolution", 2.0 * half / steps / factor);
            one(converter.value("phase", phase))
        }
        // A parabola takes as much off in sum as the logarithm of the formula: ∫ = softness²/6 = π²/6·width².
        (Block::SoftLimitAbove, &[limit, width]) => one(new("amplifier-clamp")
            .value("low", -far / u)
            .value("high", limit / u)
            .value("softness", PI * width / u)),
        // The same with a hyperbolic tangent above the knee: 1/2 − ln cosh 1 + ln(1 + e⁻²) = 0.1931 of width².
        (Block::KneeAbove, &[knee, width]) => one(new("amplifier-clamp")
            .value("low", -far / u)
            .value("high", (knee + width) / u)
            .value("softness", (6.0 * 0.1931_f64).sqrt() * width / u)),
        (Block::Gain, &[gain]) => one(new("sensor-scale").value("gain", 1.0 + gain)),
        (Block::Polynomial(span), &[square, cubic]) if is_command => {
            one(new("amplifier-nonlinearity")
                .value("quadratic", square)
                .value("cubic", cubic)
                .value("centre", span.centre / u)
                .value("half_range", span.half / u))
        }
        // The loss of a loop about the mean: power π/2·loss·capacitance·|ṽ v′| over its mean here.
        (Block::Heating { half, loss: Loss::Loops { mean, .. } }, &[growth, time]) => {
            one(warming(*mean / (u * u), time, o).value("growth", growth * half / y))
        }
        (Block::HeatingGain { loss: Loss::Loops { mean, .. } }, &[growth, time]) => {
            one(warming(*mean / (u * u), time, o).value("coefficient", growth))
        }
        // What the component reads is the command.
        (Block::FeedThrough { .. }, _) if !piece.of_command => None,
        (block, p) => stepped(o, block, p),
    }
}

/// The components that a block steps itself.
fn stepped(o: &Outcome, block: &Block, p: &[f64]) -> Option<Vec<ComponentBlueprint>> {
    let kernel = block.prepare(p, o.task.data.step).ok()?;
    let span = o.task.data.command_span;
    // A limit on one side has another where no command comes.
    let far = 10.0 * (span.half + span.centre.abs());
    let all =
        kernel.components().into_iter().map(|Stepped { component, structure, parameters }| {
            let declaration = component.declaration();
            let (mut own, mut rest) = (ComponentBlueprint::new(declaration.kind), parameters);
            for (k, quantity) in declaration.parameters.iter().enumerate() {
                let (values, behind) = rest.split_at(declaration.length(k, structure));
                rest = behind;
                let scale = scale_of(o, quantity.unit);
                let finite = |v: &f64| if v.is_finite() { *v } else { far.copysign(*v) };
                let values: Vec<f64> = values.iter().map(|v| finite(v) / scale).collect();
                let is_scalar = matches!(quantity.shape, Shape::Scalar);
                match values[..] {
                    [value] if is_scalar && quantity.start == Some(value) => {}
                    [value] if is_scalar => own.set(quantity.name, value),
                    _ => own.set(quantity.name, values),
                }
            }
            own
        });
    Some(all.collect()).filter(|all: &Vec<_>| !all.is_empty())
}

/// A component that warms by one kelvin at the mean power of the log.
fn warming(mean: f64, time: f64, o: &Outcome) -> ComponentBlueprint {
    ComponentBlueprint::new("self-heating")
        .value("loss", std::f64::consts::FRAC_2_PI)
        .value("capacitance", 1.0)
        .value("resistance", 1.0 / mean)
        .value("time_constant", time)
        .value("coefficient", 0.0)
        .value("growth", 0.0)
        .value("averaging", o.task.data.longest())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stiffness over that at zero grows by 10 % to the far end of the range, whose middle is off zero.
    #[test]
    fn a_spring_is_written_with_the_range_that_it_was_found_with() {
        let mode = ComponentBlueprint::new("mode").value("frequency", 100.0).value("damping", 0.01);
        for force in [(Force::Cubic, 0.08e-6, 1e-6), (Force::Cubic, 0.5e-6, 1e-6)] {
            let written = forced(1e-6, force, &[0.1], &mode).expect("a component has it");
            let of = |name| written.get(name).and_then(number);
            let growth = of("hardening").or_else(|| of("quadratic")).expect("a growth");
            let range = of("reference").or_else(|| of("half_range")).expect("a range");
            let far = 1.0 + force.1 / 1e-6;
            assert!(
                (growth / (range * range) / (0.1 / (far * far)) - 1.0).abs() < 1e-12,
                "{written:?}"
            );
        }
    }
}
