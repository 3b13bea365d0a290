//! `piezoloop simulate`: an FMU driven by a log, or a closed loop of two.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use cli::{PageOptions, Screen};
use cosim::{Coupling, Drive, Driven, Ending, Fmu, Loop, LoopSettings, Memory, Run};
use cosim::{Slave, Value, Wiring};
use data::Log;

use crate::fmus::{self, Addresses, Isolation};
use crate::inputs::{self, LogOptions, Readings};
use crate::messages::{FmuMessage, MessageOptions};
use crate::results::simulate::{EarlyEnd, OutputFit, Simulated};
use crate::times::RunTimes;
use crate::window::Window;
use crate::{pages, progress, records};

mod matched;
mod starts;
mod tables;

use matched::Matched;
pub(crate) use matched::list;
pub(crate) use starts::{configure, starts};
pub(crate) use tables::{can_be_seconds, points, signals, units};

/// Simulates an FMU with the inputs of a log, or the closed loop of a plant and a controller
///
/// Takes co-simulation FMUs of any vendor; a blueprint (.toml) or the name of a rig is packed first. If the log has a
/// column for an output, the fit is printed.
#[derive(Args, Debug)]
#[command(
    after_help = "Examples:\n  piezoloop simulate plant.fmu --log test_ff.csv --map u=u1 -o run.csv\n  piezoloop simulate plant.fmu --log test_ff.csv --map u=u1 --rows 5051..6050\n  piezoloop simulate --loop plant.fmu controller.fmu --reference ref.csv -o run.csv"
)]
pub(crate) struct Simulate {
    /// The FMU; with --loop the plant and the controller
    #[arg(required = true, num_args = 1..=2, value_name = "FMU")]
    fmus: Vec<PathBuf>,
    /// Close the loop of a plant and a controller
    #[arg(long = "loop", requires = "reference")]
    closed: bool,
    /// The log with the inputs of the FMU
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with = "closed",
        required_unless_present_any = ["closed", "reference"]
    )]
    log: Option<PathBuf>,
    /// The references of the loop, a log with the columns reference[i] (or named by --map)
    #[arg(long, value_name = "FILE", requires = "closed")]
    reference: Option<PathBuf>,
    /// Order of the steps in a loop
    #[arg(long, value_name = "ORDER", default_value = "controller-first", conflicts_with = "log")]
    coupling: Order,
    /// Communication step of the loop in s [default: the smaller of the reference's sample time and
    /// the controller's step]
    #[arg(long, value_name = "S", conflicts_with = "log", value_parser = crate::ranges::above(0.0, crate::ranges::LONGEST))]
    step: Option<f64>,
    /// A start value or parameter, as in axis[1].mechanics.damping=0.05; in a loop plant.NAME or controller.NAME (may
    /// be given several times)
    #[arg(long = "start", value_name = "NAME=VALUE")]
    starts: Vec<String>,
    #[command(flatten)]
    options: LogOptions,
    #[command(flatten)]
    readings: Readings,
    #[command(flatten)]
    window: Window,
    #[command(flatten)]
    isolation: Isolation,
    #[command(flatten)]
    messages: MessageOptions,
    /// A variable to record (may be given several times) [default: driven inputs and all outputs]
    #[arg(long = "record", value_name = "NAME", conflicts_with = "closed")]
    record: Vec<String>,
    /// Initialise the FMU without a stop time, for FMUs that refuse to step up to it
    #[arg(long)]
    no_stop_time: bool,
    /// Record the run in this file: .npy, .npz, .parquet, or otherwise CSV
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    page: PageOptions,
}

/// Who steps when in a loop.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// Gauss-Seidel: the command acts on the plant at once
    ControllerFirst,
    /// Jacobi: the command acts one step later
    SideBySide,
}

/// What belongs to a result beside its signals.
#[derive(Default)]
struct About {
    endings: Vec<EarlyEnd>,
    matched: Matched,
    messages: Vec<FmuMessage>,
    times: RunTimes,
    notes: Vec<String>,
}

impl Simulate {
    pub(crate) fn run(self, screen: &Screen) -> anyhow::Result<u8> {
        let read: Vec<(&str, &Path)> = self.files();
        self.page.can_write()?;
        let result = self.execute(screen)?;
        self.page.finish(screen, &result, || pages::simulation(&result, &read))
    }

