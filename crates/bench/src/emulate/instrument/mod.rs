//! Instruments that laboratories have, with a piezo plant behind them: a digital servo, and the protocol
//! that clients of the real one speak.
//!
//! Open loop: the voltage acts on the plant. Closed loop: a PID law with notch filters (`servo.rs`) brings the position
//! to the target; as delivered it is a slow integrator u += K·(target − y)/g per step, g the plant's static gain.

mod gcs;
mod generator;
mod inputs;
mod nv200;
mod servo;

pub use gcs::GcsInstrument;
pub use inputs::Signals;
pub use nv200::Nv200Instrument;

use self::generator::{Generator, Recorder, Seen, Source};
use self::inputs::Inputs;
use self::servo::{Notch, Servo};
use crate::gateway::Instrument;
use crate::plant::{Plant, PlantError};

/// Share of the error that one step of the servo takes away from a plant without dynamics, at most, and its rate in 1/s:
/// slow enough for any stage.
const INTEGRAL: f64 = 0.03;
const INTEGRAL_RATE: f64 = 30.0;
/// Within this share of the travel an axis is on its target.
const ON_TARGET: f64 = 1e-3;
/// Steps in which the plant is led to each of its ends, steps in which it comes to rest there, and those in which it is read.
const REST: usize = 2000;

/// How far an axis goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Voltages.
    pub volts: [f64; 2],
    /// Positions at these.
    pub positions: [f64; 2],
}

impl Travel {
    pub(super) fn gain(&self) -> f64 {
        let gain = (self.positions[1] - self.positions[0]) / (self.volts[1] - self.volts[0]);
        if gain.is_finite() && gain != 0.0 { gain } else { 1.0 }
    }

    /// The least and the greatest position.
    pub(super) fn range(&self) -> [f64; 2] {
        let [a, b] = self.positions;
        [a.min(b), a.max(b)]
    }

    /// Whether a target is one, to the digits that are told.
    pub(super) fn reaches(&self, target: f64) -> bool {
        let [least, greatest] = self.range();
        (least - 1e-6..=greatest + 1e-6).contains(&target)
    }
}

