//! `invert` on the rigs: what it says, what it writes, and that it holds on the very plant.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;

use common::{json, refuse, succeed};
use control::{CommandActs, Damping};
use serde_json::Value;

/// Runs the controller c.toml as FMU over in.csv and in this process with the same inputs, and compares the outputs.
fn runs_to_the_bit(
    at: &Path,
    inputs: &[&str],
    outputs: &[&str],
    period: f64,
    values: impl Fn(usize) -> Vec<f64>,
) {
    succeed(&["pack", "c.toml", "-o", "c.fmu"], at);
    succeed(&["simulate", "c.fmu", "--log", "in.csv", "-o", "run.csv"], at);
    let run = fs::read_to_string(at.join("run.csv")).expect("a run");
    let head = run.lines().next().expect("a head").split(',');
    let names: Vec<_> = head.map(|name| name.split(' ').next().unwrap_or_default()).collect();
    let blueprint = data::Blueprint::read(&at.join("c.toml")).expect("a blueprint");
    let mut system = blueprint.check(learned::COMPONENTS).expect("sound").build();
    let place = |name: &str, system: &model::System| system.variables().find(name).expect("one");
    for (k, line) in run.lines().skip(1).enumerate() {
        let row = k.saturating_sub(1);
        for (name, value) in inputs.iter().zip(values(row)) {
            let reference = place(name, &system);
            system.set(reference, value).expect("an input");
        }
        match k {
            0 => system.initialise(0.0).expect("rest"),
            _ => system.advance(k as f64 * period).map(|_| ()).expect("finite"),
        }
        for name in outputs {
            let column = names.iter().position(|n| n == name).expect("a command");
            let packed: f64 =
                line.split(',').nth(column).expect("a cell").parse().expect("a number");
            let native = system.get(place(name, &system)).expect("an output");
            assert_eq!(packed.to_bits(), native.to_bits(), "{name}, row {k}: {packed} {native}");
        }
    }
}

/// A raised sine over the middle of each reach, softly begun.
fn wave(axes: &[Value], period: f64, at: &Path) {
    use std::fmt::Write as _;
    let mut text = String::from("time [s]");
    (1..=axes.len()).for_each(|axis| write!(text, ",reference[{axis}]").expect("a text"));
    for k in 0..=(4.0 / period) as usize {
        let time = k as f64 * period;
        write!(text, "\n{time}").expect("a text");
        for axis in axes {
            let end = |n: usize| axis["reach"][n].as_f64().expect("a number");
            let (middle, half) = (0.5 * (end(0) + end(1)), 0.3 * (end(1) - end(0)));
            let on = time.min(1.0);
            write!(text, ",{}", middle + on * half * (std::f64::consts::TAU * time).sin())
                .expect("a text");
        }
    }
    fs::write(at.join("reference.csv"), text + "\n").expect("a file");
}

/// Largest rms error of the packed loop in percent of the reference's range.
fn loop_error(rig: &str, extra: &[&str], at: &Path) -> f64 {
    let answer = json(&[&["invert", rig, "-o", "controller.toml"], extra].concat(), at);
    let axes = answer["axes"].as_array().expect("axes");
    wave(axes, answer["period_s"].as_f64().expect("a period").max(1e-4), at);
    succeed(&["pack", rig, "-o", "plant.fmu"], at);
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], at);
    let run = [
        "simulate",
        "--loop",
        "plant.fmu",
        "controller.fmu",
        "--reference",
        "reference.csv",
        "--drop",
        "2",
    ];
    let fits = json(&run, at);
    let each = fits["fits"].as_array().expect("fits").iter();
    each.map(|fit| fit["nrmse_percent"].as_f64().unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
}

#[test]
fn the_packed_controller_holds_on_the_rig_that_it_was_made_from() {
    let folder = tempfile::tempdir().expect("a folder");
    for (rig, extra, bound) in [
        // A filter of 40 Hz in the sensor, and a mode near half the sample rate.
        ("p1", &[][..], 0.1),
        // Amplifier and sensor are curved, and it creeps.
        ("p885", &[], 0.1),
        // Four axes that optics couple.
        ("p0", &["--period", "5e-3"], 0.1),
    ] {
        let error = loop_error(rig, extra, folder.path());
        assert!(error < bound, "{rig}: {error} % of range");
    }
}

