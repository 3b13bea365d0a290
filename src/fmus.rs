//! FMUs as the commands take them: opened, or packed from a blueprint first; and their short names.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Args;
use cosim::{Fmu, Worker};
use data::{Blueprint, CheckedBlueprint, Log, NameMap};
use modeldescription::Package;
use modeldescription::description::{BaseUnit, Line, Unit};
use modeldescription::variable::Causality;

use crate::{inputs, packing, ranges};

/// An opened FMU with a name for messages.
pub(crate) struct Opened {
    pub(crate) name: String,
    pub(crate) fmu: Fmu,
    /// Holds a packed blueprint as long as it is used.
    pub(crate) folder: Option<tempfile::TempDir>,
}

/// What the process of an FMU takes itself, with room, in MB.
const LEAST_MEMORY: f64 = 32.0;

/// In which process FMUs run.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct Isolation {
    /// Run each FMU in a separate process: if one crashes or hangs, the error names it
    #[arg(long)]
    pub(crate) isolate: bool,
    /// Time limit of one call to an FMU in s
    #[arg(
        long,
        value_name = "S",
        default_value_t = 60.0,
        requires = "isolate",
        value_parser = ranges::above(0.0, ranges::LONGEST)
    )]
    timeout: f64,
    /// Memory limit of each FMU's process in MB; requests beyond it fail
    #[arg(long, value_name = "MB", requires = "isolate", value_parser = ranges::from(LEAST_MEMORY, 1e9))]
    memory: Option<f64>,
}

impl Isolation {
    /// How processes for FMUs are started; none: they run in this one.
    pub(crate) fn worker(&self) -> anyhow::Result<Option<Worker>> {
        if !self.isolate {
            return Ok(None);
        }
        let timeout = Duration::from_secs_f64(self.timeout);
        let mut worker = Worker::this_program(crate::commands::WORKER, timeout)
            .context("this program does not find itself to start FMUs in their own processes")?;
        worker.memory = self.memory.map(|megabytes| (megabytes * 1e6) as u64);
        Ok(Some(worker))
    }
}

/// Opens an FMU; packs a blueprint or a rig first.
pub(crate) fn open(what: &Path) -> anyhow::Result<Opened> {
    open_in(what, None)
}

/// Opens an FMU's file, to run in processes of its own where there is a worker.
pub(crate) fn load(file: &Path, worker: Option<&Worker>) -> Result<Fmu, cosim::Error> {
    match worker {
        Some(worker) => Fmu::open_isolated(file, worker),
        None => Fmu::open(file),
    }
}

/// Opens an FMU, or packs a blueprint or a rig first, to run in processes of its own where there is a worker.
pub(crate) fn open_in(what: &Path, worker: Option<&Worker>) -> anyhow::Result<Opened> {
    let is_blueprint = cli::ends_in(what, "toml") || !what.exists();
    if !is_blueprint {
        let fmu = load(what, worker)?;
        return Ok(Opened { name: fmu.description().model_name.clone(), fmu, folder: None });
    }
    if cli::ends_in(what, "fmu") {
        bail!("{}: there is no such file", what.display());
    }
    let source = inputs::blueprint(what)?;
    let folder = tempfile::tempdir().context("no temporary folder can be made")?;
    let file = folder.path().join("packed.fmu");
    packing::pack_to_run(&source, &file)?;
    let fmu = load(&file, worker)?;
    Ok(Opened { name: source.blueprint.name, fmu, folder: Some(folder) })
}

/// The blueprint that an FMU carries, where this version can read it.
pub(crate) fn carried(package: &Package) -> Option<CheckedBlueprint> {
    let text = std::fs::read_to_string(package.resources().join("blueprint.toml")).ok()?;
    Blueprint::parse(&text, "blueprint.toml").ok()?.check(learned::COMPONENTS).ok()
}

/// The variables of a blueprint that have a short name: that name, and their own.
pub(crate) fn short_names(blueprint: &CheckedBlueprint) -> Vec<(String, String)> {
    let system = blueprint.build();
    let variables = system.variables().as_slice().iter();
    variables.filter_map(|v| Some((v.alias.clone()?, v.name.clone()))).collect()
}

/// The names under which the variables of an FMU may be addressed: their own, and, for an FMU that
/// carries a blueprint, its short names (`u`, `y`).
pub(crate) struct Addresses {
    /// Short name, variable.
    short: Vec<(String, String)>,
    inputs: Vec<String>,
    all: Vec<String>,
}

