//! A device and a runner in one thread and in virtual time.

use std::collections::VecDeque;
use std::time::Duration;

use bench::cycle::{Cycle, Orders, Tick};
use bench::gateway::Gateway;
use bench::gateway::device::{Bridge, Device};
use bench::safety::{Memory, State};

use super::PERIOD_NS;

/// The runner's end: what is sent is exchanged at once, and the answer waits for the next cycle.
pub struct Lockstep {
    pub bridge: Bridge,
    pub now_ns: u64,
    answers: VecDeque<Vec<u8>>,
}

impl Lockstep {
    pub fn new(device: Box<dyn Device>, axes: usize) -> Self {
        let bridge = Bridge::new(device, &vec![0.0; axes], 100_000_000, 0);
        Lockstep { bridge, now_ns: 0, answers: VecDeque::new() }
    }
}

impl Gateway for Lockstep {
    fn send(&mut self, packet: &[u8]) -> bool {
        self.bridge.take(packet, self.now_ns);
        let now = self.now_ns;
        self.answers.extend(self.bridge.turn(now, || now).map(<[u8]>::to_vec));
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let packet = self.answers.pop_front()?;
        buffer[..packet.len()].copy_from_slice(&packet);
        Some(packet.len())
    }

    fn wait(&mut self, _: Duration) {}
}

/// Runs until the commands are at rest in the state safe or fault, for so many cycles at most. The
/// limits of every command are checked on the way.
pub fn run(cycle: &mut Cycle, gateway: &mut Lockstep, most: u64) -> Memory {
    for index in 0..most {
        gateway.now_ns = (index + 1) * PERIOD_NS;
        let tick = Tick { index, now_ns: gateway.now_ns, ..Tick::default() };
        let orders = Orders { start: index >= 10, ..Orders::default() };
        let memory = cycle.run(&tick, &orders, gateway);
        for (command, axis) in cycle.commands().iter().zip(cycle.limits()) {
            assert!((axis.command[0]..=axis.command[1]).contains(command), "{command}");
        }
        if matches!(memory.state, State::Safe | State::Fault) && cycle.at_rest() {
            break;
        }
    }
    gateway.bridge.end();
    cycle.memory()
}
