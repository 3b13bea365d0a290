//! No output takes the place of an input, of another output, or of a file beside it that the tool did not
//! write; links, devices and permissions stay; numbers that no command can work with are refused.
#![cfg(unix)]

use crate::common;

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

use common::{kill, refuse, succeed, wait_for};

const LOG: &str = "time [s],u [V],y [um]\n0,0,0\n0.001,1,1\n0.002,2,2\n0.003,1,1.1\n0.004,0,0.1\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("in.csv"), LOG).expect("the folder is writable");
    folder
}

fn is_unchanged(folder: &Path) {
    assert_eq!(fs::read_to_string(folder.join("in.csv")).unwrap(), LOG);
}

#[test]
fn an_input_is_never_written() {
    let folder = folder();
    let at = folder.path();
    symlink("in.csv", at.join("link.csv")).unwrap();
    for output in ["in.csv", "./in.csv", "link.csv"] {
        let message = refuse(&["log", "in.csv", "-o", output], at);
        assert!(message.contains("give"), "{message}");
        is_unchanged(at);
    }
    let identify =
        ["identify", "--log", "in.csv", "--input", "u", "--output", "y", "-o", "plant.toml"];
    for option in ["--picture", "--report"] {
        let message = refuse(&[&identify[..], &[option, "in.csv"]].concat(), at);
        assert!(message.contains("already uses the file"), "{message}");
        is_unchanged(at);
    }
    let twice = [&identify[..7], &["-o", "same.html", "--report", "same.html"]].concat();
    let message = refuse(&twice, at);
    assert!(message.contains("already uses the file"), "{message}");
    assert!(!at.join("same.html").exists());
}

#[test]
fn what_a_plan_names_is_not_written() {
    let folder = folder();
    let at = folder.path();
    succeed(&["pack", "p1-truth", "-o", "plant.fmu"], at);
    let before = fs::read(at.join("plant.fmu")).unwrap();
    let plan = "runs = 1\n[diagnose]\nmachine = \"plant.fmu\"\nmodel = \"plant.fmu\"\nlogs = [\"in.csv\"]\n";
    fs::write(at.join("plan.toml"), plan).unwrap();
    refuse(&["sweep", "bundle", "plan.toml", "--table", "t.parquet", "-o", "plant.fmu"], at);
    assert_eq!(fs::read(at.join("plant.fmu")).unwrap(), before);
}

#[test]
fn a_companion_of_another_hand_stays() {
    let folder = folder();
    let at = folder.path();
    let own = "# measured on Monday\n[columns]\ny = { unit = \"nm\" }\n";
    fs::write(at.join("out.dataset.toml"), own).unwrap();
    let message = refuse(&["log", "in.csv", "-o", "out.csv"], at);
    assert!(message.contains("out.dataset.toml") && message.contains("another name"), "{message}");
    assert_eq!(fs::read_to_string(at.join("out.dataset.toml")).unwrap(), own);
    assert!(!at.join("out.csv").exists());
    // Its own it replaces.
    for _ in 0..2 {
        let output = common::piezoloop(&["log", "in.csv", "-o", "new.csv"], at);
        assert!(output.status.code().is_some_and(|code| code < 2), "{output:?}");
    }
}

#[test]
fn links_devices_and_permissions_stay() {
    let folder = folder();
    let at = folder.path();
    symlink("/dev/null", at.join("null")).unwrap();
    symlink("real.fmu", at.join("link.fmu")).unwrap();
    fs::write(at.join("real.fmu"), "old").unwrap();
    fs::set_permissions(at.join("real.fmu"), fs::Permissions::from_mode(0o600)).unwrap();
    for output in ["null", "link.fmu"] {
        succeed(&["pack", "p1-truth", "-o", output], at);
        assert!(fs::symlink_metadata(at.join(output)).unwrap().is_symlink(), "{output}");
    }
    let packed = fs::metadata(at.join("real.fmu")).unwrap();
    assert_eq!(packed.permissions().mode() & 0o777, 0o600);
    assert!(packed.len() > 1000);
    // A pipe is written through.
    assert!(Command::new("mkfifo").arg(at.join("pipe")).status().unwrap().success());
    let pipe = at.join("pipe");
    let reader = std::thread::spawn(move || fs::read(pipe).unwrap());
    succeed(&["pack", "p1-truth", "-o", "pipe"], at);
    assert!(reader.join().unwrap().starts_with(b"PK"));
    assert!(!fs::metadata(at.join("pipe")).unwrap().is_file());
}

