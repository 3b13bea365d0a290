//! Import of FMI 2.0 co-simulation FMUs.

mod instance;
mod library;
mod state;
mod values;

pub use instance::{Instance, Instantiation};
pub use library::Library;
