//! `piezoloop bench`: runner and machine as two processes.
#![cfg(unix)]

use crate::common;

use std::io::BufRead;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use common::bench::{Process, change_plan, log, machine, port, stage};
use common::{refuse, succeed, wait_for};
use serde_json::Value;

/// A runner that goes on while the test looks at it.
fn runner(port: u16, more: &[&str], folder: &Path) -> Process {
    let gateway = format!("udp://127.0.0.1:{port}");
    let mut all = vec!["bench", "run", "--plan", "plan.toml", "--gateway", &gateway];
    all.extend(more);
    Process::tool(&all, folder)
}

fn run(port: u16, more: &[&str], folder: &Path) -> (Value, Option<i32>) {
    let gateway = format!("udp://127.0.0.1:{port}");
    let mut all = vec!["--json", "bench", "run", "--plan", "plan.toml", "--gateway", &gateway];
    all.extend(more);
    let output = common::piezoloop(&all, folder);
    let messages = String::from_utf8_lossy(&output.stderr).into_owned();
    let answer = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{messages}"));
    (answer, output.status.code())
}

#[test]
fn what_the_emulator_injects_the_runner_counts() {
    let (folder, port) = (stage(1.5), port());
    let faults = "seed = 4\n[[fault]]\nkind = \"loss\"\nprobability = 0.1\n\
                  [[fault]]\nkind = \"corrupt\"\nprobability = 0.1\n\
                  [[fault]]\nkind = \"duplicate\"\nprobability = 0.1\n";
    std::fs::write(folder.path().join("faults.toml"), faults).unwrap();
    let machine = machine(port, &["--faults", "faults.toml"], folder.path());
    assert!(machine.first.contains("udp://127.0.0.1"), "{}", machine.first);
    let (answer, code) = run(port, &["--record", "run.parquet"], folder.path());
    assert_eq!((code, answer["state"].as_str()), (Some(0), Some("safe")), "{answer}");
    machine.signal("-TERM");
    let (messages, _) = machine.end();
    println!("{answer:#}\n{messages}");
    for counter in ["lost", "corrupt", "duplicate"] {
        assert!(answer["measurements"][counter].as_u64().unwrap() > 3, "{counter}");
    }
    assert_eq!(answer["measurements"]["mismatched"], 0);
    assert_eq!(answer["unrecorded"], 0);
    assert!(answer["record"]["rows"].as_u64().unwrap() > 250);
    assert!(!folder.path().join("run.parquet.journal").exists());
}

#[test]
fn a_record_has_units_and_provenance_in_every_format() {
    let (folder, port) = (stage(0.3), port());
    let machine = machine(port, &["--timing", "commands"], folder.path());
    for file in ["run.csv", "run.parquet", "run.mf4"] {
        let (answer, _) = run(port, &["--record", file], folder.path());
        assert_eq!(answer["reason"], "the plan has ended", "{answer}");
        assert!(folder.path().join(file).is_file(), "{file}");
    }
    drop(machine);
    let about = std::fs::read_to_string(folder.path().join("run.about.json")).unwrap();
    let about: Value = serde_json::from_str(&about).unwrap();
    assert_eq!(about["plan_sha256"].as_str().map(str::len), Some(64));
    assert!(about["outcome"]["work"]["p9999_us"].is_number() && about["realtime"].is_object());
    for log in ["run.csv", "run.parquet"].map(|file| log(folder.path(), file)) {
        let position = log.column("position[1]").unwrap();
        assert_eq!(position.unit.as_ref().map(|unit| unit.text.as_str()), Some("um"));
        let greatest =
            log.column("command[1]").unwrap().values.iter().fold(0.0_f64, |m, v| m.max(*v));
        assert_eq!(greatest, 6.0);
        assert_eq!(log.column("command[1]").unwrap().values.last(), Some(&0.0), "it ends at rest");
    }
    let script = "import sys\nfrom asammdf import MDF\nwith MDF(sys.argv[1]) as mdf:\n\
                  \x20   y, u = mdf.get('position[1]'), mdf.get('command[1]')\n\
                  \x20   assert y.unit == 'um' and u.unit == 'V', (y.unit, u.unit)\n\
                  \x20   assert max(u.samples) == 6.0 and len(u.timestamps) > 60\n\
                  \x20   assert 'plan_sha256' in str(mdf.header.comment), mdf.header.comment\n\
                  \x20   print('asammdf', len(u.samples))\n";
    let Some(python) = common::foreign::python() else { return };
    std::fs::write(folder.path().join("script.py"), script).unwrap();
    let messages = common::foreign::message(
        Command::new(python).args(["script.py", "run.mf4"]),
        folder.path(),
    );
    assert!(messages.contains("asammdf"), "{messages}");
}