    /// The files that are read; a rig is none.
    fn files(&self) -> Vec<(&str, &Path)> {
        let models = self.fmus.iter().map(|file| ("model", file.as_path()));
        let logs = self.log.iter().chain(&self.reference).map(|file| ("log", file.as_path()));
        models.chain(logs).filter(|(_, file)| file.exists()).collect()
    }

    /// Simulates, and writes the run.
    pub(crate) fn execute(&self, screen: &Screen) -> anyhow::Result<Simulated> {
        let result = match (self.closed, &self.fmus[..], &self.log, &self.reference) {
            (true, [plant, controller], _, Some(reference)) => {
                self.close_loop(plant, controller, reference)?
            }
            (true, _, _, _) => bail!(
                "--loop takes two FMUs, the plant and the controller, and --reference; one FMU was given"
            ),
            (false, [fmu], Some(log), _) => self.drive(fmu, log, screen)?,
            (false, _, _, _) => bail!("two FMUs make a loop: add --loop and --reference FILE"),
        };
        Ok(result)
    }

    fn drive(&self, what: &Path, log_path: &Path, screen: &Screen) -> anyhow::Result<Simulated> {
        if let Some(out) = &self.out {
            cli::can_write_as(out, inputs::RUN)?;
        }
        let mut opened = fmus::open_in(what, self.isolation.worker()?.as_ref())?;
        configure(self.starts.iter().map(String::as_str), &mut opened.fmu)?;
        let log = self.options.read(log_path)?;
        self.out.as_deref().map_or(Ok(()), records::can_keep_beside)?;
        let names = self.options.names()?;
        let addresses = Addresses::of(&opened.fmu);
        addresses.check(&names)?;
        let map = addresses.columns(&names, &log)?;
        let matched = Matched::of(&opened.fmu, &addresses, &names, &map, &log)?;
        let log = self.readings.held_for(&opened.fmu, &map, log);
        let records = signals(&log);
        let drive = Drive {
            map,
            parameters: starts(self.starts.iter().map(String::as_str), &addresses, &opened.fmu)?,
            record: self.record.iter().map(|name| addresses.variable(name)).collect(),
            no_stop_time: self.no_stop_time,
            ..Drive::default()
        };
        let unrecorded = if self.record.is_empty() {
            cosim::unrecorded(&opened.name, opened.fmu.description())
        } else {
            None
        };
        let ear = self.messages.ear()?;
        let slave = opened.fmu.instantiate(opened.name.clone(), &ear.options(&opened.name))?;
        let mut memory = Memory::new();
        let mut bar = progress::Rows::new(screen, "simulate", log.len());
        let mut driven = Driven::new(slave, &records, &drive)?;
        let outcome = driven.run(&mut (&mut memory, &mut bar));
        let times = RunTimes::from(driven.statistics());
        drop(driven);
        bar.finish();
        if let (Err(error), Some(out)) = (&outcome, &self.out) {
            return Err(broken_off(error, &memory, out)?);
        }
        let endings: Vec<EarlyEnd> = (0..).zip(outcome?).filter_map(early_end).collect();
        let mut notes: Vec<String> = endings.iter().map(EarlyEnd::note).collect();
        notes.extend(matched.notes());
        notes.extend(unrecorded);
        notes.extend(ear.notes());
        let (fits, measured) = self.fits(&memory, &log, &names, &addresses, &mut notes)?;
        let about = About { endings, matched, messages: ear.received(), times, notes };
        self.result(opened.name, memory, fits, measured, about)
    }

    /// The fit of each output that the log has a column for, record by record.
    #[allow(clippy::type_complexity)]
    fn fits(
        &self,
        memory: &Memory,
        log: &Log,
        names: &data::NameMap,
        addresses: &Addresses,
        notes: &mut Vec<String>,
    ) -> anyhow::Result<(Vec<OutputFit>, Vec<(String, Vec<f64>)>)> {
        let (mut fits, mut measured) = (Vec::new(), Vec::new());
        for series in memory.series() {
            let name = &series.column.name;
            let Some(column) = addresses.measured_column(name, names, log) else { continue };
            let unit = series.column.unit.clone().unwrap_or_default();
            let values = match unit.as_str() {
                "" => log.require(&column)?.values.clone(),
                unit => log.convert(&column, unit)?,
            };
            for (record, rows) in log.records().iter().zip(memory.records()) {
                let Some(window) = self.window.rows(log.time(), &record.rows) else {
                    notes.push(format!(
                        "record {} has no row in the window that is judged",
                        record.id
                    ));
                    continue;
                };
                let shift = rows.start as isize - record.rows.start as isize;
                let simulated = window.start.saturating_add_signed(shift)
                    ..window.end.saturating_add_signed(shift).min(rows.end);
                let (Some(y), Some(s)) = (values.get(window.clone()), series.values.get(simulated))
                else {
                    continue;
                };
                let y = &y[..s.len().min(y.len())];
                fits.push(OutputFit::new(name, &column, record.id, &unit, &window, y, s)?);
            }
            measured.push((name.clone(), values));
        }
        Ok((fits, measured))
    }

