//! The functions of FMI 3.0, found in an FMU's library.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::super::binary::{Binary, Finder};
use super::super::error::Error;
use super::super::registry::Loading;
use super::super::text::text_of;
use crate::fmi3::*;

/// The FMI 3.0 functions of one FMU's library that co-simulation uses.
///
/// Those without which nothing can be simulated must be there; an absent other one
/// is an error only when it is needed.
pub struct Library {
    pub(crate) functions: Functions,
    pub(super) events: EventFunctions,
    version: String,
    missing: Vec<&'static str>,
    /// A call returned *Fatal*: none of its instances may be called again.
    pub(crate) dead: AtomicBool,
    // Last, so that it is dropped when no pointer into it is left.
    binary: Binary,
}

/// The functions that only FMUs with events, clocks or structural parameters need.
pub(super) struct EventFunctions {
    pub(super) enter_event_mode: Option<fmi3EnterEventModeTYPE>,
    pub(super) enter_step_mode: Option<fmi3EnterStepModeTYPE>,
    pub(super) update_discrete_states: Option<fmi3UpdateDiscreteStatesTYPE>,
    pub(super) enter_configuration_mode: Option<fmi3EnterConfigurationModeTYPE>,
    pub(super) exit_configuration_mode: Option<fmi3ExitConfigurationModeTYPE>,
    pub(super) get_clock: Option<fmi3GetClockTYPE>,
    pub(super) set_clock: Option<fmi3SetClockTYPE>,
    pub(super) get_interval_decimal: Option<fmi3GetIntervalDecimalTYPE>,
    pub(super) get_shift_decimal: Option<fmi3GetShiftDecimalTYPE>,
}

/// The table of functions. Names are the header's without `fmi3`.
pub(crate) struct Functions {
    pub(crate) instantiate_co_simulation: fmi3InstantiateCoSimulationTYPE,
    pub(crate) free_instance: fmi3FreeInstanceTYPE,
    pub(crate) enter_initialization_mode: fmi3EnterInitializationModeTYPE,
    pub(crate) exit_initialization_mode: fmi3ExitInitializationModeTYPE,
    pub(crate) get_float64: fmi3GetFloat64TYPE,
    pub(crate) set_float64: fmi3SetFloat64TYPE,
    pub(crate) do_step: fmi3DoStepTYPE,

    pub(crate) set_debug_logging: Option<fmi3SetDebugLoggingTYPE>,
    pub(crate) terminate: Option<fmi3TerminateTYPE>,
    pub(crate) reset: Option<fmi3ResetTYPE>,
    pub(crate) get_float32: Option<fmi3GetFloat32TYPE>,
    pub(crate) set_float32: Option<fmi3SetFloat32TYPE>,
    pub(crate) get_int8: Option<fmi3GetInt8TYPE>,
    pub(crate) set_int8: Option<fmi3SetInt8TYPE>,
    pub(crate) get_uint8: Option<fmi3GetUInt8TYPE>,
    pub(crate) set_uint8: Option<fmi3SetUInt8TYPE>,
    pub(crate) get_int16: Option<fmi3GetInt16TYPE>,
    pub(crate) set_int16: Option<fmi3SetInt16TYPE>,
    pub(crate) get_uint16: Option<fmi3GetUInt16TYPE>,
    pub(crate) set_uint16: Option<fmi3SetUInt16TYPE>,
    pub(crate) get_int32: Option<fmi3GetInt32TYPE>,
    pub(crate) set_int32: Option<fmi3SetInt32TYPE>,
    pub(crate) get_uint32: Option<fmi3GetUInt32TYPE>,
    pub(crate) set_uint32: Option<fmi3SetUInt32TYPE>,
    pub(crate) get_int64: Option<fmi3GetInt64TYPE>,
    pub(crate) set_int64: Option<fmi3SetInt64TYPE>,
    pub(crate) get_uint64: Option<fmi3GetUInt64TYPE>,
    pub(crate) set_uint64: Option<fmi3SetUInt64TYPE>,
    pub(crate) get_boolean: Option<fmi3GetBooleanTYPE>,
    pub(crate) set_boolean: Option<fmi3SetBooleanTYPE>,
    pub(crate) get_string: Option<fmi3GetStringTYPE>,
    pub(crate) set_string: Option<fmi3SetStringTYPE>,
    pub(crate) get_fmu_state: Option<fmi3GetFMUStateTYPE>,
    pub(crate) set_fmu_state: Option<fmi3SetFMUStateTYPE>,
    pub(crate) free_fmu_state: Option<fmi3FreeFMUStateTYPE>,
    pub(crate) serialized_fmu_state_size: Option<fmi3SerializedFMUStateSizeTYPE>,
    pub(crate) serialize_fmu_state: Option<fmi3SerializeFMUStateTYPE>,
    pub(crate) deserialize_fmu_state: Option<fmi3DeserializeFMUStateTYPE>,
    pub(crate) get_directional_derivative: Option<fmi3GetDirectionalDerivativeTYPE>,
    pub(crate) get_output_derivatives: Option<fmi3GetOutputDerivativesTYPE>,
}

