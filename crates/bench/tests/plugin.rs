//! Libraries in C as machines: a good one follows, one that talks nonsense is refused or ends the run in
//! its safe state, with a sentence. Virtual time; skipped where there is no C compiler.
#![cfg(unix)]
#![allow(clippy::print_stdout)]

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::lockstep::{Lockstep, run};
use crate::common::{PERIOD, control_law, controller, cycle};
use bench::gateway::device::Device;
use bench::gateway::{C_HEADER, PluginDevice};
use bench::safety::{Reason, State};

const AXES: usize = 2;

/// The plant of the other tests, in C; from step 300 on it does what its options say.
const CARD: &str = r#"
#include "gateway.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
static double x[128]; static unsigned n; static char what[64]; static long step; static unsigned enabled;
uint32_t piezoloop_gateway_version(void) { return WHICH; }
int32_t piezoloop_gateway_open(const char *o, uint32_t channels, double period, void **card) {
    (void)card; (void)period; n = channels; step = 0; memset(x, 0, sizeof x);
    snprintf(what, sizeof what, "%s", o);
    return strcmp(what, "closed") ? 0 : -7;
}
int32_t piezoloop_gateway_describe(void *c, char *text, uint32_t size) { (void)c; memset(text, 'x', size); return 0; }
int32_t piezoloop_gateway_exchange(void *c, uint32_t enable, const double *u, double *y, uint32_t *count, uint32_t *status) {
    int bad = step++ >= 300;
    (void)c; enabled = enable;
    for (unsigned i = 0; i < n; i++) { x[i] += (0.1 * u[i] - x[i]) / 3.0; x[i] += 1e-9 * sin(1e7 * x[i]); y[i] = x[i]; }
    *count = n; *status = 3;
    if (!bad) return 0;
    if (!strcmp(what, "count")) *count = n - 1;
    if (!strcmp(what, "nan")) y[1] = NAN;
    if (!strcmp(what, "inf")) y[0] = INFINITY;
    if (!strcmp(what, "beyond")) y[n] = 1;
    if (!strcmp(what, "unwritten")) memcpy(&y[1], "\0OZEIP\364\177", 8);
    if (!strcmp(what, "status")) *status = 0xffffffff;
    if (!strcmp(what, "invalid")) *status = 2;
    if (!strcmp(what, "power")) *status = 1;
    if (!strcmp(what, "nothing")) return 1;
    if (!strcmp(what, "error")) return 1234567;
    return 0;
}
const char *piezoloop_gateway_last_error(void *c) { (void)c; return strcmp(what, "closed") ? "the cable is off\xff" : 0; }
#ifndef LEFT_OUT
void piezoloop_gateway_close(void *c) { (void)c; if (enabled) puts("closed while enabled"); }
#endif
"#;

fn built(folder: &Path, name: &str, define: &[&str]) -> Option<PathBuf> {
    std::fs::write(folder.join("gateway.h"), C_HEADER).unwrap();
    std::fs::write(folder.join("card.c"), CARD).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-O2", "-shared", "-fPIC"]);
    let compiled = compiler.args(define).args(["-o", name, "card.c", "-lm"]).current_dir(folder);
    let Ok(compiled) = compiled.output() else {
        println!("SKIPPED: no C compiler `cc`");
        return None;
    };
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    Some(folder.join(name))
}

#[test]
fn nonsense_of_a_library_ends_in_the_safe_state_and_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let Some(library) = built(folder.path(), "card.so", &["-DWHICH=1"]) else { return };
    use Reason::{Finished, PowerLost, SampleInvalid, SampleLost, SampleNotFinite};
    for (what, state, reason, word) in [
        ("", State::Safe, Finished, ""),
        ("count", State::Safe, SampleInvalid, "1 of 2 positions"),
        ("nan", State::Safe, SampleNotFinite, ""),
        ("inf", State::Safe, SampleNotFinite, ""),
        ("beyond", State::Safe, SampleInvalid, "more than 2 positions"),
        ("unwritten", State::Safe, SampleInvalid, "did not write position 2"),
        ("status", State::Safe, SampleInvalid, "0xffffffff"),
        ("invalid", State::Safe, SampleInvalid, ""),
        ("power", State::Fault, PowerLost, ""),
        ("nothing", State::Safe, SampleLost, ""),
        ("error", State::Safe, SampleInvalid, "the cable is off\u{fffd} (code 1234567)"),
    ] {
        let mut device = PluginDevice::open(&library, what, AXES, PERIOD).unwrap();
        assert_eq!(device.describe().map(|text| text.len()), Some(1024), "without its zero");
        let mut gateway = Lockstep::new(Box::new(device), AXES);
        let mut cycle = cycle(AXES, controller(AXES, control_law(AXES)));
        let memory = run(&mut cycle, &mut gateway, 3000);
        assert_eq!((memory.state, memory.reason), (state, reason), "{what}");
        assert!(cycle.at_rest(), "{what}");
        let failure = gateway.bridge.failure().unwrap_or_default();
        assert!(
            failure.contains(word) && failure.is_empty() == word.is_empty(),
            "{what}: {failure}"
        );
    }
}

#[test]
fn what_is_no_gateway_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let Some(newer) = built(at, "newer.so", &["-DWHICH=2"]) else { return };
    let less = built(at, "less.so", &["-DWHICH=1", "-DLEFT_OUT"]).unwrap();
    let good = built(at, "good.so", &["-DWHICH=1"]).unwrap();
    std::fs::write(at.join("text.so"), "no library").unwrap();
    for (library, options, words) in [
        (newer, "", "version 2 of gateway.h, this program speaks version 1"),
        (less, "", "no function piezoloop_gateway_close"),
        (good, "closed", "does not open: it does not say why (code -7)"),
        (at.join("text.so"), "", "cannot be loaded"),
        (at.join("none.so"), "", "No such file"),
    ] {
        let message = PluginDevice::open(&library, options, AXES, PERIOD).unwrap_err();
        assert!(message.contains(words) && message.contains(".so"), "{message}");
    }
}
