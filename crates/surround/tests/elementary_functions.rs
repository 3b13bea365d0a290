//! What runs inside an FMU gives the same bits on every platform: elementary functions come from `libm`,
//! whose results are its own, and never from the standard library, whose results are the platform's.

use std::fs;
use std::path::{Path, PathBuf};

/// Methods of `f64` that the standard library leaves to the platform. Roots, rounding, remainders and
/// fused products are exact by IEEE 754 and may be called.
const OF_THE_PLATFORM: [&str; 25] = [
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "exp",
    "exp2", "exp_m1", "hypot", "ln", "ln_1p", "log", "log10", "log2", "powf", "powi", "sin",
    "sin_cos", "sinh", "tanh",
];

/// Crates with the standard library whose code runs inside FMUs.
const WITH_STD: [&str; 3] = ["crates/surround", "crates/fmi-bindings", "crates/learned"];
/// Crates without it, which cannot call what they do not have.
const WITHOUT_STD: [&str; 2] = ["crates/model", "crates/components"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All Rust files below a folder.
fn sources(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.expect("a folder's entry").path();
        if path.is_dir() {
            sources(&path, all);
        } else if path.extension().is_some_and(|e| e == "rs") {
            all.push(path);
        }
    }
}

/// Modules of a library that only training has, which no FMU does.
fn of_training(library: &str) -> Vec<String> {
    let pairs = library.lines().zip(library.lines().skip(1));
    let gated =
        pairs.filter(|(line, _)| line.contains("cfg(") && line.contains("feature = \"train\""));
    let module =
        |line: &str| line.trim_start_matches("pub ").strip_prefix("mod ").map(str::to_owned);
    gated.filter_map(|(_, next)| module(next)).map(|m| m.trim_end_matches(';').to_owned()).collect()
}

/// The lines before a file's tests that call a function of the platform.
fn calls(text: &str) -> Vec<String> {
    let product = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let is_call = |line: &&str| {
        let code = line.split("//").next().unwrap_or_default();
        OF_THE_PLATFORM
            .iter()
            .any(|f| code.contains(&format!(".{f}(")) || code.contains(&format!("f64::{f}")))
            || code.contains(".tan(")
    };
    product.lines().filter(is_call).map(|line| line.trim().to_owned()).collect()
}

#[test]
fn elementary_functions_inside_fmus_are_those_of_libm() {
    let mut found = Vec::new();
    for name in WITH_STD {
        let mut files = Vec::new();
        sources(&root().join(name).join("src"), &mut files);
        assert!(files.len() > 5, "{name} has moved");
        let src = root().join(name).join("src");
        let library = fs::read_to_string(src.join("lib.rs")).expect("a library");
        for module in of_training(&library) {
            files.retain(|f| !f.starts_with(src.join(&module)));
            files.retain(|f| *f != src.join(format!("{module}.rs")));
        }
        for file in files {
            let text = fs::read_to_string(&file).expect("a source file");
            found
                .extend(calls(&text).into_iter().map(|line| format!("{}: {line}", file.display())));
        }
    }
    assert!(found.is_empty(), "use libm's function instead:\n{}", found.join("\n"));
    for name in WITHOUT_STD {
        let text = fs::read_to_string(root().join(name).join("src/lib.rs")).expect("a library");
        assert!(text.contains("no_std"), "{name} has the standard library now: list it above");
    }
}

#[test]
fn a_call_is_found_where_it_is_one() {
    assert_eq!(calls("let y = x.tanh();\nlet z = tanh(x); // x.tanh()\n"), ["let y = x.tanh();"]);
    assert_eq!(calls("f64::exp_m1(x)"), ["f64::exp_m1(x)"]);
    assert!(calls("x.sqrt() + x.round()\n#[cfg(test)]\nmod tests {\n x.sin() }").is_empty());
}
