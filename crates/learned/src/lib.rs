//! Models learned from data: least-squares support vector machines, Gaussian processes, and plays with a small network.
//!
//! * [`COMPONENTS`]: the list of all component types, with those that run learned tables.
//! * [`KernelSum`]: the function that they all are, evaluated without allocation.
//! * [`lssvm`]: training, cross-validation, leave-one-out, pruning.
//! * [`Compressor`]: fewer centres for the same function.
//! * [`gp`]: training by marginal likelihood, predictive variance.
//! * [`features`]: from signals to inputs, step by step, as in real time.
//! * [`plays`]: plays between curves with creep, corrected by a small network.
//! * [`tune`]: searches for the settings: grid, particle swarm, annealing, simplex.
//!
//! Without the feature `train` only what runs in real time is there.

mod components;
#[cfg(feature = "train")]
mod compress;
mod deviation;
#[cfg(feature = "train")]
mod error;
pub mod features;
#[cfg(feature = "train")]
pub mod gp;
mod kernel_sum;
#[cfg(feature = "train")]
pub mod lssvm;
mod simd;
#[cfg(feature = "train")]
mod solve;
#[cfg(all(test, feature = "train"))]
mod testing;
#[cfg(feature = "train")]
pub mod tune;

pub use components::COMPONENTS;
pub use components::plays;
#[cfg(feature = "train")]
pub use compress::Compressor;
pub use deviation::Deviation;
#[cfg(feature = "train")]
pub use error::Error;
pub use kernel_sum::KernelSum;
#[cfg(feature = "train")]
pub use solve::Route;
