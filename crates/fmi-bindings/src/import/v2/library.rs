//! The functions of FMI 2.0, found in an FMU's library.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::super::binary::{Binary, Finder};
use super::super::error::Error;
use super::super::registry::Loading;
use super::super::text::text_of;
use crate::fmi2::*;

/// The FMI 2.0 functions of one FMU's library.
///
/// The standard wants all of them in every library (section 2.3); real libraries lack some. Those
/// without which nothing can be simulated must be there; an absent other one is an error only when
/// it is needed, and [`Library::missing`] names it.
pub struct Library {
    pub(crate) functions: Functions,
    missing: Vec<&'static str>,
    /// A call returned *Fatal*: none of its instances may be called again.
    pub(crate) dead: AtomicBool,
    // Last, so that it is dropped when no pointer into it is left.
    binary: Binary,
}

/// The table of functions. Names are the header's without `fmi2`.
pub(crate) struct Functions {
    pub(crate) instantiate: fmi2InstantiateTYPE,
    pub(crate) free_instance: fmi2FreeInstanceTYPE,
    pub(crate) setup_experiment: fmi2SetupExperimentTYPE,
    pub(crate) enter_initialization_mode: fmi2EnterInitializationModeTYPE,
    pub(crate) exit_initialization_mode: fmi2ExitInitializationModeTYPE,
    pub(crate) get_real: fmi2GetRealTYPE,
    pub(crate) set_real: fmi2SetRealTYPE,
    pub(crate) do_step: fmi2DoStepTYPE,

    pub(crate) set_debug_logging: Option<fmi2SetDebugLoggingTYPE>,
    pub(crate) terminate: Option<fmi2TerminateTYPE>,
    pub(crate) reset: Option<fmi2ResetTYPE>,
    pub(crate) get_integer: Option<fmi2GetIntegerTYPE>,
    pub(crate) get_boolean: Option<fmi2GetBooleanTYPE>,
    pub(crate) get_string: Option<fmi2GetStringTYPE>,
    pub(crate) set_integer: Option<fmi2SetIntegerTYPE>,
    pub(crate) set_boolean: Option<fmi2SetBooleanTYPE>,
    pub(crate) set_string: Option<fmi2SetStringTYPE>,
    pub(crate) get_fmu_state: Option<fmi2GetFMUstateTYPE>,
    pub(crate) set_fmu_state: Option<fmi2SetFMUstateTYPE>,
    pub(crate) free_fmu_state: Option<fmi2FreeFMUstateTYPE>,
    pub(crate) serialized_fmu_state_size: Option<fmi2SerializedFMUstateSizeTYPE>,
    pub(crate) serialize_fmu_state: Option<fmi2SerializeFMUstateTYPE>,
    pub(crate) deserialize_fmu_state: Option<fmi2DeSerializeFMUstateTYPE>,
    pub(crate) get_directional_derivative: Option<fmi2GetDirectionalDerivativeTYPE>,
    pub(crate) set_real_input_derivatives: Option<fmi2SetRealInputDerivativesTYPE>,
    pub(crate) get_real_output_derivatives: Option<fmi2GetRealOutputDerivativesTYPE>,
    pub(crate) cancel_step: Option<fmi2CancelStepTYPE>,
    pub(crate) get_status: Option<fmi2GetStatusTYPE>,
    pub(crate) get_real_status: Option<fmi2GetRealStatusTYPE>,
    pub(crate) get_integer_status: Option<fmi2GetIntegerStatusTYPE>,
    pub(crate) get_boolean_status: Option<fmi2GetBooleanStatusTYPE>,
    pub(crate) get_string_status: Option<fmi2GetStringStatusTYPE>,
}

