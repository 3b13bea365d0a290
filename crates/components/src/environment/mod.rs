//! Surroundings: temperature, floor.

mod disturbance;
mod floor_vibration;
mod thermal_drift;
mod thermal_expansion;

pub use disturbance::Disturbance;
pub use floor_vibration::FloorVibration;
pub use thermal_drift::ThermalDrift;
pub use thermal_expansion::ThermalExpansion;
