//! Bandwidth of the sensor, second order.
//!
//! `y″ + 2ζω y′ + ω² y = ω²·x`, ω = 2π·frequency
//!
//! * frequency in Hz: natural frequency (the −3 dB bandwidth for ζ = 0.707); damping: ζ > 0.
//! * State: y and y′/ω. Exact at any period, as the input is held over a step.

use model::{Declaration, Quantity, Stage, Violation};

use crate::linear::SecondOrder;
use crate::low_pass::LowPass;
use crate::rules::{WRONG_LENGTH, second_order};
use crate::{effects, phenomena};

/// The component `sensor-second-order`.
pub static SENSOR_SECOND_ORDER: LowPass =
    LowPass { declaration: &DECLARATION, law: unit_gain, extended: |_| None };

static DECLARATION: Declaration = Declaration {
    kind: "sensor-second-order",
    name: "sensor",
    summary: "Second-order bandwidth of the sensor and its filter",
    equation: "y'' + 2*damping*w*y' + w^2*y = w^2*x; w = 2*pi*frequency",
    reference: "A. J. Fleming, Sensors and Actuators A 190 (2013) 106-126",
    stage: Stage::Sensor,
    effect: Some(&effects::SENSOR_BANDWIDTH),
    phenomena: &[&phenomena::SENSOR_BANDWIDTH],
    parameters: &[
        Quantity::new("frequency", "Hz", "Natural frequency").min(0.0).fitted(),
        Quantity::new("damping", "1", "Damping ratio; 0.707 is flat")
            .start(0.707)
            .min(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

fn unit_gain(parameters: &[f64], period: f64) -> Result<SecondOrder, Violation> {
    let &[frequency, damping] = parameters else { return Err(WRONG_LENGTH) };
    second_order(frequency, damping, period)?;
    Ok(SecondOrder::new(frequency, damping, 1.0, period))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_ramp_is_read_late_by_twice_the_damping_over_the_angular_frequency() {
        let mut sensor = Instance::new(&SENSOR_SECOND_ORDER, &[], &[40.0, 0.707], 1e-4).unwrap();
        sensor.rest(&[0.0]);
        let mut y = 0.0;
        for n in 1..=10_000 {
            // The held ramp lies half a step behind the continuous one at the end of a step.
            y = sensor.step(&[1e-4 * (f64::from(n) - 0.5)]);
        }
        let late = 2.0 * 0.707 / (core::f64::consts::TAU * 40.0);
        assert!((1.0 - y - late).abs() < 1e-6, "{}", 1.0 - y);
    }
}
