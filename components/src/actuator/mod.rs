//! The actuator apart from its memory: gain, temperature, polarisation.

mod gain;
mod polarisation_saturation;
mod self_heating;
mod temperature;

pub use gain::ActuatorGain;
pub use polarisation_saturation::PolarisationSaturation;
pub use self_heating::SelfHeating;
pub use temperature::ActuatorTemperature;
