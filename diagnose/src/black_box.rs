//! An FMU as one node of a chain.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cosim::{Experiment, Fmu, HOST, InstanceOptions, Message, RunError, Selection, Slave};
use cosim::{StepResult, Value};

use crate::chain::{Failed, Link};
use crate::data_set::RecordData;
use crate::error::Error;

/// An FMU with one input that the chain drives, others that a record drives, and one output.
#[derive(Clone)]
pub(crate) struct BlackBox {
    shared: Arc<Shared>,
    times: Arc<Times>,
    /// Parameters: name, value, and which coordinate moves it.
    pub(crate) parameters: Vec<(String, f64)>,
    /// Links to the chain's parameters; `index` counts `parameters`.
    pub(crate) links: Vec<Link>,
}

/// Times of the rows of each record, by the record's first row.
pub(crate) type Times = std::collections::BTreeMap<usize, Vec<f64>>;

struct Shared {
    fmu: Fmu,
    inputs: Vec<String>,
    output: String,
    /// From SI to the unit of the driven input, and from the output's unit to SI.
    units: (model::Unit, model::Unit),
    /// Instances that are not in use.
    idle: Mutex<Vec<Box<dyn Slave>>>,
    incidents: Arc<Mutex<Incidents>>,
}

/// After so many crashes and hangs the search is given up: each costs a process, a hang the whole
/// time that is allowed.
const MOST_LOST: usize = 8;

/// What the FMU did beside its answers.
#[derive(Default)]
struct Incidents {
    /// Simulations that failed, those that ended its process among them.
    failed: usize,
    lost: usize,
    /// The first failure.
    first: Option<String>,
    /// What it changed of the program that ran it.
    changes: BTreeSet<String>,
}

impl Shared {
    /// Name of the model, for messages.
    fn name(&self) -> &str {
        &self.fmu.description().model_name
    }
}

impl BlackBox {
    /// An FMU whose inputs are `inputs`, the driven one first.
    pub(crate) fn new(
        fmu: Fmu,
        inputs: Vec<String>,
        output: String,
        units: (model::Unit, model::Unit),
        times: Times,
    ) -> Self {
        let idle = Mutex::new(Vec::new());
        let incidents = Arc::default();
        let shared = Arc::new(Shared { fmu, inputs, output, units, idle, incidents });
        Self { shared, times: Arc::new(times), parameters: Vec::new(), links: Vec::new() }
    }

    /// The same for records with these times.
    pub(crate) fn over(&self, times: Times) -> Self {
        Self { times: Arc::new(times), ..self.clone() }
    }

    fn take(&self) -> Result<Box<dyn Slave>, cosim::Error> {
        let shared = &*self.shared;
        let idle = shared.idle.lock().ok().and_then(|mut idle| idle.pop());
        if let Some(mut slave) = idle {
            slave.reset()?;
            return Ok(slave);
        }
        let incidents = Arc::clone(&shared.incidents);
        let hear = move |message: &Message| {
            if message.category == HOST {
                incidents_of(&incidents).changes.insert(message.text.clone());
            }
        };
        let options =
            InstanceOptions { on_message: Some(Arc::new(hear)), ..InstanceOptions::default() };
        shared.fmu.instantiate(shared.name(), &options)
    }

    /// Runs a record; a failure of the FMU is a failed simulation, and remembered.
    pub(crate) fn run(
        &self,
        theta: &[f64],
        record: &RecordData,
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), Failed> {
        if incidents_of(&self.shared.incidents).lost >= MOST_LOST {
            return Err(Failed);
        }
        self.try_run(theta, record, x, out).map_err(|error| {
            let mut incidents = incidents_of(&self.shared.incidents);
            incidents.failed += 1;
            incidents.lost += usize::from(is_lost(&error));
            incidents.first.get_or_insert_with(|| error.to_string());
            Failed
        })
    }

    /// Refuses where the FMU crashed or hung too often to go on.
    pub(crate) fn is_alive(&self) -> Result<(), Error> {
        let incidents = incidents_of(&self.shared.incidents);
        if incidents.lost < MOST_LOST {
            return Ok(());
        }
        let first = incidents.first.as_deref().unwrap_or_default();
        Err(Error::Model {
            model: self.shared.name().to_owned(),
            message: format!(
                "the FMU ran over the logs as they are, but crashed or hung {} times with other \
                 inputs or parameters, the first time so: {first}; diagnose it without --tune, or ask \
                 its maker",
                incidents.lost
            ),
        })
    }

