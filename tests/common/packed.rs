//! Packed FMUs lying unpacked, and C hosts that load their libraries as any importer does.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use modeldescription::Package;
use modeldescription::variable::{Causality, DataType};

use super::{python, root, succeed};

/// The blueprints that are packed: a plant of two axes and a controller for it.
pub(crate) const PLANT: &str = "evc";
/// See [`PLANT`].
pub(crate) const CONTROLLER: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/controller.toml");

/// An FMU of the tool, unpacked.
pub(crate) struct Packed {
    pub(crate) package: Package,
    pub(crate) file: PathBuf,
    _folder: tempfile::TempDir,
}

impl Packed {
    /// Packs a blueprint for a version of the standard, `2` or `3`.
    pub(crate) fn new(blueprint: &str, version: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        succeed(&["pack", blueprint, "--fmi", version, "-o", "packed.fmu"], folder.path());
        let file = folder.path().join("packed.fmu");
        Self { package: Package::open(&file).expect("a sound FMU"), file, _folder: folder }
    }

    /// A file that is there already; the folder goes with it.
    pub(crate) fn of(file: PathBuf, folder: tempfile::TempDir) -> Self {
        Self { package: Package::open(&file).expect("a sound FMU"), file, _folder: folder }
    }

    /// The packed's shared library for this machine.
    pub(crate) fn library(&self) -> PathBuf {
        self.package.binary().expect("a library for this machine")
    }

    /// The model's name.
    pub(crate) fn name(&self) -> &str {
        &self.package.description().model_name
    }

    pub(crate) fn guid(&self) -> &str {
        &self.package.description().instantiation_token
    }

    /// Value references of the real variables with this causality, as an argument of a host.
    pub(crate) fn references(&self, causality: Causality) -> String {
        let variables = &self.package.description().variables;
        let wanted = variables
            .iter()
            .filter(|v| v.causality == causality && v.data_type == DataType::Float64);
        let all: Vec<_> = wanted.map(|v| v.value_reference.to_string()).collect();
        assert!(!all.is_empty());
        all.join(",")
    }

    /// The value reference of a variable.
    pub(crate) fn reference(&self, name: &str) -> String {
        let found = self.package.description().variable(name);
        found.unwrap_or_else(|| panic!("no variable {name}")).value_reference.to_string()
    }

    /// Numbers of input and output values in FMI 3.0, where arrays have several.
    pub(crate) fn array_values(&self) -> [&'static str; 2] {
        if self.name() == "evc" { ["2", "2"] } else { ["4", "6"] }
    }

    /// Puts another library in the place of its own.
    pub(crate) fn exchange_library(&self, library: &Path) {
        fs::copy(library, self.library()).expect("a copy");
    }

    /// The internal period in s.
    pub(crate) fn period(&self) -> f64 {
        let experiment = self.package.description().default_experiment.as_ref();
        experiment.and_then(|e| e.step_size).expect("the internal step")
    }

    /// The arguments that every host takes, with another location of the resources.
    pub(crate) fn arguments_at(&self, library: &Path, resources: &str) -> Vec<String> {
        vec![
            library.to_str().expect("a path in UTF-8").to_owned(),
            self.guid().to_owned(),
            resources.to_owned(),
            self.period().to_string(),
            self.references(Causality::Input),
            self.references(Causality::Output),
        ]
    }

    /// The arguments that every host takes.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let resources = if self.package.description().fmi_version.text().starts_with('2') {
            self.package.resources_uri()
        } else {
            self.package.resources().to_str().expect("a path in UTF-8").to_owned()
        };
        self.arguments_at(&self.library(), &resources)
    }
}

/// A C program of `tests/c`, compiled against the standard's headers.
pub(crate) struct Host {
    program: PathBuf,
    _folder: tempfile::TempDir,
}

/// The standard's headers, which fmpy carries.
pub(crate) fn headers() -> PathBuf {
    let code = "import fmpy, os; print(os.path.join(os.path.dirname(fmpy.__file__), 'c-code'))";
    let folder = tempfile::tempdir().expect("a folder");
    PathBuf::from(python::script(code, &[], folder.path()).trim())
}

