//! The repaired FMU: valid, alone in a foreign importer, nearer to the machine, and with its effects
//! switched off the original to the bit. Over our FMUs, over one in C, over one of PythonFMU, and
//! over a repaired one.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;

use common::packed::{CONTROLLER, Host, Packed, compile_library, with};
use common::repaired::{STEP, effects, measure, measure_lag, repair};
use common::{foreign, json, piezoloop, python, refuse, succeed};
use modeldescription::{ModelDescription, Package, PackageBuilder};
use serde_json::Value;

const STAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/stage.toml");
const PLANT_PORTS: (&str, &str) = ("command[1]", "position[1]");
const C_PORTS: (&str, &str) = ("u", "y");

/// Simulates the FMUs given as arguments in fmpy over both logs and prints the rms of each against
/// the measured reading as JSON, and whether their outputs have the same bits. The second of the
/// FMUs, if there is one, has all its effects switched off.
const COMPARE: &str = r#"
import json, sys
import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
first, second, u, y, step = sys.argv[1:]
known = [str(p) for p in validate_fmu(first)]
out = {"problems": [str(p) for p in validate_fmu(second) if str(p) not in known], "rms": {}, "off": {}, "same": True}
own = {v.name for v in read_model_description(first).modelVariables}
off = {v.name: False for v in read_model_description(second).modelVariables
       if v.name.endswith(".enabled") and v.name not in own}
out["switches"] = sorted(off)
for name in ("multisine", "stairs"):
    t, command, reading = np.loadtxt(name + ".csv", delimiter=",", skiprows=1, unpack=True)
    table = np.array(list(zip(t, command)), dtype=[("time", "f8"), (u, "f8")])
    def run(fmu, start):
        result = simulate_fmu(fmu, stop_time=t[-1], step_size=float(step),
                              output_interval=float(step), input=table, output=[y],
                              start_values=start)
        return result[y].reshape(len(result))[:len(t)]
    before, after, without = run(first, {}), run(second, {}), run(second, off)
    rms = lambda r: float(np.sqrt(np.mean((r - r.mean()) ** 2)))
    out["rms"][name] = [rms(reading - before), rms(reading - after)]
    out["same"] &= before.tobytes() == without.tobytes()
print(json.dumps(out))
"#;

/// Holds a repaired FMU against its original in fmpy, and against the noise of 2 nm.
fn compare(original: &str, repaired: &str, (u, y): (&str, &str), folder: &Path) -> Value {
    let step = STEP.to_string();
    let message = python::script(COMPARE, &[original, repaired, u, y, &step], folder);
    let out: Value = serde_json::from_str(message.trim()).expect("a line of JSON");
    println!("{repaired}: {out}");
    assert_eq!(out["problems"], serde_json::json!([]), "fmpy finds no problem");
    assert_eq!(out["same"], true, "switched off it is the original to the bit");
    out
}

/// Before and after, over both logs.
fn rms(out: &Value) -> Vec<(f64, f64)> {
    let all = out["rms"].as_object().expect("figures").values();
    all.map(|pair| (pair[0].as_f64().expect("rms"), pair[1].as_f64().expect("rms"))).collect()
}

fn assert_nearer(out: &Value, noise: f64) {
    for (before, after) in rms(out) {
        assert!(before > 4.0 * after, "{before} before, {after} after");
        assert!(after < 1.5 * noise, "{after} is not the noise of {noise}");
    }
}

/// Our repaired stage.
fn repaired_stage(version: &str) -> (Value, Packed) {
    let folder = tempfile::tempdir().expect("a folder");
    measure(folder.path());
    succeed(&["pack", STAGE, "--fmi", version, "-o", "stage.fmu"], folder.path());
    let gap = repair("stage.fmu", PLANT_PORTS, "repaired.fmu", folder.path());
    let file = folder.path().join("repaired.fmu");
    (gap, Packed::of(file, folder))
}

