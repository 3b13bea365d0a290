//! An instrument behind a line in memory, and what can go wrong with both.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use bench::emulate::Instrument;
use bench::gateway::line::Line;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The line is gone, and does not open.
    Cut,
    /// The line is gone once, and opens again.
    HungUp,
    /// Nothing is answered.
    Silence,
    /// Answers come with those of the next exchange.
    Delay,
    /// Answers are other bytes.
    Garbage,
    /// Answers break off, and the rest is lost.
    Half,
    /// Answers come twice.
    Double,
    /// Lines of an answer are swapped.
    Swapped,
    /// The instrument's power was off for a moment.
    Reboot,
    /// Somebody stops it.
    Stop,
}

pub const FAULTS: [Fault; 10] = [
    Fault::Cut,
    Fault::HungUp,
    Fault::Silence,
    Fault::Delay,
    Fault::Garbage,
    Fault::Half,
    Fault::Double,
    Fault::Swapped,
    Fault::Reboot,
    Fault::Stop,
];

/// The instrument, its line, and what happens to both.
#[derive(Debug)]
pub struct World {
    pub instrument: Box<dyn Instrument>,
    /// What a question for positions holds, and the positions of its answer.
    asks: &'static [u8],
    positions: fn(&str) -> Option<Vec<f64>>,
    /// What stops the instrument.
    stop: &'static [u8],
    /// At a serial line, which knows no connection: what ends a command there.
    end: Option<&'static [u8]>,
    fault: Option<(Fault, u64, u64)>,
    random: ChaCha8Rng,
    exchanges: u64,
    is_open: bool,
    pending: Vec<u8>,
    late: Vec<u8>,
    /// Positions that were told.
    pub commanded: Vec<Vec<f64>>,
}

impl World {
    fn active(&self) -> Option<Fault> {
        let (fault, from, length) = self.fault?;
        (from..from.saturating_add(length)).contains(&self.exchanges).then_some(fault)
    }

    fn question(&mut self, bytes: &[u8]) {
        let asks = bytes.windows(self.asks.len()).any(|word| word == self.asks);
        if asks {
            let is_first = self.active().is_none();
            self.exchanges += 1;
            self.instrument.step().unwrap();
            match self.active() {
                Some(Fault::Reboot) if is_first => self.instrument.reboot(),
                Some(Fault::Stop) => drop(self.instrument.receive(self.stop)),
                _ => {}
            }
        }
        let good = self.instrument.receive(bytes);
        if asks {
            self.commanded.extend((self.positions)(&String::from_utf8_lossy(&good)));
        }
        let arrived = std::mem::take(&mut self.late);
        self.pending.extend(arrived);
        match self.active() {
            Some(Fault::Cut | Fault::Silence) => {}
            Some(Fault::Delay) => self.late = good,
            Some(Fault::Garbage) => {
                let bytes = good.iter().map(|_| (self.random.next_u32() >> 8) as u8);
                self.pending.extend(bytes.collect::<Vec<_>>());
            }
            Some(Fault::Half) => self.pending.extend(&good[..good.len() / 2]),
            Some(Fault::Double) => [&good, &good].iter().for_each(|all| self.pending.extend(*all)),
            Some(Fault::Swapped) => {
                let text = String::from_utf8_lossy(&good).replace("1=", "#=").replace("2=", "1=");
                self.pending.extend(text.replace("#=", "2=").bytes());
            }
            Some(Fault::HungUp | Fault::Reboot | Fault::Stop) | None => self.pending.extend(&good),
        }
    }
}

#[derive(Debug)]
pub struct MemoryLine(pub Rc<RefCell<World>>);

impl Line for MemoryLine {
    fn open(&mut self, _: Duration) -> Result<(), String> {
        let mut world = self.0.borrow_mut();
        if world.end.is_none() {
            (world.pending, world.late) = (Vec::new(), Vec::new());
            world.instrument.hang_up();
        }
        // The time that an attempt takes.
        world.exchanges += 1;
        world.instrument.step().unwrap();
        world.is_open = world.active() != Some(Fault::Cut);
        // A half command is ended, and what comes is thrown away; what is late still comes later.
        if let (Some(end), true) = (world.end, world.is_open) {
            let _ = world.instrument.receive(end);
            world.pending.clear();
        }
        if world.is_open { Ok(()) } else { Err("nobody answers".to_owned()) }
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        let mut world = self.0.borrow_mut();
        let is_gone = matches!(world.active(), Some(Fault::Cut | Fault::HungUp));
        if is_gone && world.is_open && world.active() == Some(Fault::HungUp) {
            world.fault = None;
            world.is_open = false;
        }
        if is_gone || !world.is_open {
            return Err("the line is gone".to_owned());
        }
        world.question(bytes);
        Ok(())
    }

    fn read(&mut self, bytes: &mut [u8], _: Duration) -> Result<usize, String> {
        let mut world = self.0.borrow_mut();
        // In pieces, as a line brings them.
        let most = 1 + world.random.next_u32() as usize % 7;
        let length = world.pending.len().min(bytes.len()).min(most);
        let piece: Vec<u8> = world.pending.drain(..length).collect();
        bytes[..length].copy_from_slice(&piece);
        Ok(length)
    }

    fn close(&mut self) {
        self.0.borrow_mut().is_open = false;
    }
}

impl World {
    /// At a serial line; `end`: what ends a command there.
    pub fn at_serial_line(&mut self, end: &'static [u8]) {
        self.end = Some(end);
    }

    /// `asks`, `positions`, `stop`: what the protocol calls them.
    pub fn new(
        instrument: Box<dyn Instrument>,
        seed: u64,
        fault: Option<(Fault, u64, u64)>,
        asks: &'static [u8],
        positions: fn(&str) -> Option<Vec<f64>>,
        stop: &'static [u8],
    ) -> Rc<RefCell<Self>> {
        let axes = instrument.targets().len();
        Rc::new(RefCell::new(World {
            instrument,
            asks,
            positions,
            stop,
            end: None,
            fault,
            random: ChaCha8Rng::seed_from_u64(seed),
            exchanges: 0,
            is_open: false,
            pending: Vec::new(),
            late: Vec::new(),
            commanded: vec![vec![0.0; axes]],
        }))
    }
}
