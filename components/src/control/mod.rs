//! Control laws and feedforward.

mod feedforward_gain;
mod pid;
mod reference_lead;

pub use feedforward_gain::FeedforwardGain;
pub use pid::Pid;
pub use reference_lead::ReferenceLead;
