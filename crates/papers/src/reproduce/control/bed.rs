//! A packed machine: stepped by hand, or in a closed loop with a packed controller.

use std::path::Path;

use anyhow::Context;
use cosim::{
    Experiment, Fmu, InstanceOptions, Loop, LoopSettings, Memory, Points, Run, Selection, Signal,
    Signals, Slave, Value, Wiring,
};
use data::Blueprint;
use modeldescription::variable::Causality;

use crate::Pack;

/// A machine on the bench.
pub struct Bed {
    machine: Fmu,
    /// Holds the machine's FMU as long as it is used, where it was packed for this.
    _folder: Option<tempfile::TempDir>,
    pack: Pack,
    slave: Box<dyn Slave>,
    commands: Selection,
    positions: Selection,
    axes: usize,
    count: u64,
    period: f64,
}

/// What a closed loop did: per axis, per sample.
pub struct Tracked {
    /// The controller's command.
    pub command: Vec<Vec<f64>>,
    /// What the controller was told, ahead of what is wanted where it previews.
    pub previewed: Vec<Vec<f64>>,
    /// The wanted position.
    pub reference: Vec<Vec<f64>>,
    /// The measured position.
    pub position: Vec<Vec<f64>>,
    /// Wanted minus measured position.
    pub error: Vec<Vec<f64>>,
}

impl Tracked {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.error.iter().map(Vec::len).min().unwrap_or(0)
    }
}

impl Bed {
    /// Puts an FMU on the bench: of the plant that messages call `what`; `folder` is kept as long. `pack`
    /// writes the controllers' FMUs.
    ///
    /// # Errors
    /// Where it has no inputs `command[i]` with as many outputs `position[i]`, or cannot be instantiated.
    pub fn new(
        machine: Fmu,
        folder: Option<tempfile::TempDir>,
        what: &Path,
        pack: Pack,
    ) -> anyhow::Result<Self> {
        let axes = numbered(&machine, Causality::Input, "command");
        anyhow::ensure!(
            axes > 0 && numbered(&machine, Causality::Output, "position") == axes,
            "{}: is no plant with command[i] and position[i]",
            what.display()
        );
        let slave = machine.instantiate("machine", &InstanceOptions::default())?;
        let select = |name: &str| -> anyhow::Result<Selection> {
            let mut selection = Selection::default();
            for axis in 1..=axes {
                let variable = machine.description().variable(&format!("{name}[{axis}]"));
                selection.add("machine", variable.context("the axes are numbered from 1")?)?;
            }
            Ok(selection)
        };
        let (commands, positions) = (select("command")?, select("position")?);
        let (count, period) = (0, 1.0);
        Ok(Self { slave, commands, positions, axes, count, period, machine, _folder: folder, pack })
    }

    /// Number of axes.
    pub fn axes(&self) -> usize {
        self.axes
    }

    /// At rest under these commands; the positions. Steps have this period from then on.
    ///
    /// # Errors
    /// What the FMU reports.
    pub fn rest(&mut self, commands: &[f64], period: f64) -> anyhow::Result<Vec<f64>> {
        let experiment = self.machine.description().default_experiment.as_ref();
        if let Some(inner) = experiment.and_then(|e| e.step_size) {
            data::inner_steps::check(period, inner).map_err(anyhow::Error::msg)?;
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

    fn positions(&mut self) -> anyhow::Result<Vec<f64>> {
        let mut positions = vec![0.0; self.axes];
        self.slave.get(&self.positions, &mut positions)?;
        Ok(positions)
    }

    /// The positions at the end of one period with these commands.
    ///
    /// # Errors
    /// What the FMU reports.
    pub fn step(&mut self, commands: &[f64]) -> anyhow::Result<Vec<f64>> {
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
    ) -> anyhow::Result<Vec<f64>> {
        let mut commands = vec![others; self.axes];
        commands[axis] = u.first().copied().unwrap_or(0.0);
        let mut all = vec![self.rest(&commands, period)?[axis]];
        for value in u {
            commands[axis] = *value;
            all.push(self.step(&commands)?[axis]);
        }
        Ok(all)
    }

    /// Closes the loop with a controller over these references, one row per period. The controller's
    /// input runs `preview` rows ahead of them.
    ///
    /// # Errors
    /// Where the controller cannot be packed or connected, and what the FMUs report.
    pub fn track(
        &self,
        controller: &Blueprint,
        references: &[Vec<f64>],
        period: f64,
        preview: usize,
    ) -> anyhow::Result<Tracked> {
        let folder = tempfile::tempdir().context("no temporary folder can be made")?;
        let file = folder.path().join("controller.fmu");
        (self.pack)(controller, &file)?;
        let packed = cosim::Fmu::open(&file)?;
        let options = InstanceOptions::default();
        let (c, p) = (
            packed.instantiate("controller", &options)?,
            self.machine.instantiate("plant", &options)?,
        );
        let rows = references.iter().map(Vec::len).min().unwrap_or(0);
        let time: Vec<f64> = (0..rows).map(|k| k as f64 * period).collect();
        let ahead: Vec<Vec<f64>> = references
            .iter()
            .map(|r| (0..rows).map(|k| r[(k + preview).min(rows - 1)]).collect())
            .collect();
        let names: Vec<String> = (1..=self.axes).map(|axis| format!("reference[{axis}]")).collect();
        let columns = names.iter().zip(&ahead).map(|(name, values)| Signal {
            name: name.clone(),
            unit: None,
            values,
        });
        let table = Signals { time: &time, columns: columns.collect() };
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let wiring = Wiring::by_name(&*c, &*p, &known)?;
        let mut closed = Loop::new(c, p, &LoopSettings { wiring, ..LoopSettings::default() })?;
        let mut memory = Memory::new();
        let points = Points::uniform(0.0, time.last().copied().unwrap_or(0.0), period)?;
        closed.run(&Run::new(points, &table), &mut memory)?;
        let of = |name: &str, axis: usize| -> anyhow::Result<Vec<f64>> {
            let values = memory.values(&format!("{name}[{}]", axis + 1));
            Ok(values.with_context(|| format!("{name} was not recorded"))?[..rows].to_vec())
        };
        let axes = 0..self.axes;
        let position =
            axes.clone().map(|axis| of("position", axis)).collect::<Result<Vec<_>, _>>()?;
        let command = axes.map(|axis| of("command", axis)).collect::<Result<Vec<_>, _>>()?;
        let error = references
            .iter()
            .zip(&position)
            .map(|(r, y)| r.iter().zip(y).map(|(r, y)| r - y).collect())
            .collect();
        let reference = references.iter().map(|r| r[..rows].to_vec()).collect();
        Ok(Tracked { command, previewed: ahead, reference, position, error })
    }
}

/// How many variables `name[1]`, `name[2]`, … there are.
fn numbered(machine: &Fmu, causality: Causality, name: &str) -> usize {
    let names = machine.names(causality);
    (1..).take_while(|axis| names.contains(&format!("{name}[{axis}]"))).count()
}
