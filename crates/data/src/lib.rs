//! Logs and blueprints: read, write, check, resample.
//!
//! * [`Blueprint`]: the file that says which components a plant or a controller has, and with which
//!   values. Reading gives the *unchecked* type; [`Blueprint::check`] gives a [`CheckedBlueprint`],
//!   from which a [`model::System`] is built, or every [`Problem`] there is.
//! * [`Log`]: measured or simulated time series with units, in records.
//! * [`NameMap`]: which column of a log belongs to which variable of a model.
//! * [`Uniform`]: a signal on a uniform grid, and its resampling onto another one.
//! * [`Fit`]: figures of agreement between two signals.
//! * [`AtomicFile`]: a file that appears whole or not at all.

mod blueprint;
#[cfg(feature = "logs")]
mod counted;
#[cfg(feature = "logs")]
mod fit;
#[cfg(feature = "logs")]
pub mod inner_steps;
#[cfg(feature = "logs")]
mod log;
#[cfg(feature = "logs")]
mod name_map;
mod nearest;
mod number_text;
mod pattern;
mod problem;
#[cfg(feature = "logs")]
mod resample;
mod toml_kind;
mod toml_text;

pub use blueprint::{
    AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint, ConnectionBlueprint,
    CouplingBlueprint, ParameterRecord, RecordValue, SignalBlueprint, Value, npy_of,
};
#[cfg(feature = "logs")]
pub use counted::counted;
pub use files::AtomicFile;
#[cfg(feature = "logs")]
pub use fit::{Fit, FitError};
#[cfg(feature = "formats")]
pub use log::Format;
#[cfg(feature = "parquet")]
pub use log::ParquetLogWriter;
#[cfg(feature = "logs")]
pub use log::{
    Column, ColumnHeader, ColumnUnit, Finding, LeftOut, Log, LogWriter, Mf4About, Mf4Writer,
    Quality, ReadOptions, Record, Resample, Rounded, SampleTime, UnitPlace, check_sidecar,
    renew_sidecar, sidecar_of, write_sidecar,
};
#[cfg(feature = "logs")]
pub use name_map::NameMap;
pub use nearest::nearest;
pub use number_text::push_number;
pub use pattern::fits_pattern;
pub use problem::{Problem, Problems};
#[cfg(feature = "logs")]
pub use resample::{Hold, ResampleError, Uniform};
pub use toml_kind::{of_another_kind, toml_kind};
