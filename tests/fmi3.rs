//! FMUs of FMI 3.0: axes and array parameters are arrays, and everything computes the bits of the
//! FMU of FMI 2.0 with its scalars; in fmpy and in our master.

use crate::common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::{json, python, succeed};

/// Packs rig evc and its controller for both versions: `plant2.fmu`, `plant3.fmu`, ….
fn pack_both(folder: &Path) {
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    for version in ["2", "3"] {
        for (blueprint, name) in [("evc", "plant"), ("controller.toml", "controller")] {
            let file = format!("{name}{version}.fmu");
            succeed(&["pack", blueprint, "--fmi", version, "-o", &file], folder);
        }
    }
}

/// A log of two commands on the internal grid of the rig: sums of sines that reach every play.
fn write_commands(folder: &Path) {
    let mut text = String::from("time,\"command[1]\",\"command[2]\"\n");
    for k in 0..2000 {
        let t = f64::from(k) * 20e-6;
        let first = 60.0 - 50.0 * (2.0 * std::f64::consts::PI * 37.0 * t).cos();
        let second = 50.0 + 30.0 * (311.0 * t).sin() + 10.0 * (4110.0 * t).sin();
        let _ = writeln!(text, "{t},{first},{second}");
    }
    fs::write(folder.join("commands.csv"), text).expect("the folder is writable");
}

#[test]
fn fmpy_and_our_checker_find_nothing_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    pack_both(folder.path());
    let files = ["plant3.fmu", "controller3.fmu"];
    let code = r#"
import sys
import zipfile
from fmpy import read_model_description
from fmpy.validation import validate_fmu
for name in sys.argv[1:]:
    for problem in validate_fmu(name):
        print(name, problem)
    description = read_model_description(name)
    with zipfile.ZipFile(name) as archive:
        assert b'providesDirectionalDerivatives="true"' in archive.read("modelDescription.xml")
    shapes = {v.name: v.shape for v in description.modelVariables}
    if "plant" in name:
        assert shapes["command"] == shapes["position"] == (2,), shapes
        assert shapes["axis[1].hysteresis.w"] == shapes["axis[2].hysteresis.r"] == (10,), shapes
    else:
        assert shapes["reference"] == shapes["measured"] == shapes["command"] == (2,), shapes
        assert shapes["enable"] == (), shapes
"#;
    assert_eq!(python::script(code, &files, folder.path()).trim(), "");
    for file in files {
        println!("{}", succeed(&["check", file], folder.path()));
    }
}

#[test]
fn fmpy_simulates_arrays_to_the_bits_of_the_scalars() {
    let folder = tempfile::tempdir().expect("a folder");
    pack_both(folder.path());
    write_commands(folder.path());
    let code = r#"
import numpy as np
from fmpy import simulate_fmu
from fmpy.util import read_csv
log = read_csv("commands.csv")
both = np.stack([log["command[1]"], log["command[2]"]], axis=1)
arrays = np.array([(t, u) for t, u in zip(log["time"], both)],
                  dtype=[("time", float), ("command", float, (2,))])
settings = dict(stop_time=0.03, output_interval=20e-6)
w = [0.02] * 10
two = simulate_fmu("plant2.fmu", input=log, **settings,
                   start_values={f"axis[2].hysteresis.w[{i + 1}]": w[i] for i in range(10)})
three = simulate_fmu("plant3.fmu", input=arrays, **settings,
                     start_values={"axis[2].hysteresis.w": w})
assert three["position"].shape == (len(two), 2)
for i in (0, 1):
    wanted = two[f"position[{i + 1}]"]
    print(f"position[{i + 1}] moves by", np.ptp(wanted))
    assert np.ptp(wanted) > 0.5
    assert (three["position"][:, i] == wanted).all()
"#;
    println!("{}", python::script(code, &[], folder.path()));
}

