//! The build script's nested build: with a vendored source, without the network, from sources that it leaves
//! alone, in folders with blanks, called from elsewhere, with flags in the environment. The script is the
//! tool's own; around it stand a few lines in place of the tool.
#![cfg(target_os = "linux")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const LIBRARIES: [&str; 2] = ["blueprint", "wrap"];
const CHECKSUM: &str = "0000000000000000000000000000000000000000000000000000000000000000";

fn write(path: PathBuf, text: &str) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

/// A tool whose libraries and build script need crates that are vendored beside it, in `vendor`.
fn sources(root: &Path, vendor: &Path) {
    let mut members = String::new();
    let mut locked = String::new();
    let mut variables = String::new();
    for name in LIBRARIES {
        let package = format!("piezoloop-fmu-{name}");
        members += &format!("\"fmu-{name}\", ");
        locked += &format!(
            "[[package]]\nname = \"{package}\"\nversion = \"0.1.0\"\ndependencies = [\"leaf\"]\n\n"
        );
        variables += &format!(
            "    assert!(include_bytes!(env!(\"PIEZOLOOP_{}_LIBRARY\")).len() > 1000);\n",
            name.to_uppercase()
        );
        let manifest = format!(
            "[package]\nname = \"{package}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[lib]\n\
             crate-type = [\"cdylib\"]\n[dependencies]\nleaf = \"1\"\n"
        );
        write(root.join(format!("fmu-{name}/Cargo.toml")), &manifest);
        let code = concat!(
            "#[cfg(of_the_tool)]\ncompile_error!(\"the tool's flags reach the libraries\");\n",
            "#[unsafe(no_mangle)]\npub extern \"C\" fn answer() -> u32 {\n    leaf::answer()\n}\n",
        );
        write(root.join(format!("fmu-{name}/src/lib.rs")), code);
    }
    let manifest = format!(
        "[package]\nname = \"tool\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[dependencies]\nleaf = \"1\"\n\
         [build-dependencies]\nminiz_oxide = \"1\"\n[workspace]\nmembers = [{members}]\n[profile.fmu]\ninherits = \"release\"\n"
    );
    write(root.join("Cargo.toml"), &manifest);
    // What the script packs the libraries with, which only passes them on here.
    let packer = "pub mod deflate {\n    pub fn compress_to_vec(bytes: &[u8], _: u8) -> Vec<u8> {\n        \
                  bytes.to_vec()\n    }\n}\n";
    let vendored = [("leaf", "pub fn answer() -> u32 {\n    42\n}\n"), ("miniz_oxide", packer)];
    let of_crates_io: String = vendored
        .iter()
        .map(|(name, _)| {
            format!(
                "[[package]]\nname = \"{name}\"\nversion = \"1.0.0\"\nsource = \
                 \"registry+https://github.com/rust-lang/crates.io-index\"\nchecksum = \"{CHECKSUM}\"\n\n"
            )
        })
        .collect();
    let lock = format!(
        "version = 4\n\n{of_crates_io}{locked}[[package]]\nname = \"tool\"\nversion = \"0.1.0\"\n\
         dependencies = [\"leaf\", \"miniz_oxide\"]\n"
    );
    write(root.join("Cargo.lock"), &lock);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("build.rs");
    fs::copy(script, root.join("build.rs")).unwrap();
    let main = format!(
        "fn main() {{\n{variables}    println!(\"{{}}{{}}\", leaf::answer(), env!(\"PIEZOLOOP_COMMIT\"));\n}}\n"
    );
    write(root.join("src/main.rs"), &main);
    for (name, code) in vendored {
        let manifest =
            format!("[package]\nname = \"{name}\"\nversion = \"1.0.0\"\nedition = \"2024\"\n");
        write(vendor.join(name).join("Cargo.toml"), &manifest);
        write(vendor.join(name).join("src/lib.rs"), code);
        let sum = format!("{{\"files\":{{}},\"package\":\"{CHECKSUM}\"}}");
        write(vendor.join(name).join(".cargo-checksum.json"), &sum);
    }
}

fn files(folder: &Path) -> BTreeSet<PathBuf> {
    let mut all = BTreeSet::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path));
        }
        all.insert(path);
    }
    all
}

/// Takes the right to write away from all of it, or gives it back.
fn lock(root: &Path, is_locked: bool) {
    for path in files(root).into_iter().chain([root.to_owned()]) {
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        #[allow(clippy::permissions_set_readonly_false, reason = "a temporary folder of our own")]
        permissions.set_readonly(is_locked);
        fs::set_permissions(path, permissions).unwrap();
    }
}

#[test]
fn vendored_frozen_read_only_and_in_folders_with_blanks() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (root, vendor) = (at("the sources"), at("the vendor"));
    sources(&root, &vendor);
    // Somebody else's repository around the sources is not asked for the commit.
    let git = |arguments: &[&str]| {
        let mut git = Command::new("git");
        git.current_dir(folder.path()).args(["-c", "user.name=a", "-c", "user.email=a@b"]);
        assert!(git.args(arguments).output().unwrap().status.success(), "{arguments:?}");
    };
    git(&["init", "-q"]);
    git(&["commit", "-q", "--allow-empty", "-m", "theirs"]);
    let config = format!(
        "[source.crates-io]\nreplace-with = \"vendored\"\n[source.vendored]\ndirectory = {vendor:?}\n"
    );
    let before = files(&root);
    lock(&root, true);
    // The configuration is found from where the outer Cargo is called, or is given to it.
    write(at("with configuration/.cargo/config.toml"), &config);
    write(at("vendored source.toml"), &config);
    fs::create_dir(at("elsewhere")).unwrap();
    let given = at("vendored source.toml").display().to_string();
    let calls: [(&str, &[&str]); 2] =
        [("with configuration", &["--frozen"]), ("elsewhere", &["--frozen", "--config", &given])];
    for (number, (from, arguments)) in calls.into_iter().enumerate() {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(at(from)).args(["run", "-q", "--manifest-path"]);
        cargo.arg(root.join("Cargo.toml")).args(arguments);
        // Nothing of this test's own call, and no crate from the network's cache.
        for (name, _) in std::env::vars() {
            if name.starts_with("CARGO_") || name.starts_with("PIEZOLOOP_") {
                cargo.env_remove(name);
            }
        }
        cargo.env("CARGO_HOME", at("no cache"));
        cargo.env("CARGO_TARGET_DIR", at(&format!("target {number}")));
        cargo.env("RUSTFLAGS", "--cfg of_the_tool --check-cfg cfg(of_the_tool)");
        let output = cargo.output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{from}: {message}");
        assert_eq!(String::from_utf8_lossy(&output.stdout), "42\n", "{from}");
    }
    lock(&root, false);
    assert_eq!(files(&root), before, "the sources are left alone");
}
