//! One cycle of the runner: receive, judge, compute, send.

mod controller;
mod player;
mod row;

pub use controller::{Controller, ControllerError, Driver};
pub use player::Player;
pub use row::{Column, columns, computed};

use crate::gateway::Gateway;
use crate::packet::{self, Header, Kind, PacketError, Status};
use crate::receive::{Arrival, Counters, Receiver};
use crate::safety::{self, AxisLimits, Events, Memory, Monitor, Reason, Shaper, State, Watch};

/// Packets that are taken in one cycle; of a flood, the rest waits for the next one.
const MOST_PACKETS: usize = 64;

/// What a cycle is made of.
#[derive(Debug)]
pub struct Setup {
    /// Length of a cycle in ns.
    pub period_ns: u64,
    /// Who makes the commands.
    pub driver: Driver,
    /// The references that it follows (or the commands, without a controller).
    pub player: Player,
    /// Limits of each axis.
    pub limits: Vec<AxisLimits>,
    /// What is watched.
    pub watch: Watch,
    /// Cycles over which the controller takes over.
    pub blend: u32,
    /// Sequence of the first packet; differs from one start to the next.
    pub first_sequence: u32,
}

/// What somebody outside wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orders {
    /// To run.
    pub start: bool,
    /// To stop.
    pub stop: bool,
    /// To acknowledge a fault.
    pub reset: bool,
}

/// When a cycle takes place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tick {
    /// The tick's place on the grid of deadlines.
    pub index: u64,
    /// Deadlines before it that were missed.
    pub skipped: u32,
    /// Monotonic time in ns at its begin.
    pub now_ns: u64,
    /// By how many ns it began after its deadline.
    pub wake_ns: u64,
    /// How many ns the cycle before it worked.
    pub last_work_ns: u64,
}

/// All that a cycle works with; made once, nothing of it grows.
#[derive(Debug)]
pub struct Cycle {
    period_ns: u64,
    driver: Driver,
    player: Player,
    receiver: Receiver,
    monitor: Monitor,
    shaper: Shaper,
    watch: Watch,
    memory: Memory,
    missing: u32,
    missing_because: Reason,
    first_sequence: u32,
    /// Sequence and time of the command that went out last.
    sent: u32,
    /// Sequence and time of the newest packet in order, for the echo.
    echo: (u32, u64),
    round_trip_ns: Option<u64>,
    references: Box<[f64]>,
    wanted: Box<[f64]>,
    /// The driver cannot go on.
    failed: Option<Reason>,
    /// Why the first whole packet that was refused was no packet for this runner.
    refused: Option<PacketError>,
    unsent: u64,
    /// Cycles that drove on with an older sample.
    held: u64,
    /// Index of the cycle that has time 0: the first that is not idle.
    origin: u64,
    buffer: Box<[u8; packet::MAX_BYTES]>,
    row: Box<[f64]>,
}