/// Measures how far each axis of a plant goes between two voltages: it is used up.
///
/// The voltages are led there smoothly, and the positions averaged: a light mode would still ring after a jump.
///
/// # Errors
/// The plant failed.
pub fn travel(mut plant: Plant, volts: &[[f64; 2]]) -> Result<Vec<Travel>, PlantError> {
    let mut ends = [0, 1].map(|_| vec![0.0; plant.axes()]);
    let mut from = plant.commands()?;
    let mut read = vec![0.0; plant.axes()];
    for (end, positions) in ends.iter_mut().enumerate() {
        let to: Vec<f64> = volts.iter().map(|volts| volts[end]).collect();
        for k in 1..=3 * REST {
            let part = (k as f64 / REST as f64).min(1.0);
            let share = 0.5 - 0.5 * (core::f64::consts::PI * part).cos();
            let lead = from.iter().zip(&to).map(|(from, to)| from + share * (to - from));
            plant.step(&lead.collect::<Vec<_>>())?;
            if k > 2 * REST {
                plant.read(&mut read);
                positions.iter_mut().zip(&read).for_each(|(sum, y)| *sum += y / REST as f64);
            }
        }
        from = to;
    }
    let axis =
        |axis: usize| Travel { volts: volts[axis], positions: [ends[0][axis], ends[1][axis]] };
    Ok((0..volts.len()).map(axis).collect())
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Axis {
    pub(super) servo: bool,
    pub(super) target: f64,
    pub(super) volts: f64,
    pub(super) position: f64,
}

impl Axis {
    /// What a recorder sees of it.
    fn seen(&self, (_, what): Source) -> f64 {
        match what {
            Seen::Nothing => 0.0,
            Seen::Target if self.servo => self.target,
            Seen::Target | Seen::Voltage => self.volts,
            Seen::Position => self.position,
            Seen::Error => self.target - self.position,
            Seen::AbsoluteError => (self.target - self.position).abs(),
        }
    }
}

/// Plant and servo.
#[derive(Debug)]
pub(super) struct Stage {
    plant: Plant,
    pub(super) travel: Vec<Travel>,
    pub(super) axes: Vec<Axis>,
    pub(super) servos: Vec<Servo>,
    /// The laws after the next power-up.
    pub(super) saved: Vec<Servo>,
    /// One for each axis.
    pub(super) generators: Vec<Generator>,
    pub(super) recorder: Recorder,
    inputs: Inputs,
    steps: u64,
}

impl Stage {
    /// A plant at rest, servo off.
    pub(super) fn new(plant: Plant, travel: Vec<Travel>, recorder: Recorder) -> Self {
        let axes = vec![Axis::default(); plant.axes()];
        let integral = INTEGRAL.min(INTEGRAL_RATE * plant.period());
        let servos = vec![Servo::new(integral); axes.len()];
        let generators = vec![Generator::new(); axes.len()];
        let saved = servos.clone();
        let inputs = Inputs::new(&travel);
        let mut stage =
            Stage { plant, travel, axes, servos, saved, generators, recorder, inputs, steps: 0 };
        stage.look();
        stage
    }

    /// Length of a servo cycle in s.
    pub(super) fn period(&self) -> f64 {
        self.plant.period()
    }

    /// Voltages that act, axis by axis.
    pub(super) fn volts(&self) -> Vec<f64> {
        self.axes.iter().map(|axis| axis.volts).collect()
    }

    /// Targets and servo states, axis by axis.
    pub(super) fn targets(&self) -> Vec<(f64, bool)> {
        self.axes.iter().map(|axis| (axis.target, axis.servo)).collect()
    }

    /// One step of servo and plant.
    ///
    /// # Errors
    /// The plant failed.
    pub(super) fn step(&mut self) -> Result<(), PlantError> {
        let analog: Vec<Option<f64>> = (0..self.axes.len()).map(|n| self.analog(n)).collect();
        for (n, axis) in self.axes.iter_mut().enumerate() {
            let travel = &self.travel[n];
            let [low, high] = travel.volts;
            let volts = [low.min(high), high.max(low)];
            let wave = self.generators[n].next();
            if let Some(value) = analog[n].or(wave) {
                let [least, greatest] = if axis.servo { travel.range() } else { volts };
                let value = value.clamp(least, greatest);
                *(if axis.servo { &mut axis.target } else { &mut axis.volts }) = value;
            }
            if axis.servo {
                let error = axis.target - axis.position;
                axis.volts = self.servos[n].step(error, travel.gain(), volts);
            }
            axis.volts = axis.volts.clamp(volts[0], volts[1]);
        }
        // As an instrument does: the position that the law has seen, and what it made of it.
        let axes = &self.axes;
        self.recorder.take(|source| axes[source.0].seen(source));
        self.plant.step(&self.volts())?;
        self.steps += 1;
        self.look();
        Ok(())
    }

    /// An input signal, from 0: normalized to ±100, and scaled to a position.
    pub(super) fn input(&self, n: usize) -> [f64; 2] {
        let axes = self.axes.len();
        let axis = n % axes;
        let [least, greatest] = self.travel[axis].range();
        let position = self.axes[axis].position;
        let sensor = 200.0 * (position - least) / (greatest - least).max(1e-300) - 100.0;
        let Some(input) = n.checked_sub(axes) else { return [sensor, position] };
        let seconds = self.steps as f64 * self.period();
        let normalized = self.inputs.normalized(input, seconds, sensor);
        let [offset, gain] = self.inputs.now.scales[n];
        [normalized, offset + gain * normalized]
    }

    /// What is led to an analog input, from 0, now, in V; nothing: 0 V.
    pub(super) fn analog_volts(&self, input: usize) -> f64 {
        self.inputs.volts(input, self.steps as f64 * self.period())
    }

    /// The target of an axis that an input signal gives; none: none is connected to it.
    pub(super) fn analog(&self, axis: usize) -> Option<f64> {
        let source = self.inputs.now.sources[axis].checked_sub(1)?;
        Some(self.input(source)[1] + self.inputs.now.offsets[axis])
    }

    fn look(&mut self) {
        let mut positions = vec![0.0; self.axes.len()];
        self.plant.read(&mut positions);
        self.axes.iter_mut().zip(positions).for_each(|(axis, position)| axis.position = position);
    }

    /// Power off and on: servo off, the voltage next to 0, what was not saved is lost.
    pub(super) fn reboot(&mut self) {
        self.servos = self.saved.clone();
        self.inputs.now = self.inputs.saved.clone();
        self.generators.iter_mut().for_each(|generator| *generator = Generator::new());
        self.recorder = Recorder::new(self.recorder.sources.clone(), self.recorder.length);
        for (axis, travel) in self.axes.iter_mut().zip(&self.travel) {
            let [a, b] = travel.volts;
            (axis.servo, axis.volts) = (false, 0.0_f64.clamp(a.min(b), a.max(b)));
            axis.target = axis.position;
        }
    }

    /// The servo of an axis; it takes over where the axis is.
    pub(super) fn servo(&mut self, axis: usize, on: bool) {
        let (servo, axis) = (&mut self.servos[axis], &mut self.axes[axis]);
        if !axis.servo {
            axis.target = axis.position;
            servo.rest(axis.volts, 0.0);
        }
        axis.servo = on;
    }

    /// A notch filter of an axis: frequency (0: off), damping of zeros and of poles.
    pub(super) fn notch(&mut self, axis: usize, place: usize, values: [f64; 3]) {
        let notch = Notch::new(values, self.period(), self.axes[axis].volts);
        self.servos[axis].notches[place] = notch;
    }

    pub(super) fn is_on_target(&self, axis: usize) -> bool {
        let [least, greatest] = self.travel[axis].range();
        let Axis { servo, target, position, .. } = self.axes[axis];
        // An input signal that has just been connected gives the target before the next servo cycle does.
        let target = self.analog(axis).map_or(target, |value| value.clamp(least, greatest));
        servo && (target - position).abs() <= ON_TARGET * (greatest - least)
    }
}
