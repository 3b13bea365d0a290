//! Getting and setting: which variable, which type, when; all or nothing.

use std::ptr::{null, null_mut};

use crate::support::{Fmu, controller, plant};
use fmi_bindings::export::v2;
use fmi_bindings::fmi2::*;

#[test]
fn outputs_follow_inputs_and_parameters_in_the_initialization_mode() {
    let fmu = Fmu::new(plant);
    fmu.set_up(0.0, None);
    fmu.enter();
    assert_eq!(fmu.real("position[1]"), 0.0);
    assert_eq!(fmu.set_real("command[1]", 3.0), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 6.0);
    assert_eq!(fmu.set_real("axis[1].lag.gain", 4.0), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 12.0);
    assert_eq!(fmu.set_boolean("axis[1].double.enabled", fmi2True), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 24.0);
    assert_eq!(fmu.real("position[2]"), 0.0, "the other axis is left alone");
    assert_eq!(fmu.exit(), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 24.0);
}

#[test]
fn parameters_that_disagree_for_a_moment_may_be_set_one_by_one() {
    let fmu = Fmu::new(plant);
    fmu.set_up(0.0, None);
    fmu.enter();
    assert_eq!(fmu.set_real("axis[1].lag.gain", 150.0), fmi2OK);
    assert_eq!(fmu.set_real("axis[1].lag.ceiling", 200.0), fmi2OK);
    assert_eq!(fmu.exit(), fmi2OK);
}

