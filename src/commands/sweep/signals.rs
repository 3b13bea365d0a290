//! Runs whose signals are measured: closed loops and systems of FMUs.

use std::path::PathBuf;

use anyhow::{Context, bail};
use cosim::plan::{Plan as SystemPlan, PlannedStart, Prepared};
use cosim::{
    Ending, Fmu, InstanceOptions, Loop, LoopSettings, Points, Port, Run, Signals, Slave,
    Transformations, Value,
};
use data::Log;
use modeldescription::ModelDescription;
use modeldescription::ssp::ParameterValue;
use modeldescription::variable::{Causality, DataType, Start};
use sweep::{
    Cell, ClosedLoop, Column, ColumnKind, Coupling, Design, Kind, Plan, Row, Scalar, SystemRun,
};
use sweep::{Target, Worker};

use super::figures::{self, Figure, Meter};
use super::materials::Stage;
use crate::commands::{simulate, system};
use crate::fmus::{self, Addresses};
use crate::inputs::LogOptions;

/// Closed loops or systems, ready to be set up on any thread.
pub(super) struct SignalRuns {
    stage: Stage,
    plan: Plan,
    parts: Vec<Part>,
    /// Keeps the FMUs of an SSP unpacked.
    _system: Option<SystemPlan>,
    log: Option<Log>,
    options: LogOptions,
    isolation: Option<cosim::Worker>,
}

/// An FMU of the loop or the system.
struct Part {
    name: String,
    path: PathBuf,
    addresses: Addresses,
}

/// One set of instances.
enum Set {
    Loop(Loop),
    System(Prepared),
}

/// A set of instances with the points of its runs and the figures that are taken.
struct Ready {
    set: Set,
    points: Points<'static>,
    figures: Vec<Figure>,
}

impl SignalRuns {
    /// What the plan needs, read.
    pub(super) fn new(
        stage: Stage,
        plan: Plan,
        isolation: Option<cosim::Worker>,
    ) -> anyhow::Result<Self> {
        let worker = isolation.as_ref();
        let mut system = None;
        let (fmus, input, map) = match &plan.kind {
            Kind::Loop(closed) => {
                let named = |name: &str| Ok((name.to_owned(), stage.file(&format!("{name}.fmu"))?));
                let fmus = ["controller", "plant"].into_iter().map(named);
                (fmus.collect::<anyhow::Result<Vec<_>>>()?, "reference.csv", &closed.map)
            }
            Kind::System(run) => {
                let planned = system.insert(system_plan(&stage, run)?);
                let fmus = planned.fmus.iter().map(|fmu| (fmu.name.clone(), fmu.path.clone()));
                (fmus.collect(), "input.csv", &run.map)
            }
            _ => bail!("this plan runs no FMUs itself"),
        };
        let part = |(name, path): (String, PathBuf)| -> anyhow::Result<Part> {
            let addresses = Addresses::of(&fmus::load(&path, worker)?);
            Ok(Part { name, path, addresses })
        };
        let parts = fmus.into_iter().map(part).collect::<anyhow::Result<_>>()?;
        let map = map.iter().map(|(variable, column)| format!("{variable}={column}")).collect();
        let options = LogOptions { map, ..LogOptions::default() };
        let log = stage.path(input).map(|path| options.read(&path)).transpose()?;
        Ok(SignalRuns { parts, _system: system, log, options, stage, plan, isolation })
    }

    /// What may vary: every parameter, as `fmu.name`, around its start value.
    pub(super) fn targets(&self) -> anyhow::Result<Vec<Target>> {
        let mut targets = Vec::new();
        for part in &self.parts {
            let prefix = format!("{}.", part.name);
            let fmu = fmus::load(&part.path, self.isolation.as_ref())?;
            targets.extend(parameters(&fmu, &prefix, self.starts())?);
        }
        Ok(targets)
    }

    fn starts(&self) -> &std::collections::BTreeMap<String, Scalar> {
        match &self.plan.kind {
            Kind::Loop(closed) => &closed.start,
            Kind::System(run) => &run.start,
            Kind::Identify(campaign) | Kind::Diagnose(campaign) => &campaign.start,
        }
    }

