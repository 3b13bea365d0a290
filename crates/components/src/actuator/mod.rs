//! The actuator apart from its memory: gain, temperature, polarisation, thermal port.

mod ageing;
mod gain;
mod polarisation_saturation;
mod remanence;
mod self_heating;
mod temperature;
mod thermal_port;

pub use ageing::ActuatorAgeing;
pub use gain::ACTUATOR_GAIN;
pub use polarisation_saturation::PolarisationSaturation;
pub use remanence::Remanence;
pub use self_heating::SelfHeating;
pub use temperature::ActuatorTemperature;
pub use thermal_port::ThermalPort;

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry = &[
    &PolarisationSaturation,
    &ACTUATOR_GAIN,
    &ActuatorTemperature,
    &ActuatorAgeing,
    &SelfHeating,
    &ThermalPort,
];
