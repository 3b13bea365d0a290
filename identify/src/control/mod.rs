//! From a plant to its controller.

mod closed_loop;
mod invert;
mod linearised;
mod loop_shape;

pub use closed_loop::{LoopRun, simulate_loop};
pub use invert::{ControlSettings, Inversion, LoopFigures, invert};
