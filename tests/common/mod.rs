//! What the tests of the tool share: the built tool, a Python with the foreign checkers, folders.
#![allow(dead_code)]

#[cfg(unix)]
pub(crate) mod bench;
pub(crate) mod faulty;
pub(crate) mod foreign;
pub(crate) mod four_axes;
#[cfg(unix)]
pub(crate) mod jobs;
pub(crate) mod packed;
pub(crate) mod python;
pub(crate) mod random;
pub(crate) mod repaired;
pub(crate) mod spy;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// A controller of two axes with a Jacobian that is not calibrated yet.
pub(crate) const COORDINATED: &str = include_str!("../blueprints/coordinated.toml");
/// A plant of one axis, u in V and y in um: two plays behind a lag of the amplifier.
pub(crate) const PLAYED: &str = include_str!("../blueprints/played.toml");

/// Runs cases side by side that wait for a machine's time.
pub(crate) fn at_once<T: Sync>(cases: &[T], run: impl Fn(&T) + Sync) {
    std::thread::scope(|scope| {
        cases.iter().for_each(|case| drop(scope.spawn(|| run(case))));
    });
}

/// What `look` finds within a minute; until then it says what it sees.
pub(crate) fn wait_for<T>(mut look: impl FnMut() -> Result<T, String>) -> T {
    let begin = Instant::now();
    loop {
        match look() {
            Ok(found) => return found,
            Err(seen) => assert!(begin.elapsed() < Duration::from_secs(60), "{seen}"),
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Runs the tool and returns what it said.
pub(crate) fn piezoloop(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the tool starts")
}

/// Runs the tool, which must succeed, and returns its standard output.
pub(crate) fn succeed(arguments: &[&str], folder: &Path) -> String {
    let output = piezoloop(arguments, folder);
    assert!(
        output.status.success(),
        "piezoloop {} failed ({}):\n{}{}",
        arguments.join(" "),
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("the tool prints UTF-8")
}

/// Runs the tool with `--json`, which must succeed, and returns the parsed answer.
pub(crate) fn json(arguments: &[&str], folder: &Path) -> serde_json::Value {
    let mut all = vec!["--json"];
    all.extend(arguments);
    serde_json::from_str(&succeed(&all, folder)).expect("--json prints JSON")
}

/// Runs the tool, which must refuse (exit code not 0, nothing panics), and returns its message.
pub(crate) fn refuse(arguments: &[&str], folder: &Path) -> String {
    let output = piezoloop(arguments, folder);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let code = output.status.code();
    assert!(code.is_some_and(|c| c != 0 && c != 101), "exit {code:?}: {message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

/// The shell's own `kill`: a small system has no program of that name.
pub(crate) fn kill(arguments: &[&str]) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", "kill \"$@\"", "sh"]).args(arguments);
    command
}

/// The workspace's root.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A measured log, or `None` with a line that says why the test is skipped.
pub(crate) fn measured(file: &str) -> Option<PathBuf> {
    let path = root().join("../shared/data").join(file);
    if path.is_file() {
        return Some(path);
    }
    eprintln!("SKIPPED: no measured log at {}", path.display());
    None
}
