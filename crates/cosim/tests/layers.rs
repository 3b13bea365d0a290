//! The master knows FMUs only: no component of a plant is among the crates that it is built of.

use std::path::Path;
use std::process::Command;

#[test]
fn the_master_is_built_without_components() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let call = ["tree", "--offline", "--locked", "-p", "piezoloop-cosim", "-e", "normal"];
    let output = Command::new(env!("CARGO"))
        .args(call)
        .args(["--prefix", "none", "--format", "{p}"])
        .current_dir(root)
        .output()
        .expect("cargo runs");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("piezoloop-fmi-bindings"), "{text}");
    for layer in ["components", "surround", "learned"] {
        let line = text.lines().find(|line| line.starts_with(&format!("piezoloop-{layer} ")));
        assert_eq!(line, None, "cosim is built with {layer}");
    }
}
