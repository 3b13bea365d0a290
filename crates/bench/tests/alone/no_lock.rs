//! The cycle takes no lock: none can be reached from it in the machine code, and a live run never
//! sleeps but for its deadlines.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]
#![allow(clippy::print_stdout)]

#[path = "../common/mod.rs"]
mod common;

use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bench::emulate::{Script, Serve, serve};
use bench::gateway::{Address, End, Gateway, Site, open};
use bench::record::Recorder;
use bench::runner::{Settings, SharedOrders, run};
use common::{PERIOD_NS, control_law, controller, cycle, emulator};
use rustix::mm::{MlockAllFlags, mlockall};

const AXES: usize = 4;

/// What a lock calls when it must wait, by the names of the standard library, of libc and of common
/// crates: the fast way of a lock is inlined, but each lock can reach its slow way.
const LOCKS: [&str; 9] = [
    "lock_contended",
    "read_contended",
    "write_contended",
    "futex_wait",
    "pthread_mutex_lock",
    "pthread_rwlock",
    "pthread_cond",
    "sem_wait",
    "lock_slow",
];

/// What ends the run, and may do what it likes: a panic, and an FMU that reports an error, whose
/// messages are then read from the log that its logger writes.
const ENDS: [&str; 8] = [
    "panic",
    "unwrap_failed",
    "expect_failed",
    "handle_error",
    "alloc_error",
    "_fail",
    "Unwind",
    "Instance::failed",
];

/// The calls of a program: functions by address, and what each calls or jumps to.
struct Calls {
    names: HashMap<u64, String>,
    /// Places of the global offset table with functions of the program itself.
    places: HashMap<u64, u64>,
    calls: HashMap<u64, Vec<u64>>,
}

impl Calls {
    /// Of this test's own program; none without objdump.
    fn of_this_program() -> Option<Self> {
        let program = std::env::current_exe().ok()?;
        let dump = |arguments: &[&str]| {
            let output = Command::new("objdump").args(arguments).arg(&program).output().ok()?;
            output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
        };
        let mut all =
            Calls { names: HashMap::new(), places: HashMap::new(), calls: HashMap::new() };
        // Many calls go through places of the global offset table.
        for line in dump(&["-R", "-C"])?.lines() {
            let mut words = line.split_whitespace();
            if let (Some(place), Some(_), Some(name)) = (words.next(), words.next(), words.next())
                && let Ok(place) = u64::from_str_radix(place, 16)
            {
                let own = name.strip_prefix("*ABS*+0x");
                match own.and_then(|own| u64::from_str_radix(own, 16).ok()) {
                    Some(own) => all.places.insert(place, own).is_some(),
                    None => all.names.insert(place, name.to_owned()).is_some(),
                };
            }
        }
        let mut function = 0;
        for line in dump(&["-d", "-C", "--no-show-raw-insn"])?.lines() {
            if let Some((address, name)) = line.strip_suffix(">:").and_then(|l| l.split_once(" <"))
            {
                function = u64::from_str_radix(address, 16).ok()?;
                all.names.insert(function, name.to_owned());
            } else if let Some(target) = target(line) {
                let target = all.places.get(&target).copied().unwrap_or(target);
                all.calls.entry(function).or_default().push(target);
            }
        }
        Some(all)
    }

    /// Functions with all of these words in their names, the last one at the end.
    fn named(&self, words: &[&str]) -> Vec<u64> {
        let fits = |name: &String| {
            let ends = words.last().is_some_and(|last| name.ends_with(last));
            ends && words.iter().all(|word| name.contains(word))
        };
        let all = self.names.iter().filter(|(_, name)| fits(name));
        all.map(|(address, _)| *address).collect()
    }

