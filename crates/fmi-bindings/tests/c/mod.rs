//! C spelled from Rust types, and compiled beside the standard's headers.
#![allow(unreachable_pub, unused_macros, dead_code, clippy::print_stdout)]

use std::ffi::c_void;
use std::path::{Path, PathBuf};
use std::process::Command;

use fmi_bindings::fmi2::{
    fmi2CallbackFunctions, fmi2EventInfo, fmi2Status, fmi2StatusKind, fmi2Type,
};
use fmi_bindings::fmi3::{fmi3DependencyKind, fmi3IntervalQualifier, fmi3Status};

/// The C spelling of a Rust type.
pub trait C {
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
    // C's `char`, and FMI 3.0's 8-bit integer, which Rust does not tell apart.
    i8 => "char",
    u8 => "unsigned char",
    i16 => "short",
    u16 => "unsigned short",
    i32 => "int",
    u32 => "unsigned int",
    i64 => "int64_t",
    u64 => "uint64_t",
    f32 => "float",
    f64 => "double",
    bool => "_Bool",
    usize => "size_t",
    fmi2Status => "fmi2Status",
    fmi2Type => "fmi2Type",
    fmi2StatusKind => "fmi2StatusKind",
    fmi2CallbackFunctions => "fmi2CallbackFunctions",
    fmi2EventInfo => "fmi2EventInfo",
    fmi3Status => "fmi3Status",
    fmi3DependencyKind => "fmi3DependencyKind",
    fmi3IntervalQualifier => "fmi3IntervalQualifier",
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
    A B D E F G H I;
    A B D E F G H I J;
    A B D E F G H I J K;
    A B D E F G H I J K L;
    A B D E F G H I J K L M;
}

/// The logger.
impl<A: C, B: C, D: C, E: C, F: C> C for unsafe extern "C" fn(A, B, D, E, F, ...) {
    fn c() -> String {
        let arguments = [A::c(), B::c(), D::c(), E::c(), F::c()].join(", ");
        format!("void ({arguments}, ...)")
    }
}

pub fn same(name: &str, rust: String) -> String {
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

pub fn spelled_field<S, T: C>(_: impl Fn(&S) -> &T) -> String {
    T::c()
}

/// `name == value` for each constant.
pub fn equal(constants: &[(&str, u32)]) -> String {
    let equal =
        |(name, value): &(&str, u32)| format!("_Static_assert({name} == {value}, \"{name}\");\n");
    constants.iter().map(equal).collect()
}

/// Enumerations are as large as the integers that stand for them.
pub fn enumerations(names: &[&str]) -> String {
    let size = size_of::<u32>();
    let sized = |name: &&str| format!("_Static_assert(sizeof({name}) == {size}, \"{name}\");\n");
    names.iter().map(sized).collect()
}

/// fmpy's folder of headers, in the tests' Python environment.
pub fn headers() -> Option<PathBuf> {
    let environment = match std::env::var_os("PIEZOLOOP_PYTHON") {
        Some(python) => PathBuf::from(python).parent()?.parent()?.to_path_buf(),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?.join("target/python-env"),
    };
    let versions = std::fs::read_dir(environment.join("lib")).ok()?;
    let mut folders = versions.flatten().map(|v| v.path().join("site-packages/fmpy/c-code"));
    folders.find(|folder| folder.join("fmi2Functions.h").is_file())
}

pub fn compile(headers: &Path, source: &str, folder: &Path) -> Result<(), String> {
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

/// Compiles the assertions; then again with one type wrong, to see that the comparison is sharp.
pub fn check(assertions: &str, wrong: (&str, &str), complaint: &str) {
    let Some(headers) = headers() else {
        println!("SKIPPED: no fmpy with the standard's headers (PIEZOLOOP_PYTHON not set)");
        return;
    };
    let folder = tempfile::tempdir().expect("temporary folder");
    compile(&headers, assertions, folder.path()).expect("all types agree");
    let changed = assertions.replacen(wrong.0, wrong.1, 1);
    assert_ne!(changed, assertions);
    let error = compile(&headers, &changed, folder.path()).expect_err("a wrong type is found");
    assert!(error.contains(complaint), "{error}");
}
