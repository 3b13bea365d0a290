//! Time and converters: delay, clock, quantisation of the command.

mod clock_offset;
mod dac_quantisation;
pub(crate) mod delay;

pub use clock_offset::ClockOffset;
pub use dac_quantisation::DAC_QUANTISATION;
pub use delay::Delay;

/// The components of this folder, in the order of the signal path.
pub(crate) static COMPONENTS: model::Registry = &[&Delay, &ClockOffset, &DAC_QUANTISATION];
