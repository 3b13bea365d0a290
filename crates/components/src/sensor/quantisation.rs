//! Resolution of the reading's converter.
//!
//! `y = resolution·(round(x/resolution − phase) + phase)`, halves away from zero
//!
//! * resolution: the step of the converter, its range over 2^bits; phase: where its codes lie between two multiples of
//!   the resolution, 0 for a code at zero, 0.5 for an edge there.
//! * No state.
//!
//! Limits: ideal steps; the range is not its matter.

use model::{Declaration, Quantity, Stage};

use crate::quantiser::Quantiser;
use crate::{effects, phenomena};

/// The component `sensor-quantisation`.
pub static SENSOR_QUANTISATION: Quantiser = Quantiser { declaration: &DECLARATION };

static DECLARATION: Declaration = Declaration {
    kind: "sensor-quantisation",
    name: "adc",
    summary: "Resolution of the reading's converter",
    equation: "y = resolution*(round(x/resolution - phase) + phase)",
    reference: "B. Widrow, I. Kollar, Quantization Noise, Cambridge University Press 2008",
    stage: Stage::Sensor,
    effect: Some(&effects::SENSOR_QUANTISATION),
    phenomena: &[&phenomena::READING_QUANTISATION],
    parameters: &[
        Quantity::new("resolution", "{position}", "Step of the converter: range over 2^bits")
            .min(0.0)
            .fitted(),
        Quantity::new("phase", "1", "Place of the codes between two multiples of the resolution")
            .start(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};
