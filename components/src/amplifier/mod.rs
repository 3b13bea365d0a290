//! The high-voltage amplifier.

mod lag;

pub use lag::AmplifierLag;
