//! The closed loop of two FMUs: a controller and a plant.

use modeldescription::description::Unit;
use modeldescription::variable::Causality;

use crate::algorithm::{Algorithm, GaussSeidel, Jacobi};
use crate::diagram::Diagram;
use crate::error::Error;
use crate::problem::{Problem, Problems};
use crate::record::Recorder;
use crate::run::Run;
use crate::slave::{Slave, Value, numbers};
use crate::system::{Ending, System};

/// Who steps when, and so how old a value is when it acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coupling {
    /// Controller, then plant (Gauss–Seidel). The command computed from y_k and r_k acts over
    /// \[t_k, t_{k+1}\]: no delay but that of sampling.
    #[default]
    ControllerFirst,
    /// Side by side (Jacobi). The command computed from y_k and r_k acts over
    /// \[t_{k+1}, t_{k+2}\]: one sample more, as of a controller that needs a whole period to
    /// compute.
    SideBySide,
}

/// Which variables of controller and plant belong together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wiring {
    /// Controller output, plant input.
    pub commands: Vec<(String, String)>,
    /// Plant output, controller input.
    pub measurements: Vec<(String, String)>,
    /// Column of the reference table, controller input.
    pub references: Vec<(String, String)>,
}

/// A controller and a plant in a closed loop.
///
/// At t_k the controller gets the reference r_k and the measured y_k and steps to t_{k+1}; with
/// [`Coupling::ControllerFirst`] its command then acts on the plant over \[t_k, t_{k+1}\]. In fmpy,
/// with both FMUs initialized as [`System::run`] says:
///
/// ```python
/// for k in range(n):
///     t, h = start + k * dt, (start + (k + 1) * dt) - (start + k * dt)
///     y = plant.getReal(position)                         # y_k, row k of the record
///     controller.setReal(reference + measured, [*r[k], *y])
///     controller.doStep(t, h)
///     u = controller.getReal(command_out)                 # u_k, row k of the record
///     plant.setReal(command_in, u)
///     plant.doStep(t, h)
/// ```
///
/// and with [`Coupling::SideBySide`] the line that reads `u` stands before `controller.doStep`.
///
/// Delays, in communication steps from the source's value to the end of the step it acts on:
///
/// | connection | controller first | side by side |
/// |---|---|---|
/// | reference → controller | 1 | 1 |
/// | measurement → controller | 1 | 1 |
/// | command → plant | 0 | 1 |
pub struct Loop {
    system: System,
    algorithm: Box<dyn Algorithm>,
}

impl Wiring {
    /// By name: a controller output feeds the plant input of its name (`command[i]`), the plant
    /// output `position[i]` feeds the controller input `measured[i]`, and a column of the reference
    /// table feeds the other controller input of its name (`reference[i]`). Inputs that nothing
    /// feeds keep their start values.
    ///
    /// # Errors
    /// A controller and a plant that share no command or no measurement, or a table that has
    /// nothing for the controller.
    pub fn by_name(
        controller: &dyn Slave,
        plant: &dyn Slave,
        columns: &[&str],
    ) -> Result<Self, Problems> {
        let outputs = names(controller, Causality::Output);
        let inputs = names(plant, Causality::Input);
        let commands: Vec<(String, String)> = outputs
            .iter()
            .filter(|name| inputs.contains(name))
            .map(|name| (name.clone(), name.clone()))
            .collect();
        let positions = names(plant, Causality::Output);
        let controlled = names(controller, Causality::Input);
        let mut measurements = Vec::new();
        let mut references = Vec::new();
        for input in &controlled {
            let position = input.replacen("measured", "position", 1);
            if position != *input && positions.contains(&position) {
                measurements.push((position, input.clone()));
            } else if columns.contains(&input.as_str()) {
                references.push((input.clone(), input.clone()));
            }
        }
        let fits = |from: &[String], to: &[String]| from.iter().any(|name| to.contains(name));
        if commands.is_empty() && measurements.is_empty() && fits(&positions, &controlled) {
            let swapped = "the first FMU looks like the controller and the second like the plant: its outputs have the \
                           names of the second one's inputs; give the plant first";
            return Err(Problem::Loop(swapped.to_owned()).into());
        }
        let wiring = Wiring { commands, measurements, references };
        let mut problems = wiring.gaps(&outputs, &inputs, &positions, &controlled);
        if wiring.references.is_empty() {
            problems.push(Problem::Loop(format!(
                "no column of the reference table has the name of an input of the controller ({}); \
                 assign one with --map, as in --map 'reference[1]=COLUMN'",
                controlled.join(", ")
            )));
        }
        Problems::none_or(problems, wiring)
    }

