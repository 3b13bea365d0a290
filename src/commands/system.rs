//! `piezoloop system`: any number of FMUs, connected by a TOML or an SSP.

mod recording;

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::{Context, bail};
use clap::Args;
use cli::{Answer, PageOptions, Screen};
use cosim::plan::{Coupling, PlannedFmu};
use cosim::{Ending, Fmu, Plan, Points, RecordFile, Run, Signal, Signals};
use data::Log;
use modeldescription::ModelDescription;
use serde::Serialize;

use self::recording::Recording;
use super::simulate;
use crate::fmus::{self, Isolation};
use crate::inputs::{self, LogOptions};
use crate::messages::MessageOptions;
use crate::results::simulate::EarlyEnd;
use crate::results::system::{Drawn, Ran};
use crate::times::{self, RunTimes};
use crate::{pages, progress, records};

/// Runs a system of connected FMUs, described by a short TOML file or an SSP
///
/// The FMUs may come from any vendor, of FMI 2.0 and 3.0. An input table (a log) feeds the system's inputs; the
/// record is written to .csv, .npy, .npz or .parquet.
#[derive(Args, Debug)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct System {
    /// The system: .toml, .ssp, .ssd or an unpacked SSP
    file: PathBuf,
    /// The input table, a log with a column for each input of the system
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
    /// Start values from a parameter set (SSV) with names `fmu.variable`; they override the system's (may be given
    /// several times)
    #[arg(long, value_name = "FILE")]
    parameters: Vec<PathBuf>,
    /// Communication step in s [default: the system's; otherwise the smallest of the FMUs' preferred steps and the
    /// input table's sample time]
    #[arg(long, value_name = "S", value_parser = crate::ranges::above(0.0, crate::ranges::LONGEST))]
    step: Option<f64>,
    /// End of the run in s [default: the system's; otherwise that of the input table; otherwise the latest that an
    /// FMU prefers]
    #[arg(long, value_name = "S", value_parser = crate::ranges::from(-crate::ranges::LONGEST, crate::ranges::LONGEST))]
    stop: Option<f64>,
    /// Order of the steps [default: the system's, else gauss-seidel]
    #[arg(long, value_name = "NAME")]
    algorithm: Option<Algorithm>,
    #[command(flatten)]
    isolation: Isolation,
    #[command(flatten)]
    messages: MessageOptions,
    /// Initialise the FMUs without a stop time, for FMUs that refuse to step up to it
    #[arg(long)]
    no_stop_time: bool,
    /// Simulated seconds per second of real time: 1 runs in real time [default: as fast as possible]
    #[arg(long, value_name = "X", conflicts_with = "export", allow_negative_numbers = true)]
    pace: Option<f64>,
    #[command(flatten)]
    options: LogOptions,
    /// Record the run in this file: .csv, .npy, .npz or .parquet
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write the system with its FMUs as an SSP 1.0, without running it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["out", "input", "reports", "plot"])]
    export: Option<PathBuf>,
    #[command(flatten)]
    page: PageOptions,
}

const AFTER_HELP: &str = "\
Examples:
  piezoloop system loop.toml --input reference.csv -o run.csv
  piezoloop system loop.ssp --stop 2 --isolate -o run.parquet
  piezoloop system loop.ssp --input reference.csv --parameters loaded.ssv -o loaded.csv
  piezoloop system loop.toml --export loop.ssp

