//! Test signals by name: every signal of the five papers, and the general ones of the field.
//!
//! A [`SignalType`] declares its name, sentence, source, equation, parameters, channels and rules
//! once; the families in [`FAMILIES`] are the one list of all of them. A [`Signal`] is the result:
//! channels with units on the grid t = n·T, n = 0 … N − 1. The functions of mathematics come from
//! `libm` and the random numbers from ChaCha8 with a stated seed, so a signal has the same bits on
//! every machine.
//!
//! ```
//! use signals as signals;
//!
//! let chirp = signals::lookup("p3-chirp")?;
//! let signal = chirp.generate(&[("duration", 0.1)])?;
//! assert_eq!((signal.len(), signal.period, signal.channels[0].unit.as_str()), (2000, 50e-6, "V"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod general;
mod papers;
mod parameter;
mod random;
mod registry;
mod rules;
mod shape;
mod signal;
mod signal_type;
mod table;

pub use error::{Problem, SignalError, UnknownSignal};
pub use parameter::Parameter;
pub use registry::{FAMILIES, Family, all, find, lookup};
pub use signal::{Channel, Signal};
pub use signal_type::{ChannelType, MAX_SAMPLES, Rule, Settings, SignalType};
pub use table::{document, reference, table};
