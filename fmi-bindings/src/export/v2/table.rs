//! The call table of FMI 2.0.5 §4.2.4 for co-simulation, without the states that cannot be reached
//! here (stepInProgress, stepFailed, stepCanceled).

use crate::export::Rule;

macro_rules! table {
    ($($name:ident $function:ident $marks:literal)*) => {
        $(pub(super) const $name: Rule = Rule::new(stringify!($function), $marks);)*
        /// All rows, in the order of the header; functions that need no instance are left out.
        pub const TABLE: &[Rule] = &[$($name),*];
    };
}

table! {
    //  instantiated, initializationMode, stepComplete, terminated, error: I M S T E
    SET_DEBUG_LOGGING             fmi2SetDebugLogging               "x x x x x"
    FREE_INSTANCE                 fmi2FreeInstance                  "x x x x x"
    SETUP_EXPERIMENT              fmi2SetupExperiment               "x . . . ."
    ENTER_INITIALIZATION_MODE     fmi2EnterInitializationMode       "x . . . ."
    EXIT_INITIALIZATION_MODE      fmi2ExitInitializationMode        ". x . . ."
    TERMINATE                     fmi2Terminate                     ". . x . ."
    RESET                         fmi2Reset                         "x x x x x"
    GET_REAL                      fmi2GetReal                       ". x x x x"
    GET_INTEGER                   fmi2GetInteger                    ". x x x x"
    GET_BOOLEAN                   fmi2GetBoolean                    ". x x x x"
    GET_STRING                    fmi2GetString                     ". x x x x"
    SET_REAL                      fmi2SetReal                       "x x x . ."
    SET_INTEGER                   fmi2SetInteger                    "x x x . ."
    SET_BOOLEAN                   fmi2SetBoolean                    "x x x . ."
    SET_STRING                    fmi2SetString                     "x x x . ."
    GET_FMU_STATE                 fmi2GetFMUstate                   "x x x x x"
    SET_FMU_STATE                 fmi2SetFMUstate                   "x x x x x"
    FREE_FMU_STATE                fmi2FreeFMUstate                  "x x x x x"
    SERIALIZED_FMU_STATE_SIZE     fmi2SerializedFMUstateSize        "x x x x x"
    SERIALIZE_FMU_STATE           fmi2SerializeFMUstate             "x x x x x"
    DESERIALIZE_FMU_STATE         fmi2DeSerializeFMUstate           "x x x x x"
    GET_DIRECTIONAL_DERIVATIVE    fmi2GetDirectionalDerivative      ". x x x x"
    ENTER_EVENT_MODE              fmi2EnterEventMode                ". . . . ."
    NEW_DISCRETE_STATES           fmi2NewDiscreteStates             ". . . . ."
    ENTER_CONTINUOUS_TIME_MODE    fmi2EnterContinuousTimeMode       ". . . . ."
    COMPLETED_INTEGRATOR_STEP     fmi2CompletedIntegratorStep       ". . . . ."
    SET_TIME                      fmi2SetTime                       ". . . . ."
    SET_CONTINUOUS_STATES         fmi2SetContinuousStates           ". . . . ."
    GET_DERIVATIVES               fmi2GetDerivatives                ". . . . ."
    GET_EVENT_INDICATORS          fmi2GetEventIndicators            ". . . . ."
    GET_CONTINUOUS_STATES         fmi2GetContinuousStates           ". . . . ."
    GET_NOMINALS                  fmi2GetNominalsOfContinuousStates ". . . . ."
    SET_REAL_INPUT_DERIVATIVES    fmi2SetRealInputDerivatives       "x x x . ."
    GET_REAL_OUTPUT_DERIVATIVES   fmi2GetRealOutputDerivatives      ". . x x x"
    DO_STEP                       fmi2DoStep                        ". . x . ."
    CANCEL_STEP                   fmi2CancelStep                    ". . . . ."
    GET_STATUS                    fmi2GetStatus                     ". . x x ."
    GET_REAL_STATUS               fmi2GetRealStatus                 ". . x x ."
    GET_INTEGER_STATUS            fmi2GetIntegerStatus              ". . x x ."
    GET_BOOLEAN_STATUS            fmi2GetBooleanStatus              ". . x x ."
    GET_STRING_STATUS             fmi2GetStringStatus               ". . x x ."
}
