//! The emulator: plays the machine from a plant FMU, and injects faults by a script.
//!
//! It is told the time, never reads it: the same code runs in real time and in virtual time.

mod fault;
mod instrument;
mod link;
mod serve;

pub use crate::gateway::Instrument;
pub use crate::plant::{Plant, PlantError};
pub use fault::{Active, Direction, Fault, FaultKind, Script, ScriptError};
pub use instrument::{GcsInstrument, Nv200Instrument, Signals, Travel, travel};
pub use link::{Injected, Link};
pub use serve::{Serve, Served, serve};

use crate::gateway::Gateway;
use crate::packet::{self, Header, Kind, Status};
use crate::receive::{Arrival, Counters, Receiver};

/// Before the first sequence of a machine that has just begun; one that restarts begins at 0.
const FIRST_SEQUENCE: u32 = 1 << 20;

/// When the machine steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// At its own deadlines, as a machine does.
    #[default]
    Clock,
    /// Once per command, and for a command that never came when its follower comes: free of the
    /// jitter of this computer, so that a log is the same each time. Without commands it goes on by
    /// its clock.
    Commands,
}

/// How the machine behaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Behaviour {
    /// When it steps.
    pub timing: Timing,
    /// Length of a step in ns.
    pub period_ns: u64,
    /// Without a command for so many steps it stops itself.
    pub heartbeat: u32,
    /// Commands while it is stopped, in the unit of the plant's inputs.
    pub safe: Vec<f64>,
}

/// A machine that is played.
#[derive(Debug)]
pub struct Emulator {
    behaviour: Behaviour,
    script: Script,
    plant: Plant,
    receiver: Receiver,
    commands: Link,
    measurements: Link,
    active: Active,
    /// Steps so far.
    steps: u64,
    /// Sequence of the newest command, and the step at which it came.
    newest: Option<(u32, u64)>,
    next_step_ns: Option<u64>,
    stopped: bool,
    sequence: u32,
    applied: Box<[f64]>,
    held: Box<[f64]>,
    sample: Box<[f64]>,
    buffer: Box<[u8; packet::MAX_BYTES]>,
}

impl Emulator {
    /// A machine at rest under the safe commands.
    #[must_use]
    pub fn new(plant: Plant, behaviour: Behaviour, script: Script) -> Self {
        let axes = plant.axes();
        let zeros = || vec![0.0; axes].into_boxed_slice();
        let seed = script.seed;
        Emulator {
            // A machine plays what it is told, however old: only the runner judges age.
            receiver: Receiver::new(Kind::Command, axes, u32::MAX),
            commands: Link::new(seed, 0),
            measurements: Link::new(seed, 1),
            active: Active::default(),
            steps: 0,
            newest: None,
            next_step_ns: None,
            stopped: false,
            sequence: FIRST_SEQUENCE,
            applied: behaviour.safe.clone().into(),
            held: zeros(),
            sample: zeros(),
            buffer: Box::new([0; packet::MAX_BYTES]),
            behaviour,
            script,
            plant,
        }
    }

    /// Steps so far.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Whether it stopped itself.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Commands that act now.
    #[must_use]
    pub fn applied(&self) -> &[f64] {
        &self.applied
    }

