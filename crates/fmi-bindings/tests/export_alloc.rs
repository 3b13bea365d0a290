//! After initialisation, set, step, get, save and restore allocate nothing.
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each block calls the edge as an importer does, by the standard's contract"
)]

mod support;

use counting::{Counting, calls};
use fmi_bindings::export::{v2, v3};
use fmi_bindings::fmi2::*;
use fmi_bindings::fmi3::*;
use support::{Fmu, plant};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_million_calls_allocate_nothing() {
    let fmu = Fmu::ready(plant);
    let (input, position) = (fmu.reference("command[1]"), fmu.reference("position[1]"));
    let (gain, moving) = (fmu.reference("axis[1].lag.gain"), fmu.reference("moving[1]"));
    let mut state = fmu.save();
    let (mut time, mut value, mut flag, mut slope) = (0.0, 0.0, 0, 0.0);
    let before = calls();
    for k in 0..100_000 {
        let command = f64::from(k % 50);
        let statuses = unsafe {
            [
                v2::fmi2SetReal(fmu.c, &input, 1, &command),
                v2::fmi2SetReal(fmu.c, &gain, 1, &(1.0 + command / 100.0)),
                v2::fmi2SetRealInputDerivatives(fmu.c, &input, 1, &1, &0.5),
                v2::fmi2GetFMUstate(fmu.c, &mut state),
                v2::fmi2DoStep(fmu.c, time, 1e-3, fmi2False),
                v2::fmi2SetFMUstate(fmu.c, state),
                v2::fmi2DoStep(fmu.c, time, 1e-3, fmi2True),
                v2::fmi2GetReal(fmu.c, &position, 1, &mut value),
                v2::fmi2GetBoolean(fmu.c, &moving, 1, &mut flag),
                v2::fmi2GetDirectionalDerivative(fmu.c, &position, 1, &input, 1, &1.0, &mut slope),
                v2::fmi2GetRealStatus(fmu.c, fmi2LastSuccessfulTime, &mut time),
            ]
        };
        assert_eq!(statuses, [fmi2OK; 11]);
    }
    assert_eq!(calls() - before, 0);
    // The counter counts: an error has a message.
    assert_eq!(fmu.step(-1.0, 1e-3), fmi2Error);
    assert!(calls() > before);
}

#[test]
fn so_does_the_other_version() {
    let token = std::ffi::CString::new(support::components::plant().variables().fingerprint());
    let path = std::ffi::CString::new(support::resources().to_str().unwrap());
    let (none, flag) = (std::ptr::null(), false);
    let fmu = unsafe {
        let fmu = v3::fmi3InstantiateCoSimulation(
            plant,
            c"it".as_ptr(),
            token.unwrap().as_ptr(),
            path.unwrap().as_ptr(),
            flag,
            flag,
            flag,
            flag,
            none,
            0,
            std::ptr::null_mut(),
            None,
            None,
        );
        assert_eq!(v3::fmi3EnterInitializationMode(fmu, flag, 0.0, 0.0, flag, 0.0), fmi3OK);
        assert_eq!(v3::fmi3ExitInitializationMode(fmu), fmi3OK);
        fmu
    };
    let (mut a, mut b, mut c, mut time) = (false, false, false, 0.0);
    let (mut values, mut slopes) = ([0.0; 2], [0.0; 2]);
    let before = calls();
    for k in 0..100_000 {
        let command = [f64::from(k % 50), 1.0];
        let now = time;
        let statuses = unsafe {
            [
                v3::fmi3SetFloat64(fmu, &0, 1, command.as_ptr(), 2),
                v3::fmi3DoStep(fmu, now, 1e-3, true, &mut a, &mut b, &mut c, &mut time),
                v3::fmi3GetFloat64(fmu, &2, 1, values.as_mut_ptr(), 2),
                v3::fmi3GetDirectionalDerivative(
                    fmu,
                    &2,
                    1,
                    &0,
                    1,
                    command.as_ptr(),
                    2,
                    slopes.as_mut_ptr(),
                    2,
                ),
            ]
        };
        assert_eq!(statuses, [fmi3OK; 4]);
    }
    assert_eq!(calls() - before, 0);
    unsafe { v3::fmi3FreeInstance(fmu) };
}
