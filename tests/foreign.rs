//! Verdicts of foreign checkers, and our loop in foreign masters: where they couple as ours does,
//! the trajectory is ours.
#![cfg(target_os = "linux")]

use crate::common;

use common::packed::{CONTROLLER, PLANT};
use common::{foreign, piezoloop, root, succeed};
use std::fs;
use std::path::Path;
use std::process::Command;

const STAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/stage.toml");

/// Packs plant and controller and writes a reference that begins at rest at 0: some masters
/// initialise a loop with zeros only.
fn pack_loop(version: &str, folder: &Path) {
    succeed(&["pack", PLANT, "--fmi", version, "-o", "plant.fmu"], folder);
    succeed(&["pack", CONTROLLER, "--fmi", version, "-o", "controller.fmu"], folder);
    let mut text = String::from("time,reference[1],reference[2]\n");
    for k in 0..2001 {
        let t = f64::from(k) * 20e-6;
        let wave = 1.0 - (2.0 * std::f64::consts::PI * 50.0 * t).cos();
        text += &format!("{t},{wave},{}\n", 1.5 * wave);
    }
    fs::write(folder.join("reference.csv"), text).expect("the folder is writable");
}

/// Our run of the loop, in run.csv.
fn our_run(coupling: &str, plant: &str, controller: &str, folder: &Path) {
    let files = ["simulate", "--loop", plant, controller, "--reference", "reference.csv"];
    let rest = ["--coupling", coupling, "-o", "run.csv"];
    succeed(&[&files[..], &rest[..]].concat(), folder);
}

#[test]
fn fmutool_has_nothing_to_say_against_our_fmus() {
    let Some(python) = foreign::python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for blueprint in [PLANT, CONTROLLER, STAGE] {
        for version in ["2", "3"] {
            let file = format!("{version}.fmu");
            succeed(&["pack", blueprint, "--fmi", version, "-o", &file], folder.path());
            let mut fmutool = foreign::tool(python, "fmutool");
            let message =
                foreign::message(fmutool.args(["-check", "-input", &file]), folder.path());
            assert!(
                message.contains(&format!("seems to be compliant with FMI-{version}.0")),
                "{message}"
            );
            assert!(message.contains("No semantic error"), "{message}");
            assert!(!message.contains("WARNING") && !message.contains("ERROR"), "{message}");
        }
    }
}

#[test]
fn the_loop_in_fmucontainer_is_ours() {
    let Some(python) = foreign::python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    for version in ["2", "3"] {
        pack_loop(version, folder.path());
        for coupling in ["side-by-side", "controller-first"] {
            our_run(coupling, "plant.fmu", "controller.fmu", folder.path());
            let arguments = [coupling, version];
            let script = "loop_in_fmucontainer.py";
            let message = foreign::script(python, script, &arguments, folder.path());
            // The container says these whatever is in it, through the wrong level of its log.
            let banner = ["FMUContainer 'V2.0'", "Solver configure....", "Container use "];
            for line in message.lines().filter(|line| line.starts_with('[')) {
                assert!(banner.iter().any(|words| line.contains(words)), "{message}");
            }
            message.lines().filter(|l| !l.starts_with('[')).for_each(|line| println!("{line}"));
            run_container(version, folder.path());
        }
    }
}

/// Our master runs the toolbox's container as it is, though its description of FMI 3.0 breaks the
/// schema, which our checker tells.
fn run_container(version: &str, folder: &Path) {
    let reference = fs::read_to_string(folder.join("reference.csv")).expect("the reference");
    fs::write(folder.join("r.csv"), reference.replace("reference", "r")).expect("written");
    succeed(&["simulate", "loop.fmu", "--log", "r.csv", "-o", "container.csv"], folder);
    let (ours, theirs) = (numbers(folder, "run.csv"), numbers(folder, "container.csv"));
    assert_eq!(ours.len(), theirs.len());
    for (ours, theirs) in ours.iter().zip(&theirs) {
        // The positions are the last two columns of both.
        assert_eq!(ours[ours.len() - 2..], theirs[theirs.len() - 2..]);
    }
    let message = piezoloop(&["check", "loop.fmu"], folder);
    assert_eq!(message.status.success(), version == "2");
    let text = String::from_utf8_lossy(&message.stdout);
    assert_eq!(text.contains("<Start> stands in <Float64>"), version == "3", "{text}");
}

/// The rows of a record.
fn numbers(folder: &Path, file: &str) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(folder.join(file)).expect("a record");
    let number = |cell: &str| cell.parse().expect("a number");
    text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect()
}

#[test]
fn the_loop_in_ecos_is_ours() {
    let Some(python) = foreign::python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    pack_loop("2", folder.path());
    our_run("side-by-side", "plant.fmu", "controller.fmu", folder.path());
    print!("{}", foreign::script(python, "loop_in_ecos.py", &[], folder.path()));
}

