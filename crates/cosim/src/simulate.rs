//! One FMU driven by a log.

use modeldescription::variable::Causality;

use crate::algorithm::Jacobi;
use crate::diagram::{Diagram, can_be_fed};
use crate::error::Error;
use crate::port::Port;
use crate::problem::{Problem, Problems};
use crate::record::Recorder;
use crate::run::Run;
use crate::signals::Signals;
use crate::slave::{Address, Slave, Value, numbers};
use crate::statistics::Statistics;
use crate::system::{Ending, System};
use crate::time::Points;

/// How a log drives an FMU.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// Variables and the columns that feed them, where names differ: `(variable, column)`.
    pub map: Vec<(String, String)>,
    /// Parameters and other start values.
    pub parameters: Vec<(String, Value)>,
    /// Variables to record; empty: all driven inputs and all numeric outputs.
    pub record: Vec<String>,
    /// Relative tolerance for FMUs with error control.
    pub tolerance: Option<f64>,
    /// Do not tell the FMU when a record ends.
    pub no_stop_time: bool,
}

/// Drives a slave with the rows of a log, record by record, and records it.
///
/// Row k: u_k acts from t_k until t_{k+1} (zero-order hold); outputs are read at t_k before u_k
/// acts. The communication points are the rows' times. A column feeds the input or tunable
/// parameter that `map` gives it, else the one of its own name; a column that fits nothing is
/// ignored, an input that no column feeds keeps its start value. Between records the FMU is reset
/// and gets its parameters anew.
///
/// On a uniform grid the result is that of
///
/// ```python
/// fmpy.simulate_fmu(fmu, start_time=t[0], stop_time=t[-1], output_interval=dt, input=table,
///                   start_values=parameters, output=outputs)
/// ```
///
/// (fmpy interpolates *continuous* inputs linearly: where its time differs from the row's by
/// rounding, so does its input, by slope times rounding error.)
///
/// Returns for each record the [`Ending`], if the FMU asked for an early end; the next record is
/// run nevertheless.
///
/// # Errors
/// All problems of names, units and tables before anything is run; then [`Error::Run`], which ends
/// the whole, with what was recorded kept by the recorder.
pub fn simulate_with_inputs(
    slave: Box<dyn Slave>,
    records: &[Signals<'_>],
    drive: &Drive,
    recorder: &mut dyn Recorder,
) -> Result<Vec<Option<Ending>>, Error> {
    Driven::new(slave, records, drive)?.run(recorder)
}

/// A slave with the rows that drive it, to be run again and again: see [`simulate_with_inputs`].
pub struct Driven<'a> {
    slave: String,
    system: System,
    runs: Vec<Run<'a>>,
}

impl Driven<'_> {
    /// Gives a parameter that the drive names another value for the runs that follow.
    ///
    /// # Errors
    /// The drive does not name it, or the value does not fit.
    pub fn set(&mut self, variable: &str, value: Value) -> Result<(), Error> {
        let port = Port::from((self.slave.as_str(), variable));
        self.system.set_start(&port, value).map_err(|problem| Problems::from(problem).into())
    }

    /// How long the steps of all runs so far took.
    pub fn statistics(&self) -> Statistics {
        self.system.statistics()
    }

    /// Runs all records.
    ///
    /// # Errors
    /// What the slave says, as [`Error::Run`].
    pub fn run(&mut self, recorder: &mut dyn Recorder) -> Result<Vec<Option<Ending>>, Error> {
        let Driven { system, runs, .. } = self;
        runs.iter().map(|run| system.run(run, &Jacobi, recorder)).collect()
    }
}

impl Driven<'_> {
    /// Runs one record, counted from 0; nothing where there is none.
    ///
    /// # Errors
    /// What the slave says, as [`Error::Run`].
    pub fn run_one(
        &mut self,
        record: usize,
        recorder: &mut dyn Recorder,
    ) -> Result<Option<Ending>, Error> {
        let Driven { system, runs, .. } = self;
        runs.get(record).map_or(Ok(None), |run| system.run(run, &Jacobi, recorder))
    }
}