#[test]
fn a_run_that_cannot_begin_leaves_nothing_to_recover() {
    let (folder, port) = (stage(0.3), port());
    // Nobody listens there.
    let gateway = format!("gcs://127.0.0.1:{port}");
    for _ in 0..2 {
        let run = ["bench", "run", "--plan", "plan.toml", "--gateway", &gateway];
        let messages = refuse(&[&run[..], &["--record", "run.csv"]].concat(), folder.path());
        assert!(messages.contains("the device"), "{messages}");
        let names = std::fs::read_dir(folder.path()).unwrap().flatten();
        let names: Vec<_> = names.map(|entry| entry.file_name()).collect();
        assert_eq!(names, ["plan.toml"]);
    }
}

#[test]
fn a_killed_runner_leaves_its_rows_and_the_machine_stops_itself() {
    let (folder, port) = (stage(60.0), port());
    let machine = machine(port, &["--heartbeat", "20"], folder.path());
    let runner = runner(port, &["--record", "run.csv"], folder.path());
    let journal = folder.path().join("run.csv.journal");
    let size = || std::fs::metadata(&journal).map_or(0, |found| found.len());
    wait_for(|| match size() {
        60_000.. => Ok(()),
        size => Err(format!("no rows: {size} bytes")),
    });
    runner.signal("-KILL");
    let (_, code) = runner.end();
    assert_eq!(code, None);
    let gateway = format!("udp://127.0.0.1:{port}");
    let again =
        ["bench", "run", "--plan", "plan.toml", "--gateway", &gateway, "--record", "run.csv"];
    let message = refuse(&again, folder.path());
    assert!(message.contains("bench recover"), "{message}");
    let messages = succeed(&["bench", "recover", "run.csv.journal"], folder.path());
    println!("{messages}");
    // 18 columns of 8 bytes.
    assert!(log(folder.path(), "run.csv").len() as u64 >= 60_000 / (8 * 18) - 40);
    // What is there stays unless it is named; a file of another hand beside it in any case.
    let messages = refuse(&["bench", "recover", "run.csv.journal"], folder.path());
    assert!(messages.contains("run.csv: is there") && messages.contains("-o FILE"), "{messages}");
    succeed(&["bench", "recover", "run.csv.journal", "-o", "run.csv"], folder.path());
    std::fs::write(folder.path().join("mine.about.json"), "{}").unwrap();
    let messages =
        refuse(&["bench", "recover", "run.csv.journal", "-o", "mine.csv"], folder.path());
    assert!(
        messages.contains("mine.about.json") && !folder.path().join("mine.csv").exists(),
        "{messages}"
    );
    std::thread::sleep(Duration::from_millis(400));
    machine.signal("-TERM");
    let (messages, _) = machine.end();
    assert!(messages.contains("the machine stopped itself"), "{messages}");
}

