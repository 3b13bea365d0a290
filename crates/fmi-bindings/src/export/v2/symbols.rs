//! The names of the functions in a library, and their signatures against the standard's types.

/// Writes one exported function per line that calls the one of the same name in a module.
#[doc(hidden)]
#[macro_export]
macro_rules! forward {
    ($module:path: $($function:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        $(
            #[doc = concat!("`", stringify!($function), "` of the standard.")]
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $function($($argument: $type),*) $(-> $result)? {
                use $module as edge;
                #[allow(unused_unsafe)]
                // SAFETY: handed on as the importer, who keeps to the standard, gave it.
                unsafe { edge::$function($($argument),*) }
            }
        )*
    };
}

/// Exports the 44 functions of FMI 2.0 from a library, in the order of the header, for the models
/// that a [`Factory`](crate::export::Factory) builds. To be used once, in a `cdylib`.
#[macro_export]
macro_rules! export_fmi2 {
    ($factory:path) => {
        $crate::fmi2_symbols! { $crate::export::v2, $factory, }
    };
}

/// The functions of FMI 2.0 as a module has them, which takes the extra argument at instantiation.
#[doc(hidden)]
#[macro_export]
macro_rules! fmi2_symbols {
    ($edge:path, $($factory:path,)?) => {
        /// The functions of FMI 2.0.
        #[allow(non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]
        mod fmi2_symbols {
            use ::std::ffi::c_char;
            use $crate::fmi2::*;

            $crate::forward! { $edge:
                fmi2GetTypesPlatform() -> *const c_char;
                fmi2GetVersion() -> *const c_char;
                fmi2SetDebugLogging(c: fmi2Component, loggingOn: fmi2Boolean, nCategories: usize, categories: *const fmi2String) -> fmi2Status;
            }

            /// `fmi2Instantiate` of the standard.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn fmi2Instantiate(
                instanceName: fmi2String,
                fmuType: fmi2Type,
                fmuGUID: fmi2String,
                fmuResourceLocation: fmi2String,
                functions: *const fmi2CallbackFunctions,
                visible: fmi2Boolean,
                loggingOn: fmi2Boolean,
            ) -> fmi2Component {
                $crate::export::install_panic_hook();
                use $edge as edge;
                // SAFETY: handed on as the importer, who keeps to the standard, gave it.
                unsafe {
                    edge::fmi2Instantiate(
                        $($factory,)?
                        instanceName,
                        fmuType,
                        fmuGUID,
                        fmuResourceLocation,
                        functions,
                        visible,
                        loggingOn,
                    )
                }
            }

            $crate::forward! { $edge:
                fmi2FreeInstance(c: fmi2Component);
                fmi2SetupExperiment(c: fmi2Component, toleranceDefined: fmi2Boolean, tolerance: fmi2Real, startTime: fmi2Real, stopTimeDefined: fmi2Boolean, stopTime: fmi2Real) -> fmi2Status;
                fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status;
                fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status;
                fmi2Terminate(c: fmi2Component) -> fmi2Status;
                fmi2Reset(c: fmi2Component) -> fmi2Status;
                fmi2GetReal(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Real) -> fmi2Status;
                fmi2GetInteger(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Integer) -> fmi2Status;
                fmi2GetBoolean(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Boolean) -> fmi2Status;
                fmi2GetString(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2String) -> fmi2Status;
                fmi2SetReal(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Real) -> fmi2Status;
                fmi2SetInteger(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Integer) -> fmi2Status;
                fmi2SetBoolean(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Boolean) -> fmi2Status;
                fmi2SetString(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2String) -> fmi2Status;
                fmi2GetFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status;
                fmi2SetFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status;
                fmi2FreeFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status;
                fmi2SerializedFMUstateSize(c: fmi2Component, FMUstate: fmi2FMUstate, size: *mut usize) -> fmi2Status;
                fmi2SerializeFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate, serializedState: *mut fmi2Byte, size: usize) -> fmi2Status;
                fmi2DeSerializeFMUstate(c: fmi2Component, serializedState: *const fmi2Byte, size: usize, FMUstate: *mut fmi2FMUstate) -> fmi2Status;
                fmi2GetDirectionalDerivative(c: fmi2Component, vUnknown_ref: *const fmi2ValueReference, nUnknown: usize, vKnown_ref: *const fmi2ValueReference, nKnown: usize, dvKnown: *const fmi2Real, dvUnknown: *mut fmi2Real) -> fmi2Status;
                fmi2EnterEventMode(c: fmi2Component) -> fmi2Status;
                fmi2NewDiscreteStates(c: fmi2Component, fmi2eventInfo: *mut fmi2EventInfo) -> fmi2Status;
                fmi2EnterContinuousTimeMode(c: fmi2Component) -> fmi2Status;
                fmi2CompletedIntegratorStep(c: fmi2Component, noSetFMUStatePriorToCurrentPoint: fmi2Boolean, enterEventMode: *mut fmi2Boolean, terminateSimulation: *mut fmi2Boolean) -> fmi2Status;
                fmi2SetTime(c: fmi2Component, time: fmi2Real) -> fmi2Status;
                fmi2SetContinuousStates(c: fmi2Component, x: *const fmi2Real, nx: usize) -> fmi2Status;
                fmi2GetDerivatives(c: fmi2Component, derivatives: *mut fmi2Real, nx: usize) -> fmi2Status;
                fmi2GetEventIndicators(c: fmi2Component, eventIndicators: *mut fmi2Real, ni: usize) -> fmi2Status;
                fmi2GetContinuousStates(c: fmi2Component, x: *mut fmi2Real, nx: usize) -> fmi2Status;
                fmi2GetNominalsOfContinuousStates(c: fmi2Component, x_nominal: *mut fmi2Real, nx: usize) -> fmi2Status;
                fmi2SetRealInputDerivatives(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer, value: *const fmi2Real) -> fmi2Status;
                fmi2GetRealOutputDerivatives(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer, value: *mut fmi2Real) -> fmi2Status;
                fmi2DoStep(c: fmi2Component, currentCommunicationPoint: fmi2Real, communicationStepSize: fmi2Real, noSetFMUStatePriorToCurrentPoint: fmi2Boolean) -> fmi2Status;
                fmi2CancelStep(c: fmi2Component) -> fmi2Status;
                fmi2GetStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Status) -> fmi2Status;
                fmi2GetRealStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status;
                fmi2GetIntegerStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Integer) -> fmi2Status;
                fmi2GetBooleanStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Boolean) -> fmi2Status;
                fmi2GetStringStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2String) -> fmi2Status;
            }

            $crate::check_fmi2_signatures!(self);
        }
    };
}

