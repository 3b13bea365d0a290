//! Builds the FMUs' shared libraries with a nested Cargo and hands their paths to the tool, which
//! carries them inside. A variable may point to a prebuilt library instead.

use std::collections::BTreeSet;
use std::env;
use std::error::Error;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Package, library name, and the variable that overrides and passes on its path.
const LIBRARIES: [(&str, &str, &str); 2] = [
    ("piezoloop-fmu-blueprint", "piezoloop_fmu_blueprint", "PIEZOLOOP_BLUEPRINT_LIBRARY"),
    ("piezoloop-fmu-wrap", "piezoloop_fmu_wrap", "PIEZOLOOP_WRAP_LIBRARY"),
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
    shrink();
    let missing: Vec<_> =
        LIBRARIES.into_iter().filter(|(_, _, variable)| env::var_os(variable).is_none()).collect();
    if missing.is_empty() {
        for (_, library, variable) in LIBRARIES {
            let path = PathBuf::from(env::var(variable)?).canonicalize()?;
            carry(library, variable, &path)?;
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
        carry(library, variable, &path)?;
    }
    for path in sources(&folder)? {
        println!("cargo:rerun-if-changed={}", path.display());
    }
    for manifest in ["Cargo.toml", "Cargo.lock"] {
        println!("cargo:rerun-if-changed={}", root.join(manifest).display());
    }
    Ok(())
}

/// Builds with what the outer Cargo has fetched and locked, and uses the network only where something is
/// missing and the outer one may.
fn nested_build(root: &Path, out: &Path, target: &str) -> Result<(), Box<dyn Error>> {
    let outer = Outer::find();
    match cargo(&outer, root, out, target, true) {
        Err(_) if !outer.is_offline => cargo(&outer, root, out, target, false),
        outcome => outcome,
    }
}

/// How the outer Cargo was called, as far as it matters. Cargo does not tell a build script; where the
/// system shows no other process's command line, the environment's word is all there is.
#[derive(Default)]
struct Outer {
    /// Where Cargo looks for its configuration, such as that of a vendored source.
    folder: Option<PathBuf>,
    /// What was given with `--config`.
    config: Vec<OsString>,
    is_offline: bool,
}

impl Outer {
    fn find() -> Self {
        let mut outer =
            Outer { is_offline: env::var_os("CARGO_NET_OFFLINE").is_some(), ..Self::default() };
        #[cfg(target_os = "linux")]
        {
            use std::os::unix::ffi::OsStringExt as _;
            let process = PathBuf::from(format!("/proc/{}", std::os::unix::process::parent_id()));
            let line = std::fs::read(process.join("cmdline")).unwrap_or_default();
            let words = line.split(|byte| *byte == 0).map(|word| OsString::from_vec(word.to_vec()));
            // Behind `--` stands what belongs to a program that is run.
            let mut words = words.take_while(|word| word != "--");
            outer.folder = process.join("cwd").read_link().ok();
            while let Some(word) = words.next() {
                let text = word.to_string_lossy();
                outer.is_offline |= text == "--offline" || text == "--frozen";
                if let Some(given) = text.strip_prefix("--config=") {
                    outer.config.push(given.into());
                } else if text == "--config" {
                    outer.config.extend(words.next());
                }
            }
        }
        outer
    }
}

fn cargo(
    outer: &Outer,
    root: &Path,
    out: &Path,
    target: &str,
    offline: bool,
) -> Result<(), Box<dyn Error>> {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(outer.folder.as_deref().unwrap_or(root));
    command.args(["build", "--profile", "fmu", "--target", target]);
    command.arg("--manifest-path").arg(root.join("Cargo.toml"));
    for given in &outer.config {
        command.arg("--config").arg(given);
    }
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

/// Passes on the path of a library, and writes a ZIP archive with it as its only entry, which the tool carries: its file is
/// smaller, and packing an FMU copies what is compressed here.
fn carry(library: &str, variable: &str, path: &Path) -> Result<(), Box<dyn Error>> {
    const NAME: &[u8] = b"library";
    println!("cargo:rustc-env={variable}={}", path.display());
    let bytes = std::fs::read(path)?;
    let deflated = miniz_oxide::deflate::compress_to_vec(&bytes, 9);
    // What the local header and the directory have in common: version 2.0, no flags, deflated, midnight of 1980-01-01.
    let mut common = vec![20, 0, 0, 0, 8, 0, 0, 0, 0x21, 0];
    for size in [crc32(&bytes), u32::try_from(deflated.len())?, u32::try_from(bytes.len())?] {
        common.extend(size.to_le_bytes());
    }
    common.extend([u8::try_from(NAME.len())?, 0, 0, 0]);
    let mut zip = [b"PK\x03\x04", &common[..], NAME, &deflated].concat();
    let start = u32::try_from(zip.len())?;
    // Made on Unix; no comment, the first disk, a file that everybody may run.
    zip.extend(b"PK\x01\x02\x14\x03");
    zip.extend(common);
    zip.extend([0; 6]);
    zip.extend((0o100_755_u32 << 16).to_le_bytes());
    zip.extend([0; 4]);
    zip.extend(NAME);
    let size = u32::try_from(zip.len())? - start;
    zip.extend(b"PK\x05\x06\0\0\0\0\x01\0\x01\0");
    zip.extend([size.to_le_bytes(), start.to_le_bytes()].concat());
    zip.extend([0, 0]);
    std::fs::write(PathBuf::from(env::var("OUT_DIR")?).join(format!("{library}.zip")), zip)?;
    Ok(())
}

/// The checksum of ZIP.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    let table: Vec<u32> = (0..256).map(|n| (0..8).fold(n, |crc, _| step(crc))).collect();
    !bytes.iter().fold(!0, |crc, byte| table[usize::from(crc.to_le_bytes()[0] ^ byte)] ^ (crc >> 8))
}

/// Makes the tool's file smaller where the linker can: functions and constants of the same bytes once, relocations
/// packed. Each option is tried on a program that does nothing, and that program is run.
fn shrink() {
    let of = |name: &str| env::var_os(name);
    let (Some(rustc), Some(out)) = (of("RUSTC"), of("OUT_DIR")) else { return };
    // What is built for another system cannot be tried here.
    if of("TARGET") != of("HOST") || of("CARGO_CFG_TARGET_OS").is_none_or(|os| os != "linux") {
        return;
    }
    let folder = PathBuf::from(out);
    let (source, program) = (folder.join("nothing.rs"), folder.join("nothing"));
    if std::fs::write(&source, "fn main() {}\n").is_err() {
        return;
    }
    let flags = env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    for option in
        ["-Wl,--icf=all", "-Wl,--ignore-data-address-equality", "-Wl,-z,pack-relative-relocs"]
    {
        // A linker that somebody chose may link for older systems, which cannot unpack relocations.
        if option.ends_with("-relocs") && of("RUSTC_LINKER").is_some() {
            continue;
        }
        let mut link = Command::new(&rustc);
        link.args(flags.split('\u{1f}').filter(|flag| !flag.is_empty()));
        if let Some(linker) = of("RUSTC_LINKER") {
            link.arg("-C")
                .arg([OsString::from("linker="), linker].into_iter().collect::<OsString>());
        }
        link.arg("-C").arg(format!("link-arg={option}")).arg("-o").arg(&program).arg(&source);
        let links = link.output().is_ok_and(|output| output.status.success());
        if links && Command::new(&program).output().is_ok_and(|output| output.status.success()) {
            println!("cargo:rustc-link-arg-bins={option}");
        }
    }
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
    // A file that is not there would make each build begin anew.
    for name in ["HEAD", "logs/HEAD"] {
        let file = ask(&["rev-parse", "--git-path", name]).map(|file| root.join(file));
        if let Some(file) = file.filter(|file| is_ours && file.is_file()) {
            println!("cargo:rerun-if-changed={}", file.display());
        }
    }
}
