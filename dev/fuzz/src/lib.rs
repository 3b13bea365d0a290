//! Hostile input for every reader of files: what it must never do is panic, hang or take memory
//! without bound.
//!
//! ```text
//! corpus/<target>/ ─▶ mutate (text, zip archive, binary) ─▶ Target::run ─▶ new behaviour? ─▶ pool
//! ```
//!
//! [`targets`] are the readers. [`campaign::run`] tries mutated files in this process, on any
//! compiler, and keeps those that make a reader say something new; the program `guided` gives the
//! same targets and mutations to libFuzzer, which keeps what reaches new code.

pub mod campaign;
mod instrument;
pub mod mutate;
mod random;
mod target;
mod zip;

pub use instrument::NO_COMPILER;
pub use random::Random;
pub use target::{Kind, Scratch, Target, corpus, targets};
