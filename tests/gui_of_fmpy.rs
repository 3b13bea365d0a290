//! Our FMUs in FMPy's graphical user interface, offscreen: it loads them, shows their documentation,
//! validates and simulates them, and has nothing to warn of.
#![cfg(target_os = "linux")]

use crate::common;

use common::packed::{CONTROLLER, PLANT};
use common::{foreign, succeed};
use std::fs;
use std::path::Path;

/// Inputs on a grid of 0.1 ms: by element, as our tool and FMI 2.0 take them, and by array.
fn write_inputs(folder: &Path, kind: &str, arrays: &[&str]) {
    let mut header = String::from("time");
    for name in arrays {
        header += &format!(",{name}[1],{name}[2]");
    }
    let (mut elements, mut complete) = (header, format!("time,{}", arrays.join(",")));
    let enable = if kind == "controller" { ",1" } else { "" };
    if kind == "controller" {
        elements += ",enable";
        complete += ",enable";
    }
    for k in 0..301 {
        let t = f64::from(k) * 1e-4;
        elements += &format!("\n{t}");
        complete += &format!("\n{t}");
        for place in 0..arrays.len() {
            let phase = place as f64;
            let values = [3.0 - 2.0 * (44.0 * t + phase).cos(), 3.0 + (131.0 * t + phase).sin()];
            elements += &format!(",{},{}", values[0], values[1]);
            complete += &format!(",{} {}", values[0], values[1]);
        }
        elements += enable;
        complete += enable;
    }
    fs::write(folder.join(format!("{kind}2.csv")), elements + "\n").expect("written");
    fs::write(folder.join(format!("{kind}3.csv")), complete + "\n").expect("written");
}

#[test]
fn fmpys_gui_shows_and_runs_our_fmus_without_a_warning() {
    let Some(python) = foreign::environment("gui") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let mut arguments = Vec::new();
    for (blueprint, kind, inputs) in
        [(PLANT, "plant", &["command"][..]), (CONTROLLER, "controller", &["reference", "measured"])]
    {
        write_inputs(folder.path(), kind, inputs);
        for version in ["2", "3"] {
            let fmu = format!("{kind}{version}.fmu");
            let run = format!("{kind}{version}-run.csv");
            succeed(&["pack", blueprint, "--fmi", version, "-o", &fmu], folder.path());
            let log = format!("{kind}2.csv");
            succeed(&["simulate", &fmu, "--log", &log, "-o", &run], folder.path());
            arguments.extend([fmu, format!("{kind}{version}.csv"), run]);
        }
    }
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let message = foreign::script(&python, "gui_of_fmpy.py", &arguments, folder.path());
    print!("{message}");
    let fine = |line: &str| line.starts_with("FMPy's GUI, ") || line.starts_with("SKIPPED");
    assert!(message.lines().all(fine) && !message.is_empty(), "{message}");
    // For whoever wants to see the pages.
    if let Some(keep) = std::env::var_os("PIEZOLOOP_PICTURES") {
        for picture in fs::read_dir(folder.path()).expect("a folder").flatten() {
            if picture.path().extension().is_some_and(|e| e == "png") {
                fs::copy(picture.path(), Path::new(&keep).join(picture.file_name()))
                    .expect("a copy");
            }
        }
    }
}