#[test]
fn the_plant_that_identify_writes_is_inverted() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    // The log of the README.
    let signal = "signal triangle-decaying --set low=0 --set high=120 --set frequency=2 --set cycles=4 \
                  --set sample_time=5e-4 -o triangles.csv";
    succeed(&signal.split_whitespace().collect::<Vec<_>>(), at);
    let run = "simulate evc-truth --log triangles.csv --map command[1]=u -o log.csv";
    succeed(&run.split_whitespace().collect::<Vec<_>>(), at);
    let identify = "identify --log log.csv --input command[1] --output position[1] -o plant.toml";
    let identify: Vec<&str> = identify.split_whitespace().collect();
    for model in [&[][..], &["--model", "generalised-play"]] {
        succeed(&[&identify[..], model].concat(), at);
        let plant = fs::read_to_string(at.join("plant.toml")).expect("a plant");
        assert!(model.iter().skip(1).all(|kind| plant.contains(kind)), "{plant}");
        let answer = json(&["invert", "plant.toml", "-o", "controller.toml"], at);
        assert!(at.join("controller.toml").is_file(), "{model:?}");
        // A slow wave on the very plant.
        let error = answer["axes"][0]["checks"][0]["closed_loop"].as_f64();
        assert!(error.is_some_and(|error| error < 0.05), "{model:?}: {answer}");
    }
}

#[test]
fn what_is_printed_stands_in_the_blueprint_and_in_the_answer() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let answer = json(&["invert", "p0", "--period", "5e-3", "-o", "c.toml"], at);
    assert_eq!(answer["coordinators"][0]["couplings"][0], "optics-jacobian", "{answer}");
    assert!(
        answer["coordinators"][0]["condition"].as_f64().is_some_and(|c| (4.0..6.0).contains(&c))
    );
    let text = fs::read_to_string(at.join("c.toml")).expect("a file");
    for word in
        ["jacobian-coordinator", "motion = ", "reach", "gain margin", "on its own plant", "delay"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
    for axis in answer["axes"].as_array().expect("axes") {
        // Two filters of 50 Hz and a driver: half a period of hold besides.
        assert!(axis["delay"].as_f64().is_some_and(|d| (4e-3..6e-3).contains(&d)), "{axis}");
        let check = &axis["checks"][0];
        let error = |name: &str| check[name].as_f64().expect("a number");
        assert!(error("closed_loop") < 0.1 * error("feedback"), "{axis}");
    }
    let messages = succeed(&["invert", "p2", "-o", "c.toml"], at);
    assert!(messages.contains("curls over") && messages.contains("fitted"), "{messages}");
}

#[test]
fn the_ways_of_a_plant_are_listed_and_can_be_chosen() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let answer = json(&["invert", "p2", "--list"], at);
    let ways = answer["ways"].as_array().expect("ways");
    let of = |name: &str| ways.iter().find(|way| way["name"] == name).expect("a way");
    assert!(of("inverse")["reason"].as_str().is_some_and(|r| r.contains("curls over")), "{answer}");
    assert!(of("dynamic")["reason"].is_string(), "{answer}");
    for name in ["inverse-free", "fitted", "gp", "linear", "none"] {
        assert!(of(name)["axes"][0]["checks"][0]["closed_loop"].is_number(), "{answer}");
    }
    assert!(!at.join("controller.toml").exists());
    json(&["invert", "p3", "--feedforward", "linear", "--feedback", "pi", "-o", "c.toml"], at);
    let text = fs::read_to_string(at.join("c.toml")).expect("a file");
    assert!(text.contains("kd = 0") && text.contains("feedforward-gain"), "{text}");
    let message = refuse(&["invert", "p3", "--feedforward", "inverse-free"], at);
    assert!(message.contains("actuator") && message.contains("--list"), "{message}");
}

#[test]
fn the_page_has_loop_step_and_waves_of_each_axis() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    succeed(&["invert", "p0", "--period", "5e-3", "--report", "page.json"], at);
    let page: Value =
        serde_json::from_str(&fs::read_to_string(at.join("page.json")).expect("a page")).unwrap();
    let figures = page["key_figures"].as_array().expect("figures");
    assert_eq!(figures.len(), 4);
    assert!(figures.iter().all(|figure| figure["outcome"] == "pass"), "{figures:?}");
    let text = page["sections"].to_string();
    for title in
        ["Open loop L", "Nyquist plot", "Sensitivity and closed loop", "Step of the reference"]
    {
        assert_eq!(text.matches(&format!("\"{title}\"")).count(), 4, "{title}");
    }
    let message = refuse(&["invert", "p0", "--list", "--report", "list.html"], at);
    assert!(message.contains("--list designs no controller"), "{message}");
    assert!(!at.join("list.html").exists());
}

