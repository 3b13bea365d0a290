//! The C types of FMI 3.0, as `fmi3PlatformTypes.h` and `fmi3FunctionTypes.h` declare them.
//!
//! As in [`crate::fmi2`], names are the standard's own, enumerations are transparent integers, and
//! a test compiles the standard's headers against every type of this file.
#![allow(non_camel_case_types, non_snake_case, non_upper_case_globals)]

use std::ffi::{c_char, c_uint, c_void};

mod functions;
mod values;

pub use functions::*;
pub use values::*;

/// Pointer to an FMU's instance; opaque to the importer.
pub type fmi3Instance = *mut c_void;
/// Pointer to the importer's data, handed back by the callbacks; opaque to the FMU.
pub type fmi3InstanceEnvironment = *mut c_void;
/// Pointer to a saved state of an FMU; opaque to the importer.
pub type fmi3FMUState = *mut c_void;
/// Handle of a variable.
pub type fmi3ValueReference = u32;
/// 32-bit float.
pub type fmi3Float32 = f32;
/// 64-bit float.
pub type fmi3Float64 = f64;
/// 8-bit signed integer.
pub type fmi3Int8 = i8;
/// 8-bit unsigned integer.
pub type fmi3UInt8 = u8;
/// 16-bit signed integer.
pub type fmi3Int16 = i16;
/// 16-bit unsigned integer.
pub type fmi3UInt16 = u16;
/// 32-bit signed integer.
pub type fmi3Int32 = i32;
/// 32-bit unsigned integer.
pub type fmi3UInt32 = u32;
/// 64-bit signed integer.
pub type fmi3Int64 = i64;
/// 64-bit unsigned integer.
pub type fmi3UInt64 = u64;
/// Value of a Boolean variable: C99's `bool`. What a foreign FMU writes must be 0 or 1, else it is
/// undefined behaviour: read into bytes and compare where the FMU is not trusted.
pub type fmi3Boolean = bool;
/// One character.
pub type fmi3Char = c_char;
/// UTF-8 text ending with a zero byte.
pub type fmi3String = *const fmi3Char;
/// One byte.
pub type fmi3Byte = u8;
/// Bytes of a binary variable.
pub type fmi3Binary = *const fmi3Byte;
/// Whether a clock ticks: C99's `bool`.
pub type fmi3Clock = bool;

/// The value true.
pub const fmi3True: fmi3Boolean = true;
/// The value false.
pub const fmi3False: fmi3Boolean = false;
/// A clock that ticks.
pub const fmi3ClockActive: fmi3Clock = true;
/// A clock that does not.
pub const fmi3ClockInactive: fmi3Clock = false;

/// What `fmi3GetVersion` returns; patch releases append to it.
pub const fmi3Version: &std::ffi::CStr = c"3.0";

/// Result of a call (section 2.2.3).
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct fmi3Status(pub c_uint);

/// All well.
pub const fmi3OK: fmi3Status = fmi3Status(0);
/// Things are not quite right, but the computation may go on.
pub const fmi3Warning: fmi3Status = fmi3Status(1);
/// The call was not carried out; the state is as before it.
pub const fmi3Discard: fmi3Status = fmi3Status(2);
/// The instance can only be reset or freed.
pub const fmi3Error: fmi3Status = fmi3Status(3);
/// All instances of the FMU are corrupted.
pub const fmi3Fatal: fmi3Status = fmi3Status(4);

/// How an unknown depends on a known.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct fmi3DependencyKind(pub c_uint);

/// Not at all.
pub const fmi3Independent: fmi3DependencyKind = fmi3DependencyKind(0);
/// By a constant factor.
pub const fmi3Constant: fmi3DependencyKind = fmi3DependencyKind(1);
/// By a factor that is fixed after initialization.
pub const fmi3Fixed: fmi3DependencyKind = fmi3DependencyKind(2);
/// By a factor that changes with tunable parameters.
pub const fmi3Tunable: fmi3DependencyKind = fmi3DependencyKind(3);
/// By a factor that changes at events.
pub const fmi3Discrete: fmi3DependencyKind = fmi3DependencyKind(4);
/// Without known structure.
pub const fmi3Dependent: fmi3DependencyKind = fmi3DependencyKind(5);

/// What is known about a clock's next interval.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct fmi3IntervalQualifier(pub c_uint);

/// Not yet known.
pub const fmi3IntervalNotYetKnown: fmi3IntervalQualifier = fmi3IntervalQualifier(0);
/// The same as when it was last asked for.
pub const fmi3IntervalUnchanged: fmi3IntervalQualifier = fmi3IntervalQualifier(1);
/// New since it was last asked for.
pub const fmi3IntervalChanged: fmi3IntervalQualifier = fmi3IntervalQualifier(2);

/// The importer's logger; the message is a text, not a format.
pub type fmi3LogMessageCallback = unsafe extern "C" fn(
    instanceEnvironment: fmi3InstanceEnvironment,
    status: fmi3Status,
    category: fmi3String,
    message: fmi3String,
);
/// Tells the importer that a clock ticks (scheduled execution).
pub type fmi3ClockUpdateCallback =
    unsafe extern "C" fn(instanceEnvironment: fmi3InstanceEnvironment);
/// Lets the importer look and set within a step (intermediate update).
pub type fmi3IntermediateUpdateCallback = unsafe extern "C" fn(
    instanceEnvironment: fmi3InstanceEnvironment,
    intermediateUpdateTime: fmi3Float64,
    intermediateVariableSetRequested: fmi3Boolean,
    intermediateVariableGetAllowed: fmi3Boolean,
    intermediateStepFinished: fmi3Boolean,
    canReturnEarly: fmi3Boolean,
    earlyReturnRequested: *mut fmi3Boolean,
    earlyReturnTime: *mut fmi3Float64,
);
/// Begins a section that must not be preempted (scheduled execution).
pub type fmi3LockPreemptionCallback = unsafe extern "C" fn();
/// Ends a section that must not be preempted (scheduled execution).
pub type fmi3UnlockPreemptionCallback = unsafe extern "C" fn();
