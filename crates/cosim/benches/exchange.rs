//! Cost of an exchange: two C FMUs in a closed loop, by the bare C functions and by the master.
//!
//! `cargo bench -p piezoloop-cosim`
#![allow(clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::process::Command;
use std::time::Instant;

use common::instance;
use cosim::{Coupling, Loop, LoopSettings, Memory, Points, Recorder, Run, Signals, Wiring};

const STEPS: usize = 1_000_000;
const H: f64 = 1e-3;
const REPEATS: usize = 7;

/// The closed loop by hand in fmpy, ns per step and FMU; `None` where there is no Python with it.
fn fmpy(fmus: &common::Fmus) -> Option<f64> {
    let workspace = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?;
    let own = || workspace.join("target/python-env/bin/python");
    let python = std::env::var_os("PIEZOLOOP_PYTHON").map_or_else(own, std::path::PathBuf::from);
    let controller = fmus.pack("controller", &common::controller());
    let plant = fmus.pack("integrator", &common::integrator());
    let output = Command::new(python).args(["-c", FMPY]).args([controller, plant]).output();
    let text = String::from_utf8(output.ok()?.stdout).ok()?;
    text.lines().find_map(|line| line.strip_prefix("ns ")?.parse().ok())
}

/// Best of some repeats, as here; the arrays of references are made once, as fmpy allows.
const FMPY: &str = r#"
import sys, time
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
def slave(path, name):
    d = read_model_description(path, validate=False)
    s = FMU2Slave(guid=d.guid, unzipDirectory=extract(path), instanceName=name,
                  modelIdentifier=d.coSimulation.modelIdentifier)
    s.instantiate()
    s.setupExperiment(startTime=0.0)
    s.enterInitializationMode()
    s.exitInitializationMode()
    return s
best, steps, h = float("inf"), 20000, 1e-3
c, p = slave(sys.argv[1], "c"), slave(sys.argv[2], "p")
for _ in range(5):
    for s in (c, p):
        s.reset()
        s.setupExperiment(startTime=0.0)
        s.enterInitializationMode()
        s.exitInitializationMode()
    y, begin = [0.0], time.perf_counter_ns()
    for k in range(steps):
        c.setReal([0, 1], [1.0, y[0]])
        c.doStep(k * h, h)
        p.setReal([0], c.getReal([2]))
        p.doStep(k * h, h)
        y = p.getReal([1])
    best = min(best, (time.perf_counter_ns() - begin) / (2 * steps))
print("ns", best)
"#;

/// Best time of some repeats, ns per step and FMU.
fn best(mut run: impl FnMut()) -> f64 {
    let nanoseconds = (0..REPEATS).map(|_| {
        let begin = Instant::now();
        run();
        begin.elapsed().as_nanos() as f64 / (2 * STEPS) as f64
    });
    nanoseconds.fold(f64::INFINITY, f64::min)
}

/// Best time of some repeats by the bare C functions, in a C program.
fn bare(fmus: &common::Fmus) -> f64 {
    let source = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/bare.c");
    let program = fmus.path("bare");
    let built = Command::new("cc")
        .args(["-std=gnu11", "-O2", "-o"])
        .args([&program, &source])
        .arg("-ldl")
        .status()
        .expect("the C compiler runs");
    assert!(built.success(), "{} does not compile", source.display());
    let output = Command::new(program)
        .args([fmus.compile("controller"), fmus.compile("integrator")])
        .args([STEPS.to_string(), REPEATS.to_string()])
        .output()
        .expect("it starts");
    let message = String::from_utf8_lossy(&output.stdout);
    message
        .trim()
        .parse()
        .unwrap_or_else(|_| panic!("{message}{}", String::from_utf8_lossy(&output.stderr)))
}

fn master(
    fmus: &common::Fmus,
    coupling: Coupling,
    recorder: impl Fn() -> Box<dyn Recorder>,
) -> f64 {
    let (controller, plant) = (fmus.controller(), fmus.integrator());
    let (c, p) = (instance(&controller, "controller"), instance(&plant, "plant"));
    let wiring = Wiring::by_name(&*c, &*p, &["reference[1]"]).expect("a loop");
    let settings = LoopSettings { wiring, coupling, ..LoopSettings::default() };
    let mut closed = Loop::new(c, p, &settings).expect("a loop");
    let signals = Signals::new(&[0.0]).with("reference[1]", &[1.0]);
    let points = Points::uniform(0.0, STEPS as f64 * H, H).expect("points");
    let run = Run::new(points, &signals);
    best(|| {
        closed.run(&run, &mut *recorder()).expect("a run");
    })
}

fn main() {
    let Some(fmus) = common::Fmus::new() else {
        println!("SKIPPED: no C compiler `cc`");
        return;
    };
    let own = bare(&fmus);
    println!("{:<44} {own:6.1} ns", "bare C functions: set + step + get, per FMU");
    let report = |name: &str, cost: f64| {
        println!("{name:<44} {cost:6.1} ns, {:6.1} ns over the FMU's own", cost - own);
    };
    let ours = master(&fmus, Coupling::ControllerFirst, || Box::new(()));
    report("controller first, no record", ours);
    report("side by side, no record", master(&fmus, Coupling::SideBySide, || Box::new(())));
    let memory = || -> Box<dyn Recorder> { Box::new(Memory::new()) };
    report(
        "controller first, 3 columns in memory",
        master(&fmus, Coupling::ControllerFirst, memory),
    );
    match fmpy(&fmus) {
        Some(theirs) => {
            println!("{:<44} {theirs:6.0} ns, {:6.1} times ours", "fmpy, by hand", theirs / ours);
        }
        None => println!("fmpy: skipped, no Python with fmpy (PIEZOLOOP_PYTHON not set)"),
    }
}