#[test]
fn counts_out_of_range_are_refused_before_the_work() {
    let folder = folder();
    let response = ["frequency-response", "in.csv", "--input", "u", "--output", "y"];
    let tune = ["tune", "p1-truth", "--period", "2e-3", "--middle", "5", "--amplitude", "0.5"];
    let diagnose = ["diagnose", "--model", "p1-truth", "--log", "in.csv"];
    let identify = ["identify", "--log", "in.csv", "--input", "u", "--output", "y"];
    let sweep = ["sweep", "plan.toml"];
    let cases: [(&[&str], &str, &[&str]); 8] = [
        (&response, "--period", &["0", "1"]),
        (&response, "--lines", &["0"]),
        (&response, "--modes", &["101"]),
        (&response, "--lags", &["101"]),
        (&tune, "--samples", &["0", "10000000000"]),
        (&diagnose, "--threads", &["100000"]),
        (&identify, "--threads", &["100000"]),
        (&sweep, "--threads", &["100000"]),
    ];
    for (command, option, values) in cases {
        for value in values.iter().chain(&["-1", "NaN", "inf", "1e300", "18446744073709551615", ""])
        {
            let option = format!("{option}={value}");
            let message = refuse(&[command, &[&option]].concat(), folder.path());
            assert!(
                message.contains("invalid value") && message.contains("--help"),
                "{option}: {message}"
            );
        }
    }
}

#[test]
fn a_second_call_writes_the_same_and_streams_are_guarded() {
    let folder = folder();
    let at = folder.path();
    // The units beside it describe the array too; they are the same the second time.
    fs::write(
        at.join("in.dataset.toml"),
        "[columns]\nu = { unit = \"V\" }\ny = { unit = \"um\" }\n",
    )
    .unwrap();
    for _ in 0..2 {
        common::piezoloop(&["log", "in.csv", "-o", "copy.csv"], at);
        let message = common::piezoloop(&["log", "copy.csv", "-o", "copy.csv"], at);
        assert_eq!(message.status.code(), Some(2));
    }
    succeed(&["pack", "p1-truth", "-o", "plant.fmu"], at);
    for log in ["in.csv", "plant.fmu"] {
        let call = ["simulate", "plant.fmu", "--log", "in.csv", "--map", "u=u", "--fmu-log", log];
        let message = refuse(&call, at);
        assert!(message.contains("already uses the file"), "{message}");
        is_unchanged(at);
    }
    // What another hand has put into a folder stays.
    fs::create_dir(at.join("mine")).unwrap();
    fs::write(at.join("mine/index.html"), "mine").unwrap();
    for call in
        [&["gap-bench", "--short", "--cases", "0", "-o", "mine"][..], &["demo", "-o", "mine"]]
    {
        if call[0] == "demo" {
            // A page is what an earlier demo leaves.
            fs::rename(at.join("mine/index.html"), at.join("mine/notes.txt")).unwrap();
        }
        let message = refuse(call, at);
        assert!(message.contains("earlier call"), "{message}");
        assert_eq!(fs::read_dir(at.join("mine")).unwrap().count(), 1);
    }
}

#[test]
fn the_column_of_time_is_named_by_map() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("t.csv"), LOG.replacen("time [s]", "abscissa", 1)).unwrap();
    let message = refuse(&["log", "t.csv"], at);
    assert!(message.contains("time"), "{message}");
    let reported = common::piezoloop(&["log", "t.csv", "--map", "time=abscissa"], at);
    assert!(String::from_utf8_lossy(&reported.stdout).contains("1000 Hz"), "{reported:?}");
    // A name that is nearly one of a file beside it, and an option before its command.
    let message = refuse(&["log", "tt.csv"], at);
    assert!(message.contains("did you mean t.csv?"), "{message}");
    let message = refuse(&["--rate", "5", "log", "t.csv"], at);
    assert!(message.contains("after the command: piezoloop log"), "{message}");
}

