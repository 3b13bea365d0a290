//! Builds the FMUs' shared libraries with a nested Cargo and hands their paths to the tool, which
//! carries them inside. A variable may point to a prebuilt library instead.

use std::collections::BTreeSet;
use std::env;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Package, library name, and the variable that overrides and passes on its path.
const LIBRARIES: [(&str, &str, &str); 3] = [
    ("piezoloop-fmu-plant", "piezoloop_plant", "PIEZOLOOP_PLANT_LIBRARY"),
    ("piezoloop-fmu-controller", "piezoloop_controller", "PIEZOLOOP_CONTROLLER_LIBRARY"),
    ("piezoloop-fmu-wrap", "piezoloop_wrap", "PIEZOLOOP_WRAP_LIBRARY"),
];

/// Set by the outer Cargo; inherited they would make the nested one use its folders or wrappers.
const REMOVED: [&str; 10] = [
    // What suits the tool on this machine does not go into libraries that go to others.
    "RUSTFLAGS",
    "CARGO_BUILD_RUSTFLAGS",
    "RUSTC_WRAPPER",
    "RUSTC_WORKSPACE_WRAPPER",
    "CARGO_ENCODED_RUSTFLAGS",
    "CARGO_TARGET_DIR",
    "CARGO_BUILD_TARGET_DIR",
    "CLIPPY_ARGS",
    "CARGO_MAKEFLAGS",
    "MAKEFLAGS",
];

fn main() -> Result<(), Box<dyn Error>> {
    for (_, _, variable) in LIBRARIES {
        println!("cargo:rerun-if-env-changed={variable}");
    }
    println!("cargo:rerun-if-changed=build.rs");
    commit();
    let missing: Vec<_> =
        LIBRARIES.into_iter().filter(|(_, _, variable)| env::var_os(variable).is_none()).collect();
    if missing.is_empty() {
        for (_, _, variable) in LIBRARIES {
            let path = PathBuf::from(env::var(variable)?).canonicalize()?;
            pass_on(variable, &path);
            println!("cargo:rerun-if-changed={}", path.display());
        }
        return Ok(());
    }
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(env::var("OUT_DIR")?).join("fmu-target");
    let target = env::var("TARGET")?;
    nested_build(&root, &out, &target)?;
    let folder = out.join(&target).join("fmu");
    for (_, library, variable) in LIBRARIES {
        let path = match env::var_os(variable) {
            Some(path) => PathBuf::from(path).canonicalize()?,
            None => folder.join(file_name(library)?),
        };
        if !path.is_file() {
            return Err(format!("{} was not built", path.display()).into());
        }
        pass_on(variable, &path);
    }
    for path in sources(&folder)? {
        println!("cargo:rerun-if-changed={}", path.display());
    }
    for manifest in ["Cargo.toml", "Cargo.lock"] {
        println!("cargo:rerun-if-changed={}", root.join(manifest).display());
    }
    Ok(())
}

/// Builds with what the outer Cargo has fetched and locked. Cargo does not tell a build script whether it
/// may use the network, so that is asked for only where something is missing.
fn nested_build(root: &Path, out: &Path, target: &str) -> Result<(), Box<dyn Error>> {
    match cargo(root, out, target, true) {
        Err(_) if env::var_os("CARGO_NET_OFFLINE").is_none() => cargo(root, out, target, false),
        outcome => outcome,
    }
}

fn cargo(root: &Path, out: &Path, target: &str, offline: bool) -> Result<(), Box<dyn Error>> {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root).args(["build", "--profile", "fmu", "--target", target]);
    // The outer Cargo has written the lock file, or has found it in order.
    command.arg("--locked");
    if offline {
        command.arg("--offline");
    }
    command.arg("--target-dir").arg(out);
    for (package, _, _) in LIBRARIES {
        command.args(["-p", package]);
    }
    for variable in REMOVED {
        command.env_remove(variable);
    }
    // Nothing of the outer package's configuration concerns the libraries.
    for (name, _) in env::vars_os() {
        let text = name.to_string_lossy();
        if text.starts_with("CARGO_FEATURE_")
            || text.starts_with("CARGO_CFG_")
            || text.starts_with("CARGO_TARGET_") && text.ends_with("_RUSTFLAGS")
        {
            command.env_remove(&name);
        }
    }
    let output = command.output()?;
    if output.status.success() {
        return Ok(());
    }
    Err(format!(
        "building the FMUs' shared libraries failed ({}):\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    )
    .into())
}

/// The file that Cargo writes for a cdylib of this name on the target.
fn file_name(library: &str) -> Result<String, Box<dyn Error>> {
    Ok(match env::var("CARGO_CFG_TARGET_OS")?.as_str() {
        "windows" => format!("{library}.dll"),
        "macos" => format!("lib{library}.dylib"),
        _ => format!("lib{library}.so"),
    })
}

/// Every source file named in the nested build's dependency files.
fn sources(folder: &Path) -> Result<BTreeSet<PathBuf>, Box<dyn Error>> {
    let mut found = BTreeSet::new();
    for entry in folder.read_dir()? {
        let path = entry?.path();
        if path.extension().is_none_or(|e| e != "d") {
            continue;
        }
        let text = std::fs::read_to_string(&path)?.replace("\\ ", "\u{0}");
        for line in text.lines() {
            let Some((_, inputs)) = line.split_once(": ") else { continue };
            found.extend(inputs.split_whitespace().map(|f| PathBuf::from(f.replace('\u{0}', " "))));
        }
    }
    Ok(found)
}

fn pass_on(variable: &str, path: &Path) {
    println!("cargo:rustc-env={variable}={}", path.display());
}

/// The commit that the tool is built from, for `--version`; empty outside a checkout.
fn commit() {
    let root = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).unwrap_or_default();
    let ask = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(&root).args(arguments).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
        output.status.success().then_some(text)
    };
    // Sources that lie unpacked in somebody else's repository are not of its commit.
    let top =
        ask(&["rev-parse", "--show-toplevel"]).and_then(|top| Path::new(&top).canonicalize().ok());
    let is_ours = top.is_some() && top == root.canonicalize().ok();
    let text = if is_ours { ask(&["rev-parse", "--short=12", "HEAD"]) } else { None };
    let text = text.unwrap_or_default();
    println!("cargo:rustc-env=PIEZOLOOP_COMMIT={text}");
    println!("cargo:rerun-if-changed=.git/HEAD");
    println!("cargo:rerun-if-changed=.git/logs/HEAD");
}
