//! `piezoloop identify`: measured log → plant blueprint.

mod axes;
mod candidates;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use cli::{PageOptions, Screen};
use data::CheckedBlueprint;
use diagnose::{Between, Reading};
use identify::learned::{Seek, Selection};
use identify::{
    Dynamics, FeatureChoice, Identification, Learning, Methods, Observer, Record, Search, Settings,
    Swarm, Target,
};

use self::axes::{axis, join, unit};
pub(crate) use self::axes::{identifier, short_name, usual_unit};
use crate::inputs::{self, LogOptions, Readings};
use crate::results::identify::{AxisResult, Identified};
use crate::{pages, progress, ranges};

/// Identifies a plant from a measured log
///
/// Every hysteresis model is fitted to the first part of each record, with delay and offset, and with amplifier lag
/// and mode if the data show them. The model with the smallest error on the rest is written. All figures belong to
/// the plants as written, in simulation mode. Ctrl-C ends the search and writes the best model so far.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop identify --log model_1hz_3v6.csv --input u --output y --model prandtl-ishlinskii --drop 2 -o plant.toml\n  piezoloop identify --log stage.csv --input u_y --output y --input u_z --output z --unit y=um --unit z=um -o stage.toml --report stage.html"
)]
pub(crate) struct Identify {
    /// A measured log (may be given several times)
    #[arg(long = "log", value_name = "FILE", required = true)]
    logs: Vec<PathBuf>,
    /// Column of the command; once per axis
    #[arg(long = "input", value_name = "COLUMN", required = true)]
    inputs: Vec<String>,
    /// Column of the position; once per axis, in the order of the inputs
    #[arg(long = "output", value_name = "COLUMN", required = true)]
    outputs: Vec<String>,
    /// Model to fit (may be given several times) [default: all hysteresis models except the learned ones; the best is
    /// written]
    #[arg(long = "model", value_name = "MODEL", value_parser = model_names())]
    models: Vec<String>,
    /// Write the plants of all models to this folder, one file each
    #[arg(long, value_name = "FOLDER")]
    all: Option<PathBuf>,
    /// Command at which the machine rested before each record [default: the record's first command, or 0 if its first
    /// rows indicate that]
    #[arg(long, value_name = "COMMAND", value_parser = ranges::signal())]
    rest: Option<f64>,
    /// Search the shape parameters with a particle swarm instead of Levenberg-Marquardt
    #[arg(long)]
    swarm: bool,
    /// Seed of the particle swarm
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = ranges::seed())]
    seed: u64,
    /// Threads of the particle swarm; they do not change the result
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = ranges::threads())]
    threads: usize,
    /// Number of plays
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = ranges::count(1, 10_000))]
    plays: usize,
    /// Inputs of a learned model: for lssvm-stops add the command's rate; for lssvm-term its signals; for gp the number
    /// of inputs
    #[arg(long, value_enum, value_name = "INPUTS")]
    features: Option<Features>,
    /// Criterion for the settings of an LS-SVM [default: for lssvm-stops the evidence, for lssvm-narx and lssvm-term
    /// the error on the last third of the fitted rows]
    #[arg(long, value_enum, value_name = "WAY")]
    select: Option<Select>,
    /// Search method for these settings, with --select
    #[arg(long, value_enum, value_name = "WAY", default_value_t = Sought::Grid, requires = "select")]
    search: Sought,
    /// Prune an LS-SVM to this number of support vectors by Algorithm 1 of the laser beam paper [default: projection
    /// on the fewest centres with almost the same error]
    #[arg(long, value_name = "N", value_parser = ranges::count(2, 10_000))]
    prune: Option<usize>,
    /// Give the plant of a gp the output deviation: the standard deviation that the process predicts of a measured
    /// position
    #[arg(long)]
    deviation: bool,
    /// Run-in in s at the start of each record: simulated, but neither fitted nor judged [default: as long as the
    /// first rows differ from the prediction of the rest of the record]
    #[arg(long, value_name = "S", value_parser = ranges::time())]
    drop: Option<f64>,
    /// Last part of each record's time, which is held out to judge the fit
    #[arg(long, value_name = "PART", default_value_t = 0.5, value_parser = ranges::above(0.0, 0.99))]
    hold_out: f64,
    /// Do not fit amplifier lag and mode
    #[arg(long = "static")]
    is_static: bool,
    /// Name of the model [default: that of the file to write]
    #[arg(long)]
    name: Option<String>,
    #[command(flatten)]
    options: LogOptions,
    #[command(flatten)]
    readings: Readings,
    /// The blueprint to write
    #[arg(short = 'o', long = "out", value_name = "FILE", default_value = "plant.toml")]
    out: PathBuf,
    /// Write the loop of the first axis, measured and simulated, as an SVG picture
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    page: PageOptions,
}

