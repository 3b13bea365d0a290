//! Where the system gives few threads and processes (`ulimit -u`, containers): each command works with those
//! that there are, or says that it needs more; nothing panics, and no FMU is blamed.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use common::jobs::allow;
use common::{PLAYED as PLANT, succeed};

/// Calls of all commands that start threads or processes; `OUT` stands for a folder of each call's own.
const CALLS: [&str; 25] = [
    "log in.csv -o OUT/copy.csv",
    "check plant.fmu",
    "check plant.fmu --replay",
    "invert plant.toml -o OUT/controller.toml",
    "pack plant.toml -o OUT/plant.fmu",
    "simulate plant.fmu --log in.csv --map u=u -o OUT/run.csv",
    "simulate plant.fmu --log in.csv --map u=u -o OUT/run.csv --isolate",
    "system system.toml --step 1e-3 --stop 0.01 -o OUT/run.csv",
    "system system.toml --step 1e-3 --stop 0.01 -o OUT/run.csv --isolate",
    "estimate plant.fmu --log in.csv --tune axis[1].amplifier.bandwidth=50 --starts 2",
    "estimate plant.fmu --log in.csv --tune axis[1].amplifier.bandwidth=50 --starts 1 --isolate",
    "identify --log in.csv --input u --output y --static --model prandtl-ishlinskii --plays 3 -o OUT/p.toml",
    "identify --log in.csv --input u --output y --swarm --model prandtl-ishlinskii --plays 3 --threads 4 -o OUT/p.toml",
    "tune plant.fmu --period 1e-3 --middle 0 --amplitude 1 --samples 20",
    "frequency-response in.csv --input u --output y --modes 1 -o OUT/response.csv",
    "sweep plan.toml --threads 4 -o OUT/table.parquet",
    "sweep plan.toml --threads 4 --isolate -o OUT/table.parquet",
    "sweep campaign.toml --threads 2 -o OUT/table.parquet",
    "diagnose --model plant.toml --log in.csv --max-effects 1 --threads 4 --json OUT/gap.json",
    "diagnose --model plant.fmu --log in.csv --map command[1]=u --map position[1]=y --max-effects 1 --threads 4 --isolate --json OUT/gap.json",
    "gap-bench --cases single/creep:1 --short -o OUT/bench",
    "bench emulate plant.fmu --gateway udp://127.0.0.1:PORT --rate 1k --duration 0.02",
    "bench run --plan bench.toml --gateway udp://127.0.0.1:PORT --rate 1k --record OUT/run.csv",
    "bench run --plan bench.toml --gateway udp://127.0.0.1:PORT --rate 1k --web 0",
    "bench run --plan bench.toml --gateway gcs://127.0.0.1:PORT --rate 1k --record OUT/run.csv",
];

const BENCH: &str = "patience = 0.01\n[[axis]]\ncommand_limits = [-1, 1]\n\
    [[sequence]]\nkind = \"rest\"\nseconds = 0.01\n";
const PLAN: &str = "runs = 3\nseed = 1\n[system]\nfile = \"system.toml\"\nstep = 1e-3\nstop = 0.01\n\
    [vary]\n\"plant.axis[1].amplifier.bandwidth\" = { tolerance = 0.1 }\n\
    [measure]\nlargest = { column = \"plant.position[1]\", take = \"peak\" }\n";
const CAMPAIGN: &str =
    "runs = 1\n[diagnose]\nmachine = \"plant.fmu\"\nmodel = \"plant.fmu\"\nlogs = [\"in.csv\"]\n";

fn inputs(at: &Path) {
    let mut log = "time [s],u [V],y [um]\n".to_owned();
    let mut y = 0.0;
    for k in 0..300 {
        let u = (f64::from(k) * 0.05).sin() + 0.3 * (f64::from(k) * 0.4).sin();
        log += &format!("{},{u},{y}\n", f64::from(k) * 1e-3);
        y += 0.27 * (u - y);
    }
    for (name, text) in [
        ("in.csv", log.as_str()),
        ("plant.toml", PLANT),
        ("system.toml", "name = \"s\"\n[fmus.plant]\nfile = \"plant.fmu\"\n"),
        ("bench.toml", BENCH),
        ("plan.toml", PLAN),
        ("campaign.toml", CAMPAIGN),
    ] {
        fs::write(at.join(name), text).expect("writable");
    }
    succeed(&["pack", "plant.toml", "-o", "plant.fmu"], at);
}

/// Runs the tool as a user who may have so many threads and processes.
fn limited(most: u32, words: &[String], folder: &Path, temporary: &Path) -> Output {
    let user = 61_000 + std::process::id() % 1000;
    let (user, group) = (format!("--reuid={user}"), format!("--regid={user}"));
    Command::new("setpriv")
        .args([user.as_str(), &group, "--clear-groups", "prlimit", &format!("--nproc={most}")])
        .arg(env!("CARGO_BIN_EXE_piezoloop"))
        .args(words)
        .current_dir(folder)
        .env("TMPDIR", temporary)
        .output()
        .expect("setpriv starts")
}

#[test]
fn few_threads_and_processes_are_enough_or_stated() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    allow(at, 0o755);
    let can = limited(9, &["--version".to_owned()], at, at);
    if !can.status.success() {
        println!("SKIPPED: nobody else can run the tool here; it takes root, setpriv and prlimit");
        return;
    }
    inputs(at);
    let port = common::bench::port().to_string();
    let (mut described, mut worked) = (0, 0);
    for most in [1, 2, 3, 4, 16] {
        for call in CALLS {
            let out = tempfile::tempdir().expect("a folder");
            let temporary = tempfile::tempdir().expect("a folder");
            [out.path(), temporary.path()].iter().for_each(|folder| allow(folder, 0o777));
            let own = out.path().to_str().expect("UTF-8");
            let words: Vec<String> =
                call.split(' ').map(|w| w.replace("OUT", own).replace("PORT", &port)).collect();
            let output = limited(most, &words, at, temporary.path());
            let message = [output.stdout, output.stderr].concat();
            let message = String::from_utf8_lossy(&message);
            let when = format!("{call} with {most}: {:?}: {message}", output.status);
            assert!(!message.contains("panicked"), "{when}");
            assert_eq!(fs::read_dir(temporary.path()).unwrap().count(), 0, "{when}");
            let is_limit = message.contains("ulimit -u");
            // No machine answers the bench.
            let is_alone = call.starts_with("bench run");
            match output.status.code() {
                Some(0) => worked += 1,
                Some(1 | 2) if is_limit => described += 1,
                Some(1 | 2) if is_alone => assert!(most > 1, "{when}"),
                _ => panic!("{when}"),
            }
            assert!(!is_limit || most < 16, "{when}");
            // The FMU is as good as it was, and a run that did not begin leaves nothing to recover.
            assert!(!message.contains("1 error"), "{when}");
            let left: Vec<_> = fs::read_dir(out.path())
                .expect("a folder")
                .map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8"))
                .filter(|name| name == "run.csv.journal" || name.starts_with('.'))
                .collect();
            assert!(left.is_empty(), "{when}: {left:?}");
        }
    }
    println!("{worked} calls worked, {described} said that they need more");
    assert!(worked > 40 && described > 10, "{worked} {described}");
}
