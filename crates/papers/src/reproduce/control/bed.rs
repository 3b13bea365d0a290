//! A packed machine: stepped by hand, or in a closed loop with a packed controller.

use std::ops::{Deref, DerefMut};
use std::path::Path;

use anyhow::Context;
use cosim::{
    Fmu, InstanceOptions, Loop, LoopSettings, Memory, Points, Run, Signal, Signals, Wiring,
};
use data::Blueprint;

use crate::Tool;

/// A machine on the bench, which is stepped as a [`cosim::Bed`].
pub struct Bed {
    plant: cosim::Bed,
    tool: Tool,
}

impl Deref for Bed {
    type Target = cosim::Bed;

    fn deref(&self) -> &cosim::Bed {
        &self.plant
    }
}

impl DerefMut for Bed {
    fn deref_mut(&mut self) -> &mut cosim::Bed {
        &mut self.plant
    }
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
    /// Packs a plant with this tool, from its blueprint or the name of a rig, and puts it on the bench.
    ///
    /// # Errors
    /// Where it cannot be packed, has no inputs `command[i]` with as many outputs `position[i]`, or cannot be
    /// instantiated.
    pub fn open(tool: &Tool, what: &Path) -> anyhow::Result<Self> {
        let folder = tempfile::tempdir().context("no temporary folder can be made")?;
        let file = folder.path().join("packed.fmu");
        tool.pack_file(what, &file)?;
        let plant = cosim::Bed::new(Fmu::open(&file)?, Some(folder), what)?;
        Ok(Self { plant, tool: tool.clone() })
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
        self.tool.pack(controller, &file)?;
        let packed = cosim::Fmu::open(&file)?;
        let options = InstanceOptions::default();
        let (c, p) = (
            packed.instantiate("controller", &options)?,
            self.plant.machine().instantiate("plant", &options)?,
        );
        let rows = references.iter().map(Vec::len).min().unwrap_or(0);
        let time: Vec<f64> = (0..rows).map(|k| k as f64 * period).collect();
        let ahead: Vec<Vec<f64>> = references
            .iter()
            .map(|r| (0..rows).map(|k| r[(k + preview).min(rows - 1)]).collect())
            .collect();
        let names: Vec<String> =
            (1..=self.axes()).map(|axis| format!("reference[{axis}]")).collect();
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
        let axes = 0..self.axes();
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
