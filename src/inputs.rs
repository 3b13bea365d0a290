//! What several commands take: a log's options, a blueprint by file or rig, a file to write.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use cosim::Fmu;
use data::{Blueprint, Log, NameMap, ReadOptions, Resample};
use diagnose::{Between, Reading};
use modeldescription::variable::Causality;

use crate::ranges;

/// How the columns of a log are read.
#[derive(Args, Debug, Clone, Default)]
pub(crate) struct LogOptions {
    /// Assign a column to a variable of the model; time=COLUMN names the time column of a log that has no column
    /// called time (may be given several times)
    #[arg(long = "map", value_name = "FMU_NAME=COLUMN")]
    pub(crate) map: Vec<String>,
    /// Unit of a column; overrides the header and dataset.toml (may be given several times)
    #[arg(long = "unit", value_name = "COLUMN=UNIT")]
    pub(crate) unit: Vec<String>,
    /// Sample rate in Hz, for logs without a time column or with a row index instead
    #[arg(long, value_name = "HZ", value_parser = ranges::above(0.0, 1e12))]
    pub(crate) rate: Option<f64>,
    /// The group of a measurement file (MDF, TDMS) to read, or the length of the arrays (MAT, npz)
    #[arg(long, value_name = "NAME")]
    pub(crate) group: Option<String>,
    /// Memory limit in MB for the numbers of a binary log [default: 268, or 100 times the size of the file if that is
    /// more]
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub(crate) log_memory: Option<u64>,
    /// Column names of a text file without a header, with units as in 'y [um]'
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) columns: Vec<String>,
    /// Resample the log to uniform times, and join groups with different times; without HZ at the times of the
    /// fastest group
    #[arg(long, value_name = "HZ", num_args = 0..=1, require_equals = true, default_missing_value = "fastest", value_parser = resample)]
    pub(crate) resample: Option<Resample>,
}

/// How the rows of a log are read, for a command that is not to find it out.
#[derive(Args, Debug, Clone, Default)]
pub(crate) struct Readings {
    /// Command between two rows of the logs: zoh (held), line, band-limited [default: held]
    #[arg(long, value_name = "BETWEEN", value_parser = ["zoh", "line", "band-limited"])]
    between: Option<String>,
    /// Instant of a row's reading: before its command acts, with it, or after it has acted [default: before a held
    /// command, with one that moves]
    #[arg(long, value_name = "READING", value_parser = ["before", "with", "after"])]
    reading: Option<String>,
}

impl Readings {
    pub(crate) fn new(between: Between, reading: Reading) -> Self {
        Self { between: Some(between.name().into()), reading: Some(reading.name().into()) }
    }

    /// The log with held commands in the columns that feed inputs of an FMU; `map` says which column feeds which variable.
    pub(crate) fn held_for(&self, fmu: &Fmu, map: &[(String, String)], log: Log) -> Log {
        let inputs = fmu.names(Causality::Input);
        let driven = map.iter().filter(|(variable, _)| inputs.contains(variable));
        self.held(log, driven.map(|(_, column)| column.as_str()))
    }

    /// The log with held commands in these columns, to which a machine answers as to the commands it had.
    pub(crate) fn held<'a>(&self, mut log: Log, commands: impl Iterator<Item = &'a str>) -> Log {
        // Its own are held already.
        if self.between.is_none() && self.reading.is_none() {
            return log;
        }
        let between = self.between.as_deref().and_then(Between::find).unwrap_or_default();
        let reading = self.reading.as_deref().and_then(Reading::find);
        for command in commands {
            log.replace(command, |time, values| between.as_held(reading, time, values));
        }
        log
    }
}

/// Refuses a log that is both fitted and judged, under whatever name.
pub(crate) fn are_apart(
    (fits, fitted): (&str, &[PathBuf]),
    (judges, judged): (&str, &[PathBuf]),
) -> anyhow::Result<()> {
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let fitted: Vec<PathBuf> = fitted.iter().map(|path| real(path)).collect();
    match judged.iter().find(|path| fitted.contains(&real(path))) {
        Some(both) => bail!(
            "{judges} {}: is also a {fits}, and a log that is fitted cannot judge the fit; give another one, or leave \
             {judges} out",
            both.display()
        ),
        None => Ok(()),
    }
}

/// The rate of `--resample=HZ`, or `fastest`.
fn resample(text: &str) -> Result<Resample, String> {
    if text == "fastest" {
        return Ok(Resample::Fastest);
    }
    let rate = text.parse().ok().filter(|rate: &f64| rate.is_finite() && *rate > 0.0);
    rate.map(Resample::Rate).ok_or_else(|| {
        "must be a positive rate in Hz; without a value the rate of the fastest group is used"
            .into()
    })
}

