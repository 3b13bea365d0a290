//! Import of FMI 2.0 co-simulation FMUs.

mod instance;
mod library;
mod state;
mod values;

pub use instance::{Experiment, Instance, Instantiation, StepResult};
pub use library::Library;
pub use state::SavedState;