impl<'a> Driven<'a> {
    /// Connects the slave to the columns.
    ///
    /// # Errors
    /// All problems of names, units and tables.
    pub fn new(
        slave: Box<dyn Slave>,
        records: &'a [Signals<'a>],
        drive: &Drive,
    ) -> Result<Self, Error> {
        let name = slave.name().to_owned();
        let system = connected(slave, records, drive)?;
        let tolerance = drive.tolerance;
        let runs = records.iter().enumerate().map(|(record, signals)| {
            let points = Points::rows(signals.time)
                .map_err(|problem| Problem::Table { record, what: problem.to_string() })?;
            let no_stop_time = drive.no_stop_time;
            Ok(Run { record, tolerance, no_stop_time, ..Run::new(points, signals) })
        });
        let runs = runs.collect::<Result<Vec<_>, Problem>>().map_err(Problems::from)?;
        Ok(Driven { slave: name, system, runs })
    }
}

/// The slave as a system whose columns are those of the records.
fn connected(
    slave: Box<dyn Slave>,
    records: &[Signals<'_>],
    drive: &Drive,
) -> Result<System, Error> {
    let columns = records.first().map(|first| first.columns.as_slice()).unwrap_or_default();
    let mut diagram = Diagram::new();
    let mut fed = Vec::new();
    for column in columns {
        for variable in targets(&*slave, drive, &column.name) {
            diagram.feed(&column.name, column.unit.clone(), port(&*slave, &variable));
            fed.push(variable);
        }
    }
    for (variable, value) in &drive.parameters {
        diagram.start(port(&*slave, variable), value.clone());
    }
    for variable in recorded(&*slave, drive, &fed) {
        diagram.record(port(&*slave, &variable));
    }
    check_map(&*slave, records, drive)?;
    diagram.add(slave);
    Ok(diagram.build()?)
}

fn port(slave: &dyn Slave, variable: &str) -> Port {
    Port::from((slave.name(), variable))
}

/// The variables that a column feeds: those the map gives it, else the one of its own name.
fn targets(slave: &dyn Slave, drive: &Drive, column: &str) -> Vec<String> {
    let mapped: Vec<String> = drive
        .map
        .iter()
        .filter(|(_, from)| from == column)
        .map(|(variable, _)| variable.clone())
        .collect();
    let is_mapped_elsewhere = drive.map.iter().any(|(variable, _)| variable == column);
    let description = slave.description();
    let own = Address::find(slave.name(), description, column).ok().map(|found| found.variable);
    let own = own.filter(|variable| can_be_fed(variable, description));
    match own {
        Some(variable) if mapped.is_empty() && !is_mapped_elsewhere => vec![variable.name],
        _ => mapped,
    }
}

fn recorded(slave: &dyn Slave, drive: &Drive, fed: &[String]) -> Vec<String> {
    if !drive.record.is_empty() {
        return drive.record.clone();
    }
    let description = slave.description();
    let outputs = description.variables.iter().filter(|v| v.causality == Causality::Output);
    fed.iter().cloned().chain(outputs.flat_map(|output| numbers(description, output))).collect()
}

/// Every column that the map names must exist.
fn check_map(slave: &dyn Slave, records: &[Signals<'_>], drive: &Drive) -> Result<(), Problems> {
    let Some(first) = records.first() else { return Ok(()) };
    let there: Vec<&str> = first.columns.iter().map(|column| column.name.as_str()).collect();
    let problems = drive
        .map
        .iter()
        .filter(|(_, column)| !there.contains(&column.as_str()))
        .map(|(variable, column)| Problem::NoSuchColumn {
            name: column.clone(),
            slave: slave.name().to_owned(),
            variable: variable.clone(),
            there: there.join(", "),
        })
        .collect();
    Problems::none_or(problems, ())
}
