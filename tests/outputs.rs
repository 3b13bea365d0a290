//! No output takes the place of an input, of another output, or of a file beside it that the tool did not
//! write; links, devices and permissions stay; numbers that no command can work with are refused.
#![cfg(unix)]

mod common;

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

use common::{refuse, succeed};

const LOG: &str = "time [s],u [V],y [um]\n0,0,0\n0.001,1,1\n0.002,2,2\n0.003,1,1.1\n0.004,0,0.1\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("in.csv"), LOG).expect("the folder is writable");
    folder
}

fn is_unchanged(folder: &Path) {
    assert_eq!(fs::read_to_string(folder.join("in.csv")).unwrap(), LOG);
}

#[test]
fn an_input_is_never_written() {
    let folder = folder();
    let at = folder.path();
    symlink("in.csv", at.join("link.csv")).unwrap();
    for output in ["in.csv", "./in.csv", "link.csv"] {
        let said = refuse(&["log", "in.csv", "-o", output], at);
        assert!(said.contains("give"), "{said}");
        is_unchanged(at);
    }
    let identify =
        ["identify", "--log", "in.csv", "--input", "u", "--output", "y", "-o", "plant.toml"];
    for option in ["--picture", "--report"] {
        refuse(&[&identify[..], &[option, "in.csv"]].concat(), at);
        is_unchanged(at);
    }
    let twice = [&identify[..7], &["-o", "same.html", "--report", "same.html"]].concat();
    let said = refuse(&twice, at);
    assert!(said.contains("twice"), "{said}");
    assert!(!at.join("same.html").exists());
}

#[test]
fn what_a_plan_names_is_not_written() {
    let folder = folder();
    let at = folder.path();
    succeed(&["pack", "p1-truth", "-o", "plant.fmu"], at);
    let before = fs::read(at.join("plant.fmu")).unwrap();
    let plan = "runs = 1\n[diagnose]\nmachine = \"plant.fmu\"\nmodel = \"plant.fmu\"\nlogs = [\"in.csv\"]\n";
    fs::write(at.join("plan.toml"), plan).unwrap();
    refuse(&["sweep", "bundle", "plan.toml", "--table", "t.parquet", "-o", "plant.fmu"], at);
    assert_eq!(fs::read(at.join("plant.fmu")).unwrap(), before);
}

#[test]
fn a_companion_of_another_hand_stays() {
    let folder = folder();
    let at = folder.path();
    let own = "# measured on Monday\n[columns]\ny = { unit = \"nm\" }\n";
    fs::write(at.join("out.dataset.toml"), own).unwrap();
    let said = refuse(&["log", "in.csv", "-o", "out.csv"], at);
    assert!(said.contains("out.dataset.toml") && said.contains("another name"), "{said}");
    assert_eq!(fs::read_to_string(at.join("out.dataset.toml")).unwrap(), own);
    assert!(!at.join("out.csv").exists());
    // Its own it replaces.
    for _ in 0..2 {
        let output = common::piezoloop(&["log", "in.csv", "-o", "new.csv"], at);
        assert!(output.status.code().is_some_and(|code| code < 2), "{output:?}");
    }
}

#[test]
fn links_devices_and_permissions_stay() {
    let folder = folder();
    let at = folder.path();
    symlink("/dev/null", at.join("null")).unwrap();
    symlink("real.fmu", at.join("link.fmu")).unwrap();
    fs::write(at.join("real.fmu"), "old").unwrap();
    fs::set_permissions(at.join("real.fmu"), fs::Permissions::from_mode(0o600)).unwrap();
    for output in ["null", "link.fmu"] {
        succeed(&["pack", "p1-truth", "-o", output], at);
        assert!(fs::symlink_metadata(at.join(output)).unwrap().is_symlink(), "{output}");
    }
    let packed = fs::metadata(at.join("real.fmu")).unwrap();
    assert_eq!(packed.permissions().mode() & 0o777, 0o600);
    assert!(packed.len() > 1000);
    // A pipe is written through.
    assert!(Command::new("mkfifo").arg(at.join("pipe")).status().unwrap().success());
    let pipe = at.join("pipe");
    let reader = std::thread::spawn(move || fs::read(pipe).unwrap());
    succeed(&["pack", "p1-truth", "-o", "pipe"], at);
    assert!(reader.join().unwrap().starts_with(b"PK"));
    assert!(!fs::metadata(at.join("pipe")).unwrap().is_file());
}

#[test]
fn counts_out_of_range_are_refused_before_the_work() {
    let folder = folder();
    let response = ["frequency-response", "in.csv", "--input", "u", "--output", "y"];
    let tune = ["tune", "p1-truth", "--period", "2e-3", "--middle", "5", "--amplitude", "0.5"];
    let diagnose = ["diagnose", "--model", "p1-truth", "--log", "in.csv"];
    let identify = ["identify", "--log", "in.csv", "--input", "u", "--output", "y"];
    let sweep = ["sweep", "plan.toml"];
    let cases: [(&[&str], &str, &[&str]); 8] = [
        (&response, "--period", &["0", "1"]),
        (&response, "--lines", &["0"]),
        (&response, "--modes", &["101"]),
        (&response, "--lags", &["101"]),
        (&tune, "--samples", &["0", "10000000000"]),
        (&diagnose, "--threads", &["100000"]),
        (&identify, "--threads", &["100000"]),
        (&sweep, "--threads", &["100000"]),
    ];
    for (command, option, values) in cases {
        for value in values.iter().chain(&["-1", "NaN", "inf", "1e300", "18446744073709551615", ""])
        {
            let option = format!("{option}={value}");
            let said = refuse(&[command, &[&option]].concat(), folder.path());
            assert!(said.contains("invalid value") && said.contains("--help"), "{option}: {said}");
        }
    }
}
