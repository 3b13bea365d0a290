//! Import of FMI 3.0 co-simulation FMUs.
//!
//! Event mode with clocks, early return and configuration mode are there for those who ask for them;
//! without, every step goes to its end, as in FMI 2.0. Intermediate update is declined.

mod events;
mod instance;
mod library;
mod state;
mod values;

pub use events::Updated;
pub use instance::{Instance, Instantiation, Stepped};
pub use library::Library;
