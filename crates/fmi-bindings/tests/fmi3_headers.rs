//! The standard's own C headers of FMI 3.0, compiled against every type of `fmi3.rs`.
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each block calls the edge as an importer does, by the standard's contract"
)]
// Where `c_char` is unsigned, Rust does not tell C's `char` and `unsigned char` apart.
#![cfg(target_arch = "x86_64")]

#[macro_use]
mod c;

use c::{C, check, enumerations, equal, same};
use fmi_bindings::fmi3::*;

fn scalars() -> String {
    all! {
        fmi3Instance fmi3InstanceEnvironment fmi3FMUState fmi3ValueReference fmi3Float32
        fmi3Float64 fmi3Int8 fmi3UInt8 fmi3Int16 fmi3UInt16 fmi3Int32 fmi3UInt32 fmi3Int64
        fmi3UInt64 fmi3Boolean fmi3Char fmi3String fmi3Byte fmi3Binary fmi3Clock
    }
}

fn callbacks() -> String {
    let pointers = [
        ("fmi3LogMessageCallback", <Option<fmi3LogMessageCallback> as C>::c()),
        ("fmi3ClockUpdateCallback", <Option<fmi3ClockUpdateCallback> as C>::c()),
        ("fmi3IntermediateUpdateCallback", <Option<fmi3IntermediateUpdateCallback> as C>::c()),
        ("fmi3LockPreemptionCallback", <Option<fmi3LockPreemptionCallback> as C>::c()),
        ("fmi3UnlockPreemptionCallback", <Option<fmi3UnlockPreemptionCallback> as C>::c()),
    ];
    pointers.into_iter().map(|(name, rust)| same(name, rust)).collect()
}

/// All 75 functions of the standard: type and declaration.
fn functions() -> String {
    functions! {
        fmi3GetVersion: fmi3GetVersionTYPE
        fmi3SetDebugLogging: fmi3SetDebugLoggingTYPE
        fmi3InstantiateModelExchange: fmi3InstantiateModelExchangeTYPE
        fmi3InstantiateCoSimulation: fmi3InstantiateCoSimulationTYPE
        fmi3InstantiateScheduledExecution: fmi3InstantiateScheduledExecutionTYPE
        fmi3FreeInstance: fmi3FreeInstanceTYPE
        fmi3EnterInitializationMode: fmi3EnterInitializationModeTYPE
        fmi3ExitInitializationMode: fmi3ExitInitializationModeTYPE
        fmi3EnterEventMode: fmi3EnterEventModeTYPE
        fmi3Terminate: fmi3TerminateTYPE
        fmi3Reset: fmi3ResetTYPE
        fmi3GetFloat32: fmi3GetFloat32TYPE
        fmi3GetFloat64: fmi3GetFloat64TYPE
        fmi3GetInt8: fmi3GetInt8TYPE
        fmi3GetUInt8: fmi3GetUInt8TYPE
        fmi3GetInt16: fmi3GetInt16TYPE
        fmi3GetUInt16: fmi3GetUInt16TYPE
        fmi3GetInt32: fmi3GetInt32TYPE
        fmi3GetUInt32: fmi3GetUInt32TYPE
        fmi3GetInt64: fmi3GetInt64TYPE
        fmi3GetUInt64: fmi3GetUInt64TYPE
        fmi3GetBoolean: fmi3GetBooleanTYPE
        fmi3GetString: fmi3GetStringTYPE
        fmi3GetBinary: fmi3GetBinaryTYPE
        fmi3GetClock: fmi3GetClockTYPE
        fmi3SetFloat32: fmi3SetFloat32TYPE
        fmi3SetFloat64: fmi3SetFloat64TYPE
        fmi3SetInt8: fmi3SetInt8TYPE
        fmi3SetUInt8: fmi3SetUInt8TYPE
        fmi3SetInt16: fmi3SetInt16TYPE
        fmi3SetUInt16: fmi3SetUInt16TYPE
        fmi3SetInt32: fmi3SetInt32TYPE
        fmi3SetUInt32: fmi3SetUInt32TYPE
        fmi3SetInt64: fmi3SetInt64TYPE
        fmi3SetUInt64: fmi3SetUInt64TYPE
        fmi3SetBoolean: fmi3SetBooleanTYPE
        fmi3SetString: fmi3SetStringTYPE
        fmi3SetBinary: fmi3SetBinaryTYPE
        fmi3SetClock: fmi3SetClockTYPE
        fmi3GetNumberOfVariableDependencies: fmi3GetNumberOfVariableDependenciesTYPE
        fmi3GetVariableDependencies: fmi3GetVariableDependenciesTYPE
        fmi3GetFMUState: fmi3GetFMUStateTYPE
        fmi3SetFMUState: fmi3SetFMUStateTYPE
        fmi3FreeFMUState: fmi3FreeFMUStateTYPE
        fmi3SerializedFMUStateSize: fmi3SerializedFMUStateSizeTYPE
        fmi3SerializeFMUState: fmi3SerializeFMUStateTYPE
        fmi3DeserializeFMUState: fmi3DeserializeFMUStateTYPE
        fmi3GetDirectionalDerivative: fmi3GetDirectionalDerivativeTYPE
        fmi3GetAdjointDerivative: fmi3GetAdjointDerivativeTYPE
        fmi3EnterConfigurationMode: fmi3EnterConfigurationModeTYPE
        fmi3ExitConfigurationMode: fmi3ExitConfigurationModeTYPE
        fmi3GetIntervalDecimal: fmi3GetIntervalDecimalTYPE
        fmi3GetIntervalFraction: fmi3GetIntervalFractionTYPE
        fmi3GetShiftDecimal: fmi3GetShiftDecimalTYPE
        fmi3GetShiftFraction: fmi3GetShiftFractionTYPE
        fmi3SetIntervalDecimal: fmi3SetIntervalDecimalTYPE
        fmi3SetIntervalFraction: fmi3SetIntervalFractionTYPE
        fmi3SetShiftDecimal: fmi3SetShiftDecimalTYPE
        fmi3SetShiftFraction: fmi3SetShiftFractionTYPE
        fmi3EvaluateDiscreteStates: fmi3EvaluateDiscreteStatesTYPE
        fmi3UpdateDiscreteStates: fmi3UpdateDiscreteStatesTYPE
        fmi3EnterContinuousTimeMode: fmi3EnterContinuousTimeModeTYPE
        fmi3CompletedIntegratorStep: fmi3CompletedIntegratorStepTYPE
        fmi3SetTime: fmi3SetTimeTYPE
        fmi3SetContinuousStates: fmi3SetContinuousStatesTYPE
        fmi3GetContinuousStateDerivatives: fmi3GetContinuousStateDerivativesTYPE
        fmi3GetEventIndicators: fmi3GetEventIndicatorsTYPE
        fmi3GetContinuousStates: fmi3GetContinuousStatesTYPE
        fmi3GetNominalsOfContinuousStates: fmi3GetNominalsOfContinuousStatesTYPE
        fmi3GetNumberOfEventIndicators: fmi3GetNumberOfEventIndicatorsTYPE
        fmi3GetNumberOfContinuousStates: fmi3GetNumberOfContinuousStatesTYPE
        fmi3EnterStepMode: fmi3EnterStepModeTYPE
        fmi3GetOutputDerivatives: fmi3GetOutputDerivativesTYPE
        fmi3DoStep: fmi3DoStepTYPE
        fmi3ActivateModelPartition: fmi3ActivateModelPartitionTYPE
    }
}

