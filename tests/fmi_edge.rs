//! What the C functions of our FMUs cost, in ns per call, beside C FMUs: one that does the same at each
//! call, and a short one.
#![cfg(target_os = "linux")]

use crate::common;

use std::path::{Path, PathBuf};

use common::packed::{CONTROLLER, Host, PLANT, Packed, compile_library};
use serde_json::Value;

/// y = 2 u.
const GAIN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/gain.toml");
const COLUMNS: [&str; 8] =
    ["bare", "set", "get", "idle_step", "step", "exchange", "save", "restore"];

/// Rounds in which all libraries are measured one after the other; the least time of each call counts,
/// so that other work on the machine during one round does not.
const ROUNDS: usize = 3;

fn measured(host: &Host, libraries: &[Vec<String>]) -> Vec<Value> {
    let once = |arguments: &Vec<String>| -> Value {
        serde_json::from_str(&host.run(arguments)).expect("a line of JSON")
    };
    let mut least: Vec<Value> = libraries.iter().map(once).collect();
    for _ in 1..ROUNDS {
        for (least, library) in least.iter_mut().zip(libraries) {
            let again = once(library);
            for (name, figure) in least.as_object_mut().expect("figures") {
                if again[name.as_str()].as_f64() < figure.as_f64() {
                    *figure = again[name.as_str()].clone();
                }
            }
        }
    }
    least
}

fn row(name: &str, figures: &Value) {
    print!("{name:32}");
    for column in COLUMNS {
        match figures[column].as_f64() {
            Some(figure) => print!("{figure:10.1}"),
            None => print!("{:>10}", "-"),
        }
    }
    match figures["instantiate_us"].as_f64() {
        Some(figure) => println!("{figure:14.0}"),
        None => println!("{:>14}", "-"),
    }
}

/// A library of `tests/c` and its arguments.
fn in_c(source: &str, folder: &Path) -> Vec<String> {
    let library = folder.join(source).with_extension("so");
    compile_library(source, &[], &library);
    let library = library.to_str().expect("UTF-8").to_owned();
    [library.as_str(), "x", "x", "1e-3", "0", "1"].map(str::to_owned).into()
}

fn figure(figures: &Value, name: &str) -> f64 {
    figures[name].as_f64().expect("a figure")
}

/// Plays between two curves with creep and a network of 24 units, as `identify --model learned-plays` writes it of a log.
fn learned_plays(folder: &Path) -> PathBuf {
    let list = |count: u32, number: &dyn Fn(u32) -> f64| {
        format!("{:?}", (0..count).map(number).collect::<Vec<f64>>())
    };
    let text = format!(
        r#"
piezoloop = 1
kind = "plant"
name = "learned"
source = "created for tests"
step = 1e-3
[[axis]]
name = "X"
command = {{ name = "u", unit = "V", min = 0, max = 100, start = 0 }}
position = {{ name = "y", unit = "um" }}
[[axis.component]]
type = "learned-plays"
r = {r}
w = {w}
share = [0.01, 0.01, 0.01]
time_constant = [0.02, 0.2, 2]
height = {height}
bias = {bias}
weight = {weight}
activation = 1
centre = 50
half_range = 50
position_centre = 10
position_half_range = 10
"#,
        r = list(60, &|i| 0.8 * f64::from(i)),
        w = list(60, &|i| if i == 0 { 0.1 } else { 0.003 }),
        height = list(24, &|n| 0.01 * f64::from(n + 1).sin()),
        bias = list(24, &|n| 0.5 * f64::from(n).cos()),
        weight = list(9 * 24, &|n| f64::from(n).sin()),
    );
    let file = folder.join("learned.toml");
    std::fs::write(&file, text).expect("a blueprint");
    file
}

/// The edge (state, references, values, guard) costs at most 10 ns per call over a C FMU that does the
/// same without a guard, and so does a step in which no hit of the model's grid falls. A step of y = 2 u
/// takes at most as long as in C that is put together at run time as our models are, and at most 1.5
/// times as long as in C whose model is known when it is compiled (1.3 where nothing else runs). A step of the plant with two
/// axes of ten plays takes at most 1 us, of learned plays at most 400 ns (200 where nothing else runs).
#[test]
fn the_edge_costs_nanoseconds() {
    let folder = tempfile::tempdir().expect("a folder");
    let host = Host::new("edge.c");
    let learned = learned_plays(folder.path());
    let blueprints = [GAIN, PLANT, CONTROLLER, learned.to_str().expect("UTF-8")];
    let packed: Vec<Packed> =
        blueprints.iter().map(|blueprint| Packed::new(blueprint, "2")).collect();
    let mut libraries: Vec<Vec<String>> = ["trivial.c", "careful.c", "assembled.c"]
        .iter()
        .map(|source| in_c(source, folder.path()))
        .collect();
    libraries.extend(packed.iter().map(Packed::arguments));
    let figures = measured(&host, &libraries);
    let [short, c, assembled, gain, plant, controller, learned] = &figures[..] else {
        panic!("seven")
    };
    let host = Host::new("edge3.c");
    let packed = Packed::new(GAIN, "3");
    let figures = measured(&host, &[in_c("careful3.c", folder.path()), packed.arguments()]);
    let [c3, gain3] = &figures[..] else { panic!("two") };
    print!("ns per call                     ");
    COLUMNS.iter().for_each(|name| print!("{name:>10}"));
    println!("instantiate/us");
    row("y = 2 u in C, short", short);
    row("y = 2 u in C, as ours", c);
    row("y = 2 u in C, put together", assembled);
    row("y = 2 u, our FMU", gain);
    row("plant, 2 axes", plant);
    row("controller, 2 axes", controller);
    row("60 learned plays, 24 units", learned);
    row("FMI 3: y = 2 u in C, as ours", c3);
    row("FMI 3: y = 2 u, our FMU", gain3);
    for (version, ours, theirs) in [("2.0", gain, c), ("3.0", gain3, c3)] {
        for name in ["bare", "set", "get", "idle_step"] {
            let edge = figure(ours, name) - figure(theirs, name);
            assert!(edge <= 10.0, "FMI {version}, {name}: {edge:.1} ns more than in C");
        }
    }
    let times = |theirs: &Value| figure(gain, "step") / figure(theirs, "step");
    println!("step: {:.2} of C put together, {:.2} of C", times(assembled), times(c));
    assert!(times(assembled) <= 1.0, "{:.2} times C that is put together", times(assembled));
    assert!(times(c) <= 1.5, "{:.2} times C that is compiled as a whole", times(c));
    assert!(figure(plant, "step") <= 1000.0, "a step of the plant: {plant}");
    assert!(figure(controller, "step") <= 1000.0, "a step of the controller: {controller}");
    assert!(figure(learned, "step") <= 400.0, "a step of learned plays: {learned}");
}
