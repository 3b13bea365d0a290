//! Surroundings: temperature, floor.

mod disturbance;
mod floor_vibration;
mod thermal_drift;
mod thermal_expansion;

pub use disturbance::Disturbance;
pub use floor_vibration::FloorVibration;
pub use thermal_drift::ThermalDrift;
pub use thermal_expansion::ThermalExpansion;

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry =
    &[&ThermalDrift, &ThermalExpansion, &Disturbance, &FloorVibration];
