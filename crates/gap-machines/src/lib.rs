//! Machines with a withheld effect: an independent generator of measured logs.
//!
//! A [`Scene`] is a machine drawn at random: a baseline that a model knows within tolerance, effects
//! that it does not know, brought to a stated size, and records of several kinds with noise. The
//! crate shares no code with the rest of the workspace, so that no formula of the generator can be
//! one of the diagnosis by accident.
//!
//! ```text
//! Order ─▶ Baseline::draw, off ─▶ magnitude of each effect by its size after the re-tune ─▶ records
//! ```
//!
//! Size: root mean square of what the re-tuned model leaves of the noise-free reading, over the
//! standard deviation of the noise. An effect that the re-tune absorbs has no size.

mod baseline;
mod blocks;
mod build;
mod effect;
mod machine;
mod random;
mod records;
mod scene;
mod size;
mod tune;

pub use baseline::{Baseline, COMMAND_SPAN, TOLERANCES, Tolerances, blueprint};
pub use effect::{Effect, Formula, Insertion};
pub use machine::{Drive, Machine};
pub use random::Random;
pub use records::{Kind, neighbour, noise};
pub use scene::{Order, Record, Scene, Setting, Timing, Wish, rounded};
pub use size::{Unreachable, magnitude};
pub use tune::{Tuned, Tuner, rms};