#[test]
fn sigterm_ends_in_the_safe_state_with_the_record_complete() {
    let (folder, port) = (stage(60.0), port());
    let _machine = machine(port, &[], folder.path());
    let runner = runner(port, &["--record", "run.csv"], folder.path());
    std::thread::sleep(Duration::from_millis(1500));
    runner.signal("-TERM");
    let (messages, code) = runner.end();
    assert_eq!(code, Some(0), "{messages}");
    assert!(messages.contains("state safe: somebody stopped it"), "{messages}");
    let log = log(folder.path(), "run.csv");
    assert_eq!(log.column("command[1]").unwrap().values.last(), Some(&0.0));
    assert_eq!(log.column("bench.state").unwrap().values.last(), Some(&4.0));
}

/// At 1e-6 V/s the safe value is months away.
#[test]
fn the_third_interruption_ends_a_run_wherever_its_command_is() {
    let (folder, port) = (stage(60.0), port());
    change_plan(folder.path(), &[("safe_rate = 100", "safe_rate = 1e-6")]);
    let _machine = machine(port, &[], folder.path());
    let mut runner = runner(port, &[], folder.path());
    std::thread::sleep(Duration::from_millis(1500));
    for signal in ["-INT", "-TERM"] {
        runner.signal(signal);
        std::thread::sleep(Duration::from_millis(300));
        assert!(runner.child.try_wait().unwrap().is_none(), "it waits for the safe value");
    }
    runner.signal("-INT");
    let (messages, _) = runner.end();
    assert!(messages.contains("state safe: somebody stopped it"), "{messages}");
    assert!(messages.contains("a third interruption ended the run"), "{messages}");
}

#[test]
fn with_a_key_only_its_holder_is_believed() {
    let (folder, port) = (stage(0.5), port());
    let at = folder.path();
    std::fs::write(at.join("a.key"), "0123456789abcdef").unwrap();
    std::fs::write(at.join("b.key"), "0123456789abcdeF").unwrap();
    let keyed = machine(port, &["--key", "a.key"], at);
    assert!(keyed.first.contains("HMAC-SHA-256") && keyed.first.contains("us per cycle"));
    change_plan(at, &[("patience = 20", "patience = 0.5")]);
    for wrong in [&["--key", "b.key"][..], &[]] {
        let (answer, code) = run(port, wrong, at);
        assert_eq!((code, answer["measurements"]["used"].as_u64()), (Some(1), Some(0)), "{answer}");
    }
    change_plan(at, &[("patience = 0.5", "patience = 20")]);
    let (answer, code) = run(port, &["--key", "a.key"], at);
    println!("{answer:#}");
    assert_eq!(
        (code, answer["reason"].as_str()),
        (Some(0), Some("the plan has ended")),
        "{answer}"
    );
    assert_eq!(answer["keyed"]["forged"], 0);
    keyed.signal("-TERM");
    let (messages, _) = keyed.end();
    assert!(messages.contains("packets without a right tag"), "{messages}");
    let far = ["bench", "run", "--plan", "plan.toml", "--gateway", "shm://x", "--key", "a.key"];
    assert!(refuse(&far, at).contains("--key is for udp://"));
}

#[test]
fn a_dead_machine_is_a_fault_of_the_run() {
    let (folder, port) = (stage(60.0), port());
    let machine = machine(port, &["--inject", "power-loss,from=1"], folder.path());
    let (answer, code) = run(port, &[], folder.path());
    assert_eq!((code, answer["state"].as_str()), (Some(1), Some("fault")), "{answer}");
    assert_eq!(answer["reason"], "the machine's power was off");
    drop(machine);
}

#[test]
fn a_machine_with_other_channels_is_reported() {
    let (folder, port) = (stage(1.0), port());
    let axis = "[[axis]]\ncommand_limits = [-2, 12]\n[watch]";
    let changes =
        [("patience = 20", "patience = 0.5"), ("[watch]", axis), ("at = [6]", "at = [6, 6]")];
    change_plan(folder.path(), &changes);
    let _machine = machine(port, &[], folder.path());
    let (answer, code) = run(port, &[], folder.path());
    assert_eq!(code, Some(1), "{answer}");
    assert_eq!(answer["refused"], "the packet has 1 channels; 2 are configured");
}

