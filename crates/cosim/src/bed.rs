//! A plant stepped by hand.

use std::path::{Path, PathBuf};

use data::inner_steps;
use modeldescription::variable::Causality;

use crate::{Error, Experiment, Fmu, InstanceOptions, Problems, Selection, Slave, Value};

/// A plant on the bench: its FMU with inputs `command[i]` and outputs `position[i]`, stepped by hand.
pub struct Bed {
    machine: Fmu,
    /// Holds the machine's FMU as long as it is used, where it was packed for this.
    _folder: Option<tempfile::TempDir>,
    /// What messages call the plant.
    what: PathBuf,
    slave: Box<dyn Slave>,
    commands: Selection,
    positions: Selection,
    axes: usize,
    count: u64,
    period: f64,
}

impl Bed {
    /// Puts an FMU on the bench: of the plant that messages call `what`; `folder` is kept as long.
    ///
    /// # Errors
    /// Where it has no inputs `command[i]` with as many outputs `position[i]`, or cannot be instantiated.
    pub fn new(
        machine: Fmu,
        folder: Option<tempfile::TempDir>,
        what: &Path,
    ) -> Result<Self, Error> {
        let unfit =
            |reason: &str| Error::Package { path: what.to_owned(), reason: reason.to_owned() };
        let axes = numbered(&machine, Causality::Input, "command");
        if axes == 0 || numbered(&machine, Causality::Output, "position") != axes {
            return Err(unfit("is no plant with command[i] and position[i]"));
        }
        let slave = machine.instantiate("machine", &InstanceOptions::default())?;
        let select = |name: &str| -> Result<Selection, Error> {
            let mut selection = Selection::default();
            for axis in 1..=axes {
                let variable = machine.description().variable(&format!("{name}[{axis}]"));
                let variable = variable.ok_or_else(|| unfit("the axes are not numbered from 1"))?;
                selection.add("machine", variable).map_err(Problems::from)?;
            }
            Ok(selection)
        };
        let (commands, positions) = (select("command")?, select("position")?);
        let (what, count, period) = (what.to_owned(), 0, 1.0);
        Ok(Self { slave, commands, positions, axes, count, period, machine, what, _folder: folder })
    }

    /// The plant's FMU, for runs beside this one.
    pub fn machine(&self) -> &Fmu {
        &self.machine
    }

    /// Number of axes.
    pub fn axes(&self) -> usize {
        self.axes
    }

    /// At rest under these commands; the positions. Steps have this period from then on.
    ///
    /// # Errors
    /// What the FMU reports.
    pub fn rest(&mut self, commands: &[f64], period: f64) -> Result<Vec<f64>, Error> {
        let experiment = self.machine.description().default_experiment.as_ref();
        if let Some(inner) = experiment.and_then(|e| e.step_size) {
            let unfit = |reason| Error::Package { path: self.what.clone(), reason };
            inner_steps::check(period, inner).map_err(unfit)?;
        }
        self.slave.reset()?;
        self.slave.setup(&Experiment { start: 0.0, stop: None, tolerance: None })?;
        for (axis, value) in (1..).zip(commands) {
            self.slave.set_start(&format!("command[{axis}]"), &Value::Real(*value))?;
        }
        self.slave.enter_initialization()?;
        self.slave.exit_initialization()?;
        (self.count, self.period) = (0, period);
        self.positions()
    }

    fn positions(&mut self) -> Result<Vec<f64>, Error> {
        let mut positions = vec![0.0; self.axes];
        self.slave.get(&self.positions, &mut positions)?;
        Ok(positions)
    }

    /// The positions at the end of one period with these commands.
    ///
    /// # Errors
    /// What the FMU reports.
    pub fn step(&mut self, commands: &[f64]) -> Result<Vec<f64>, Error> {
        self.slave.set(&self.commands, commands)?;
        let t = self.count as f64 * self.period;
        self.count += 1;
        self.slave.step(t, self.count as f64 * self.period - t)?;
        self.positions()
    }

    /// The positions of one axis at the end of each period with its commands `u`, from rest under the
    /// first one; the other axes rest at `others`. The position at rest comes first.
    ///
    /// # Errors
    /// What the FMU reports.
    pub fn response(
        &mut self,
        axis: usize,
        u: &[f64],
        others: f64,
        period: f64,
    ) -> Result<Vec<f64>, Error> {
        let mut commands = vec![others; self.axes];
        commands[axis] = u.first().copied().unwrap_or(0.0);
        let mut all = vec![self.rest(&commands, period)?[axis]];
        for value in u {
            commands[axis] = *value;
            all.push(self.step(&commands)?[axis]);
        }
        Ok(all)
    }
}

/// How many variables `name[1]`, `name[2]`, … there are.
fn numbered(machine: &Fmu, causality: Causality, name: &str) -> usize {
    let names = machine.names(causality);
    (1..).take_while(|axis| names.contains(&format!("{name}[{axis}]"))).count()
}
