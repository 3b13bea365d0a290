//! The plant library and the control laws: one file per component.
//!
//! Folders are the stages of the signal path. A component is a unit type, or a static of a type that
//! several share, that implements [`model::Component`]; to add one, write its file and its lines in
//! the `mod.rs` of its folder. The physical causes that the diagnosis tells apart are in [`effects`],
//! the rows of the documentation's catalogue in [`phenomena`]. Nothing here allocates; functions come
//! from `libm`, so that results are equal on every machine.
#![no_std]
#[cfg(test)]
extern crate std;

pub mod actuator;
pub mod amplifier;
pub mod control;
pub mod coupling;
pub mod creep;
pub mod effects;
pub mod environment;
pub mod forced;
pub mod hysteresis;
pub mod linear;
pub mod mechanics;
pub mod phenomena;
pub mod random;
pub mod sensor;
pub mod solve;
pub mod timing;
pub mod turn;

mod affine;
mod low_pass;
mod quantiser;
mod rules;
#[cfg(test)]
mod testing;

/// The parts of [`COMPONENTS`], in the order of the signal path.
static STAGES: [model::Registry; 11] = [
    timing::COMPONENTS,
    amplifier::COMPONENTS,
    actuator::COMPONENTS,
    hysteresis::OPERATORS,
    creep::COMPONENTS,
    mechanics::COMPONENTS,
    coupling::COMPONENTS,
    environment::COMPONENTS,
    sensor::COMPONENTS,
    hysteresis::INVERSES,
    control::COMPONENTS,
];

/// All component types, in the order of the signal path.
pub static COMPONENTS: model::Registry = &ALL;

static ALL: [&dyn model::Component; model::count(&STAGES)] = model::joined(&STAGES);

/// The component type of this name (a blueprint's `type`).
#[must_use]
pub fn find(kind: &str) -> Option<&'static dyn model::Component> {
    COMPONENTS.iter().copied().find(|c| c.declaration().kind == kind)
}