    /// The error with the first failure of the FMU beside it, where it failed.
    pub(crate) fn reason(&self, error: &Error) -> Option<Error> {
        let first = incidents_of(&self.shared.incidents).first.clone()?;
        let message = format!("{error}; with other inputs or parameters the FMU failed: {first}");
        Some(Error::Model { model: self.shared.name().to_owned(), message })
    }

    /// Failures and what it changed of this program, in sentences.
    pub(crate) fn incidents(&self) -> Vec<String> {
        let (name, incidents) = (self.shared.name(), incidents_of(&self.shared.incidents));
        let mut all: Vec<String> =
            incidents.changes.iter().map(|change| format!("FMU `{name}`: {change}")).collect();
        if let Some(first) = &incidents.first {
            all.push(format!(
                "the FMU failed {} times with other inputs or parameters, which were passed over; the \
                 first time: {first}",
                incidents.failed
            ));
        }
        all
    }

    /// Runs a record and says why it failed.
    pub(crate) fn try_run(
        &self,
        theta: &[f64],
        record: &RecordData,
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), Error> {
        let mut slave = self.take()?;
        let empty = Vec::new();
        let times = self.times.get(&record.rows.start).unwrap_or(&empty);
        let mut done = 0;
        match self.drive(&mut *slave, (theta, record, times), x, out, &mut done) {
            Ok(()) => {
                if let Ok(mut idle) = self.shared.idle.lock() {
                    idle.push(slave);
                }
                Ok(())
            }
            Err(cause) => {
                let time = times.get(done.saturating_sub(1)).copied().unwrap_or(0.0);
                let cause = RunError { record: 0, time, cause };
                Err(Error::Run {
                    record: record.name.clone(),
                    row: done,
                    rows: times.len(),
                    cause: Box::new(cause),
                })
            }
        }
    }

    /// The run itself; `done` counts the rows.
    fn drive(
        &self,
        slave: &mut dyn Slave,
        (theta, record, times): (&[f64], &RecordData, &[f64]),
        x: &[f64],
        out: &mut [f64],
        done: &mut usize,
    ) -> Result<(), cosim::Error> {
        let shared = &*self.shared;
        let names: Vec<&str> = shared.inputs.iter().map(String::as_str).collect();
        let inputs = Selection::of(slave.description(), &names)?;
        let output = Selection::of(slave.description(), &[&shared.output])?;
        let (Some(&start), stop) = (times.first(), times.last().copied()) else { return Ok(()) };
        let experiment = Experiment { start, stop, tolerance: None };
        slave.setup(&experiment)?;
        for (k, (name, value)) in self.parameters.iter().enumerate() {
            let shift: f64 = self
                .links
                .iter()
                .filter(|link| link.index == k)
                .map(|link| link.deviation * theta.get(link.parameter).copied().unwrap_or(0.0))
                .sum();
            slave.set_start(name, &Value::Real(value + shift))?;
        }
        let mut values = vec![0.0; names.len()];
        let mut fill = |row: usize, value: f64| {
            values[0] = shared.units.0.from_si(value);
            for (v, other) in values[1..].iter_mut().zip(&record.others) {
                *v = other.get(row).copied().unwrap_or(0.0);
            }
            values.clone()
        };
        let first = fill(0, x.first().copied().unwrap_or(0.0));
        slave.enter_initialization()?;
        slave.set(&inputs, &first)?;
        slave.exit_initialization()?;
        let mut y = [0.0];
        for (row, time) in times.iter().enumerate().take(out.len()) {
            slave.get(&output, &mut y)?;
            if !y[0].is_finite() {
                let (fmu, variable) = (shared.name().to_owned(), shared.output.clone());
                return Err(cosim::Error::NotFinite { fmu, variable, value: y[0] });
            }
            out[row] = shared.units.1.to_si(y[0]);
            *done = row + 1;
            let (Some(next), Some(&u)) = (times.get(row + 1), x.get(row + 1)) else { break };
            if row + 1 >= out.len() {
                break;
            }
            slave.set(&inputs, &fill(row, u))?;
            let step = next - time;
            if let StepResult::Discarded { reached, .. } = slave.step(*time, step)? {
                return Err(cosim::Error::Discarded {
                    fmu: shared.name().to_owned(),
                    step,
                    reached,
                });
            }
        }
        slave.terminate()
    }
}

fn incidents_of(incidents: &Mutex<Incidents>) -> MutexGuard<'_, Incidents> {
    incidents.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the FMU's process is gone.
fn is_lost(error: &Error) -> bool {
    matches!(error, Error::Run { cause, .. } if matches!(cause.cause, cosim::Error::Lost(_)))
}
