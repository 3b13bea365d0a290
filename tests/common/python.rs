//! A Python environment of our own under `target/`, with the pinned foreign tools.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::root;

/// The interpreter with fmpy. Made once per set of requirements; several test processes wait for
/// the one that makes it.
pub(crate) fn python() -> PathBuf {
    if let Some(given) = std::env::var_os("PIEZOLOOP_PYTHON") {
        return PathBuf::from(given);
    }
    let requirements = root().join("tests/python/requirements.txt");
    let wanted = fs::read_to_string(&requirements).expect("the requirements are in the project");
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a target folder");
    let folder = target.join("python-env");
    let lock = File::create(target.join("python-env.lock")).expect("the target folder is writable");
    lock.lock().expect("a lock on the environment");
    let interpreter = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let stamp = folder.join("requirements.txt");
    if fs::read_to_string(&stamp).is_ok_and(|made_with| made_with == wanted) {
        return interpreter;
    }
    let _ = fs::remove_dir_all(&folder);
    let host = if cfg!(windows) { "python" } else { "python3" };
    run(Command::new(host).args(["-m", "venv"]).arg(&folder));
    run(Command::new(&interpreter)
        .args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--require-hashes",
            "-r",
        ])
        .arg(&requirements));
    fs::write(&stamp, wanted).expect("the environment is writable");
    interpreter
}

fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|error| {
        panic!("{command:?}: {error}; the tests need Python 3 with its venv module (Debian: python3-venv)")
    });
    assert!(
        output.status.success(),
        "{command:?} failed:\n{}{}\nThe tests need Python 3 with venv, and PyPI once",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

/// Runs a script with arguments; it must succeed. Returns its standard output.
pub(crate) fn script(code: &str, arguments: &[&str], folder: &Path) -> String {
    let path = folder.join("script.py");
    File::create(&path)
        .and_then(|mut file| file.write_all(code.as_bytes()))
        .expect("the test's folder is writable");
    let output = Command::new(python())
        .arg(&path)
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the interpreter starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "the script failed ({}):\n{text}{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    text
}
