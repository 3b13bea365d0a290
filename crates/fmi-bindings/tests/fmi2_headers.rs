//! The standard's own C headers of FMI 2.0, compiled against every type of `fmi2.rs`.
//!
//! The C text of each Rust type is derived from the type itself, so a wrong argument there is a
//! failed `_Static_assert` of the C compiler. The headers come with the fmpy wheel.
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each block calls the edge as an importer does, by the standard's contract"
)]
// Where `c_char` is unsigned, Rust does not tell C's `char` and `unsigned char` apart.
#![cfg(target_arch = "x86_64")]

#[macro_use]
mod c;

use std::mem::offset_of;

use c::{C, check, enumerations, equal, same, spelled_field};
use fmi_bindings::fmi2::*;

fn scalars() -> String {
    all! {
        fmi2Component fmi2ComponentEnvironment fmi2FMUstate fmi2ValueReference fmi2Real fmi2Integer
        fmi2Boolean fmi2Char fmi2String fmi2Byte
    }
}

fn callbacks() -> String {
    let pointers = [
        ("fmi2CallbackLogger", <Option<fmi2CallbackLogger> as C>::c()),
        ("fmi2CallbackAllocateMemory", <Option<fmi2CallbackAllocateMemory> as C>::c()),
        ("fmi2CallbackFreeMemory", <Option<fmi2CallbackFreeMemory> as C>::c()),
        ("fmi2StepFinished", <Option<fmi2StepFinished> as C>::c()),
    ];
    pointers.into_iter().map(|(name, rust)| same(name, rust)).collect()
}

/// All 44 functions of the standard: type and declaration.
fn functions() -> String {
    functions! {
        fmi2GetTypesPlatform: fmi2GetTypesPlatformTYPE
        fmi2GetVersion: fmi2GetVersionTYPE
        fmi2SetDebugLogging: fmi2SetDebugLoggingTYPE
        fmi2Instantiate: fmi2InstantiateTYPE
        fmi2FreeInstance: fmi2FreeInstanceTYPE
        fmi2SetupExperiment: fmi2SetupExperimentTYPE
        fmi2EnterInitializationMode: fmi2EnterInitializationModeTYPE
        fmi2ExitInitializationMode: fmi2ExitInitializationModeTYPE
        fmi2Terminate: fmi2TerminateTYPE
        fmi2Reset: fmi2ResetTYPE
        fmi2GetReal: fmi2GetRealTYPE
        fmi2GetInteger: fmi2GetIntegerTYPE
        fmi2GetBoolean: fmi2GetBooleanTYPE
        fmi2GetString: fmi2GetStringTYPE
        fmi2SetReal: fmi2SetRealTYPE
        fmi2SetInteger: fmi2SetIntegerTYPE
        fmi2SetBoolean: fmi2SetBooleanTYPE
        fmi2SetString: fmi2SetStringTYPE
        fmi2GetFMUstate: fmi2GetFMUstateTYPE
        fmi2SetFMUstate: fmi2SetFMUstateTYPE
        fmi2FreeFMUstate: fmi2FreeFMUstateTYPE
        fmi2SerializedFMUstateSize: fmi2SerializedFMUstateSizeTYPE
        fmi2SerializeFMUstate: fmi2SerializeFMUstateTYPE
        fmi2DeSerializeFMUstate: fmi2DeSerializeFMUstateTYPE
        fmi2GetDirectionalDerivative: fmi2GetDirectionalDerivativeTYPE
        fmi2EnterEventMode: fmi2EnterEventModeTYPE
        fmi2NewDiscreteStates: fmi2NewDiscreteStatesTYPE
        fmi2EnterContinuousTimeMode: fmi2EnterContinuousTimeModeTYPE
        fmi2CompletedIntegratorStep: fmi2CompletedIntegratorStepTYPE
        fmi2SetTime: fmi2SetTimeTYPE
        fmi2SetContinuousStates: fmi2SetContinuousStatesTYPE
        fmi2GetDerivatives: fmi2GetDerivativesTYPE
        fmi2GetEventIndicators: fmi2GetEventIndicatorsTYPE
        fmi2GetContinuousStates: fmi2GetContinuousStatesTYPE
        fmi2GetNominalsOfContinuousStates: fmi2GetNominalsOfContinuousStatesTYPE
        fmi2SetRealInputDerivatives: fmi2SetRealInputDerivativesTYPE
        fmi2GetRealOutputDerivatives: fmi2GetRealOutputDerivativesTYPE
        fmi2DoStep: fmi2DoStepTYPE
        fmi2CancelStep: fmi2CancelStepTYPE
        fmi2GetStatus: fmi2GetStatusTYPE
        fmi2GetRealStatus: fmi2GetRealStatusTYPE
        fmi2GetIntegerStatus: fmi2GetIntegerStatusTYPE
        fmi2GetBooleanStatus: fmi2GetBooleanStatusTYPE
        fmi2GetStringStatus: fmi2GetStringStatusTYPE
    }
}

fn constants() -> String {
    equal(&[
        ("fmi2True", fmi2True as u32),
        ("fmi2False", fmi2False as u32),
        ("fmi2OK", fmi2OK.0),
        ("fmi2Warning", fmi2Warning.0),
        ("fmi2Discard", fmi2Discard.0),
        ("fmi2Error", fmi2Error.0),
        ("fmi2Fatal", fmi2Fatal.0),
        ("fmi2Pending", fmi2Pending.0),
        ("fmi2ModelExchange", fmi2ModelExchange.0),
        ("fmi2CoSimulation", fmi2CoSimulation.0),
        ("fmi2DoStepStatus", fmi2DoStepStatus.0),
        ("fmi2PendingStatus", fmi2PendingStatus.0),
        ("fmi2LastSuccessfulTime", fmi2LastSuccessfulTime.0),
        ("fmi2Terminated", fmi2Terminated.0),
    ]) + &enumerations(&["fmi2Status", "fmi2Type", "fmi2StatusKind"])
}

fn structures() -> String {
    layout!(fmi2CallbackFunctions: logger allocateMemory freeMemory stepFinished
        componentEnvironment)
        + &layout!(fmi2EventInfo: newDiscreteStatesNeeded terminateSimulation
        nominalsOfContinuousStatesChanged valuesOfContinuousStatesChanged nextEventTimeDefined
        nextEventTime)
}

#[test]
fn the_headers_of_fmi_2_agree_with_our_types() {
    let assertions = ["#include \"fmi2Functions.h\"\n".to_owned(), scalars(), callbacks()].concat()
        + &functions()
        + &constants()
        + &structures();
    let wrong = ("unsigned int const*, size_t, double*", "double*");
    check(&assertions, wrong, "fmi2GetRealTYPE");
}
