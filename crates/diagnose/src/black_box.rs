//! An FMU as one node of a chain.

mod entry;
mod known;
mod plays;

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cosim::{Experiment, Fmu, HOST, InstanceOptions, Message, RunError, Selection, Slave};
use cosim::{StepResult, Value};
use modeldescription::ModelDescription;
use surround::Span;

pub(crate) use self::entry::Entry;
use self::entry::{ringing, small_step};
use self::known::Known;
use crate::data_set::RecordData;
use crate::error::{Error, Failed};
use crate::parameter::Link;
use crate::thresholds::base::Thresholds;

/// An FMU with one input that the chain drives, others that a record drives, and one output.
#[derive(Clone)]
pub(crate) struct BlackBox {
    shared: Arc<Shared>,
    times: Arc<Times>,
    /// The last runs over these records.
    known: Arc<Mutex<Known>>,
    /// Parameters that may be off.
    pub(crate) parameters: Vec<Own>,
    /// Links to the chain's parameters; `index` counts `parameters`.
    pub(crate) links: Vec<Link>,
}

/// A parameter of the FMU.
#[derive(Clone)]
pub(crate) struct Own {
    pub(crate) name: String,
    /// The value that it has where nobody sets it.
    pub(crate) start: f64,
    pub(crate) value: f64,
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

/// What the FMU did beside its answers.
#[derive(Default)]
struct Incidents {
    /// Simulations that failed, those that ended its process among them.
    failed: usize,
    lost: usize,
    /// Of those that failed, the ones that ran when they were repeated.
    ran_again: usize,
    /// The first failure.
    first: Option<String>,
    /// What the incidents changed of the program that ran it.
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
        let (times, known) = (Arc::new(times), Arc::default());
        Self { shared, times, known, parameters: Vec::new(), links: Vec::new() }
    }

    /// The FMU for records with these times.
    pub(crate) fn over(&self, times: Times) -> Self {
        Self { times: Arc::new(times), known: Arc::default(), ..self.clone() }
    }

    /// The FMU with one parameter moved by this much.
    pub(crate) fn with(&self, parameter: usize, shift: f64) -> Self {
        let mut moved = self.clone();
        if let Some(own) = moved.parameters.get_mut(parameter) {
            own.value += shift;
        }
        moved
    }

