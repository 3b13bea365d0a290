//! Systems from files: TOML and SSP say the same, and every problem is told with its line.
#![allow(clippy::print_stdout)]

use crate::common;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{Fmus, instance};
use cosim::plan::Coupling;
use cosim::{Fmu, Memory, Plan, Points, Run, Signals};
use modeldescription::ModelDescription;

/// The closed loop in TOML, beside its FMUs.
fn write_loop(fmus: &Fmus, algorithm: &str) -> PathBuf {
    fmus.pack("controller", &common::controller());
    fmus.pack("integrator", &common::integrator());
    let text = format!(
        "name = \"closed loop\"\nstep = 0.01\nstop = 2.0\nalgorithm = \"{algorithm}\"\n\n[fmus]\n\
         controller = {{ file = \"controller é.fmu\", start = {{ k = 5.0 }} }}\n\
         plant = \"integrator é.fmu\"\n\n[connections]\n\
         \"plant.command[1]\" = {{ from = \"controller.command[1]\", factor = 0.5 }}\n\
         \"controller.measured[1]\" = \"plant.position[1]\"\n\n[inputs]\n\
         \"controller.reference[1]\" = \"r\"\n\n[record]\nposition = \"plant.position[1]\"\n\
         command = \"plant.command[1]\"\n"
    );
    let path = fmus.path("loop.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn open(plan: &Plan) -> Vec<Fmu> {
    plan.fmus.iter().map(|fmu| Fmu::open(&fmu.path).unwrap()).collect()
}

fn run(plan: &Plan, rows: &[(f64, f64)]) -> Memory {
    let fmus = open(plan);
    let slaves = plan.fmus.iter().zip(&fmus).map(|(p, fmu)| instance(fmu, &p.name)).collect();
    let step = plan.master.step.unwrap();
    let mut prepared = plan.prepare(slaves, step, &[]).unwrap();
    assert_eq!(prepared.notes, Vec::<String>::new());
    let (time, values): (Vec<f64>, Vec<f64>) = rows.iter().copied().unzip();
    let signals = Signals::new(&time).with("r", &values);
    let points = Points::uniform(0.0, plan.master.stop.unwrap(), step).unwrap();
    let run = Run::new(points, &signals);
    let mut memory = Memory::new();
    prepared.system.run(&run, &*prepared.algorithm, &mut memory).unwrap();
    memory
}

#[test]
fn a_system_of_toml_is_an_ssp_and_runs_the_same() {
    let fmus = fmus_or_skip!();
    for algorithm in ["gauss-seidel", "jacobi", "iteration"] {
        let plan = Plan::read(write_loop(&fmus, algorithm)).unwrap();
        assert_eq!(plan.master.coupling.name(), algorithm);
        let memory = run(&plan, &[(0.0, 1.0)]);
        let position = memory.values("position").unwrap();
        assert!((position[200] - 1.0).abs() < 0.02, "{}", position[200]);
        if plan.master.coupling == Coupling::GaussSeidel {
            // u = 0.5 · 5 (1 − y), at once.
            let expected = 1.0 - (1.0_f64 - 0.01 * 2.5).powi(200);
            assert!((position[200] - expected).abs() < 1e-12);
        }

        let ssp = fmus.path("loop.ssp");
        let opened = open(&plan);
        let descriptions: Vec<&ModelDescription> = opened.iter().map(Fmu::description).collect();
        plan.export_ssp(&ssp, &descriptions).unwrap();
        let read = Plan::read(&ssp).unwrap();
        assert_eq!(read.master.coupling, plan.master.coupling);
        assert_eq!(read.master, plan.master);
        assert_eq!(read.columns(), ["r"]);
        assert_eq!(run(&read, &[(0.0, 1.0)]), memory, "{algorithm}");
    }
}

#[test]
fn every_problem_of_a_toml_is_reported_with_its_line() {
    let text = "nam = \"x\"\nstep = 0\nalgorithm = \"euler\"\norder = 3\n[fmus]\na = \"a.fmu\"\n\
                b = { fil = \"b.fmu\" }\n[connections]\n\"a.u\" = \"c.y\"\n\"d.u\" = \"a.y\"\n\
                \"a.v\" = { factor = \"two\" }\n[inputs]\n\"a.w\" = 3\n[record]\nx = \"a\"\n";
    let error = Plan::parse_toml(text, Path::new("loop.toml")).unwrap_err().to_string();
    for (line, words) in [
        (1, "nam: is no key; did you mean name?"),
        (2, "step = 0: must be greater than 0 s"),
        (3, "algorithm = euler: must be \"gauss-seidel\""),
        (4, "order: must be a list of names"),
        (7, "fmus.b.fil: is no key; did you mean file?"),
        (7, "fmus.b: names no file"),
        (9, "c.y: must be fmu.variable with one of the FMUs a"),
        (10, "d.u: must be fmu.variable"),
        (11, "factor: must be a finite number"),
        (11, "has no source"),
        (13, "inputs: must be a text"),
        (15, "record = a: must be fmu.variable"),
    ] {
        let place = format!("loop.toml:{line}: ");
        let hit = error.lines().any(|text| text.starts_with(&place) && text.contains(words));
        assert!(hit, "{place}{words} is not in\n{error}");
    }
    let broken = Plan::parse_toml("a = [\nb", Path::new("loop.toml")).unwrap_err().to_string();
    assert!(broken.contains("loop.toml:2: ") && broken.contains("is not valid TOML"), "{broken}");
    let empty = Plan::parse_toml("name = \"x\"", Path::new("x.toml")).unwrap_err().to_string();
    assert!(empty.contains("a system has FMUs"), "{empty}");
}

#[test]
fn variables_and_steps_are_checked_when_a_system_is_prepared() {
    let fmus = fmus_or_skip!();
    let path = write_loop(&fmus, "jacobi");
    let text = std::fs::read_to_string(&path)
        .unwrap()
        .replace("start = { k = 5.0 }", "step = 0.025, start = { q = 1, k = \"x\" }")
        .replace("\"plant.position[1]\"\n\n", "\"plant.positon[1]\"\n\n");
    let plan = Plan::parse_toml(&text, &path).unwrap();
    let opened = open(&plan);
    let slaves = plan.fmus.iter().zip(&opened).map(|(p, fmu)| instance(fmu, &p.name)).collect();
    let error = plan.prepare(slaves, 0.01, &[]).err().unwrap().to_string();
    for words in [
        "FMU `controller` has no variable `q`",
        "value \"x\" for variable `k`",
        "no variable `positon[1]`; did you mean `position[1]`?",
        "FMU `controller` steps over 0.025 s, which is no multiple of the communication step",
    ] {
        assert!(error.contains(words), "{words} is not in\n{error}");
    }
}

fn python() -> Option<PathBuf> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?;
    let own = || workspace.join("target/python-env/bin/python");
    let python = std::env::var_os("PIEZOLOOP_PYTHON").map_or_else(own, PathBuf::from);
    let found = Command::new(&python).args(["-c", "import fmpy.ssp"]).output().ok()?;
    found.status.success().then_some(python)
}

