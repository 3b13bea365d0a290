//! What importers really pass. Our FMUs must give the same bits to all of them; and our own master
//! is recorded by an FMU that spies on it.
#![cfg(target_os = "linux")]

use crate::common;

use common::packed::{CONTROLLER, Host, PLANT, Packed, with};
use common::{python, spy};
use modeldescription::variable::{Causality, DataType};
use std::fs;
use std::process::Command;

/// The value references of the parameters of a type, as an argument of a host.
fn parameters(fmu: &Packed, data_type: DataType) -> String {
    let all = fmu.package.description().variables.iter();
    let parameters = all
        .filter(|v| v.causality == Causality::Parameter && v.data_type == data_type)
        .map(|v| v.value_reference.to_string());
    let list = parameters.collect::<Vec<_>>().join(",");
    if list.is_empty() { "-".to_owned() } else { list }
}

#[test]
fn every_importers_oddities_give_the_same_bits() {
    let host = Host::new("importers.c");
    for blueprint in [PLANT, CONTROLLER] {
        let fmu = Packed::new(blueprint, "2");
        let path = fmu.package.resources_uri().replacen("file://", "", 1);
        let lists = [parameters(&fmu, DataType::Float64), parameters(&fmu, DataType::Boolean)];
        let arguments = with(fmu.arguments_at(&fmu.library(), &path), &[&lists[0], &lists[1]]);
        println!("{}: {}", fmu.name(), host.run(&arguments));
    }
}

#[test]
fn our_master_calls_as_the_standard_says() {
    let folder = tempfile::tempdir().expect("a folder");
    spy::pack(folder.path());
    fs::write(folder.path().join("in.csv"), "time,u\n0,1.5\n0.1,2.5\n0.2,3.5\n0.3,4.5\n")
        .expect("the folder is writable");
    let record = folder.path().join("calls");
    let output = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(["simulate", "spy.fmu", "--log", "in.csv", "--start", "gain=3", "-o", "run.csv"])
        .current_dir(folder.path())
        .env("SPY_RECORD", &record)
        .output()
        .expect("the tool starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let calls = spy::calls(&record);

    let [built] = spy::of(&calls, "Instantiate")[..] else { panic!("one instance: {calls:#?}") };
    assert_eq!(built["type"], 1, "co-simulation");
    for given in ["callbacks", "logger", "allocate", "free"] {
        assert_eq!(built[given], 1, "{given}: {built}");
    }
    assert_eq!(built["visible"], 0, "nobody looks");
    let resources = built["resources"].as_str().expect("a location");
    assert!(resources.starts_with("file:///") && resources.ends_with("/resources"), "{resources}");

    let order: Vec<_> = calls.iter().map(|call| call["call"].as_str().expect("a name")).collect();
    let at = |name: &str| order.iter().position(|n| *n == name).unwrap_or_else(|| panic!("{name}"));
    assert!(at("Instantiate") == 0 && at("SetupExperiment") < at("EnterInitializationMode"));
    assert!(at("ExitInitializationMode") < at("DoStep") && at("DoStep") < at("Terminate"));
    assert_eq!(order.last(), Some(&"FreeInstance"));
    let setup = &calls[at("SetupExperiment")];
    assert!(setup["start"] == 0.0 && setup["stop"] == 0.3, "{setup}");

    // The first input is there before the initialization ends; a fixed parameter before it begins.
    let set = |reference: &str, value: f64| {
        let is = |call: &serde_json::Value| call["values"][reference] == value;
        calls.iter().position(|call| call["call"] == "SetReal" && is(call)).expect("it is set")
    };
    assert!(set("2", 3.0) < at("ExitInitializationMode"));
    assert!(set("0", 1.5) < at("ExitInitializationMode"));

    let steps = spy::of(&calls, "DoStep");
    let points: Vec<_> = steps.iter().map(|s| s["time"].as_f64().expect("a time")).collect();
    assert_eq!(points, [0.0, 0.1, 0.2], "exactly the log's");
    for (step, end) in steps.iter().zip([0.1, 0.2, 0.3]) {
        let size = step["size"].as_f64().expect("a size");
        let time = step["time"].as_f64().expect("a time");
        assert!((time + size - end).abs() <= f64::EPSILON * end, "{step}");
    }
    // y = gain * u; at t_k it is that of u_{k-1}, and of u_0 as initialised.
    let run = fs::read_to_string(folder.path().join("run.csv")).expect("the run");
    let names: Vec<_> = run.lines().next().expect("a header").split(',').collect();
    let y = names.iter().position(|name| name.starts_with("y")).expect("the output");
    let values: Vec<_> = run.lines().skip(1).filter_map(|row| row.split(',').nth(y)).collect();
    assert_eq!(values, ["4.5", "4.5", "7.5", "10.5"], "{run}");
}

/// The row of fmpy in the table of importers, recorded anew with the version that is installed.
#[test]
fn fmpy_calls_as_its_row_in_the_table_says() {
    let folder = tempfile::tempdir().expect("a folder");
    spy::pack(folder.path());
    let record = folder.path().join("calls");
    let code = r#"
import os, sys
os.environ["SPY_RECORD"] = sys.argv[1]
from fmpy import simulate_fmu
simulate_fmu("spy.fmu", stop_time=1.0, output_interval=0.1, start_values={"u": 1.5})
"#;
    python::script(code, &[record.to_str().expect("UTF-8")], folder.path());
    let calls = spy::calls(&record);
    let built = &calls[0];
    assert_eq!((&built["allocate"], &built["free"]), (&1.into(), &1.into()), "{built}");
    assert_eq!((&built["stepFinished"], &built["environment"]), (&0.into(), &0.into()), "{built}");
    let order: Vec<_> = calls.iter().filter_map(|call| call["call"].as_str()).collect();
    let at = |name: &str| order.iter().position(|n| *n == name).unwrap_or_else(|| panic!("{name}"));
    assert!(at("SetReal") < at("EnterInitializationMode"), "inputs come before: {order:?}");
    assert_ne!(calls[at("SetupExperiment")]["stop"], serde_json::Value::Null);
    assert_eq!(order[order.len() - 2..], ["Terminate", "FreeInstance"]);
}
