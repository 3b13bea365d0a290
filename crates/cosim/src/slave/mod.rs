//! What the master knows of a slave, whatever version of FMI it speaks.

mod address;
mod array;
mod clocks;
#[cfg(feature = "wasm")]
mod component;
mod events;
mod fmi2;
mod fmi3;
mod index;
mod selection;
pub(crate) mod structure;
mod support;
mod typed;
mod value;

pub use address::unrecorded;
pub(crate) use address::{Address, numbers};
pub(crate) use clocks::can_be_triggered;
#[cfg(feature = "wasm")]
pub(crate) use component::{ComponentLibrary, ComponentSlave};
pub(crate) use fmi2::Fmi2Slave;
pub(crate) use fmi3::Fmi3Slave;
pub(crate) use index::Index;
pub use selection::{ArrayRun, Selection, TypeRun};
pub(crate) use support::Settings;
pub use value::Value;
pub(crate) use value::{Settable, settable};

use fmi_bindings::import::{Experiment, StepResult};
use modeldescription::ModelDescription;

use crate::error::Error;

/// A handle of a state that a slave has saved; only that slave can use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StateId(pub usize);

/// A slave: one instance of an FMU, or anything else that steps.
///
/// Order of calls: `setup`, `set_start`…, `enter_initialization`, (`set_start` | `set` | `get`)…,
/// `exit_initialization`, (`set` | `step` | `get`)…, `terminate`, `get`…, and from anywhere
/// `reset`, which leads back to the beginning. After an error only `reset` or dropping it.
pub trait Slave: Send {
    /// Name of the instance; unique in a system.
    fn name(&self) -> &str;

    /// What the slave says about itself.
    fn description(&self) -> &ModelDescription;

    /// Tells the time span of the run.
    fn setup(&mut self, experiment: &Experiment) -> Result<(), Error>;

    /// Begins initialization.
    fn enter_initialization(&mut self) -> Result<(), Error>;

    /// Ends initialization; from here on it can step.
    fn exit_initialization(&mut self) -> Result<(), Error>;

    /// Gives a variable a value before or during initialization.
    fn set_start(&mut self, variable: &str, value: &Value) -> Result<(), Error>;

    /// Reads one variable of any type, in initialization or later.
    fn value(&mut self, variable: &str) -> Result<Value, Error>;

    /// Writes the selected variables; `values` in the order of the selection.
    fn set(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error>;

    /// Reads the selected variables; `values` in the order of the selection.
    fn get(&mut self, selection: &Selection, values: &mut [f64]) -> Result<(), Error>;

    /// The slopes of Real outputs in time, in their unit per second.
    fn output_slopes(&mut self, outputs: &Selection, slopes: &mut [f64]) -> Result<(), Error> {
        let (_, _) = (outputs, slopes);
        Err(self.no_slopes("give slopes of its outputs", "maxOutputDerivativeOrder"))
    }

    /// Lets Real inputs move on straight lines in the next step; slopes in their unit per second.
    fn set_input_slopes(&mut self, inputs: &Selection, slopes: &[f64]) -> Result<(), Error> {
        let (_, _) = (inputs, slopes);
        Err(self.no_slopes("take slopes of its inputs", "canInterpolateInputs"))
    }

    /// Steps from `time` over `step` seconds.
    fn step(&mut self, time: f64, step: f64) -> Result<StepResult, Error>;

    /// Ends the run.
    fn terminate(&mut self) -> Result<(), Error>;

    /// Back to the state right after it was made.
    fn reset(&mut self) -> Result<(), Error>;

    /// Saves the whole state, into `reuse` if given.
    fn save(&mut self, reuse: Option<StateId>) -> Result<StateId, Error> {
        let _ = reuse;
        Err(self.no_state())
    }

    /// Goes back to a saved state, which stays saved.
    fn restore(&mut self, state: StateId) -> Result<(), Error> {
        let _ = state;
        Err(self.no_state())
    }

    /// Frees a saved state.
    fn forget(&mut self, state: StateId) -> Result<(), Error> {
        let _ = state;
        Err(self.no_state())
    }

    /// A saved state as bytes, for another process.
    fn serialize(&mut self, state: StateId) -> Result<Vec<u8>, Error> {
        let _ = state;
        Err(self.no_bytes())
    }

    /// A saved state from bytes; it becomes the current one by `restore`.
    fn deserialize(&mut self, bytes: &[u8]) -> Result<StateId, Error> {
        let _ = bytes;
        Err(self.no_bytes())
    }

    /// The error of a slave that knows no slopes.
    #[doc(hidden)]
    fn no_slopes(&self, what: &'static str, attribute: &'static str) -> Error {
        Error::NotOffered { fmu: self.name().to_owned(), what, attribute }
    }

    /// The error of a slave that cannot turn its state into bytes.
    #[doc(hidden)]
    fn no_bytes(&self) -> Error {
        Error::NotOffered {
            fmu: self.name().to_owned(),
            what: "turn its state into bytes",
            attribute: "canSerializeFMUstate",
        }
    }

    /// The error of a slave that cannot save its state.
    #[doc(hidden)]
    fn no_state(&self) -> Error {
        Error::NotOffered {
            fmu: self.name().to_owned(),
            what: "save or restore its state",
            attribute: "canGetAndSetFMUstate",
        }
    }
}