#[test]
fn escapes_of_terminals_are_shown() {
    let folder = folder();
    let at = folder.path();
    let evil = LOG.replacen("u [V]", "u\u{1b}]0;evil\u{7}\u{9b}31m [V]", 1);
    fs::write(at.join("evil.csv"), evil).unwrap();
    for more in [&[][..], &["--json"], &["--map", "x"]] {
        let reported = common::piezoloop(&[&["log", "evil.csv"][..], more].concat(), at);
        let all = [reported.stdout, reported.stderr].concat();
        let text = String::from_utf8_lossy(&all);
        assert!(!text.contains(|c: char| c.is_control() && c != '\n' && c != '\t'), "{text}");
    }
    let reported = common::piezoloop(&["log", "evil.csv"], at);
    assert!(String::from_utf8_lossy(&reported.stdout).contains("u\\u001b]0;evil"), "{reported:?}");
}

/// A signal ends a call with the files that it found, and without a trace of its own.
#[test]
fn temporary_files_go_with_a_signal() {
    use std::os::unix::process::ExitStatusExt as _;
    let folder = folder();
    let at = folder.path();
    let temporary = at.join("tmp");
    fs::create_dir(&temporary).unwrap();
    succeed(&["pack", "p1-truth", "-o", "plant.fmu"], at);
    let mut log = "time,u\n".to_owned();
    // Of many steps from row to row: a run of seconds, which a busy machine does not end before the signal comes.
    (0..600_000).for_each(|k| log.push_str(&format!("{},1\n", f64::from(k) * 2e-2)));
    fs::write(at.join("long.csv"), log).unwrap();
    for (signal, number) in [("TERM", 15), ("HUP", 1), ("INT", 2)] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
            .args(["simulate", "plant.fmu", "--log", "long.csv", "--map", "u=u", "-o", "run.csv"])
            .current_dir(at)
            .env("TMPDIR", &temporary)
            .spawn()
            .unwrap();
        let is_begun = || {
            let names = fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name());
            names.into_iter().any(|name| name.to_string_lossy().starts_with(".run.csv"))
        };
        let is_unpacked = || fs::read_dir(&temporary).unwrap().count() > 0;
        wait_for(|| {
            assert!(child.try_wait().unwrap().is_none(), "it ended before the signal");
            if is_begun() && is_unpacked() { Ok(()) } else { Err("nothing is written".to_owned()) }
        });
        let id = child.id().to_string();
        assert!(kill(&["-s", signal, &id]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().signal(), Some(number));
        assert_eq!(fs::read_dir(&temporary).unwrap().count(), 0, "{signal}");
        assert!(!is_begun() && !at.join("run.csv").exists(), "{signal}");
    }
}

/// A design that takes seconds, most of them simulation, ends when it is asked to.
#[test]
fn a_signal_ends_invert_at_once() {
    use std::os::unix::process::ExitStatusExt as _;
    use std::time::{Duration, Instant};
    let folder = folder();
    let at = folder.path();
    let before = fs::read_dir(at).unwrap().count();
    for (signal, number) in [("TERM", 15), ("HUP", 1), ("INT", 2)] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
            .args(["invert", "p1-truth", "--period", "5e-7", "-o", "controller.toml"])
            .current_dir(at)
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        // On a fast machine all of it takes 1.1 s.
        std::thread::sleep(Duration::from_millis(300));
        assert!(child.try_wait().unwrap().is_none(), "it was to take seconds");
        let begin = Instant::now();
        let id = child.id().to_string();
        assert!(kill(&["-s", signal, &id]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().signal(), Some(number));
        assert!(begin.elapsed() < Duration::from_secs(1), "{signal}");
        assert_eq!(fs::read_dir(at).unwrap().count(), before, "{signal} leaves nothing");
    }
}

/// An FMU that takes a while to unpack: with many files in folders of their own.
fn with_many_files(from: &Path, to: &Path) {
    let mut complete = zip::ZipArchive::new(fs::File::open(from).unwrap()).unwrap();
    let mut packed = zip::ZipWriter::new(fs::File::create(to).unwrap());
    for index in 0..complete.len() {
        packed.raw_copy_file(complete.by_index_raw(index).unwrap()).unwrap();
    }
    let options = zip::write::SimpleFileOptions::default();
    for number in 0..3000 {
        packed.start_file(format!("extra/org.example/{number}/a.txt"), options).unwrap();
    }
    packed.finish().unwrap();
}

