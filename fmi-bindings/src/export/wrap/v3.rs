//! The functions of FMI 3.0 of a repaired FMU, in the order of the header.
//!
//! # Safety
//! As [`export::v3`](crate::export::v3).
#![allow(
    non_snake_case,
    non_upper_case_globals,
    clippy::missing_safety_doc,
    clippy::too_many_arguments
)]

use std::ffi::{CStr, c_void};

use super::core::{
    Answer, Around, CATEGORY, Code, DISCARD, ERROR, OK, Original, Saved, Wrapped, call as guarded,
    send, state,
};
use super::file::{Files, PLATFORM_V3};
use crate::export::arguments::{Room, array, text, texts};
use crate::export::guard::{self, Notice};
use crate::export::log::Sink;
use crate::export::resources::Location;
use crate::fmi3::*;
use crate::import::v3::Library;

pub use crate::export::v3::fmi3GetVersion;

/// The original.
struct Inner {
    instance: fmi3Instance,
    library: Library,
    /// Whether the host promises not to go back before the current point.
    no_way_back: fmi3Boolean,
    /// What the last step told.
    told: Told,
}

/// What a step tells; flags as bytes, because the original may write anything.
#[derive(Clone, Copy, Default)]
struct Told {
    event: u8,
    terminate: u8,
    early: u8,
    time: f64,
}

type Instance = Wrapped<Inner>;

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: an instance of this library, never used again.
        unsafe { (self.library.functions.free_instance)(self.instance) }
    }
}

