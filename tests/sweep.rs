//! Sweeps: the same bytes whatever the threads, shards and pauses; what is wrong is told.
#![cfg(unix)]

use crate::common;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use common::{refuse, root, succeed, wait_for};

/// A loop of rig evc over a short ellipse.
fn prepared(folder: &Path) {
    succeed(&["invert", "evc", "-o", "controller.toml"], folder);
    let ellipse = ["--set", "duration=0.06", "--set", "rise=0.01", "-o", "ellipse.csv"];
    succeed(&[&["signal", "p4-ellipse"], &ellipse[..]].concat(), folder);
}

fn plan(folder: &Path, runs: usize, vary: &str) {
    let text = format!(
        "runs = {runs}\nseed = 7\n\n[loop]\nplant = \"evc\"\ncontroller = \"controller.toml\"\n\
         reference = \"ellipse.csv\"\nmap = {{ \"reference[1]\" = \"y\", \"reference[2]\" = \"z\" }}\n\
         from = 0.02\n\n[vary]\n{vary}"
    );
    fs::write(folder.join("plan.toml"), text).expect("the folder is writable");
}

const VARY: &str = "\"plant.*.mechanics.frequency\" = { tolerance = 0.05 }\n\
                    \"controller.*.pid.ki\" = { within = 0.3 }\n";

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).expect("a table")
}

#[test]
fn threads_shards_and_a_kill_leave_no_trace() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    plan(folder, 300, VARY);
    succeed(&["sweep", "plan.toml", "--threads", "1", "-o", "one.parquet"], folder);
    succeed(&["sweep", "plan.toml", "--threads", "5", "-o", "five.parquet"], folder);
    let complete = bytes(folder, "one.parquet");
    assert!(complete == bytes(folder, "five.parquet"));
    // A pipe gets the table too; nobody looks whether there is one in it already.
    assert!(Command::new("mkfifo").arg(folder.join("pipe")).status().expect("mkfifo").success());
    let pipe = folder.join("pipe");
    let reader = std::thread::spawn(move || fs::read(pipe).expect("a table"));
    succeed(&["sweep", "plan.toml", "-o", "pipe"], folder);
    assert!(complete == reader.join().expect("read"));
    // Shards, in any order.
    for shard in ["3/3", "1/3", "2/3"] {
        succeed(&["sweep", "plan.toml", "--shard", shard], folder);
    }
    let parts = ["plan.2-of-3.parquet", "plan.3-of-3.parquet", "plan.1-of-3.parquet"];
    succeed(&[&["sweep", "merge"], &parts[..], &["-o", "merged.parquet"]].concat(), folder);
    assert!(complete == bytes(folder, "merged.parquet"));
    let message = refuse(&["sweep", "merge", parts[0], parts[1], "-o", "less.parquet"], folder);
    assert!(message.contains("runs 0 to 99 are missing"), "{message}");
    assert!(!folder.join("less.parquet").exists());
    // Killed in the midst, then called again.
    let mut killed = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(["sweep", "plan.toml", "--threads", "1", "-o", "killed.parquet"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .spawn()
        .expect("the tool starts");
    let journal = folder.join("killed.parquet.journal");
    wait_for(|| match fs::metadata(&journal) {
        Ok(about) if about.len() >= 5000 => Ok(()),
        about => Err(format!("no run was kept: {about:?}")),
    });
    killed.kill().expect("it runs");
    killed.wait().expect("it ends");
    assert!(!folder.join("killed.parquet").exists(), "a table appears whole");
    let answer = succeed(&["--json", "sweep", "plan.toml", "-o", "killed.parquet"], folder);
    let answer: serde_json::Value = serde_json::from_str(&answer).expect("JSON");
    let fresh = answer["fresh"].as_u64().expect("a number");
    assert!(fresh > 0 && fresh < 300, "{fresh} runs were run again");
    assert!(complete == bytes(folder, "killed.parquet"));
    assert!(!journal.exists());
    // Called once more, nothing is run.
    let message = succeed(&["sweep", "plan.toml", "-o", "killed.parquet"], folder);
    assert!(message.contains("there already"), "{message}");
}

#[test]
fn a_run_is_the_run_of_simulate() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    plan(folder, 3, VARY);
    succeed(&["sweep", "plan.toml", "-o", "all.parquet"], folder);
    succeed(&["pack", "evc", "-o", "plant.fmu"], folder);
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder);
    let script = "import json, sys, pyarrow.parquet as p\n\
                  t = p.read_table(sys.argv[1]).to_pylist()\nprint(json.dumps(t))";
    let Some(python) = common::foreign::python() else { return };
    let output = Command::new(python)
        .args(["-c", script])
        .arg(folder.join("all.parquet"))
        .output()
        .expect("the interpreter starts");
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).expect("rows");
    let rows = rows.as_array().expect("rows");
    assert_eq!(rows.len(), 3);
    for row in rows {
        let mut loop_of = vec!["--json", "simulate", "--loop", "plant.fmu", "controller.fmu"];
        loop_of.extend(["--reference", "ellipse.csv", "--drop", "0.02"]);
        loop_of.extend(["--map", "reference[1]=y", "--map", "reference[2]=z"]);
        let starts: Vec<String> = row
            .as_object()
            .expect("a row")
            .iter()
            .filter(|(name, _)| name.contains('.'))
            .map(|(name, value)| format!("{name}={value}"))
            .collect();
        assert_eq!(starts.len(), 4, "{starts:?}");
        for start in &starts {
            loop_of.extend(["--start", start]);
        }
        let answer: serde_json::Value =
            serde_json::from_str(&succeed(&loop_of, folder)).expect("JSON");
        for (axis, fit) in (1..).zip(answer["fits"].as_array().expect("fits")) {
            for (ours, theirs) in [("rms_error", "raw_rmse"), ("max_error", "raw_max_error")] {
                let ours = row[format!("{ours}[{axis}]")].as_f64().expect("a figure");
                let theirs = fit[theirs].as_f64().expect("a figure");
                assert!((ours / theirs - 1.0).abs() < 1e-12, "{axis}: {ours} {theirs}");
            }
        }
    }
    let errors: Vec<&serde_json::Value> = rows.iter().map(|row| &row["rms_error[1]"]).collect();
    assert!(errors[0] != errors[1] && errors[1] != errors[2], "{errors:?}");
}

