//! Every option of every command with every hostile number: an answer within seconds, never a panic, an
//! abort or a hang. The options come from the tool's own tree of commands, so that new ones are in it.
#![cfg(unix)]

use crate::common;

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use common::{PLAYED as PLANT, refuse, succeed};

const HOSTILE: [&str; 7] = ["0", "-1", "NaN", "inf", "1e300", "18446744073709551615", ""];
/// Most processor time of a call, which does not depend on what else a machine does.
const LONGEST: Duration = Duration::from_secs(20);
/// Longest time of a call that computes nothing.
const STILL: Duration = Duration::from_secs(120);

/// Small arguments with which each command works; `None`: it has no options that take values.
const SMALL: [(&str, Option<&str>); 31] = [
    ("", Some("log in.csv")),
    (
        "identify",
        Some(
            "identify --log in.csv --input u --output y --static --model prandtl-ishlinskii --plays 3",
        ),
    ),
    ("invert", Some("invert plant.toml --feedforward none")),
    ("calibrate", Some("calibrate in.csv --motion u --position y")),
    ("frequency-response", Some("frequency-response in.csv --input u --output y --modes 1")),
    ("tune", Some("tune plant.fmu --period 1e-3 --middle 0 --amplitude 1 --samples 20")),
    ("pack", Some("pack plant.toml --ports mechanical --port-value stiffness=20N/um")),
    ("simulate", Some("simulate plant.fmu --log in.csv --map u=u")),
    ("system", Some("system system.toml --step 1e-3 --stop 0.01")),
    (
        "estimate",
        Some("estimate plant.fmu --log in.csv --tune axis[1].amplifier.bandwidth=50 --starts 1"),
    ),
    ("sweep", Some("sweep plan.toml --threads 1")),
    ("sweep merge", Some("sweep merge part.parquet --out whole.parquet")),
    ("sweep bundle", Some("sweep bundle plan.toml --table table.parquet --out plan.bundle")),
    ("sweep serve", None),
    ("check", Some("check plant.fmu --replay")),
    ("bench", None),
    ("bench run", Some("bench run --plan bench.toml --gateway udp://127.0.0.1:9 --rate 1k")),
    (
        "bench emulate",
        Some("bench emulate plant.fmu --gateway udp://127.0.0.1:19370 --rate 1k --duration 0.01"),
    ),
    // Nobody listens there.
    (
        "bench measure",
        Some("bench measure in.csv --column u --gateway gcs://127.0.0.1:9 -o log.csv"),
    ),
    ("bench tune", Some("bench tune gcs://127.0.0.1:9")),
    ("bench campaign", Some("bench campaign campaign.toml")),
    ("bench recover", Some("bench recover run.csv.journal")),
    ("bench replay", Some("bench replay run.csv.journal")),
    ("list", Some("list rigs")),
    ("log", Some("log in.csv")),
    ("signal", Some("signal ellipse")),
    // Its page, or its folder, cannot be written: it ends before its work, which takes half a minute.
    ("demo", Some("demo --report .")),
    ("diagnose", Some("diagnose --model plant.toml --log in.csv --max-effects 1 --threads 1")),
    ("gap-bench", Some("gap-bench --cases single/creep:1 --short --tool /bin/false")),
    ("gap-bench real", Some("gap-bench real nowhere")),
    ("man", Some("man --out pages")),
];

/// Lengths of runs: whoever asks for a long one waits for it.
const WAITED: [&str; 2] = ["--stop", "--duration"];

/// What goes before a number in an option that takes a pair.
const PAIRS: [(&str, &str); 9] = [
    ("--port-value", "stiffness="),
    ("--map", "u="),
    ("--unit", "y="),
    ("--tune", "axis[1].amplifier.bandwidth="),
    ("--start", "axis[1].amplifier.bandwidth="),
    ("--set", "frequency="),
    ("--noise", "position[1]="),
    ("--inject", "delay,seconds="),
    ("--rows", "1.."),
];

/// One that finds no machine.
const BENCH: &str = r#"
patience = 0.01
[[axis]]
command_limits = [-1, 1]
[[sequence]]
kind = "rest"
seconds = 0.01
"#;
const CAMPAIGN: &str = r#"
plan = "bench.toml"
plant = "plant.fmu"
[[case]]
name = "nothing"
expect = { state = "safe", reason = "finished", within = 100 }
"#;

/// A folder with all that the small arguments name.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let mut log = "time [s],u [V],y [um]\n".to_owned();
    let (mut y, mut noise) = (0.0, 1_u32);
    for k in 0..300 {
        // A generator of pseudo-random numbers is all that is wanted.
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let u = (f64::from(k) * 0.05).sin() + 0.3 * (f64::from(k) * 0.4).sin();
        log.push_str(&format!("{},{u},{}\n", f64::from(k) * 1e-3, y + f64::from(noise) * 1e-13));
        y += 0.27 * (u - y);
    }
    fs::write(at.join("in.csv"), log).unwrap();
    fs::write(at.join("plant.toml"), PLANT).unwrap();
    succeed(&["pack", "plant.toml", "-o", "plant.fmu"], at);
    fs::write(at.join("system.toml"), "name = \"s\"\n[fmus.plant]\nfile = \"plant.fmu\"\n")
        .unwrap();
    let plan = "runs = 1\n[diagnose]\nmachine = \"plant.fmu\"\nmodel = \"plant.fmu\"\nlogs = [\"in.csv\"]\n";
    fs::write(at.join("plan.toml"), plan).unwrap();
    fs::write(at.join("bench.toml"), BENCH).unwrap();
    fs::write(at.join("campaign.toml"), CAMPAIGN).unwrap();
    fs::write(at.join("run.csv.journal"), "").unwrap();
    fs::create_dir(at.join("piezoloop-demo")).unwrap();
    fs::write(at.join("piezoloop-demo/mine.txt"), "").unwrap();
    folder
}

