//! The plant FMU that the emulator plays.

use cosim::{Experiment, Selection, Slave};
use thiserror::Error;

/// A plant FMU, stepped once per step of the machine.
pub struct Plant {
    slave: Box<dyn Slave>,
    inputs: Selection,
    outputs: Selection,
    sample: Box<[f64]>,
    step: f64,
    steps: u64,
}

/// A plant that cannot be played.
#[derive(Debug, Error)]
pub enum PlantError {
    /// The FMU says so.
    #[error(transparent)]
    Fmu(#[from] cosim::Error),
    /// It has other channels than a machine must have.
    #[error(
        "the plant has {inputs} inputs ({input_names}) and {outputs} outputs ({output_names}); a \
         machine has one position for each command: choose them with --commands and --positions"
    )]
    Channels {
        /// Number of inputs.
        inputs: usize,
        /// Names of these signals.
        input_names: String,
        /// Number of outputs.
        outputs: usize,
        /// Names of these signals.
        output_names: String,
    },
}

impl std::fmt::Debug for Plant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Plant").field("name", &self.slave.name()).finish_non_exhaustive()
    }
}

impl Plant {
    /// Initialises a plant that was instantiated, at rest under the commands `safe`; an empty
    /// `safe`: its start values.
    ///
    /// # Errors
    /// What the FMU says, names that it does not have, or not one position for each command.
    pub fn new(
        mut slave: Box<dyn Slave>,
        commands: &[String],
        positions: &[String],
        safe: &[f64],
        step: f64,
    ) -> Result<Self, PlantError> {
        if commands.len() != positions.len() || commands.is_empty() {
            return Err(PlantError::Channels {
                inputs: commands.len(),
                input_names: commands.join(", "),
                outputs: positions.len(),
                output_names: positions.join(", "),
            });
        }
        let inputs = Selection::of(slave.description(), commands)?;
        let outputs = Selection::of(slave.description(), positions)?;
        slave.setup(&Experiment { start: 0.0, stop: None, tolerance: None })?;
        for (name, value) in commands.iter().zip(safe) {
            slave.set_start(name, &(*value).into())?;
        }
        slave.enter_initialization()?;
        slave.exit_initialization()?;
        let mut sample = vec![0.0; outputs.len()].into_boxed_slice();
        slave.get(&outputs, &mut sample)?;
        Ok(Plant { slave, inputs, outputs, sample, step, steps: 0 })
    }

    /// Number of axes.
    #[must_use]
    pub fn axes(&self) -> usize {
        self.outputs.len()
    }

    /// Names of commands and positions.
    #[must_use]
    pub fn names(&self) -> (&[String], &[String]) {
        (self.inputs.names(), self.outputs.names())
    }

    /// The commands that act now.
    ///
    /// # Errors
    /// What the FMU says.
    pub fn commands(&mut self) -> Result<Vec<f64>, PlantError> {
        let mut values = vec![0.0; self.inputs.len()];
        self.slave.get(&self.inputs, &mut values)?;
        Ok(values)
    }

    /// One step under these commands.
    pub(crate) fn step(&mut self, commands: &[f64]) -> Result<(), PlantError> {
        self.slave.set(&self.inputs, commands)?;
        let begin = self.steps as f64 * self.step;
        let end = (self.steps + 1) as f64 * self.step;
        self.slave.step(begin, end - begin)?;
        self.steps += 1;
        self.slave.get(&self.outputs, &mut self.sample)?;
        Ok(())
    }

    /// Length of a step in s.
    pub(crate) fn period(&self) -> f64 {
        self.step
    }

    /// The positions.
    pub(crate) fn read(&self, sample: &mut [f64]) {
        sample.copy_from_slice(&self.sample);
    }
}
