//! Every function in every state, against the table of FMI 2.0.5 §4.2.4.

use std::ptr::null_mut;

use crate::support::{Fmu, plant};
use fmi_bindings::export::{Phase, v2};
use fmi_bindings::fmi2::*;

/// The standard's table for co-simulation: the function, its marks in the states instantiated,
/// initializationMode, stepComplete, terminated and error, and its answer to good arguments there.
const STANDARD: &str = "
fmi2SetDebugLogging                x x x x x  ok
fmi2SetupExperiment                x . . . .  ok
fmi2EnterInitializationMode        x . . . .  ok
fmi2ExitInitializationMode         . x . . .  ok
fmi2Terminate                      . . x . .  ok
fmi2Reset                          x x x x x  ok
fmi2GetReal                        . x x x x  ok
fmi2GetInteger                     . x x x x  ok
fmi2GetBoolean                     . x x x x  ok
fmi2GetString                      . x x x x  ok
fmi2SetReal                        x x x . .  ok
fmi2SetInteger                     x x x . .  ok
fmi2SetBoolean                     x x x . .  ok
fmi2SetString                      x x x . .  ok
fmi2GetFMUstate                    x x x x x  ok
fmi2SetFMUstate                    x x x x x  ok
fmi2FreeFMUstate                   x x x x x  ok
fmi2SerializedFMUstateSize         x x x x x  ok
fmi2SerializeFMUstate              x x x x x  ok
fmi2DeSerializeFMUstate            x x x x x  ok
fmi2GetDirectionalDerivative       . x x x x  ok
fmi2EnterEventMode                 . . . . .  -
fmi2NewDiscreteStates              . . . . .  -
fmi2EnterContinuousTimeMode        . . . . .  -
fmi2CompletedIntegratorStep        . . . . .  -
fmi2SetTime                        . . . . .  -
fmi2SetContinuousStates            . . . . .  -
fmi2GetDerivatives                 . . . . .  -
fmi2GetEventIndicators             . . . . .  -
fmi2GetContinuousStates            . . . . .  -
fmi2GetNominalsOfContinuousStates  . . . . .  -
fmi2SetRealInputDerivatives        x x x . .  ok
fmi2GetRealOutputDerivatives       . . x x x  ok
fmi2DoStep                         . . x . .  ok
fmi2CancelStep                     . . . . .  -
fmi2GetStatus                      . . x x .  discard
fmi2GetRealStatus                  . . x x .  ok
fmi2GetIntegerStatus               . . x x .  discard
fmi2GetBooleanStatus               . . x x .  ok
fmi2GetStringStatus                . . x x .  discard
";

/// An instance in this state, and a saved state of it.
fn in_state(phase: Phase) -> (Fmu, fmi2FMUstate) {
    let fmu = Fmu::new(plant);
    match phase {
        Phase::Instantiated => assert_eq!(fmu.set_up(0.0, None), fmi2OK),
        Phase::Initialization => {
            assert_eq!(fmu.set_up(0.0, None), fmi2OK);
            assert_eq!(fmu.enter(), fmi2OK);
        }
        Phase::Step => fmu.start(0.0),
        Phase::Terminated => {
            fmu.start(0.0);
            assert_eq!(fmu.terminate(), fmi2OK);
        }
        Phase::Error => {
            fmu.start(0.0);
            assert_eq!(fmu.step(0.0, -1.0), fmi2Error);
        }
    }
    let state = fmu.save();
    (fmu, state)
}