impl Library {
    /// Loads the library at `path` and finds the functions of FMI 3.0 co-simulation in it.
    ///
    /// # Errors
    /// [`Error::Load`], [`Error::MissingFunctions`] with all that are missing, or
    /// [`Error::WrongVersion`] if the library names another version than 3.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let _loading = Loading::of(path);
        let binary = Binary::load(path)?;
        let version = check_version(&binary)?;
        let mut find = Finder::new(&binary);
        // SAFETY: each name goes with its own type from the standard's headers.
        let functions = unsafe { Functions::find(&mut find) };
        let (needed, other) = find.missing();
        match functions {
            Some(functions) => {
                // SAFETY: as above.
                let events = unsafe { EventFunctions::find(&binary) };
                let (missing, dead) = (other, AtomicBool::new(false));
                Ok(Library { functions, events, version, missing, dead, binary })
            }
            None => Err(Error::MissingFunctions {
                path: binary.path().to_path_buf(),
                version: "3.0",
                names: needed,
            }),
        }
    }

    /// Functions that the standard requires and this library lacks, though simulation can do
    /// without them.
    pub fn missing(&self) -> &[&'static str] {
        &self.missing
    }

    /// What `fmi3GetVersion` answers; empty where it cannot be asked.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Whether it has what event mode needs.
    pub fn has_event_mode(&self) -> bool {
        let EventFunctions { enter_event_mode, enter_step_mode, update_discrete_states, .. } =
            &self.events;
        enter_event_mode.is_some() && enter_step_mode.is_some() && update_discrete_states.is_some()
    }

    /// Any function of the library.
    ///
    /// # Safety
    /// The contract of [`Binary::function`].
    #[cfg(feature = "wrap")]
    pub(crate) unsafe fn function<F: Copy>(&self, name: &str) -> Option<F> {
        // SAFETY: promised by the caller.
        unsafe { self.binary.function(name) }
    }

    /// The loaded file.
    pub fn path(&self) -> &Path {
        self.binary.path()
    }
}

/// Asks the library for its version, of which only the major number matters; a library that
/// cannot be asked is let pass.
fn check_version(binary: &Binary) -> Result<String, Error> {
    let function = "fmi3GetVersion";
    // SAFETY: the function has this type.
    let Some(ask) = (unsafe { binary.function::<fmi3GetVersionTYPE>(function) }) else {
        return Ok(String::new());
    };
    // SAFETY: the standard allows the call at any time; it returns a constant text.
    let found = unsafe { text_of(ask()) };
    if found == "3" || found.starts_with("3.") {
        return Ok(found);
    }
    let path = binary.path().to_path_buf();
    Err(Error::WrongVersion { path, function, found, expected: "3.0" })
}

