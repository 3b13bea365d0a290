//! What FMUs say, and how: foreign environment pointers in every phase of an instance's life.
#![allow(clippy::print_stdout)]

mod common;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use cosim::{Drive, Fmu, HOST, InstanceOptions, Memory, Signals, simulate_with_inputs};
use modeldescription::FmiVersion;

/// A wrong pointer from a thread of the FMU's own is taken for the only instance there is, so tests run one by one.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

type Heard = Arc<Mutex<Vec<(String, String)>>>;

/// Options whose instance's messages are heard as (category, text).
fn ear(heard: &Heard) -> InstanceOptions {
    let ears = Arc::clone(heard);
    let hear = move |message: &cosim::Message| {
        ears.lock().unwrap().push((message.category.clone(), message.text.clone()));
    };
    InstanceOptions { on_message: Some(Arc::new(hear)), ..InstanceOptions::default() }
}

fn count(heard: &Heard, text: &str) -> usize {
    heard.lock().unwrap().iter().filter(|(_, messages)| messages == text).count()
}

fn a_stranger_runs(version: FmiVersion) {
    let fmus = fmus_or_skip!();
    let fmu = Fmu::open(fmus.pack("stranger", &common::stranger(version))).unwrap();
    let heard = Heard::default();
    let slave = fmu.instantiate("stranger", &ear(&heard)).unwrap();
    let signals = Signals::new(&[0.0, 1.0, 2.0, 3.0]).with("u", &[1.0, 2.0, 3.0, 4.0]);
    let mut memory = Memory::new();
    simulate_with_inputs(slave, &[signals], &Drive::default(), &mut memory).unwrap();
    assert_eq!(memory.values("y").unwrap(), [0.0, 2.0, 4.0, 6.0]);
    // Nine or ten wrong pointers in each phase; all of them are heard, three steps.
    for (text, least) in [
        ("before it is made", 9),
        ("at initialization", 9),
        ("in a step", 27),
        ("from a thread", 27),
        ("at the end", 9),
    ] {
        assert!(count(&heard, text) >= least, "{text}: {}", count(&heard, text));
    }
    let notes = heard.lock().unwrap().iter().filter(|(category, _)| category == HOST).count();
    assert_eq!(notes, 1, "the foreign pointer is noted once");
    // It speaks once more when it is gone; the library is still there.
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(count(&heard, "after the end"), 0);
}

#[test]
fn a_foreign_environment_pointer_is_never_followed() {
    let _turn = alone();
    a_stranger_runs(FmiVersion::V2);
}

#[test]
fn a_foreign_environment_pointer_is_never_followed_in_fmi_3() {
    let _turn = alone();
    a_stranger_runs(FmiVersion::V3);
}

#[test]
fn of_two_instances_each_hears_its_own() {
    let _turn = alone();
    let fmus = fmus_or_skip!();
    let fmu = Fmu::open(fmus.pack("stranger", &common::stranger(FmiVersion::V2))).unwrap();
    let (a, b) = (Heard::default(), Heard::default());
    let mut one = fmu.instantiate("one", &ear(&a)).unwrap();
    let mut two = fmu.instantiate("two", &ear(&b)).unwrap();
    for slave in [&mut one, &mut two] {
        slave.setup(&cosim::Experiment::default()).unwrap();
        slave.enter_initialization().unwrap();
        slave.exit_initialization().unwrap();
    }
    let before = count(&b, "in a step");
    one.step(0.0, 1.0).unwrap();
    assert!(count(&a, "in a step") >= 9 && count(&a, "from a thread") >= 9);
    assert_eq!(count(&b, "in a step"), before);
    drop((one, two));
    std::thread::sleep(Duration::from_millis(200));
}

#[test]
fn instances_come_and_go_without_growth() {
    let _turn = alone();
    let fmus = fmus_or_skip!();
    let fmu = Fmu::open(fmus.pack("bare", &common::bare())).unwrap();
    let resident = || {
        let text = std::fs::read_to_string("/proc/self/statm").ok()?;
        text.split(' ').nth(1)?.parse::<usize>().ok()
    };
    let cycle = || drop(fmu.instantiate("bare", &InstanceOptions::default()).unwrap());
    (0..5_000).for_each(|_| cycle());
    let before = resident();
    let asked = std::env::var("PIEZOLOOP_INSTANCES").ok().and_then(|n| n.parse().ok());
    let count = asked.unwrap_or(100_000);
    // A place that is never used again would take 12 MB for each 100 000.
    (0..count).for_each(|_| cycle());
    let (Some(before), Some(after)) = (before, resident()) else { return };
    println!("{count} lives: {before} pages became {after}");
    assert!(after < before + 512, "{before} pages became {after}");
}

#[test]
fn an_fmu_of_a_draft_is_named_as_one() {
    let _turn = alone();
    let fmus = fmus_or_skip!();
    let mut description = common::integrator3();
    description.draft = Some("3.0-beta.2".to_owned());
    let fmu = Fmu::open(fmus.pack("integrator3", &description)).unwrap();
    let heard = Heard::default();
    drop(fmu.instantiate("p", &ear(&heard)).unwrap());
    assert_eq!(count(&heard, "is of FMI 3.0-beta.2, a draft; it is run as one of FMI 3.0"), 1);
}
