//! The master knows FMUs only: no component of a plant is among the crates that it is built of.

use std::path::Path;
use std::process::Command;

/// The crates that a package is built of, a line each, with their features.
fn crates(package: &[&str]) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "-e", "normal"])
        .args(["--prefix", "none", "--format", "{p} {f}", "-p"])
        .args(package)
        .current_dir(root)
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for layer in ["components", "surround", "learned"] {
        let line = text.lines().find(|line| line.starts_with(&format!("piezoloop-{layer} ")));
        assert_eq!(line, None, "{package:?} is built with {layer}");
    }
    text
}

#[test]
fn the_master_is_built_without_components() {
    let text = crates(&["piezoloop-cosim"]);
    let edge = text.lines().find(|line| line.starts_with("piezoloop-fmi-bindings "));
    assert!(edge.is_some_and(|line| line.ends_with(") import")), "not import alone: {edge:?}");
}

#[test]
fn the_import_of_fmus_is_built_without_any_layer() {
    let text = crates(&["piezoloop-fmi-bindings", "--no-default-features", "--features", "import"]);
    let own: Vec<_> = text.lines().filter(|line| line.starts_with("piezoloop-")).collect();
    assert!(matches!(own[..], [only] if only.contains("fmi-bindings")), "{own:?}");
}
