//! Why a training gives no model.

use thiserror::Error;

/// Why a training gives no model.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// Inputs and outputs do not belong together.
    #[error(
        "{inputs} numbers in inputs of {dimension} coordinates, but {outputs} outputs; give one \
         output per input"
    )]
    Shape {
        /// Numbers in the inputs.
        inputs: usize,
        /// Coordinates of one input.
        dimension: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// Too few samples.
    #[error("{found} samples, but {needed} are needed; give a longer record")]
    TooFew {
        /// Samples there are.
        found: usize,
        /// Samples needed.
        needed: usize,
    },
    /// A number that is not finite.
    #[error("{what} {index} is {value}, no finite number; correct the record")]
    NotFinite {
        /// What the not finite belongs to.
        what: &'static str,
        /// The what's index from 0.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A setting outside its range.
    #[error("{name} = {value} {rule}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// The name's value.
        value: f64,
        /// The rule and the way out.
        rule: &'static str,
    },
    /// The regularised kernel matrix is not positive definite in double precision.
    #[error(
        "the kernel matrix of {samples} samples with lambda = {lambda:e} is not positive definite in \
         double precision; raise the regularisation (a smaller gamma), shorten the kernel, or leave \
         out samples that repeat others"
    )]
    IllPosed {
        /// Number of samples.
        samples: usize,
        /// What is added to the diagonal.
        lambda: f64,
    },
    /// The exact residual of the result is too large.
    #[error(
        "the solution leaves a residual of {residual:e} of the outputs (at most {limit:e} is \
         accepted) with lambda = {lambda:e}; raise the regularisation (a smaller gamma)"
    )]
    Unconverged {
        /// Exact relative residual.
        residual: f64,
        /// Greatest one accepted.
        limit: f64,
        /// What is added to the diagonal.
        lambda: f64,
    },
    /// A simulation with the model left all bounds.
    #[error(
        "the simulation runs away at sample {sample}: {value} outside the {limit} that was allowed; \
         raise the regularisation, widen the kernel or train on data with larger loops"
    )]
    Runaway {
        /// Sample from 0.
        sample: usize,
        /// The value there.
        value: f64,
        /// Greatest absolute value allowed.
        limit: f64,
    },
}
