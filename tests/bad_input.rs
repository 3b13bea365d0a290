//! Bad input gets an error that names the file, the value, the rule and the way out; nothing is
//! written, nothing panics, the exit code is not 0.

use crate::common;

use std::fs;
use std::path::Path;

use common::{piezoloop, refuse, succeed};

/// A folder with a packed plant, its controller and a short log.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    succeed(&["pack", "evc", "-o", "plant.fmu"], folder.path());
    succeed(&["invert", "evc", "-o", "controller.toml"], folder.path());
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder.path());
    write(folder.path(), "log.csv", "time,command[1],command[2]\n0,0,0\n0.001,10,5\n0.002,20,9\n");
    folder
}

fn write(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), text).expect("the folder is writable");
}

/// Refuses, says all `words`, and leaves nothing behind.
fn refuses(folder: &Path, arguments: &[&str], words: &[&str]) {
    let listing = |folder: &Path| {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> = entries.flatten().map(|e| e.file_name()).collect();
        names.sort();
        names
    };
    let before = listing(folder);
    let message = refuse(arguments, folder);
    for word in words {
        assert!(message.contains(word), "\"{word}\" is not in: {message}");
    }
    assert_eq!(listing(folder), before, "{arguments:?} left files behind");
}

#[test]
fn files_that_are_not_there_or_not_what_they_should_be() {
    let folder = prepared();
    let at = folder.path();
    write(at, "broken.fmu", "this is no archive");
    write(at, "broken.toml", "piezoloop = 1\nkind = \"plant\"\nname = ");
    refuses(at, &["pack", "nothing.toml", "-o", "x.fmu"], &["nothing.toml"]);
    refuses(at, &["pack", "no_such_rig", "-o", "x.fmu"], &["no_such_rig", "evc"]);
    refuses(at, &["pack", "broken.toml", "-o", "x.fmu"], &["broken.toml", "3"]);
    refuses(at, &["simulate", "broken.fmu", "--log", "log.csv", "-o", "x.csv"], &["broken.fmu"]);
    refuses(at, &["simulate", "none.fmu", "--log", "log.csv", "-o", "x.csv"], &["none.fmu"]);
    refuses(at, &["simulate", "plant.fmu", "--log", "none.csv", "-o", "x.csv"], &["none.csv"]);
    refuses(at, &["invert", "controller.toml", "-o", "x.toml"], &["controller", "plant"]);
    // One kind of file in the place of another.
    refuses(at, &["invert", "plant.fmu", "-o", "x.toml"], &["FMU", "blueprint", ".toml"]);
    refuses(at, &["log", "controller.toml"], &["is a blueprint, no log"]);
    refuses(at, &["log", "plant.fmu"], &["is an FMU, no log"]);
    refuses(
        at,
        &["bench", "run", "--plan", "controller.toml", "--gateway", "udp://127.0.0.1:9"],
        &["controller.toml:", "is a blueprint, no plan of the bench"],
    );
    refuses(at, &["sweep", "controller.toml"], &["is a blueprint, no plan of a sweep"]);
    refuses(at, &["system", "controller.toml"], &["is a blueprint, no system of FMUs"]);
    let rows: String = (0..100).map(|k| format!("{k},{k}\n")).collect();
    write(at, "rows.csv", &rows);
    let message = refuse(&["pack", "rows.csv", "-o", "x.fmu"], at);
    assert!(message.lines().count() < 12 && message.contains("further places"), "{message}");
    refuses(at, &["pack", "evc", "-o", "no/such/folder/x.fmu"], &["no/such/folder"]);
}

#[test]
fn an_ending_says_what_is_written() {
    let folder = prepared();
    let at = folder.path();
    let drive = ["simulate", "plant.fmu", "--log", "log.csv", "-o"];
    for ending in ["xyz", "mf4", "mat", "CVS"] {
        let out = format!("x.{ending}");
        refuses(at, &[&drive[..], &[&out]].concat(), &[".csv, .txt, .npy, .npz or .parquet"]);
        refuses(at, &["log", "log.csv", "-o", &out], &[".csv or .txt"]);
        refuses(at, &["signal", "ellipse", "-o", &out], &[".csv or .txt"]);
    }
    refuses(at, &["log", "log.csv", "-o", "x.parquet"], &[".parquet is not written here"]);
    refuses(at, &["pack", "evc", "-o", "x.toml"], &["ends in .fmu"]);
    refuses(at, &["invert", "evc", "-o", "x.fmu"], &["ends in .toml"]);
    refuses(at, &[&drive[..], &["x.csv", "--report", "x.pdf"]].concat(), &[".html, .htm or .json"]);
    // What only looks like an ending of a pipe or device is none.
    for out in ["/dev/null", "x.csv", "y"] {
        succeed(&[&drive[..], &[out]].concat(), at);
    }
}

