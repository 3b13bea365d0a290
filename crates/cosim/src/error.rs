//! What can go wrong in a co-simulation.

use std::fmt;

use fmi_bindings::import;

use crate::problem::Problems;

/// An error of the master.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An FMU refused a call; the message names the FMU, the call and what the FMU says.
    #[error(transparent)]
    Fmu(#[from] import::Error),
    /// An FMU gave up a step without asking for the end of the run.
    #[error("FMU `{fmu}`: fmi2DoStep over {step} s returned Discard{}; \
             try a smaller communication step", reached_text(*reached))]
    Discarded {
        /// Name of the FMU.
        fmu: String,
        /// The step that was asked for, s.
        step: f64,
        /// Time that the FMU reached, s, if it tells.
        reached: Option<f64>,
    },
    /// A value that the variable's type cannot hold.
    #[error("FMU `{fmu}`: variable `{variable}` is of type {data_type} and cannot take {value}")]
    Type {
        /// Name of the FMU.
        fmu: String,
        /// Name of the variable.
        variable: String,
        /// The variable's type.
        data_type: &'static str,
        /// The value.
        value: String,
    },
    /// An output that is no number, or none that anything can be computed with.
    #[error(
        "FMU `{fmu}`: variable `{variable}` has become {value}; look whether its inputs and \
         parameters are those it is made for, or try a smaller communication step"
    )]
    NotFinite {
        /// Name of the FMU.
        fmu: String,
        /// Name of the variable.
        variable: String,
        /// NaN, inf or -inf.
        value: f64,
    },
    /// An FMU wrote more values than it was asked for.
    #[error(
        "FMU `{fmu}`: {call} was asked for {asked} values and wrote more, which the standard forbids: \
         its library does not fit its modelDescription.xml; ask its maker for a sound export"
    )]
    Overrun {
        /// Name of the FMU.
        fmu: String,
        /// The function.
        call: &'static str,
        /// Values that it was asked for.
        asked: usize,
    },
    /// The FMU does not offer what is asked for.
    #[error("FMU `{fmu}` cannot {what}: its model description does not state {attribute}")]
    NotOffered {
        /// Name of the FMU.
        fmu: String,
        /// What was asked for.
        what: &'static str,
        /// The capability flag.
        attribute: &'static str,
    },
    /// An algebraic loop without solution in the passes allowed.
    #[error(
        "the algebraic loop of {variables} is not solved after {iterations} passes: {worst} still \
         changes by {change:e} to {value:e} (tolerance {tolerance:e} of its largest magnitude); \
         allow more passes, relax more, or step less far"
    )]
    Loop {
        /// The outputs whose values are guessed.
        variables: String,
        /// Passes that were made.
        iterations: usize,
        /// The output that changes most.
        worst: String,
        /// The worst's value.
        value: f64,
        /// The value's last change.
        change: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// A clock that cannot be let tick.
    #[error("FMU `{fmu}`: clock `{clock}`: {what}")]
    Clock {
        /// Name of the FMU.
        fmu: String,
        /// Name of the clock.
        clock: String,
        /// What is wrong and the way out.
        what: String,
    },
    /// An FMU whose discrete states do not settle.
    #[error(
        "FMU `{fmu}`: the event at t = {time} s is not over after {passes} calls of \
         fmi3UpdateDiscreteStates: the FMU asks for another one each time, or lets a clock tick again \
         at once"
    )]
    Events {
        /// Name of the FMU.
        fmu: String,
        /// Time of the event, s.
        time: f64,
        /// Calls that were made.
        passes: usize,
    },
    /// A WebAssembly component that refused a call, or left its bounds.
    #[error("FMU `{fmu}`: {call}: {what}")]
    Component {
        /// Name of the FMU.
        fmu: String,
        /// The function of the component.
        call: String,
        /// What is wrong.
        what: String,
    },
    /// The settings do not fit together; all problems at once.
    #[error(transparent)]
    Problems(#[from] Problems),
    /// A file that describes a system is wrong; all problems at once.
    #[error(transparent)]
    File(#[from] data::Problems),
    /// An SSP is wrong; all problems at once.
    #[error(transparent)]
    Ssp(#[from] modeldescription::ssp::SspError),
    /// The package cannot be opened, or has no library for this machine.
    #[error(transparent)]
    Open(#[from] modeldescription::PackageError),
    /// The package has no use here.
    #[error("{path}: {reason}")]
    Package {
        /// The FMU's file or folder.
        path: std::path::PathBuf,
        /// What is wrong and the way out.
        reason: String,
    },
    /// No process can be started for an FMU, which is no fault of the FMU.
    #[error("no process can be started for the FMU `{fmu}` ({}): {error}", program.display())]
    NoProcess {
        /// Name of the FMU.
        fmu: String,
        /// What was to be started.
        program: std::path::PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// An FMU in a process of its own failed; the message names it.
    #[error("{0}")]
    Worker(String),
    /// An FMU in a process of its own crashed or took too long; the message names it.
    #[error("{0}")]
    Lost(String),
    /// The record cannot be written.
    #[error("the record cannot be written: {0}")]
    Record(#[from] std::io::Error),
    /// A run ended early; what was recorded until then is kept.
    #[error(transparent)]
    Run(#[from] Box<RunError>),
}

/// Where in a run an error came up.
#[derive(Debug)]
pub struct RunError {
    /// Number of the record (experiment) of the run, from 0.
    pub record: usize,
    /// Communication point at which the failing step began, s.
    pub time: f64,
    /// What happened.
    pub cause: Error,
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.record {
            0 => write!(f, "at t = {} s: {}", self.time, self.cause),
            record => write!(f, "in record {record} at t = {} s: {}", self.time, self.cause),
        }
    }
}

impl std::error::Error for RunError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.cause)
    }
}

fn reached_text(reached: Option<f64>) -> String {
    reached.map_or_else(String::new, |time| format!(", having reached t = {time} s"))
}
