//! Plants and inverses by learned models: kernels over features of a record, and the linear part
//! behind them.
//!
//! A pair of a record is the command that is held over a sample and the position at the end of it:
//! row k of a log and row k + 1 ([`pairs`]).

mod arx;
mod cascade;
mod evidence;
pub(crate) mod family;
pub mod inverse;
mod machine;
pub(crate) mod network;
pub(crate) mod plant;
mod process;
mod projection;
mod selection;
mod series;
mod spline;
mod synthetic_data;
mod weighed;

pub use arx::Arx;
pub use evidence::{EvidenceWeighted, GREATEST_GAMMA, weigh, weigh_samples};
pub use inverse::InverseFigures;
pub use machine::{Frame, Machine, Recipe, Span};
pub use plant::learned_inverse;
pub use process::{Search, by_likelihood};
pub use selection::{BOUNDS, Records, Seek, Selected, Selection, held_out, select, sought};
pub use series::{Run, Series, Teaches, Turns};
pub use synthetic_data::{SEED, SyntheticData, Waves};
pub use weighed::Widths;

/// Commands with the positions that they lead to: the position of row k + 1 belongs to the command
/// of row k.
#[must_use]
pub fn pairs<'a>(command: &'a [f64], position: &'a [f64]) -> (&'a [f64], &'a [f64]) {
    let count = command.len().min(position.len().saturating_sub(1));
    (&command[..count], position.get(1..=count).unwrap_or(&[]))
}

/// Root mean square of the differences.
#[must_use]
pub fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().min(b.len()).max(1) as f64;
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / count).sqrt()
}