#[test]
fn effects_and_gains_vary_on_grids() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    let vary = "\"plant.axis[1].backlash.enabled\" = { grid = [false, true] }\n\
                \"plant.axis[1].backlash.width\" = { choice = [0.2] }\n\
                \"controller.axis[1].pid.ki\" = { grid = [3000, 6000] }\n";
    plan(folder, 1, vary);
    let text = fs::read_to_string(folder.join("plan.toml")).expect("the plan");
    let all = text.replace("from = 0.02", "from = 0.02\nall-effects = true");
    fs::write(folder.join("plan.toml"), all).expect("the folder is writable");
    let message = succeed(&["sweep", "plan.toml"], folder);
    assert!(message.contains("4 runs") && message.contains("false 2, true 2"), "{message}");
    // A run that fails is a row that says so, and an exit code of 1: an amplifier without bandwidth.
    plan(folder, 1, "\"plant.axis[1].amplifier.bandwidth\" = { grid = [3000, 0] }\n");
    let output = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(["sweep", "plan.toml", "-o", "failing.parquet"])
        .current_dir(folder)
        .output()
        .expect("the tool starts");
    let message = String::from_utf8_lossy(&output.stdout);
    println!("{message}");
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("1 failed, the first is run 1: "), "{message}");
}

#[test]
fn systems_and_campaigns_are_swept_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    succeed(&["pack", "evc", "--all-effects", "-o", "plant.fmu"], folder);
    succeed(&["pack", "controller.toml", "-o", "controller.fmu"], folder);
    for file in ["loop.toml", "repaired.ssv"] {
        let source = root().join("examples/03_system").join(file);
        fs::copy(source, folder.join(file)).expect("the folder is writable");
    }
    succeed(&["system", "loop.toml", "--export", "loop.ssp"], folder);
    let system = |file: &str| {
        format!(
            "runs = 4\n[system]\nfile = \"{file}\"\ninput = \"ellipse.csv\"\nparameters = \
             [\"repaired.ssv\"]\nmap = {{ \"reference[1]\" = \"y\", \"reference[2]\" = \"z\" }}\n\
             [measure]\nlargest = {{ column = \"position[1]\", take = \"max\" }}\n[vary]\n\
             \"plant.axis[1].delay.delay\" = {{ uniform = [1e-4, 3e-4] }}\n"
        )
    };
    // An SSP says what its TOML says.
    let [toml, ssp] = ["loop.toml", "loop.ssp"].map(|file| {
        fs::write(folder.join("system.toml"), system(file)).expect("the folder is writable");
        let answer =
            succeed(&["--json", "sweep", "system.toml", "-o", &format!("{file}.parquet")], folder);
        let answer: serde_json::Value = serde_json::from_str(&answer).expect("JSON");
        answer["figures"].clone()
    });
    assert_eq!(toml.as_array().expect("figures").len(), 2);
    assert_eq!(toml, ssp);
    let spread = |part: &str| toml[1][part].as_f64().expect("a figure");
    assert!(spread("percent_5") < spread("max"), "{toml}");
    // Two logs, each identified with one hysteresis model.
    let triangle = ["signal", "triangle-decaying", "--set", "low=0", "--set", "high=10"];
    let length = ["--set", "frequency=2", "--set", "cycles=2", "--set", "sample_time=2e-3"];
    let rename = ["--rename", "u=command[1]", "-o", "triangles.csv"];
    succeed(&[&triangle[..], &length, &rename].concat(), folder);
    let identify = "runs = 2\n[identify]\nmachine = \"p1-truth\"\nlogs = [\"triangles.csv\"]\n\
                    options = [\"--model\", \"prandtl-ishlinskii\"]\n[vary]\n\
                    \"option.plays\" = { grid = [\"5\", \"10\"] }\n\
                    \"machine.*.seed\" = { whole = [1, 1000] }\n";
    fs::write(folder.join("identify.toml"), identify).expect("the folder is writable");
    let message = succeed(&["sweep", "identify.toml"], folder);
    println!("{message}");
    assert!(message.contains("4 runs") && message.contains("held_out_nrmse"), "{message}");
    assert!(message.contains("option.plays: 10 2, 5 2"), "{message}");
    let diagnose = "runs = 1\n[diagnose]\nmachine = \"p1\"\nmodel = \"p1\"\nlogs = \
                    [\"triangles.csv\"]\n[vary]\n\"option.seed\" = { grid = [\"1\", \"2\"] }\n";
    fs::write(folder.join("diagnose.toml"), diagnose).expect("the folder is writable");
    let message = succeed(&["sweep", "diagnose.toml"], folder);
    println!("{message}");
    assert!(message.contains("2 runs") && message.contains("verdict: "), "{message}");
}