#[test]
fn fmpys_low_level_classes_meet_arrays_of_exact_size() {
    let folder = tempfile::tempdir().expect("a folder");
    pack_both(folder.path());
    let code = r#"
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

def instantiate(name, kind):
    folder, description = extract(name), read_model_description(name)
    fmu = kind(guid=description.guid, unzipDirectory=folder,
               modelIdentifier=description.coSimulation.modelIdentifier, instanceName=name)
    fmu.instantiate()
    return fmu, {v.name: v.valueReference for v in description.modelVariables}

two, r2 = instantiate("plant2.fmu", FMU2Slave)
three, r3 = instantiate("plant3.fmu", FMU3Slave)
two.setupExperiment(startTime=1.0)
two.enterInitializationMode()
three.enterInitializationMode(startTime=1.0)
u2, y2 = [r2["command[1]"], r2["command[2]"]], [r2["position[1]"], r2["position[2]"]]
u3, y3 = [r3["command"]], [r3["position"]]

def same(what):
    a, b = two.getReal(y2), three.getFloat64(y3, nValues=2)
    assert a == b, (what, a, b)
    seed = [1.0, -0.5]
    a = two.getDirectionalDerivative(y2, u2, seed)
    b = three.getDirectionalDerivative(y3, u3, seed, nSensitivity=2)
    assert list(a) == list(b) and any(a), (what, a, b)

two.setReal(u2, [20.0, 30.0])
three.setFloat64(u3, [20.0, 30.0])
same("in initialization mode")
two.exitInitializationMode()
three.exitInitializationMode()
same("after initialization")
h = 20e-6
for k in range(200):
    u = [20.0 + k % 60, 30.0 + 0.1 * k]
    two.setReal(u2, u)
    three.setFloat64(u3, u)
    two.doStep(1.0 + k * h, h)
    flags = three.doStep(1.0 + k * h, h)
    assert flags[:3] == (False, False, False), flags
    same(k)

weights = r3["axis[1].hysteresis.w"]
assert three.getFloat64([weights], nValues=10) == [
    two.getReal([r2[f"axis[1].hysteresis.w[{i}]"]])[0] for i in range(1, 11)]
state = three.getFMUState()
for count in (0, 1, 3):
    try:
        three.getFloat64(y3, nValues=count)
    except FMICallException as error:
        three.setFMUState(state)
    else:
        raise AssertionError(f"{count} values of an array of 2")
for references, values in ((u3, [1.0]), (u3, [1.0, 2.0, 3.0]), ([u3[0] + 1], [1.0])):
    try:
        three.setFloat64(references, values)
    except FMICallException:
        three.setFMUState(state)
    else:
        raise AssertionError((references, values))
same("after refusals")
three.terminate()
assert len(three.getFloat64(y3, nValues=2)) == 2
three.freeInstance()
"#;
    println!("{}", python::script(code, &[], folder.path()));
}

/// The rows of a CSV file, without its header.
fn rows(folder: &Path, file: &str) -> Vec<String> {
    let text = fs::read_to_string(folder.join(file)).expect("the run was written");
    text.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn our_master_drives_elements_of_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    pack_both(folder.path());
    write_commands(folder.path());
    let simulate = |version: &str, further: &[&str]| {
        let (fmu, out) = (format!("plant{version}.fmu"), format!("run{version}.csv"));
        let mut arguments = vec!["simulate", &fmu, "--log", "commands.csv", "-o", &out];
        arguments.extend(further);
        succeed(&arguments, folder.path());
        fs::read_to_string(folder.path().join(out)).expect("the run was written")
    };
    let weight = ["--start", "axis[2].hysteresis.w[3]=0.1"];
    let one_axis = ["--map", "command[2]=command[1]"];
    let by_short_name = ["--map", "u_z=command[1]"];
    let plain = simulate("2", &[]);
    for further in [&[][..], &weight, &one_axis, &by_short_name] {
        let (two, three) = (simulate("2", further), simulate("3", further));
        assert!(two.contains("position[2]"), "{}", two.lines().next().unwrap_or_default());
        assert_eq!(two, three, "{further:?}");
        assert_eq!(further.is_empty(), two == plain, "{further:?} has an effect");
    }
}

