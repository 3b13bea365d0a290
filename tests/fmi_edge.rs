//! What the C functions of our FMUs cost, in ns per call, beside C FMUs: one that does the same at each
//! call, and a short one.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stdout)]

mod common;

use std::path::Path;

use common::packed::{CONTROLLER, Host, PLANT, Packed, compile_library};
use serde_json::Value;

/// y = 2 u.
const GAIN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/gain.toml");
const COLUMNS: [&str; 8] =
    ["bare", "set", "get", "idle_step", "step", "exchange", "save", "restore"];

fn measured(host: &Host, arguments: &[String]) -> Value {
    serde_json::from_str(&host.run(arguments)).expect("a line of JSON")
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

/// The edge (state, references, values, guard) costs at most 10 ns per call over a C FMU that does the
/// same without a guard, and so does a step in which no hit of the model's grid falls. A step of y = 2 u
/// takes at most 1.3 times as long as in C that is put together at run time as our models are, and at
/// most 2.2 times as long as in C whose model is known when it is compiled. A step of the plant with two
/// axes of ten plays takes at most 1 us.
#[test]
fn the_edge_costs_nanoseconds() {
    let folder = tempfile::tempdir().expect("a folder");
    let host = Host::new("edge.c");
    let short = measured(&host, &in_c("trivial.c", folder.path()));
    let c = measured(&host, &in_c("careful.c", folder.path()));
    let assembled = measured(&host, &in_c("assembled.c", folder.path()));
    let gain = measured(&host, &Packed::new(GAIN, "2").arguments());
    let plant = measured(&host, &Packed::new(PLANT, "2").arguments());
    let controller = measured(&host, &Packed::new(CONTROLLER, "2").arguments());
    let host = Host::new("edge3.c");
    let c3 = measured(&host, &in_c("careful3.c", folder.path()));
    let gain3 = measured(&host, &Packed::new(GAIN, "3").arguments());
    print!("ns per call                     ");
    COLUMNS.iter().for_each(|name| print!("{name:>10}"));
    println!("instantiate/us");
    row("y = 2 u in C, short", &short);
    row("y = 2 u in C, as ours", &c);
    row("y = 2 u in C, put together", &assembled);
    row("y = 2 u, our FMU", &gain);
    row("plant, 2 axes", &plant);
    row("controller, 2 axes", &controller);
    row("FMI 3: y = 2 u in C, as ours", &c3);
    row("FMI 3: y = 2 u, our FMU", &gain3);
    for (version, ours, theirs) in [("2.0", &gain, &c), ("3.0", &gain3, &c3)] {
        for name in ["bare", "set", "get", "idle_step"] {
            let edge = figure(ours, name) - figure(theirs, name);
            assert!(edge <= 10.0, "FMI {version}, {name}: {edge:.1} ns more than in C");
        }
    }
    let times = |theirs: &Value| figure(&gain, "step") / figure(theirs, "step");
    println!("step: {:.2} of C put together, {:.2} of C", times(&assembled), times(&c));
    assert!(times(&assembled) <= 1.3, "{:.2} times C that is put together", times(&assembled));
    assert!(times(&c) <= 2.2, "{:.2} times C that is compiled as a whole", times(&c));
    assert!(figure(&plant, "step") <= 1000.0, "a step of the plant: {plant}");
    assert!(figure(&controller, "step") <= 1000.0, "a step of the controller: {controller}");
}