/// Calls a function with arguments that are good for the plant.
fn call(function: &str, fmu: &Fmu, state: fmi2FMUstate) -> fmi2Status {
    let c = fmu.c;
    let (input, position) = (fmu.reference("command[1]"), fmu.reference("position[1]"));
    let (moving, switch) = (fmu.reference("moving[1]"), fmu.reference("axis[1].double.enabled"));
    let (mut real, mut integer, mut boolean, mut status) = (0.0, 0, 0, fmi2OK);
    let (mut size, mut text, mut place) = (0, std::ptr::null(), state);
    let mut info = unsafe { std::mem::zeroed::<fmi2EventInfo>() };
    let mut bytes = fmu.bytes(state);
    unsafe {
        match function {
            "fmi2SetDebugLogging" => v2::fmi2SetDebugLogging(c, fmi2False, 0, std::ptr::null()),
            "fmi2SetupExperiment" => v2::fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            "fmi2EnterInitializationMode" => v2::fmi2EnterInitializationMode(c),
            "fmi2ExitInitializationMode" => v2::fmi2ExitInitializationMode(c),
            "fmi2Terminate" => v2::fmi2Terminate(c),
            "fmi2Reset" => v2::fmi2Reset(c),
            "fmi2GetReal" => v2::fmi2GetReal(c, &position, 1, &mut real),
            "fmi2GetInteger" => v2::fmi2GetInteger(c, &input, 0, &mut integer),
            "fmi2GetBoolean" => v2::fmi2GetBoolean(c, &moving, 1, &mut boolean),
            "fmi2GetString" => v2::fmi2GetString(c, &input, 0, &mut text),
            "fmi2SetReal" => v2::fmi2SetReal(c, &input, 1, &1.0),
            "fmi2SetInteger" => v2::fmi2SetInteger(c, &input, 0, &1),
            "fmi2SetBoolean" => v2::fmi2SetBoolean(c, &switch, 0, &1),
            "fmi2SetString" => v2::fmi2SetString(c, &input, 0, &std::ptr::null()),
            "fmi2GetFMUstate" => v2::fmi2GetFMUstate(c, &mut place),
            "fmi2SetFMUstate" => v2::fmi2SetFMUstate(c, state),
            "fmi2FreeFMUstate" => v2::fmi2FreeFMUstate(c, &mut place),
            "fmi2SerializedFMUstateSize" => v2::fmi2SerializedFMUstateSize(c, state, &mut size),
            "fmi2SerializeFMUstate" => {
                v2::fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr().cast(), bytes.len())
            }
            "fmi2DeSerializeFMUstate" => {
                v2::fmi2DeSerializeFMUstate(c, bytes.as_ptr().cast(), bytes.len(), &mut place)
            }
            "fmi2GetDirectionalDerivative" => {
                v2::fmi2GetDirectionalDerivative(c, &position, 1, &input, 1, &1.0, &mut real)
            }
            "fmi2EnterEventMode" => v2::fmi2EnterEventMode(c),
            "fmi2NewDiscreteStates" => v2::fmi2NewDiscreteStates(c, &mut info),
            "fmi2EnterContinuousTimeMode" => v2::fmi2EnterContinuousTimeMode(c),
            "fmi2CompletedIntegratorStep" => {
                v2::fmi2CompletedIntegratorStep(c, 0, &mut boolean, &mut integer)
            }
            "fmi2SetTime" => v2::fmi2SetTime(c, 0.0),
            "fmi2SetContinuousStates" => v2::fmi2SetContinuousStates(c, &real, 0),
            "fmi2GetDerivatives" => v2::fmi2GetDerivatives(c, &mut real, 0),
            "fmi2GetEventIndicators" => v2::fmi2GetEventIndicators(c, &mut real, 0),
            "fmi2GetContinuousStates" => v2::fmi2GetContinuousStates(c, &mut real, 0),
            "fmi2GetNominalsOfContinuousStates" => {
                v2::fmi2GetNominalsOfContinuousStates(c, &mut real, 0)
            }
            "fmi2SetRealInputDerivatives" => {
                v2::fmi2SetRealInputDerivatives(c, &input, 1, &1, &1.0)
            }
            "fmi2GetRealOutputDerivatives" => {
                v2::fmi2GetRealOutputDerivatives(c, &position, 1, &1, &mut real)
            }
            "fmi2DoStep" => v2::fmi2DoStep(c, 0.0, 1e-3, fmi2True),
            "fmi2CancelStep" => v2::fmi2CancelStep(c),
            "fmi2GetStatus" => v2::fmi2GetStatus(c, fmi2DoStepStatus, &mut status),
            "fmi2GetRealStatus" => v2::fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &mut real),
            "fmi2GetIntegerStatus" => v2::fmi2GetIntegerStatus(c, fmi2DoStepStatus, &mut integer),
            "fmi2GetBooleanStatus" => v2::fmi2GetBooleanStatus(c, fmi2Terminated, &mut boolean),
            "fmi2GetStringStatus" => v2::fmi2GetStringStatus(c, fmi2PendingStatus, &mut text),
            other => panic!("the test does not call {other}"),
        }
    }
}

