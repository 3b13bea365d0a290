//! What the C functions of our FMUs cost, in ns per call, beside a C FMU that checks as much.
#![cfg(target_os = "linux")]
#![allow(clippy::print_stdout)]

mod common;

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
    print!("{name:22}");
    for column in COLUMNS {
        match figures[column].as_f64() {
            Some(figure) => print!("{figure:10.1}"),
            None => print!("{:>10}", "-"),
        }
    }
    println!("{:14.0}", figures["instantiate_us"].as_f64().expect("a figure"));
}

/// The edge (state, references, values, guard) costs at most 10 ns per call over a C FMU that
/// checks the same without a guard; a step of the plant with two axes of ten plays at most 1 us.
#[test]
fn the_edge_costs_nanoseconds() {
    let host = Host::new("edge.c");
    let folder = tempfile::tempdir().expect("a folder");
    let library = folder.path().join("trivial.so");
    compile_library("trivial.c", &library);
    let library = library.to_str().expect("UTF-8").to_owned();
    let arguments = [library.as_str(), "x", "x", "1e-3", "0", "1"].map(str::to_owned);
    let c = measured(&host, &arguments);
    let gain = measured(&host, &Packed::new(GAIN, "2").arguments());
    let plant = measured(&host, &Packed::new(PLANT, "2").arguments());
    let controller = measured(&host, &Packed::new(CONTROLLER, "2").arguments());
    print!("ns per call           ");
    COLUMNS.iter().for_each(|name| print!("{name:>10}"));
    println!("instantiate/us");
    row("y = 2 u in C", &c);
    row("y = 2 u, our FMU", &gain);
    row("plant, 2 axes", &plant);
    row("controller, 2 axes", &controller);
    let figure = |figures: &Value, name: &str| figures[name].as_f64().expect("a figure");
    for name in ["bare", "set", "get"] {
        let edge = figure(&gain, name) - figure(&c, name);
        assert!(edge <= 10.0, "{name}: {edge:.1} ns more than in C");
    }
    assert!(figure(&plant, "step") <= 1000.0, "a step of the plant: {plant}");
    assert!(figure(&controller, "step") <= 1000.0, "a step of the controller: {controller}");
}
