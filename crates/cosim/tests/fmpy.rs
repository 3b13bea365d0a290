//! The same runs in fmpy: one FMU driven by a table, the closed loop by hand.
#![allow(clippy::print_stdout)]

use crate::common;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::instance;
use cosim::{
    Coupling, Drive, Fmu, Loop, LoopSettings, Memory, Points, Run, Signals, Value, Wiring,
    simulate_with_inputs,
};

/// The Python of the tests' environment, if it has fmpy.
fn python() -> Option<PathBuf> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?;
    let own = || workspace.join("target/python-env/bin/python");
    let python = std::env::var_os("PIEZOLOOP_PYTHON").map_or_else(own, PathBuf::from);
    let found = Command::new(&python).args(["-c", "import fmpy"]).output().ok()?.status.success();
    found.then_some(python)
}

macro_rules! python_or_skip {
    () => {
        match python() {
            Some(python) => python,
            None => {
                println!("SKIPPED: no Python with fmpy (PIEZOLOOP_PYTHON not set)");
                return;
            }
        }
    };
}

fn reference(python: &Path, arguments: &[&OsStr]) -> Vec<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference.py");
    let output = Command::new(python).arg(script).args(arguments).output().expect("Python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8").lines().map(str::to_owned).collect()
}

/// The numbers of the lines that begin with `row`; fmpy prints warnings too.
fn rows(lines: &[String]) -> Vec<Vec<f64>> {
    let numbers = |row: &str| row.split(',').map(|cell| cell.parse().expect("a number")).collect();
    lines.iter().filter_map(|line| line.strip_prefix("row ")).map(numbers).collect()
}

#[test]
fn a_driven_fmu_gives_the_values_and_the_calls_of_simulate_fmu() {
    let (fmus, python) = (fmus_or_skip!(), python_or_skip!());
    let count = 200;
    let time: Vec<f64> = (0..count).map(|k| f64::from(k) * 1e-2).collect();
    let u: Vec<f64> = (0..count).map(|k| (0.7 * f64::from(k)).sin()).collect();
    let path = fmus.pack("integrator", &common::integrator());
    let table = fmus.path("table.csv");
    let mut text = "time,command[1]\n".to_owned();
    time.iter().zip(&u).for_each(|(t, u)| text += &format!("{t:?},{u:?}\n"));
    std::fs::write(&table, text).unwrap();
    let lines = reference(&python, &["drive".as_ref(), path.as_ref(), table.as_ref()]);

    let fmu = Fmu::open(&path).unwrap();
    let drive = Drive { parameters: vec![("k".to_owned(), Value::Real(3.0))], ..Drive::default() };
    let signals = Signals::new(&time).with("command[1]", &u);
    let mut memory = Memory::new();
    simulate_with_inputs(instance(&fmu, "plant"), &[signals], &drive, &mut memory).unwrap();

    // The calls of fmpy.simulate_fmu, as the FMU noted them.
    let calls = lines.iter().find_map(|line| line.strip_prefix("history ")).expect("the calls");
    let ours = "srerxg".to_owned() + &"rdg".repeat(count as usize - 1) + "t";
    assert_eq!(calls, &ours[..calls.len()]);
    assert_eq!(calls.len(), 255, "as many as the FMU notes");

    let theirs = rows(&lines);
    assert_eq!(theirs.len(), memory.time().len());
    let position = memory.values("position[1]").unwrap();
    for ((row, t), y) in theirs.iter().zip(memory.time()).zip(position) {
        assert!((row[0] - t).abs() <= 1e-12 * t.abs().max(1.0));
        assert!((row[1] - y).abs() <= 1e-12, "fmpy {} ours {y} at {t}", row[1]);
    }
}

#[test]
fn the_closed_loop_by_hand_in_fmpy_is_ours() {
    let (fmus, python) = (fmus_or_skip!(), python_or_skip!());
    let (controller, plant) = (
        fmus.pack("controller", &common::controller()),
        fmus.pack("integrator", &common::integrator()),
    );
    let (step, steps, gain) = (1e-3, 300, 25.0);
    let time: Vec<f64> = (0..=steps).map(|k| f64::from(k) * step).collect();
    let reference_signal: Vec<f64> = (0..=steps).map(|k| (0.3 * f64::from(k)).sin()).collect();
    for (coupling, word) in
        [(Coupling::ControllerFirst, "controller-first"), (Coupling::SideBySide, "side-by-side")]
    {
        let numbers_of_run = [step.to_string(), steps.to_string(), gain.to_string()];
        let [a, b, c] = numbers_of_run.each_ref();
        let arguments: [&OsStr; 7] = [
            "loop".as_ref(),
            controller.as_ref(),
            plant.as_ref(),
            a.as_ref(),
            b.as_ref(),
            c.as_ref(),
            word.as_ref(),
        ];
        let lines = reference(&python, &arguments);

        let (c, p) = (Fmu::open(&controller).unwrap(), Fmu::open(&plant).unwrap());
        let (c, p) = (instance(&c, "controller"), instance(&p, "plant"));
        let wiring = Wiring::by_name(&*c, &*p, &["reference[1]"]).unwrap();
        let parameters = vec![("controller".to_owned(), "k".to_owned(), gain.into())];
        let settings = LoopSettings { wiring, coupling, parameters, ..LoopSettings::default() };
        let mut closed = Loop::new(c, p, &settings).unwrap();
        let signals = Signals::new(&time).with("reference[1]", &reference_signal);
        let points = Points::uniform(0.0, f64::from(steps) * step, step).unwrap();
        let run = Run::new(points, &signals);
        let mut memory = Memory::new();
        closed.run(&run, &mut memory).unwrap();

        let theirs = rows(&lines);
        assert_eq!(theirs.len(), steps as usize);
        let (u, y) = (memory.values("command[1]").unwrap(), memory.values("position[1]").unwrap());
        for (k, row) in theirs.iter().enumerate() {
            let close = |ours: f64, theirs: f64| (ours - theirs).abs() <= 1e-12 * gain;
            assert!(close(u[k], row[0]) && close(y[k], row[1]), "{word}, row {k}: {row:?}");
        }
    }
}
