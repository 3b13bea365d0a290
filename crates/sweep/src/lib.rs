//! Many runs from one plan: what each run gets, who runs which, and what is kept.
//!
//! ```text
//! Plan ── Targets (what may vary, from the FMUs) ──▶ Design ── point(run) ──▶ values of a run
//!                                                     │
//! Shard i/n ──▶ runs to do ── Journal (what is done) ─┴─▶ work(threads) ──▶ rows ──▶ Table (Parquet)
//! ```
//!
//! It knows neither FMUs nor commands: a [`Worker`] makes the row of a run, however it does that.
//!
//! # Why results do not depend on who computes them
//! The values of a run follow from the plan's seed, the name of each varied variable and the number of
//! the run alone ([`Design`]); a worker may keep nothing from one run to the next; rows are written in
//! the order of the runs, in row groups of a fixed size. So threads, shards, a run that was killed
//! and went on, and the machine leave no trace in the file.

mod design;
mod draw;
mod error;
mod journal;
mod plan;
mod row;
mod shard;
mod table;
mod work;

pub use design::{Design, Target, Variable};
pub use error::Error;
pub use journal::{Journal, frame};
pub use plan::{Campaign, ClosedLoop, Coupling, Kind, Law, Measure, Plan, Scalar, SystemRun, Take};
pub use row::{Cell, Column, ColumnKind, Row};
pub use shard::Shard;
pub use table::{About, Table};
pub use work::{Worker, work};
