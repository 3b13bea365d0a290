//! The high-voltage amplifier.

mod clamp;
mod foldback;
mod lag;
mod nonlinearity;
mod piezo_charge;
mod rc;
mod second_order;
mod slew;

pub use clamp::AmplifierClamp;
pub use foldback::AmplifierFoldback;
pub use lag::AmplifierLag;
pub use nonlinearity::AmplifierNonlinearity;
pub use piezo_charge::PiezoCharge;
pub use rc::AmplifierRc;
pub use second_order::AMPLIFIER_SECOND_ORDER;
pub use slew::{AmplifierSlew, slewed};

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry = &[
    &AmplifierLag,
    &AMPLIFIER_SECOND_ORDER,
    &AmplifierRc,
    &AmplifierSlew,
    &AmplifierFoldback,
    &AmplifierClamp,
    &AmplifierNonlinearity,
    &PiezoCharge,
];