fn our_stage_repaired(version: &str) {
    let (gap, fmu) = repaired_stage(version);
    assert_eq!(gap["verdict"], "effects", "{}", gap["sentence"]);
    let named = effects(&gap);
    assert!(named.contains(&"creep"), "{named:?}");
    let folder = fmu.file.parent().expect("a folder");
    // What is two scalars in FMI 2.0 is two arrays of one element in FMI 3.0.
    let ports = if version == "3" { ("command", "position") } else { PLANT_PORTS };
    let out = compare("stage.fmu", "repaired.fmu", ports, folder);
    assert_nearer(&out, 2e-3);
    let checked = piezoloop(&["check", "repaired.fmu", "--replay"], folder);
    let message = String::from_utf8_lossy(&checked.stdout);
    assert!(checked.status.success(), "{message}");
    assert!(message.contains("reference results repeated"), "{message}");
    // It explains itself: a page with switches and the original's page, the original's icon.
    let page = fs::read_to_string(fmu.package.folder().join("documentation/index.html"));
    let page = page.expect("a page");
    for words in ["creep.enabled", "own page: resources", "the original"] {
        assert!(page.contains(words), "{words}");
    }
    let icon = if version == "2" { "model.png" } else { "terminalsAndIcons/icon.png" };
    assert!(fmu.package.folder().join(icon).is_file(), "{icon}");
    let described = fmu.package.description();
    assert!(described.version.as_deref().is_some_and(|text| text.ends_with("repaired")));
    assert!(described.generation_date_and_time.is_some() && described.license.is_some());
    // The original travels inside, untouched.
    let mut inner = Vec::new();
    let original = Package::open(folder.join("stage.fmu")).expect("an FMU");
    let inside = fmu.package.resources().join("inner");
    for path in ["modelDescription.xml", "resources/blueprint.toml"] {
        let read = |base: &Path| fs::read(base.join(path)).expect("a file");
        assert_eq!(read(original.folder()), read(&inside), "{path}");
        inner.push(path);
    }
    let repair = fs::read_to_string(fmu.package.resources().join("repair.toml")).expect("a file");
    let hash = python::script(
        "import hashlib; print(hashlib.sha256(open('stage.fmu', 'rb').read()).hexdigest())",
        &[],
        folder,
    );
    assert!(repair.contains(hash.trim()), "the hash of the original's archive is in {repair}");
    // Variables of the original keep name, reference and order.
    let of = |d: &ModelDescription| -> Vec<(String, u32)> {
        d.variables.iter().map(|v| (v.name.clone(), v.value_reference)).collect()
    };
    let (old, new) = (of(original.description()), of(fmu.package.description()));
    assert_eq!(old[..], new[..old.len()]);
    assert!(new.len() > old.len());
    // Our own master steps it to the same readings.
    let simulated = json(
        &[
            "simulate",
            "repaired.fmu",
            "--log",
            "stairs.csv",
            "--map",
            "command[1]=u",
            "--map",
            "position[1]=x",
        ],
        folder,
    );
    let fit = &simulated["fits"][0];
    assert!(fit["raw_rmse"].as_f64().expect("rms") < 0.1, "{fit}");
}

#[test]
fn our_stage_of_fmi_2_is_repaired() {
    our_stage_repaired("2");
}

#[test]
fn our_stage_of_fmi_3_with_arrays_is_repaired() {
    our_stage_repaired("3");
}

#[test]
fn instances_states_threads_and_namesakes() {
    let (_, fmu) = repaired_stage("2");
    // In a host that exports the standard's names and loads with RTLD_GLOBAL.
    let controller = Packed::new(CONTROLLER, "2");
    let plain = Host::new("run.c");
    let alone = plain.run(&fmu.arguments()) + &plain.run(&controller.arguments());
    let mut both = fmu.arguments();
    both.extend(controller.arguments());
    assert_eq!(Host::new("namesakes.c").run(&both), alone);
    // Side by side, and a thousand times one after the other.
    let life = Host::new("life.c");
    print!("repaired: {}", life.run(&with(fmu.arguments(), &["threads"])));
    print!("repaired: {}", life.run(&with(fmu.arguments(), &["1000"])));
    // States come back in another process.
    let state = Host::new("state.c");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("state");
    let file = file.to_str().expect("UTF-8");
    let first = state.run(&with(fmu.arguments(), &["write", file, "0"]));
    let second = state.run(&with(fmu.arguments(), &["read", file, "5"]));
    assert_eq!(first, second);
}

/// Directional derivatives of the output by the input after a step, with all effects and with none,
/// beside what the step does with another input from the same state.
const DERIVATIVE: &str = r#"
import math, sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
file, u, y, step, off = sys.argv[1:]
step, model = float(step), read_model_description(file)
of = {v.name: v.valueReference for v in model.modelVariables}
is_three = model.fmiVersion.startswith("3")
fmu = (FMU3Slave if is_three else FMU2Slave)(
    guid=model.guid, unzipDirectory=extract(file), instanceName="i",
    modelIdentifier=model.coSimulation.modelIdentifier)
