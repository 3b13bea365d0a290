//! The names of the functions in a library, and their signatures against the standard's types.

/// Exports the 75 functions of FMI 3.0 from a library, in the order of the header, for the models
/// that a [`Factory`](crate::export::Factory) builds. To be used once, in a `cdylib`; the names are
/// others than those of FMI 2.0, so that one library can carry both.
#[macro_export]
macro_rules! export_fmi3 {
    ($factory:path) => {
        $crate::fmi3_symbols! { $crate::export::v3, $factory, }
    };
}

/// The functions of FMI 3.0 as a module has them, which takes the extra argument at instantiation.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi3_symbols {
    ($edge:path, $($factory:path,)?) => {
        /// The functions of FMI 3.0.
        #[allow(non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]
        mod fmi3_symbols {
            use ::std::ffi::c_char;
            use $crate::fmi3::*;

            $crate::forward! { $edge:
                fmi3GetVersion() -> *const c_char;
                fmi3SetDebugLogging(instance: fmi3Instance, loggingOn: fmi3Boolean, nCategories: usize, categories: *const fmi3String) -> fmi3Status;
                fmi3InstantiateModelExchange(instanceName: fmi3String, instantiationToken: fmi3String, resourcePath: fmi3String, visible: fmi3Boolean, loggingOn: fmi3Boolean, instanceEnvironment: fmi3InstanceEnvironment, logMessage: Option<fmi3LogMessageCallback>) -> fmi3Instance;
            }

            /// `fmi3InstantiateCoSimulation` of the standard.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
                instanceName: fmi3String,
                instantiationToken: fmi3String,
                resourcePath: fmi3String,
                visible: fmi3Boolean,
                loggingOn: fmi3Boolean,
                eventModeUsed: fmi3Boolean,
                earlyReturnAllowed: fmi3Boolean,
                requiredIntermediateVariables: *const fmi3ValueReference,
                nRequiredIntermediateVariables: usize,
                instanceEnvironment: fmi3InstanceEnvironment,
                logMessage: Option<fmi3LogMessageCallback>,
                intermediateUpdate: Option<fmi3IntermediateUpdateCallback>,
            ) -> fmi3Instance {
                $crate::export::install_panic_hook();
                use $edge as edge;
                // SAFETY: handed on as the importer, who keeps to the standard, gave it.
                unsafe {
                    edge::fmi3InstantiateCoSimulation(
                        $($factory,)?
                        instanceName,
                        instantiationToken,
                        resourcePath,
                        visible,
                        loggingOn,
                        eventModeUsed,
                        earlyReturnAllowed,
                        requiredIntermediateVariables,
                        nRequiredIntermediateVariables,
                        instanceEnvironment,
                        logMessage,
                        intermediateUpdate,
                    )
                }
            }

            $crate::forward! { $edge:
                fmi3InstantiateScheduledExecution(instanceName: fmi3String, instantiationToken: fmi3String, resourcePath: fmi3String, visible: fmi3Boolean, loggingOn: fmi3Boolean, instanceEnvironment: fmi3InstanceEnvironment, logMessage: Option<fmi3LogMessageCallback>, clockUpdate: Option<fmi3ClockUpdateCallback>, lockPreemption: Option<fmi3LockPreemptionCallback>, unlockPreemption: Option<fmi3UnlockPreemptionCallback>) -> fmi3Instance;
                fmi3FreeInstance(instance: fmi3Instance);
                fmi3EnterInitializationMode(instance: fmi3Instance, toleranceDefined: fmi3Boolean, tolerance: fmi3Float64, startTime: fmi3Float64, stopTimeDefined: fmi3Boolean, stopTime: fmi3Float64) -> fmi3Status;
                fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status;
                fmi3EnterEventMode(instance: fmi3Instance) -> fmi3Status;
                fmi3Terminate(instance: fmi3Instance) -> fmi3Status;
                fmi3Reset(instance: fmi3Instance) -> fmi3Status;
                fmi3GetFloat32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Float32, nValues: usize) -> fmi3Status;
                fmi3GetFloat64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Float64, nValues: usize) -> fmi3Status;
                fmi3GetInt8(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int8, nValues: usize) -> fmi3Status;
                fmi3GetUInt8(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt8, nValues: usize) -> fmi3Status;
                fmi3GetInt16(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int16, nValues: usize) -> fmi3Status;
                fmi3GetUInt16(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt16, nValues: usize) -> fmi3Status;
                fmi3GetInt32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int32, nValues: usize) -> fmi3Status;
                fmi3GetUInt32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt32, nValues: usize) -> fmi3Status;
                fmi3GetInt64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int64, nValues: usize) -> fmi3Status;
                fmi3GetUInt64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt64, nValues: usize) -> fmi3Status;
                fmi3GetBoolean(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Boolean, nValues: usize) -> fmi3Status;
                fmi3GetString(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3String, nValues: usize) -> fmi3Status;
                fmi3GetBinary(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *mut usize, values: *mut fmi3Binary, nValues: usize) -> fmi3Status;
                fmi3GetClock(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Clock) -> fmi3Status;
                fmi3SetFloat32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Float32, nValues: usize) -> fmi3Status;
                fmi3SetFloat64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Float64, nValues: usize) -> fmi3Status;
                fmi3SetInt8(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int8, nValues: usize) -> fmi3Status;
                fmi3SetUInt8(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt8, nValues: usize) -> fmi3Status;
                fmi3SetInt16(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int16, nValues: usize) -> fmi3Status;
                fmi3SetUInt16(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt16, nValues: usize) -> fmi3Status;
                fmi3SetInt32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int32, nValues: usize) -> fmi3Status;
                fmi3SetUInt32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt32, nValues: usize) -> fmi3Status;
                fmi3SetInt64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int64, nValues: usize) -> fmi3Status;
                fmi3SetUInt64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt64, nValues: usize) -> fmi3Status;
                fmi3SetBoolean(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Boolean, nValues: usize) -> fmi3Status;
                fmi3SetString(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3String, nValues: usize) -> fmi3Status;
                fmi3SetBinary(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *const usize, values: *const fmi3Binary, nValues: usize) -> fmi3Status;
                fmi3SetClock(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Clock) -> fmi3Status;
                fmi3GetNumberOfVariableDependencies(instance: fmi3Instance, valueReference: fmi3ValueReference, nDependencies: *mut usize) -> fmi3Status;
                fmi3GetVariableDependencies(instance: fmi3Instance, dependent: fmi3ValueReference, elementIndicesOfDependent: *mut usize, independents: *mut fmi3ValueReference, elementIndicesOfIndependents: *mut usize, dependencyKinds: *mut fmi3DependencyKind, nDependencies: usize) -> fmi3Status;
                fmi3GetFMUState(instance: fmi3Instance, FMUState: *mut fmi3FMUState) -> fmi3Status;
                fmi3SetFMUState(instance: fmi3Instance, FMUState: fmi3FMUState) -> fmi3Status;
                fmi3FreeFMUState(instance: fmi3Instance, FMUState: *mut fmi3FMUState) -> fmi3Status;
                fmi3SerializedFMUStateSize(instance: fmi3Instance, FMUState: fmi3FMUState, size: *mut usize) -> fmi3Status;
                fmi3SerializeFMUState(instance: fmi3Instance, FMUState: fmi3FMUState, serializedState: *mut fmi3Byte, size: usize) -> fmi3Status;
                fmi3DeserializeFMUState(instance: fmi3Instance, serializedState: *const fmi3Byte, size: usize, FMUState: *mut fmi3FMUState) -> fmi3Status;
                fmi3GetDirectionalDerivative(instance: fmi3Instance, unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize, seed: *const fmi3Float64, nSeed: usize, sensitivity: *mut fmi3Float64, nSensitivity: usize) -> fmi3Status;
                fmi3GetAdjointDerivative(instance: fmi3Instance, unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize, seed: *const fmi3Float64, nSeed: usize, sensitivity: *mut fmi3Float64, nSensitivity: usize) -> fmi3Status;
                fmi3EnterConfigurationMode(instance: fmi3Instance) -> fmi3Status;
                fmi3ExitConfigurationMode(instance: fmi3Instance) -> fmi3Status;
                fmi3GetIntervalDecimal(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *mut fmi3Float64, qualifiers: *mut fmi3IntervalQualifier) -> fmi3Status;
                fmi3GetIntervalFraction(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64, qualifiers: *mut fmi3IntervalQualifier) -> fmi3Status;
                fmi3GetShiftDecimal(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *mut fmi3Float64) -> fmi3Status;
                fmi3GetShiftFraction(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64) -> fmi3Status;
                fmi3SetIntervalDecimal(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *const fmi3Float64) -> fmi3Status;
                fmi3SetIntervalFraction(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64) -> fmi3Status;
                fmi3SetShiftDecimal(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *const fmi3Float64) -> fmi3Status;
                fmi3SetShiftFraction(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64) -> fmi3Status;
                fmi3EvaluateDiscreteStates(instance: fmi3Instance) -> fmi3Status;
                fmi3UpdateDiscreteStates(instance: fmi3Instance, discreteStatesNeedUpdate: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean, nominalsOfContinuousStatesChanged: *mut fmi3Boolean, valuesOfContinuousStatesChanged: *mut fmi3Boolean, nextEventTimeDefined: *mut fmi3Boolean, nextEventTime: *mut fmi3Float64) -> fmi3Status;
                fmi3EnterContinuousTimeMode(instance: fmi3Instance) -> fmi3Status;
                fmi3CompletedIntegratorStep(instance: fmi3Instance, noSetFMUStatePriorToCurrentPoint: fmi3Boolean, enterEventMode: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean) -> fmi3Status;
                fmi3SetTime(instance: fmi3Instance, time: fmi3Float64) -> fmi3Status;
                fmi3SetContinuousStates(instance: fmi3Instance, continuousStates: *const fmi3Float64, nContinuousStates: usize) -> fmi3Status;
                fmi3GetContinuousStateDerivatives(instance: fmi3Instance, derivatives: *mut fmi3Float64, nContinuousStates: usize) -> fmi3Status;
                fmi3GetEventIndicators(instance: fmi3Instance, eventIndicators: *mut fmi3Float64, nEventIndicators: usize) -> fmi3Status;
                fmi3GetContinuousStates(instance: fmi3Instance, continuousStates: *mut fmi3Float64, nContinuousStates: usize) -> fmi3Status;
                fmi3GetNominalsOfContinuousStates(instance: fmi3Instance, nominals: *mut fmi3Float64, nContinuousStates: usize) -> fmi3Status;
                fmi3GetNumberOfEventIndicators(instance: fmi3Instance, nEventIndicators: *mut usize) -> fmi3Status;
                fmi3GetNumberOfContinuousStates(instance: fmi3Instance, nContinuousStates: *mut usize) -> fmi3Status;
                fmi3EnterStepMode(instance: fmi3Instance) -> fmi3Status;
                fmi3GetOutputDerivatives(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize, orders: *const fmi3Int32, values: *mut fmi3Float64, nValues: usize) -> fmi3Status;
                fmi3DoStep(instance: fmi3Instance, currentCommunicationPoint: fmi3Float64, communicationStepSize: fmi3Float64, noSetFMUStatePriorToCurrentPoint: fmi3Boolean, eventHandlingNeeded: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean, earlyReturn: *mut fmi3Boolean, lastSuccessfulTime: *mut fmi3Float64) -> fmi3Status;
                fmi3ActivateModelPartition(instance: fmi3Instance, clockReference: fmi3ValueReference, activationTime: fmi3Float64) -> fmi3Status;
            }

            $crate::check_fmi3_signatures!(self);
        }
    };
}