impl Original for Inner {
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Code {
        let get = self.library.functions.get_float64;
        let (vr, n) = (references.as_ptr(), references.len());
        // SAFETY: the instance is alive, the arrays have these lengths.
        unsafe { get(self.instance, vr, n, values.as_mut_ptr(), values.len()).0 }
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Code {
        let set = self.library.functions.set_float64;
        let (vr, n) = (references.as_ptr(), references.len());
        // SAFETY: the instance is alive, the arrays have these lengths.
        unsafe { set(self.instance, vr, n, values.as_ptr(), values.len()).0 }
    }

    fn step(&mut self, time: f64, step: f64) -> (Code, bool) {
        let do_step = self.library.functions.do_step;
        let mut told = Told { time, ..Told::default() };
        // SAFETY: the instance is alive; `bool` has the size of a byte, and whatever is written
        // there is read as a byte.
        let code = unsafe {
            do_step(
                self.instance,
                time,
                step,
                self.no_way_back,
                (&raw mut told.event).cast(),
                (&raw mut told.terminate).cast(),
                (&raw mut told.early).cast(),
                &raw mut told.time,
            )
            .0
        };
        self.told = told;
        (code, told.event == 0 && told.terminate == 0 && told.early == 0)
    }
}

/// One call.
///
/// # Safety
/// As all functions here.
unsafe fn call(
    instance: fmi3Instance,
    function: &str,
    body: impl FnOnce(&mut Instance) -> Answer,
) -> fmi3Status {
    // SAFETY: the contract of all functions here.
    fmi3Status(unsafe { guarded(instance, function, body) })
}

impl Instance {
    /// Calls a function of the original that the repair does not touch.
    ///
    /// # Safety
    /// `F` is the type of the function, and `body` calls it as the host called this one.
    unsafe fn pass<F: Copy>(
        &mut self,
        function: &str,
        body: impl FnOnce(F, fmi3Instance) -> fmi3Status,
    ) -> Answer {
        // SAFETY: promised by the caller.
        match unsafe { self.original.library.function::<F>(function) } {
            Some(found) => Ok(body(found, self.original.instance).0),
            None => Err(missing(function)),
        }
    }
}

fn missing(function: &str) -> Notice {
    Notice::error(format!(
        "the original's library has no {function}, though the standard requires it"
    ))
}

/// Functions that go through as they are.
macro_rules! pass {
    ($($(#[$what:meta])* $function:ident: $kind:ty = ($($argument:ident: $type:ty),*);)*) => {
        $(
            $(#[$what])*
            pub unsafe extern "C" fn $function(instance: fmi3Instance, $($argument: $type),*) -> fmi3Status {
                const NAME: &str = stringify!($function);
                let body = |w: &mut Instance| {
                    w.touch();
                    // SAFETY: the function's own type, and the host's own arguments.
                    unsafe { w.pass::<$kind>(NAME, |f, inner| f(inner, $($argument),*)) }
                };
                // SAFETY: the contract of all functions here.
                unsafe { call(instance, NAME, body) }
            }
        )*
    };
}

/// Functions that are not offered.
macro_rules! never {
    ($why:literal: $($(#[$what:meta])* $function:ident($($argument:ident: $type:ty),*);)*) => {
        $(
            $(#[$what])*
            pub unsafe extern "C" fn $function(instance: fmi3Instance, $($argument: $type),*) -> fmi3Status {
                $(let _ = $argument;)*
                let body = |_: &mut Instance| Err(Notice::error($why));
                // SAFETY: the contract of all functions here.
                unsafe { call(instance, stringify!($function), body) }
            }
        )*
    };
}

/// Switches debug logging of the original; the repair's own messages always go out.
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: fmi3Instance,
    loggingOn: fmi3Boolean,
    nCategories: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array of texts.
        let all = unsafe { texts(categories, nCategories, "categories")? };
        let passed: Vec<_> = all.iter().filter(|n| **n != CATEGORY).map(|n| n.as_ptr()).collect();
        if passed.is_empty() && !all.is_empty() {
            return Ok(OK);
        }
        let set = w.original.library.functions.set_debug_logging;
        let Some(set) = set else { return Err(missing("fmi3SetDebugLogging")) };
        // SAFETY: the instance is alive, the texts are the host's.
        Ok(unsafe { set(w.original.instance, loggingOn, passed.len(), passed.as_ptr()).0 })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3SetDebugLogging", body) }
}

/// Refused: model exchange is not offered.
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instanceName: fmi3String,
    _instantiationToken: fmi3String,
    _resourcePath: fmi3String,
    _visible: fmi3Boolean,
    _loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: Option<fmi3LogMessageCallback>,
) -> fmi3Instance {
    // SAFETY: the caller's text.
    unsafe { refuse("fmi3InstantiateModelExchange", instanceName, instanceEnvironment, logMessage) }
}

/// Says that only co-simulation is offered.
///
/// # Safety
/// The name and the logger are the host's.
unsafe fn refuse(
    function: &str,
    name: fmi3String,
    environment: fmi3InstanceEnvironment,
    logger: Option<fmi3LogMessageCallback>,
) -> fmi3Instance {
    // SAFETY: the caller's text.
    let name = unsafe { text(name) }.unwrap_or(c"");
    let why = format!("{function}: a repaired FMU offers co-simulation only");
    send(sink(logger, environment), name, ERROR, &why);
    std::ptr::null_mut()
}

fn sink(logger: Option<fmi3LogMessageCallback>, environment: fmi3InstanceEnvironment) -> Sink {
    logger.map_or(Sink::None, |callback| Sink::V3 { callback, environment })
}

/// Makes an instance of the original and puts the effects around it.
pub unsafe fn fmi3InstantiateCoSimulation(
    instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    eventModeUsed: fmi3Boolean,
    _earlyReturnAllowed: fmi3Boolean,
    _requiredIntermediateVariables: *const fmi3ValueReference,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: Option<fmi3LogMessageCallback>,
    _intermediateUpdate: Option<fmi3IntermediateUpdateCallback>,
) -> fmi3Instance {
    let sink = sink(logMessage, instanceEnvironment);
    // SAFETY: the caller's texts.
    let (name, token, path) =
        unsafe { (text(instanceName), text(instantiationToken), text(resourcePath)) };
    let made = guard::without_instance(|| {
        if eventModeUsed || nRequiredIntermediateVariables > 0 {
            return Err(Notice::error(
                "event mode and intermediate variables are not offered through a repair",
            ));
        }
        let location = path.map_or(Location::None, |path| Location::Path(path.to_bytes()));
        let files = Files::read(location, "3.0", token)?;
        let library = Library::load(&files.library(PLATFORM_V3))
            .map_err(|e| Notice::error(format!("the original inside: {e}")))?;
        let (token, resources) = (files.token()?, files.resources_path()?);
        // SAFETY: texts end with a zero byte; environment and logger are the host's.
        let inner = unsafe {
            (library.functions.instantiate_co_simulation)(
                name.map_or(std::ptr::null(), CStr::as_ptr),
                token.as_ptr(),
                resources.as_ptr(),
                visible,
                loggingOn,
                fmi3False,
                fmi3False,
                std::ptr::null(),
                0,
                instanceEnvironment,
                logMessage,
                None,
            )
        };
        if inner.is_null() {
            return Err(Notice::error(format!(
                "the original inside, {}, makes no instance; its own message, if it has any, \
                 stands before this one",
                library.path().display()
            )));
        }
        let told = Told::default();
        let original = Inner { instance: inner, library, no_way_back: fmi3False, told };
        Ok(Box::new(Wrapped::new(original, files.surround, sink, name.unwrap_or(c"").into())))
    });
    match made {
        Ok(instance) => Box::into_raw(instance).cast::<c_void>(),
        Err(notice) => {
            let message = format!("fmi3InstantiateCoSimulation: {}", notice.message);
            send(sink, name.unwrap_or(c""), ERROR, &message);
            std::ptr::null_mut()
        }
    }
}

/// Refused: scheduled execution is not offered.
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    instanceName: fmi3String,
    _instantiationToken: fmi3String,
    _resourcePath: fmi3String,
    _visible: fmi3Boolean,
    _loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: Option<fmi3LogMessageCallback>,
    _clockUpdate: Option<fmi3ClockUpdateCallback>,
    _lockPreemption: Option<fmi3LockPreemptionCallback>,
    _unlockPreemption: Option<fmi3UnlockPreemptionCallback>,
) -> fmi3Instance {
    const NAME: &str = "fmi3InstantiateScheduledExecution";
    // SAFETY: the caller's text.
    unsafe { refuse(NAME, instanceName, instanceEnvironment, logMessage) }
}

/// Frees an instance, its states, and the original.
pub unsafe extern "C" fn fmi3FreeInstance(instance: fmi3Instance) {
    if instance.is_null() {
        return;
    }
    let freed = guard::without_instance(|| {
        // SAFETY: it came from `Box::into_raw`, as the caller promises.
        let mut instance = unsafe { Box::from_raw(instance.cast::<Instance>()) };
        for saved in std::mem::take(&mut instance.saved) {
            // SAFETY: a state of this instance that is not freed.
            unsafe { drop_state(&mut instance, saved) };
        }
        drop(instance);
        Ok(())
    });
    // Nobody is left who could be told.
    drop(freed);
}

/// Brings effects on parameters to the original and goes through.
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: fmi3Instance,
    toleranceDefined: fmi3Boolean,
    tolerance: fmi3Float64,
    startTime: fmi3Float64,
    stopTimeDefined: fmi3Boolean,
    stopTime: fmi3Float64,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        let code = w.before_entering();
        if code >= DISCARD {
            return Ok(code);
        }
        let enter = w.original.library.functions.enter_initialization_mode;
        let inner = w.original.instance;
        // SAFETY: the instance is alive.
        let entered = unsafe {
            enter(inner, toleranceDefined, tolerance, startTime, stopTimeDefined, stopTime).0
        };
        if entered < DISCARD {
            w.entered();
        }
        Ok(code.max(entered))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3EnterInitializationMode", body) }
}

/// Brings effects to rest and goes through.
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status {
    let body = |w: &mut Instance| {
        let code = w.before_leaving();
        if code >= DISCARD {
            return Ok(code);
        }
        let exit = w.original.library.functions.exit_initialization_mode;
        // SAFETY: the instance is alive.
        let code = code.max(unsafe { exit(w.original.instance).0 });
        if code >= DISCARD {
            return Ok(code);
        }
        Ok(code.max(w.left()))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3ExitInitializationMode", body) }
}

never! {
    "event mode is not offered through a repair":
    /// Not offered.
    fmi3EnterEventMode();
}

pass! {
    /// Goes through.
    fmi3Terminate: fmi3TerminateTYPE = ();
}

/// Goes through; effects go back to their start values.
pub unsafe extern "C" fn fmi3Reset(instance: fmi3Instance) -> fmi3Status {
    let body = |w: &mut Instance| {
        let Some(reset) = w.original.library.functions.reset else {
            return Err(missing("fmi3Reset"));
        };
        // SAFETY: the instance is alive.
        let code = unsafe { reset(w.original.instance).0 };
        w.was_reset();
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3Reset", body) }
}

/// Reads Float64 variables.
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *mut fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        if !w.is_ours(references) {
            let (get, inner) = (w.original.library.functions.get_float64, w.original.instance);
            // SAFETY: the host's own arguments.
            return Ok(unsafe { get(inner, valueReferences, nValueReferences, values, nValues).0 });
        }
        if nValues > (1 << 40) {
            return Err(Notice::error("that many values cannot be"));
        }
        let mut own = vec![0.0; nValues];
        let code = w.get(references, &mut own)?;
        // SAFETY: the caller's room for `nValues` values.
        let room = unsafe { Room::new(values, nValues, "values")? };
        // SAFETY: positions are below `nValues`.
        own.iter().enumerate().for_each(|(at, v)| unsafe { room.write(at, *v) });
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3GetFloat64", body) }
}

/// Sets Float64 variables.
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *const fmi3Float64,
    nValues: usize,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        if !w.is_ours(references) {
            w.touch();
            let (set, inner) = (w.original.library.functions.set_float64, w.original.instance);
            // SAFETY: the host's own arguments.
            return Ok(unsafe { set(inner, valueReferences, nValueReferences, values, nValues).0 });
        }
        // SAFETY: the caller's array of `nValues` values.
        w.set(references, unsafe { array(values, nValues, "values")? })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3SetFloat64", body) }
}

/// Whether all variables of a call are the repair's Booleans; a call that mixes them with others is
/// done one by one.
fn flags(w: &Instance, references: &[u32], count: usize) -> Result<bool, Notice> {
    let own = references.iter().filter(|r| w.surround.is_flag(**r)).count();
    if own > 0 && count != references.len() {
        return Err(Notice::error(
            "a call for Booleans of the repair and for arrays at once; ask for them one by one",
        ));
    }
    Ok(own > 0)
}

/// Reads Boolean variables.
pub unsafe extern "C" fn fmi3GetBoolean(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *mut fmi3Boolean,
    nValues: usize,
) -> fmi3Status {
    const NAME: &str = "fmi3GetBoolean";
    let body = |w: &mut Instance| {
        // SAFETY: the caller's array.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        if !flags(w, references, nValues)? {
            // SAFETY: the function's own type, and the host's own arguments.
            return unsafe {
                w.pass::<fmi3GetBooleanTYPE>(NAME, |f, c| {
                    f(c, valueReferences, nValueReferences, values, nValues)
                })
            };
        }
        // SAFETY: the caller's room for `nValues` values, as many as there are references.
        let room = unsafe { Room::new(values, nValues, "values")? };
        let mut code = OK;
        for (at, reference) in references.iter().enumerate() {
            if w.surround.is_flag(*reference) {
                let value = w.surround.get(*reference) == Some(1.0);
                // SAFETY: the position is below `nValues`.
                unsafe { room.write(at, value) };
                continue;
            }
            // SAFETY: the function's own type, and room for one value.
            code = code.max(unsafe {
                w.pass::<fmi3GetBooleanTYPE>(NAME, |f, c| {
                    f(c, std::ptr::from_ref(reference), 1, values.add(at), 1)
                })?
            });
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// Sets Boolean variables.
pub unsafe extern "C" fn fmi3SetBoolean(
    instance: fmi3Instance,
    valueReferences: *const fmi3ValueReference,
    nValueReferences: usize,
    values: *const fmi3Boolean,
    nValues: usize,
) -> fmi3Status {
    const NAME: &str = "fmi3SetBoolean";
    let body = |w: &mut Instance| {
        w.touch();
        // SAFETY: the caller's array.
        let references = unsafe { array(valueReferences, nValueReferences, "valueReferences")? };
        if !flags(w, references, nValues)? {
            // SAFETY: the function's own type, and the host's own arguments.
            return unsafe {
                w.pass::<fmi3SetBooleanTYPE>(NAME, |f, c| {
                    f(c, valueReferences, nValueReferences, values, nValues)
                })
            };
        }
        // SAFETY: the caller's array, as bytes because a host may write anything.
        let own = unsafe { array(values.cast::<u8>(), nValues, "values")? };
        let mut code = OK;
        for (at, reference) in references.iter().enumerate() {
            if w.surround.is_flag(*reference) {
                w.set_flag(*reference, own[at] != 0)?;
                continue;
            }
            // SAFETY: the function's own type, and one value of the host's.
            code = code.max(unsafe {
                w.pass::<fmi3SetBooleanTYPE>(NAME, |f, c| {
                    f(c, std::ptr::from_ref(reference), 1, values.add(at), 1)
                })?
            });
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

pass! {
    /// Goes through.
    fmi3GetFloat32: fmi3GetFloat32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Float32, nValues: usize);
    /// Goes through.
    fmi3GetInt8: fmi3GetInt8TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int8, nValues: usize);
    /// Goes through.
    fmi3GetUInt8: fmi3GetUInt8TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt8, nValues: usize);
    /// Goes through.
    fmi3GetInt16: fmi3GetInt16TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int16, nValues: usize);
    /// Goes through.
    fmi3GetUInt16: fmi3GetUInt16TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt16, nValues: usize);
    /// Goes through.
    fmi3GetInt32: fmi3GetInt32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int32, nValues: usize);
    /// Goes through.
    fmi3GetUInt32: fmi3GetUInt32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt32, nValues: usize);
    /// Goes through.
    fmi3GetInt64: fmi3GetInt64TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int64, nValues: usize);
    /// Goes through.
    fmi3GetUInt64: fmi3GetUInt64TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt64, nValues: usize);
    /// Goes through.
    fmi3GetString: fmi3GetStringTYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3String, nValues: usize);
    /// Goes through.
    fmi3GetBinary: fmi3GetBinaryTYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *mut usize, values: *mut fmi3Binary, nValues: usize);
    /// Goes through.
    fmi3SetFloat32: fmi3SetFloat32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Float32, nValues: usize);
    /// Goes through.
    fmi3SetInt8: fmi3SetInt8TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int8, nValues: usize);
    /// Goes through.
    fmi3SetUInt8: fmi3SetUInt8TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt8, nValues: usize);
    /// Goes through.
    fmi3SetInt16: fmi3SetInt16TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int16, nValues: usize);
    /// Goes through.
    fmi3SetUInt16: fmi3SetUInt16TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt16, nValues: usize);
    /// Goes through.
    fmi3SetInt32: fmi3SetInt32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int32, nValues: usize);
    /// Goes through.
    fmi3SetUInt32: fmi3SetUInt32TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt32, nValues: usize);
    /// Goes through.
    fmi3SetInt64: fmi3SetInt64TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int64, nValues: usize);
    /// Goes through.
    fmi3SetUInt64: fmi3SetUInt64TYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt64, nValues: usize);
    /// Goes through.
    fmi3SetString: fmi3SetStringTYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3String, nValues: usize);
    /// Goes through.
    fmi3SetBinary: fmi3SetBinaryTYPE = (valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *const usize, values: *const fmi3Binary, nValues: usize);
    /// Goes through.
    fmi3GetNumberOfVariableDependencies: fmi3GetNumberOfVariableDependenciesTYPE = (valueReference: fmi3ValueReference, nDependencies: *mut usize);
    /// Goes through.
    fmi3GetVariableDependencies: fmi3GetVariableDependenciesTYPE = (dependent: fmi3ValueReference, elementIndicesOfDependent: *mut usize, independents: *mut fmi3ValueReference, elementIndicesOfIndependents: *mut usize, dependencyKinds: *mut fmi3DependencyKind, nDependencies: usize);
    /// Goes through.
    fmi3EnterConfigurationMode: fmi3EnterConfigurationModeTYPE = ();
    /// Goes through.
    fmi3ExitConfigurationMode: fmi3ExitConfigurationModeTYPE = ();
}