/// What a learned machine may be told.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Features {
    /// For lssvm-stops: stop operators, the command and its rate, one width
    Rate,
    /// For lssvm-term: the command and past terms (model I)
    Command,
    /// For lssvm-term: the position and past terms (model II), which invert uses without an inverse
    Position,
    /// For lssvm-term: command, past positions and past terms (model III), the default
    Both,
    /// For gp: the command and its rate
    #[value(name = "2")]
    Two,
    /// For gp: both, one sample earlier, now and one sample later
    #[value(name = "6")]
    Six,
    /// For gp: also the acceleration
    #[value(name = "9")]
    Nine,
    /// For gp: also the jerk
    #[value(name = "12")]
    Twelve,
}

/// What settings are judged by.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Select {
    /// Ten blocks of rows, each left out once and simulated
    CrossValidation,
    /// Each row left out once, one step ahead
    LeaveOneOut,
    /// The last third, simulated
    HeldOut,
}

/// How settings are sought.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Sought {
    /// A particle swarm of 30 over 100 iterations
    Pso,
    /// Coupled simulated annealing, then a simplex
    Csa,
    /// A grid, then a simplex
    Grid,
}

/// Part of what is fitted on that a run-in may take: where the first rows are off for longer, it is the model that is
/// off.
const MOST_RUN_IN: f64 = 0.25;

/// What can be fitted, as the command line takes it.
fn model_names() -> clap::builder::PossibleValuesParser {
    let values =
        identify::methods().map(|(name, help)| clap::builder::PossibleValue::new(name).help(help));
    values.collect::<Vec<_>>().into()
}

