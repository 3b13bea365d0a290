//! The withheld-effect benchmark: does the diagnosis name what a machine does and its model does not?
//!
//! ```text
//! Plan::cases ─▶ gap_machines::Scene ─▶ cases/<id>/ (model, logs, question) ─▶ tool ─▶ gap.json ─┐
//!                                   └─▶ truth/<id>/ (label, unseen records) ─────────▶ Scores ◀──┘
//! ```
//!
//! The tool under test is a program of its own that is started in the folder of a case; labels lie in
//! another folder, under names that say nothing, and only the scorer reads them. [`run()`] leaves out
//! the cases that have been answered, so that a benchmark can be stopped and gone on with.

mod answer;
mod case;
mod error;
mod families;
mod judge;
mod label;
mod page;
mod prepare;
mod real;
mod run;
mod score;
mod statistics;
mod target;
mod text;
mod tool;

pub use answer::{Answer, Leftover, Named, Shrink};
pub use case::{Case, NoiseHint, Plan, SIZES, select};
pub use error::Error;
pub use families::{FAMILIES, Family};
pub use label::{Label, Miss, TrueEffect};
pub use prepare::{Folders, Question, prepare};
pub use real::{Judgement, Measured, Real, real};
pub use run::{Outcome, Realised, Settings, run};
pub use score::{
    Confusion, Failure, OfEffect, Removed, Scores, ShrinkPair, Single, Times, Verdicts,
};
pub use statistics::{Bin, Calibration, Rate, quantile};
pub use target::{Figure, Goal};
pub use text::CAUTION;
pub use tool::{Program, Tool};