    /// The columns of the figures; sets everything up once, so that what is wrong is told at once.
    pub(super) fn columns(&self, design: &Design) -> anyhow::Result<Vec<Column>> {
        let ready = self.ready(design)?;
        if ready.figures.is_empty() {
            bail!(
                "{}: nothing is measured; add figures, as in\n  [measure]\n  largest = {{ column = \
                 \"position[1]\", take = \"peak\" }}",
                self.plan.origin.display()
            );
        }
        Ok(figures::columns(&ready.figures))
    }

    /// A worker for one thread.
    pub(super) fn hire<'r>(&'r self, design: &'r Design) -> anyhow::Result<SignalWorker<'r>> {
        let ready = self.ready(design)?;
        let results = ready.figures.len();
        let ports = design.variables().iter().map(|variable| self.port(&variable.target.name));
        let ports = ports.collect::<anyhow::Result<_>>()?;
        let table = self.table()?;
        Ok(SignalWorker { runs: self, design, ports, table, results, ready: Some(ready) })
    }

    /// The variable that `fmu.name` means; the longest name of an FMU counts.
    fn port(&self, text: &str) -> anyhow::Result<Port> {
        let candidates = self.parts.iter().filter_map(|part| {
            Some((part, text.strip_prefix(part.name.as_str())?.strip_prefix('.')?))
        });
        let found = candidates.max_by_key(|(part, _)| part.name.len());
        let (part, variable) = found.with_context(|| {
            let names: Vec<&str> = self.parts.iter().map(|part| part.name.as_str()).collect();
            let origin = self.plan.origin.display();
            format!(
                "{origin}: \"{text}\": write FMU.NAME with one of the FMUs {}",
                names.join(", ")
            )
        })?;
        Ok(Port::from((part.name.as_str(), part.addresses.variable(variable))))
    }

    /// Start values of all runs, then those of the first run for what varies: each run replaces them.
    fn start_values(&self, design: &Design) -> anyhow::Result<Vec<(Port, Value)>> {
        let mut values = Vec::new();
        for (name, value) in self.starts() {
            values.push((self.port(name)?, of_scalar(value)));
        }
        let first = design.point(0).map_err(anyhow::Error::msg)?;
        for (variable, cell) in design.variables().iter().zip(&first) {
            let value = value(cell).context("a value is missing")?;
            values.push((self.port(&variable.target.name)?, value));
        }
        Ok(values)
    }

    fn ready(&self, design: &Design) -> anyhow::Result<Ready> {
        let starts = self.start_values(design)?;
        let open = |part: &Part| -> anyhow::Result<(Fmu, Box<dyn Slave>)> {
            let fmu = fmus::load(&part.path, self.isolation.as_ref())?;
            let slave = fmu.instantiate(&part.name, &InstanceOptions::default())?;
            Ok((fmu, slave))
        };
        let opened = self.parts.iter().map(open).collect::<anyhow::Result<Vec<_>>>()?;
        match &self.plan.kind {
            Kind::Loop(closed) => self.ready_loop(closed, opened, starts),
            Kind::System(run) => self.ready_system(run, opened, starts),
            _ => bail!("this plan runs no FMUs itself"),
        }
    }

    fn ready_loop(
        &self,
        closed: &ClosedLoop,
        opened: Vec<(Fmu, Box<dyn Slave>)>,
        starts: Vec<(Port, Value)>,
    ) -> anyhow::Result<Ready> {
        let log = self.log.as_ref().context("the loop has no reference")?;
        let table = self.table()?;
        let mut opened = opened.into_iter();
        let (Some((controller, c)), Some((_, p)), Some(part)) =
            (opened.next(), opened.next(), self.parts.first())
        else {
            bail!("a loop has a controller and a plant");
        };
        let columns = part.addresses.columns(&self.options.names()?, log)?;
        let wiring = simulate::wiring(&*c, &*p, &columns)?;
        let axes: Vec<_> = (wiring.measurements.iter().zip(&wiring.references).enumerate())
            .map(|(axis, ((position, _), (_, reference)))| {
                let command = wiring.commands.get(axis).map(|(_, command)| command.clone());
                (position.clone(), reference.clone(), command)
            })
            .collect();
        let points = simulate::points(log, &controller, closed.step, closed.stop)?;
        let parameters = starts.into_iter().map(|(port, value)| (port.slave, port.variable, value));
        let settings = LoopSettings {
            wiring,
            coupling: match closed.coupling {
                Coupling::ControllerFirst => cosim::Coupling::ControllerFirst,
                Coupling::SideBySide => cosim::Coupling::SideBySide,
            },
            reference_units: simulate::units(&table),
            parameters: parameters.collect(),
            record: Vec::new(),
        };
        let mut closed = Loop::new(c, p, &settings)?;
        let recorded = closed.system().columns();
        let figures = match self.plan.measure.is_empty() {
            true => figures::of_loop(&axes, recorded),
            false => figures::of_plan(&self.plan, recorded)?,
        };
        Ok(Ready { set: Set::Loop(closed), points, figures })
    }