fmu.instantiate()
flags = [v for v in model.modelVariables if v.name.endswith(".enabled")]
off = [v.valueReference for v in flags if off in ("all", v.name)]
if off:
    fmu.setBoolean(off, [False] * len(off))
if not is_three:
    fmu.setupExperiment()
fmu.enterInitializationMode()
get, set = (fmu.getFloat64, fmu.setFloat64) if is_three else (fmu.getReal, fmu.setReal)
set([of[u]], [40.0])
before = get([of[y]])[0]
at_rest = fmu.getDirectionalDerivative([of[y]], [of[u]], [2.0])[0]
set([of[u]], [40.0 + 2e-3])
at_rest -= (get([of[y]])[0] - before) / 1e-3
fmu.exitInitializationMode()
worst, sizes = 0.0, []
for k in range(600):
    value = 40 + 25 * math.sin(0.02 * k) + 5 * math.sin(0.11 * k)
    state = fmu.getFMUState()
    set([of[u]], [value])
    fmu.doStep(k * step, step)
    if k % 50 == 7:
        before = get([of[y]])[0]
        # What is set after a step belongs to the next one.
        set([of[u]], [value + 3])
        for direction in (1.0, -2.0):
            slope = fmu.getDirectionalDerivative([of[y]], [of[u]], [direction])[0]
            after = fmu.getFMUState()
            fmu.setFMUState(state)
            e = 1e-3
            set([of[u]], [value + e * direction])
            fmu.doStep(k * step, step)
            quotient = (get([of[y]])[0] - before) / e
            fmu.setFMUState(after)
            fmu.freeFMUState(after)
            sizes.append(abs(quotient))
            worst = max(worst, abs(slope - quotient))
    fmu.freeFMUState(state)
fmu.terminate()
fmu.freeInstance()
print(worst, max(sizes), abs(at_rest))
"#;

#[test]
fn derivatives_go_through_the_effects() {
    for version in ["2", "3"] {
        let (_, fmu) = repaired_stage(version);
        let co_simulation =
            fmu.package.description().co_simulation.as_ref().expect("co-simulation");
        assert!(co_simulation.common.provides_directional_derivatives);
        let folder = fmu.file.parent().expect("a folder");
        let (u, y) = if version == "3" { ("command", "position") } else { PLANT_PORTS };
        // With a delay nothing of a step's input is in the output at its end.
        for (off, moves) in [("none", false), ("delay.enabled", true), ("all", true)] {
            let arguments = ["repaired.fmu", u, y, &STEP.to_string(), off];
            let message = python::script(DERIVATIVE, &arguments, folder);
            println!("FMI {version}, switched off {off}: {message}");
            let figures = message.split_whitespace().map(|f| f.parse().expect("a number"));
            let [worst, size, at_rest] = figures.collect::<Vec<f64>>()[..] else {
                panic!("{message}")
            };
            assert_eq!(size > 1e-6, moves, "{message}");
            assert!(worst <= 1e-6 * size && at_rest < 1e-6, "{message}");
        }
    }
}

#[test]
fn a_repaired_fmu_is_repaired_again() {
    let folder = tempfile::tempdir().expect("a folder");
    measure(folder.path());
    succeed(&["pack", STAGE, "-o", "stage.fmu"], folder.path());
    let one = |model: &str, to: &str| {
        json(
            &[
                "diagnose",
                "--model",
                model,
                "--log",
                "multisine.csv",
                "--log",
                "stairs.csv",
                "--map",
                "command[1]=u",
                "--map",
                "position[1]=x",
                "--max-effects",
                "1",
                "--repair",
                to,
            ],
            folder.path(),
        )
    };
    let first = one("stage.fmu", "once.fmu");
    assert_eq!(effects(&first).len(), 1, "{}", first["sentence"]);
    let second = one("once.fmu", "twice.fmu");
    assert_eq!(effects(&second).len(), 1, "{}", second["sentence"]);
    compare("once.fmu", "twice.fmu", PLANT_PORTS, folder.path());
    let twice = Package::open(folder.path().join("twice.fmu")).expect("an FMU");
    let switches = twice.description().variables.iter().filter(|v| v.name.ends_with(".enabled"));
    assert_eq!(switches.count(), 2 + 4, "two of the stage, two effects and two re-tunes");
    assert!(twice.resources().join("inner/resources/inner/modelDescription.xml").is_file());
}

