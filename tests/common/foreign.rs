//! Further Python environments, with foreign tools that not every machine can have.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use super::root;

/// The interpreter with the foreign tools, or `None` with a line that says why tests are skipped.
pub(crate) fn python() -> Option<&'static Path> {
    static MADE: OnceLock<Option<PathBuf>> = OnceLock::new();
    MADE.get_or_init(|| environment("foreign")).as_deref()
}

/// The interpreter with the packages of `tests/python/requirements-<name>.txt`, made once under
/// `target/`; or `None` with a line that says why tests are skipped. The variable
/// `PIEZOLOOP_<NAME>_PYTHON` may name an interpreter that has them.
pub(crate) fn environment(name: &str) -> Option<PathBuf> {
    let made = make(name);
    if let Err(reason) = &made {
        println!("SKIPPED: no environment of requirements-{name}.txt: {reason}");
    }
    made.ok()
}

fn make(name: &str) -> Result<PathBuf, String> {
    if let Some(given) = std::env::var_os(format!("PIEZOLOOP_{}_PYTHON", name.to_uppercase())) {
        return Ok(PathBuf::from(given));
    }
    let requirements = root().join(format!("tests/python/requirements-{name}.txt"));
    let base = root().join("tests/python/requirements.txt");
    let text = |path: &Path| fs::read_to_string(path).map_err(|e| e.to_string());
    let wanted = text(&base)? + &text(&requirements)?;
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().ok_or("no target folder")?;
    let folder = target.join(format!("python-{name}"));
    let lock =
        File::create(target.join(format!("python-{name}.lock"))).map_err(|e| e.to_string())?;
    lock.lock().map_err(|e| e.to_string())?;
    let interpreter = folder.join("bin/python");
    let stamp = folder.join("requirements.txt");
    if text(&stamp).is_ok_and(|made_with| made_with == wanted) {
        return Ok(interpreter);
    }
    let _ = fs::remove_dir_all(&folder);
    succeed(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
    let pip = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--require-hashes",
        "-r",
    ];
    succeed(Command::new(&interpreter).args(pip).arg(&requirements))?;
    fs::write(&stamp, wanted).map_err(|e| e.to_string())?;
    Ok(interpreter)
}

fn succeed(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    Err(errors.lines().last().unwrap_or("no message").to_owned())
}

/// A command-line tool of the environment.
pub(crate) fn tool(python: &Path, name: &str) -> Command {
    Command::new(python.with_file_name(name))
}

/// Runs a command in a folder; it must succeed. Returns all it printed.
pub(crate) fn said(command: &mut Command, folder: &Path) -> String {
    let output = command.current_dir(folder).output().expect("the tool starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?} failed ({}):\n{text}", output.status);
    text
}

/// Runs a script of `tests/python` in a folder; it must succeed. Returns all it printed.
pub(crate) fn script(python: &Path, name: &str, arguments: &[&str], folder: &Path) -> String {
    let file = root().join("tests/python").join(name);
    said(Command::new(python).arg(file).args(arguments), folder)
}