impl Identify {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let result = self.execute(screen)?;
        let logs: Vec<&Path> = self.logs.iter().map(PathBuf::as_path).collect();
        self.page.finish(screen, &result, || pages::identification(&result, &logs))
    }

    /// A search for one model, for a command that writes no plant: the run-in (none: that of the first rows) and the
    /// part that is held out.
    pub(crate) fn one_model(
        model: &str,
        logs: &[PathBuf],
        (inputs, outputs): (&[String], &[String]),
        options: &LogOptions,
        (drop, hold_out): (Option<f64>, f64),
        (between, reading): (Between, Reading),
    ) -> Self {
        Self {
            logs: logs.to_vec(),
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            models: vec![model.to_owned()],
            all: None,
            rest: None,
            swarm: false,
            seed: 1,
            threads: 1,
            plays: 30,
            features: None,
            select: None,
            search: Sought::Grid,
            prune: None,
            deviation: false,
            drop,
            hold_out,
            readings: Readings::new(between, reading),
            is_static: false,
            name: Some("linear".to_owned()),
            options: options.clone(),
            out: PathBuf::new(),
            picture: None,
            page: PageOptions::default(),
        }
    }

    /// The plant, and what was found out; nothing is written.
    pub(crate) fn plant(&self, screen: &Screen) -> anyhow::Result<(CheckedBlueprint, Identified)> {
        if self.inputs.len() != self.outputs.len() {
            bail!(
                "{} --input and {} --output columns: give one of each per axis, in the same order",
                self.inputs.len(),
                self.outputs.len()
            );
        }
        if let Some((column, _)) = self.inputs.iter().zip(&self.outputs).find(|(u, y)| u == y) {
            bail!(
                "{column} is input and output of one axis; --input is the command, --output the measured position"
            );
        }
        self.work(screen)
    }

    /// Refuses options of learned machines where none is fitted.
    fn check_learning(&self) -> anyhow::Result<()> {
        let given = [
            ("--features", self.features.is_some()),
            ("--select", self.select.is_some()),
            ("--prune", self.prune.is_some()),
            ("--deviation", self.deviation),
        ];
        let is_learned = |name: &String| identify::is_learned(name);
        if let Some((option, _)) = given.iter().find(|(_, given)| *given)
            && !self.models.iter().any(is_learned)
        {
            bail!(
                "{option} is for learned machines, and none is fitted; name one, --model lssvm-stops, lssvm-narx, lssvm-term or gp, or \
                 leave {option} out"
            );
        }
        Ok(())
    }

    /// Identifies, and writes the blueprint.
    pub(crate) fn execute(&self, screen: &Screen) -> anyhow::Result<Identified> {
        self.check_learning()?;
        cli::can_write_as(&self.out, inputs::BLUEPRINT)?;
        self.page.can_write()?;
        self.picture.as_deref().map_or(Ok(()), cli::can_write)?;
        let all = self.all.as_deref().map(candidates::Folder::open).transpose()?;
        let (plant, result) = self.plant(screen)?;
        plant.write(&self.out)?;
        if let Some(all) = all {
            all.write(&result)?;
        }
        if let (Some(file), Some(axis)) = (&self.picture, result.axes.first()) {
            let svg = pages::picture(axis).context("there is no record to draw")?;
            data::AtomicFile::write_all_of(file, svg.as_bytes())
                .with_context(|| format!("{} cannot be written", file.display()))?;
        }
        Ok(result)
    }

    fn work(&self, screen: &Screen) -> anyhow::Result<(CheckedBlueprint, Identified)> {
        let names = self.options.names()?;
        let read = |path: &PathBuf| {
            let commands = self.inputs.iter().map(|input| names.column(input).unwrap_or(input));
            Ok(self.readings.held(self.options.read(path)?, commands))
        };
        let logs = self.logs.iter().map(read).collect::<anyhow::Result<Vec<_>>>()?;
        let mut notes = Vec::new();
        for (k, log) in
            self.logs.iter().enumerate().filter(|(k, log)| self.logs[..*k].contains(log))
        {
            notes.push(format!(
                "--log {} is given more than once and counts as often (no. {})",
                log.display(),
                k + 1
            ));
        }
        let mut tasks = Vec::new();
        for (k, (input, output)) in self.inputs.iter().zip(&self.outputs).enumerate() {
            let input_column = names.column(input).unwrap_or(input);
            let output_column = names.column(output).unwrap_or(output);
            let command_unit = unit(&logs, input_column, "V", &mut notes)?;
            let position_unit = unit(&logs, output_column, "um", &mut notes)?;
            let columns =
                ((input_column, command_unit.as_str()), (output_column, position_unit.as_str()));
            let mut records = Vec::new();
            for log in &logs {
                records.extend(identify::records_of(log, columns.0, columns.1)?);
            }
            if let Some(command) = self.rest {
                records = records.into_iter().map(|record| record.rested_at(command)).collect();
            }
            let target = Target {
                model: self.model_name(),
                source: self.source(),
                axis: axis(k, (input, &command_unit), (output, &position_unit)),
            };
            let drop = self.begin(&mut records, &command_unit, &mut notes);
            tasks.push(Task { name: output.clone(), records, target, command_unit, drop });
        }
        let run_in = tasks.iter().map(|task| task.drop).fold(0.0, f64::max);
        let axes = self.identify_all(tasks, screen)?;
        let plant = join(&axes)?;
        Ok((plant, Identified { blueprint: self.out.clone(), axes, notes, run_in }))
    }

    /// Finds out how the records begin and says it in a note. The run-in in s.
    fn begin(&self, records: &mut [Record], unit: &str, notes: &mut Vec<String>) -> f64 {
        // What does not suit is said by the identification itself.
        let Ok(found) = identify::beginnings(records, &self.settings()) else {
            return self.drop.unwrap_or(0.0);
        };
        for (record, beginning) in records.iter_mut().zip(&found) {
            if beginning.rest != record.rest() {
                notes.push(format!(
                    "{}: the machine rested under {} {unit}, as the first rows say, not under the first command, \
                     {:.4} {unit} (--rest COMMAND says otherwise)",
                    record.name(),
                    beginning.rest,
                    record.rest()
                ));
                *record = record.clone().rested_at(beginning.rest);
            }
        }
        self.drop.unwrap_or_else(|| {
            // One run-in for all records: it must leave the shortest one most of what is fitted on.
            let fitted = (1.0 - self.hold_out)
                * records.iter().map(Record::duration).fold(f64::INFINITY, f64::min);
            let longest = found.iter().map(|beginning| beginning.run_in).fold(0.0, f64::max);
            let run_in = if longest <= MOST_RUN_IN * fitted { longest } else { 0.0 };
            if longest > run_in {
                notes.push(format!(
                    "the first {longest:.4} s differ from the prediction of the rest of the record, more than {:.0} % of \
                     the {fitted:.4} s that are fitted on: nothing is dropped, because the model may be the reason (--drop {longest:.4} omits them)",
                    100.0 * MOST_RUN_IN
                ));
            }
            if run_in > 0.0 {
                notes.push(format!(
                    "a run-in of {run_in:.4} s is neither fitted nor judged: the first rows differ from what \
                     the rest of the record predicts (--drop 0 keeps them)"
                ));
            }
            run_in
        })
    }

    /// Identifies the axes side by side; the first one moves the progress bar.
    fn identify_all(&self, tasks: Vec<Task>, screen: &Screen) -> anyhow::Result<Vec<AxisResult>> {
        cli::interrupt::listen()?;
        let one = |task: &Task, observer: &mut dyn Observer| -> anyhow::Result<Identification> {
            let settings = Settings { drop: task.drop, ..self.settings() };
            Ok(identify::identify(&task.records, &task.target, &settings, observer)?)
        };
        let one = &one;
        let Some((first, rest)) = tasks.split_first() else { return Ok(Vec::new()) };
        let found: Vec<anyhow::Result<Identification>> = std::thread::scope(|scope| {
            let others: Vec<_> = rest
                .iter()
                .map(|task| {
                    let own = move || one(task, &mut progress::NoProgress);
                    (task, std::thread::Builder::new().spawn_scoped(scope, own))
                })
                .collect();
            let mut all = vec![one(first, &mut progress::Stages::new(screen, "identify"))];
            for (task, other) in others {
                all.push(match other {
                    Ok(other) => other.join().unwrap_or_else(|_| {
                        Err(anyhow::anyhow!("an axis could not be identified: internal error"))
                    }),
                    // The system gives no more threads: this one does the work.
                    Err(_) => one(task, &mut progress::NoProgress),
                });
            }
            all
        });
        let result = |(task, found): (Task, anyhow::Result<Identification>)| {
            let Task { name, records, command_unit, .. } = task;
            Ok(AxisResult { name, identification: found?, records, command_unit })
        };
        tasks.into_iter().zip(found).map(result).collect()
    }

    fn settings(&self) -> Settings {
        let methods = match self.models.as_slice() {
            [] => Methods::Sensible,
            names => Methods::Named(names.to_vec()),
        };
        let swarm = Swarm { seed: self.seed, threads: self.threads, ..Swarm::default() };
        Settings {
            methods,
            search: if self.swarm { Search::ParticleSwarm(swarm) } else { Search::default() },
            plays: self.plays,
            learning: self.learning(),
            hold_out: self.hold_out,
            dynamics: if self.is_static { Dynamics::Static } else { Dynamics::Automatic },
            ..Settings::default()
        }
    }

    fn learning(&self) -> Learning {
        let seek = match self.search {
            Sought::Pso => Seek::Swarm,
            Sought::Csa => Seek::Annealing,
            Sought::Grid => Seek::Grid,
        };
        let selection = self.select.map(|way| match way {
            Select::CrossValidation => Selection::CrossValidation(10),
            Select::LeaveOneOut => Selection::LeaveOneOut,
            Select::HeldOut => Selection::HeldOut,
        });
        let features = match self.features {
            None => FeatureChoice::Usual,
            Some(Features::Rate) => FeatureChoice::Rate,
            Some(Features::Command) => FeatureChoice::Command,
            Some(Features::Position) => FeatureChoice::Position,
            Some(Features::Both) => FeatureChoice::Both,
            Some(Features::Two) => FeatureChoice::Inputs(2),
            Some(Features::Six) => FeatureChoice::Inputs(6),
            Some(Features::Nine) => FeatureChoice::Inputs(9),
            Some(Features::Twelve) => FeatureChoice::Inputs(12),
        };
        let (selection, prune) = (selection.map(|way| (way, seek)), self.prune);
        Learning { selection, prune, features, deviation: self.deviation }
    }

    fn model_name(&self) -> String {
        let stem = || self.out.file_stem().map(|s| s.to_string_lossy().into_owned());
        let text = self.name.clone().or_else(stem).unwrap_or_else(|| "plant".to_owned());
        identifier(&text)
    }

    fn source(&self) -> String {
        let file = |p: &PathBuf| p.file_name().map(|f| f.to_string_lossy().into_owned());
        let files: Vec<_> = self.logs.iter().filter_map(file).collect();
        format!("identified from {}", files.join(", "))
    }
}

/// What one axis is identified from.
struct Task {
    name: String,
    records: Vec<Record>,
    target: Target,
    command_unit: String,
    /// Run-in in s.
    drop: f64,
}