/// The description of the FMU in `tests/c/stage.c`.
const C_STAGE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="C stage" guid="c-stage">
<CoSimulation modelIdentifier="stage" canHandleVariableCommunicationStepSize="true"
 canBeInstantiatedOnlyOncePerProcess="true" canNotUseMemoryManagementFunctions="true"/>
<UnitDefinitions>
<Unit name="V"><BaseUnit kg="1" m="2" s="-3" A="-1"/></Unit>
<Unit name="um"><BaseUnit m="1" factor="1e-6"/></Unit>
</UnitDefinitions>
<ModelVariables>
<ScalarVariable name="u" valueReference="4000000000" causality="input"><Real start="0" unit="V"/></ScalarVariable>
<ScalarVariable name="y" valueReference="7" causality="output"><Real unit="um"/></ScalarVariable>
<ScalarVariable name="gain" valueReference="8" causality="parameter" variability="tunable"><Real start="0.1"/></ScalarVariable>
<ScalarVariable name="steps" valueReference="7" causality="local" variability="discrete"><Integer/></ScalarVariable>
<ScalarVariable name="label" valueReference="7" causality="local" variability="discrete"><String/></ScalarVariable>
<ScalarVariable name="fast" valueReference="9" causality="parameter" variability="fixed"><Boolean start="false"/></ScalarVariable>
</ModelVariables>
<ModelStructure>
<Outputs><Unknown index="2" dependencies="1"/></Outputs>
<InitialUnknowns><Unknown index="2" dependencies="1"/></InitialUnknowns>
</ModelStructure>
</fmiModelDescription>
"#;

#[test]
fn a_c_fmu_is_repaired_with_all_its_types_and_its_gaps() {
    let folder = tempfile::tempdir().expect("a folder");
    let library = folder.path().join("stage.so");
    compile_library("stage.c", &[], &library);
    let description = ModelDescription::parse(C_STAGE.as_bytes()).expect("a description");
    let mut package = PackageBuilder::new(&description).expect("a package");
    package.binary("linux64", fs::read(&library).expect("the library")).expect("its place");
    package.write(folder.path().join("c.fmu")).expect("the folder is writable");
    measure_lag(folder.path());
    let gap = repair("c.fmu", C_PORTS, "repaired.fmu", folder.path());
    assert_eq!(gap["verdict"], "effects", "{}", gap["sentence"]);
    compare("c.fmu", "repaired.fmu", C_PORTS, folder.path());
    let repaired = Package::open(folder.path().join("repaired.fmu")).expect("an FMU");
    let offered = &repaired.description().co_simulation.as_ref().expect("co-simulation").common;
    assert!(!offered.can_get_and_set_fmu_state && !offered.can_serialize_fmu_state);
    assert!(offered.can_be_instantiated_only_once_per_process);
    // Texts, whole numbers and truth values go through, and so do tunable parameters.
    let code = r#"
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
d = read_model_description("repaired.fmu")
ref = {v.name: v.valueReference for v in d.modelVariables}
fmu = FMU2Slave(guid=d.guid, unzipDirectory=extract("repaired.fmu"),
                modelIdentifier=d.coSimulation.modelIdentifier, instanceName="me")
fmu.instantiate()
fmu.setupExperiment(startTime=0.0)
fmu.setBoolean([ref["fast"]], [True])
fmu.enterInitializationMode()
fmu.setReal([ref["u"]], [10.0])
fmu.exitInitializationMode()
first = fmu.getReal([ref["y"], ref["u"], ref["gain"]])
assert first[1:] == [10.0, 0.1], first
# At rest the creep of a tenth is over.
assert abs(first[0] - 1.1) < 0.02, first
fmu.setReal([ref["gain"], ref["u"]], [0.2, 20.0])
for k in range(2000):
    fmu.doStep(k * 5e-4, 5e-4)
last = fmu.getReal([ref["y"], ref["u"], ref["gain"]])
assert last[1:] == [20.0, 0.2] and abs(last[0] - 4.4) < 0.1, last
assert fmu.getBoolean([ref["fast"]]) == [1]
assert fmu.getInteger([ref["steps"]]) == [2000]
assert b"I am me" in fmu.getString([ref["label"]])[0]
switches = [v for v in d.modelVariables if v.name.endswith(".enabled")]
mixed = fmu.getBoolean([switches[0].valueReference, ref["fast"]])
assert mixed == [1, 1], mixed
fmu.doStep(1.0, 5e-3)
assert fmu.getInteger([ref["steps"]]) == [2010], "a long step is divided"
try:
    fmu.setBoolean([switches[0].valueReference], [False])
    raise SystemExit("a switch is fixed after initialization")
except Exception:
    pass
fmu.reset()
fmu.setupExperiment(startTime=0.0)
fmu.setBoolean([v.valueReference for v in switches], [False] * len(switches))
fmu.enterInitializationMode()
fmu.setReal([ref["u"]], [10.0])
fmu.exitInitializationMode()
assert fmu.getReal([ref["y"]]) == [1.0]
fmu.doStep(0.0, 5e-3)
assert fmu.getInteger([ref["steps"]]) == [1], "switched off, steps are the host's"
fmu.terminate()
fmu.freeInstance()
"#;
    python::script(code, &[], folder.path());
}

