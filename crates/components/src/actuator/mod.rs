//! The actuator apart from its memory: gain, temperature, polarisation.

mod ageing;
mod gain;
mod polarisation_saturation;
mod remanence;
mod self_heating;
mod temperature;

pub use ageing::ActuatorAgeing;
pub use gain::ACTUATOR_GAIN;
pub use polarisation_saturation::PolarisationSaturation;
pub use remanence::Remanence;
pub use self_heating::SelfHeating;
pub use temperature::ActuatorTemperature;
