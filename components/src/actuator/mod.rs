//! The actuator apart from its memory: gain, temperature, polarisation.

mod gain;

pub use gain::ActuatorGain;
