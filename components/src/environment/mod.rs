//! Surroundings: temperature, floor.

mod floor_vibration;
mod thermal_drift;

pub use floor_vibration::FloorVibration;
pub use thermal_drift::ThermalDrift;
