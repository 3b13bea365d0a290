//! A plant and a controller in Rust, in the place of FMUs, and a bench made of them.
#![allow(dead_code, unreachable_pub)]

pub mod bad_line;
pub mod lockstep;

use bench::cycle::{Controller, Cycle, Driver, Player, Setup};
use bench::emulate::{Behaviour, Emulator, Plant, Script, Timing};
use bench::safety::{AxisLimits, Watch};
use bench::virtual_run::VirtualRun;
use cosim::{Error, Experiment, Selection, Slave, StepResult, Value};
use modeldescription::description::CoSimulation;
use modeldescription::variable::{Causality, DataType, Start, Variable};
use modeldescription::{FmiVersion, ModelDescription};

pub const PERIOD_NS: u64 = 1_000_000;
pub const PERIOD: f64 = 1e-3;

/// What a test slave does in a step: step number, inputs, state, outputs.
pub type Law = Box<dyn FnMut(u64, &[f64], &mut [f64], &mut [f64]) -> bool + Send>;

/// A slave that is a Rust function.
pub struct RustSlave {
    description: ModelDescription,
    inputs: usize,
    values: Vec<f64>,
    state: Vec<f64>,
    steps: u64,
    law: Law,
}

impl RustSlave {
    pub fn boxed(name: &str, inputs: &[String], outputs: &[String], law: Law) -> Box<dyn Slave> {
        let mut description = ModelDescription::new(FmiVersion::V2, name, name);
        description.co_simulation = Some(CoSimulation::new(name));
        let all = inputs.iter().map(|name| (name, Causality::Input));
        let all = all.chain(outputs.iter().map(|name| (name, Causality::Output)));
        for ((name, causality), reference) in all.zip(0..) {
            let mut variable = Variable::new(name.as_str(), reference, DataType::Float64);
            variable.causality = causality;
            variable.start = (causality == Causality::Input).then(|| Start::Float(vec![0.0]));
            description.variables.push(variable);
        }
        let values = vec![0.0; inputs.len() + outputs.len()];
        let state = vec![0.0; 3 * outputs.len()];
        Box::new(RustSlave { description, inputs: inputs.len(), values, state, steps: 0, law })
    }
}

impl Slave for RustSlave {
    fn name(&self) -> &str {
        &self.description.model_name
    }
    fn description(&self) -> &ModelDescription {
        &self.description
    }
    fn setup(&mut self, _: &Experiment) -> Result<(), Error> {
        Ok(())
    }
    fn enter_initialization(&mut self) -> Result<(), Error> {
        Ok(())
    }
    fn exit_initialization(&mut self) -> Result<(), Error> {
        Ok(())
    }
    fn set_start(&mut self, _: &str, _: &Value) -> Result<(), Error> {
        Ok(())
    }
    fn value(&mut self, _: &str) -> Result<Value, Error> {
        Ok(Value::Real(0.0))
    }
    fn set(&mut self, selection: &Selection, values: &[f64]) -> Result<(), Error> {
        let places = selection.references().iter().map(|reference| *reference as usize);
        places.zip(values).for_each(|(place, value)| self.values[place] = *value);
        Ok(())
    }
    fn get(&mut self, selection: &Selection, values: &mut [f64]) -> Result<(), Error> {
        let places = selection.references().iter().map(|reference| *reference as usize);
        places.zip(values).for_each(|(place, value)| *value = self.values[place]);
        Ok(())
    }
    fn step(&mut self, time: f64, _: f64) -> Result<StepResult, Error> {
        let (inputs, outputs) = self.values.split_at_mut(self.inputs);
        let good = (self.law)(self.steps, inputs, &mut self.state, outputs);
        self.steps += 1;
        Ok(match good {
            true => StepResult::Completed,
            false => StepResult::Discarded { reached: Some(time), terminated: false },
        })
    }
    fn terminate(&mut self) -> Result<(), Error> {
        Ok(())
    }
    fn reset(&mut self) -> Result<(), Error> {
        Ok(())
    }
}

pub fn names(word: &str, axes: usize) -> Vec<String> {
    (1..=axes).map(|axis| format!("{word}[{axis}]")).collect()
}

