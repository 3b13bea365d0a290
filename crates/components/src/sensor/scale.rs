//! Gain and offset of the sensor.
//!
//! `y = gain·x + offset`
//!
//! * gain without unit; offset in position. No state.
//!
//! Limits: position and command alone cannot tell this gain from the actuator's.

use model::{Declaration, Quantity, Stage};

use crate::affine::Affine;
use crate::{effects, phenomena};

/// The component `sensor-scale`.
pub static SENSOR_SCALE: Affine = Affine { declaration: &DECLARATION };

static DECLARATION: Declaration = Declaration {
    kind: "sensor-scale",
    name: "scale",
    summary: "Gain and offset of the sensor",
    equation: "y = gain*x + offset",
    reference: "linear sensor",
    stage: Stage::Sensor,
    effect: Some(&effects::ACTUATOR_GAIN),
    phenomena: &[&phenomena::SENSOR_SCALE],
    parameters: &[
        Quantity::new("gain", "1", "Reading per position").start(1.0).fitted(),
        Quantity::new("offset", "{position}", "Reading at position 0").start(0.0).fitted(),
    ],
    ..Declaration::PATH
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn scales_and_shifts() {
        let mut scale = Instance::new(&SENSOR_SCALE, &[], &[1.25, -3.0], 1e-3).unwrap();
        assert_eq!(scale.rest(&[8.0]), 7.0);
        assert_eq!(scale.step(&[4.0]), 2.0);
    }
}