never! {
    "clocks are not offered through a repair":
    /// Not offered.
    fmi3GetClock(valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Clock);
    /// Not offered.
    fmi3SetClock(valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Clock);
    /// Not offered.
    fmi3GetIntervalDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *mut fmi3Float64, qualifiers: *mut fmi3IntervalQualifier);
    /// Not offered.
    fmi3GetIntervalFraction(valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64, qualifiers: *mut fmi3IntervalQualifier);
    /// Not offered.
    fmi3GetShiftDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *mut fmi3Float64);
    /// Not offered.
    fmi3GetShiftFraction(valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64);
    /// Not offered.
    fmi3SetIntervalDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *const fmi3Float64);
    /// Not offered.
    fmi3SetIntervalFraction(valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64);
    /// Not offered.
    fmi3SetShiftDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *const fmi3Float64);
    /// Not offered.
    fmi3SetShiftFraction(valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64);
}

never! {
    "derivatives are not offered through a repair; take differences between saved states":
    /// Not offered.
    fmi3GetDirectionalDerivative(unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize, seed: *const fmi3Float64, nSeed: usize, sensitivity: *mut fmi3Float64, nSensitivity: usize);
    /// Not offered.
    fmi3GetAdjointDerivative(unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize, seed: *const fmi3Float64, nSeed: usize, sensitivity: *mut fmi3Float64, nSensitivity: usize);
    /// Not offered.
    fmi3GetOutputDerivatives(valueReferences: *const fmi3ValueReference, nValueReferences: usize, orders: *const fmi3Int32, values: *mut fmi3Float64, nValues: usize);
}

