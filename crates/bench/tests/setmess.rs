//! An amplifier that knows `set` and `mess`, emulated behind a bad line in virtual time: each script ends at rest, and
//! no sample is used that the amplifier did not measure.
#![cfg(unix)]

use std::cell::RefCell;
use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::rc::Rc;

use crate::common::bad_line::{Fault, MemoryLine, World};
use crate::common::lockstep::{Lockstep, run};
use crate::common::{PERIOD, control_law, controller, cycle};
use bench::emulate::{Instrument, PlantError};
use bench::gateway::device::{Device as _, Exchanged};
use bench::gateway::line::Options;
use bench::gateway::setmess::SetMess;
use bench::gateway::{Address, End, Site, open};
use bench::safety::{Reason, State};

/// Voltages that it takes.
const VOLTS: std::ops::RangeInclusive<f64> = -20.0..=120.0;

/// An amplifier and its stage: a first-order lag of gain 0.1 um/V and 3 ms.
#[derive(Debug, Default)]
struct Amplifier {
    volts: f64,
    position: f64,
    line: Vec<u8>,
    commands: u64,
}

impl Amplifier {
    fn answer(&mut self, request: &str) -> String {
        self.commands += 1;
        match request.split_once(',').map(|(name, value)| (name, value.parse::<f64>())) {
            None if request == "mess" => format!("mess,{:.6}\r", self.position),
            Some(("set", Ok(volts))) if VOLTS.contains(&volts) => {
                self.volts = volts;
                format!("set,{volts:.6}\r")
            }
            Some(("set", Ok(_))) => "error,range\r".to_owned(),
            _ => "error,unknown\r".to_owned(),
        }
    }
}

impl Instrument for Amplifier {
    fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut answers = Vec::new();
        for byte in bytes {
            if *byte != b'\r' {
                self.line.push(*byte);
            } else if !self.line.is_empty() {
                let line = std::mem::take(&mut self.line);
                answers.extend(self.answer(&String::from_utf8_lossy(&line)).bytes());
            }
        }
        answers
    }

    fn step(&mut self) -> Result<(), PlantError> {
        self.position += (0.1 * self.volts - self.position) * (PERIOD / 3e-3);
        Ok(())
    }

    fn reboot(&mut self) {
        (self.volts, self.line) = (0.0, Vec::new());
    }

    fn hang_up(&mut self) {
        self.line.clear();
    }

    fn commands(&self) -> u64 {
        self.commands
    }

    fn targets(&self) -> Vec<(f64, bool)> {
        vec![(self.volts, false)]
    }
}

/// The position of an answer `mess,1.5`.
fn position(answer: &str) -> Option<Vec<f64>> {
    Some(vec![answer.trim().strip_prefix("mess,")?.parse().ok()?])
}

fn world(seed: u64, fault: Option<(Fault, u64, u64)>) -> Rc<RefCell<World>> {
    World::new(Box::new(Amplifier::default()), seed, fault, b"mess", position, b"")
}

fn device(world: &Rc<RefCell<World>>, options: &str, safe: &[f64]) -> Result<SetMess, String> {
    let options = Options::parse(options, PERIOD)?;
    SetMess::open(Box::new(MemoryLine(Rc::clone(world))), &options, safe)
}

#[test]
fn a_good_line_follows_and_nothing_is_set_before_enable() {
    let world = world(1, None);
    let mut device = device(&world, "", &[0.0]).unwrap();
    let sample = Exchanged::Sample { valid: true, powered: true };
    assert_eq!(device.exchange(false, &[30.0], &mut [0.0]), sample);
    assert_eq!(world.borrow().instrument.targets(), [(0.0, false)]);
    let mut gateway = Lockstep::new(Box::new(device), 1);
    let mut cycle = cycle(1, controller(1, control_law(1)));
    let memory = run(&mut cycle, &mut gateway, 6000);
    assert_eq!((memory.state, memory.reason), (State::Safe, Reason::Finished));
    assert_eq!(gateway.bridge.failure(), None);
    let greatest = world.borrow().commanded.iter().fold(0.0_f64, |most, now| most.max(now[0]));
    assert!((7.0..9.0).contains(&greatest), "it moved: {greatest} um");
}

#[test]
fn line_faults_end_at_rest() {
    let mut scripts = 0;
    for fault in [
        Fault::Cut,
        Fault::HungUp,
        Fault::Silence,
        Fault::Delay,
        Fault::Garbage,
        Fault::Half,
        Fault::Double,
    ] {
        for (index, from) in [60, 317, 1040].into_iter().enumerate() {
            for (length, serial) in
                [1, 2, 3, 9, u64::MAX].into_iter().flat_map(|n| [(n, false), (n, true)])
            {
                scripts += 1;
                let name = format!("{fault:?} from exchange {from} for {length}, {serial}");
                let world = world(1000 * index as u64 + length % 1000, Some((fault, from, length)));
                if serial {
                    world.borrow_mut().at_serial_line(b"\r");
                }
                let device = Box::new(device(&world, "", &[0.0]).unwrap());
                let mut gateway = Lockstep::new(device, 1);
                let mut cycle = cycle(1, controller(1, control_law(1)));
                let memory = run(&mut cycle, &mut gateway, 6000);
                assert!(matches!(memory.state, State::Safe | State::Fault), "{name}: {memory:?}");
                assert!(cycle.at_rest(), "{name}");
                if length == u64::MAX && fault != Fault::HungUp {
                    assert_ne!(memory.reason, Reason::Finished, "{name}");
                }
                let (world, used) = (world.borrow(), cycle.row()[2]);
                assert!(world.commanded.contains(&vec![used]), "{name}: {used} was never told");
                if length != u64::MAX {
                    assert_eq!(world.instrument.targets(), [(0.0, false)], "{name}");
                }
            }
        }
    }
    assert_eq!(scripts, 210);
}

#[test]
fn what_it_refuses_and_what_does_not_fit_is_reported() {
    let good = world(1, None);
    let mut driven = device(&good, "", &[0.0]).unwrap();
    let said = driven.exchange(true, &[500.0], &mut [0.0]);
    assert_eq!(said, Exchanged::Failed("set,500.000000: range".to_owned()));
    for (options, safe) in [("", &[0.0, 0.0][..]), ("axes=1", &[0.0]), ("analog=1", &[0.0])] {
        assert!(device(&good, options, safe).unwrap_err().contains("has one axis"), "{options}");
    }
    let silent = world(1, Some((Fault::Silence, 0, u64::MAX)));
    assert!(device(&silent, "", &[0.0]).unwrap_err().contains("does not answer mess"));
}

#[test]
fn its_address_opens_it_over_tcp() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("setmess://{}?timeout=0.5", listener.local_addr().unwrap());
    let amplifier = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let (mut amplifier, mut bytes) = (Amplifier::default(), [0; 64]);
        while let Ok(length @ 1..) = stream.read(&mut bytes) {
            stream.write_all(&amplifier.receive(&bytes[..length])).unwrap();
        }
    });
    let site = Site { safe: vec![0.0], period: PERIOD, ..Site::default() };
    let gateway = open(&address.parse::<Address>().unwrap(), End::Runner, None, &site).unwrap();
    assert_eq!(gateway.describe().as_deref(), Some("amplifier with set and mess, at 0"));
    drop(gateway);
    amplifier.join().unwrap();
}
