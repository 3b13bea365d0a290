//! The master: connect FMUs, step them, record.
//!
//! ```text
//! Fmu ── instantiate ──▶ Slave ┐
//! Fmu ── instantiate ──▶ Slave ┼▶ Diagram ── build (check) ──▶ System ── run(Algorithm) ──▶ Recorder
//! input table (Signals) ───────┘
//! ```
//!
//! It knows FMUs only, of any vendor. [`simulate_with_inputs`] drives one FMU by a log,
//! [`Loop`] closes the loop of a controller and a plant; both are short uses of [`Diagram`].
//!
//! # Rows
//! Row k of an input table, and of a record: u_k acts from t_k until t_{k+1} (zero-order hold);
//! y_k is read at t_k before u_k acts. Time is t_k = start + k·h, multiplied, never accumulated, or
//! that of a table's rows.
//!
//! # How old a value is when it acts
//! See [`algorithm`] for each kind of connection, [`Loop`] for the closed loop, with the same in
//! fmpy by hand.

pub mod algorithm;
mod bed;
mod closed_loop;
mod diagram;
mod error;
mod fmu;
pub mod isolate;
pub mod plan;
mod port;
mod problem;
pub mod record;
mod run;
mod signals;
mod simulate;
mod slave;
mod sought;
mod statistics;
mod system;
mod time;
mod unit;

pub use algorithm::{
    Algorithm, Extrapolation, GaussSeidel, Iteration, IterationSettings, Jacobi, Relaxation,
};
pub use bed::Bed;
pub use closed_loop::{Coupling, Loop, LoopSettings, Wiring};
pub use diagram::{Connection, Diagram};
pub use error::{Error, RunError};
pub use fmi_bindings::import::{Experiment, StepResult};
pub use fmi_bindings::import::{HOST, Message, OnMessage, Status, called, instances};
pub use fmu::{Fmu, InstanceOptions};
pub use isolate::Worker;
pub use plan::Plan;
pub use port::Port;
pub use problem::{Problem, Problems};
pub use record::{CsvFile, CsvRecorder, Memory, NpyFile, NpzFile, RecordFile, Recorder};
pub use run::Run;
pub use signals::{Signal, Signals};
pub use simulate::{Drive, Driven, simulate_with_inputs};
pub use slave::{ArrayRun, Selection, Slave, StateId, TypeRun, Value, unrecorded};
pub use sought::Sought;
pub use statistics::{FmuTimes, Statistics};
pub use system::{Ending, System};
pub use time::Points;
pub use unit::{Conversion, Transformations};
