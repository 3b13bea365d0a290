//! What can go wrong, with the way out.

use thiserror::Error as ThisError;

/// Why an identification or an inversion was not done.
#[derive(Clone, Debug, PartialEq, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// The records cannot be identified from; every problem that was found.
    #[error("{}", list(.0))]
    Unsuitable(Vec<Problem>),
    /// The settings contradict themselves or the records; every problem that was found.
    #[error("{}", list(.0))]
    Settings(Vec<SettingsProblem>),
    /// A solver ended without a valid answer. No model is returned then.
    #[error(
        "the fit has no valid solution: {reason}; take fewer plays, drop more of the run-in, or \
         check the log for outliers"
    )]
    NoSolution {
        /// What was found.
        reason: &'static str,
    },
    /// A learned model that was not trained.
    #[error("{message}")]
    Learned {
        /// What was found, and the way out.
        message: String,
    },
    /// None of the methods that were named has a model.
    #[error("{}", no_model(.failures))]
    NoModel {
        /// Name of each method, and why it has none.
        failures: Vec<(&'static str, Error)>,
    },
    /// A Jacobian cannot be calibrated from these motions.
    #[error("{message}")]
    Calibration {
        /// What was found, and the way out.
        message: String,
    },
    /// An experiment on a machine gave no gains.
    #[error("{message}")]
    Tuning {
        /// What was found, and the way out.
        message: String,
    },
    /// A method that does not exist.
    #[error("\"{name}\" is no method; there are {names}")]
    NoMethod {
        /// The name.
        name: String,
        /// Names of the methods that there are.
        names: String,
    },
    /// The caller asked to stop before there was a result.
    #[error("stopped before there was a model; let it run until the first one is fitted")]
    Stopped,
    /// The output falls where the input rises.
    #[error(
        "{record}: \"{output}\" falls where \"{input}\" rises (gain {gain:.4e}), and the model's \
         weights are zero or positive; change the sign of the output column, or check that the \
         two columns belong to the same axis"
    )]
    NegativeGain {
        /// The record.
        record: String,
        /// Name of the input.
        input: String,
        /// Name of the output.
        output: String,
        /// Gain of the best straight line.
        gain: f64,
    },
    /// A blueprint cannot be built or run.
    #[error("{name}: {message}")]
    Model {
        /// Name of the model.
        name: String,
        /// What the model says.
        message: String,
    },
    /// A log lacks a column, or a unit does not fit.
    #[error("{0}")]
    Log(data::Problems),
    /// A plant has no inverse or no stable loop; every reason that was found.
    #[error("{}", list(.0))]
    NotInvertible(Vec<NotInvertible>),
}

impl Error {
    pub(crate) const fn no_solution(reason: &'static str) -> Self {
        Self::NoSolution { reason }
    }
}

impl From<numerics::least_squares::NoSolution> for Error {
    fn from(
        numerics::least_squares::NoSolution(reason): numerics::least_squares::NoSolution,
    ) -> Self {
        Self::NoSolution { reason }
    }
}

/// One problem of a record.
#[derive(Clone, Debug, PartialEq, ThisError)]
#[non_exhaustive]
pub enum Problem {
    /// Columns of different lengths.
    #[error(
        "{record}: {time} times, {input} inputs and {output} outputs; give columns of one length"
    )]
    Lengths {
        /// The record.
        record: String,
        /// Number of times.
        time: usize,
        /// Number of inputs.
        input: usize,
        /// Number of outputs.
        output: usize,
    },
    /// Too few samples to fit and to judge.
    #[error(
        "{record}: {found} samples {part}, but {needed} are needed; give a longer log, drop less \
         of the run-in, or take fewer plays"
    )]
    TooShort {
        /// The record.
        record: String,
        /// Which samples: in all, to fit on, to judge on.
        part: &'static str,
        /// Samples found.
        found: usize,
        /// Samples needed.
        needed: usize,
    },
    /// A value that is not finite.
    #[error(
        "{record}, row {row}: {column} = {value} is not a finite number ({count} such values in \
         the record); cut the log there or repair the samples"
    )]
    NotFinite {
        /// The record.
        record: String,
        /// First such row, counted from 1.
        row: usize,
        /// The column.
        column: String,
        /// The value.
        value: f64,
        /// Number of such values.
        count: usize,
    },
    /// Time does not advance by one period per row.
    #[error(
        "{record}, row {row}: time {time} s is {off:.3} periods from the uniform grid of \
         {period:.6e} s; resample the log to a constant rate, or split it into records at gaps"
    )]
    NotUniform {
        /// The record.
        record: String,
        /// The row furthest from the grid, counted from 1.
        row: usize,
        /// The row's time in s.
        time: f64,
        /// Distance from the grid in periods.
        off: f64,
        /// Mean period in s.
        period: f64,
    },
    /// A column that does not change where it is needed.
    #[error(
        "{record}: \"{column}\" is {value} in all samples {part}, so nothing can be identified; \
         drive the axis through its range there, or name another column"
    )]
    Constant {
        /// The record.
        record: String,
        /// The column.
        column: String,
        /// The column's value.
        value: f64,
        /// Which samples.
        part: &'static str,
    },
    /// Records of sample times without a common measure.
    #[error(
        "{record}: its period of {period:.6e} s is no whole multiple of the shortest one, {first:.6e} s, nor of a \
         tenth of it; resample it to a multiple"
    )]
    OtherPeriod {
        /// The record.
        record: String,
        /// The record's period in s.
        period: f64,
        /// The shortest one.
        first: f64,
    },
    /// No record at all.
    #[error("there is no record to identify from; give a log with at least one")]
    NoRecord,
}

/// One problem of the settings.
#[derive(Clone, Debug, PartialEq, ThisError)]
#[error("{setting} = {value}: {rule}")]
pub struct SettingsProblem {
    /// The setting.
    pub setting: &'static str,
    /// The settings problem's value.
    pub value: f64,
    /// The rule that it breaks, and the way out.
    pub rule: &'static str,
}

/// One reason why a plant gets no controller.
#[derive(Clone, Debug, PartialEq, ThisError)]
#[error("{place}: {reason}")]
pub struct NotInvertible {
    /// The axis or component.
    pub place: String,
    /// The reason, and the way out.
    pub reason: String,
}

fn no_model(failures: &[(&str, Error)]) -> String {
    let lines = failures.iter().map(|(method, error)| format!("method \"{method}\": {error}"));
    lines.collect::<Vec<_>>().join("\n")
}

fn list<T: std::fmt::Display>(problems: &[T]) -> String {
    problems.iter().map(T::to_string).collect::<Vec<_>>().join("\n")
}