#[test]
fn our_master_closes_the_loop_over_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    pack_both(folder.path());
    let mut text = String::from("time,reference[1],reference[2]\n");
    for k in 0..1000 {
        let t = f64::from(k) * 20e-6;
        let (sine, cosine) = (2.0 * std::f64::consts::PI * 100.0 * t).sin_cos();
        let _ = writeln!(text, "{t},{},{}", 2.0 - 2.0 * cosine, 3.0 + sine);
    }
    fs::write(folder.path().join("reference.csv"), text).expect("the folder is writable");
    for (plant, controller) in [("2", "2"), ("3", "3"), ("2", "3"), ("3", "2")] {
        let (plant_file, controller_file) =
            (format!("plant{plant}.fmu"), format!("controller{controller}.fmu"));
        let out = format!("loop{plant}{controller}.csv");
        let files = [plant_file.as_str(), controller_file.as_str()];
        let mut arguments = vec!["simulate", "--loop"];
        arguments.extend(files);
        arguments.extend(["--reference", "reference.csv", "-o", &out]);
        succeed(&arguments, folder.path());
        assert_eq!(rows(folder.path(), "loop22.csv"), rows(folder.path(), &out), "{out}");
    }
    let first = rows(folder.path(), "loop22.csv");
    assert!(first.len() >= 1000 && first[0] != first[999]);
}

/// A hysteresis of two play operators alone: its derivatives are sums of weights.
const HYSTERESIS: &str = r#"
piezoloop = 1
kind = "plant"
name = "plays"
step = 1e-3
[[axis]]
name = "Y"
command = { unit = "V", min = -20, max = 120 }
position = { unit = "um" }
[[axis.component]]
type = "prandtl-ishlinskii"
r = [0, 4]
w = [0.02, 0.03]
"#;

#[test]
fn derivatives_of_a_hysteresis_are_the_weights_of_the_plays_that_move() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("plays.toml"), HYSTERESIS).expect("the folder is writable");
    succeed(&["pack", "plays.toml", "-o", "plays.fmu"], folder.path());
    let code = r#"
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
description = read_model_description("plays.fmu")
assert description.coSimulation.providesDirectionalDerivative
fmu = FMU2Slave(guid=description.guid, unzipDirectory=extract("plays.fmu"),
                modelIdentifier=description.coSimulation.modelIdentifier, instanceName="plays")
r = {v.name: v.valueReference for v in description.modelVariables}
fmu.instantiate()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.exitInitializationMode()
u, y = [r["command[1]"]], [r["position[1]"]]
both, first = 0.05, 0.02
# Command, derivative upwards and downwards: rising, held, turned, turned by both edges, falling.
time = 0.0
for command, up, down in ((20.0, both, both), (20.0, both, first), (15.0, first, first),
                          (12.0, first, both), (5.0, both, both)):
    fmu.setReal(u, [command])
    fmu.doStep(time, 1e-3)
    time += 1e-3
    found = (fmu.getDirectionalDerivative(y, u, [1.0])[0],
             -fmu.getDirectionalDerivative(y, u, [-1.0])[0])
    print(command, found)
    assert all(abs(a - b) < 1e-10 for a, b in zip(found, (up, down))), (command, found, up, down)
"#;
    println!("{}", python::script(code, &[], folder.path()));
}

#[test]
fn the_tool_tells_the_version() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = json(&["pack", "evc", "--fmi", "3", "-o", "evc.fmu"], folder.path());
    assert_eq!(message["fmi_version"], "3.0");
}

/// One axis is an array of one; fmpy took its short name for a second variable.
#[test]
fn fmpy_finds_nothing_wrong_with_one_axis() {
    let folder = tempfile::tempdir().expect("a folder");
    for rig in ["p885", "p1", "p2", "p3"] {
        succeed(&["pack", rig, "--fmi", "3", "-o", "one.fmu"], folder.path());
        let code = "from fmpy.validation import validate_fmu; print(validate_fmu('one.fmu'))";
        assert_eq!(python::script(code, &[], folder.path()).trim(), "[]", "{rig}");
    }
}
