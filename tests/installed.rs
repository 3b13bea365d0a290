//! What an installation brings besides the commands: completions, manual pages, the Python package.

use crate::common;

use common::{refuse, root, succeed};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Names of the commands that `piezoloop --help` shows.
fn commands(folder: &Path) -> Vec<String> {
    let help = succeed(&["--help"], folder);
    let rows = help.split("Commands:").nth(1).expect("the help lists commands");
    let rows = rows.split("Options:").next().expect("options follow");
    // A sentence that goes on in the next line is indented more.
    let rows = rows.lines().filter_map(|row| row.strip_prefix("  "));
    let names = rows.filter(|row| !row.starts_with(' ')).filter_map(|row| row.split(' ').next());
    names.filter(|name| !["help", ""].contains(name)).map(str::to_owned).collect()
}

#[test]
fn every_command_is_completed_and_has_a_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let commands = commands(folder);
    assert!(commands.len() > 10, "{commands:?}");
    succeed(&["man", "-o", "man"], folder);
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = succeed(&["completions", shell], folder);
        for command in &commands {
            assert!(script.contains(command.as_str()), "{shell} does not complete {command}");
        }
    }
    for command in &commands {
        let page = folder.join(format!("man/piezoloop-{command}.1"));
        let page = fs::read_to_string(page).expect("a page per command");
        assert!(page.contains(".SH SYNOPSIS") && page.contains(".SH OPTIONS"), "{command}");
    }
    assert!(refuse(&["completions", "tcsh"], folder).contains("bash"));
    fs::write(folder.join("file"), "").expect("the folder is writable");
    assert!(refuse(&["man", "-o", "file"], folder).contains("file"));
}

#[test]
fn bash_takes_the_completions() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = succeed(&["completions", "bash"], folder.path());
    fs::write(folder.path().join("completions"), script).expect("the folder is writable");
    let code = "source completions && COMP_WORDS=(piezoloop ide) COMP_CWORD=1 && \
                _piezoloop piezoloop ide piezoloop && echo \"${COMPREPLY[@]}\"";
    let Ok(output) = Command::new("bash").args(["-c", code]).current_dir(folder.path()).output()
    else {
        println!("SKIPPED: no bash here");
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(text.trim(), "identify", "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_python_package_gives_fmus_diagnoses_and_arrays() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(common::python::python())
        .arg(root().join("tests/python/package.py"))
        .arg(root().join("tests/blueprints/straight.toml"))
        .env("PYTHONPATH", root().join("python"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("PIEZOLOOP", env!("CARGO_BIN_EXE_piezoloop"))
        .current_dir(folder.path())
        .output()
        .expect("the interpreter starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && text.contains("the package works"), "{text}{errors}");
}