#[test]
fn parameters_that_disagree_in_the_end_are_named_with_value_rule_and_way_out() {
    let fmu = Fmu::new(plant);
    fmu.set_up(0.0, None);
    fmu.set_real("axis[1].lag.gain", 150.0);
    fmu.enter();
    assert_eq!(fmu.exit(), fmi2Error);
    let text = fmu.last();
    for part in ["fmi2ExitInitializationMode", "axis[1].lag.gain", "0.00015", "ceiling", "raise"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn at_communication_points_inputs_are_as_set_and_outputs_as_last_computed() {
    let fmu = Fmu::ready(plant);
    assert_eq!(fmu.set_real("command[1]", 3.0), fmi2OK);
    assert_eq!(fmu.real("command[1]"), 3.0);
    assert_eq!(fmu.real("position[1]"), 0.0, "not before the step");
    assert_eq!(fmu.boolean("moving[1]"), fmi2False);
    assert_eq!(fmu.step(0.0, 1e-3), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 6.0 * (1e-3 / 0.01));
    assert_eq!(fmu.boolean("moving[1]"), fmi2True);
}

#[test]
fn tunable_parameters_act_at_the_next_step_and_fixed_ones_come_too_late() {
    let fmu = Fmu::ready(plant);
    fmu.set_real("command[1]", 1.0);
    assert_eq!(fmu.set_real("axis[1].lag.gain", 10.0), fmi2OK);
    assert_eq!(fmu.real("axis[1].lag.gain"), 10.0);
    assert_eq!(fmu.step(0.0, 1e-3), fmi2OK);
    assert_eq!(fmu.real("position[1]"), 10.0 * (1e-3 / 0.01));
    assert_eq!(fmu.set_real("axis[1].lag.time", 0.02), fmi2Error);
    assert!(fmu.last().contains("axis[1].lag.time (value reference"), "{}", fmu.last());
    assert!(fmu.last().contains("fixed") && fmu.last().contains("reset"), "{}", fmu.last());
}

#[test]
fn a_failing_set_changes_nothing() {
    let fmu = Fmu::new(plant);
    let input = fmu.reference("command[1]");
    let cases: [(u32, f64, &str); 6] = [
        (fmu.reference("position[1]"), 1.0, "position[1]"),
        (fmu.reference("command[2]"), f64::NAN, "command[2]"),
        (fmu.reference("command[2]"), f64::INFINITY, "command[2]"),
        (fmu.reference("axis[1].lag.time"), 0.0, "0.001 to 10"),
        (fmu.reference("axis[1].double.enabled"), 1.0, "Boolean"),
        (99, 1.0, "value reference 99 is unknown"),
    ];
    for (reference, value, part) in cases {
        let fmu = Fmu::new(plant);
        assert_eq!(fmu.set_real("command[1]", 7.0), fmi2OK);
        assert_eq!(fmu.set_reals(&[input, reference], &[8.0, value]), fmi2Error);
        assert!(fmu.last().contains(part), "{part}: {}", fmu.last());
        assert_eq!(fmu.real("command[1]"), 7.0, "{part}");
    }
}

#[test]
fn a_failing_get_writes_nothing() {
    let fmu = Fmu::ready(plant);
    let mut values = [-1.0, -1.0];
    let references = [fmu.reference("position[1]"), 1234];
    let status = unsafe { v2::fmi2GetReal(fmu.c, references.as_ptr(), 2, values.as_mut_ptr()) };
    assert_eq!(status, fmi2Error);
    assert_eq!(values, [-1.0, -1.0]);
    assert!(fmu.last().contains("1234") && fmu.last().contains("0 to "), "{}", fmu.last());
}

#[test]
fn the_functions_of_another_type_name_the_right_one() {
    for function in ["Real", "Integer", "Boolean", "String"] {
        let fmu = Fmu::ready(plant);
        let (position, moving) = (fmu.reference("position[1]"), fmu.reference("moving[1]"));
        let c = fmu.c;
        let (mut real, mut integer, mut text) = (0.0, 0, null());
        let status = unsafe {
            match function {
                "Real" => v2::fmi2GetReal(c, &moving, 1, &mut real),
                "Integer" => v2::fmi2GetInteger(c, &position, 1, &mut integer),
                "Boolean" => v2::fmi2GetBoolean(c, &position, 1, &mut integer),
                _ => v2::fmi2GetString(c, &position, 1, &mut text),
            }
        };
        assert_eq!(status, fmi2Error, "{function}");
        assert!(fmu.last().contains(&format!("not {function}")), "{}", fmu.last());
    }
    let fmu = Fmu::ready(plant);
    let input = fmu.reference("command[1]");
    assert_eq!(unsafe { v2::fmi2SetInteger(fmu.c, &input, 1, &1) }, fmi2Error);
    assert_eq!(fmu.reset(), fmi2OK);
    assert_eq!(unsafe { v2::fmi2SetString(fmu.c, &input, 1, &null()) }, fmi2Error);
}

#[test]
fn a_boolean_input_acts_and_every_int_but_zero_is_true() {
    let fmu = Fmu::ready(controller);
    assert_eq!(fmu.boolean("enable"), fmi2True);
    fmu.set_real("reference[1]", 2.0);
    for (value, command) in [(fmi2False, 0.0), (fmi2True, 6.0), (0, 0.0), (-1, 6.0)] {
        assert_eq!(fmu.set_boolean("enable", value), fmi2OK);
        let mut time = 0.0;
        unsafe { v2::fmi2GetRealStatus(fmu.c, fmi2LastSuccessfulTime, &mut time) };
        assert_eq!(fmu.step(time, 1e-3), fmi2OK);
        assert_eq!(fmu.real("command[1]"), command);
        assert_eq!(fmu.boolean("enable"), fmi2Boolean::from(value != 0));
    }
}

#[test]
fn null_pointers_are_fine_where_nothing_is_needed_and_an_error_where_something_is() {
    let fmu = Fmu::ready(plant);
    let c = fmu.c;
    unsafe {
        assert_eq!(v2::fmi2GetReal(c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(v2::fmi2SetReal(c, null(), 0, null()), fmi2OK);
        assert_eq!(v2::fmi2GetBoolean(c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(v2::fmi2GetString(c, null(), 0, null_mut()), fmi2OK);
        assert_eq!(v2::fmi2SetString(c, null(), 0, null()), fmi2OK);
        assert_eq!(v2::fmi2SetDebugLogging(c, fmi2True, 0, null()), fmi2OK);
        assert_eq!(v2::fmi2SetRealInputDerivatives(c, null(), 0, null(), null()), fmi2OK);
        assert_eq!(v2::fmi2GetRealOutputDerivatives(c, null(), 0, null(), null_mut()), fmi2OK);
    }
    type Call = unsafe fn(fmi2Component) -> fmi2Status;
    const INPUT: u32 = 0;
    let calls: [(Call, &str); 10] = [
        (|c| unsafe { v2::fmi2GetReal(c, null(), 1, &mut 0.0) }, "vr"),
        (|c| unsafe { v2::fmi2GetReal(c, &INPUT, 1, null_mut()) }, "value"),
        (|c| unsafe { v2::fmi2SetReal(c, &INPUT, 1, null()) }, "value"),
        (|c| unsafe { v2::fmi2GetString(c, null(), 1, null_mut()) }, "vr"),
        (|c| unsafe { v2::fmi2SetDebugLogging(c, fmi2True, 1, null()) }, "categories"),
        (|c| unsafe { v2::fmi2GetFMUstate(c, null_mut()) }, "FMUstate"),
        (|c| unsafe { v2::fmi2SetFMUstate(c, null_mut()) }, "FMUstate"),
        (|c| unsafe { v2::fmi2SerializedFMUstateSize(c, null_mut(), &mut 0) }, "FMUstate"),
        (|c| unsafe { v2::fmi2DeSerializeFMUstate(c, null(), 8, &mut null_mut()) }, "serialized"),
        (|c| unsafe { v2::fmi2GetRealStatus(c, fmi2LastSuccessfulTime, null_mut()) }, "value"),
    ];
    for (call, part) in calls {
        let fmu = Fmu::ready(plant);
        assert_eq!(unsafe { call(fmu.c) }, fmi2Error);
        assert!(fmu.last().contains(part) && fmu.last().contains("null"), "{}", fmu.last());
    }
}
