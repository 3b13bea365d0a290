//! Control laws and feedforward.

mod feedforward_gain;
mod pid;

pub use feedforward_gain::FeedforwardGain;
pub use pid::Pid;
