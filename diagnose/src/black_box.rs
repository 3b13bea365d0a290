//! An FMU as one node of a chain.

use std::sync::{Arc, Mutex};

use cosim::{Experiment, Fmu, InstanceOptions, Selection, Slave, Value};

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
        let shared = Arc::new(Shared { fmu, inputs, output, units, idle });
        Self { shared, times: Arc::new(times), parameters: Vec::new(), links: Vec::new() }
    }

    /// The same for records with these times.
    pub(crate) fn over(&self, times: Times) -> Self {
        Self { times: Arc::new(times), ..self.clone() }
    }

    fn take(&self) -> Result<Box<dyn Slave>, Error> {
        let idle = self.shared.idle.lock().ok().and_then(|mut idle| idle.pop());
        match idle {
            Some(mut slave) => {
                slave.reset()?;
                Ok(slave)
            }
            None => Ok(self.shared.fmu.instantiate("diagnosed", &InstanceOptions::default())?),
        }
    }

    /// Runs a record; a failure of the FMU is a failed simulation.
    pub(crate) fn run(
        &self,
        theta: &[f64],
        record: &RecordData,
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), Failed> {
        self.try_run(theta, record, x, out).map_err(|_| Failed)
    }

    /// Runs a record and says why it failed.
    pub(crate) fn try_run(
        &self,
        theta: &[f64],
        record: &RecordData,
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), Error> {
        let shared = &*self.shared;
        let mut slave = self.take()?;
        let empty = Vec::new();
        let times = self.times.get(&record.rows.start).unwrap_or(&empty);
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
            out[row] = shared.units.1.to_si(y[0]);
            let (Some(next), Some(&u)) = (times.get(row + 1), x.get(row + 1)) else { break };
            if row + 1 >= out.len() {
                break;
            }
            slave.set(&inputs, &fill(row, u))?;
            slave.step(*time, next - time)?;
        }
        slave.terminate()?;
        if let Ok(mut idle) = shared.idle.lock() {
            idle.push(slave);
        }
        Ok(())
    }
}