/// Holds each function against the standard's type of that function: another signature does not
/// compile.
#[doc(hidden)]
#[macro_export]
macro_rules! check_fmi2_signatures {
    ($module:ident) => {
        const _: () = {
            let _: fmi2GetTypesPlatformTYPE = $module::fmi2GetTypesPlatform;
            let _: fmi2GetVersionTYPE = $module::fmi2GetVersion;
            let _: fmi2SetDebugLoggingTYPE = $module::fmi2SetDebugLogging;
            let _: fmi2InstantiateTYPE = $module::fmi2Instantiate;
            let _: fmi2FreeInstanceTYPE = $module::fmi2FreeInstance;
            let _: fmi2SetupExperimentTYPE = $module::fmi2SetupExperiment;
            let _: fmi2EnterInitializationModeTYPE = $module::fmi2EnterInitializationMode;
            let _: fmi2ExitInitializationModeTYPE = $module::fmi2ExitInitializationMode;
            let _: fmi2TerminateTYPE = $module::fmi2Terminate;
            let _: fmi2ResetTYPE = $module::fmi2Reset;
            let _: fmi2GetRealTYPE = $module::fmi2GetReal;
            let _: fmi2GetIntegerTYPE = $module::fmi2GetInteger;
            let _: fmi2GetBooleanTYPE = $module::fmi2GetBoolean;
            let _: fmi2GetStringTYPE = $module::fmi2GetString;
            let _: fmi2SetRealTYPE = $module::fmi2SetReal;
            let _: fmi2SetIntegerTYPE = $module::fmi2SetInteger;
            let _: fmi2SetBooleanTYPE = $module::fmi2SetBoolean;
            let _: fmi2SetStringTYPE = $module::fmi2SetString;
            let _: fmi2GetFMUstateTYPE = $module::fmi2GetFMUstate;
            let _: fmi2SetFMUstateTYPE = $module::fmi2SetFMUstate;
            let _: fmi2FreeFMUstateTYPE = $module::fmi2FreeFMUstate;
            let _: fmi2SerializedFMUstateSizeTYPE = $module::fmi2SerializedFMUstateSize;
            let _: fmi2SerializeFMUstateTYPE = $module::fmi2SerializeFMUstate;
            let _: fmi2DeSerializeFMUstateTYPE = $module::fmi2DeSerializeFMUstate;
            let _: fmi2GetDirectionalDerivativeTYPE = $module::fmi2GetDirectionalDerivative;
            let _: fmi2EnterEventModeTYPE = $module::fmi2EnterEventMode;
            let _: fmi2NewDiscreteStatesTYPE = $module::fmi2NewDiscreteStates;
            let _: fmi2EnterContinuousTimeModeTYPE = $module::fmi2EnterContinuousTimeMode;
            let _: fmi2CompletedIntegratorStepTYPE = $module::fmi2CompletedIntegratorStep;
            let _: fmi2SetTimeTYPE = $module::fmi2SetTime;
            let _: fmi2SetContinuousStatesTYPE = $module::fmi2SetContinuousStates;
            let _: fmi2GetDerivativesTYPE = $module::fmi2GetDerivatives;
            let _: fmi2GetEventIndicatorsTYPE = $module::fmi2GetEventIndicators;
            let _: fmi2GetContinuousStatesTYPE = $module::fmi2GetContinuousStates;
            let _: fmi2GetNominalsOfContinuousStatesTYPE =
                $module::fmi2GetNominalsOfContinuousStates;
            let _: fmi2SetRealInputDerivativesTYPE = $module::fmi2SetRealInputDerivatives;
            let _: fmi2GetRealOutputDerivativesTYPE = $module::fmi2GetRealOutputDerivatives;
            let _: fmi2DoStepTYPE = $module::fmi2DoStep;
            let _: fmi2CancelStepTYPE = $module::fmi2CancelStep;
            let _: fmi2GetStatusTYPE = $module::fmi2GetStatus;
            let _: fmi2GetRealStatusTYPE = $module::fmi2GetRealStatus;
            let _: fmi2GetIntegerStatusTYPE = $module::fmi2GetIntegerStatus;
            let _: fmi2GetBooleanStatusTYPE = $module::fmi2GetBooleanStatus;
            let _: fmi2GetStringStatusTYPE = $module::fmi2GetStringStatus;
        };
    };
}