#[test]
fn nobody_answers() {
    let folder = stage(1.0);
    change_plan(folder.path(), &[("patience = 20", "patience = 0.2")]);
    let (answer, code) = run(port(), &[], folder.path());
    assert_eq!((code, answer["measurements"]["used"].as_u64()), (Some(1), Some(0)));
    assert_eq!(answer["reason"], "no packet came from the machine");
}

/// A controller FMU of evc, two axes, follows a reference over UDP and over shared memory.
#[test]
fn the_controller_fmu_that_was_simulated_runs_on_the_bench() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    succeed(&["invert", "evc", "--period", "1e-3", "-o", "controller.toml"], here);
    for version in ["2", "3"] {
        succeed(&["pack", "controller.toml", "--fmi", version, "-o", "controller.fmu"], here);
        let rows =
            (0..300).map(|k| format!("{},{},2\n", f64::from(k) * 0.01, 2.0 + f64::from(k) * 1e-3));
        let text: String = rows.collect();
        std::fs::write(
            here.join("ref.csv"),
            format!("time,reference[1] [um],reference[2] [um]\n{text}"),
        )
        .unwrap();
        let udp = format!("udp://127.0.0.1:{}", port());
        let memory = format!("shm://test-{}-{version}", std::process::id());
        for gateway in [&udp, &memory] {
            let emulate = ["bench", "emulate", "evc", "--gateway", gateway, "--rate", "200"];
            let machine = Process::tool(&[&emulate[..], &["--timing", "commands"]].concat(), here);
            let plan = "[watch]\nhold = 150\nmax_age = 100\n";
            std::fs::write(here.join("plan.toml"), plan).unwrap();
            let call = ["--json", "bench", "run", "controller.fmu", "--plan", "plan.toml"];
            let rate = ["--gateway", gateway, "--rate", "200", "--command-limits", "0..120"];
            let files = ["--reference", "ref.csv", "--record", "run.csv"];
            let output = common::piezoloop(&[&call[..], &rate, &files].concat(), here);
            let messages = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(0), "{gateway}: {messages}{:?}", output.stdout);
            drop(machine);
            let log = log(here, "run.csv");
            let column = |name: &str| log.column(name).unwrap().values.clone();
            let (r, y, row) = (column("reference[1]"), column("position[1]"), column("bench.row"));
            let last = row.iter().rposition(|row| *row > 500.0).expect("the end of the plan");
            assert!(
                (r[last] - y[last]).abs() < 0.1,
                "FMI {version} {gateway}: {} {}",
                r[last],
                y[last]
            );
        }
    }
}

fn peer(command: &mut Command, folder: &Path, port: u16) {
    let machine = Process::start(command.args([&port.to_string(), "60"]));
    assert!(machine.first.contains("listening"), "{}", machine.first);
    let (answer, code) = run(port, &["--record", "run.csv"], folder);
    assert_eq!(code, Some(0), "{answer}");
    for counter in ["corrupt", "mismatched", "duplicate", "reordered"] {
        assert_eq!(answer["measurements"][counter], 0, "{counter}");
    }
    let log = log(folder, "run.csv");
    let greatest = log.column("position[1]").unwrap().values.iter().fold(0.0_f64, |m, y| m.max(*y));
    assert!((greatest - 0.5).abs() < 0.01, "6 V / 12 = 0.5 um, not {greatest}");
}

#[test]
fn a_peer_in_c() {
    let folder = stage(0.5);
    let program = folder.path().join("peer");
    let source = common::root().join("examples/05_bench/peer.c");
    let compiler = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-O2", "-o"])
        .args([&program, &source])
        .output();
    let Ok(compiled) = compiler else {
        println!("SKIPPED: no C compiler `cc`");
        return;
    };
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    peer(&mut Command::new(program), folder.path(), port());
}

#[test]
fn a_peer_in_python() {
    let folder = stage(0.5);
    let script = common::root().join("examples/05_bench/peer.py");
    if Command::new("python3").arg("--version").output().is_err() {
        println!("SKIPPED: no python3");
        return;
    }
    peer(Command::new("python3").arg(script), folder.path(), port());
}