#[test]
fn what_a_reference_asks_beyond_the_limits_is_stated() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    succeed(&["signal", "p0-trajectory-1", "-o", "path.csv"], at);
    let rig = ["invert", "p0", "--period", "5e-3", "--reference", "path.csv", "-o", "c.toml"];
    let answer = json(&rig, at);
    let along = answer["along"].as_array().expect("axes");
    let of = |axis: &str| along.iter().find(|a| a["axis"] == axis).expect("an axis");
    let number = |value: &Value| value.as_f64().expect("a number");
    for axis in ["M1x", "M1y", "M2x"] {
        assert_eq!(number(&of(axis)["beyond"]), 0.0, "{answer}");
        assert!(number(&of(axis)["error"]) < 5e-4, "{answer}");
    }
    assert!((number(&of("M2y")["asked"][0]) + 3.31).abs() < 0.05, "{answer}");
    assert!(number(&of("M2y")["beyond"]) > 0.02 && number(&of("M2y")["error"]) > 2e-3, "{answer}");
    let messages = succeed(&rig, at);
    assert!(messages.contains("asks M2y for -3.3") && messages.contains("limit 0"), "{messages}");
    let message = refuse(&["invert", "p1", "--reference", "path.csv", "-o", "c.toml"], at);
    assert!(message.contains("reference[1]"), "{message}");
}

#[test]
fn the_four_control_systems_of_coupled_axes() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut errors = Vec::new();
    for system in ["1", "2", "3", "4"] {
        let rig = ["invert", "p0", "--period", "5e-3", "--system", system, "-o", "c.toml"];
        let answer = json(&rig, at);
        let text = fs::read_to_string(at.join("c.toml")).expect("a file");
        assert_eq!(text.contains("210.358"), system != "1", "{text}");
        assert_eq!(text.contains("inverse-prandtl-ishlinskii"), matches!(system, "3" | "4"));
        assert_eq!(text.contains("ki = 0"), system == "3", "{text}");
        let axes = answer["axes"].as_array().expect("axes");
        let error = |axis: &Value| axis["checks"][0]["closed_loop"].as_f64().expect("a number");
        errors.push(axes[2..].iter().map(error).fold(0.0, f64::max));
    }
    // On the second mirror: alone, coordinated, feedforward, both.
    assert!(errors[0] > errors[1] && errors[1] > errors[2] && errors[2] > errors[3], "{errors:?}");
    let message = refuse(&["invert", "p1", "--system", "2", "-o", "c.toml"], at);
    assert!(message.contains("coupled"), "{message}");
}

/// All but those that hold where nothing is said.
#[test]
fn the_python_package_lists_the_kinds_of_the_tool() {
    let module = common::root().join("python/piezoloop/_workflow.py");
    let text = fs::read_to_string(module).expect("a module");
    let listed = |option: &str| {
        let mut lines = text.lines().filter(|line| line.trim_start().starts_with(option));
        let line = lines.find(|line| line.contains("``")).expect(option);
        let mut names: Vec<_> = line.split("``").skip(1).step_by(2).map(str::to_owned).collect();
        names.sort();
        names
    };
    let sorted = |mut names: Vec<&'static str>| {
        names.sort_unstable();
        names
    };
    let dampings = Damping::ALL.iter().filter(|damping| **damping != Damping::default());
    assert_eq!(listed("damping:"), sorted(dampings.map(|damping| damping.name()).collect()));
    let acts = CommandActs::ALL.iter().filter(|acts| **acts != CommandActs::default());
    assert_eq!(listed("command_acts:"), sorted(acts.map(|acts| acts.name()).collect()));
}

/// A stage with a lightly damped mode.
const LIGHT: &str = "piezoloop = 1\nkind = \"plant\"\nname = \"light\"\nstep = 5e-5\n[[axis]]\nname = \"X\"\n\
     command = { name = \"u\", unit = \"V\", min = -20, max = 120 }\nposition = { name = \"x\", unit = \"um\" }\n\
     [[axis.component]]\ntype = \"amplifier-lag\"\nbandwidth = 5000\n\
     [[axis.component]]\ntype = \"actuator-gain\"\nname = \"actuator\"\ngain = 0.8\n\
     [[axis.component]]\ntype = \"mode\"\nname = \"mechanics\"\nfrequency = 400\ndamping = 0.01\n";

