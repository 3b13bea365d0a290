//! Time and converters: delay, clock, quantisation of the command.

mod clock_offset;
mod dac_quantisation;
pub(crate) mod delay;

pub use clock_offset::ClockOffset;
pub use dac_quantisation::DAC_QUANTISATION;
pub use delay::Delay;