impl EventFunctions {
    /// # Safety
    /// The library's functions have the types of the standard's headers.
    unsafe fn find(binary: &Binary) -> Self {
        // SAFETY: the field each result goes to has the type of the named function.
        unsafe {
            EventFunctions {
                enter_event_mode: binary.function("fmi3EnterEventMode"),
                enter_step_mode: binary.function("fmi3EnterStepMode"),
                update_discrete_states: binary.function("fmi3UpdateDiscreteStates"),
                enter_configuration_mode: binary.function("fmi3EnterConfigurationMode"),
                exit_configuration_mode: binary.function("fmi3ExitConfigurationMode"),
                get_clock: binary.function("fmi3GetClock"),
                set_clock: binary.function("fmi3SetClock"),
                get_interval_decimal: binary.function("fmi3GetIntervalDecimal"),
                get_shift_decimal: binary.function("fmi3GetShiftDecimal"),
            }
        }
    }
}

impl Functions {
    /// Finds all functions; `None` if a needed one is missing.
    ///
    /// # Safety
    /// The library's functions have the types of the standard's headers.
    #[rustfmt::skip]
    unsafe fn find(find: &mut Finder<'_>) -> Option<Self> {
        // SAFETY: the field each result goes to has the type of the named function.
        unsafe {
            let instantiate_co_simulation = find.needed("fmi3InstantiateCoSimulation");
            let free_instance = find.needed("fmi3FreeInstance");
            let enter_initialization_mode = find.needed("fmi3EnterInitializationMode");
            let exit_initialization_mode = find.needed("fmi3ExitInitializationMode");
            let get_float64 = find.needed("fmi3GetFloat64");
            let set_float64 = find.needed("fmi3SetFloat64");
            let do_step = find.needed("fmi3DoStep");
            Some(Functions {
                set_debug_logging: find.other("fmi3SetDebugLogging"),
                terminate: find.other("fmi3Terminate"),
                reset: find.other("fmi3Reset"),
                get_float32: find.other("fmi3GetFloat32"),
                set_float32: find.other("fmi3SetFloat32"),
                get_int8: find.other("fmi3GetInt8"),
                set_int8: find.other("fmi3SetInt8"),
                get_uint8: find.other("fmi3GetUInt8"),
                set_uint8: find.other("fmi3SetUInt8"),
                get_int16: find.other("fmi3GetInt16"),
                set_int16: find.other("fmi3SetInt16"),
                get_uint16: find.other("fmi3GetUInt16"),
                set_uint16: find.other("fmi3SetUInt16"),
                get_int32: find.other("fmi3GetInt32"),
                set_int32: find.other("fmi3SetInt32"),
                get_uint32: find.other("fmi3GetUInt32"),
                set_uint32: find.other("fmi3SetUInt32"),
                get_int64: find.other("fmi3GetInt64"),
                set_int64: find.other("fmi3SetInt64"),
                get_uint64: find.other("fmi3GetUInt64"),
                set_uint64: find.other("fmi3SetUInt64"),
                get_boolean: find.other("fmi3GetBoolean"),
                set_boolean: find.other("fmi3SetBoolean"),
                get_string: find.other("fmi3GetString"),
                set_string: find.other("fmi3SetString"),
                get_fmu_state: find.other("fmi3GetFMUState"),
                set_fmu_state: find.other("fmi3SetFMUState"),
                free_fmu_state: find.other("fmi3FreeFMUState"),
                serialized_fmu_state_size: find.other("fmi3SerializedFMUStateSize"),
                serialize_fmu_state: find.other("fmi3SerializeFMUState"),
                deserialize_fmu_state: find.other("fmi3DeserializeFMUState"),
                get_directional_derivative: find.other("fmi3GetDirectionalDerivative"),
                get_output_derivatives: find.other("fmi3GetOutputDerivatives"),
                instantiate_co_simulation: instantiate_co_simulation?,
                free_instance: free_instance?,
                enter_initialization_mode: enter_initialization_mode?,
                exit_initialization_mode: exit_initialization_mode?,
                get_float64: get_float64?,
                set_float64: set_float64?,
                do_step: do_step?,
            })
        }
    }
}