#[test]
fn a_damped_loop_is_printed_written_and_runs_in_the_fmu_to_the_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("light.toml"), LIGHT).expect("a file");
    let rows = 400;
    let (period, wave) = (5e-5, |k: usize| 20.0 + 5.0 * (0.02 * (k * k) as f64 / 40.0).sin());
    let mut table = String::from("time [s],reference[1] [um],measured[1] [um]");
    for k in 0..rows {
        use std::fmt::Write as _;
        write!(table, "\n{},{},{}", k as f64 * period, wave(k), 0.9 * wave(k + 3)).expect("a text");
    }
    fs::write(at.join("in.csv"), table + "\n").expect("a file");
    for (law, kind) in [
        ("irc", "integral-resonant-control"),
        ("ppf", "positive-position-feedback"),
        ("nrc", "non-minimum-phase-damping"),
        ("notch", "notch"),
    ] {
        let asked =
            ["invert", "light.toml", "--damping", law, "--sensitivity", "2", "-o", "c.toml"];
        let answer = json(&asked, at);
        let found = &answer["axes"][0]["damping"];
        assert_eq!(found["law"], law, "{answer}");
        let number = |name: &str| found[name].as_f64().expect("a number");
        assert!(answer["axes"][0]["sensitivity"].as_f64().is_some_and(|s| s <= 2.0), "{answer}");
        if law != "notch" {
            assert!(number("closed_loop_bandwidth") >= 1.1 * number("resonance"), "{found}");
        }
        // All laws are printed alike.
        if law == "irc" {
            let messages = succeed(&asked, at);
            assert!(messages.contains("times the resonance of 400.0 Hz"), "{messages}");
        }
        let text = fs::read_to_string(at.join("c.toml")).expect("a blueprint");
        assert!(text.contains(kind) && text.contains("resonance 400"), "{text}");
        let inputs = |row: usize| vec![wave(row), 0.9 * wave(row + 3)];
        runs_to_the_bit(at, &["reference[1]", "measured[1]"], &["command[1]"], period, inputs);
    }
    let asked = ["invert", "light.toml", "--damping", "nrc", "--feedback", "none"];
    let messages = refuse(&asked, at);
    assert!(messages.contains("--feedback pid or pi"), "{messages}");
    let messages = refuse(&["invert", "p885", "--damping", "nrc"], at);
    assert!(messages.contains("no mode") && messages.contains("--damping"), "{messages}");
}

/// Two axes whose coupling has two modes.
const MIRROR: &str = "piezoloop = 1\nkind = \"plant\"\nname = \"mirror\"\nstep = 2e-4\n[[axis]]\nname = \"a\"\n\
     command = { name = \"u1\", unit = \"V\", min = -5, max = 5 }\nposition = { name = \"y1\", unit = \"um\" }\n\
     [[axis.component]]\ntype = \"actuator-gain\"\ngain = 2\n[[axis]]\nname = \"b\"\n\
     command = { name = \"u2\", unit = \"V\", min = -5, max = 5 }\nposition = { name = \"y2\", unit = \"um\" }\n\
     [[axis.component]]\ntype = \"actuator-gain\"\ngain = -3\n[[coupling]]\naxes = [\"a\", \"b\"]\n\
     type = \"modal-matrix\"\ndirect = [0, 0, 0, 0]\nfrequency = [310, 430]\ndamping = [0.01, 0.02]\n\
     residue = [0.6, 0.6, 0.6, 0.6, 0.5, -0.5, -0.5, 0.5]\nrate_residue = [0, 0, 0, 0, 0, 0, 0, 0]\n";

#[test]
fn coupled_axes_get_one_loop_and_a_preview_that_runs_in_the_fmu_to_the_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("mirror.toml"), MIRROR).expect("a file");
    let asked = ["invert", "mirror.toml", "--feedforward", "preview", "-o", "c.toml"];
    let answer = json(&asked, at);
    let found = &answer["coordinators"][0];
    assert_eq!(found["coupled_loop"]["plants"], 30, "{answer}");
    assert!(found["coupled_loop"]["sensitivity"].as_f64().is_some_and(|s| s <= 1.5), "{found}");
    assert!(found["preview"]["preview"].as_f64().is_some_and(|s| s > 0.0), "{found}");
    let messages = succeed(&asked, at);
    assert!(messages.contains("all axes together") && messages.contains("ms late"), "{messages}");
    let text = fs::read_to_string(at.join("c.toml")).expect("a blueprint");
    assert!(text.contains("preview-coordinator") && text.contains("feedback-notch"), "{text}");
    let values = |k: usize| {
        let wave = |turn: f64| 0.4 * (turn * (k * k) as f64 / 4000.0).sin();
        vec![wave(1.0), wave(1.3), 0.9 * wave(0.8), 1.1 * wave(0.7)]
    };
    let mut table = String::from("time [s],reference[1],reference[2],measured[1],measured[2]");
    for k in 0..400 {
        use std::fmt::Write as _;
        write!(table, "\n{}", k as f64 * 2e-4).expect("a text");
        values(k).iter().for_each(|value| write!(table, ",{value}").expect("a text"));
    }
    fs::write(at.join("in.csv"), table + "\n").expect("a file");
    let inputs = ["reference[1]", "reference[2]", "measured[1]", "measured[2]"];
    runs_to_the_bit(at, &inputs, &["command[1]", "command[2]"], 2e-4, values);
    let messages = refuse(&["invert", "mirror.toml", "--damping", "nrc"], at);
    assert!(
        messages.contains("mode of a single axis") && messages.contains("leave --damping out"),
        "{messages}"
    );
    fs::write(at.join("light.toml"), LIGHT).expect("a file");
    let messages = refuse(&["invert", "light.toml", "--feedforward", "preview"], at);
    assert!(messages.contains("no coupling with dynamics"), "{messages}");
}
