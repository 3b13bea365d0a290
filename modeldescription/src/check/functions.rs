//! The C functions that a shared library must export, whatever capabilities it offers.
//!
//! Source: `fmi2Functions.h` (2.0.5) and `fmi3Functions.h` (3.0.2); 2.3 (2.0.5) and 2.5 (3.0.2) say
//! that all functions of the offered interface types must be present.

use crate::description::{FmiVersion, ModelDescription};

const COMMON_2: [&str; 25] = [
    "fmi2GetTypesPlatform",
    "fmi2GetVersion",
    "fmi2SetDebugLogging",
    "fmi2Instantiate",
    "fmi2FreeInstance",
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2Terminate",
    "fmi2Reset",
    "fmi2GetReal",
    "fmi2GetInteger",
    "fmi2GetBoolean",
    "fmi2GetString",
    "fmi2SetReal",
    "fmi2SetInteger",
    "fmi2SetBoolean",
    "fmi2SetString",
    "fmi2GetFMUstate",
    "fmi2SetFMUstate",
    "fmi2FreeFMUstate",
    "fmi2SerializedFMUstateSize",
    "fmi2SerializeFMUstate",
    "fmi2DeSerializeFMUstate",
    "fmi2GetDirectionalDerivative",
];

const MODEL_EXCHANGE_2: [&str; 10] = [
    "fmi2EnterEventMode",
    "fmi2NewDiscreteStates",
    "fmi2EnterContinuousTimeMode",
    "fmi2CompletedIntegratorStep",
    "fmi2SetTime",
    "fmi2SetContinuousStates",
    "fmi2GetDerivatives",
    "fmi2GetEventIndicators",
    "fmi2GetContinuousStates",
    "fmi2GetNominalsOfContinuousStates",
];

const CO_SIMULATION_2: [&str; 9] = [
    "fmi2SetRealInputDerivatives",
    "fmi2GetRealOutputDerivatives",
    "fmi2DoStep",
    "fmi2CancelStep",
    "fmi2GetStatus",
    "fmi2GetRealStatus",
    "fmi2GetIntegerStatus",
    "fmi2GetBooleanStatus",
    "fmi2GetStringStatus",
];

const COMMON_3: [&str; 58] = [
    "fmi3GetVersion",
    "fmi3SetDebugLogging",
    "fmi3FreeInstance",
    "fmi3EnterInitializationMode",
    "fmi3ExitInitializationMode",
    "fmi3EnterEventMode",
    "fmi3Terminate",
    "fmi3Reset",
    "fmi3GetFloat32",
    "fmi3GetFloat64",
    "fmi3GetInt8",
    "fmi3GetUInt8",
    "fmi3GetInt16",
    "fmi3GetUInt16",
    "fmi3GetInt32",
    "fmi3GetUInt32",
    "fmi3GetInt64",
    "fmi3GetUInt64",
    "fmi3GetBoolean",
    "fmi3GetString",
    "fmi3GetBinary",
    "fmi3GetClock",
    "fmi3SetFloat32",
    "fmi3SetFloat64",
    "fmi3SetInt8",
    "fmi3SetUInt8",
    "fmi3SetInt16",
    "fmi3SetUInt16",
    "fmi3SetInt32",
    "fmi3SetUInt32",
    "fmi3SetInt64",
    "fmi3SetUInt64",
    "fmi3SetBoolean",
    "fmi3SetString",
    "fmi3SetBinary",
    "fmi3SetClock",
    "fmi3GetNumberOfVariableDependencies",
    "fmi3GetVariableDependencies",
    "fmi3GetFMUState",
    "fmi3SetFMUState",
    "fmi3FreeFMUState",
    "fmi3SerializedFMUStateSize",
    "fmi3SerializeFMUState",
    "fmi3DeserializeFMUState",
    "fmi3GetDirectionalDerivative",
    "fmi3GetAdjointDerivative",
    "fmi3EnterConfigurationMode",
    "fmi3ExitConfigurationMode",
    "fmi3GetIntervalDecimal",
    "fmi3GetIntervalFraction",
    "fmi3GetShiftDecimal",
    "fmi3GetShiftFraction",
    "fmi3SetIntervalDecimal",
    "fmi3SetIntervalFraction",
    "fmi3SetShiftDecimal",
    "fmi3SetShiftFraction",
    "fmi3EvaluateDiscreteStates",
    "fmi3UpdateDiscreteStates",
];

const MODEL_EXCHANGE_3: [&str; 11] = [
    "fmi3InstantiateModelExchange",
    "fmi3EnterContinuousTimeMode",
    "fmi3CompletedIntegratorStep",
    "fmi3SetTime",
    "fmi3SetContinuousStates",
    "fmi3GetContinuousStateDerivatives",
    "fmi3GetEventIndicators",
    "fmi3GetContinuousStates",
    "fmi3GetNominalsOfContinuousStates",
    "fmi3GetNumberOfEventIndicators",
    "fmi3GetNumberOfContinuousStates",
];

const CO_SIMULATION_3: [&str; 4] =
    ["fmi3InstantiateCoSimulation", "fmi3EnterStepMode", "fmi3GetOutputDerivatives", "fmi3DoStep"];

const SCHEDULED_EXECUTION_3: [&str; 2] =
    ["fmi3InstantiateScheduledExecution", "fmi3ActivateModelPartition"];

/// The functions that the libraries of this FMU must export: those common to all interface types and
/// those of the interface types it offers.
pub fn required_functions(description: &ModelDescription) -> Vec<&'static str> {
    let (common, model_exchange, co_simulation): (&[_], &[_], &[_]) = match description.fmi_version
    {
        FmiVersion::V2 => (&COMMON_2, &MODEL_EXCHANGE_2, &CO_SIMULATION_2),
        FmiVersion::V3 => (&COMMON_3, &MODEL_EXCHANGE_3, &CO_SIMULATION_3),
    };
    let mut functions = common.to_vec();
    if description.model_exchange.is_some() {
        functions.extend(model_exchange);
    }
    if description.co_simulation.is_some() {
        functions.extend(co_simulation);
    }
    let is_3 = description.fmi_version == FmiVersion::V3;
    if is_3 && description.scheduled_execution.is_some() {
        functions.extend(SCHEDULED_EXECUTION_3);
    }
    functions
}