    fn ready_system(
        &self,
        run: &SystemRun,
        opened: Vec<(Fmu, Box<dyn Slave>)>,
        starts: Vec<(Port, Value)>,
    ) -> anyhow::Result<Ready> {
        let mut plan = system_plan(&self.stage, run)?;
        for (to, value) in starts {
            let place = format!("{}: {}.{}", self.plan.origin.display(), to.slave, to.variable);
            let (value, way) = (planned(value), Transformations::default());
            plan.starts.push(PlannedStart { to, value, way, place, optional: false });
        }
        let file = self.plan.origin.clone();
        let command = system::System::of(file, run.step, run.stop, self.options.clone());
        let descriptions: Vec<&ModelDescription> =
            opened.iter().map(|(fmu, _)| fmu.description()).collect();
        let (points, step) = command.points(&plan, &descriptions, self.log.as_ref())?;
        let table = self.table_of(&plan)?;
        let slaves = opened.into_iter().map(|(_, slave)| slave).collect();
        let prepared = plan.prepare(slaves, step, &simulate::units(&table))?;
        let figures = figures::of_plan(&self.plan, prepared.system.columns())?;
        Ok(Ready { set: Set::System(prepared), points, figures })
    }

    /// The input table of every run.
    fn table(&self) -> anyhow::Result<Signals<'_>> {
        match &self.plan.kind {
            Kind::System(run) => self.table_of(&system_plan(&self.stage, run)?),
            _ => {
                let log = self.log.as_ref().context("the loop has no reference")?;
                let [_] = log.records() else {
                    bail!("the reference of a loop has one record, not {}", log.records().len());
                };
                simulate::signals(log).into_iter().next().context("the reference has no rows")
            }
        }
    }

    fn table_of(&self, plan: &SystemPlan) -> anyhow::Result<Signals<'_>> {
        if self.log.is_none() && !plan.columns().is_empty() {
            bail!(
                "{}: the system has the inputs {}; give a table with these columns by input = \"FILE\"",
                self.plan.origin.display(),
                plan.columns().join(", ")
            );
        }
        let file = self.plan.origin.clone();
        let command = system::System::of(file, None, None, self.options.clone());
        command.table(plan, self.log.as_ref())
    }

    fn judged_from(&self) -> (f64, bool) {
        match &self.plan.kind {
            Kind::Loop(closed) => (closed.from, closed.new_instances),
            Kind::System(run) => (run.from, run.new_instances),
            _ => (0.0, false),
        }
    }
}

/// The system of a plan, its FMUs where the sweep has them.
fn system_plan(stage: &Stage, run: &SystemRun) -> anyhow::Result<SystemPlan> {
    let mut plan = match stage.path("system.ssp") {
        Some(ssp) => SystemPlan::read(ssp)?,
        None => {
            let mut plan = SystemPlan::read(stage.file("system.toml")?)?;
            for (at, fmu) in plan.fmus.iter_mut().enumerate() {
                fmu.path = stage.file(&format!("system.{at}.fmu"))?;
            }
            plan
        }
    };
    for at in 0..run.parameters.len() {
        plan.set(&stage.file(&format!("parameters.{at}.ssv"))?)?;
    }
    Ok(plan)
}

