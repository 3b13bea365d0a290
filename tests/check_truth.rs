//! `check` tells the truth: what could not be opened is never without problem, no code of an FMU runs
//! unless asked for, and a name in an FMU never leads out of it.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use common::faulty::{Lie, build, has_compiler};
use common::{piezoloop, refuse};
use zip::write::SimpleFileOptions;

/// A sound FMU as an archive, with one entry more.
fn packed(
    folder: &Path,
    name: &str,
    entry: Option<&str>,
    xml: impl Fn(Vec<u8>) -> Vec<u8>,
) -> PathBuf {
    let unpacked = folder.join(build(folder, "unpacked", &["FAULT=SOUND", "ALL"], Lie::None));
    let archive = folder.join(name);
    let mut zip = zip::ZipWriter::new(File::create(&archive).expect("writable"));
    let mut add = |name: &str, bytes: &[u8]| {
        zip.start_file(name, SimpleFileOptions::default()).expect("an entry");
        zip.write_all(bytes).expect("written");
    };
    let library = fs::read_dir(unpacked.join("binaries")).expect("a folder").next();
    let platform = library.expect("one").expect("one").file_name().to_string_lossy().into_owned();
    let library = format!("binaries/{platform}/faulty.so");
    add(
        "modelDescription.xml",
        &xml(fs::read(unpacked.join("modelDescription.xml")).expect("there")),
    );
    add(&library, &fs::read(unpacked.join(&library)).expect("there"));
    if let Some(entry) = entry {
        add(entry, b"content");
    }
    zip.finish().expect("an archive");
    archive
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Checks with this folder for temporary files.
fn check_in(temporary: &str, fmus: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_piezoloop"));
    command.arg("check").args(fmus).current_dir(folder).env("TMPDIR", temporary);
    command.output().expect("the tool starts")
}

#[test]
fn what_cannot_be_opened_is_not_without_problem() {
    if !has_compiler() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    packed(at, "sound.fmu", None, |xml| xml);
    let output = piezoloop(&["check", "sound.fmu"], at);
    assert!(
        message(&output).contains("no problem") && output.status.success(),
        "{}",
        message(&output)
    );
    // Nowhere to unpack it.
    let output = check_in("/nowhere/at/all", &["sound.fmu"], at);
    assert_eq!(output.status.code(), Some(2), "{}", message(&output));
    let text = message(&output);
    assert!(text.contains("sound.fmu") && !text.contains("no problem"), "{text}");
    // A name that no file system holds, a name that is too long as a whole.
    for (name, length) in [("part.fmu", 300), ("whole.fmu", 2000)] {
        let entry =
            format!("resources/{}", "x/".repeat(length / 400 * 400) + &"n".repeat(length % 400));
        packed(at, name, Some(&entry), |xml| xml);
        let output = piezoloop(&["check", name], at);
        assert_eq!(output.status.code(), Some(1), "{}", message(&output));
        assert!(!message(&output).contains("no problem"), "{}", message(&output));
    }
    // Characters that no XML holds, wherever they stand.
    for (number, byte) in [0_u8, 1, 0x0b, 0x1f].into_iter().enumerate() {
        for place in ["<ModelVariables>", "modelName=\"", "<?xml"] {
            let name = format!("byte{number}.fmu");
            let spoiled = |xml: Vec<u8>| {
                let text = String::from_utf8(xml).expect("UTF-8");
                let at = text.find(place).expect(place) + place.len();
                let mut bytes = text.into_bytes();
                bytes.insert(at, byte);
                bytes
            };
            packed(at, &name, None, spoiled);
            let output = piezoloop(&["check", &name], at);
            assert_eq!(output.status.code(), Some(1), "{byte} in {place}: {}", message(&output));
            assert!(message(&output).contains("modelDescription.xml:"), "{}", message(&output));
        }
    }
}

#[test]
fn one_missing_file_does_not_hide_the_others() {
    if !has_compiler() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    packed(at, "sound.fmu", None, |xml| xml);
    fs::write(at.join("text.fmu"), "no archive").expect("writable");
    let output = piezoloop(&["check", "missing.fmu", "sound.fmu", "text.fmu"], at);
    let text = message(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    for words in
        ["missing.fmu: not checked: cannot read", "sound.fmu: \"faulty\", FMI 2.0", "text.fmu"]
    {
        assert!(text.contains(words), "\"{words}\" is not in {text}");
    }
    // Alone it is an error as of every command.
    let text = refuse(&["check", "missing.fmu"], at);
    assert!(text.starts_with("error:") && text.contains("missing.fmu"), "{text}");
}

/// Puts reference results of two rows beside an unpacked FMU.
fn with_reference(fmu: &Path) {
    let reference = fmu.join("extra/io.github.piezoloop/reference");
    fs::create_dir_all(&reference).expect("a folder");
    let about = "format = 1\ntool = \"t\"\nrows = 12\nstep = 0.1\ntolerance = 1e-9\n";
    fs::write(reference.join("reference.toml"), about).expect("writable");
    let rows = |head: &str| {
        let row = |k: usize| format!("{},0\n", k as f64 / 10.0);
        format!("time,{head}\n{}", (0..12).map(row).collect::<String>())
    };
    fs::write(reference.join("input.csv"), rows("command[1]")).expect("writable");
    fs::write(reference.join("output.csv"), rows("position[1]")).expect("writable");
}

#[test]
fn code_runs_only_with_replay_and_never_succeeds_by_leaving() {
    if !has_compiler() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for fault in ["CRASH_LOAD", "HANG_STEP", "FLOOD", "EXIT_STEP", "EXIT_GET", "SIGPIPE_STEP"] {
        let fmu = build(at, fault, &[&format!("FAULT={fault}"), "ALL"], Lie::None);
        with_reference(&at.join(&fmu));
        let output = piezoloop(&["check", &fmu], at);
        let text = message(&output);
        assert!(
            output.status.success() && text.contains("--replay runs its code"),
            "{fault}: {text}"
        );
        let begin = Instant::now();
        let output = piezoloop(&["check", &fmu, "--replay", "--timeout", "2"], at);
        let text = message(&output);
        assert_eq!(output.status.code(), Some(1), "{fault}: {text}");
        assert!(text.contains("the reference results cannot be repeated"), "{fault}: {text}");
        assert!(begin.elapsed() < Duration::from_secs(20), "{fault}: {:?}", begin.elapsed());
    }
    let fmu = build(at, "SOUND", &["FAULT=SOUND", "ALL"], Lie::None);
    with_reference(&at.join(&fmu));
    let output = piezoloop(&["check", &fmu, "--replay"], at);
    assert!(output.status.success(), "{}", message(&output));
    assert!(message(&output).contains("reference results repeated"), "{}", message(&output));
}

#[test]
fn a_model_identifier_never_leads_out_of_the_fmu() {
    if !has_compiler() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("log.csv"), "time,command[1]\n0,1\n1,1\n").expect("writable");
    let fmu = at.join(build(at, "inside", &["FAULT=SOUND", "ALL"], Lie::None));
    let other = at.join(build(at, "outside", &["FAULT=CRASH_LOAD"], Lie::None));
    let platform = fs::read_dir(other.join("binaries")).expect("a folder").next();
    let platform = platform.expect("one").expect("one").path();
    fs::rename(platform.join("faulty.so"), at.join("evil.so")).expect("moved");
    let text = fs::read_to_string(fmu.join("modelDescription.xml")).expect("there");
    let absolute = at.join("evil").display().to_string();
    for identifier in
        [absolute.as_str(), "../../../evil", "..", ".", "", "a/../../../../evil", "C:evil", "a\\b"]
    {
        let lie = text
            .replace("modelIdentifier=\"faulty\"", &format!("modelIdentifier=\"{identifier}\""));
        assert_ne!(lie, text);
        fs::write(fmu.join("modelDescription.xml"), lie).expect("writable");
        for more in [&[][..], &["--isolate"]] {
            let message =
                refuse(&[&["simulate", "inside.fmu", "--log", "log.csv"], more].concat(), at);
            assert!(message.contains("is no file name"), "{identifier}: {message}");
        }
        let output = piezoloop(&["check", "inside.fmu"], at);
        assert_eq!(output.status.code(), Some(1), "{identifier}: {}", message(&output));
    }
}