/// Holds each function against the standard's type of that function: another signature does not
/// compile.
#[doc(hidden)]
#[macro_export]
macro_rules! check_fmi3_signatures {
    ($module:ident) => {
        const _: () = {
            let _: fmi3GetVersionTYPE = $module::fmi3GetVersion;
            let _: fmi3SetDebugLoggingTYPE = $module::fmi3SetDebugLogging;
            let _: fmi3InstantiateModelExchangeTYPE = $module::fmi3InstantiateModelExchange;
            let _: fmi3InstantiateCoSimulationTYPE = $module::fmi3InstantiateCoSimulation;
            let _: fmi3InstantiateScheduledExecutionTYPE =
                $module::fmi3InstantiateScheduledExecution;
            let _: fmi3FreeInstanceTYPE = $module::fmi3FreeInstance;
            let _: fmi3EnterInitializationModeTYPE = $module::fmi3EnterInitializationMode;
            let _: fmi3ExitInitializationModeTYPE = $module::fmi3ExitInitializationMode;
            let _: fmi3EnterEventModeTYPE = $module::fmi3EnterEventMode;
            let _: fmi3TerminateTYPE = $module::fmi3Terminate;
            let _: fmi3ResetTYPE = $module::fmi3Reset;
            let _: fmi3GetFloat32TYPE = $module::fmi3GetFloat32;
            let _: fmi3GetFloat64TYPE = $module::fmi3GetFloat64;
            let _: fmi3GetInt8TYPE = $module::fmi3GetInt8;
            let _: fmi3GetUInt8TYPE = $module::fmi3GetUInt8;
            let _: fmi3GetInt16TYPE = $module::fmi3GetInt16;
            let _: fmi3GetUInt16TYPE = $module::fmi3GetUInt16;
            let _: fmi3GetInt32TYPE = $module::fmi3GetInt32;
            let _: fmi3GetUInt32TYPE = $module::fmi3GetUInt32;
            let _: fmi3GetInt64TYPE = $module::fmi3GetInt64;
            let _: fmi3GetUInt64TYPE = $module::fmi3GetUInt64;
            let _: fmi3GetBooleanTYPE = $module::fmi3GetBoolean;
            let _: fmi3GetStringTYPE = $module::fmi3GetString;
            let _: fmi3GetBinaryTYPE = $module::fmi3GetBinary;
            let _: fmi3GetClockTYPE = $module::fmi3GetClock;
            let _: fmi3SetFloat32TYPE = $module::fmi3SetFloat32;
            let _: fmi3SetFloat64TYPE = $module::fmi3SetFloat64;
            let _: fmi3SetInt8TYPE = $module::fmi3SetInt8;
            let _: fmi3SetUInt8TYPE = $module::fmi3SetUInt8;
            let _: fmi3SetInt16TYPE = $module::fmi3SetInt16;
            let _: fmi3SetUInt16TYPE = $module::fmi3SetUInt16;
            let _: fmi3SetInt32TYPE = $module::fmi3SetInt32;
            let _: fmi3SetUInt32TYPE = $module::fmi3SetUInt32;
            let _: fmi3SetInt64TYPE = $module::fmi3SetInt64;
            let _: fmi3SetUInt64TYPE = $module::fmi3SetUInt64;
            let _: fmi3SetBooleanTYPE = $module::fmi3SetBoolean;
            let _: fmi3SetStringTYPE = $module::fmi3SetString;
            let _: fmi3SetBinaryTYPE = $module::fmi3SetBinary;
            let _: fmi3SetClockTYPE = $module::fmi3SetClock;
            let _: fmi3GetNumberOfVariableDependenciesTYPE =
                $module::fmi3GetNumberOfVariableDependencies;
            let _: fmi3GetVariableDependenciesTYPE = $module::fmi3GetVariableDependencies;
            let _: fmi3GetFMUStateTYPE = $module::fmi3GetFMUState;
            let _: fmi3SetFMUStateTYPE = $module::fmi3SetFMUState;
            let _: fmi3FreeFMUStateTYPE = $module::fmi3FreeFMUState;
            let _: fmi3SerializedFMUStateSizeTYPE = $module::fmi3SerializedFMUStateSize;
            let _: fmi3SerializeFMUStateTYPE = $module::fmi3SerializeFMUState;
            let _: fmi3DeserializeFMUStateTYPE = $module::fmi3DeserializeFMUState;
            let _: fmi3GetDirectionalDerivativeTYPE = $module::fmi3GetDirectionalDerivative;
            let _: fmi3GetAdjointDerivativeTYPE = $module::fmi3GetAdjointDerivative;
            let _: fmi3EnterConfigurationModeTYPE = $module::fmi3EnterConfigurationMode;
            let _: fmi3ExitConfigurationModeTYPE = $module::fmi3ExitConfigurationMode;
            let _: fmi3GetIntervalDecimalTYPE = $module::fmi3GetIntervalDecimal;
            let _: fmi3GetIntervalFractionTYPE = $module::fmi3GetIntervalFraction;
            let _: fmi3GetShiftDecimalTYPE = $module::fmi3GetShiftDecimal;
            let _: fmi3GetShiftFractionTYPE = $module::fmi3GetShiftFraction;
            let _: fmi3SetIntervalDecimalTYPE = $module::fmi3SetIntervalDecimal;
            let _: fmi3SetIntervalFractionTYPE = $module::fmi3SetIntervalFraction;
            let _: fmi3SetShiftDecimalTYPE = $module::fmi3SetShiftDecimal;
            let _: fmi3SetShiftFractionTYPE = $module::fmi3SetShiftFraction;
            let _: fmi3EvaluateDiscreteStatesTYPE = $module::fmi3EvaluateDiscreteStates;
            let _: fmi3UpdateDiscreteStatesTYPE = $module::fmi3UpdateDiscreteStates;
            let _: fmi3EnterContinuousTimeModeTYPE = $module::fmi3EnterContinuousTimeMode;
            let _: fmi3CompletedIntegratorStepTYPE = $module::fmi3CompletedIntegratorStep;
            let _: fmi3SetTimeTYPE = $module::fmi3SetTime;
            let _: fmi3SetContinuousStatesTYPE = $module::fmi3SetContinuousStates;
            let _: fmi3GetContinuousStateDerivativesTYPE =
                $module::fmi3GetContinuousStateDerivatives;
            let _: fmi3GetEventIndicatorsTYPE = $module::fmi3GetEventIndicators;
            let _: fmi3GetContinuousStatesTYPE = $module::fmi3GetContinuousStates;
            let _: fmi3GetNominalsOfContinuousStatesTYPE =
                $module::fmi3GetNominalsOfContinuousStates;
            let _: fmi3GetNumberOfEventIndicatorsTYPE = $module::fmi3GetNumberOfEventIndicators;
            let _: fmi3GetNumberOfContinuousStatesTYPE = $module::fmi3GetNumberOfContinuousStates;
            let _: fmi3EnterStepModeTYPE = $module::fmi3EnterStepMode;
            let _: fmi3GetOutputDerivativesTYPE = $module::fmi3GetOutputDerivatives;
            let _: fmi3DoStepTYPE = $module::fmi3DoStep;
            let _: fmi3ActivateModelPartitionTYPE = $module::fmi3ActivateModelPartition;
        };
    };
}