A system in TOML:
  name = \"closed loop\"
  step = 1e-4                            # communication step in s
  algorithm = \"gauss-seidel\"             # or jacobi, jacobi-extrapolated (linear
                                         # inputs), iteration (loops are solved)
  order = [\"controller\", \"plant\"]        # of gauss-seidel; else sources before targets

  [fmus]
  plant = \"plant.fmu\"
  controller = { file = \"controller.fmu\", step = 1e-3, start = { \"k\" = 2.0 } }

  [connections]                          # input = output
  \"plant.command[1]\" = \"controller.command[1]\"
  \"controller.measured[1]\" = { from = \"plant.position[1]\", factor = 1e-6, convert = false }

  [inputs]                               # input = column of the input table
  \"controller.reference[1]\" = \"reference[1]\"

  [record]                               # column of the record = variable
  position = \"plant.position[1]\"";

/// Who steps when.
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
enum Algorithm {
    /// One after the other, sources before targets
    GaussSeidel,
    /// All side by side: every connection delays by one step
    Jacobi,
    /// As jacobi, with linear extrapolation of inputs where the FMUs support it
    JacobiExtrapolated,
    /// Algebraic loops are solved, with rollback of the FMUs' states
    Iteration,
}

/// What was written.
#[derive(Serialize)]
struct Exported {
    system: String,
    fmus: Vec<String>,
    ssp: PathBuf,
}

impl System {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let mut plan = Plan::read(&self.file)?;
        for set in &self.parameters {
            plan.set(set)?;
        }
        match self.algorithm {
            Some(Algorithm::GaussSeidel) => plan.master.coupling = Coupling::GaussSeidel,
            Some(Algorithm::JacobiExtrapolated) => plan.master.coupling = Coupling::Extrapolation,
            Some(Algorithm::Jacobi) => plan.master.coupling = Coupling::Jacobi,
            Some(Algorithm::Iteration) => plan.master.coupling = Coupling::Iteration,
            None => {}
        }
        if let Some(ssp) = &self.export {
            return screen.show(&self.export(&plan, ssp)?);
        }
        let read: Vec<&Path> = self.input.iter().map(PathBuf::as_path).collect();
        self.page.can_write()?;
        let result = self.simulate(&plan, screen)?;
        let file = |what, file| (what, file);
        let files: Vec<(&str, &Path)> = std::iter::once(file("system", self.file.as_path()))
            .filter(|(_, path)| path.is_file())
            .chain(read.iter().map(|path| ("log", *path)))
            .collect();
        self.page.finish(screen, &result, || pages::system(&result, &files))
    }

    /// A system to be run again and again, by somebody else.
    pub(crate) fn of(
        file: PathBuf,
        step: Option<f64>,
        stop: Option<f64>,
        options: LogOptions,
    ) -> Self {
        System {
            file,
            input: None,
            parameters: Vec::new(),
            step,
            stop,
            algorithm: None,
            isolation: Isolation::default(),
            messages: MessageOptions::default(),
            no_stop_time: false,
            pace: None,
            options,
            out: None,
            export: None,
            page: PageOptions::default(),
        }
    }

    fn export(&self, plan: &Plan, ssp: &Path) -> anyhow::Result<Exported> {
        cli::can_write_as(ssp, inputs::SYSTEM)?;
        let packages = plan
            .fmus
            .iter()
            .map(|fmu| modeldescription::Package::open(&fmu.path))
            .collect::<Result<Vec<_>, _>>()?;
        let descriptions: Vec<&ModelDescription> =
            packages.iter().map(modeldescription::Package::description).collect();
        plan.export_ssp(ssp, &descriptions)?;
        let fmus = plan.fmus.iter().map(|fmu| fmu.name.clone()).collect();
        Ok(Exported { system: plan.name.clone(), fmus, ssp: ssp.to_path_buf() })
    }

    fn simulate(&self, plan: &Plan, screen: &Screen) -> anyhow::Result<Ran> {
        if let Some(out) = &self.out {
            cli::can_write(out)?;
        }
        let fmus = self.open(plan)?;
        let descriptions: Vec<&ModelDescription> =
            fmus.iter().map(|fmu| fmu.description()).collect();
        let log = self.input.as_deref().map(|path| self.options.read(path)).transpose()?;
        self.out.as_deref().map_or(Ok(()), records::can_keep_beside)?;
        let (columns, names) = (plan.columns(), self.options.names()?);
        if log.is_none() && !columns.is_empty() {
            bail!(
                "the system has the inputs {}; give a table with these columns by --input FILE",
                columns.join(", ")
            );
        }
        let (points, step) = self.points(plan, &descriptions, log.as_ref())?;
        let table = self.table(plan, log.as_ref())?;
        let units = simulate::units(&table);
        let ear = self.messages.ear()?;
        let slaves = plan
            .fmus
            .iter()
            .zip(&fmus)
            .map(|(planned, fmu)| fmu.instantiate(&planned.name, &ear.options(&planned.name)))
            .collect::<Result<Vec<_>, _>>()?;
        let prepared = plan.prepare(slaves, step, &units);
        let mut prepared = prepared.map_err(|error| {
            // Where all is told of with the plan's file, that is not said once more.
            let file = self.file.display().to_string();
            let names_the_file = error.to_string().lines().all(|line| line.starts_with(&file));
            let error = anyhow::Error::from(error);
            if names_the_file { error } else { error.context(file) }
        })?;
        let rows = points.steps() + 1;
        let (start_s, stop_s) = (points.start(), points.stop());
        let mut recorder = Recording {
            file: match self.out.as_deref() {
                Some(out) => Some((RecordFile::create(out)?, out)),
                None => None,
            },
            columns: Vec::new(),
            notes: Vec::new(),
            bar: progress::Rows::new(screen, "run", rows),
            rows: 0,
            drawn: self.page.is_asked().then(Drawn::default),
        };
        let (no_stop_time, pace) = (self.no_stop_time, times::pace(self.pace)?);
        let run = Run { no_stop_time, pace, ..Run::new(points, &table) };
        let outcome = prepared.system.run(&run, &*prepared.algorithm, &mut recorder);
        recorder.bar.finish();
        let Recording { file, rows, columns, notes: of_names, drawn, .. } = recorder;
        if let Some((file, out)) = file {
            let written = file.finish().and_then(|()| records::renew(&columns, out));
            written.with_context(|| format!("{} cannot be written", out.display()))?;
        }
        let mut notes = prepared.notes;
        notes.extend(of_names);
        let unfed_inputs = prepared.unfed;
        if !unfed_inputs.is_empty() {
            let keep = if unfed_inputs.len() == 1 {
                "keeps its start value"
            } else {
                "keep their start values"
            };
            let list = simulate::list(&unfed_inputs);
            notes.push(format!("nothing feeds {list}, which {keep}"));
        }
        let is_used = |name: &str| {
            plan.columns().iter().any(|used| names.column(used).unwrap_or(used) == name)
        };
        let unused = log.iter().flat_map(Log::columns).map(|column| column.name.clone());
        let unused_columns: Vec<String> = unused.filter(|name| !is_used(name)).collect();
        if !unused_columns.is_empty() {
            let (s, feed) = if unused_columns.len() == 1 { ("", "feeds") } else { ("s", "feed") };
            notes.push(format!("the column{s} {} {feed} nothing", simulate::list(&unused_columns)));
        }
        notes.extend(prepared.system.unsolved().iter().map(|variables| {
            format!(
                "at the start {variables} depend on each other in a circle for which no values were \
                 found; the run begins with those of one pass through it"
            )
        }));
        let times = RunTimes::from(prepared.system.statistics());
        drop(prepared.system);
        notes.extend(ear.notes());
        notes.extend(times.note());
        let mut endings = Vec::new();
        match (outcome, &self.out) {
            (Err(error), Some(out)) if rows > 0 => {
                bail!("{error}; {}", simulate::until_then(rows, out))
            }
            (Err(error), _) => return Err(error.into()),
            (Ok(Some(Ending { slave, time })), _) => {
                endings.push(EarlyEnd { fmu: slave, record: 0, time_s: time });
                notes.extend(endings.iter().map(EarlyEnd::note));
            }
            (Ok(None), _) => {}
        }
        Ok(Ran {
            system: plan.name.clone(),
            fmus: plan.fmus.iter().map(|fmu| fmu.name.clone()).collect(),
            algorithm: plan.master.coupling.name(),
            step_s: step,
            rows,
            start_s,
            stop_s,
            run: self.out.clone(),
            endings,
            unused_columns,
            unfed_inputs,
            messages: ear.received(),
            times,
            notes,
            drawn: drawn.unwrap_or_default(),
        })
    }

    /// The FMUs, each file opened once for all its components; one that allows a single instance per
    /// process is unpacked for each, so that each has a library of its own.
    fn open(&self, plan: &Plan) -> anyhow::Result<Vec<Rc<Fmu>>> {
        if self.isolation.isolate && plan.master.coupling == Coupling::Extrapolation {
            bail!("jacobi-extrapolated runs FMUs in this process only; leave out --isolate");
        }
        let worker = self.isolation.worker()?;
        let mut opened: HashMap<PathBuf, Rc<Fmu>> = HashMap::new();
        let mut open = |path: &Path| -> anyhow::Result<Rc<Fmu>> {
            let file = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
            if let Some(fmu) = opened.get(&file) {
                return Ok(Rc::clone(fmu));
            }
            let fmu = Rc::new(fmus::open_in(path, worker.as_ref())?.fmu);
            let interface = fmu.description().co_simulation.as_ref();
            let is_single =
                interface.is_some_and(|cs| cs.common.can_be_instantiated_only_once_per_process);
            if !is_single {
                opened.insert(file, Rc::clone(&fmu));
            }
            Ok(fmu)
        };
        let configured = |fmu: Rc<Fmu>, name: &str| -> anyhow::Result<Rc<Fmu>> {
            let structure = plan.structure(name, fmu.description())?;
            if structure.is_empty() {
                return Ok(fmu);
            }
            let mut own = Fmu::clone(&fmu);
            own.configure(&structure)?;
            Ok(Rc::new(own))
        };
        let placed = |fmu: &PlannedFmu| {
            let opened = open(&fmu.path).with_context(|| fmu.place.clone())?;
            configured(opened, &fmu.name)
        };
        plan.fmus.iter().map(placed).collect()
    }

    /// The communication points, and the step that FMUs' own steps are multiples of.
    pub(crate) fn points(
        &self,
        plan: &Plan,
        descriptions: &[&ModelDescription],
        log: Option<&Log>,
    ) -> anyhow::Result<(Points<'static>, f64)> {
        let time = log.map(Log::time).unwrap_or_default();
        let rows = time.windows(2).map(|pair| pair[1] - pair[0]).reduce(f64::min);
        let own = plan.step(descriptions);
        let found = match (plan.master.step, own, rows) {
            (Some(stated), _, _) => Some(stated),
            // A table on the FMUs' own grid, but for rounding, is that grid.
            (_, Some(own), Some(rows)) if (rows - own).abs() <= 1e-6 * own => Some(own),
            (_, Some(own), Some(rows)) => Some(own.min(rows)),
            (_, own, rows) => own.or(rows),
        };
        let Some(step) = self.step.or(found) else {
            bail!(
                "the communication step is not known: neither the system nor its FMUs say one; give it with --step S"
            )
        };
        let start = plan.master.start.or(time.first().copied()).unwrap_or(0.0);
        let preferred = |description: &&ModelDescription| {
            description.default_experiment.as_ref().and_then(|experiment| experiment.stop_time)
        };
        let longest = descriptions.iter().filter_map(preferred).reduce(f64::max);
        let stop = self.stop.or(plan.master.stop).or(time.last().copied()).or(longest);
        let Some(stop) = stop else {
            bail!("the end of the run is not known: give it with --stop S");
        };
        // The table says how long the run is.
        if let (None, None, Some(log)) = (self.stop, plan.master.stop, log) {
            simulate::can_be_seconds(log, own.map_or(step, |own| own.min(step)))?;
        }
        Ok((Points::uniform(start, stop, step)?, step))
    }

    /// The input table, its columns under the names that the system knows.
    pub(crate) fn table<'l>(
        &self,
        plan: &Plan,
        log: Option<&'l Log>,
    ) -> anyhow::Result<Signals<'l>> {
        let Some(log) = log else { return Ok(Signals::default()) };
        let [_] = log.records() else {
            bail!(
                "{}: an input table has one record, this file has {}; give them one by one",
                log.origin(),
                log.records().len()
            );
        };
        let names = self.options.names()?;
        let mut columns = Vec::new();
        for name in plan.columns() {
            let column = log.require(names.column(name).unwrap_or(name))?;
            columns.push(Signal {
                name: name.to_owned(),
                unit: column.unit.as_ref().map(|unit| fmus::fmi_unit(&unit.text, &unit.unit)),
                values: &column.values,
            });
        }
        Ok(Signals { time: log.time(), columns })
    }
}

impl Answer for Exported {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{}: {}", self.system, self.fmus.join(", "))?;
        writeln!(out, "{}: written", self.ssp.display())
    }
}