/// Rows of the standard: function, marks, answer.
fn rows() -> impl Iterator<Item = (&'static str, [bool; 5], &'static str)> {
    STANDARD.trim().lines().map(|line| {
        let (function, rest) = line.split_once(' ').unwrap();
        let (marks, answer) = rest.trim_start().split_once("  ").unwrap();
        let marks: Vec<bool> = marks.split(' ').map(|mark| mark == "x").collect();
        (function, marks.try_into().unwrap(), answer.trim())
    })
}

#[test]
fn every_function_in_every_state_answers_as_the_standard_says() {
    let mut pairs = 0;
    for (function, marks, answer) in rows() {
        for (phase, allowed) in Phase::ALL.into_iter().zip(marks) {
            let (fmu, state) = in_state(phase);
            let before = fmu.messages().len();
            let status = call(function, &fmu, state);
            let messages = fmu.messages().split_off(before);
            let place = format!("{function} in {phase}: {messages:?}");
            match (allowed, answer) {
                (true, "ok") => {
                    assert_eq!(status, fmi2OK, "{place}");
                    assert!(messages.is_empty(), "{place}");
                }
                (true, "discard") => {
                    assert_eq!(status, fmi2Discard, "{place}");
                    assert_eq!(messages[0].category, "logStatusDiscard", "{place}");
                }
                (false, _) => {
                    assert_eq!(status, fmi2Error, "{place}");
                    assert_eq!(messages.len(), 1, "{place}");
                    assert!(messages[0].format.starts_with(&format!("{function}: not allowed")));
                    assert!(messages[0].format.contains(&phase.to_string()), "{place}");
                }
                other => panic!("{place}: {other:?}"),
            }
            pairs += 1;
        }
    }
    assert_eq!(pairs, 40 * 5);
}

#[test]
fn the_table_in_the_code_is_the_standards() {
    let code: Vec<_> = v2::TABLE.iter().filter(|r| r.function != "fmi2FreeInstance").collect();
    assert_eq!(code.len(), rows().count());
    for (rule, (function, marks, _)) in code.iter().zip(rows()) {
        assert_eq!(rule.function, function);
        assert_eq!(Phase::ALL.map(|phase| rule.allows(phase)), marks, "{function}");
    }
    // The 44 functions: the rows, and three that need no instance.
    assert_eq!(v2::TABLE.len() + 3, 44);
}

#[test]
fn an_instance_is_freed_in_every_state_and_null_is_ignored() {
    for phase in Phase::ALL {
        let (fmu, _) = in_state(phase);
        drop(fmu);
    }
    unsafe { v2::fmi2FreeInstance(null_mut()) };
    assert_eq!(unsafe { v2::fmi2Reset(null_mut()) }, fmi2Error);
    assert_eq!(unsafe { v2::fmi2DoStep(null_mut(), 0.0, 1.0, 1) }, fmi2Error);
}

#[test]
fn a_wrong_call_leads_to_the_state_error_and_reset_out_of_it() {
    for phase in Phase::ALL {
        let (fmu, _) = in_state(phase);
        assert_eq!(unsafe { v2::fmi2SetTime(fmu.c, 0.0) }, fmi2Error);
        assert_eq!(fmu.terminate(), fmi2Error, "not after an error");
        assert_eq!(fmu.step(0.0, 1e-3), fmi2Error);
        assert!(fmu.last().contains("state Error"), "{}", fmu.last());
        assert_eq!(fmu.reset(), fmi2OK);
        fmu.start(0.0);
        assert_eq!(fmu.step(0.0, 1e-3), fmi2OK);
    }
}

#[test]
fn a_saved_state_leads_out_of_the_state_error_too() {
    let fmu = Fmu::ready(plant);
    let state = fmu.save();
    assert_eq!(fmu.step(0.0, 0.0), fmi2Error);
    assert_eq!(fmu.restore(state), fmi2OK);
    assert_eq!(fmu.step(0.0, 1e-3), fmi2OK);
}

#[test]
fn the_versions_are_the_standards() {
    use std::ffi::CStr;
    let (version, platform) = (v2::fmi2GetVersion(), v2::fmi2GetTypesPlatform());
    assert_eq!(unsafe { CStr::from_ptr(version) }, c"2.0");
    assert_eq!(unsafe { CStr::from_ptr(platform) }, c"default");
}