/// Compiles a source of `tests/c` with further arguments into a file.
fn compile(source: &str, arguments: &[&str], to: &Path) {
    let output = Command::new("cc")
        .args(["-std=gnu11", "-O2", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror", "-I"])
        .arg(headers())
        .arg(root().join("tests/c").join(source))
        .arg("-o")
        .arg(to)
        .args(arguments)
        .output()
        .expect("the tests need a C compiler, cc (Debian: gcc, libc6-dev)");
    assert!(output.status.success(), "{source}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Compiles a shared library of `tests/c` with further arguments into a file.
pub(crate) fn compile_library(source: &str, further: &[&str], to: &Path) {
    let arguments = ["-shared", "-fPIC", "-fvisibility=hidden", "-lm"];
    compile(source, &[&arguments[..], further].concat(), to);
}

impl Host {
    pub(crate) fn new(source: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let program = folder.path().join("host");
        compile(source, &["-rdynamic", "-ldl", "-lm", "-lpthread"], &program);
        Self { program, _folder: folder }
    }

    /// Compiles it with the address, leak and undefined-behaviour sanitizers; `None` with a line
    /// that says why, where the compiler has none.
    pub(crate) fn sanitized(source: &str) -> Option<Self> {
        let folder = tempfile::tempdir().expect("a folder");
        let program = folder.path().join("host");
        let empty = folder.path().join("empty.c");
        fs::write(&empty, "int main(void) { return 0; }").expect("written");
        let flags = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"];
        let tried = Command::new("cc").args(flags).arg(&empty).arg("-o").arg(&program).status();
        if !tried.is_ok_and(|status| status.success()) {
            println!("SKIPPED: the C compiler has no sanitizers (Debian: libgcc-12-dev)");
            return None;
        }
        let link = ["-rdynamic", "-ldl", "-lm", "-lpthread"];
        compile(source, &[&flags[..], &link[..]].concat(), &program);
        Some(Self { program, _folder: folder })
    }

    /// Runs it; the environment is such that a panic would ask for a backtrace.
    pub(crate) fn output(&self, arguments: &[String]) -> Output {
        let mut command = Command::new(&self.program);
        command.args(arguments).env("RUST_BACKTRACE", "1");
        command.output().expect("the host starts")
    }

    /// Runs it under valgrind, which must find neither a wrong access nor a leak.
    pub(crate) fn run_under_valgrind(&self, arguments: &[String]) -> String {
        let mut command = Command::new("valgrind");
        command.args(["-q", "--leak-check=full", "--show-leak-kinds=definite,indirect,possible"]);
        command.arg("--errors-for-leak-kinds=definite,indirect,possible");
        command.arg("--error-exitcode=9");
        well(&command.arg(&self.program).args(arguments).output().expect("valgrind starts"))
    }

    /// Runs it under one of valgrind's checkers of threads, which must find no race.
    pub(crate) fn run_under_checker(&self, tool: &str, arguments: &[String]) -> String {
        let mut command = Command::new("valgrind");
        command.args(["-q", &format!("--tool={tool}"), "--error-exitcode=9"]);
        well(&command.arg(&self.program).args(arguments).output().expect("valgrind starts"))
    }

    /// Runs it; it must end well and print nothing to standard error. Returns what it printed.
    pub(crate) fn run(&self, arguments: &[String]) -> String {
        well(&self.output(arguments))
    }
}

/// The seed of random calls: `PIEZOLOOP_SEED`, else always the same.
pub(crate) fn seed() -> String {
    std::env::var("PIEZOLOOP_SEED").unwrap_or_else(|_| "20".to_owned())
}

/// The arguments of `fuzz2.c` and `fuzz3.c`.
pub(crate) fn random_calls(fmu: &Packed, version: &str, rounds: &str) -> Vec<String> {
    let variables = fmu.package.description().variables.len().to_string();
    let arguments = with(fmu.arguments(), &[&variables, &seed(), rounds]);
    if version == "3" { with(arguments, &fmu.array_values()) } else { arguments }
}

/// What a host printed that ended well.
fn well(output: &Output) -> String {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{}: {errors}", output.status);
    String::from_utf8(output.stdout.clone()).expect("the host prints UTF-8")
}

/// The arguments with further ones.
pub(crate) fn with(mut arguments: Vec<String>, further: &[&str]) -> Vec<String> {
    arguments.extend(further.iter().map(|text| (*text).to_owned()));
    arguments
}

/// A copy of a folder and all below it.
pub(crate) fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a copy");
        }
    }
}