    /// The way from a function to a lock, if there is one; and how many functions were looked at.
    fn way_to_a_lock(&self, root: u64) -> (Option<Vec<&str>>, usize) {
        let mut from: HashMap<u64, u64> = HashMap::new();
        let mut seen = HashSet::from([root]);
        let mut next = vec![root];
        let name = |address: &u64| self.names.get(address).map_or("?", String::as_str);
        while let Some(function) = next.pop() {
            for target in self.calls.get(&function).into_iter().flatten() {
                if ENDS.iter().any(|word| name(target).contains(word)) || !seen.insert(*target) {
                    continue;
                }
                from.insert(*target, function);
                if LOCKS.iter().any(|word| name(target).contains(word)) {
                    let mut way = vec![name(target)];
                    let mut at = *target;
                    while let Some(before) = from.get(&at) {
                        way.insert(0, name(before));
                        at = *before;
                    }
                    return (Some(way), seen.len());
                }
                next.push(*target);
            }
        }
        (None, seen.len())
    }
}

/// Where a call or a jump leads: an address of the program, or a place of the offset table.
fn target(line: &str) -> Option<u64> {
    let (_, instruction) = line.split_once(":\t")?;
    let mut words = instruction.split_whitespace();
    let word = words.next()?;
    if !(word.starts_with("call") || word.starts_with('j')) {
        return None;
    }
    let operand = words.next()?;
    if operand.starts_with('*') {
        let place = instruction.split_once("# ")?.1.split_whitespace().next()?;
        return u64::from_str_radix(place, 16).ok();
    }
    u64::from_str_radix(operand, 16).ok()
}

#[inline(never)]
fn a_planted_lock(value: &Mutex<u64>) -> u64 {
    value.lock().map_or(0, |mut value| {
        *value += 1;
        *value
    })
}

#[test]
fn no_lock_can_be_reached_from_the_cycle() {
    // What is linked is what is called: an FMU as the controller too.
    let missing = cosim::Fmu::open(std::path::Path::new("none.fmu"));
    assert!(missing.and_then(|fmu| fmu.instantiate("none", &Default::default())).is_err());
    assert_eq!(a_planted_lock(std::hint::black_box(&Mutex::new(1))), 2);
    let Some(calls) = Calls::of_this_program() else {
        println!("SKIPPED: no objdump (Debian: binutils)");
        return;
    };
    let root = |words: &[&str]| {
        let found = calls.named(words);
        assert!(!found.is_empty(), "no function {words:?} in the program");
        found
    };
    for planted in root(&["a_planted_lock"]) {
        assert!(calls.way_to_a_lock(planted).0.is_some(), "the planted lock is not found");
    }
    // The runner, and what it calls through tables: the gateways, and the controller FMU.
    let mut roots = root(&["bench::runner::run"]);
    for gateway in ["UdpGateway", "SharedMemoryGateway"] {
        for call in ["Gateway>::send", "Gateway>::receive"] {
            roots.extend(root(&[gateway, call]));
        }
    }
    for slave in ["::Fmi2Slave", "::Fmi3Slave"] {
        for call in ["Slave>::set", "Slave>::get", "Slave>::step"] {
            roots.extend(root(&[slave, call]));
        }
    }
    for one in roots {
        let (way, seen) = calls.way_to_a_lock(one);
        println!("{}: {seen} functions", calls.names[&one]);
        assert!(way.is_none(), "{}", way.unwrap_or_default().join("\n-> "));
    }
}

/// Counts how often the calling thread has waited for something, without a wait of its own: it
/// allocates nothing, and so never asks for the memory map, which another thread may be changing.
struct Waits(File);

impl Waits {
    fn of_this_thread() -> Self {
        Self(File::open("/proc/thread-self/status").unwrap())
    }

    fn count(&self) -> u64 {
        let mut buffer = [0; 4096];
        let length = self.0.read_at(&mut buffer, 0).unwrap();
        let status = std::str::from_utf8(&buffer[..length]).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("voluntary_ctxt_switches:"));
        line.unwrap().trim().parse().unwrap()
    }
}

