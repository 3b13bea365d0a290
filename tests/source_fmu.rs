//! FMUs of C sources: compiled, they are what the shared library is, in values, rules and states.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::packed::{CONTROLLER, Host, PLANT, Packed, headers, random_calls, with};
use common::{json, python, refuse, root, succeed};

/// A compiler command, or none with a line that says why.
fn cc() -> Option<Command> {
    if Command::new("cc").arg("--version").output().is_err() {
        println!("SKIPPED: no C compiler cc is here, so that sources are not compiled");
        return None;
    }
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "-O0", "-I"]).arg(headers());
    Some(cc)
}

fn done(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{command:?}: {message}");
    String::from_utf8_lossy(&output.stdout).into_owned() + &message
}

/// Packs with sources and unpacks them; the folder of `sources`.
fn sources(blueprint: &str, version: &str, folder: &Path) -> PathBuf {
    let arguments = ["pack", blueprint, "--fmi", version, "--sources=only", "-o", "source.fmu"];
    succeed(&arguments, folder);
    let mut zip = zip::ZipArchive::new(fs::File::open(folder.join("source.fmu")).expect("a file"));
    let to = folder.join("unpacked");
    zip.as_mut().expect("an archive").extract(&to).expect("unpacked");
    assert!(!to.join("binaries").exists());
    to.join("sources")
}

#[test]
fn compiled_sources_pass_for_the_shared_library() {
    for (blueprint, version, partition, state, calls) in [
        (PLANT, "2", Some("partition.c"), "state.c", "fuzz2.c"),
        (CONTROLLER, "3", None, "state3.c", "fuzz3.c"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let from = sources(blueprint, version, folder.path());
        let library = folder.path().join("source.so");
        let Some(mut cc) = cc() else { return };
        // A shared library has the names of the standard.
        cc.arg("-DFMI3_OVERRIDE_FUNCTION_PREFIX");
        done(cc.args(["-shared", "-fPIC", "-o"]).arg(&library).arg(from.join("fmu.c")));
        let native = Packed::new(blueprint, version);
        let compiled = Packed::new(blueprint, version);
        compiled.exchange_library(&library);
        let more: &[&str] = if version == "3" { &compiled.array_values() } else { &[] };
        let file = folder.path().join("state");
        let file = file.to_str().expect("UTF-8");
        let host = Host::new(state);
        let run = |fmu: &Packed, what: &str| {
            let rest: &[&str] = if version == "2" { &["0"] } else { &[] };
            let arguments = with(with(fmu.arguments(), more), &[what, file]);
            host.run(&with(arguments, rest))
        };
        // The same outputs to the bit, and the states of one are read by the other.
        let wanted = run(&native, "write");
        assert_eq!(run(&compiled, "read"), wanted);
        assert_eq!(run(&compiled, "write"), wanted);
        assert_eq!(run(&native, "read"), wanted);
        if let Some(partition) = partition {
            Host::new(partition).run(&with(compiled.arguments(), &["41.37", "14"]));
        }
        let host = Host::new(calls);
        let message = host.run(&random_calls(&compiled, version, "300"));
        assert_eq!(message, host.run(&random_calls(&native, version, "300")), "random calls");
        println!("{}: {message}", native.name());
    }
}

#[test]
fn two_fmus_link_into_one_program_and_a_panic_stays_in_its_instance() {
    let folder = tempfile::tempdir().expect("a folder");
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    for path in [&first, &second] {
        fs::create_dir(path).expect("a folder");
    }
    let Some(mut one) = cc() else { return };
    let Some(mut two) = cc() else { return };
    // One in the program's own file, which can break it; the other beside it.
    let program = folder.path().join("program");
    let object = folder.path().join("second.o");
    // The headers of fmpy take no prefix in FMI 2.0, those of the standard do; FMI 3.0 has it in both.
    let beside = sources("p885", "3", &second);
    done(two.arg("-c").arg("-o").arg(&object).arg(beside.join("fmu.c")));
    let text = fs::read_to_string(beside.join("model.h")).expect("a text");
    let token =
        text.split("PIEZOLOOP_TOKEN ").nth(1).and_then(|t| t.lines().next()).expect("a token");
    let from = sources("evc", "3", &first);
    let main = root().join("tests/c/source_two.c");
    one.arg(format!("-DSECOND_TOKEN={token}"));
    done(one.arg("-I").arg(&from).arg(&main).arg(&object).arg("-o").arg(&program));
    let message = done(&mut Command::new(&program));
    assert!(message.contains("capacity overflow"), "{message}");
    println!("{message}");
    let symbols =
        done(Command::new("nm").args(["-g", "--defined-only", "--format=posix"]).arg(&object));
    for line in symbols.lines() {
        assert!(line.starts_with("p885_fmi3"), "a name without the model's prefix: {line}");
    }
}

#[test]
fn a_compiler_that_would_change_the_results_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let from = sources(PLANT, "2", folder.path());
    let Some(mut cc) = cc() else { return };
    let output =
        cc.args(["-ffast-math", "-fsyntax-only"]).arg(from.join("fmu.c")).output().expect("cc");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("without -ffast-math"), "{message}");
}

#[test]
fn pack_says_what_is_in_and_check_and_fmpy_know_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for version in ["2", "3"] {
        let both = json(&["pack", "evc", "--fmi", version, "--sources", "-o", "both.fmu"], at);
        assert!(
            both["sources"] == true && both["platforms"].as_array().is_some_and(|p| p.len() == 1)
        );
        let only = json(&["pack", "evc", "--fmi", version, "--sources=only", "-o", "only.fmu"], at);
        assert!(only["sources"] == true && only["platforms"].as_array().is_some_and(Vec::is_empty));
        for file in ["both.fmu", "only.fmu"] {
            succeed(&["check", file], at);
            let code =
                "import sys, fmpy.validation; print(fmpy.validation.validate_fmu(sys.argv[1]))";
            assert_eq!(python::script(code, &[file], at).trim(), "[]", "{version} {file}");
        }
    }
    let message =
        refuse(&["pack", "evc", "--sources=only", "--binary", "win64=x.dll", "-o", "x.fmu"], at);
    assert!(message.contains("--sources=only"), "{message}");
}
