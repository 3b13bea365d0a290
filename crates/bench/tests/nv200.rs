//! An NV200 behind a bad line, in virtual time: 200 scripts of cuts, delays, garbage, half and doubled answers and
//! restarts. Each ends in the safe state or runs on, no sample is used that the instrument did not have,
//! and the commands keep their limits.
#![cfg(unix)]
#![allow(clippy::print_stdout)]

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use crate::common::bad_line::{Fault, MemoryLine, World};
use crate::common::lockstep::{Lockstep, run};
use crate::common::{PERIOD, controller, cycle_with, plant, target_limits, targets};
use bench::emulate::{Nv200Instrument, travel};
use bench::gateway::device::Device;
use bench::gateway::line::Options;
use bench::gateway::nv200::{self, Nv200Device};
use bench::safety::{Reason, State};

/// The position of an answer `meas,1.5`.
fn position(answer: &str) -> Option<Vec<f64>> {
    let value = answer.trim_matches(|c: char| c.is_control()).strip_prefix("meas,")?;
    Some(vec![value.trim().parse().ok()?])
}

fn world(seed: u64, fault: Option<(Fault, u64, u64)>) -> Rc<RefCell<World>> {
    let travel = travel(plant(1), &[[-20.0, 120.0]]).unwrap();
    let instrument = Box::new(Nv200Instrument::new(plant(1), travel).unwrap());
    World::new(instrument, seed, fault, b"meas", position, b"")
}

fn device(world: &Rc<RefCell<World>>, options: &str) -> Result<Nv200Device, String> {
    let options = Options::parse(options, PERIOD)?;
    Nv200Device::open(Box::new(MemoryLine(Rc::clone(world))), options, &[0.0])
}

#[test]
fn line_faults_end_in_the_safe_state() {
    faults_end_safely(false);
}

#[test]
fn faults_of_a_serial_line_end_in_the_safe_state() {
    faults_end_safely(true);
}

fn faults_end_safely(serial: bool) {
    let faults = [
        Fault::Cut,
        Fault::HungUp,
        Fault::Silence,
        Fault::Delay,
        Fault::Garbage,
        Fault::Half,
        Fault::Double,
        Fault::Reboot,
    ];
    let mut ends = BTreeMap::<String, u32>::new();
    let mut scripts = 0;
    for fault in faults {
        for (index, from) in [60, 150, 317, 700, 1040].into_iter().enumerate() {
            for length in [1, 2, 3, 9, u64::MAX] {
                scripts += 1;
                let seed = 1000 * index as u64 + length % 1000;
                let name = format!("{fault:?} from exchange {from} for {length}, seed {seed}");
                let world = world(seed, Some((fault, from, length)));
                if serial {
                    world.borrow_mut().at_serial_line(nv200::END);
                }
                let mut gateway = Lockstep::new(Box::new(device(&world, "").unwrap()), 1);
                let mut cycle = cycle_with(1, controller(1, targets(1)), target_limits());
                let memory = run(&mut cycle, &mut gateway, 6000);
                *ends
                    .entry(format!("{fault:?}: {}, {}", memory.state, memory.reason))
                    .or_default() += 1;
                assert!(matches!(memory.state, State::Safe | State::Fault), "{name}: {memory:?}");
                assert!(cycle.at_rest(), "{name}");
                if (length > 8 && fault != Fault::HungUp) || fault == Fault::Reboot {
                    assert_ne!(memory.reason, Reason::Finished, "{name}");
                }
                let world = world.borrow();
                let used = cycle.row()[2];
                assert!(
                    world.commanded.iter().any(|commanded| *commanded == [used]),
                    "{name}: {used} was never told"
                );
                if length != u64::MAX && fault != Fault::Reboot {
                    assert_eq!(world.instrument.targets(), [(0.0, true)], "{name}");
                }
                if fault == Fault::Reboot {
                    let reported = gateway.bridge.failure().unwrap_or_default();
                    assert!(reported.contains("has restarted"), "{name}: {reported}");
                    assert!(!world.instrument.targets()[0].1, "{name}: it is left alone");
                }
            }
        }
    }
    println!("{scripts} scripts: {ends:#?}");
    assert_eq!(scripts, 200);
}

#[test]
fn a_good_line_follows_in_both_modes() {
    for (options, words) in
        [("", "closed loop, from -2 to 12"), ("mode=open", "open loop, from -20 to 120")]
    {
        let world = world(1, None);
        let mut device = device(&world, options).unwrap();
        let reported = device.describe().unwrap();
        assert!(reported.contains("NV200/D_NET") && reported.contains(words), "{reported}");
        let mut gateway = Lockstep::new(Box::new(device), 1);
        let mut cycle = cycle_with(1, controller(1, targets(1)), target_limits());
        let memory = run(&mut cycle, &mut gateway, 6000);
        assert_eq!((memory.state, memory.reason), (State::Safe, Reason::Finished), "{options}");
        assert_eq!(gateway.bridge.failure(), None);
        let world = world.borrow();
        let greatest =
            world.commanded.iter().fold(0.0_f64, |most, commanded| most.max(commanded[0]));
        // 8 um, or 8 V of 0.1 um/V.
        let expected = if options.is_empty() { 6.0..9.0 } else { 0.7..0.9 };
        assert!(expected.contains(&greatest), "it moved: {greatest} um");
    }
}

#[test]
fn an_instrument_that_does_not_fit_is_refused() {
    let open = |options: &str, safe: &[f64]| {
        let options = Options::parse(options, PERIOD)?;
        Nv200Device::open(Box::new(MemoryLine(world(1, None))), options, safe).map(|_| ())
    };
    for (options, safe, words) in [
        ("", &[0.0, 0.0][..], "has one axis, the run 2"),
        ("axes=1", &[0.0], "axes= and analog= are not for it"),
        ("", &[50.0], "its travel is from -2 to 12; the safe command 50"),
    ] {
        let message = open(options, safe).unwrap_err();
        assert!(message.contains(words), "{message}");
    }
    let silent = world(1, Some((Fault::Silence, 0, u64::MAX)));
    assert!(device(&silent, "").unwrap_err().contains("does not answer as an NV200"));
}
