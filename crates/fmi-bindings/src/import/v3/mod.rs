//! Import of FMI 3.0 co-simulation FMUs.
//!
//! Event mode, early return, intermediate update and clocks are declined: every step goes to its
//! end, as in FMI 2.0.

mod instance;
mod library;
mod state;
mod values;

pub use instance::{Instance, Instantiation};
pub use library::Library;