/// fmpy's runner couples side by side, starts connectors at 0 and hands inputs on one step late.
#[test]
fn the_runner_of_fmpy_gives_our_trajectory() {
    let fmus = fmus_or_skip!();
    let Some(python) = python() else {
        println!("SKIPPED: no Python with fmpy (PIEZOLOOP_PYTHON not set)");
        return;
    };
    let path = write_loop(&fmus, "jacobi");
    // fmpy does not know scaled connections and ignores parameter bindings.
    let text = std::fs::read_to_string(&path).unwrap();
    let text = text.replace(", factor = 0.5", "").replace(", start = { k = 5.0 }", "");
    let plan = Plan::parse_toml(&text, &path).unwrap();
    let opened = open(&plan);
    let descriptions: Vec<&ModelDescription> = opened.iter().map(Fmu::description).collect();
    let ssp = fmus.path("plain.ssp");
    plan.export_ssp(&ssp, &descriptions).unwrap();
    let script = "import sys\nfrom fmpy.ssp.simulation import simulate_ssp\n\
                  rows = simulate_ssp(sys.argv[1], stop_time=2.0, step_size=0.01, \
                  input={'r': lambda t: 1.0})\n\
                  print('row', *[repr(float(x)) for x in rows['plant.position[1]']])\n";
    let output = Command::new(python).args(["-c", script]).arg(&ssp).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let row = text.lines().find_map(|line| line.strip_prefix("row ")).expect("a row");
    let theirs: Vec<f64> = row.split(' ').map(|x| x.parse().unwrap()).collect();
    // Row k of fmpy is the state after step k; its reference arrives at the second step.
    let ours = run(&Plan::read(&ssp).unwrap(), &[(0.0, 0.0), (0.01, 1.0)]);
    let ours = ours.values("position").unwrap();
    for (k, y) in theirs.iter().enumerate().take(ours.len() - 1) {
        assert!((y - ours[k + 1]).abs() <= 1e-9, "row {k}: fmpy {y}, ours {}", ours[k + 1]);
    }
    assert!(theirs.len() >= 200);
}
