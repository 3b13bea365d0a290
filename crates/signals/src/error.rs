//! What can be wrong with a request for a signal.

use thiserror::Error;

/// A name that no signal has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no signal is named `{name}`; known are {known}")]
pub struct UnknownSignal {
    /// The name asked for.
    pub name: String,
    /// All names, separated by commas.
    pub known: String,
}

/// Settings that a signal refuses: all problems at once.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("signal `{signal}`: {}", listed(.problems))]
pub struct SignalError {
    /// Name of the signal.
    pub signal: &'static str,
    /// Every problem found, at least one.
    pub problems: Vec<Problem>,
}

fn listed(problems: &[Problem]) -> String {
    match problems {
        [one] => one.to_string(),
        many => {
            let lines: Vec<String> = many.iter().map(|p| format!("\n  {p}")).collect();
            format!("{} problems:{}", many.len(), lines.concat())
        }
    }
}

/// One problem of a request.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Problem {
    /// The signal has no such parameter.
    #[error("unknown parameter `{name}` (= {value}); the parameters are {known}")]
    Unknown {
        /// Name as given.
        name: String,
        /// Value as given.
        value: f64,
        /// The signal's parameters, separated by commas.
        known: String,
    },
    /// A parameter is set more than once.
    #[error("`{name}` is given twice, the second time as {value}; give it once")]
    Twice {
        /// Name of the parameter.
        name: &'static str,
        /// The later value.
        value: f64,
    },
    /// A value outside the declared bounds, or no number.
    #[error("{name} = {value} {unit} is not within {min} to {max} {unit}; give a value inside")]
    OutOfRange {
        /// Name of the parameter.
        name: &'static str,
        /// Value as given.
        value: f64,
        /// Unit of the parameter.
        unit: &'static str,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// A fraction where a whole number is needed.
    #[error("{name} = {value} must be a whole number; {} and {} are the nearest",
        .value.floor(), .value.ceil())]
    NotInteger {
        /// Name of the parameter.
        name: &'static str,
        /// Value as given.
        value: f64,
    },
    /// Values that do not go together.
    #[error("{name} = {value} {unit} {rule}")]
    Rule {
        /// Name of the parameter.
        name: &'static str,
        /// The name's value.
        value: f64,
        /// Unit of the parameter.
        unit: &'static str,
        /// The rule and the way out.
        rule: &'static str,
    },
    /// A record of no sample at all, or of more than memory should hold.
    #[error(
        "the record would have {samples} samples of {sample_time} s; it needs 1 to {max}: change \
         sample_time or the length of the record"
    )]
    Samples {
        /// Number of samples asked for.
        samples: f64,
        /// Sample time in s.
        sample_time: f64,
        /// Greatest number allowed.
        max: usize,
    },
}