#[test]
fn a_repair_needs_something_to_repair_and_a_fitting_name() {
    let folder = tempfile::tempdir().expect("a folder");
    measure(folder.path());
    succeed(&["pack", STAGE, "-o", "stage.fmu"], folder.path());
    let arguments = ["diagnose", "--model", "stage.fmu", "--log", "stairs.csv", "--repair"];
    let message = refuse(&[&arguments[..], &["x.toml"]].concat(), folder.path());
    assert!(message.contains("x.toml") && message.contains(".fmu"), "{message}");
    let message = refuse(&[&arguments[..], &["x.zip"]].concat(), folder.path());
    assert!(message.contains("x.zip"), "{message}");
    // Without an effect nothing is written, and that is said.
    let truth = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/stage_truth.toml");
    let log = ["--log", "stairs.csv", "--log", "multisine.csv", "--map", "u=u"];
    let message = succeed(
        &[&["diagnose", "--model", truth, "--noise", "0.002", "--repair", "no.toml"], &log[..]]
            .concat(),
        folder.path(),
    );
    assert!(!folder.path().join("no.toml").exists(), "{message}");
    assert!(message.contains("no.toml is not written"), "{message}");
}

#[test]
fn an_fmu_of_pythonfmu_is_repaired() {
    let Some(interpreter) = foreign::python() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/stage_law.py");
    fs::copy(source, folder.path().join("stage_law.py")).expect("a copy");
    let mut build = foreign::tool(interpreter, "pythonfmu");
    foreign::message(build.args(["build", "-f", "stage_law.py"]), folder.path());
    measure_lag(folder.path());
    // A stage of Python is slow: a short record, and the effects that are in the machine.
    let log = fs::read_to_string(folder.path().join("multisine.csv")).expect("a log");
    let short: Vec<&str> = log.lines().skip(1).take(400).collect();
    let short = format!("time,u,x\n{}\n", short.join("\n"));
    fs::write(folder.path().join("short.csv"), short).expect("the folder is writable");
    let known = json(&["list", "effects"], folder.path());
    let names = known.as_array().expect("effects").iter().filter_map(|e| e["name"].as_str());
    let mut arguments = vec![
        "diagnose",
        "--model",
        "StageLaw.fmu",
        "--log",
        "short.csv",
        "--map",
        "y=x",
        "--noise",
        "0.002",
        "--unit",
        "x=1",
        "--max-effects",
        "1",
        "--repair",
        "repaired.fmu",
    ];
    for name in names.filter(|name| *name != "delay") {
        arguments.extend(["--without", name]);
    }
    // Its library expects the interpreter to be in the process already.
    let code =
        "import sysconfig as s; v = s.get_config_var; print(v('LIBDIR') + '/' + v('INSTSONAME'))";
    let library = python::script(code, &[], folder.path());
    if !Path::new(library.trim()).is_file() {
        println!("SKIPPED: no {}: a native host cannot run FMUs of PythonFMU", library.trim());
        return;
    }
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(&arguments)
        .env("LD_PRELOAD", library.trim())
        .current_dir(folder.path())
        .output()
        .expect("the tool starts");
    let message = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}{errors}");
    assert!(message.contains("delay"), "{message}");
    let out = compare("StageLaw.fmu", "repaired.fmu", C_PORTS, folder.path());
    for (before, after) in rms(&out) {
        assert!(after < before, "{before} before, {after} after");
    }
}
