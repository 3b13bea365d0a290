//! The controller FMU as the cycle sees it.

use std::collections::BTreeMap;
use std::fmt;

use cosim::{Experiment, Fmu, InstanceOptions, Selection, Slave, StepResult, Value};
use thiserror::Error;

/// Who makes the commands.
pub enum Driver {
    /// A controller FMU, from references and positions.
    Controller(Box<Controller>),
    /// Nobody: the plan's rows are the commands.
    Direct,
}

impl fmt::Debug for Driver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Driver::Controller(_) => "Controller",
            Driver::Direct => "Direct",
        })
    }
}

/// A controller that does not come to life.
#[derive(Debug, Error)]
pub enum ControllerError {
    /// The FMU says so.
    #[error(transparent)]
    Fmu(#[from] cosim::Error),
    /// A start value that is a list or a table.
    #[error("[start] {name} = {value}: is no single value")]
    Start {
        /// Variable.
        name: String,
        /// As it was given.
        value: toml::Value,
    },
}

/// A controller FMU of any vendor, stepped once per cycle.
///
/// The controller's time is its own count of steps: n·h. A cycle that was missed is a sample that it does not
/// see, as for any controller on a real-time target.
pub struct Controller {
    slave: Box<dyn Slave>,
    inputs: Selection,
    outputs: Selection,
    values: Box<[f64]>,
    step: f64,
    steps: u64,
    failure: Option<String>,
}

impl Controller {
    /// Initialises a controller that was instantiated. The names are of its inputs and outputs,
    /// axis by axis; `start` are start values.
    ///
    /// # Errors
    /// What the FMU says, or names that it does not have.
    pub fn new(
        mut slave: Box<dyn Slave>,
        references: &[String],
        measured: &[String],
        commands: &[String],
        start: &[(String, Value)],
        step: f64,
    ) -> Result<Self, ControllerError> {
        let names: Vec<&String> = references.iter().chain(measured).collect();
        let inputs = Selection::of(slave.description(), &names)?;
        let outputs = Selection::of(slave.description(), commands)?;
        slave.setup(&Experiment { start: 0.0, stop: None, tolerance: None })?;
        for (name, value) in start {
            slave.set_start(name, value)?;
        }
        slave.enter_initialization()?;
        slave.exit_initialization()?;
        let values = vec![0.0; inputs.len()].into();
        let mut controller =
            Controller { slave, inputs, outputs, values, step, steps: 0, failure: None };
        let mut wanted = vec![0.0; commands.len()];
        // One reading before the clock runs, so that the first cycle finds everything in place.
        controller.slave.get(&controller.outputs, &mut wanted)?;
        Ok(controller)
    }

    fn step(
        &mut self,
        references: &[f64],
        positions: &[f64],
        wanted: &mut [f64],
    ) -> Result<bool, cosim::Error> {
        let (first, second) = self.values.split_at_mut(references.len());
        first.copy_from_slice(references);
        second.copy_from_slice(positions);
        self.slave.set(&self.inputs, &self.values)?;
        let begin = self.steps as f64 * self.step;
        let end = (self.steps + 1) as f64 * self.step;
        let result = self.slave.step(begin, end - begin)?;
        self.steps += 1;
        self.slave.get(&self.outputs, wanted)?;
        Ok(matches!(result, StepResult::Completed))
    }
}

impl Driver {
    /// An instance of a controller FMU; the arguments are those of [`Controller::new`].
    ///
    /// # Errors
    /// What the FMU says; names that it does not have; or a start value that is no single value.
    pub fn controller(
        fmu: &Fmu,
        references: &[String],
        measured: &[String],
        commands: &[String],
        start: &BTreeMap<String, toml::Value>,
        step: f64,
    ) -> Result<Self, ControllerError> {
        let single = |(name, value): (&String, &toml::Value)| {
            let value = match value {
                toml::Value::Float(value) => Value::Real(*value),
                toml::Value::Integer(value) => Value::Integer((*value).into()),
                toml::Value::Boolean(value) => Value::Boolean(*value),
                toml::Value::String(value) => Value::Text(value.clone()),
                other => {
                    let (name, value) = (name.clone(), other.clone());
                    return Err(ControllerError::Start { name, value });
                }
            };
            Ok((name.clone(), value))
        };
        let start = start.iter().map(single).collect::<Result<Vec<_>, _>>()?;
        let slave = fmu.instantiate("controller", &InstanceOptions::default())?;
        let controller = Controller::new(slave, references, measured, commands, &start, step)?;
        Ok(Driver::Controller(Box::new(controller)))
    }

    /// The commands of one cycle; false when the controller cannot go on.
    pub(crate) fn step(
        &mut self,
        references: &[f64],
        positions: &[f64],
        wanted: &mut [f64],
    ) -> bool {
        let Driver::Controller(controller) = self else {
            wanted.copy_from_slice(references);
            return true;
        };
        match controller.step(references, positions, wanted) {
            Ok(true) => true,
            Ok(false) => {
                controller.failure = Some("it ended a step before its time".to_owned());
                false
            }
            // From here on the controller is not called again, and words may be allocated.
            Err(error) => {
                controller.failure = Some(error.to_string());
                false
            }
        }
    }

    /// What went wrong.
    pub(crate) fn failure(&self) -> Option<String> {
        match self {
            Driver::Controller(controller) => controller.failure.clone(),
            Driver::Direct => None,
        }
    }
}
