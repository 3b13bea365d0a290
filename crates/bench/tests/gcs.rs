//! An instrument of PI behind a bad line, in virtual time: 200 scripts of cuts, delays, garbage, half and doubled
//! answers, restarts and stops. Each ends in the safe state or runs on, no sample is used that the
//! instrument did not have, and the commands keep their limits.
#![cfg(unix)]
#![allow(clippy::print_stdout)]

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use crate::common::bad_line::{FAULTS, Fault, MemoryLine, World};
use crate::common::lockstep::{Lockstep, run};
use crate::common::{PERIOD, controller, cycle_with, plant, target_limits, targets};
use bench::emulate::{GcsInstrument, travel};
use bench::gateway::device::Device;
use bench::gateway::gcs::{self, GcsDevice};
use bench::gateway::line::Options;
use bench::safety::{Reason, State};

const AXES: usize = 2;

/// The positions of an answer `1=+0.5 \n2=+1.5\n0\n`.
fn positions(answer: &str) -> Option<Vec<f64>> {
    let values = answer.split('\n').filter_map(|line| line.split_once('='));
    let values: Vec<f64> = values.filter_map(|(_, value)| value.trim().parse().ok()).collect();
    (values.len() == AXES).then_some(values)
}

fn world(seed: u64, fault: Option<(Fault, u64, u64)>) -> Rc<RefCell<World>> {
    let travel = travel(plant(AXES), &[[-20.0, 120.0]; AXES]).unwrap();
    let instrument = Box::new(GcsInstrument::new(plant(AXES), travel));
    World::new(instrument, seed, fault, b"POS?", positions, &[24])
}

fn device(world: &Rc<RefCell<World>>) -> GcsDevice {
    let options = Options::parse("", PERIOD).unwrap();
    GcsDevice::open(Box::new(MemoryLine(Rc::clone(world))), options, &[0.0; AXES]).unwrap()
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
    let mut ends = BTreeMap::<String, u32>::new();
    let mut scripts = 0;
    for fault in FAULTS {
        for (index, from) in [60, 150, 317, 700, 1040].into_iter().enumerate() {
            for length in [1, 3, 9, u64::MAX] {
                scripts += 1;
                let seed = 1000 * index as u64 + length % 1000;
                let name = format!("{fault:?} from exchange {from} for {length}, seed {seed}");
                let world = world(seed, Some((fault, from, length)));
                if serial {
                    world.borrow_mut().at_serial_line(gcs::END);
                }
                let mut gateway = Lockstep::new(Box::new(device(&world)), AXES);
                let mut cycle = cycle_with(AXES, controller(AXES, targets(AXES)), target_limits());
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
                    world.commanded.iter().any(|commanded| commanded == used),
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
                    let reported = gateway.bridge.failure().unwrap_or_default();
                    assert!(
                        reported.contains("restarted") || reported.contains("servo off"),
                        "{name}: {reported}"
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
    let reported = device.describe().unwrap();
    assert!(
        reported.contains("emulated GCS 2.0") && reported.contains("1 from -2 to 12"),
        "{reported}"
    );
    let mut gateway = Lockstep::new(Box::new(device), AXES);
    let mut cycle = cycle_with(AXES, controller(AXES, targets(AXES)), target_limits());
    let memory = run(&mut cycle, &mut gateway, 6000);
    assert_eq!((memory.state, memory.reason), (State::Safe, Reason::Finished));
    assert_eq!(gateway.bridge.failure(), None);
    let world = world.borrow();
    assert_eq!(world.instrument.targets(), vec![(0.0, true); AXES]);
    let greatest = world.commanded.iter().fold(0.0_f64, |most, commanded| most.max(commanded[0]));
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
    // Positions from the analog inputs.
    assert_eq!(open("analog=3,4", &[0.0, 0.0]), Ok(()));
    for (options, safe, words) in [
        ("", &[0.0; 3][..], "has the axes 1, 2"),
        ("axes=1,7", &[0.0; 2], "choose with ?axes=1,2"),
        ("", &[0.0, 50.0], "axis 2 has a travel from -2 to 12; the safe command 50"),
        ("analog=3", &[0.0; 2], "names 1 input signals for 2 axes"),
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