    fn close_loop(
        &self,
        plant: &Path,
        controller: &Path,
        reference: &Path,
    ) -> anyhow::Result<Simulated> {
        if let Some(out) = &self.out {
            cli::can_write_as(out, inputs::RUN)?;
        }
        let worker = self.isolation.worker()?;
        let open = |what: &Path| fmus::open_in(what, worker.as_ref());
        let (mut plant, mut controller) = (open(plant)?, open(controller)?);
        configure(self.starts_of("plant."), &mut plant.fmu)?;
        configure(self.starts_of("controller."), &mut controller.fmu)?;
        let log = self.options.read(reference)?;
        self.out.as_deref().map_or(Ok(()), records::can_keep_beside)?;
        let [_] = log.records() else {
            bail!(
                "{}: a reference has one record, this file has {}; give them one by one",
                log.origin(),
                log.records().len()
            );
        };
        let points = points(&log, &controller.fmu, self.step, None)?;
        let addresses = Addresses::of(&controller.fmu);
        let columns = addresses.columns(&self.options.names()?, &log)?;
        let ear = self.messages.ear()?;
        let (c, p) = (
            controller.fmu.instantiate("controller", &ear.options("controller"))?,
            plant.fmu.instantiate("plant", &ear.options("plant"))?,
        );
        let wiring = wiring(&*c, &*p, &columns)?;
        let pairs = wiring.clone();
        let table = signals(&log).into_iter().next().context("the reference has no rows")?;
        let reference_units = units(&table);
        let settings = LoopSettings {
            wiring,
            coupling: match self.coupling {
                Order::ControllerFirst => Coupling::ControllerFirst,
                Order::SideBySide => Coupling::SideBySide,
            },
            reference_units,
            parameters: self.loop_parameters(&plant.fmu, &controller.fmu)?,
            record: Vec::new(),
        };
        let mut closed = Loop::new(c, p, &settings)?;
        let mut memory = Memory::new();
        let run = Run { no_stop_time: self.no_stop_time, ..Run::new(points, &table) };
        let outcome = closed.run(&run, &mut memory);
        let times = RunTimes::from(closed.system().statistics());
        drop(closed);
        if let (Err(error), Some(out)) = (&outcome, &self.out) {
            return Err(broken_off(error, &memory, out)?);
        }
        let endings: Vec<EarlyEnd> = [(0, outcome?)].into_iter().filter_map(early_end).collect();
        let fits = self.tracking(&memory, &pairs)?;
        let mut notes = slow_plant(&plant.fmu, &controller.fmu);
        let both = [("controller", &controller.fmu), ("plant", &plant.fmu)];
        notes.extend(
            both.iter().filter_map(|(name, fmu)| cosim::unrecorded(name, fmu.description())),
        );
        notes.extend(endings.iter().map(EarlyEnd::note));
        notes.extend(ear.notes());
        let name = format!("{} with {}", plant.name, controller.name);
        let messages = ear.received();
        let about = About { endings, messages, times, notes, ..About::default() };
        self.result(name, memory, fits, Vec::new(), about)
    }

    /// Position against reference, axis by axis.
    fn tracking(&self, memory: &Memory, wiring: &Wiring) -> anyhow::Result<Vec<OutputFit>> {
        let mut fits = Vec::new();
        let all = 0..memory.time().len();
        let Some(window) = self.window.rows(memory.time(), &all) else {
            bail!(
                "the window that is judged has no row of the run; choose another --rows or --drop"
            );
        };
        for ((position, _), (_, reference)) in wiring.measurements.iter().zip(&wiring.references) {
            let (Some(y), Some(r)) = (memory.values(position), memory.values(reference)) else {
                continue;
            };
            let unit = memory
                .series()
                .iter()
                .find(|s| &s.column.name == position)
                .and_then(|s| s.column.unit.clone())
                .unwrap_or_default();
            let (r, y) = (&r[window.clone()], &y[window.clone()]);
            fits.push(OutputFit::new(position, reference, 0, &unit, &window, r, y)?);
        }
        Ok(fits)
    }

