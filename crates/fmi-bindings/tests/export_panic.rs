//! What a library does that has installed the panic hook: nothing is printed, the message has the
//! place. The hook is for the whole process, so this test has its own.
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each block calls the edge as an importer does, by the standard's contract"
)]

mod support;

use fmi_bindings::export::install_panic_hook;
use fmi_bindings::fmi2::*;
use support::{Fmu, plant};

/// Set in the process that panics.
const INSIDE: &str = "PIEZOLOOP_TEST_PANICS";

#[test]
fn a_panic_goes_to_the_logger_with_its_place_and_nowhere_else() {
    if std::env::var_os(INSIDE).is_some() {
        install_panic_hook();
        let fmu = Fmu::ready(plant);
        fmu.set_real("axis[1].lag.fault", 2.0);
        let quiet = fmu.step(0.0, 1e-3);
        let text = fmu.last();
        // Failures of this test are seen by its exit code only: the hook swallows their text.
        let good = quiet == fmi2Error
            && text.contains("a fault on 100%% purpose")
            && text.contains("components.rs:");
        std::process::exit(if good { 0 } else { 1 });
    }
    let done = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "a_panic_goes_to_the_logger_with_its_place_and_nowhere_else"])
        .arg("--nocapture")
        .env(INSIDE, "1")
        .env("RUST_BACKTRACE", "1")
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{printed}");
    assert!(printed.is_empty(), "{printed}");
}
