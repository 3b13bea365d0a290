//! A linear actuator: position proportional to command.
//!
//! `y = gain · u + offset`
//!
//! * gain in position per command (effective d33 times the number of layers, times every other
//!   constant factor of the path that data cannot separate).
//! * No state.
//!
//! Limits: no hysteresis, no dynamics; a linear baseline, or the actuator in front of a mode whose
//! gain is 1.

use model::{Conversion, Declaration, Quantity, Role, Stage};

use crate::affine::Affine;
use crate::{effects, phenomena};

/// The component `actuator-gain`.
pub static ACTUATOR_GAIN: Affine = Affine { declaration: &DECLARATION };

static DECLARATION: Declaration = Declaration {
    kind: "actuator-gain",
    name: "gain",
    summary: "Linear actuator: position proportional to command",
    equation: "y = gain*u + offset",
    reference: "linear piezoelectric effect, IEEE Std 176-1987",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::ACTUATOR_GAIN),
    phenomena: &[&phenomena::ACTUATOR_GAIN],
    parameters: &[
        Quantity::new("gain", "{position}/{command}", "Position per command")
            .role(Role::Slope)
            .fitted(),
        Quantity::new("offset", "{position}", "Position at zero command").start(0.0).fitted(),
    ],
    ..Declaration::PATH
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn position_is_gain_times_command_plus_offset() {
        let mut gain = Instance::new(&ACTUATOR_GAIN, &[], &[0.25, 3.0], 1e-3).unwrap();
        assert_eq!(gain.rest(&[8.0]), 5.0);
        assert_eq!(gain.step(&[-4.0]), 2.0);
    }
}
