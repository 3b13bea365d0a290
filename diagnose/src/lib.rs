//! From the gap between a machine and its model to the physical effects that cause it.
//!
//! ```text
//! model + logs ─▶ residual in simulation mode ─▶ re-tune under tolerance ─▶ candidates: screen, fit
//!     ─▶ held-out acceptance, sets, probabilities ─▶ where, how much, what next, repaired model
//! ```
//!
//! [`diagnose`] gives the answer as [`Gap`], the content of `gap.json`.

mod error;
mod gap;
mod request;

pub use error::Error;
pub use gap::{
    BandShare, Estimate, Gap, HeldOut, Leftover, NamedEffect, NextExperiment, NoiseFloor,
    OutputGap, Place, Provenance, RecordShare, Retuned, SCHEMA, Shrink, Tried, Verdict,
};
pub use identify::{Observer, Silent};
pub use request::{Deviation, Model, Noise, Request, Tolerance};