never! {
    "event mode, model exchange and scheduled execution are not offered":
    /// Not offered.
    fmi3EvaluateDiscreteStates();
    /// Not offered.
    fmi3UpdateDiscreteStates(discreteStatesNeedUpdate: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean, nominalsOfContinuousStatesChanged: *mut fmi3Boolean, valuesOfContinuousStatesChanged: *mut fmi3Boolean, nextEventTimeDefined: *mut fmi3Boolean, nextEventTime: *mut fmi3Float64);
    /// Not offered.
    fmi3EnterContinuousTimeMode();
    /// Not offered.
    fmi3CompletedIntegratorStep(noSetFMUStatePriorToCurrentPoint: fmi3Boolean, enterEventMode: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean);
    /// Not offered.
    fmi3SetTime(time: fmi3Float64);
    /// Not offered.
    fmi3SetContinuousStates(continuousStates: *const fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fmi3GetContinuousStateDerivatives(derivatives: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fmi3GetEventIndicators(eventIndicators: *mut fmi3Float64, nEventIndicators: usize);
    /// Not offered.
    fmi3GetContinuousStates(continuousStates: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fmi3GetNominalsOfContinuousStates(nominals: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fmi3GetNumberOfEventIndicators(nEventIndicators: *mut usize);
    /// Not offered.
    fmi3GetNumberOfContinuousStates(nContinuousStates: *mut usize);
    /// Not offered.
    fmi3EnterStepMode();
    /// Not offered.
    fmi3ActivateModelPartition(clockReference: fmi3ValueReference, activationTime: fmi3Float64);
}

/// Saves the state of the original and of the effects.
pub unsafe extern "C" fn fmi3GetFMUState(
    instance: fmi3Instance,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    const NAME: &str = "fmi3GetFMUState";
    let body = |w: &mut Instance| {
        // SAFETY: the host's own pointer.
        let place = unsafe { FMUState.as_mut() };
        let place = place.ok_or_else(|| Notice::error("the place of the state is null"))?;
        let old = if place.is_null() { None } else { Some(state(*place)?) };
        // SAFETY: a state of this instance.
        let mut inner = old.map_or(std::ptr::null_mut(), |saved| unsafe { (*saved).inner });
        // SAFETY: the function's own type; the pointer is null or a state of the original.
        let code = unsafe { w.pass::<fmi3GetFMUStateTYPE>(NAME, |f, c| f(c, &raw mut inner))? };
        if code >= DISCARD {
            return Ok(code);
        }
        let saved = Saved { inner, around: w.around() };
        match old {
            // SAFETY: a state of this instance, and the only reference to it.
            Some(old) => unsafe { *old = saved },
            None => {
                let new = Box::into_raw(Box::new(saved));
                w.saved.push(new);
                *place = new.cast();
            }
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// Goes back to a saved state.
pub unsafe extern "C" fn fmi3SetFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
) -> fmi3Status {
    const NAME: &str = "fmi3SetFMUState";
    let body = |w: &mut Instance| {
        let saved = state(FMUState)?;
        // SAFETY: a state of this instance.
        let (inner, around) = unsafe { ((*saved).inner, (*saved).around.clone()) };
        // SAFETY: the function's own type and a state of the original.
        let code = unsafe { w.pass::<fmi3SetFMUStateTYPE>(NAME, |f, c| f(c, inner))? };
        if code < DISCARD {
            w.restore(&around)?;
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// Frees a state that is in no list any more.
///
/// # Safety
/// `saved` is a state of this instance that is not freed.
unsafe fn drop_state(w: &mut Instance, saved: *mut Saved) -> Code {
    // SAFETY: it came from `Box::into_raw`, as the caller promises.
    let mut saved = unsafe { Box::from_raw(saved) };
    let Some(free) = w.original.library.functions.free_fmu_state else { return OK };
    // SAFETY: a state of the original.
    unsafe { free(w.original.instance, &raw mut saved.inner).0 }
}

/// Frees a saved state; null is ignored.
pub unsafe extern "C" fn fmi3FreeFMUState(
    instance: fmi3Instance,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the host's own pointer.
        let Some(place) = (unsafe { FMUState.as_mut() }).filter(|p| !p.is_null()) else {
            return Ok(OK);
        };
        let saved = state(*place)?;
        w.saved.retain(|s| *s != saved);
        *place = std::ptr::null_mut();
        // SAFETY: a state of this instance, in no list any more.
        Ok(unsafe { drop_state(w, saved) })
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3FreeFMUState", body) }
}

/// Number of bytes of the original's state.
///
/// # Safety
/// `inner` is a state of the original.
unsafe fn inner_size(w: &mut Instance, inner: fmi3FMUState) -> Result<(Code, usize), Notice> {
    let mut size = 0;
    // SAFETY: the function's own type and a state of the original.
    let code = unsafe {
        w.pass::<fmi3SerializedFMUStateSizeTYPE>("fmi3SerializedFMUStateSize", |f, c| {
            f(c, inner, &raw mut size)
        })?
    };
    Ok((code, size))
}

/// Number of bytes of a saved state.
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    size: *mut usize,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        let saved = state(FMUState)?;
        // SAFETY: a state of this instance; the host's room for one number.
        unsafe {
            let (code, inner) = inner_size(w, (*saved).inner)?;
            let around = &(*saved).around;
            Room::new(size, 1, "size")?.write(0, around.byte_len() + inner);
            Ok(code)
        }
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3SerializedFMUStateSize", body) }
}

/// A saved state as bytes.
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: fmi3Instance,
    FMUState: fmi3FMUState,
    serializedState: *mut fmi3Byte,
    size: usize,
) -> fmi3Status {
    const NAME: &str = "fmi3SerializeFMUState";
    let body = |w: &mut Instance| {
        let saved = state(FMUState)?;
        // SAFETY: a state of this instance.
        let (inner, around) = unsafe { ((*saved).inner, (*saved).around.clone()) };
        // SAFETY: a state of the original.
        let (code, length) = unsafe { inner_size(w, inner)? };
        let head = around.byte_len();
        if size < head + length {
            return Err(Notice::error(format!("{size} bytes are too few for {}", head + length)));
        }
        let mut bytes = vec![0; head + length];
        let behind = bytes[head..].as_mut_ptr().cast::<fmi3Byte>();
        // SAFETY: the function's own type; the room has this length.
        let done = unsafe {
            w.pass::<fmi3SerializeFMUStateTYPE>(NAME, |f, c| f(c, inner, behind, length))?
        };
        around.write(&w.surround.repair().token, &mut bytes);
        // SAFETY: the host's room has `size` bytes, which is not less.
        unsafe {
            let room = Room::new(serializedState.cast::<u8>(), size, "serializedState")?;
            bytes.iter().enumerate().for_each(|(at, b)| room.write(at, *b));
        }
        Ok(code.max(done))
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// A saved state from bytes; it is not yet the current one.
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: fmi3Instance,
    serializedState: *const fmi3Byte,
    size: usize,
    FMUState: *mut fmi3FMUState,
) -> fmi3Status {
    const NAME: &str = "fmi3DeserializeFMUState";
    let body = |w: &mut Instance| {
        // SAFETY: the host's array of `size` bytes and its pointer.
        let (bytes, place) = unsafe {
            (array(serializedState.cast::<u8>(), size, "serializedState")?, FMUState.as_mut())
        };
        let place = place.ok_or_else(|| Notice::error("the place of the state is null"))?;
        let token = &w.surround.repair().token;
        let (around, at) = Around::read(token, bytes).ok_or_else(|| {
            Notice::error("the bytes are no state of this FMU, or they are damaged")
        })?;
        let mut inner: fmi3FMUState = std::ptr::null_mut();
        let behind = &bytes[at..];
        // SAFETY: the function's own type; the bytes have this length.
        let code = unsafe {
            w.pass::<fmi3DeserializeFMUStateTYPE>(NAME, |f, c| {
                f(c, behind.as_ptr().cast(), behind.len(), &raw mut inner)
            })?
        };
        if code < DISCARD {
            if !place.is_null() {
                let old = state(*place)?;
                w.saved.retain(|s| *s != old);
                // SAFETY: a state of this instance, in no list any more.
                unsafe { drop_state(w, old) };
            }
            let new = Box::into_raw(Box::new(Saved { inner, around }));
            w.saved.push(new);
            *place = new.cast();
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, NAME, body) }
}

/// Computes one communication step.
pub unsafe extern "C" fn fmi3DoStep(
    instance: fmi3Instance,
    currentCommunicationPoint: fmi3Float64,
    communicationStepSize: fmi3Float64,
    noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    eventHandlingNeeded: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    earlyReturn: *mut fmi3Boolean,
    lastSuccessfulTime: *mut fmi3Float64,
) -> fmi3Status {
    let body = |w: &mut Instance| {
        // SAFETY: the caller's room for one value each.
        let (event, terminate, early, last) = unsafe {
            (
                Room::new(eventHandlingNeeded, 1, "eventHandlingNeeded")?,
                Room::new(terminateSimulation, 1, "terminateSimulation")?,
                Room::new(earlyReturn, 1, "earlyReturn")?,
                Room::new(lastSuccessfulTime, 1, "lastSuccessfulTime")?,
            )
        };
        w.original.no_way_back = noSetFMUStatePriorToCurrentPoint;
        let code = w.step(currentCommunicationPoint, communicationStepSize);
        let told = w.original.told;
        // SAFETY: as above.
        unsafe {
            event.write(0, told.event != 0);
            terminate.write(0, told.terminate != 0);
            early.write(0, told.early != 0);
            last.write(0, told.time);
        }
        Ok(code)
    };
    // SAFETY: the contract of all functions here.
    unsafe { call(instance, "fmi3DoStep", body) }
}
