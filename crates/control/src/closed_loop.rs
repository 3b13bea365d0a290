//! Plant and controller, stepped in turn in one process.

use data::CheckedBlueprint;
use model::System;

use identify::Error;

/// What a closed loop did: one list per axis, one value per communication point.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopRun {
    /// Command of each axis, acting from this point to the next.
    pub command: Vec<Vec<f64>>,
    /// What the feedforward asked for, whatever the limits; 0 where there is none.
    pub feedforward: Vec<Vec<f64>>,
    /// Position of each axis, before the command of this point acts.
    pub position: Vec<Vec<f64>>,
}

/// Runs `references[axis][point]` through the closed loop with communication points `period` s apart.
/// The controller goes first: from t_k to t_{k+1} it sees the reference and the position of t_k, and
/// the plant sees the command of the same interval. Both start at rest: the plant under the
/// controller's command for the first reference.
///
/// # Errors
/// [`Error::Model`] where the two do not fit together or one leaves its range.
pub fn simulate_loop(
    plant: &CheckedBlueprint,
    controller: &CheckedBlueprint,
    references: &[Vec<f64>],
    period: f64,
) -> Result<LoopRun, Error> {
    let mut machine = Side::new(plant);
    let mut control = Side::new(controller);
    let axes = references.len();
    let plant_axes = plant.spec().axes.len();
    if axes != plant_axes || axes != controller.spec().axes.len() {
        return Err(machine.error(format!(
            "the plant has {plant_axes} axes, the controller {}, and {axes} references were given; \
             give as many of each",
            controller.spec().axes.len()
        )));
    }
    let points = references.iter().map(Vec::len).min().unwrap_or(0);
    let none = || vec![Vec::with_capacity(points); axes];
    let mut run = LoopRun { command: none(), feedforward: none(), position: none() };
    for point in 0..points {
        let time = point as f64 * period;
        for (axis, reference) in references.iter().enumerate() {
            control.set("reference", axis, reference[point])?;
        }
        if point == 0 {
            // Feedforward of the first reference, then the machine under it, then both agree.
            control.initialise()?;
            for axis in 0..axes {
                machine.set("command", axis, control.get("command", axis)?)?;
            }
            machine.initialise()?;
            for axis in 0..axes {
                control.set("measured", axis, machine.get("position", axis)?)?;
            }
            control.initialise()?;
        }
        for axis in 0..axes {
            let position = machine.get("position", axis)?;
            run.position[axis].push(position);
            control.set("measured", axis, position)?;
        }
        control.advance(time + period)?;
        for axis in 0..axes {
            let command = control.get("command", axis)?;
            run.command[axis].push(command);
            run.feedforward[axis].push(control.get("feedforward", axis).unwrap_or(0.0));
            machine.set("command", axis, command)?;
        }
        machine.advance(time + period)?;
    }
    Ok(run)
}

/// One of the two.
pub(crate) struct Side {
    system: System,
}

impl Side {
    pub(crate) fn new(blueprint: &CheckedBlueprint) -> Self {
        Self { system: blueprint.build() }
    }

    fn error(&self, message: String) -> Error {
        Error::Model { name: self.system.name().to_owned(), message }
    }

    fn reference(&self, name: &str, axis: usize) -> Result<u32, Error> {
        let name = format!("{name}[{}]", axis + 1);
        let found = self.system.variables().find(&name);
        found.ok_or_else(|| {
            self.error(format!(
                "has no variable \"{name}\"; a loop is one plant and one controller"
            ))
        })
    }

    pub(crate) fn set(&mut self, name: &str, axis: usize, value: f64) -> Result<(), Error> {
        let reference = self.reference(name, axis)?;
        let result = self.system.set(reference, value);
        result.map_err(|e| self.error(self.system.explain_set(&e)))
    }

    pub(crate) fn get(&self, name: &str, axis: usize) -> Result<f64, Error> {
        let reference = self.reference(name, axis)?;
        Ok(self.system.get(reference).unwrap_or(f64::NAN))
    }

    pub(crate) fn initialise(&mut self) -> Result<(), Error> {
        let result = self.system.initialise(0.0);
        result.map_err(|e| self.error(self.system.explain(&e)))
    }

    pub(crate) fn advance(&mut self, time: f64) -> Result<(), Error> {
        let result = self.system.advance(time);
        result.map(|_| ()).map_err(|e| self.error(self.system.explain(&e)))
    }
}