/// A signal while an FMU is unpacked and tried: the one who unpacks does not make anew what is removed.
#[test]
fn temporary_files_go_with_a_signal_during_preparation() {
    use std::os::unix::process::ExitStatusExt as _;
    use std::time::{Duration, Instant};
    let folder = folder();
    let at = folder.path();
    measured(at);
    succeed(&["pack", "p1-truth", "-o", "plant.fmu"], at);
    with_many_files(&at.join("plant.fmu"), &at.join("many.fmu"));
    let diagnose = ["diagnose", "--model", "many.fmu", "--log", "measured.csv", "--map"];
    let diagnose = [&diagnose[..], &["command[1]=u", "--map", "position[1]=y"]].concat();
    let isolated = [&diagnose[..], &["--isolate"]].concat();
    let check = ["check", "many.fmu", "--replay"];
    let mut ended = 0;
    for call in [&diagnose[..], &isolated, &check] {
        for (moment, (signal, number)) in
            [("TERM", 15), ("HUP", 1), ("TERM", 15), ("INT", 2)].into_iter().enumerate()
        {
            let temporary = tempfile::tempdir().unwrap();
            let mut child = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
                .args(call)
                .current_dir(at)
                .env("TMPDIR", temporary.path())
                .stdout(std::process::Stdio::null())
                .spawn()
                .unwrap();
            // Inside of the folder of this call lies that of the FMU.
            let inside = || {
                let own = fs::read_dir(temporary.path()).unwrap().flatten().next();
                own.is_some_and(|own| {
                    fs::read_dir(own.path()).is_ok_and(|mut e| e.next().is_some())
                })
            };
            // Whose end has been seen gets no signal: its number may be another's by now.
            let is_running = wait_for(|| match child.try_wait().unwrap() {
                Some(_) => Ok(false),
                None if inside() => Ok(true),
                None => Err("the FMU is not unpacked".to_owned()),
            });
            std::thread::sleep(Duration::from_millis(10 * moment as u64));
            let id = child.id().to_string();
            let is_sent =
                is_running && kill(&["-s", signal, &id]).output().unwrap().status.success();
            let begin = Instant::now();
            let status = child.wait().unwrap();
            assert!(begin.elapsed() < Duration::from_secs(10), "{call:?} {signal}");
            // A busy machine may be late.
            if is_sent && status.signal().is_some() {
                assert_eq!(status.signal(), Some(number), "{call:?}");
                ended += 1;
            }
            let left = fs::read_dir(temporary.path()).unwrap().count();
            assert_eq!(left, 0, "{call:?} {signal} after {moment}: {status}");
        }
    }
    assert!(ended > 6, "only {ended} were ended by a signal");
}

/// A log on which a model can be fitted.
fn measured(at: &Path) {
    let mut log = "time [s],u [V],y [um]\n".to_owned();
    for k in 0..400 {
        let u = (f64::from(k) * 0.05).sin() * 10.0;
        log.push_str(&format!("{},{u},{}\n", f64::from(k) * 1e-3, 0.2 * u));
    }
    fs::write(at.join("measured.csv"), log).unwrap();
}

#[test]
fn all_models_go_into_a_folder_of_their_own() {
    let folder = folder();
    let at = folder.path();
    measured(at);
    let fit = ["identify", "--log", "measured.csv", "--input", "u", "--output", "y"];
    let fit = [&fit[..], &["--static", "--model", "linear", "-o", "p.toml"]].concat();
    fs::create_dir(at.join("mine")).unwrap();
    fs::write(at.join("mine/y-linear.toml"), "mine").unwrap();
    let message = refuse(&[&fit[..], &["--all", "mine"]].concat(), at);
    assert!(message.contains("earlier call"), "{message}");
    assert!(!at.join("p.toml").exists(), "told before the work");
    assert_eq!(fs::read_to_string(at.join("mine/y-linear.toml")).unwrap(), "mine");
    // Its own it replaces; what somebody has put there since, not.
    for _ in 0..2 {
        succeed(&[&fit[..], &["--all", "own"]].concat(), at);
        let list = fs::read_to_string(at.join("own/candidates.json")).unwrap();
        assert!(list.contains("y-linear.toml") && list.contains("held_out_nrmse"), "{list}");
    }
    let list = fs::read_to_string(at.join("own/candidates.json")).unwrap();
    let of_another = list.replace("y-linear.toml", "z-linear.toml");
    fs::write(at.join("own/candidates.json"), of_another).unwrap();
    let message = refuse(&[&fit[..], &["--all", "own"]].concat(), at);
    assert!(message.contains("not written by this program"), "{message}");
    // Nor is one of them another output.
    let twice =
        [&fit[..8], &["--model", "linear", "-o", "new/y-linear.toml", "--all", "new"]].concat();
    fs::create_dir(at.join("new")).unwrap();
    let message = refuse(&twice, at);
    assert!(message.contains("file of this call itself"), "{message}");
}