#[test]
fn names_that_do_not_exist() {
    let folder = prepared();
    let at = folder.path();
    let drive = |more: &[&'static str]| {
        let mut all = vec!["simulate", "plant.fmu", "--log", "log.csv", "-o", "x.csv"];
        all.extend(more);
        all
    };
    refuses(at, &drive(&["--map", "command[1]=volts"]), &["log.csv", "volts", "command[1]"]);
    refuses(at, &drive(&["--map", "command[1]"]), &["command[1]", "="]);
    refuses(at, &drive(&["--start", "axis[1].mechanics.dampng=0.1"]), &["dampng"]);
    refuses(at, &drive(&["--start", "axis[1].mechanics.damping=high"]), &["damping", "high"]);
    refuses(at, &drive(&["--start", "axis[1].mechanics.damping=-3"]), &["damping", "-3"]);
    let tune =
        ["diagnose", "--model", "evc", "--log", "log.csv", "--tune", "*.mechanics.frequenzy=0.1"];
    refuses(at, &tune, &["--tune *.mechanics.frequenzy", "no parameter of the model"]);
    let noise = ["diagnose", "--model", "evc", "--log", "log.csv", "--noise", "positon[1]=0.1"];
    refuses(at, &noise, &["--noise positon[1]", "did you mean position[1]?"]);
    refuses(at, &drive(&["--unit", "command[1]=furlong"]), &["furlong"]);
    refuses(at, &drive(&["--unit", "command[1]=um"]), &["um", "V"]);
    refuses(at, &drive(&["--rows", "9..2"]), &["9..2"]);
    refuses(at, &drive(&["--map", "comand[1]=command[1]"]), &["did you mean command[1]="]);
    refuses(at, &drive(&["--map", "time=tiem"]), &["log.csv", "tiem"]);
    refuses(at, &["list", "rigs", "--show", "hubble"], &["hubble", "evc"]);
    refuses(at, &["list", "rigs", "--show", "evc-truht"], &["did you mean evc-truth?"]);
    refuses(at, &["pack", "evc-truht", "-o", "x.fmu"], &["did you mean evc-truth?"]);
    refuses(at, &["signal", "trianle", "-o", "x.csv"], &["did you mean triangle?"]);
    let identify = |input: &'static str, output: &'static str| {
        vec!["identify", "--log", "log.csv", "--input", input, "--output", output, "-o", "x.toml"]
    };
    refuses(at, &identify("comand", "command[2]"), &["did you mean \"command[1]\"?"]);
    refuses(at, &identify("command[1]", "command[1]"), &["input and output"]);
    refuses(at, &["pack", "evc", "--binary", "amiga=x.so"], &["amiga", "linux64"]);
    refuses(at, &["pack", "evc", "--binary", "win64=none.dll"], &["none.dll"]);
}

#[test]
fn logs_that_cannot_be_used() {
    let folder = prepared();
    let at = folder.path();
    let cases = [
        ("back.csv", "time,command[1]\n0,0\n0.002,1\n0.001,2\n", ["back.csv", "4", "time"]),
        ("nan.csv", "time,command[1]\n0,0\n0.001,nan\n", ["nan.csv", "3", "command[1]"]),
        ("ragged.csv", "time,command[1]\n0,0\n0.001\n", ["ragged.csv", "3", ""]),
        ("comma.csv", "time,command[1]\n0,\"0,5\"\n", ["comma.csv", "2", "comma"]),
        ("text.csv", "time,command[1]\n0,zero\n", ["text.csv", "2", "zero"]),
        ("empty.csv", "", ["empty.csv", "", ""]),
    ];
    for (name, text, words) in cases {
        write(at, name, text);
        refuses(at, &["simulate", "plant.fmu", "--log", name, "-o", "x.csv"], &words);
    }
    write(
        at,
        "still.csv",
        &(0..200)
            .fold("time,u,y\n".to_owned(), |t, k| t + &format!("{},3,1\n", 0.01 * f64::from(k))),
    );
    let identify =
        ["identify", "--log", "still.csv", "--input", "u", "--output", "y", "-o", "x.toml"];
    refuses(at, &identify, &["still.csv", "u", "3"]);
    let columns = ["identify", "--log", "log.csv", "--input", "u", "--output", "y", "-o", "x.toml"];
    refuses(at, &columns, &["log.csv", "u", "command[1]"]);
}

