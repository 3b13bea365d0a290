//! FMUs with a WebAssembly component: in wasmtime it is what the shared library is in fmpy.
#![cfg(unix)]
#![allow(clippy::print_stdout)]

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
