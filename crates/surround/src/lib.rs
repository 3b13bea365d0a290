//! What a repaired FMU does before and behind the original.
//!
//! ```text
//! inputs of the host ── blocks of the inputs ── the original ── blocks of the outputs ── outputs
//! ```
//!
//! A [`Repair`] says which blocks there are and under which value references their parameters are
//! found; it is the file `repair.toml` in the resources of a repaired FMU. A [`Surround`] is what
//! steps: it knows nothing of FMI but numbers and value references. Blocks compute in SI; the
//! factors of the original's units stand at its ports.

mod block;
mod map;
mod mechanics;
mod memory;
mod rated;
mod repair;
mod state;
mod surround;
mod tangent;
mod warmth;
mod whole;

pub use block::{Block, Wires};
pub use mechanics::{Force, ForcedMode};
pub use rated::Growth;
pub use repair::{
    Change, Effect, Error, FILE, FORMAT, Original, Parameter, Piece, Port, Repair, Side, Variable,
};
pub use state::State;
pub use surround::{Surround, Unset};
pub use tangent::{Directions, Jump};
pub use warmth::Loss;
pub use whole::Whole;