#[test]
fn what_is_read_without_being_named_is_an_input_too() {
    let folder = folder();
    let at = folder.path();
    succeed(&["pack", "p1-truth", "-o", "plant.fmu"], at);
    let described = "[columns]\ny = { unit = \"um\" }\n";
    fs::write(at.join("in.dataset.toml"), described).unwrap();
    let estimate = ["estimate", "plant.fmu", "--log", "in.csv", "--map", "u=u", "--starts", "1"];
    let estimate = [&estimate[..], &["--tune", "axis[1].amplifier.bandwidth=50"]].concat();
    let simulate = ["simulate", "plant.fmu", "--log", "in.csv", "--map", "u=u"];
    for call in [&estimate[..], &simulate] {
        for option in ["--fmu-log", "--report"] {
            refuse(&[call, &[option, "in.dataset.toml"]].concat(), at);
            assert_eq!(fs::read_to_string(at.join("in.dataset.toml")).unwrap(), described);
        }
    }
    // A folder as SSP or FMU, and a library that is packed.
    let ssd = "<ssd:SystemStructureDescription xmlns:ssd=\"http://ssp-standard.org/SSP1/SystemStructureDescription\" version=\"1.0\" name=\"s\">\
        <ssd:System name=\"s\"><ssd:Elements><ssd:Component name=\"p\" source=\"../plant.fmu\"/></ssd:Elements></ssd:System>\
        </ssd:SystemStructureDescription>";
    fs::create_dir(at.join("ssp")).unwrap();
    fs::write(at.join("ssp/SystemStructure.ssd"), ssd).unwrap();
    let system = ["system", "ssp", "--step", "1e-3", "--stop", "2e-3"];
    for option in ["--report", "--fmu-log"] {
        refuse(&[&system[..], &[option, "ssp/SystemStructure.ssd"]].concat(), at);
        assert_eq!(fs::read_to_string(at.join("ssp/SystemStructure.ssd")).unwrap(), ssd);
    }
    succeed(&system, at);
    let mut fmu = zip::ZipArchive::new(fs::File::open(at.join("plant.fmu")).unwrap()).unwrap();
    fmu.extract(at.join("unpacked")).unwrap();
    let description = fs::read(at.join("unpacked/modelDescription.xml")).unwrap();
    for option in ["--report", "--fmu-log"] {
        let file = "unpacked/modelDescription.xml";
        refuse(&["simulate", "unpacked", "--log", "in.csv", "--map", "u=u", option, file], at);
        assert_eq!(fs::read(at.join(file)).unwrap(), description);
    }
    fs::write(at.join("lib.so"), "mine").unwrap();
    refuse(&["pack", "p1-truth", "--binary", "win64=lib.so", "-o", "lib.so"], at);
    assert_eq!(fs::read_to_string(at.join("lib.so")).unwrap(), "mine");
}

#[test]
fn what_describes_a_log_is_bounded() {
    let folder = folder();
    let at = folder.path();
    let long = fs::File::create(at.join("in.dataset.toml")).unwrap();
    long.set_len(20 << 30).unwrap();
    let message = refuse(&["log", "in.csv"], at);
    assert!(message.contains("16777216 bytes") && message.contains("--log-memory"), "{message}");
    for (call, file) in [
        (&["pack", "long.toml"][..], "long.toml"),
        (&["system", "long.toml"], "long.toml"),
        (&["sweep", "long.toml"], "long.toml"),
    ] {
        fs::File::create(at.join(file)).unwrap().set_len(20 << 30).unwrap();
        let message = refuse(call, at);
        assert!(message.contains("longer than 16777216 bytes"), "{call:?}: {message}");
    }
}
