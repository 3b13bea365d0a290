//! The file of a repair.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::block::Block;

/// Name of the file in the resources of a repaired FMU.
pub const FILE: &str = "repair.toml";

/// The format of the file that this version reads and writes.
pub const FORMAT: u32 = 1;

/// What is put around an FMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Repair {
    /// Always [`FORMAT`].
    pub format: u32,
    /// GUID of the repaired FMU.
    pub token: String,
    /// Longest step between two looks at the original, in s: the sample time of the log.
    pub step: f64,
    /// Whether a longer communication step is divided; else the original cannot be stepped so.
    pub divide: bool,
    /// The FMU in `inner/`.
    pub original: Original,
    /// Inputs that blocks read or drive.
    #[serde(default, rename = "input")]
    pub inputs: Vec<Port>,
    /// Outputs that blocks change.
    #[serde(default, rename = "output")]
    pub outputs: Vec<Port>,
    /// Parameters of the original that an effect changes.
    #[serde(default, rename = "change")]
    pub changes: Vec<Change>,
    /// Effects, in the order in which they were found.
    #[serde(default, rename = "effect")]
    pub effects: Vec<Effect>,
    /// Float64 variables with more than one value: value reference, number of values.
    #[serde(default)]
    pub sizes: Vec<(u32, usize)>,
    /// Start values that the original is given in place of its own.
    #[serde(default, rename = "preset", skip_serializing_if = "Vec::is_empty")]
    pub presets: Vec<Variable>,
}

/// The FMU inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Original {
    /// Version of the standard, `2.0` or `3.0`.
    pub fmi: String,
    /// The original's `modelIdentifier`.
    pub identifier: String,
    /// The original's GUID.
    pub token: String,
    /// SHA-256 of its archive.
    pub sha256: String,
}

/// A variable of the FMU, whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variable {
    /// Value reference.
    pub reference: u32,
    /// Start values, one per element.
    pub start: Vec<f64>,
}

/// One element of an input or output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Port {
    /// Name of the element.
    pub name: String,
    /// The port's variable.
    pub variable: Variable,
    /// Number of the element, from 0.
    #[serde(default)]
    pub element: usize,
    /// Whether the variable is one of the repair's own and unknown to the original.
    #[serde(default)]
    pub own: bool,
    /// Unit, for the description.
    pub unit: String,
    /// SI per unit.
    pub factor: f64,
    /// SI at 0.
    #[serde(default)]
    pub offset: f64,
}

/// A parameter of the original to which an effect adds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// The variable.
    pub variable: Variable,
    /// Number of the element, from 0.
    #[serde(default)]
    pub element: usize,
    /// Number of the effect, from 0.
    pub effect: usize,
    /// Number of its parameter that is added, from 0.
    pub parameter: usize,
}

/// One effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effect {
    /// Name before the dot of its variables.
    pub name: String,
    /// What the effect is.
    pub description: String,
    /// Start value of `<name>.enabled`.
    pub enabled: bool,
    /// Value reference of `<name>.enabled`.
    pub reference: u32,
    /// The effect's parameters.
    #[serde(default, rename = "parameter")]
    pub parameters: Vec<Parameter>,
    /// What the effect does.
    #[serde(default, rename = "block")]
    pub blocks: Vec<Piece>,
}

/// A parameter of an effect: `<effect>.<name>`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Name behind the dot.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Unit.
    pub unit: String,
    /// SI per unit.
    pub factor: f64,
    /// Start value.
    pub start: f64,
    /// Least value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Greatest value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Value reference.
    pub reference: u32,
}

/// On which side of the original a block is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Before it.
    Input,
    /// Behind it.
    Output,
}

/// A block in its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Piece {
    /// Before or behind the original.
    pub side: Side,
    /// Number of the input or output, from 0.
    pub port: usize,
    /// Number of the input that drives this path, from 0.
    pub drive: usize,
    /// Number of the input that is the auxiliary signal, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub auxiliary: Option<usize>,
    /// Place on the path; lower ones come first.
    pub place: u32,
    /// Numbers of the effect's parameters that the block takes, from 0.
    #[serde(default)]
    pub parameters: Vec<usize>,
    /// The block.
    pub block: Block,
}