fn constants() -> String {
    equal(&[
        ("fmi3True", fmi3True.into()),
        ("fmi3False", fmi3False.into()),
        ("fmi3ClockActive", fmi3ClockActive.into()),
        ("fmi3ClockInactive", fmi3ClockInactive.into()),
        ("fmi3OK", fmi3OK.0),
        ("fmi3Warning", fmi3Warning.0),
        ("fmi3Discard", fmi3Discard.0),
        ("fmi3Error", fmi3Error.0),
        ("fmi3Fatal", fmi3Fatal.0),
        ("fmi3Independent", fmi3Independent.0),
        ("fmi3Constant", fmi3Constant.0),
        ("fmi3Fixed", fmi3Fixed.0),
        ("fmi3Tunable", fmi3Tunable.0),
        ("fmi3Discrete", fmi3Discrete.0),
        ("fmi3Dependent", fmi3Dependent.0),
        ("fmi3IntervalNotYetKnown", fmi3IntervalNotYetKnown.0),
        ("fmi3IntervalUnchanged", fmi3IntervalUnchanged.0),
        ("fmi3IntervalChanged", fmi3IntervalChanged.0),
    ]) + &enumerations(&["fmi3Status", "fmi3DependencyKind", "fmi3IntervalQualifier"])
}

#[test]
fn the_headers_of_fmi_3_agree_with_our_types() {
    // The 8-bit integer is spelled as C's `char`, which Rust does not tell apart from it.
    let include = "#include <stdint.h>\n#define int8_t char\n#include \"fmi3Functions.h\"\n";
    let assertions =
        [include.to_owned(), scalars(), callbacks(), functions(), constants()].concat();
    let wrong = ("double*, size_t", "float*, size_t");
    check(&assertions, wrong, "fmi3GetFloat64TYPE");
}
