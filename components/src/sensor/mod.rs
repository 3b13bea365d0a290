//! The position sensor and its conditioning.

mod lag;

pub use lag::SensorLag;
