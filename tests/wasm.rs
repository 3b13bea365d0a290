//! FMUs with a WebAssembly component: in wasmtime it is what the shared library is in fmpy.
#![cfg(unix)]

use crate::common;

use std::fs;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::Command;

use common::{json, piezoloop, python, refuse, root, succeed};

const RIGS: [&str; 12] = [
    "evc",
    "p0",
    "p1",
    "p2",
    "p3",
    "p885",
    "p0-machine",
    "p1-machine",
    "p2-machine",
    "p3-machine",
    "p4-machine",
    "evc-truth",
];

#[test]
fn components_compute_what_the_libraries_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    succeed(&["invert", "evc", "-o", "controller.toml"], here);
    let mut command = Command::new(python::python());
    command.arg(root().join("tests/python/component.py")).current_dir(here);
    for model in RIGS.into_iter().chain(["controller.toml"]) {
        let fmu = format!("{}.fmu", model.trim_end_matches(".toml"));
        let message = succeed(&["pack", model, "--fmi", "3", "--wasm", "-o", &fmu], here);
        assert!(message.contains("WebAssembly (component)"), "{message}");
        command.arg(fmu);
    }
    let output = command.output().expect("Python");
    let message = String::from_utf8_lossy(&output.stdout);
    println!("{message}");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(message.contains("13 FMUs, 1500 steps: the same bits"), "{message}");
    assert!(
        succeed(&["check", "evc.fmu"], here).contains("wasm32-wasip2, x86_64-linux: no problem")
    );
}

#[test]
fn a_component_alone_is_an_fmu() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    let packed = json(&["pack", "p1", "--fmi", "3", "--wasm=only", "-o", "only.fmu"], here);
    assert_eq!((&packed["wasm"], &packed["platforms"]), (&true.into(), &serde_json::json!([])));
    assert!(succeed(&["check", "only.fmu"], here).contains("for wasm32-wasip2: no problem"));
    // Nobody here runs it, which is said.
    let message = succeed(&["check", "--replay", "only.fmu"], here);
    assert!(message.contains("no library for this machine is there to repeat them"), "{message}");
    let error = refuse(&["pack", "p1", "--wasm"], here);
    assert!(error.contains("add --fmi 3"), "{error}");
    let error = refuse(&["pack", "p1", "--fmi", "3", "--wasm=only", "--libraries", "there"], here);
    assert!(error.contains("--wasm=only: no library is included"), "{error}");
}

/// What `check` finds, which is not nothing.
fn found(arguments: &[&str], folder: &Path) -> String {
    let output = piezoloop(arguments, folder);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The same archive with one entry exchanged, or without it.
fn changed(from: &Path, to: &Path, entry: &str, content: Option<&[u8]>) {
    let mut from = zip::ZipArchive::new(fs::File::open(from).expect("a file")).expect("an archive");
    let mut into = zip::ZipWriter::new(fs::File::create(to).expect("a file"));
    for at in 0..from.len() {
        let mut old = from.by_index(at).expect("an entry");
        let (name, is_folder) = (old.name().expect("a name").into_owned(), old.is_dir());
        let mut bytes = Vec::new();
        old.read_to_end(&mut bytes).expect("its content");
        match content {
            None if name == entry => continue,
            Some(content) if name == entry => bytes = content.to_vec(),
            _ => {}
        }
        if !is_folder {
            into.start_file(name, zip::write::SimpleFileOptions::default()).expect("an entry");
            into.write_all(&bytes).expect("its content");
        }
    }
    into.finish().expect("an archive");
}

#[test]
fn check_says_what_is_wrong_with_a_component() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    succeed(&["pack", "p1", "--fmi", "3", "--wasm=only", "-o", "good.fmu"], here);
    let (wasm, manifest) =
        ("binaries/wasm32-wasip2/p1.wasm", "extra/org.modelica.fmi-ls-wasm/manifest.xml");
    for (entry, content, wanted) in [
        (wasm, Some(b"\0asm\x01\0\0\0".as_slice()), "it is a WebAssembly module"),
        (wasm, Some(b"#!/bin/sh".as_slice()), "it does not begin as WebAssembly does"),
        (wasm, None, "the FMU has neither binaries nor sources"),
        (manifest, None, "requires the manifest"),
    ] {
        changed(&here.join("good.fmu"), &here.join("bad.fmu"), entry, content);
        let message = found(&["check", "bad.fmu"], here);
        assert!(message.contains(wanted), "{entry}: {message}");
    }
}

/// What commands do with components, in a build that runs them.
#[cfg(feature = "wasm")]
mod run {
    use super::*;
    use common::bench::{Process, port};

    /// The same model as `NAME-library.fmu` and, with a component alone, as `NAME-component.fmu`.
    fn both(model: &str, folder: &Path) -> [String; 2] {
        let stem = model.trim_end_matches(".toml");
        [("library", None), ("component", Some("--wasm=only"))].map(|(kind, more)| {
            let fmu = format!("{stem}-{kind}.fmu");
            let call = [&["pack", model, "--fmi", "3", "-o", &fmu][..], more.as_slice()].concat();
            succeed(&call, folder);
            fmu
        })
    }

