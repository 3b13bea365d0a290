//! A Python environment of our own under `target/`, with the pinned foreign tools.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::root;

/// The variable with an interpreter that has the foreign tools.
const GIVEN: &str = "PIEZOLOOP_PYTHON";
/// The environment with fmpy.
const FIRST: &str = "python-env";

/// The interpreter with fmpy. Made once per set of requirements; several test processes wait for
/// the one that makes it.
pub(crate) fn python() -> PathBuf {
    if let Some(given) = std::env::var_os(GIVEN) {
        return PathBuf::from(given);
    }
    let requirements = root().join("tests/python/requirements.txt");
    let built = environment(FIRST, &requirements, "");
    built.unwrap_or_else(|error| {
        panic!("{error}\nThe tests need Python 3 with venv (Debian: python3-venv), and PyPI once")
    })
}

/// The interpreter of `target/<folder>` with the packages of a file of requirements, made anew where
/// that file, or the text `also`, is another one than when it was made.
pub(crate) fn environment(
    folder: &str,
    requirements: &Path,
    also: &str,
) -> Result<PathBuf, String> {
    let text = |path: &Path| {
        fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let wanted = also.to_owned() + &text(requirements)?;
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().ok_or("no target folder")?;
    let lock = File::create(target.join(format!("{folder}.lock"))).map_err(|e| e.to_string())?;
    lock.lock().map_err(|error| error.to_string())?;
    let folder = target.join(folder);
    let interpreter = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let stamp = folder.join("requirements.txt");
    if text(&stamp).is_ok_and(|version| version == wanted) {
        return Ok(interpreter);
    }
    let _ = fs::remove_dir_all(&folder);
    let host = if cfg!(windows) { "python" } else { "python3" };
    let mut make = Command::new(host);
    make.args(["-m", "venv"]).arg(&folder);
    // The environment with fmpy has pip, which fills the others, too: unpacking it takes longer than all else here.
    let is_filled_by_another = folder != target.join(FIRST) && std::env::var_os(GIVEN).is_none();
    let mut install = if is_filled_by_another {
        run(make.arg("--without-pip"))?;
        Command::new(python())
    } else {
        run(&mut make)?;
        Command::new(&interpreter)
    };
    install.args(["-m", "pip", "--disable-pip-version-check"]);
    if is_filled_by_another {
        install.arg("--python").arg(&interpreter);
    }
    install
        .args(["install", "--quiet", "--no-compile", "--require-hashes", "-r"])
        .arg(requirements);
    run(&mut install)?;
    fs::write(&stamp, wanted).map_err(|error| error.to_string())?;
    Ok(interpreter)
}

fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    Err(errors.lines().last().unwrap_or("no message").to_owned())
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