/// A gateway that counts the waits from the first cycle's packet to the last one's. What the run
/// prepares before its first cycle and reports after its last may wait: it asks for memory there.
struct Watched<'a> {
    gateway: &'a mut dyn Gateway,
    waits: &'a Waits,
    first: Option<u64>,
    last: u64,
    sent: u64,
}

impl Gateway for Watched<'_> {
    fn send(&mut self, packet: &[u8]) -> bool {
        let sent = self.gateway.send(packet);
        self.last = self.waits.count();
        self.first.get_or_insert(self.last);
        self.sent += 1;
        sent
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.gateway.receive(buffer)
    }

    fn wait(&mut self, timeout: Duration) {
        self.gateway.wait(timeout);
    }
}

/// Plays the machine until it is told to end, or for three seconds.
fn machine(address: &Address, stop: &AtomicBool) {
    let mut gateway = open(address, End::Machine, None, &Site::default()).unwrap();
    let mut emulator = emulator(AXES, Script::default());
    let until = Serve { stop, duration_ns: Some(3_000_000_000) };
    serve(&mut emulator, &mut *gateway, &until).unwrap();
}

#[test]
fn a_live_run_waits_for_nothing_but_its_deadlines() {
    let first = 40_000 + (std::process::id() % 500) as u16 * 2;
    let (address, mut runner) = (first..60_000)
        .step_by(2)
        .find_map(|port| {
            let address: Address = format!("udp://127.0.0.1:{port}").parse().ok()?;
            Some((address.clone(), open(&address, End::Runner, None, &Site::default()).ok()?))
        })
        .expect("a free port");
    let mut cycle = cycle(AXES, controller(AXES, control_law(AXES)));
    let (recorder, mut ring) = Recorder::start(None, cycle.row().len(), 10_000).unwrap();
    let settings = Settings { period_ns: PERIOD_NS, settle: 20, patience: 1_000_000 };
    let (orders, stop) = (SharedOrders::default(), AtomicBool::new(false));
    let (outcome, waited) = std::thread::scope(|scope| {
        // Readers of the view take its lock as often as they can; the recorder takes it to write.
        for _ in 0..2 {
            scope.spawn(|| {
                while !stop.load(Ordering::Relaxed) {
                    std::hint::black_box(recorder.view().latest());
                }
            });
        }
        scope.spawn(|| {
            machine(&address, &stop);
            orders.stop();
        });
        // As before every run of the tool: the first touch of a page may wait for the kernel, which
        // changes the memory map for the other threads.
        let locked = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).is_ok();
        println!("memory locked: {locked}");
        let waits = Waits::of_this_thread();
        let mut watched =
            Watched { gateway: &mut *runner, waits: &waits, first: None, last: 0, sent: 0 };
        let outcome = run(&mut cycle, &mut watched, &orders, &settings, &mut ring);
        let waited = watched.last - watched.first.expect("a packet");
        assert_eq!(watched.sent, outcome.cycles, "one packet each cycle");
        stop.store(true, Ordering::Relaxed);
        (outcome, waited)
    });
    let rows = recorder.finish().unwrap().rows;
    println!("{waited} waits between {} cycles, {rows} rows", outcome.cycles);
    assert!(outcome.cycles > 30 && rows > 20, "{} cycles, {rows} rows", outcome.cycles);
    assert!(waited < outcome.cycles, "{waited} waits between {} cycles", outcome.cycles);
}

#[test]
fn a_lock_that_another_thread_holds_is_seen_as_a_wait() {
    let value = Arc::new(Mutex::new(0));
    let other = Arc::clone(&value);
    let (sender, receiver) = std::sync::mpsc::channel();
    let holder = std::thread::spawn(move || {
        let held = other.lock().unwrap();
        sender.send(()).unwrap();
        std::thread::sleep(Duration::from_millis(200));
        drop(held);
    });
    receiver.recv().unwrap();
    let waits = Waits::of_this_thread();
    let before = waits.count();
    *value.lock().unwrap() += 1;
    assert!(waits.count() > before);
    holder.join().unwrap();
}
