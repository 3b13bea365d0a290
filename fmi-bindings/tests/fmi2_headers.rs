//! The standard's own C headers, compiled against every type of `fmi2.rs`.
//!
//! The C text of each Rust type is derived from the type itself, so a wrong argument in `fmi2.rs`
//! is a failed `_Static_assert` of the C compiler. The headers come with the fmpy wheel.
#![allow(unsafe_code, clippy::print_stdout)]

use std::ffi::{c_char, c_double, c_int, c_uint, c_void};
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::process::Command;

use piezoloop_fmi_bindings::fmi2::*;

/// The C spelling of a Rust type.
trait C {
    fn c() -> String;
}

macro_rules! spelled {
    ($($rust:ty => $c:literal),* $(,)?) => {
        $(impl C for $rust { fn c() -> String { $c.to_owned() } })*
    };
}

spelled! {
    () => "void",
    c_void => "void",
    c_char => "char",
    c_int => "int",
    c_uint => "unsigned int",
    c_double => "double",
    usize => "size_t",
    fmi2Status => "fmi2Status",
    fmi2Type => "fmi2Type",
    fmi2StatusKind => "fmi2StatusKind",
    fmi2CallbackFunctions => "fmi2CallbackFunctions",
    fmi2EventInfo => "fmi2EventInfo",
}

impl<T: C> C for *const T {
    fn c() -> String {
        format!("{} const*", T::c())
    }
}

impl<T: C> C for *mut T {
    fn c() -> String {
        format!("{}*", T::c())
    }
}

/// A nullable function pointer is a function pointer.
impl<F: C> C for Option<F> {
    fn c() -> String {
        format!("__typeof__({})*", F::c())
    }
}

macro_rules! function_types {
    ($($($argument:ident)*;)*) => {
        $(impl<R: C, $($argument: C),*> C for unsafe extern "C" fn($($argument),*) -> R {
            fn c() -> String {
                let arguments: Vec<String> = vec![$($argument::c()),*];
                let arguments =
                    if arguments.is_empty() { "void".to_owned() } else { arguments.join(", ") };
                format!("{} ({arguments})", R::c())
            }
        })*
    };
}

function_types! {
    ;
    A;
    A B;
    A B D;
    A B D E;
    A B D E F;
    A B D E F G;
    A B D E F G H;
}

/// The logger.
impl<A: C, B: C, D: C, E: C, F: C> C for unsafe extern "C" fn(A, B, D, E, F, ...) {
    fn c() -> String {
        let arguments = [A::c(), B::c(), D::c(), E::c(), F::c()].join(", ");
        format!("void ({arguments}, ...)")
    }
}

fn same(name: &str, rust: String) -> String {
    format!("_Static_assert(__builtin_types_compatible_p({name}, {rust}), \"{name}\");\n")
}

macro_rules! all {
    ($($name:ident)*) => { [$(same(stringify!($name), <$name as C>::c())),*].concat() };
}

macro_rules! functions {
    ($($name:ident: $type:ident)*) => {
        [$(
            same(stringify!($type), <$type as C>::c()),
            same(concat!("__typeof__(", stringify!($name), ")"), <$type as C>::c()),
        )*]
        .concat()
    };
}

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
    let values = [
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
    ];
    let enums = ["fmi2Status", "fmi2Type", "fmi2StatusKind"].map(|name| (name, size_of::<u32>()));
    let values = values.map(|(name, value)| format!("_Static_assert({name} == {value}, \"\");\n"));
    let sizes =
        enums.map(|(name, size)| format!("_Static_assert(sizeof({name}) == {size}, \"\");\n"));
    values.concat() + &sizes.concat()
}

macro_rules! layout {
    ($structure:ident: $($field:ident)*) => {{
        let name = stringify!($structure);
        let mut text = format!(
            "_Static_assert(sizeof({name}) == {}, \"{name}\");\n", size_of::<$structure>()
        );
        $({
            let (field, offset) = (stringify!($field), offset_of!($structure, $field));
            text += &format!("_Static_assert(offsetof({name}, {field}) == {offset}, \"{field}\");\n");
            text += &same(
                &format!("__typeof__((({name}*)0)->{field})"),
                spelled_field(|s: &$structure| &s.$field),
            );
        })*
        text
    }};
}

fn spelled_field<S, T: C>(_: impl Fn(&S) -> &T) -> String {
    T::c()
}

fn structures() -> String {
    layout!(fmi2CallbackFunctions: logger allocateMemory freeMemory stepFinished
        componentEnvironment)
        + &layout!(fmi2EventInfo: newDiscreteStatesNeeded terminateSimulation
        nominalsOfContinuousStatesChanged valuesOfContinuousStatesChanged nextEventTimeDefined
        nextEventTime)
}

fn assertions() -> String {
    ["#include \"fmi2Functions.h\"\n".to_owned(), scalars(), callbacks(), functions()].concat()
        + &constants()
        + &structures()
}

/// fmpy's folder of headers, in the tests' Python environment.
fn headers() -> Option<PathBuf> {
    let environment = match std::env::var_os("PIEZOLOOP_PYTHON") {
        Some(python) => PathBuf::from(python).parent()?.parent()?.to_path_buf(),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).parent()?.join("target/python-env"),
    };
    let versions = std::fs::read_dir(environment.join("lib")).ok()?;
    let folders = versions.flatten().map(|v| v.path().join("site-packages/fmpy/c-code"));
    folders.into_iter().find(|folder| folder.join("fmi2Functions.h").is_file())
}

fn compile(headers: &Path, source: &str, folder: &Path) -> Result<(), String> {
    let file = folder.join("assertions.c");
    std::fs::write(&file, source).map_err(|e| e.to_string())?;
    let output = Command::new("cc")
        .args(["-std=gnu11", "-fsyntax-only", "-I"])
        .args([headers, &file])
        .output()
        .map_err(|e| e.to_string())?;
    match output.status.success() {
        true => Ok(()),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

#[test]
fn the_headers_of_the_standard_agree_with_our_types() {
    let Some(headers) = headers() else {
        println!("skipped: no fmpy with the standard's headers (PIEZOLOOP_PYTHON not set)");
        return;
    };
    let folder = tempfile::tempdir().expect("temporary folder");
    let source = assertions();
    compile(&headers, &source, folder.path()).expect("all types agree");

    // The comparison is sharp: one wrong argument is found.
    let wrong = source.replacen("unsigned int const*, size_t, double*", "double*", 1);
    assert_ne!(wrong, source);
    let error = compile(&headers, &wrong, folder.path()).expect_err("a wrong type is found");
    assert!(error.contains("fmi2GetRealTYPE"), "{error}");
}