#[test]
fn the_loop_in_fmpy_ssp_is_ours_with_its_delays() {
    let folder = tempfile::tempdir().expect("a folder");
    pack_loop("2", folder.path());
    our_run("side-by-side", "plant.fmu", "controller.fmu", folder.path());
    let python = common::python::python();
    print!("{}", foreign::script(&python, "loop_in_fmpy_ssp.py", &[], folder.path()));
    // The system file that our tool writes serves as well as one that is written by hand.
    write_system(folder.path(), ["", ""]);
    succeed(&["system", "loop.toml", "--export", "ours.ssp"], folder.path());
    print!("{}", foreign::script(&python, "loop_in_fmpy_ssp.py", &["ours.ssp"], folder.path()));
}

/// The loop as a system in loop.toml, with further settings of controller and plant.
fn write_system(folder: &Path, further: [&str; 2]) {
    let connected = |to: &str, from: &str| {
        (1..3).map(|i| format!("\"{to}[{i}]\" = \"{from}[{i}]\"\n")).collect::<String>()
    };
    let text = format!(
        "name = \"loop\"\nstep = 20e-6\nalgorithm = \"jacobi\"\n[fmus]\n\
         controller = {{ file = \"controller.fmu\"{} }}\nplant = {{ file = \"plant.fmu\"{} }}\n\
         [connections]\n{}{}[inputs]\n{}[record]\n{}",
        further[0],
        further[1],
        connected("plant.command", "controller.command"),
        connected("controller.measured", "plant.position"),
        connected("controller.reference", "reference"),
        connected("position", "plant.position"),
    );
    fs::write(folder.join("loop.toml"), text).expect("the folder is writable");
}

#[test]
fn pyssp_standard_finds_our_systems_compliant() {
    let Some(python) = foreign::python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    write_system(
        folder.path(),
        [
            ", start = { \"axis[1].pid.kp\" = 3.0 }",
            ", start = { \"axis[1].mechanics.damping\" = 0.01 }",
        ],
    );
    for version in ["2", "3"] {
        succeed(&["pack", PLANT, "--fmi", version, "-o", "plant.fmu"], folder.path());
        succeed(&["pack", CONTROLLER, "--fmi", version, "-o", "controller.fmu"], folder.path());
        let file = format!("loop{version}.ssp");
        succeed(&["system", "loop.toml", "--export", &file], folder.path());
        let message = foreign::script(python, "ssp_in_pyssp.py", &[&file], folder.path());
        assert_eq!(message, format!("pyssp-standard, {file}: compliant\n"));
    }
}

/// PythonFMU's libraries do not name the interpreter that they need, so it is loaded before.
fn interpreter_library(python: &Path, folder: &Path) -> Option<String> {
    let code = "import sysconfig as s; v = s.get_config_var; \
                print(f\"{v('LIBDIR')}/{v('INSTSONAME')}\" if v('Py_ENABLE_SHARED') else '')";
    let message = foreign::message(Command::new(python).args(["-c", code]), folder);
    Some(message.trim().to_owned()).filter(|path| Path::new(path).is_file())
}

#[test]
fn a_controller_of_pythonfmu_runs_in_our_master() {
    let Some(python) = foreign::python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let Some(library) = interpreter_library(python, folder.path()) else {
        println!("SKIPPED: this Python has no shared library for PythonFMU's FMUs");
        return;
    };
    succeed(&["pack", STAGE, "-o", "stage.fmu"], folder.path());
    let law = root().join("tests/python/integral_law.py");
    let mut build = foreign::tool(python, "pythonfmu");
    foreign::message(build.args(["build", "-f"]).arg(law), folder.path());
    let mut text = String::from("time,reference[1]\n");
    for k in 0..1001 {
        let t = f64::from(k) * 50e-6;
        text += &format!("{t},{}\n", 2.0 * (150.0 * t).sin());
    }
    fs::write(folder.path().join("reference.csv"), text).expect("the folder is writable");
    let mut ours = Command::new(env!("CARGO_BIN_EXE_piezoloop"));
    ours.args(["simulate", "--loop", "stage.fmu", "IntegralLaw.fmu"]);
    ours.args(["--reference", "reference.csv", "--coupling", "controller-first"]);
    ours.args(["--step", "50e-6", "-o", "run.csv"]);
    let packages = foreign::message(
        Command::new(python).args(["-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]),
        folder.path(),
    );
    ours.env("LD_PRELOAD", library).env("PYTHONPATH", packages.trim());
    foreign::message(&mut ours, folder.path());
    print!("{}", foreign::script(python, "law_by_hand.py", &[], folder.path()));
}

#[test]
fn a_life_in_fmpys_low_level_classes_is_the_same_in_both_versions() {
    let folder = tempfile::tempdir().expect("a folder");
    for version in ["2", "3"] {
        let file = format!("plant{version}.fmu");
        succeed(&["pack", PLANT, "--fmi", version, "-o", &file], folder.path());
    }
    let python = common::python::python();
    let message = foreign::script(&python, "life_in_fmpy.py", &[], folder.path());
    // Messages about events are welcome, about anything else are not.
    for line in message.lines().filter(|line| line.starts_with('[')) {
        assert!(line.starts_with("[OK]"), "{message}");
    }
    println!("{}", message.lines().last().unwrap_or_default());
}