    /// What happened to the packets from the runner, as the machine sees it.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        self.receiver.counters()
    }

    /// What was injected into commands and into measurements.
    #[must_use]
    pub fn injected(&self) -> (Injected, Injected) {
        (*self.commands.injected(), *self.measurements.injected())
    }

    /// The state the runner reported last, and its reason.
    #[must_use]
    pub fn runner(&self) -> Option<(u8, u8)> {
        self.receiver.header().map(|header| (header.state, header.reason))
    }

    /// When it wants to be called again at the latest.
    #[must_use]
    pub fn next_ns(&self) -> Option<u64> {
        let links = [self.commands.next_ns(), self.measurements.next_ns(), self.next_step_ns];
        links.into_iter().flatten().min()
    }

    /// Does everything that is due: takes packets, steps, sends.
    ///
    /// # Errors
    /// The plant FMU failed.
    pub fn serve(&mut self, now_ns: u64, gateway: &mut dyn Gateway) -> Result<(), PlantError> {
        self.activate();
        while let Some(length) = gateway.receive(&mut self.buffer[..]) {
            self.commands.push(now_ns, &self.buffer[..length], &self.active.commands);
        }
        while let Some(packet) = self.commands.pop(now_ns) {
            self.take(&packet, now_ns)?;
        }
        let first = *self.next_step_ns.get_or_insert(now_ns);
        if now_ns >= first {
            let period = self.behaviour.period_ns;
            let due = 1 + (now_ns - first) / period;
            self.next_step_ns = Some(first + due * period);
            for _ in 0..due {
                self.step(now_ns)?;
            }
        }
        while let Some(packet) = self.measurements.pop(now_ns) {
            gateway.send(&packet);
        }
        Ok(())
    }

    fn activate(&mut self) {
        let time = self.steps as f64 * self.behaviour.period_ns as f64 * 1e-9;
        self.script.activate(time, &mut self.active);
    }

    /// Takes a command.
    fn take(&mut self, packet: &[u8], now_ns: u64) -> Result<(), PlantError> {
        let arrival = self.receiver.receive(packet, 0);
        let Some(header) = self.receiver.header().copied() else { return Ok(()) };
        if !matches!(arrival, Arrival::Fresh | Arrival::Restarted) {
            return Ok(());
        }
        let before = self.newest.replace((header.sequence, self.steps));
        if self.stopped && !header.status.has(Status::ENABLE) {
            self.stopped = false;
        }
        if self.behaviour.timing == Timing::Clock {
            return Ok(());
        }
        // A command that was lost on the way still took its period, under the command before it.
        let passed = match (before, arrival) {
            (Some((sequence, _)), Arrival::Fresh) => header.sequence.wrapping_sub(sequence).min(64),
            _ => 1,
        };
        self.next_step_ns = Some(now_ns + self.grace());
        for _ in 1..passed {
            self.advance()?;
        }
        self.step(now_ns)
    }

    /// How long a machine that steps by commands waits before it goes on by its clock.
    fn grace(&self) -> u64 {
        u64::from(self.behaviour.heartbeat.max(2)) * self.behaviour.period_ns / 2
    }

    /// One step and its measurement.
    fn step(&mut self, now_ns: u64) -> Result<(), PlantError> {
        self.activate();
        self.choose();
        self.advance()?;
        self.measure(now_ns);
        Ok(())
    }

    /// The commands that act in this step.
    fn choose(&mut self) {
        let since = self.newest.map_or(u64::MAX, |(_, step)| self.steps - step);
        let header = self.receiver.header();
        let enabled = header.is_some_and(|header| header.status.has(Status::ENABLE));
        let alive = since < u64::from(self.behaviour.heartbeat);
        self.stopped |= enabled && (!alive || self.active.power_loss);
        let follows = enabled && !self.stopped;
        let commands = if follows { self.receiver.values() } else { &self.behaviour.safe[..] };
        self.applied.copy_from_slice(commands);
    }

    fn advance(&mut self) -> Result<(), PlantError> {
        self.plant.step(&self.applied)?;
        self.steps += 1;
        Ok(())
    }

    /// Sends what the sensors see.
    fn measure(&mut self, now_ns: u64) {
        if self.active.restart && self.sequence >= FIRST_SEQUENCE {
            self.sequence = 0;
        }
        self.plant.read(&mut self.sample);
        for (axis, value) in self.sample.iter_mut().enumerate() {
            *value = self.active.sense(axis, *value, &mut self.held[axis]);
        }
        let header = self.receiver.header();
        let mut status = Status::default();
        for (bit, is_set) in [
            (Status::POWERED, !self.active.power_loss),
            (Status::VALID, !self.active.invalid),
            (Status::SAFE, self.stopped),
        ] {
            status = if is_set { status.with(bit) } else { status };
        }
        self.sequence = self.sequence.wrapping_add(1);
        let header = Header {
            kind: Kind::Measurement,
            channels: self.sample.len() as u16,
            sequence: self.sequence,
            status,
            time_ns: now_ns,
            echo_sequence: header.map_or(0, |header| header.sequence),
            state: 0,
            reason: 0,
            echo_time_ns: header.map_or(0, |header| header.time_ns),
        };
        let length = packet::encode(&header, &self.sample, &mut self.buffer[..]);
        self.measurements.push(now_ns, &self.buffer[..length], &self.active.measurements);
    }
}