/// The live page of a run of so many seconds, as it is at its end.
fn dumped_page(browser: &str, seconds: f64) -> String {
    let (folder, port) = (stage(seconds), port());
    let _machine = machine(port, &[], folder.path());
    let mut runner = runner(port, &["--web", "0"], folder.path());
    let mut url = String::new();
    while !url.contains("live page") {
        url.clear();
        assert!(runner.out.read_line(&mut url).unwrap() > 0, "the page's address is printed");
    }
    let url = url.trim().rsplit(' ').next().unwrap_or_default().to_owned();
    // The browser's clock stands still while the stream runs: it shows the page at the end.
    let page = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"])
        .args(["--virtual-time-budget=2000", "--dump-dom", &url])
        .output()
        .expect("the browser runs");
    let (messages, code) = runner.end();
    assert_eq!(code, Some(0), "{messages}");
    String::from_utf8_lossy(&page.stdout).into_owned()
}

#[test]
fn the_live_page_shows_the_run_in_a_browser() {
    let Some(browser) = ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok())
    else {
        println!("SKIPPED: no chromium");
        return;
    };
    // A busy machine may take longer to start a browser than the run lasts.
    let mut pages = [5.0, 30.0].into_iter().map(|seconds| dumped_page(browser, seconds));
    let page = pages.find(|page| page.contains("<canvas")).unwrap_or_default();
    for part in
        ["class=\"safe\">safe", "the plan has ended", "<td>position[1]</td>", "0.0000 V", "<canvas"]
    {
        assert!(page.contains(part), "{part} in\n{page}");
    }
}

