//! The position sensor and its conditioning.

mod butterworth;
mod crosstalk;
mod drift;
mod lag;
mod mains_hum;
mod noise;
mod polynomial;
mod quad_cell;
mod quantisation;
mod scale;
mod second_order;

pub use butterworth::SensorButterworth;
pub use crosstalk::Crosstalk;
pub use drift::SensorDrift;
pub use lag::SensorLag;
pub use mains_hum::MainsHum;
pub use noise::SensorNoise;
pub use polynomial::SensorPolynomial;
pub use quad_cell::SensorQuadCell;
pub use quantisation::SENSOR_QUANTISATION;
pub use scale::SENSOR_SCALE;
pub use second_order::SENSOR_SECOND_ORDER;

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry = &[
    &SensorLag,
    &SENSOR_SECOND_ORDER,
    &SensorButterworth,
    &SENSOR_SCALE,
    &SensorPolynomial,
    &SensorQuadCell,
    &SensorNoise,
    &SensorDrift,
    &MainsHum,
    &Crosstalk,
    &SENSOR_QUANTISATION,
];