/// The parameters of an FMU as targets; the plan's start values go before those of the FMU.
pub(super) fn parameters(
    fmu: &Fmu,
    prefix: &str,
    starts: &std::collections::BTreeMap<String, Scalar>,
) -> anyhow::Result<Vec<Target>> {
    let description = fmu.description();
    let mut targets = Vec::new();
    for name in fmu.names(Causality::Parameter) {
        let variable = fmu.variable(&name)?;
        let kind = match variable.data_type {
            DataType::Float32 | DataType::Float64 => ColumnKind::Real,
            DataType::Boolean => ColumnKind::Truth,
            _ => ColumnKind::Integer,
        };
        let properties = description.properties(&variable);
        let bound = |number: Option<modeldescription::variable::Number>, other: f64| {
            number.map_or(other, modeldescription::variable::Number::as_f64)
        };
        let full = format!("{prefix}{name}");
        let own = match &variable.start {
            Some(Start::Float(values)) => values.first().copied(),
            _ => None,
        };
        let start = match starts.get(&full) {
            Some(Scalar::Real(value)) => Some(*value),
            Some(Scalar::Integer(value)) => Some(*value as f64),
            _ => own,
        };
        targets.push(Target {
            unit: properties.unit.clone(),
            start,
            min: bound(properties.min, f64::NEG_INFINITY),
            max: bound(properties.max, f64::INFINITY),
            ..Target::new(full, kind)
        });
    }
    Ok(targets)
}

fn of_scalar(value: &Scalar) -> Value {
    match value {
        Scalar::Truth(value) => Value::Boolean(*value),
        Scalar::Integer(value) => Value::Integer((*value).into()),
        Scalar::Real(value) => Value::Real(*value),
        Scalar::Text(text) => Value::Text(text.clone()),
    }
}

fn value(cell: &Cell) -> Option<Value> {
    Some(match cell {
        Cell::Missing => return None,
        Cell::Real(value) => Value::Real(*value),
        Cell::Integer(value) => Value::Integer((*value).into()),
        Cell::Truth(value) => Value::Boolean(*value),
        Cell::Text(text) => Value::Text(text.clone()),
    })
}

fn planned(value: Value) -> ParameterValue {
    match value {
        Value::Real(value) => ParameterValue::Real(vec![value]),
        Value::Integer(value) => match i64::try_from(value) {
            Ok(value) => ParameterValue::Integer(vec![value]),
            Err(_) => ParameterValue::Real(vec![value as f64]),
        },
        Value::Boolean(value) => ParameterValue::Boolean(vec![value]),
        Value::Text(text) => ParameterValue::Text(vec![text]),
    }
}

/// Instances of one thread. A run that fails costs them; the next one gets new ones.
pub(super) struct SignalWorker<'r> {
    runs: &'r SignalRuns,
    design: &'r Design,
    ports: Vec<Port>,
    table: Signals<'r>,
    /// Number of figures.
    results: usize,
    ready: Option<Ready>,
}

impl SignalWorker<'_> {
    fn attempt(&mut self, point: &[Cell], run: u64) -> anyhow::Result<Vec<Cell>> {
        let (from, anew) = self.runs.judged_from();
        let mut ready = match self.ready.take() {
            Some(ready) => ready,
            None => self.runs.ready(self.design)?,
        };
        let system = match &mut ready.set {
            Set::Loop(closed) => closed.system(),
            Set::System(prepared) => &mut prepared.system,
        };
        for (port, cell) in self.ports.iter().zip(point) {
            system.set_start(port, value(cell).context("a value is missing")?)?;
        }
        let mut meter = Meter::new(&ready.figures, from);
        let run = Run {
            record: usize::try_from(run).unwrap_or(usize::MAX),
            points: ready.points.clone(),
            signals: &self.table,
            tolerance: None,
            no_stop_time: false,
            pace: None,
        };
        let ending = match &mut ready.set {
            Set::Loop(closed) => closed.run(&run, &mut meter)?,
            Set::System(prepared) => prepared.system.run(&run, &*prepared.algorithm, &mut meter)?,
        };
        if let Some(Ending { slave, time }) = ending {
            bail!("FMU `{slave}` asked for the end of the run at {time} s");
        }
        let cells = meter.cells();
        self.ready = Some(ready).filter(|_| !anew);
        Ok(cells)
    }
}

impl Worker for SignalWorker<'_> {
    fn run(&mut self, run: u64) -> Row {
        let (design, results) = (self.design, self.results);
        super::row_of(design, results, run, |point| self.attempt(point, run))
    }
}