    fn same(files: [&str; 2], folder: &Path) {
        let [a, b] = files.map(|file| fs::read_to_string(folder.join(file)).expect(file));
        assert!(a == b && a.lines().count() > 500, "{files:?} differ");
        // Whatever has moved: rows that differ behind the time.
        let rest = |line: &str| line.split_once(',').map(|(_, rest)| rest.to_owned());
        let values: std::collections::HashSet<_> = a.lines().map(rest).collect();
        assert!(values.len() > 100, "{files:?}: it moves");
    }

    #[test]
    fn simulate_writes_what_it_writes_with_the_library() {
        let folder = tempfile::tempdir().expect("a folder");
        let here = folder.path();
        let rows: String = (0..600)
            .map(|k| {
                format!("{},{}\n", 1e-4 * f64::from(k), 3.0 + 2.0 * (0.02 * f64::from(k)).sin())
            })
            .collect();
        fs::write(here.join("log.csv"), format!("time,u\n{rows}")).expect("a log");
        for rig in RIGS {
            let outputs = both(rig, here).map(|fmu| {
                let out = format!("{fmu}.csv");
                let call =
                    ["simulate", &fmu, "--log", "log.csv", "--map", "command[1]=u", "-o", &out];
                succeed(&call, here);
                out
            });
            same([&outputs[0], &outputs[1]], here);
        }
        // In a process of its own.
        let call = ["simulate", "p1-component.fmu", "--log", "log.csv", "--map", "command[1]=u"];
        succeed(&[&call[..], &["--isolate", "-o", "isolated.csv"]].concat(), here);
        same(["p1-library.fmu.csv", "isolated.csv"], here);
    }

    #[test]
    fn loops_and_systems_of_components_are_those_of_libraries() {
        let folder = tempfile::tempdir().expect("a folder");
        let here = folder.path();
        succeed(&["invert", "p1", "--period", "1e-3", "-o", "controller.toml"], here);
        let (plants, controllers) = (both("p1", here), both("controller.toml", here));
        let rows: String = (0..600)
            .map(|k| {
                format!("{},{}\n", 1e-3 * f64::from(k), 10.0 + 5.0 * (0.05 * f64::from(k)).sin())
            })
            .collect();
        fs::write(here.join("reference.csv"), format!("time,reference[1]\n{rows}")).expect("a log");
        let [libraries, components] = [0, 1].map(|kind| {
            let (plant, controller) = (&plants[kind], &controllers[kind]);
            let out = |what: &str| format!("{what}-{kind}.csv");
            let call = ["simulate", "--loop", plant, controller, "--reference", "reference.csv"];
            succeed(&[&call[..], &["-o", &out("loop")]].concat(), here);
            let system = format!(
                "name = \"p1\"\nstep = 1e-3\norder = [\"controller\", \"plant\"]\n\
                 [fmus]\ncontroller = \"{controller}\"\nplant = \"{plant}\"\n\
                 [connections]\n\"plant.command[1]\" = \"controller.command[1]\"\n\
                 \"controller.measured[1]\" = \"plant.position[1]\"\n\
                 [inputs]\n\"controller.reference[1]\" = \"reference[1]\"\n\
                 [record]\n\"command[1]\" = \"plant.command[1]\"\n\"position[1]\" = \"plant.position[1]\"\n"
            );
            fs::write(here.join("system.toml"), system).expect("a system");
            let ssp = format!("system-{kind}.ssp");
            succeed(&["system", "system.toml", "--export", &ssp], here);
            for algorithm in ["gauss-seidel", "iteration"] {
                let call = ["system", &ssp, "--input", "reference.csv", "--algorithm", algorithm];
                succeed(&[&call[..], &["-o", &out(algorithm)]].concat(), here);
            }
            ["loop", "gauss-seidel", "iteration"].map(out)
        });
        for (library, component) in libraries.iter().zip(&components) {
            same([library, component], here);
        }
    }

    #[test]
    fn the_bench_runs_a_component_and_its_library_replays_the_record() {
        let folder = tempfile::tempdir().expect("a folder");
        let here = folder.path();
        succeed(&["invert", "p1", "--period", "1e-3", "-o", "controller.toml"], here);
        let [library, component] = both("controller.toml", here);
        let plan = "rate = 1000\nsettle = 0.1\napproach = 0.1\npatience = 20\n\
                    [[axis]]\ncommand_limits = [-2, 12]\n\
                    [watch]\nhold = 300\nmax_age = 300\n\
                    [[sequence]]\nkind = \"signal\"\nname = \"multisine-odd\"\naxis = 1\noffset = 10\ngain = 0.5\n";
        fs::write(here.join("plan.toml"), plan).expect("a plan");
        let gateway = format!("udp://127.0.0.1:{}", port());
        let machine =
            Process::tool(&["bench", "emulate", "p1", "--gateway", &gateway, "--rate", "1k"], here);
        assert!(machine.first.contains("machine p1"), "{}", machine.first);
        let call = ["bench", "run", &component, "--plan", "plan.toml", "--gateway", &gateway];
        let answer = json(&[&call[..], &["--record", "run.parquet"]].concat(), here);
        assert_eq!(answer["reason"], "the plan has ended", "{answer:#}");
        let again = json(&["bench", "replay", "run.parquet"], here);
        let other = ["bench", "replay", "run.parquet", "--fmu", &library, "--any-fmu"];
        let other = json(&other, here);
        for answer in [again, other] {
            assert_eq!(answer["different"], 0, "{answer:#}");
            assert!(answer["records"][0]["compared"].as_u64() > Some(1000), "{answer:#}");
        }
    }
}
