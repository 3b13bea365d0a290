//! Runner and emulator in one thread and in virtual time: a bench run to try a plan and its faults
//! on, as fast as the computer can, and the same each time.

use crate::cycle::{Cycle, Orders, Tick};
use crate::emulate::{Emulator, PlantError};
use crate::gateway::{MemoryGateway, pair};
use crate::safety::{Memory, State};

/// How often the machine's side is looked at within a period.
const LOOKS: u64 = 4;

/// A runner and a machine in virtual time.
#[derive(Debug)]
pub struct VirtualRun {
    /// The runner.
    pub cycle: Cycle,
    /// The machine.
    pub emulator: Emulator,
    period_ns: u64,
    runner_end: MemoryGateway,
    machine_end: MemoryGateway,
    next: u64,
    record: Option<Vec<f64>>,
}

/// How one ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ended {
    /// Last state and reason.
    pub memory: Memory,
    /// Cycle in which this state was entered.
    pub entered: u64,
    /// Cycle in which the commands were at rest.
    pub at_rest: u64,
}

impl VirtualRun {
    /// Puts a runner and a machine together.
    #[must_use]
    pub fn new(cycle: Cycle, emulator: Emulator, period_ns: u64) -> Self {
        let (runner_end, machine_end) = pair();
        VirtualRun { cycle, emulator, period_ns, runner_end, machine_end, next: 0, record: None }
    }

    /// Keeps its rows from the first cycle that is not idle, as `bench run` does.
    #[must_use]
    pub fn recorded(mut self) -> Self {
        self.record = Some(Vec::new());
        self
    }

    /// The rows that were kept, one after the other.
    #[must_use]
    pub fn record(&self) -> &[f64] {
        self.record.as_deref().unwrap_or_default()
    }

    /// Length of a cycle in s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period_ns as f64 / 1e9
    }

    /// Index of the next cycle.
    #[must_use]
    pub fn next(&self) -> u64 {
        self.next
    }

    /// One cycle, after `skipped` missed ones; the machine goes on meanwhile.
    ///
    /// # Errors
    /// The plant FMU failed.
    pub fn tick(&mut self, orders: &Orders, skipped: u32) -> Result<Memory, PlantError> {
        for _ in 0..skipped {
            self.machine()?;
        }
        let now_ns = self.now();
        let tick = Tick { index: self.next, skipped, now_ns, ..Tick::default() };
        let memory = self.cycle.run(&tick, orders, &mut self.runner_end);
        if let Some(record) = self.record.as_mut().filter(|_| memory.state != State::Idle) {
            record.extend_from_slice(self.cycle.row());
        }
        self.machine()?;
        Ok(memory)
    }

    fn now(&self) -> u64 {
        (self.next + 1) * self.period_ns
    }

    /// The machine's side over one period.
    fn machine(&mut self) -> Result<(), PlantError> {
        for look in 0..LOOKS {
            let now = self.now() + look * self.period_ns / LOOKS;
            self.emulator.serve(now, &mut self.machine_end)?;
        }
        self.next += 1;
        Ok(())
    }

    /// Runs until the machine is at rest in the state safe or fault, for `most` cycles at most;
    /// `each` is called after every cycle and gives the orders of the next one.
    ///
    /// # Errors
    /// The plant FMU failed.
    pub fn run(
        &mut self,
        most: u64,
        mut each: impl FnMut(&VirtualRun, Memory) -> Orders,
    ) -> Result<Ended, PlantError> {
        let mut orders = Orders::default();
        let mut entered = (self.cycle.memory(), self.next);
        while self.next < most {
            let index = self.next;
            let memory = self.tick(&orders, 0)?;
            if memory != entered.0 {
                entered = (memory, index);
            }
            let ended = matches!(memory.state, State::Safe | State::Fault);
            if ended && self.cycle.at_rest() {
                return Ok(Ended { memory, entered: entered.1, at_rest: index });
            }
            orders = each(self, memory);
        }
        Ok(Ended { memory: entered.0, entered: entered.1, at_rest: u64::MAX })
    }
}
