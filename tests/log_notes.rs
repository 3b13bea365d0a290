//! What commands say about the logs that they read.

use std::path::Path;
use std::process::{Command, Output};

fn piezoloop(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_piezoloop"));
    command.args(arguments).current_dir(folder).output().expect("the tool runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

/// A steady answer to a triangle, with semicolons and a column of texts.
fn log(folder: &Path) {
    let rows: Vec<String> = (0..400)
        .map(|k| {
            let u = f64::from((k % 100 - 50_i32).abs()) / 5.0;
            format!("{};{u};{};Running", f64::from(k) / 1000.0, 2.0 * u + 1.0)
        })
        .collect();
    std::fs::write(
        folder.join("log.csv"),
        format!("Time (s);u (V);y (um);state\n{}\n", rows.join("\n")),
    )
    .unwrap();
}

#[test]
fn log_says_what_it_recognised_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    log(folder.path());
    let message = piezoloop(folder.path(), &["log", "log.csv"]);
    let words = text(&message.stdout);
    assert!(words.contains("note: log.csv: cells are separated by semicolons"), "{words}");
    assert!(words.contains("column \"state\" is left out: it holds texts"), "{words}");
    assert_eq!(text(&message.stderr), "", "it is said once");
    let answer = &json(&piezoloop(folder.path(), &["log", "--json", "log.csv"]))["logs"][0];
    assert_eq!(answer["left_out"][0]["name"], "state");
    assert!(answer["notes"].as_array().unwrap().len() >= 2, "{answer}");
    assert_eq!(answer["columns"][1]["unit"], "um");
}

#[test]
fn every_command_says_it_once_and_in_its_json() {
    let folder = tempfile::tempdir().unwrap();
    log(folder.path());
    let ask = [
        "identify",
        "--log",
        "log.csv",
        "--log",
        "log.csv",
        "--input",
        "u",
        "--output",
        "y",
        "--model",
        "prandtl-ishlinskii",
    ];
    let output = piezoloop(folder.path(), &[&ask[..], &["--json", "-o", "a.toml"]].concat());
    let notes = json(&output)["log_notes"].as_array().expect("notes").clone();
    assert!(notes.iter().any(|note| note.as_str().unwrap().contains("state")), "{notes:?}");
    let words = text(&output.stderr);
    assert_eq!(words.matches("note: log.csv: column \"state\" is left out").count(), 1, "{words}");
    let quiet = piezoloop(folder.path(), &[&ask[..], &["--quiet", "-o", "b.toml"]].concat());
    assert_eq!(text(&quiet.stderr), "");
    // What is left out is an error where it is used.
    let refused = piezoloop(
        folder.path(),
        &["identify", "--log", "log.csv", "--input", "state", "--output", "y"],
    );
    assert!(
        text(&refused.stderr).contains("state: cannot be used: it holds texts"),
        "{}",
        text(&refused.stderr)
    );
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn names_and_rates_are_options_of_every_command() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bare.txt"), "0 1.5\n1 2\n3 4\n").unwrap();
    let bare = piezoloop(folder.path(), &["log", "bare.txt"]);
    assert!(text(&bare.stderr).contains("--columns time,y1"), "{}", text(&bare.stderr));
    let ask = ["log", "bare.txt", "--columns", "time,y [um]", "--resample=2", "-o", "even.csv"];
    let output = piezoloop(folder.path(), &ask);
    assert!(text(&output.stdout).contains("resampled onto 2 Hz"), "{}", text(&output.stdout));
    let even = std::fs::read_to_string(folder.path().join("even.csv")).unwrap();
    assert_eq!(even.lines().nth(4), Some("1.5,2.5"), "{even}");
    for bad in ["0", "-1", "NaN", "inf", "x", ""] {
        let output = piezoloop(folder.path(), &["log", "bare.txt", &format!("--resample={bad}")]);
        assert_eq!(output.status.code(), Some(2), "{bad}");
    }
}