#[test]
fn the_terminal_view_shows_the_run_on_a_terminal_and_q_stops_it() {
    let server = format!("piezoloop-{}", std::process::id());
    let tmux = |arguments: &[&str]| {
        let output = Command::new("tmux").args(["-L", &server]).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (folder, port) = (stage(60.0), port());
    let _machine = machine(port, &[], folder.path());
    let tool = env!("CARGO_BIN_EXE_piezoloop");
    let here = folder.path().display();
    let line = format!(
        "cd '{here}' && '{tool}' bench run --plan plan.toml --gateway udp://127.0.0.1:{port} --live; \
         echo ended with $?; sleep 60"
    );
    if tmux(&["new-session", "-d", "-x", "60", "-y", "24", &line]).is_none() {
        println!("SKIPPED: no tmux");
        return;
    }
    let shows = |words: &[&str]| {
        wait_for(|| {
            let screen = tmux(&["capture-pane", "-p"]).expect("a screen");
            let is_shown = words.iter().all(|word| screen.contains(word));
            if is_shown { Ok(screen) } else { Err(format!("{words:?} not in\n{screen}")) }
        })
    };
    let screen = shows(&["RUNNING", "6.0000 V", "position[1]", " um", "corrupt 0", "q: stop"]);
    println!("{screen}");
    tmux(&["send-keys", "q"]).expect("a key");
    shows(&["state safe: somebody stopped it", "ended with 0"]);
    tmux(&["kill-server"]);
}

#[test]
fn a_campaign_is_tried_and_what_ends_otherwise_is_reported() {
    let folder = stage(2.0);
    let campaign = "plan = \"plan.toml\"\nplant = \"p1\"\nheartbeat = 20\n\
        [[case]]\nname = \"silence\"\nat = [60, 80]\n\
        expect = { state = \"safe\", reason = \"sample-lost\", within = 155 }\n\
        [[case.fault]]\nkind = \"loss\"\nprobability = 1\n\
        [[case]]\nname = \"noise on the line\"\n\
        expect = { state = \"safe\", reason = \"finished\" }\n\
        [[case.fault]]\nkind = \"corrupt\"\nprobability = 0.1\ndirection = \"both\"\n";
    let write = |text: &str| std::fs::write(folder.path().join("faults.toml"), text).unwrap();
    write(campaign);
    let messages = succeed(&["bench", "campaign", "faults.toml"], folder.path());
    assert!(messages.contains("3 of 3 trials ended as expected"), "{messages}");
    write(&campaign.replace("within = 155", "within = 100"));
    let output = common::piezoloop(&["bench", "campaign", "faults.toml"], folder.path());
    let messages = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{messages}");
    assert!(
        messages.contains("FAILED silence, from cycle 60") && messages.contains("1 of 3"),
        "{messages}"
    );
    write(&campaign.replace("sample-lost", "sample-gone").replace("0.1", "1.1"));
    let message = refuse(&["bench", "campaign", "faults.toml"], folder.path());
    assert!(message.contains("faults.toml:7") && message.contains("sample-lost"), "{message}");
    write(&campaign.replace("plant = \"p1\"", ""));
    let message = refuse(&["bench", "campaign", "faults.toml"], folder.path());
    assert!(message.contains("--plant"), "{message}");
}

#[test]
fn an_ethercat_gateway_says_what_it_needs() {
    let folder = stage(0.5);
    let run = ["bench", "run", "--plan", "plan.toml", "--gateway", "ethercat://no-such-nic"];
    let message = refuse(&run, folder.path());
    assert!(message.contains("[ethercat]"), "{message}");
    let plan = std::fs::read_to_string(folder.path().join("plan.toml")).unwrap();
    let channel = "[[ethercat.channel]]\noutput = { device = 0, byte = 0, type = \"i16\" }\n\
                   input = { device = 1, byte = 0, type = \"i32\" }\n";
    std::fs::write(folder.path().join("plan.toml"), plan.clone() + channel).unwrap();
    let message = refuse(&run, folder.path());
    assert!(message.contains("features ethercat") || message.contains("no such interface"));
    std::fs::write(folder.path().join("plan.toml"), plan + channel + channel).unwrap();
    let message = refuse(&run, folder.path());
    assert!(message.contains("2 channels for 1 axes"), "{message}");
}

#[test]
fn the_document_has_the_table_of_the_code() {
    let table = succeed(&["bench", "packet"], common::root());
    let document = std::fs::read_to_string(common::root().join("docs/gateway.md")).unwrap();
    assert!(table.lines().count() > 14);
    assert!(document.contains(table.trim_end()), "print it with: piezoloop bench packet");
    for reason in bench::safety::Reason::ALL {
        assert!(document.contains(&format!("{} ", reason as u8)), "{reason:?}");
    }
}

#[test]
fn wrong_plans_and_options_are_reported() {
    let folder = stage(1.0);
    let here = folder.path();
    let message = refuse(&["bench", "run", "--plan", "plan.toml"], here);
    assert!(message.contains("--gateway"), "{message}");
    let gateway = ["--gateway", "udp://127.0.0.1:9"];
    let with = |more: &[&str]| {
        let mut all = vec!["bench", "run", "--plan", "plan.toml"];
        all.extend(gateway);
        all.extend(more);
        refuse(&all, here)
    };
    assert!(with(&["--record", "run.xls"]).contains(".mf4"));
    assert!(with(&["--reference", "none.csv"]).contains("none.csv"));
    assert!(with(&["--rate", "1M"]).contains("10k"));
    std::fs::write(here.join("plan.toml"), "rate = 0\n[[axis]]\ncommand_limits = [5, 1]\n")
        .unwrap();
    let message = with(&[]);
    assert!(message.contains("0.1 Hz") && message.contains("MIN < MAX"), "{message}");
    let emulate = ["bench", "emulate", "p1", "--rate", "1k", "--inject", "loss"];
    let message = refuse(&[&emulate[..], &gateway].concat(), here);
    assert!(message.contains("probability"), "{message}");
    assert!(refuse(&["bench", "recover", "plan.toml", "-o", "x.csv"], here).contains("PZLJRNL1"));
}