    /// Whether its own steps, as far as it states them, divide steps of this many seconds.
    pub(crate) fn divides(&self, step: f64) -> bool {
        let own = inner_step(self.shared.fmu.description());
        own.is_none_or(|own| {
            let count = step / own;
            count > 0.5 && (count - count.round()).abs() < Thresholds::UNIFORM_TIMES
        })
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

    /// Runs a record where this very run is not known: what stands behind an FMU changes far more often than what drives
    /// it.
    pub(crate) fn run(
        &self,
        theta: &[f64],
        record: &RecordData,
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), Failed> {
        let lock = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let values: Vec<f64> = (0..self.parameters.len()).map(|k| self.value(k, theta)).collect();
        if lock().recall(record.rows.start, &values, x, out) {
            return Ok(());
        }
        self.run_anew(theta, record, x, out)?;
        lock().keep(record.rows.start, values, x, out);
        Ok(())
    }

    /// The value of parameter number `k` at these coordinates.
    fn value(&self, k: usize, theta: &[f64]) -> f64 {
        let links = self.links.iter().filter(|link| link.index == k);
        let shift =
            |link: &Link| link.deviation * theta.get(link.parameter).copied().unwrap_or(0.0);
        self.parameters[k].value + links.map(shift).sum::<f64>()
    }

    /// Runs a record; a failure of the FMU is remembered, and a failed simulation where it happens
    /// again in a fresh instance. A crash or a hang, which costs a process, is not tried again.
    fn run_anew(
        &self,
        theta: &[f64],
        record: &RecordData,
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), Failed> {
        if incidents_of(&self.shared.incidents).lost >= Thresholds::MOST_LOST {
            return Err(Failed);
        }
        let Err(error) = self.try_run(theta, record, x, out) else { return Ok(()) };
        let lost = is_lost(&error);
        {
            let mut incidents = incidents_of(&self.shared.incidents);
            incidents.failed += 1;
            incidents.lost += usize::from(lost);
            incidents.first.get_or_insert_with(|| error.to_string());
        }
        if lost || self.try_run(theta, record, x, out).is_err() {
            return Err(Failed);
        }
        incidents_of(&self.shared.incidents).ran_again += 1;
        Ok(())
    }

    /// The answer to a small step of the driven input over the first rows of a record; none where the FMU fails, which
    /// is no incident.
    pub(crate) fn step_answer(&self, record: &RecordData, command: Span) -> Option<Vec<f64>> {
        let rows = self.times.get(&record.rows.start)?.len();
        let x = small_step(rows.min(Thresholds::ENTRY_ROWS), command);
        let mut answer = vec![0.0; x.len()];
        self.try_run(&vec![0.0; self.parameters.len()], record, &x, &mut answer).ok()?;
        Some(answer)
    }

    /// How the output is entered: the mode that it leaves through, where the answer to a small step of the driven
    /// input shows one and nothing else that moves.
    pub(crate) fn entry(&self, record: &RecordData, command: Span) -> Option<Entry> {
        let sample = self.sample(record)?;
        let rows = self.times.get(&record.rows.start)?.len().min(Thresholds::ENTRY_ROWS);
        if rows < 4 * Thresholds::ENTRY_BEFORE {
            return None;
        }
        let x = small_step(rows, command);
        ringing(&self.answer(record, &x)?, Thresholds::ENTRY_BEFORE, sample)
    }

    /// Sample time of the rows of a record in s, where they are even.
    fn sample(&self, record: &RecordData) -> Option<f64> {
        let times = self.times.get(&record.rows.start)?;
        let sample = (times.last()? - times.first()?) / (times.len() as f64 - 1.0);
        let uneven = |w: &[f64]| (w[1] - w[0] - sample).abs() > 1e-6 * sample;
        (!times.windows(2).any(uneven)).then_some(sample)
    }

    /// The answer to a course of the driven input over the first rows of a record, the others held.
    fn answer(&self, record: &RecordData, course: &[f64]) -> Option<Vec<f64>> {
        if course.len() > self.times.get(&record.rows.start)?.len() {
            return None;
        }
        let held = |row: &Vec<f64>| vec![row.first().copied().unwrap_or(0.0); course.len()];
        let others = record.others.iter().map(held).collect();
        let alone = RecordData { others, ..record.clone() };
        let mut answer = vec![0.0; course.len()];
        self.run_anew(&vec![0.0; self.parameters.len()], &alone, course, &mut answer).ok()?;
        Some(answer)
    }

    /// Refuses where the FMU crashed or hung too often to go on.
    pub(crate) fn is_alive(&self) -> Result<(), Error> {
        let incidents = incidents_of(&self.shared.incidents);
        if incidents.lost < Thresholds::MOST_LOST {
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
            let (failed, again) = (incidents.failed, incidents.ran_again);
            let after = match failed - again {
                0 => "but ran when that was repeated".to_owned(),
                left => format!("{again} of which ran when repeated and {left} were passed over"),
            };
            all.push(format!(
                "the FMU failed {failed} times with other inputs or parameters, {after}; the first \
                 time: {first}"
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
        for (k, own) in self.parameters.iter().enumerate() {
            let value = self.value(k, theta);
            if value.to_bits() != own.start.to_bits() {
                slave.set_start(&own.name, &Value::Real(value))?;
            }
        }
        let mut values = vec![0.0; names.len()];
        let fill = |values: &mut [f64], row: usize, value: f64| {
            let Some((driven, rest)) = values.split_first_mut() else { return };
            *driven = shared.units.0.from_si(value);
            for (v, other) in rest.iter_mut().zip(&record.others) {
                *v = other.get(row).copied().unwrap_or(0.0);
            }
        };
        fill(&mut values, 0, x.first().copied().unwrap_or(0.0));
        slave.enter_initialization()?;
        slave.set(&inputs, &values)?;
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
            fill(&mut values, row, u);
            slave.set(&inputs, &values)?;
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

/// The step in s that the FMU takes by itself, as far as it says.
pub(crate) fn inner_step(description: &ModelDescription) -> Option<f64> {
    let fixed = description.co_simulation.as_ref().and_then(|cs| cs.fixed_internal_step_size);
    fixed.or_else(|| description.default_experiment.as_ref().and_then(|e| e.step_size))
}

fn incidents_of(incidents: &Mutex<Incidents>) -> MutexGuard<'_, Incidents> {
    incidents.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the FMU's process is gone.
fn is_lost(error: &Error) -> bool {
    matches!(error, Error::Run { cause, .. } if matches!(cause.cause, cosim::Error::Lost(_)))
}
