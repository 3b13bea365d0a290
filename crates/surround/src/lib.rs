//! What effects do to signals, and what a repaired FMU does with them before and behind the original.
//!
//! A [`Block`] is one effect on one signal. With its parameters and a step length it is a [`Kernel`], which steps
//! in a repaired FMU and runs whole signals in the diagnosis: one formula, the same bits.
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
mod component;
mod kernel;
mod last_step;
mod linear;
mod map;
mod mechanics;
mod memory;
mod operator;
mod port_variable;
mod prepare;
mod rated;
mod repair;
mod span;
mod state;
mod surround;
mod tangent;
mod warmth;

pub use block::Block;
pub use kernel::{Count, Kernel, Signals, Stepped, Wires, WrongCount, exactly};
pub use linear::time_of;
pub use map::code;
pub use mechanics::{Acting, Force, forced_mode, forced_rest};
pub use operator::Operator;
pub use port_variable::PortVariable;
pub use rated::Growth;
pub use repair::{
    Change, Effect, Error, FILE, FORMAT, Original, Parameter, Piece, Port, Repair, Side, Variable,
};
pub use span::{Memory, Span};
pub use state::State;
pub use surround::{Surround, Unset};
pub use tangent::{Directions, Jump};
pub use warmth::Loss;