impl Cycle {
    /// Makes the cycle of a setup.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let axes = setup.limits.len();
        let period = setup.period_ns as f64 / 1e9;
        let zeros = || vec![0.0; axes].into_boxed_slice();
        let has_controller = matches!(setup.driver, Driver::Controller(_));
        Cycle {
            period_ns: setup.period_ns,
            driver: setup.driver,
            player: setup.player,
            receiver: Receiver::new(Kind::Measurement, axes, setup.watch.max_age),
            monitor: Monitor::new(&setup.limits, setup.watch, period),
            shaper: Shaper::new(&setup.limits, setup.blend, period),
            watch: setup.watch,
            memory: Memory::default(),
            missing: u32::MAX,
            missing_because: Reason::SampleLost,
            first_sequence: setup.first_sequence,
            sent: setup.first_sequence.wrapping_sub(1),
            echo: (0, 0),
            round_trip_ns: None,
            references: zeros(),
            wanted: zeros(),
            failed: None,
            refused: None,
            unsent: 0,
            held: 0,
            origin: 0,
            buffer: Box::new([0; packet::MAX_BYTES]),
            row: vec![0.0; row::length(axes, has_controller)].into(),
        }
    }

    /// State and reason.
    #[must_use]
    pub fn memory(&self) -> Memory {
        self.memory
    }

    /// What happened to the packets from the machine.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        self.receiver.counters()
    }

    /// Packets that the gateway did not take.
    #[must_use]
    pub fn unsent(&self) -> u64 {
        self.unsent
    }

    /// Cycles that drove on with an older sample.
    #[must_use]
    pub fn held(&self) -> u64 {
        self.held
    }

    /// Cycles times axes in which a command was limited.
    #[must_use]
    pub fn clipped(&self) -> u64 {
        self.shaper.clipped()
    }

    /// Whether the commands are at their safe values.
    #[must_use]
    pub fn at_rest(&self) -> bool {
        self.shaper.at_rest()
    }

    /// Limits of the axes.
    #[must_use]
    pub fn limits(&self) -> &[AxisLimits] {
        self.shaper.limits()
    }

    /// Cycles that the plan takes, from the start to its end.
    #[must_use]
    pub fn planned_cycles(&self) -> u64 {
        self.player.cycles()
    }

    /// Number of axes.
    #[must_use]
    pub fn axes(&self) -> usize {
        self.references.len()
    }

    /// Time from a command to the sample that answers it, if one came in this cycle.
    #[must_use]
    pub fn round_trip_ns(&self) -> Option<u64> {
        self.round_trip_ns
    }

    /// What the driver says about its failure.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        self.driver.failure()
    }

    /// Why whole packets were refused, if some were: another version, kind or number of channels.
    #[must_use]
    pub fn refused(&self) -> Option<PacketError> {
        self.refused
    }

    /// The commands that were sent last.
    #[must_use]
    pub fn commands(&self) -> &[f64] {
        self.shaper.commands()
    }

    /// The row of the cycle that ran last; its columns are those of [`columns`].
    #[must_use]
    pub fn row(&self) -> &[f64] {
        &self.row
    }

    /// Runs one cycle.
    pub fn run(&mut self, tick: &Tick, orders: &Orders, gateway: &mut dyn Gateway) -> Memory {
        let restarted = self.receive(tick, gateway);
        let fault = self.fault(tick, restarted);
        let before = self.memory.state;
        self.decide(orders, fault);
        if before == State::Idle && self.memory.state != State::Idle && self.origin == 0 {
            self.origin = tick.index;
        }
        if before == State::Ready && self.memory.state == State::Running {
            self.begin();
        } else if self.memory.state.drives() {
            self.player.advance(1 + u64::from(tick.skipped));
        }
        self.drive(orders);
        self.shaper.shape(self.memory.state, &self.wanted);
        self.held += u64::from(self.memory.state.drives() && self.missing > 0);
        self.send(tick, gateway);
        self.fill_row(tick);
        self.memory
    }

    /// Takes all packets that have arrived; whether the machine began to count anew.
    fn receive(&mut self, tick: &Tick, gateway: &mut dyn Gateway) -> bool {
        let mut restarted = false;
        let mut sampled = false;
        let mut because = Reason::SampleLost;
        self.round_trip_ns = None;
        for _ in 0..MOST_PACKETS {
            let Some(length) = gateway.receive(&mut self.buffer[..]) else { break };
            match self.receiver.receive(&self.buffer[..length], self.sent) {
                Arrival::Fresh => sampled = true,
                Arrival::Restarted => (sampled, restarted) = (true, true),
                Arrival::Late => because = Reason::SampleLate,
                Arrival::NotFinite => because = Reason::SampleNotFinite,
                Arrival::Invalid => because = Reason::SampleInvalid,
                Arrival::Refused(error) => {
                    because = Reason::SampleCorrupt;
                    self.refused = self.refused.or((!error.is_corruption()).then_some(error));
                }
                Arrival::Duplicate | Arrival::Reordered | Arrival::Stale => {}
            }
        }
        if let Some(header) = self.receiver.header() {
            self.echo = (header.sequence, header.time_ns);
            if sampled && header.echo_time_ns != 0 {
                self.round_trip_ns = tick.now_ns.checked_sub(header.echo_time_ns);
            }
        }
        if sampled {
            (self.missing, self.missing_because) = (0, Reason::None);
        } else {
            self.missing = self.missing.saturating_add(1 + tick.skipped);
            // Of a row of missing samples the last known cause counts, not the silence after it.
            if because != Reason::SampleLost || self.missing_because == Reason::None {
                self.missing_because = because;
            }
        }
        restarted
    }

    fn fault(&mut self, tick: &Tick, restarted: bool) -> Option<Reason> {
        let state = self.memory.state;
        let sampled = self.missing == 0;
        let positions = self.receiver.values();
        let limit = self.monitor.look(&safety::Observed {
            sample: sampled.then_some((positions, self.echo.0)),
            references: (state.drives() && self.player.plays()).then_some(&self.references),
            commands: self.shaper.commands(),
            drives: state.drives(),
        });
        let machine = Monitor::machine(self.receiver.header()).filter(|_| state != State::Safe);
        let restart = (restarted && state.drives()).then_some(Reason::MachineRestarted);
        let too_slow = self.watch.overrun > 0 && tick.skipped > self.watch.overrun;
        let overrun = (too_slow && state.drives()).then_some(Reason::Overrun);
        self.failed.or(machine).or(restart).or(overrun).or(limit)
    }

    fn decide(&mut self, orders: &Orders, fault: Option<Reason>) {
        let machine_ready = Monitor::machine(self.receiver.header()).is_none();
        let events = Events {
            missing: self.missing,
            missing_because: self.missing_because,
            machine_ready: machine_ready && self.receiver.header().is_some(),
            fault,
            start: orders.start,
            stop: orders.stop,
            reset: orders.reset,
            finished: self.player.is_finished(),
            at_rest: self.shaper.at_rest(),
        };
        let before = self.memory.state;
        self.memory = safety::next(self.memory, &events, self.watch.hold);
        let again = matches!(before, State::Safe | State::Fault);
        if again && self.memory.state == State::Idle {
            self.monitor.reset();
            self.player.rewind();
        }
    }

    /// The controller takes over.
    fn begin(&mut self) {
        self.shaper.take_over();
        let from = match &self.driver {
            Driver::Controller(_) => self.receiver.values(),
            Driver::Direct => self.shaper.commands(),
        };
        self.player.start(from);
    }

    /// The references of this cycle, and what the driver makes of them.
    fn drive(&mut self, orders: &Orders) {
        let positions = self.receiver.values();
        if self.memory.state.drives() {
            self.player.read(&mut self.references);
        } else if matches!(self.driver, Driver::Controller(_)) {
            // It waits where the machine is, so that it takes over without a bump.
            self.references.copy_from_slice(positions);
        } else {
            self.references.copy_from_slice(self.shaper.commands());
        }
        if self.failed.is_some() || self.memory.state == State::Idle {
            return;
        }
        let done = self.driver.step(&self.references, positions, &mut self.wanted);
        let finite = self.wanted.iter().all(|command| command.is_finite());
        let trouble = match (done, finite) {
            (true, true) => return,
            (true, false) => Reason::CommandNotFinite,
            (false, _) => {
                self.failed = Some(Reason::ControllerFailed);
                Reason::ControllerFailed
            }
        };
        self.decide(orders, Some(trouble));
        self.wanted.copy_from_slice(self.shaper.commands());
    }

    fn send(&mut self, tick: &Tick, gateway: &mut dyn Gateway) {
        let Memory { state, reason } = self.memory;
        let active = match state {
            State::Idle => false,
            State::Ready | State::Running | State::Hold => true,
            State::Safe | State::Fault => !self.shaper.at_rest(),
        };
        let commands = self.shaper.commands();
        self.sent = self.first_sequence.wrapping_add(tick.index as u32);
        let header = Header {
            kind: Kind::Command,
            channels: commands.len() as u16,
            sequence: self.sent,
            status: if active { Status::ENABLE } else { Status::default() },
            time_ns: tick.now_ns,
            echo_sequence: self.echo.0,
            state: state as u8,
            reason: reason as u8,
            echo_time_ns: self.echo.1,
        };
        let length = packet::encode(&header, commands, &mut self.buffer[..]);
        self.unsent += u64::from(!gateway.send(&self.buffer[..length]));
    }

    fn fill_row(&mut self, tick: &Tick) {
        let micro = |ns: u64| ns as f64 * 1e-3;
        let counters = self.receiver.counters();
        let scalars = [
            f64::from(self.memory.state as u8),
            f64::from(self.memory.reason as u8),
            f64::from(self.missing),
            self.player.row(),
            micro(tick.wake_ns),
            micro(tick.last_work_ns),
            self.round_trip_ns.map_or(0.0, micro),
            f64::from(tick.skipped),
            counters.lost as f64,
            counters.late as f64,
            counters.duplicate as f64,
            counters.reordered as f64,
            counters.corrupt as f64,
        ];
        let axes = self.references.len();
        let (time, rest) = self.row.split_at_mut(1);
        time[0] = (tick.index.saturating_sub(self.origin) * self.period_ns) as f64 / 1e9;
        let (references, rest) = rest.split_at_mut(axes);
        let (positions, rest) = rest.split_at_mut(axes);
        let (commands, rest) = rest.split_at_mut(axes);
        references.copy_from_slice(&self.references);
        positions.copy_from_slice(self.receiver.values());
        commands.copy_from_slice(self.shaper.commands());
        let (own, computed) = rest.split_at_mut(scalars.len());
        own.copy_from_slice(&scalars);
        // Empty without a controller.
        computed.copy_from_slice(&self.wanted[..computed.len()]);
    }
}