    fn gaps(
        &self,
        outputs: &[String],
        inputs: &[String],
        positions: &[String],
        controlled: &[String],
    ) -> Vec<Problem> {
        let mut problems = Vec::new();
        if self.commands.is_empty() {
            problems.push(Problem::Loop(format!(
                "no output of the controller ({}) is called as an input of the plant ({}); \
                 say which command feeds which input",
                outputs.join(", "),
                inputs.join(", ")
            )));
        }
        if self.measurements.is_empty() {
            problems.push(Problem::Loop(format!(
                "no output of the plant ({}) belongs to an input of the controller ({}): \
                 `position[i]` feeds `measured[i]`; say which output is measured by which input",
                positions.join(", "),
                controlled.join(", ")
            )));
        }
        problems
    }
}

fn names(slave: &dyn Slave, causality: Causality) -> Vec<String> {
    let description = slave.description();
    let variables = description.variables.iter().filter(|v| v.causality == causality);
    variables.flat_map(|variable| numbers(description, variable)).collect()
}

/// What a loop is made with.
#[derive(Clone, Debug, Default)]
pub struct LoopSettings {
    /// Which variables belong together.
    pub wiring: Wiring,
    /// Who steps when.
    pub coupling: Coupling,
    /// Units of the columns of the reference table, where they are known.
    pub reference_units: Vec<(String, Unit)>,
    /// Start values: name of the FMU, variable, value.
    pub parameters: Vec<(String, String, Value)>,
    /// Further variables to record: name of the FMU, variable.
    pub record: Vec<(String, String)>,
}

impl Loop {
    /// Closes the loop. Recorded are, under the names of the controller's inputs, references; under
    /// those of the plant, commands and measured outputs; then what the settings ask for.
    pub fn new(
        controller: Box<dyn Slave>,
        plant: Box<dyn Slave>,
        settings: &LoopSettings,
    ) -> Result<Self, Error> {
        let (c, p) = (controller.name().to_owned(), plant.name().to_owned());
        let Wiring { commands, measurements, references } = &settings.wiring;
        let mut diagram = Diagram::new();
        for (column, input) in references {
            let unit = settings.reference_units.iter().find(|(name, _)| name == column);
            diagram.feed(column, unit.map(|(_, unit)| unit.clone()), (&c, input));
            diagram.record((&c, input));
        }
        for (output, input) in commands {
            diagram.connect((&c, output), (&p, input)).record_as((&p, input), input);
        }
        for (output, input) in measurements {
            diagram.connect((&p, output), (&c, input)).record_as((&p, output), output);
        }
        for (slave, variable, value) in &settings.parameters {
            diagram.start((slave, variable), value.clone());
        }
        for port in &settings.record {
            diagram.record((&port.0, &port.1));
        }
        diagram.add(controller).add(plant);
        let system = diagram.build()?;
        let algorithm: Box<dyn Algorithm> = match settings.coupling {
            Coupling::ControllerFirst => Box::new(GaussSeidel::in_order(&system, &[&c, &p])?),
            Coupling::SideBySide => Box::new(Jacobi),
        };
        Ok(Loop { system, algorithm })
    }

    /// Runs one record, see [`System::run`].
    pub fn run(
        &mut self,
        run: &Run<'_>,
        recorder: &mut dyn Recorder,
    ) -> Result<Option<Ending>, Error> {
        self.system.run(run, &*self.algorithm, recorder)
    }

    /// The system of the two.
    pub fn system(&mut self) -> &mut System {
        &mut self.system
    }
}