    /// The start values of the FMU of a loop that has this prefix.
    fn starts_of<'s>(&'s self, prefix: &'s str) -> impl Iterator<Item = &'s str> {
        self.starts.iter().filter_map(move |text| text.strip_prefix(prefix))
    }

    fn loop_parameters(
        &self,
        plant: &Fmu,
        controller: &Fmu,
    ) -> anyhow::Result<Vec<(String, String, Value)>> {
        for text in &self.starts {
            if !text.starts_with("plant.") && !text.starts_with("controller.") {
                bail!("--start {text}: in a loop write plant.NAME=VALUE or controller.NAME=VALUE");
            }
        }
        let mut all = Vec::new();
        for (slave, prefix, fmu) in
            [("plant", "plant.", plant), ("controller", "controller.", controller)]
        {
            let found = starts(self.starts_of(prefix), &Addresses::of(fmu), fmu)?;
            all.extend(found.into_iter().map(|(name, value)| (slave.to_owned(), name, value)));
        }
        Ok(all)
    }

    fn result(
        &self,
        model: String,
        memory: Memory,
        fits: Vec<OutputFit>,
        measured: Vec<(String, Vec<f64>)>,
        about: About,
    ) -> anyhow::Result<Simulated> {
        let About { endings, matched, messages, times, mut notes } = about;
        if let Some(out) = &self.out {
            notes.extend(records::keep(&memory, out)?);
        }
        let time = memory.time();
        Ok(Simulated {
            model,
            records: memory.records().len(),
            rows: time.len(),
            start_s: time.first().copied().unwrap_or(0.0),
            stop_s: time.last().copied().unwrap_or(0.0),
            fits,
            run: self.out.clone(),
            endings,
            unused_columns: matched.unused_columns,
            unfed_inputs: matched.unfed_inputs,
            messages,
            times,
            notes,
            signals: memory,
            measured,
        })
    }
}

/// Which variables of controller and plant belong together; `columns` says which column of the
/// reference feeds which input.
pub(crate) fn wiring(
    controller: &dyn Slave,
    plant: &dyn Slave,
    columns: &[(String, String)],
) -> anyhow::Result<Wiring> {
    let referred: Vec<&str> = columns.iter().map(|(variable, _)| variable.as_str()).collect();
    let mut wiring = Wiring::by_name(controller, plant, &referred)?;
    for (column, variable) in &mut wiring.references {
        if let Some((_, real)) = columns.iter().find(|(v, _)| v == variable) {
            real.clone_into(column);
        }
    }
    Ok(wiring)
}

/// A note where the plant steps more slowly than the controller: it then answers late, and the loop
/// has a delay that the machine does not have.
fn slow_plant(plant: &Fmu, controller: &Fmu) -> Vec<String> {
    let step = |fmu: &Fmu| fmu.description().default_experiment.as_ref().and_then(|e| e.step_size);
    match (step(plant), step(controller)) {
        (Some(plant), Some(controller)) if plant > 1.000_001 * controller => vec![format!(
            "the plant's step, {plant} s, is longer than the controller's, {controller} s: it answers \
             late; pack it with --step {controller}"
        )],
        _ => Vec::new(),
    }
}

/// The error of a run that broke off; what was recorded until then is written.
fn broken_off(error: &cosim::Error, memory: &Memory, out: &Path) -> anyhow::Result<anyhow::Error> {
    let rows = memory.time().len();
    if rows == 0 {
        return Ok(anyhow::anyhow!("{error}"));
    }
    records::keep(memory, out)?;
    Ok(anyhow::anyhow!("{error}; {}", until_then(rows, out)))
}

/// Where the rows are that were recorded before a run broke off.
pub(super) fn until_then(rows: usize, out: &Path) -> String {
    let rows = match rows {
        1 => "the row until then is".to_owned(),
        rows => format!("the {rows} rows until then are"),
    };
    format!("{rows} in {}", out.display())
}

fn early_end((record, ending): (usize, Option<Ending>)) -> Option<EarlyEnd> {
    ending.map(|Ending { slave, time }| EarlyEnd { fmu: slave, record, time_s: time })
}
