//! Time and converters: delay, clock, quantisation of the command.

mod delay;

pub use delay::Delay;