impl Piece {
    /// The parameters of its block in SI, from the values of the effect's.
    pub(crate) fn values(&self, effect: &Effect, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let factor = |k: usize| effect.parameters.get(k).map_or(1.0, |p| p.factor);
        self.parameters.iter().map(|k| value(*k) * factor(*k)).collect()
    }
}

/// A repair that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file cannot be read.
    #[error("{path}: {reason}; unpack the whole FMU, or repair the model again", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// What it says does not go together.
    #[error("the repair does not fit together: {}; repair the model again", .0.join("; "))]
    Content(Vec<String>),
}

impl Repair {
    /// Reads and checks the file in a folder of resources.
    ///
    /// # Errors
    /// [`Error`]: no such file, no TOML, or [`check`](Self::check).
    pub fn read(resources: &Path) -> Result<Self, Error> {
        let path = resources.join(FILE);
        let failed = |reason: String| Error::File { path: path.clone(), reason };
        let text = std::fs::read_to_string(&path).map_err(|e| failed(e.to_string()))?;
        let repair: Self = toml::from_str(&text).map_err(|e| failed(e.to_string()))?;
        repair.check()?;
        Ok(repair)
    }

    /// The text of the file.
    ///
    /// # Errors
    /// [`Error::Content`] where TOML cannot hold it.
    pub fn to_toml(&self) -> Result<String, Error> {
        toml::to_string(self).map_err(|e| Error::Content(vec![e.to_string()]))
    }

    /// Checks that all numbers point to something.
    ///
    /// # Errors
    /// [`Error::Content`] with every problem.
    pub fn check(&self) -> Result<(), Error> {
        let mut all = Vec::new();
        let mut want = |is: bool, message: String| {
            if !is {
                all.push(message);
            }
        };
        want(self.format == FORMAT, format!("format {} is not {FORMAT}", self.format));
        want(self.step.is_finite() && self.step > 0.0, format!("step {} is no time", self.step));
        for port in self.inputs.iter().chain(&self.outputs) {
            let start = &port.variable.start;
            want(port.element < start.len(), format!("{} has no such element", port.name));
            let is_unit = port.factor.is_finite() && port.factor != 0.0 && port.offset.is_finite();
            want(is_unit, format!("{}: the unit's factor is {}", port.name, port.factor));
        }
        for effect in &self.effects {
            let name = &effect.name;
            for p in &effect.parameters {
                let is_number = p.start.is_finite() && p.factor.is_finite() && p.factor != 0.0;
                want(is_number, format!("{name}.{} starts at {}", p.name, p.start));
            }
            for piece in &effect.blocks {
                let ports = match piece.side {
                    Side::Input => &self.inputs,
                    Side::Output => &self.outputs,
                };
                want(piece.port < ports.len(), format!("{name}: no port {}", piece.port));
                let inputs = [Some(piece.drive), piece.auxiliary];
                let known = inputs.into_iter().flatten().all(|k| k < self.inputs.len());
                want(known, format!("{name}: it reads an input that is not there"));
                let own = piece.parameters.iter().all(|k| *k < effect.parameters.len());
                want(own, format!("{name}: it takes a parameter that is not there"));
                let p = piece.values(effect, |k| effect.parameters.get(k).map_or(1.0, |p| p.start));
                if let Err(wrong) = piece.block.prepare(&p, self.step) {
                    want(false, format!("{name}: {wrong}"));
                }
            }
        }
        for change in &self.changes {
            let effect = self.effects.get(change.effect);
            let known = effect.is_some_and(|e| change.parameter < e.parameters.len());
            want(known && change.element < change.variable.start.len(), {
                format!("the change of variable {} is of nothing", change.variable.reference)
            });
        }
        if all.is_empty() { Ok(()) } else { Err(Error::Content(all)) }
    }
}
