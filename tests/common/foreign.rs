//! Further Python environments, with foreign tools that not every machine can have.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use super::{python, root};

/// The interpreter with the foreign tools, or `None` with a line that says why tests are skipped.
pub(crate) fn python() -> Option<&'static Path> {
    static ENVIRONMENT: OnceLock<Option<PathBuf>> = OnceLock::new();
    ENVIRONMENT.get_or_init(|| environment("foreign")).as_deref()
}

/// The interpreter with the packages of `tests/python/requirements-<name>.txt`, made once under
/// `target/`; or `None` with a line that says why tests are skipped. The variable
/// `PIEZOLOOP_<NAME>_PYTHON` may name an interpreter that has them.
pub(crate) fn environment(name: &str) -> Option<PathBuf> {
    let built = make(name);
    if let Err(reason) = &built {
        println!("SKIPPED: no environment of requirements-{name}.txt: {reason}");
    }
    built.ok()
}

fn make(name: &str) -> Result<PathBuf, String> {
    if let Some(given) = std::env::var_os(format!("PIEZOLOOP_{}_PYTHON", name.to_uppercase())) {
        return Ok(PathBuf::from(given));
    }
    let requirements = root().join(format!("tests/python/requirements-{name}.txt"));
    let base = root().join("tests/python/requirements.txt");
    let base = std::fs::read_to_string(base).map_err(|error| error.to_string())?;
    python::environment(&format!("python-{name}"), &requirements, &base)
}

/// A command-line tool of the environment.
pub(crate) fn tool(python: &Path, name: &str) -> Command {
    Command::new(python.with_file_name(name))
}

/// Runs a command in a folder; it must succeed. Returns all it printed.
pub(crate) fn message(command: &mut Command, folder: &Path) -> String {
    let output = command.current_dir(folder).output().expect("the tool starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?} failed ({}):\n{text}", output.status);
    text
}

/// Runs a script of `tests/python` in a folder; it must succeed. Returns all it printed.
pub(crate) fn script(python: &Path, name: &str, arguments: &[&str], folder: &Path) -> String {
    let file = root().join("tests/python").join(name);
    message(Command::new(python).arg(file).args(arguments), folder)
}