impl Library {
    /// Loads the library at `path` and finds the functions of FMI 2.0 co-simulation in it.
    ///
    /// # Errors
    /// [`Error::Load`], [`Error::MissingFunctions`] with all that are missing, or
    /// [`Error::WrongVersion`] if the library names other C types or another version.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let _loading = Loading::of(path);
        let binary = Binary::load(path)?;
        check_version(&binary)?;
        let mut find = Finder::new(&binary);
        // SAFETY: each name goes with its own type from the standard's headers.
        let functions = unsafe { Functions::find(&mut find) };
        let (needed, other) = find.missing();
        match functions {
            Some(functions) => {
                Ok(Library { functions, missing: other, dead: AtomicBool::new(false), binary })
            }
            None => Err(Error::MissingFunctions {
                path: binary.path().to_path_buf(),
                version: "2.0",
                names: needed,
            }),
        }
    }

    /// Functions that the standard requires and this library lacks, though simulation can do
    /// without them.
    pub fn missing(&self) -> &[&'static str] {
        &self.missing
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

/// Asks the library for its C types and version; a library that cannot be asked is let pass.
fn check_version(binary: &Binary) -> Result<(), Error> {
    let questions = [("fmi2GetTypesPlatform", "default"), ("fmi2GetVersion", "2.0")];
    for (function, expected) in questions {
        // SAFETY: both functions have this one type.
        let Some(ask) = (unsafe { binary.function::<fmi2GetVersionTYPE>(function) }) else {
            continue;
        };
        // SAFETY: the standard allows the call at any time; it returns a constant text.
        let found = unsafe { text_of(ask()) };
        if found != expected {
            let path = binary.path().to_path_buf();
            return Err(Error::WrongVersion { path, function, found, expected });
        }
    }
    Ok(())
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
            let instantiate = find.needed("fmi2Instantiate");
            let free_instance = find.needed("fmi2FreeInstance");
            let setup_experiment = find.needed("fmi2SetupExperiment");
            let enter_initialization_mode = find.needed("fmi2EnterInitializationMode");
            let exit_initialization_mode = find.needed("fmi2ExitInitializationMode");
            let get_real = find.needed("fmi2GetReal");
            let set_real = find.needed("fmi2SetReal");
            let do_step = find.needed("fmi2DoStep");
            Some(Functions {
                set_debug_logging: find.other("fmi2SetDebugLogging"),
                terminate: find.other("fmi2Terminate"),
                reset: find.other("fmi2Reset"),
                get_integer: find.other("fmi2GetInteger"),
                get_boolean: find.other("fmi2GetBoolean"),
                get_string: find.other("fmi2GetString"),
                set_integer: find.other("fmi2SetInteger"),
                set_boolean: find.other("fmi2SetBoolean"),
                set_string: find.other("fmi2SetString"),
                get_fmu_state: find.other("fmi2GetFMUstate"),
                set_fmu_state: find.other("fmi2SetFMUstate"),
                free_fmu_state: find.other("fmi2FreeFMUstate"),
                serialized_fmu_state_size: find.other("fmi2SerializedFMUstateSize"),
                serialize_fmu_state: find.other("fmi2SerializeFMUstate"),
                deserialize_fmu_state: find.other("fmi2DeSerializeFMUstate"),
                get_directional_derivative: find.other("fmi2GetDirectionalDerivative"),
                set_real_input_derivatives: find.other("fmi2SetRealInputDerivatives"),
                get_real_output_derivatives: find.other("fmi2GetRealOutputDerivatives"),
                cancel_step: find.other("fmi2CancelStep"),
                get_status: find.other("fmi2GetStatus"),
                get_real_status: find.other("fmi2GetRealStatus"),
                get_integer_status: find.other("fmi2GetIntegerStatus"),
                get_boolean_status: find.other("fmi2GetBooleanStatus"),
                get_string_status: find.other("fmi2GetStringStatus"),
                instantiate: instantiate?,
                free_instance: free_instance?,
                setup_experiment: setup_experiment?,
                enter_initialization_mode: enter_initialization_mode?,
                exit_initialization_mode: exit_initialization_mode?,
                get_real: get_real?,
                set_real: set_real?,
                do_step: do_step?,
            })
        }
    }
}
