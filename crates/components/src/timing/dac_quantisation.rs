//! Resolution of the command's converter.
//!
//! `y = resolution·round(x/resolution)`, halves away from zero
//!
//! * resolution: the step of the converter, its range over 2^bits.
//! * No state.
//!
//! Limits: ideal steps; the range is not its matter.

use model::{Declaration, Quantity, Stage};

use crate::quantiser::Quantiser;
use crate::{effects, phenomena};

/// The component `dac-quantisation`.
pub static DAC_QUANTISATION: Quantiser = Quantiser { declaration: &DECLARATION };

static DECLARATION: Declaration = Declaration {
    kind: "dac-quantisation",
    name: "dac",
    summary: "Resolution of the command's converter",
    equation: "y = resolution*round(x/resolution)",
    reference: "B. Widrow, I. Kollar, Quantization Noise, Cambridge University Press 2008",
    stage: Stage::Timing,
    effect: Some(&effects::DAC_QUANTISATION),
    phenomena: &[&phenomena::COMMAND_QUANTISATION],
    parameters: &[Quantity::new(
        "resolution",
        "{command}",
        "Step of the converter: range over 2^bits",
    )
    .min(0.0)
    .fitted()],
    ..Declaration::PATH
};
