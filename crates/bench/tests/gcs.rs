//! An instrument of PI behind a bad line, in virtual time: 200 scripts of cuts, delays, garbage, half and doubled
//! answers, restarts and stops. Each ends in the safe state or runs on, no sample is used that the
//! instrument did not have, and the commands keep their limits.
#![cfg(unix)]
#![allow(clippy::print_stdout)]

mod common;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Duration;

use bench::emulate::{Instrument, travel};
use bench::gateway::device::Device;
use bench::gateway::gcs::{GcsDevice, Line, Options};
use bench::safety::{AxisLimits, Reason, State};
use common::lockstep::{Lockstep, run};
use common::{Law, PERIOD, controller, cycle_with, limits, plant};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

const AXES: usize = 2;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
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

const FAULTS: [Fault; 10] = [
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
struct World {
    instrument: Instrument,
    fault: Option<(Fault, u64, u64)>,
    random: ChaCha8Rng,
    exchanges: u64,
    is_open: bool,
    pending: Vec<u8>,
    late: Vec<u8>,
    /// Positions that were told.
    told: Vec<Vec<f64>>,
}

impl World {
    fn active(&self) -> Option<Fault> {
        let (fault, from, length) = self.fault?;
        (from..from.saturating_add(length)).contains(&self.exchanges).then_some(fault)
    }

    fn question(&mut self, bytes: &[u8]) {
        // What the runner may use: the positions before the fault.
        if bytes.windows(4).any(|word| word == b"POS?") {
            let is_first = self.active().is_none();
            self.exchanges += 1;
            self.instrument.step().unwrap();
            match self.active() {
                Some(Fault::Reboot) if is_first => self.instrument.reboot(),
                Some(Fault::Stop) => drop(self.instrument.receive(&[24])),
                _ => {}
            }
        }
        let good = self.instrument.receive(bytes);
        let asks = bytes.windows(4).any(|word| word == b"POS?");
        if let Some(line) =
            good.split(|byte| *byte == b'\n').next().filter(|line| asks && line.starts_with(b"1="))
        {
            let second = good.split(|byte| *byte == b'\n').nth(1).unwrap_or_default();
            let value = |line: &[u8]| {
                let text = String::from_utf8_lossy(line).into_owned();
                text.split_once('=').and_then(|(_, value)| value.trim().parse().ok())
            };
            self.told.push([line, second].iter().filter_map(|line| value(line)).collect());
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
struct MemoryLine(Rc<RefCell<World>>);

impl Line for MemoryLine {
    fn open(&mut self, _: Duration) -> Result<(), String> {
        let mut world = self.0.borrow_mut();
        (world.pending, world.late) = (Vec::new(), Vec::new());
        world.instrument.hang_up();
        // The time that an attempt takes.
        world.exchanges += 1;
        world.instrument.step().unwrap();
        world.is_open = world.active() != Some(Fault::Cut);
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

fn world(seed: u64, fault: Option<(Fault, u64, u64)>) -> Rc<RefCell<World>> {
    let travel = travel(plant(AXES), &[[-20.0, 120.0]; AXES]).unwrap();
    Rc::new(RefCell::new(World {
        instrument: Instrument::new(plant(AXES), travel),
        fault,
        random: ChaCha8Rng::seed_from_u64(seed),
        exchanges: 0,
        is_open: false,
        pending: Vec::new(),
        late: Vec::new(),
        told: vec![vec![0.0; AXES]],
    }))
}

fn device(world: &Rc<RefCell<World>>) -> GcsDevice {
    let options = Options::parse("", PERIOD).unwrap();
    GcsDevice::open(Box::new(MemoryLine(Rc::clone(world))), options, &[0.0; AXES]).unwrap()
}

/// The commands are targets in um: the references themselves.
fn targets() -> Law {
    Box::new(|_, inputs, _, u| {
        u.copy_from_slice(&inputs[..AXES]);
        true
    })
}

fn limits_here() -> AxisLimits {
    AxisLimits {
        command: [-1.0, 11.0],
        command_rate: 800.0,
        tracking_error: f64::INFINITY,
        position_rate: f64::INFINITY,
        safe_rate: 100.0,
        ..limits()
    }
}

#[test]
fn line_faults_end_in_the_safe_state() {
    let mut ends = BTreeMap::<String, u32>::new();
    let mut scripts = 0;
    for fault in FAULTS {
        for (index, from) in [60, 150, 317, 700, 1040].into_iter().enumerate() {
            for length in [1, 3, 9, u64::MAX] {
                scripts += 1;
                let seed = 1000 * index as u64 + length % 1000;
                let name = format!("{fault:?} from exchange {from} for {length}, seed {seed}");
                let world = world(seed, Some((fault, from, length)));
                let mut gateway = Lockstep::new(Box::new(device(&world)), AXES);
                let mut cycle = cycle_with(AXES, controller(AXES, targets()), limits_here());
                let memory = run(&mut cycle, &mut gateway, 6000);
                *ends
                    .entry(format!("{fault:?}: {}, {}", memory.state, memory.reason))
                    .or_default() += 1;
                assert!(matches!(memory.state, State::Safe | State::Fault), "{name}: {memory:?}");
                assert!(cycle.at_rest(), "{name}");
                let lasts = length > 8 && fault != Fault::HungUp;
                let stays = matches!(fault, Fault::Reboot | Fault::Stop);
                if lasts || fault == Fault::Reboot {
                    assert_ne!(memory.reason, Reason::Finished, "{name}");
                }
                let world = world.borrow();
                let used = &cycle.row()[1 + AXES..1 + 2 * AXES];
                assert!(
                    world.told.iter().any(|told| told == used),
                    "{name}: {used:?} was never told"
                );
                // Where the line is good in the end, the targets are the safe ones.
                if length != u64::MAX && !stays {
                    let targets = world.instrument.targets();
                    assert!(
                        targets.iter().all(|target| *target == (0.0, true)),
                        "{name}: {targets:?}"
                    );
                }
                if fault == Fault::Reboot {
                    let said = gateway.bridge.failure().unwrap_or_default();
                    assert!(
                        said.contains("restarted") || said.contains("servo off"),
                        "{name}: {said}"
                    );
                    assert!(world.instrument.targets().iter().all(|(_, servo)| !servo), "{name}");
                }
                if fault == Fault::Stop && length > 8 {
                    assert!(
                        gateway.bridge.failure().unwrap().contains("stopped by a command"),
                        "{name}"
                    );
                }
            }
        }
    }
    println!("{scripts} scripts: {ends:#?}");
    assert_eq!(scripts, 200);
}

#[test]
fn a_good_line_follows_and_ends_at_rest() {
    let world = world(1, None);
    let mut device = device(&world);
    let said = device.describe().unwrap();
    assert!(said.contains("emulated GCS 2.0") && said.contains("1 from -2 to 12"), "{said}");
    let mut gateway = Lockstep::new(Box::new(device), AXES);
    let mut cycle = cycle_with(AXES, controller(AXES, targets()), limits_here());
    let memory = run(&mut cycle, &mut gateway, 6000);
    assert_eq!((memory.state, memory.reason), (State::Safe, Reason::Finished));
    assert_eq!(gateway.bridge.failure(), None);
    let world = world.borrow();
    assert_eq!(world.instrument.targets(), vec![(0.0, true); AXES]);
    let greatest = world.told.iter().fold(0.0_f64, |most, told| most.max(told[0]));
    assert!((6.0..9.0).contains(&greatest), "it moved: {greatest} um");
}

#[test]
fn an_instrument_that_does_not_fit_is_refused() {
    let open = |options: &str, safe: &[f64]| {
        let world = world(1, None);
        let options = Options::parse(options, PERIOD)?;
        GcsDevice::open(Box::new(MemoryLine(world)), options, safe).map(|_| ())
    };
    assert_eq!(open("axes=2,1", &[0.0, 0.0]), Ok(()));
    for (options, safe, words) in [
        ("", &[0.0; 3][..], "has the axes 1, 2"),
        ("axes=1,7", &[0.0; 2], "choose with ?axes=1,2"),
        ("", &[0.0, 50.0], "axis 2 goes from -2 to 12; the safe command 50"),
        ("axis=1", &[0.0], "`axis=1` is none of axes"),
        ("timeout=0", &[0.0], "timeout=SECONDS"),
        ("axes=1,,2", &[0.0], "no name"),
    ] {
        let message = open(options, safe).unwrap_err();
        assert!(message.contains(words), "{message}");
    }
    let silent = world(1, Some((Fault::Silence, 0, u64::MAX)));
    let options = Options::parse("", PERIOD).unwrap();
    let message = GcsDevice::open(Box::new(MemoryLine(silent)), options, &[0.0; AXES]).unwrap_err();
    assert!(message.contains("does not answer in GCS 2.0"), "{message}");
}
