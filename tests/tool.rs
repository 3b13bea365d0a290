//! All tests of the tool, in one program: those that wait for a machine's time leave the processors to others.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod common;

mod all_effects;
mod bad_input;
mod bench;
mod bench_instruments;
mod bench_kills;
mod bench_plugin;
mod bench_replay;
mod blueprint_docs;
mod check_truth;
mod control;
mod dask;
mod docs;
mod estimate;
mod example_system;
mod examples;
mod explains;
mod files;
mod fmi3;
mod fmi_docs;
mod fmi_edge;
mod fmi_rs;
mod fmpy;
mod foreign;
mod frequency_response;
mod gap;
mod gui_of_fmpy;
mod importers;
mod installed;
mod invert;
mod learned_tables;
mod limits;
mod log_files;
mod log_notes;
mod memory;
mod messages;
mod modelica;
mod nested_build;
mod options;
mod outputs;
mod packed_library;
mod packed_results;
mod pages;
mod ports;
mod read_late;
mod real_pea;
mod record_names;
mod repaired;
mod repaired_inside;
mod reproduce;
mod shared_modes;
mod soak;
mod source_fmu;
mod supply;
mod sweep;
mod system;
mod vendors;
mod vendors_diagnose;
mod wasm;

/// A file that is no module would not be compiled, and nobody would see that its tests do not run.
#[test]
fn every_file_beside_this_one_is_one_of_its_modules() {
    let modules = include_str!("tool.rs");
    for entry in std::fs::read_dir(common::root().join("tests")).expect("our own folder") {
        let name = entry.expect("an entry").file_name().into_string().expect("a name in UTF-8");
        let Some(module) = name.strip_suffix(".rs").filter(|name| *name != "tool") else {
            continue;
        };
        assert!(modules.lines().any(|line| line == format!("mod {module};")), "tests/{name}");
    }
}