#[test]
fn what_is_wrong_with_a_plan_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    prepared(folder);
    for (vary, words) in [
        (
            "\"plant.axis[1].mechanics.freqency\" = { tolerance = 0.1 }",
            ["plan.toml:12:", "did you mean"],
        ),
        (
            "\"plant.axis[1].mechanics.frequency\" = { tolerance = 0 }",
            ["plan.toml:12:", "0 is no tolerance"],
        ),
        (
            "\"plant.axis[1].mechanics.frequency\" = { uniform = [-5, 5] }",
            ["plan.toml:12:", "is not within"],
        ),
        ("x = { even = 3 }", ["plan.toml:12:", "expected one of"]),
    ] {
        plan(folder, 3, vary);
        let message = refuse(&["sweep", "plan.toml"], folder);
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    plan(folder, 3, VARY);
    fs::create_dir(folder.join("open.fmu")).expect("writable");
    let text = fs::read_to_string(folder.join("plan.toml")).expect("the plan");
    for (old, new, words) in [
        ("plant = \"evc\"", "plant = \"evk\"", ["plant = \"evk\"", "rigs are"]),
        ("plant = \"evc\"", "plant = \"open.fmu\"", ["open.fmu: is a folder", "zip"]),
        ("ellipse.csv", "elipse.csv", ["elipse.csv", ""]),
        ("= \"y\"", "= \"x\"", ["x", "y"]),
    ] {
        fs::write(folder.join("bad.toml"), text.replace(old, new)).expect("writable");
        let message = refuse(&["sweep", "bad.toml"], folder);
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    let message = refuse(&["sweep", "none.toml"], folder);
    assert!(message.contains("none.toml") && message.contains("plan of a sweep"), "{message}");
    let message = refuse(&["sweep", "plan.toml", "--shard", "4/3"], folder);
    assert!(message.contains("PART/PARTS"), "{message}");
    // The journal of another plan is not gone on with.
    fs::write(folder.join("t.parquet.journal"), "piezoloop-sweep/1 0\n").expect("writable");
    let message = refuse(&["sweep", "plan.toml", "-o", "t.parquet"], folder);
    assert!(message.contains("another sweep") && message.contains("--out"), "{message}");
}

#[test]
fn a_reference_whose_times_cannot_be_seconds_is_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let controller = root().join("tests/blueprints/controller.toml");
    let controller = controller.to_str().unwrap();
    for (name, blueprint) in [("plant", "evc"), ("controller", controller)] {
        succeed(&["pack", blueprint, "-o", &format!("{name}.fmu")], at);
    }
    let rows = |factor: f64, last: &str| {
        let mut text = "time,reference[1],reference[2]\n".to_owned();
        (0..50).for_each(|k| text.push_str(&format!("{},3,3\n", f64::from(k) * factor)));
        text + last
    };
    fs::write(at.join("us.csv"), rows(20.0, "")).unwrap();
    fs::write(at.join("stray.csv"), rows(2e-5, "1e7,3,3\n")).unwrap();
    let system = "name = \"s\"\n[fmus]\nc = \"controller.fmu\"\n[inputs]\n\"c.reference[1]\" = \"reference[1]\"\n";
    fs::write(at.join("system.toml"), system).unwrap();
    for (file, asked) in [("us.csv", "is time in us?"), ("stray.csv", "is that time a slip?")] {
        let plan = format!(
            "runs = 1\n[loop]\nplant = \"plant.fmu\"\ncontroller = \"controller.fmu\"\nreference = \"{file}\"\n"
        );
        fs::write(at.join("plan.toml"), plan).unwrap();
        let closed = ["simulate", "--loop", "plant.fmu", "controller.fmu", "--reference", file];
        for call in
            [&["sweep", "plan.toml"][..], &closed, &["system", "system.toml", "--input", file]]
        {
            let message = refuse(call, at);
            assert!(
                message.contains(asked) && message.contains("--most-steps"),
                "{call:?}: {message}"
            );
        }
    }
}