impl LogOptions {
    /// Reads a log; what was assumed, skipped or left out is said and goes into the answer.
    pub(crate) fn read(&self, path: &Path) -> anyhow::Result<Log> {
        let log = self.read_in_silence(path)?;
        cli::note_on_log(&log.notes());
        Ok(log)
    }

    /// Reads a log for a command that says its notes itself.
    pub(crate) fn read_in_silence(&self, path: &Path) -> anyhow::Result<Log> {
        let mut options = ReadOptions {
            rate: self.rate,
            group: self.group.clone(),
            memory: self.log_memory.map(|megabytes| megabytes * 1_000_000),
            columns: self.columns.clone(),
            resample: self.resample,
            ..ReadOptions::default()
        };
        for unit in &self.unit {
            options.add_unit(unit)?;
        }
        let read = Log::read(path, &options);
        // A column of the log that is called time is its time; a variable may have that name too, and then it has a column.
        match self.names()?.column("time") {
            Some(column) if !read.as_ref().is_ok_and(|log| log.column(column).is_some()) => {
                options.time = Some(column.to_owned());
                Ok(Log::read(path, &options)?)
            }
            _ => Ok(read?),
        }
    }

    /// Which column belongs to which variable.
    pub(crate) fn names(&self) -> anyhow::Result<NameMap> {
        Ok(NameMap::parse(&self.map)?)
    }
}

/// A column of one of several logs, in the unit that it has in the first; `unit` is that unit, once it is known.
pub(crate) fn column(log: &Log, name: &str, unit: &mut Option<String>) -> anyhow::Result<Vec<f64>> {
    let own = log.require(name)?;
    let text = own.unit.as_ref().map(|unit| unit.text.clone());
    match unit {
        Some(first) => Ok(log.convert(name, first)?),
        None => {
            *unit = text;
            Ok(own.values.clone())
        }
    }
}

/// A blueprint with the text that it was read from.
pub(crate) struct BlueprintText {
    /// As it stands in the file; with the values of records put in.
    pub(crate) text: String,
    /// What the blueprint text says.
    pub(crate) blueprint: Blueprint,
}

/// Reads a blueprint: a file, or the name of a rig where no such file is.
pub(crate) fn blueprint(what: &Path) -> anyhow::Result<BlueprintText> {
    let name = what.to_string_lossy();
    let (origin, text) = match (what.exists(), rigs::find(&name)) {
        (false, Some(rig)) => (format!("rig {}", rig.name), rig.blueprint.to_owned()),
        (false, None) if what.extension().is_none() => {
            let known: Vec<_> = rigs::RIGS.iter().map(|rig| rig.name).collect();
            let near = meant(&name, known.iter().copied());
            bail!(
                "{name}: no such file, and no rig of this name; {near}rigs are {}",
                known.join(", ")
            )
        }
        _ => {
            let text = files::read_text(what).with_context(|| {
                format!(
                    "{name} cannot be read as a blueprint; give a .toml file or the name of a rig"
                )
            })?;
            (name.into_owned(), text)
        }
    };
    let blueprint = Blueprint::parse(&text, &origin)?;
    // A text that is carried away must not need a record.
    let text = if blueprint.records().is_empty() { text } else { blueprint.to_toml() };
    Ok(BlueprintText { text, blueprint })
}

/// `did you mean W? ` with the known word that is like `word`, or nothing.
pub(crate) fn meant<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    data::nearest(word, known).map_or_else(String::new, |near| format!("did you mean {near}? "))
}

/// The file to write: as asked, else `name` with this ending beside the caller.
pub(crate) fn output(given: Option<PathBuf>, name: &str, ending: &str) -> PathBuf {
    given.unwrap_or_else(|| PathBuf::from(format!("{name}.{ending}")))
}

/// Endings of what is written as CSV.
pub(crate) const CSV: &[&str] = &["csv", "txt"];
/// Endings of runs.
pub(crate) const RUN: &[&str] = &["csv", "txt", "npy", "npz", "parquet"];
/// Endings of blueprints.
pub(crate) const BLUEPRINT: &[&str] = &["toml"];
/// Endings of FMUs.
pub(crate) const FMU: &[&str] = &["fmu"];
/// Endings of sets of parameters.
pub(crate) const PARAMETERS: &[&str] = &["ssv"];
/// Endings of systems.
pub(crate) const SYSTEM: &[&str] = &["ssp"];
/// Endings of tables of many runs.
pub(crate) const TABLE: &[&str] = &["parquet"];
