//! Bandwidth of the amplifier, second order.
//!
//! `v″ + 2ζω v′ + ω² v = ω²·gain·u`, ω = 2π·frequency
//!
//! * frequency in Hz: natural frequency (the −3 dB bandwidth for ζ = 0.707); damping: ζ > 0; gain:
//!   as of `amplifier-lag`.
//! * State: v and v′/ω. Exact at any period, as the input is held over a step.
//!
//! Limits: linear: no current limit, no saturation.

use model::{Declaration, Quantity, Stage};

use crate::low_pass::{self, LowPass};
use crate::{effects, phenomena};

/// The component `amplifier-second-order`.
pub static AMPLIFIER_SECOND_ORDER: LowPass =
    LowPass { declaration: &DECLARATION, law: low_pass::with_gain, extended: |_| None };

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-second-order",
    name: "amplifier",
    summary: "Second-order bandwidth of the amplifier into the actuator's capacitance",
    equation: "v'' + 2*damping*w*v' + w^2*v = w^2*gain*u; w = 2*pi*frequency",
    reference: "A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning \
                Systems, Springer 2014, ch. 14",
    stage: Stage::Amplifier,
    effect: Some(&effects::AMPLIFIER_BANDWIDTH),
    phenomena: &[&phenomena::AMPLIFIER_SECOND_ORDER],
    parameters: &[
        Quantity::new("frequency", "Hz", "Natural frequency").min(0.0).fitted(),
        Quantity::new("damping", "1", "Damping ratio; 0.707 is flat").min(0.0).fitted(),
        Quantity::new("gain", "1", "Gain at low frequency").start(1.0).fitted(),
    ],
    ..Declaration::PATH
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_flat_amplifier_overshoots_by_four_percent() {
        let mut amplifier = Instance::new(
            &AMPLIFIER_SECOND_ORDER,
            &[],
            &[1000.0, core::f64::consts::FRAC_1_SQRT_2, 10.0],
            1e-6,
        )
        .unwrap();
        let peak = amplifier.response(0.0, &[1.0; 2000]).iter().fold(0.0f64, |m, v| m.max(*v));
        assert!((peak / 10.0 - 1.0 - (-core::f64::consts::PI).exp()).abs() < 1e-5, "{peak}");
    }
}
