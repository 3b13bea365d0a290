//! A system as a file describes it: a short TOML, or an SSP.

mod from_osp;
mod from_ssp;
mod from_ssv;
mod from_toml;
mod prepare;
mod to_ssp;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use modeldescription::ssp::{ParameterValue, Ssp};

use crate::algorithm::{IterationSettings, Relaxation};
use crate::error::Error;
use crate::port::Port;
use crate::unit::Transformations;

pub use prepare::Prepared;

/// A system as a file describes it, read but not yet built: names of variables are not checked.
///
/// ```toml
/// name = "closed loop"
/// step = 1e-4                            # communication step in s
/// algorithm = "gauss-seidel"             # or "jacobi", "jacobi-extrapolated", "iteration"
/// order = ["controller", "plant"]        # of gauss-seidel; else sources before targets
///
/// [fmus]
/// plant = "plant.fmu"
/// controller = { file = "controller.fmu", step = 1e-3, start = { "k" = 2.0 } }
///
/// [connections]                          # input = output
/// "plant.command[1]" = "controller.command[1]"
/// "controller.measured[1]" = { from = "plant.position[1]", factor = 1e-6, convert = false }
///
/// [inputs]                               # input = column of the input table
/// "controller.reference[1]" = "reference[1]"
///
/// [record]                               # column of the record = variable
/// position = "plant.position[1]"
/// ```
#[derive(Debug)]
pub struct Plan {
    /// Name of the system.
    pub name: String,
    /// The file.
    pub origin: PathBuf,
    /// The FMUs.
    pub fmus: Vec<PlannedFmu>,
    /// Output to input.
    pub connections: Vec<PlannedConnection>,
    /// Column of the input table to input.
    pub inputs: Vec<PlannedInput>,
    /// Start values.
    pub starts: Vec<PlannedStart>,
    /// What is recorded: variable, name in the record. Empty: all connected inputs and all numeric
    /// outputs, as `fmu.variable`.
    pub record: Vec<(Port, String)>,
    /// How it is run.
    pub master: Master,
    /// What the file says that has no effect.
    pub notes: Vec<String>,
    /// Connections may be written from input to output, too.
    pub(crate) undirected: bool,
    /// Names of the FMUs, once they are needed.
    names: Mutex<HashSet<String>>,
    /// Keeps the unpacked archive.
    _ssp: Option<Ssp>,
}

/// An FMU of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedFmu {
    /// Name in the system.
    pub name: String,
    /// The FMU's file.
    pub path: PathBuf,
    /// Where it stands in the plan, for messages.
    pub place: String,
    /// The planned FMU's own step in s, if it is longer than the communication step.
    pub step: Option<f64>,
}

/// A connection of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedConnection {
    /// The output.
    pub from: Port,
    /// The input.
    pub to: Port,
    /// What happens on the way.
    pub way: Transformations,
    /// Where it stands in the plan, for messages.
    pub place: String,
}

/// An input that is fed from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedInput {
    /// The column of the input table.
    pub column: String,
    /// The input.
    pub to: Port,
    /// What happens on the way.
    pub way: Transformations,
    /// Where it stands in the plan, for messages.
    pub place: String,
}

/// A start value.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedStart {
    /// The variable.
    pub to: Port,
    /// The value.
    pub value: ParameterValue,
    /// What happens on the way.
    pub way: Transformations,
    /// Where it stands, for messages.
    pub place: String,
    /// Ignored where there is no such variable, as SSP wants it.
    pub optional: bool,
}

/// How the FMUs are stepped together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coupling {
    /// All side by side.
    Jacobi,
    /// All side by side, with inputs on straight lines.
    Extrapolation,
    /// One after the other.
    #[default]
    GaussSeidel,
    /// Algebraic loops are solved.
    Iteration,
}

impl Coupling {
    /// The coupling's name in files.
    pub fn name(self) -> &'static str {
        match self {
            Coupling::Jacobi => "jacobi",
            Coupling::Extrapolation => "jacobi-extrapolated",
            Coupling::GaussSeidel => "gauss-seidel",
            Coupling::Iteration => "iteration",
        }
    }

    /// The coupling of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Coupling::Jacobi, Coupling::Extrapolation, Coupling::GaussSeidel, Coupling::Iteration]
            .into_iter()
            .find(|coupling| coupling.name() == name)
    }
}

/// How a system is run; what is not said is found from the input table and the FMUs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Master {
    /// Start in s.
    pub start: Option<f64>,
    /// End in s.
    pub stop: Option<f64>,
    /// Communication step in s.
    pub step: Option<f64>,
    /// How the FMUs are stepped together.
    pub coupling: Coupling,
    /// The order of Gauss–Seidel; empty: sources before targets.
    pub order: Vec<String>,
    /// How loops are solved.
    pub iteration: IterationSettings,
}

impl Plan {
    /// Reads a plan: `.toml`, an `OspSystemStructure.xml`, or `.ssp`, an `.ssd` or an unpacked folder.
    ///
    /// # Errors
    /// Everything that is wrong in the file, with its lines.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
            return Plan::read_toml(path);
        }
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xml")) {
            return Plan::read_osp(path);
        }
        let osp = path.join(from_osp::FILE);
        if osp.is_file() && !path.join(modeldescription::ssp::SYSTEM_STRUCTURE).exists() {
            return Plan::read_osp(&osp);
        }
        Plan::read_ssp(path)
    }

    /// The variable that `fmu.variable` means; the longest name of an FMU counts.
    fn port(&self, text: &str) -> Option<Port> {
        let mut names = self.names.lock().unwrap_or_else(PoisonError::into_inner);
        if names.len() != self.fmus.len() {
            *names = self.fmus.iter().map(|fmu| fmu.name.clone()).collect();
        }
        port_of(&names, text)
    }
}

fn port_of(names: &HashSet<String>, text: &str) -> Option<Port> {
    let mut cuts = text.rmatch_indices('.').map(|(at, _)| (&text[..at], &text[at + 1..]));
    let (fmu, variable) = cuts.find(|(fmu, rest)| !rest.is_empty() && names.contains(*fmu))?;
    Some(Port::from((fmu, variable)))
}

/// The relaxation that a number means: Aitken's where there is none.
fn relaxation(omega: Option<f64>) -> Relaxation {
    omega.map_or(Relaxation::Aitken, Relaxation::Fixed)
}