/// Each axis: a first-order lag of gain 0.1 um/V and 3 ms.
pub fn plant(axes: usize) -> Plant {
    let law: Law = Box::new(|_, u, state, y| {
        for ((x, u), y) in state.iter_mut().zip(u).zip(y) {
            *x += (0.1 * u - *x) * (PERIOD / 3e-3);
            // A sensor's last bits move.
            *x += 1e-9 * (*x * 1e7).sin();
            *y = *x;
        }
        true
    });
    let slave = RustSlave::boxed("plant", &names("command", axes), &names("position", axes), law);
    Plant::new(slave, &names("command", axes), &names("position", axes), &[], PERIOD).unwrap()
}

/// Each axis: feedforward and an integrator.
pub fn control_law(axes: usize) -> Law {
    Box::new(move |_, inputs, state, u| {
        let (r, y) = inputs.split_at(axes);
        for axis in 0..axes {
            state[axis] += 0.5 * (r[axis] - y[axis]);
            u[axis] = 10.0 * r[axis] + state[axis];
        }
        true
    })
}

pub fn controller(axes: usize, law: Law) -> Driver {
    let (r, y, u) = (names("reference", axes), names("measured", axes), names("command", axes));
    let inputs: Vec<String> = r.iter().chain(&y).cloned().collect();
    let slave = RustSlave::boxed("controller", &inputs, &u, law);
    Driver::Controller(Box::new(Controller::new(slave, &r, &y, &u, &[], PERIOD).unwrap()))
}

pub const WATCH: Watch =
    Watch { hold: 5, max_age: 3, tracking: 20, stuck: 15, saturated: 30, overrun: 8 };
pub const APPROACH: u32 = 50;
pub const ROWS: u32 = 1000;

pub fn limits() -> AxisLimits {
    AxisLimits {
        command: [-5.0, 105.0],
        command_rate: 5e3,
        position: [-1.0, 11.0],
        position_rate: 800.0,
        tracking_error: 0.8,
        safe: 0.0,
        safe_rate: 1000.0,
    }
}

/// Sines of 5 Hz between 2 and 8 um, shifted from axis to axis.
pub fn table(axes: usize) -> Vec<f64> {
    let value = |row: u32, axis: usize| {
        let phase = std::f64::consts::TAU * 5.0 * f64::from(row) * PERIOD + axis as f64;
        5.0 + 3.0 * phase.sin()
    };
    (0..ROWS).flat_map(|row| (0..axes).map(move |axis| value(row, axis))).collect()
}

pub fn cycle(axes: usize, driver: Driver) -> Cycle {
    cycle_with(axes, driver, limits())
}

pub fn cycle_with(axes: usize, driver: Driver, limits: AxisLimits) -> Cycle {
    Cycle::new(Setup {
        period_ns: PERIOD_NS,
        driver,
        player: Player::new(axes, table(axes), APPROACH),
        limits: vec![limits; axes],
        watch: WATCH,
        blend: 40,
        first_sequence: 77,
    })
}

pub fn emulator(axes: usize, script: Script) -> Emulator {
    let behaviour = Behaviour {
        timing: Timing::Clock,
        period_ns: PERIOD_NS,
        heartbeat: 20,
        safe: vec![0.0; axes],
    };
    Emulator::new(plant(axes), behaviour, script)
}

pub fn virtual_run(axes: usize, driver: Driver, script: Script) -> VirtualRun {
    VirtualRun::new(cycle(axes, driver), emulator(axes, script), PERIOD_NS)
}

/// A controller of an instrument with a servo: its commands are targets in um, the references
/// themselves.
pub fn targets(axes: usize) -> Law {
    Box::new(move |_, inputs, _, u| {
        u.copy_from_slice(&inputs[..axes]);
        true
    })
}

/// Limits of such targets.
pub fn target_limits() -> AxisLimits {
    AxisLimits {
        command: [-1.0, 11.0],
        command_rate: 800.0,
        tracking_error: f64::INFINITY,
        position_rate: f64::INFINITY,
        safe_rate: 100.0,
        ..limits()
    }
}