#[test]
fn loops_that_cannot_be_closed() {
    let folder = prepared();
    let at = folder.path();
    write(at, "ref.csv", "time,reference[1],reference[2]\n0,0,0\n0.001,1,1\n");
    let close = |fmus: &[&'static str], more: &[&'static str]| {
        let mut all = vec!["simulate", "--loop"];
        all.extend(fmus);
        all.extend(["--reference", "ref.csv", "-o", "x.csv"]);
        all.extend(more);
        all
    };
    refuses(at, &close(&["plant.fmu"], &[]), &["two FMUs"]);
    refuses(at, &close(&["plant.fmu", "plant.fmu"], &[]), &["controller"]);
    refuses(at, &close(&["controller.fmu", "plant.fmu"], &[]), &["give the plant first"]);
    refuses(at, &close(&["plant.fmu", "controller.fmu"], &["--step", "-1"]), &["step"]);
    refuses(
        at,
        &close(&["plant.fmu", "controller.fmu"], &["--start", "x=1"]),
        &["plant.", "controller."],
    );
    refuses(at, &["simulate", "plant.fmu", "controller.fmu", "--log", "log.csv"], &["--loop"]);
}

#[test]
fn a_connection_to_nothing_names_its_file_once() {
    let folder = prepared();
    let at = folder.path();
    let system = "name = \"s\"\nstep = 1e-3\nstop = 2e-3\n[fmus]\na = \"plant.fmu\"\nb = \"plant.fmu\"\n\
                  [connections]\n\"b.command[1]\" = \"a.positon[1]\"\n";
    write(at, "system.toml", system);
    let messages = refuse(&["system", "system.toml", "-o", "x.csv"], at);
    assert!(
        messages.starts_with("error: system.toml:8: FMU `a` has no variable `positon[1]`"),
        "{messages}"
    );
    assert_eq!(messages.matches("positon").count(), 1, "{messages}");
}

#[test]
fn times_that_cannot_be_seconds_are_asked_about() {
    let folder = prepared();
    let at = folder.path();
    let rows = |factor: f64, last: &str| {
        let mut text = "time,command[1],position[1]\n".to_owned();
        for k in 0..200 {
            let u = f64::from(k % 20);
            text.push_str(&format!("{},{u},{}\n", f64::from(k) * factor, 0.1 * u));
        }
        text + last
    };
    write(at, "us.csv", &rows(1000.0, ""));
    write(at, "stray.csv", &rows(1e-3, "1e9,3,0.3\n"));
    for (log, asked) in [("us.csv", "is time in us?"), ("stray.csv", "is that time a slip?")] {
        for model in ["plant.fmu", "evc"] {
            let diagnose = ["diagnose", "--model", model, "--log", log];
            let estimate = ["estimate", model, "--log", log, "--tune", "axis[1].amplifier.gain"];
            for call in [&diagnose[..], &estimate] {
                refuses(at, call, &[asked, "--most-steps"]);
            }
        }
        refuses(at, &["simulate", "plant.fmu", "--log", log, "-o", "x.csv"], &[asked]);
    }
}

#[test]
fn what_is_read_is_never_written_over() {
    let folder = prepared();
    let at = folder.path();
    let before = fs::read(at.join("log.csv")).expect("the log");
    refuses(
        at,
        &["simulate", "plant.fmu", "--log", "log.csv", "-o", "log.csv"],
        &["log.csv", "-o"],
    );
    refuses(
        at,
        &["invert", "controller.toml", "-o", "controller.toml"],
        &["controller.toml", "-o"],
    );
    assert_eq!(fs::read(at.join("log.csv")).expect("the log"), before);
}

#[test]
fn errors_are_json_where_json_is_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = piezoloop(&["--json", "pack", "none.toml", "-o", "x.fmu"], folder.path());
    let error: serde_json::Value = serde_json::from_slice(&output.stderr).expect("JSON");
    assert!(error["error"].as_str().is_some_and(|text| text.contains("none.toml")));
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn every_command_has_help_with_an_example() {
    let folder = tempfile::tempdir().expect("a folder");
    let help = succeed(&["--help"], folder.path());
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| line.starts_with("  "))
        .filter(|line| !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    assert!(commands.len() >= 7, "{commands:?}");
    for command in commands {
        let help = succeed(&[command, "--help"], folder.path());
        assert!(help.contains("Example"), "{command} has no example");
        assert!(help.contains(&format!("piezoloop {command}")), "{command}: {help}");
    }
}