/// As `folder`, for one call.
fn copy(template: &Path) -> tempfile::TempDir {
    let own = tempfile::tempdir().expect("a temporary folder");
    for entry in fs::read_dir(template).expect("a folder") {
        let from = entry.expect("an entry").path();
        let to = own.path().join(from.file_name().expect("a name"));
        if from.is_dir() {
            fs::create_dir(&to).unwrap();
            fs::write(to.join("mine.txt"), "").unwrap();
        } else {
            fs::copy(&from, &to).unwrap();
        }
    }
    own
}

/// Processor time of a process so far, from the 14th and 15th field of its `stat` in hundredths of a second; where there is
/// none, the time since its begin.
fn processor_time(process: u32, begin: Instant) -> Duration {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    // The second field is a name in brackets, which may hold blanks.
    let fields = text.rsplit_once(')').map_or("", |(_, rest)| rest).split_whitespace();
    let ticks: Vec<u64> = fields.skip(11).take(2).flat_map(str::parse).collect();
    match ticks[..] {
        [user, system] => Duration::from_millis(10 * (user + system)),
        _ => begin.elapsed(),
    }
}

/// Runs the tool; how it ended, how much processor time it took, what it said.
fn called(words: &[&str], folder: &Path) -> (Option<i32>, Option<i32>, Duration, String) {
    let begin = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(words)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the tool starts");
    let mut message = child.stderr.take().expect("piped");
    let reader = std::thread::spawn(move || {
        let mut text = Vec::new();
        // What it said until it was ended is enough.
        let _ = std::io::Read::read_to_end(&mut message, &mut text);
        String::from_utf8_lossy(&text).into_owned()
    });
    let mut took = Duration::ZERO;
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        took = took.max(processor_time(child.id(), begin));
        if took > LONGEST || begin.elapsed() > STILL {
            let _ = child.kill();
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    (status.code(), status.signal(), took, reader.join().expect("text"))
}

#[test]
fn no_option_of_any_command_panics_or_hangs() {
    let template = folder();
    let at = template.path();
    let listed = common::json(&["list", "options"], at);
    let rows = listed.as_array().expect("rows");
    let small: BTreeMap<&str, Option<&str>> = SMALL.into_iter().collect();
    let mut calls: Vec<Vec<String>> = Vec::new();
    let mut ranged = 0;
    for row in rows {
        let text = |key: &str| row[key].as_str().unwrap_or_default();
        let (command, option) = (text("command"), text("option"));
        if row["value"].is_null() {
            continue;
        }
        let base =
            small.get(command).unwrap_or_else(|| panic!("{command}: give it small arguments here"));
        let base = base.unwrap_or_else(|| {
            panic!("{command} has the option {option}: give it small arguments here")
        });
        ranged += usize::from(!row["range"].is_null());
        let words = |value: &str| {
            let has = |word: &str| word == option;
            let mut words: Vec<String> = Vec::new();
            let mut all = base.split(' ').peekable();
            while let Some(word) = all.next() {
                // Given once more it would be refused for that alone.
                if has(word) {
                    all.next_if(|next| !next.starts_with('-'));
                } else {
                    words.push(word.to_owned());
                }
            }
            words.push(format!("{option}={value}"));
            words
        };
        let pair = PAIRS.iter().find(|(name, _)| *name == option).map(|(_, first)| first);
        // The ends of its range are taken, and are no faster.
        let is_new = |word: &&str| word.parse::<f64>().is_ok() && !HOSTILE.contains(word);
        let ends = text("range").split([' ', ',']).filter(is_new);
        let ends = ends.filter(|_| !WAITED.contains(&option));
        for value in HOSTILE.into_iter().chain(ends) {
            calls.push(words(value));
            calls.extend(pair.map(|first| words(&format!("{first}{value}"))));
        }
    }
    assert!(ranged > 40, "{ranged} options with a range");
    let (next, faults) = (Mutex::new(calls.iter()), Mutex::new(Vec::new()));
    let slowest = Mutex::new((Duration::ZERO, String::new()));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            let (next, faults, slowest) = (&next, &faults, &slowest);
            scope.spawn(move || {
                loop {
                    let Some(words) = next.lock().expect("no panic").next() else { break };
                    let words: Vec<&str> = words.iter().map(String::as_str).collect();
                    let own = copy(at);
                    let (code, signal, took, message) = called(&words, own.path());
                    let is_bad = !matches!(code, Some(0..=2)) || message.contains("panicked");
                    if is_bad || took > LONGEST {
                        let fault = format!(
                            "{words:?}: exit {code:?}, signal {signal:?}, {took:?}: {message}"
                        );
                        faults.lock().expect("no panic").push(fault);
                    }
                    let mut slowest = slowest.lock().expect("no panic");
                    if took > slowest.0 {
                        *slowest = (took, words.join(" "));
                    }
                }
            });
        }
    });
    let faults = faults.into_inner().expect("no panic");
    println!("{} calls; the slowest: {:?}", calls.len(), slowest.into_inner());
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn ranges_stand_in_the_help_and_in_the_refusal() {
    let folder = folder();
    let help = succeed(&["tune", "--help"], folder.path());
    assert!(help.contains("(1 to 200000)") && help.contains("(above 1, up to 100)"), "{help}");
    let message = refuse(&["simulate", "plant.fmu", "--log", "in.csv", "--rate=-1"], folder.path());
    assert!(message.contains("must be above 0, up to 1e12"), "{message}");
}
