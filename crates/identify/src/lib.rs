//! From a measured log to a blueprint.
//!
//! * [`Record`]: the command of one axis and its position, checked; [`records_of`] takes them from a log.
//! * [`identify`]: records → plant. The static Prandtl–Ishlinskii model by non-negative least squares
//!   with an output-error fit for the linear parts, and every other hysteresis model of [`methods`]. The [`Identification`] carries the plant's blueprint
//!   and the evidence: figures in simulation mode on rows that were held out, the straight line they
//!   compare with, and what the data say about each parameter.
//! * [`simulate`] and [`compare`]: the fit of any plant to any record.
//!
//! Nothing prints; an [`Observer`] receives the progress of long work.

mod beginning;
pub mod calibration;
mod error;
mod estimates;
mod fit;
pub mod frequency;
mod identification;
mod identify;
mod judge;
pub mod learned;
mod methods;
mod observer;
mod plant;
mod record;
mod settings;
mod structure;

pub use beginning::{Beginning, beginnings};
pub use error::{Error, NotInvertible, Problem, SettingsProblem};
pub use fit::operator::Search;
pub use fit::swarm::Swarm;
pub use identification::{
    Candidate, Correlation, DeviationOutput, Estimate, Identification, Predicted, RULES, RecordFit,
    Verdict,
};
pub use identify::{SIGNIFICANT_FALL, identify};
pub use judge::{Figures, compare, simulate, simulate_axes};
pub use methods::{is_learned, methods};
pub use observer::{Observer, Silent};
pub use record::{Columns, Record, Rows, records_of};
pub use settings::{Dynamics, FeatureChoice, Learning, Methods, Settings, Target};
