//! The plant library and the control laws: one file per component.
//!
//! Folders are the stages of the signal path. A component is a unit type that implements
//! [`model::Component`]; to add one, write its file and its line in [`COMPONENTS`]. The physical
//! causes that components stand for are in [`effects`]. Nothing here allocates; functions come from
//! `libm`, so that results are equal on every machine.
#![no_std]
#[cfg(test)]
extern crate std;

pub mod actuator;
pub mod amplifier;
pub mod control;
pub mod effects;
pub mod hysteresis;
pub mod linear;
pub mod mechanics;
pub mod sensor;
pub mod timing;

mod rules;
#[cfg(test)]
mod testing;

/// All component types, in the order of the signal path.
pub static COMPONENTS: model::Registry = &[
    &timing::Delay,
    &amplifier::AmplifierLag,
    &actuator::ActuatorGain,
    &hysteresis::PrandtlIshlinskii,
    &hysteresis::ModifiedPrandtlIshlinskii,
    &hysteresis::GeneralisedPlay,
    &hysteresis::Preisach,
    &hysteresis::BoucWen,
    &hysteresis::Duhem,
    &hysteresis::Dahl,
    &hysteresis::RateDependentPlay,
    &hysteresis::Grpi,
    &hysteresis::Mpi,
    &hysteresis::DynamicPrandtlIshlinskii,
    &mechanics::Mode,
    &sensor::SensorLag,
    &hysteresis::InversePrandtlIshlinskii,
    &hysteresis::InverseModifiedPrandtlIshlinskii,
    &hysteresis::InverseGeneralisedPlay,
    &hysteresis::INVERSE_BOUC_WEN,
    &hysteresis::INVERSE_RATE_DEPENDENT_PLAY,
    &hysteresis::INVERSE_GRPI,
    &hysteresis::INVERSE_MPI,
    &hysteresis::INVERSE_DYNAMIC_PRANDTL_ISHLINSKII,
    &control::FeedforwardGain,
    &control::Pid,
];

/// The component type of this name (a blueprint's `type`).
#[must_use]
pub fn find(kind: &str) -> Option<&'static dyn model::Component> {
    COMPONENTS.iter().copied().find(|c| c.declaration().kind == kind)
}
