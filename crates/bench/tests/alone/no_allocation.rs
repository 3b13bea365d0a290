//! The cycle allocates nothing and takes no lock.
#![allow(clippy::print_stdout)]

#[path = "../common/mod.rs"]
mod common;

use std::path::Path;

use bench::cycle::{Cycle, Orders, Tick};
use bench::emulate::Script;
use bench::gateway::{Address, End, Gateway, Site, open};
use bench::runner::{Settings, SharedOrders, run};
use bench::safety::State;
use common::{control_law, controller, cycle, emulator};
use counting::Counting;
use rtrb::RingBuffer;

#[global_allocator]
static COUNTING: Counting = Counting;

const AXES: usize = 4;

/// Both ends at an address that is free.
fn udp() -> (Box<dyn Gateway>, Box<dyn Gateway>) {
    (20_000..60_000)
        .step_by(2)
        .map(|port| port + (std::process::id() % 500) as u16 * 2)
        .find_map(|port| {
            let address: Address = format!("udp://127.0.0.1:{port}").parse().ok()?;
            Some((
                open(&address, End::Runner, None, &Site::default()).ok()?,
                open(&address, End::Machine, None, &Site::default()).ok()?,
            ))
        })
        .expect("a free port")
}

/// Runs cycles against the emulator and counts the calls of the allocator inside the cycles.
fn allocations(mut runner: Box<dyn Gateway>, mut machine: Box<dyn Gateway>) -> (u64, Cycle) {
    let faults = "[[fault]]\nkind = \"loss\"\nprobability = 0.05\n\
                  [[fault]]\nkind = \"corrupt\"\nprobability = 0.05\n";
    let mut emulator = emulator(AXES, Script::parse(faults, "script").unwrap());
    let mut cycle = cycle(AXES, controller(AXES, control_law(AXES)));
    let orders = Orders { start: true, ..Orders::default() };
    let mut inside = 0;
    let mut now_ns = 1_000_000;
    for index in 0..3000 {
        let tick = Tick { index, now_ns, ..Tick::default() };
        let before = counting::calls();
        cycle.run(&tick, &orders, &mut *runner);
        inside += counting::calls() - before;
        machine.wait(std::time::Duration::from_millis(100));
        emulator.serve(now_ns, &mut *machine).unwrap();
        now_ns += 1_000_000;
    }
    (inside, cycle)
}

#[test]
fn no_cycle_allocates_over_udp() {
    let (runner, machine) = udp();
    let (calls, cycle) = allocations(runner, machine);
    // From start to finish, with holds on the way.
    assert_eq!(cycle.memory().state, State::Safe);
    assert!(cycle.counters().corrupt > 10 && cycle.counters().used > 800);
    assert_eq!(calls, 0);
}

#[cfg(feature = "shared-memory")]
#[test]
fn no_cycle_allocates_over_shared_memory() {
    let address: Address = format!("shm://count-{}", std::process::id()).parse().unwrap();
    let runner = open(&address, End::Runner, None, &Site::default()).unwrap();
    let machine = open(&address, End::Machine, None, &Site::default()).unwrap();
    let (calls, cycle) = allocations(runner, machine);
    assert_eq!(cycle.memory().state, State::Safe);
    assert!(cycle.counters().corrupt > 10 && cycle.counters().used > 800);
    assert_eq!(calls, 0);
}

#[test]
fn the_runner_itself_allocates_as_often_for_many_cycles_as_for_few() {
    let count = |patience: u64| {
        let mut silent = Silent;
        let mut cycle = cycle(AXES, controller(AXES, control_law(AXES)));
        let (mut ring, _rows) = RingBuffer::new(10_000);
        let settings = Settings { period_ns: 100_000, settle: 10, patience };
        let before = counting::calls();
        let outcome = run(&mut cycle, &mut silent, &SharedOrders::default(), &settings, &mut ring);
        assert!(outcome.cycles >= patience.min(outcome.cycles + outcome.skipped));
        counting::calls() - before
    };
    count(10);
    assert_eq!(count(20), count(2000));
}

/// A gateway that sends nowhere.
struct Silent;

impl Gateway for Silent {
    fn send(&mut self, _: &[u8]) -> bool {
        true
    }
    fn receive(&mut self, _: &mut [u8]) -> Option<usize> {
        None
    }
    fn wait(&mut self, _: std::time::Duration) {}
}

/// What runs in a cycle knows no lock, no file, no channel and no print: they are not even named.
#[test]
fn what_runs_in_a_cycle_names_no_lock() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = vec![root.join("receive.rs"), root.join("clock.rs")];
    for folder in ["cycle", "safety", "packet", "runner"] {
        let entries = std::fs::read_dir(root.join(folder)).unwrap();
        files.extend(entries.map(|entry| entry.unwrap().path()));
    }
    files.push(root.join("gateway/udp.rs"));
    assert!(files.len() > 15);
    let forbidden =
        ["Mutex", "RwLock", "Condvar", "mpsc", "println!", "File::", "Once", "thread::park"];
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        for word in forbidden {
            assert!(!text.contains(word), "{} names {word}", file.display());
        }
    }
}