impl Addresses {
    pub(crate) fn of(fmu: &Fmu) -> Self {
        let short = carried(fmu.package()).as_ref().map(short_names).unwrap_or_default();
        let inputs = fmu.names(Causality::Input);
        let all = fmu.description().variables.iter().map(|v| v.name.clone()).collect();
        Self { short, inputs, all }
    }

    /// Whether every variable that a map names is there.
    ///
    /// # Errors
    /// The first one that is not, with the one that was probably meant.
    pub(crate) fn check(&self, names: &NameMap) -> anyhow::Result<()> {
        let known = || {
            let short = self.short.iter().map(|(short, _)| short.as_str());
            self.all
                .iter()
                .map(String::as_str)
                .chain(self.inputs.iter().map(String::as_str))
                .chain(short)
        };
        // A map's names stand without the blanks around them, which a variable may have.
        let is = |known: &str, name: &str| {
            let known = known.trim();
            // An element of an array is named too.
            known == name || name.strip_prefix(known).is_some_and(|rest| rest.starts_with('['))
        };
        let unknown = |name: &str| name != "time" && !known().any(|known| is(known, name));
        if let Some((name, column)) = names.iter().find(|(name, _)| unknown(name)) {
            let element = known().find(|known| known.split('[').next() == Some(name));
            let near = if let Some(element) = element {
                format!("; did you mean {element}={column}?")
            } else if known().any(|known| is(known, column)) {
                format!("; the order is VARIABLE=COLUMN: did you mean {column}={name}?")
            } else {
                data::nearest(name, known())
                    .map_or_else(String::new, |near| format!("; did you mean {near}={column}?"))
            };
            bail!(
                "--map {name}={column}: {name} is no variable of the FMU, whose inputs are {}{near}",
                self.inputs.join(", ")
            );
        }
        Ok(())
    }

    /// The variable that a user means.
    pub(crate) fn variable(&self, name: &str) -> String {
        let found = self.short.iter().find(|(short, _)| short == name);
        found.map_or_else(|| name.to_owned(), |(_, variable)| variable.clone())
    }

    /// The column for each variable that the map or a short name gives one: `(variable, column)`.
    pub(crate) fn columns(
        &self,
        names: &NameMap,
        log: &Log,
    ) -> anyhow::Result<Vec<(String, String)>> {
        let mut map: Vec<(String, String)> = Vec::new();
        // The column of time is no signal.
        let is_time = |(of, column): &(&str, &str)| *of == "time" && log.column(column).is_none();
        for (variable, column) in names.iter().filter(|pair| !is_time(pair)) {
            log.require(column)?;
            map.push((self.variable(variable), column.to_owned()));
        }
        map.retain(|(variable, _)| self.inputs.contains(variable));
        for input in &self.inputs {
            let known = map.iter().any(|(variable, _)| variable == input);
            if known || log.column(input).is_some() {
                if !known {
                    map.push((input.clone(), input.clone()));
                }
                continue;
            }
            let short = self.short.iter().find(|(_, variable)| variable == input);
            if let Some((short, _)) = short.filter(|(short, _)| log.column(short).is_some()) {
                map.push((input.clone(), short.clone()));
            }
        }
        Ok(map)
    }

    /// The column of the log that measures this output, if there is one.
    pub(crate) fn measured_column(
        &self,
        output: &str,
        names: &NameMap,
        log: &Log,
    ) -> Option<String> {
        if self.inputs.iter().any(|input| input == output) {
            return None;
        }
        let short = self.short.iter().find(|(_, variable)| variable == output);
        let short = short.map(|(short, _)| short.as_str());
        let mapped = names.column(output).or_else(|| names.column(short?));
        let named = [mapped, Some(output), short];
        named.into_iter().flatten().find(|name| log.column(name).is_some()).map(str::to_owned)
    }
}

/// A unit as FMI declares it.
pub(crate) fn fmi_unit(name: &str, unit: &model::Unit) -> Unit {
    let [kg, m, s, a, k, mol, cd, rad] = unit.exponents.map(i32::from);
    let (factor, offset) = (unit.factor, unit.offset);
    Unit {
        name: name.to_owned(),
        base: Some(BaseUnit { kg, m, s, a, k, mol, cd, rad, factor, offset }),
        display_units: Vec::new(),
        line: Line::default(),
    }
}
