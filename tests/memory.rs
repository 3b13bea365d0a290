//! Whole lives of our FMUs under valgrind and under the address sanitizer: no wrong access, no leak,
//! no race.
#![cfg(target_os = "linux")]

use crate::common;

use common::packed::{CONTROLLER, Host, PLANT, Packed, random_calls, seed, with};
use common::root;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

const BOTH: [&str; 2] = [PLANT, CONTROLLER];

/// What is run in each version: random calls of all functions in every state, and lives with saved,
/// serialised and restored states, an error, a reset, the end. `run` gets the host and its
/// arguments.
fn lives(
    fmu: &Packed,
    version: &str,
    rounds: &str,
    hosts: &[Host; 2],
    run: impl Fn(&Host, &[String]) -> String,
) {
    run(&hosts[0], &random_calls(fmu, version, rounds));
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("state");
    let file = file.to_str().expect("UTF-8");
    let life = |what: &str| match version {
        "2" => with(fmu.arguments(), &[what, file, "5"]),
        _ => with(with(fmu.arguments(), &fmu.array_values()), &[what, file]),
    };
    let first = run(&hosts[1], &life("write"));
    assert_eq!(run(&hosts[1], &life("read")), first);
}

const SOURCES: [(&str, [&str; 2]); 2] =
    [("2", ["fuzz2.c", "state.c"]), ("3", ["fuzz3.c", "state3.c"])];

/// The library as it is packed.
#[test]
fn valgrind_finds_no_wrong_access_and_no_leak() {
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("SKIPPED: no valgrind");
        return;
    }
    println!("seed {}", seed());
    for (version, sources) in SOURCES {
        let hosts = sources.map(Host::new);
        for blueprint in BOTH {
            let fmu = Packed::new(blueprint, version);
            lives(&fmu, version, "60", &hosts, Host::run_under_valgrind);
        }
    }
}

/// Instances side by side in eight threads. The thread sanitizer would need the standard library compiled
/// with it, which a stable compiler does not have.
#[test]
fn valgrind_finds_no_race_between_instances() {
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("SKIPPED: no valgrind");
        return;
    }
    let host = Host::new("life.c");
    for blueprint in BOTH {
        let fmu = Packed::new(blueprint, "2");
        let arguments = with(fmu.arguments(), &["threads"]);
        for tool in ["helgrind", "drd"] {
            print!("{tool}: {}", host.run_under_checker(tool, &arguments));
        }
    }
}

/// The libraries' sources, compiled so that every access is checked: with the address sanitizer, and
/// with Rust's own checks of overflow, alignment and the preconditions of unsafe functions.
fn checked_libraries() -> Option<PathBuf> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent()?.join("sanitized");
    std::fs::create_dir_all(&target).expect("the target folder is writable");
    let lock = File::create(target.join("lock")).expect("the target folder is writable");
    lock.lock().expect("a lock on the folder");
    // With a target given, build scripts stay as they are.
    let triple = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--quiet", "--locked", "--target", &triple]).current_dir(root());
    cargo.args(["-p", "piezoloop-fmu-blueprint"]);
    for inherited in ["RUSTC_WRAPPER", "RUSTC_WORKSPACE_WRAPPER", "CARGO_ENCODED_RUSTFLAGS"] {
        cargo.env_remove(inherited);
    }
    cargo.env("CARGO_TARGET_DIR", &target).env("RUSTFLAGS", "-Zsanitizer=address");
    // For the lines in the sanitizer's reports.
    cargo.env("CARGO_PROFILE_DEV_DEBUG", "line-tables-only");
    // The flag is one of nightly compilers; the stable one has the runtime, too.
    let output = cargo.env("RUSTC_BOOTSTRAP", "1").output().expect("cargo starts");
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        let first = errors.lines().find(|line| line.starts_with("error")).unwrap_or_default();
        println!("SKIPPED: this compiler builds nothing with the address sanitizer: {first}");
        return None;
    }
    Some(target.join(triple).join("debug"))
}

#[test]
fn the_address_sanitizer_finds_no_wrong_access_and_no_leak() {
    let Some(libraries) = checked_libraries() else { return };
    let Some(overread) = Host::sanitized("overread.c") else { return };
    println!("seed {}", seed());
    for (version, sources) in SOURCES {
        let hosts = sources.map(|source| Host::sanitized(source).expect("as the first"));
        for blueprint in BOTH {
            let fmu = Packed::new(blueprint, version);
            fmu.exchange_library(&libraries.join("libpiezoloop_fmu_blueprint.so"));
            lives(&fmu, version, "300", &hosts, Host::run);
            if version == "2" {
                let host = Host::sanitized("life.c").expect("as the first");
                host.run(&with(fmu.arguments(), &["threads"]));
                // It would have seen something.
                let output = overread.output(&fmu.arguments());
                let message = String::from_utf8_lossy(&output.stderr);
                assert!(!output.status.success(), "the sanitizer sees nothing in the library");
                assert!(
                    message.contains("heap-buffer-overflow") && message.contains("fmi2SetReal")
                );
            }
        }
    }
}
