//! Pages of the commands, in headless Chromium: nothing is loaded or complained of, keyboard and mouse
//! work, axe-core finds nothing in light and dark, they fit a telephone, print, and are usable soon. And
//! `--plot` opens them.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use common::{piezoloop, refuse, root, succeed};
use report::{Axis, Bode, Diagram, Histogram, KeyFigure, Lane, Look, Report, Role, Section};
use report::{Spectrum, Table, TimeSeries, Value, Verdict, XyLoop};

/// Chromium, Node and axe-core, or `None` with a line that says why tests are skipped.
struct Browser {
    chromium: PathBuf,
    axe: PathBuf,
}

/// A program that starts.
fn program(names: &[&str]) -> Option<PathBuf> {
    let starts = |name: &&&str| {
        Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    names.iter().find(starts).map(PathBuf::from)
}

fn browser() -> Option<&'static Browser> {
    static FOUND: OnceLock<Option<Browser>> = OnceLock::new();
    let found = FOUND.get_or_init(|| match find_browser() {
        Ok(browser) => Some(browser),
        Err(reason) => {
            println!("SKIPPED: pages are not looked at: {reason}");
            None
        }
    });
    found.as_ref()
}

fn find_browser() -> Result<Browser, String> {
    let given = std::env::var_os("PIEZOLOOP_CHROMIUM").map(PathBuf::from);
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let chromium = given.or_else(|| program(&names)).ok_or("there is no Chromium")?;
    program(&["node"]).ok_or("there is no Node.js")?;
    Ok(Browser { chromium, axe: axe()? })
}

/// axe-core as tests/browser/package-lock.json pins it, by its hash; fetched once under `target/`.
fn axe() -> Result<PathBuf, String> {
    let from = root().join("tests/browser");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("axe");
    let read = |path: &Path| fs::read_to_string(path).map_err(|e| e.to_string());
    let wanted = read(&from.join("package-lock.json"))?;
    let file = folder.join("node_modules/axe-core/axe.min.js");
    let stamp = folder.join("stamp");
    if file.is_file() && read(&stamp).is_ok_and(|version| version == wanted) {
        return Ok(file);
    }
    fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
    for name in ["package.json", "package-lock.json"] {
        fs::copy(from.join(name), folder.join(name)).map_err(|e| e.to_string())?;
    }
    let npm = Command::new("npm")
        .args(["ci", "--ignore-scripts", "--no-audit", "--no-fund"])
        .current_dir(&folder)
        .output()
        .map_err(|e| format!("npm: {e}"))?;
    if !npm.status.success() || !file.is_file() {
        let errors = String::from_utf8_lossy(&npm.stderr).into_owned();
        return Err(format!("npm ci: {}", errors.lines().last().unwrap_or("no axe-core")));
    }
    fs::write(&stamp, wanted).map_err(|e| e.to_string())?;
    Ok(file)
}

/// Checks pages; the facts of each, in order.
fn check(browser: &Browser, folder: &Path, pages: &[&str]) -> Vec<serde_json::Value> {
    let mut command = Command::new("node");
    command.arg(root().join("tests/browser/check.mjs")).args([&browser.chromium, &browser.axe]);
    if let Some(pictures) = std::env::var_os("PIEZOLOOP_PICTURES") {
        command.env("PICTURES", pictures);
    }
    let output = command.args(pages).current_dir(folder).output().expect("node starts");
    let message = String::from_utf8_lossy(&output.stdout).into_owned();
    print!("{message}");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !message.contains("FAILED"), "{message}{errors}");
    let facts = message.lines().filter_map(|line| line.split_once(": "));
    let facts: Vec<_> =
        facts.map(|(_, text)| serde_json::from_str(text).expect("facts as JSON")).collect();
    assert_eq!(facts.len(), pages.len(), "{message}");
    facts
}

/// Ten noisy signals of 200 000 samples.
fn ten_signals() -> Report {
    let n = 200_000;
    let time: Vec<f64> = (0..n).map(|i| f64::from(i) * 5e-5).collect();
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
    };
    let figure = (0..10).fold(TimeSeries::new("Ten noisy signals", &time), |figure, k| {
        let values: Vec<f64> =
            time.iter().map(|t| (f64::from(k + 1) * t).sin() * 1.234_567 + noise()).collect();
        figure.other(format!("signal {k}"), if k < 5 { "um" } else { "V" }, &values)
    });
    Report::new("gallery", "Ten signals", Verdict::neutral("Ten signals of 200 000 samples."))
        .section(Section::new("Signals").figure(figure))
}

/// Every kind of figure and block.
fn gallery() -> Report {
    let n = 3000;
    let time: Vec<f64> = (0..n).map(|i| f64::from(i) * 1e-3).collect();
    let u: Vec<f64> = time.iter().map(|t| 50.0 - 50.0 * (6.0 * t).cos()).collect();
    let y: Vec<f64> = time.iter().map(|t| 3.0 - 3.0 * (6.0 * t - 0.2).cos()).collect();
    let e: Vec<f64> = u.iter().zip(&y).map(|(u, y)| 0.06 * u - y).collect();
    let f: Vec<f64> = (1..400).map(f64::from).collect();
    let m: Vec<f64> = f.iter().map(|f| 1.0 / (1.0 + (f / 50.0).powi(2))).collect();
    let p: Vec<f64> = f.iter().map(|f| -(f / 50.0).atan()).collect();
    let lane = Lane::new("Axis Y")
        .stage(Look::Signal, "command[1]", "V")
        .stage(Look::Box, "hysteresis", "prandtl-ishlinskii")
        .stage(Look::Shared, "coupling", "")
        .stage(Look::Off, "creep", "off")
        .stage(Look::Signal, "position[1]", "um");
    let long = (0..40).fold(Table::new("A long table", ["number", "text"]), |table, k| {
        table.row([Value::from(k), "some words that fill a cell of the table".into()])
    });
    Report::new("gallery", "Every kind of figure", Verdict::pass("All of it is shown."))
        .warning("A warning.")
        .key_figure(KeyFigure::new("Error", 0.61, "um").at_most(0.8))
        .key_figure(KeyFigure::new("Gain", 2.0, "1").at_least(3.0).note("A note."))
        .section(
            Section::new("Figures")
                .paragraph("Text.")
                .list(["An item."])
                .code("piezoloop demo")
                .diagram(Diagram::new("Signal path").lane(lane))
                .figure(
                    XyLoop::new("Loop", Axis::new("command", "V"), Axis::new("position", "um"))
                        .measured("measured", &u, &y)
                        .model("model", &u, &e),
                )
                .figure(Histogram::new(
                    "Errors",
                    Axis::new("error", "um"),
                    &[(Role::Residual, "error", &e), (Role::Other, "position", &y)],
                ))
                .figure(
                    TimeSeries::new("Signals", &time)
                        .reference("command", "V", &u)
                        .panel("position")
                        .measured("measured", "um", &y)
                        .residual("error", "um", &e)
                        .limit(5.0, "limit")
                        .band(1.0, 2.0, "held out")
                        .marker(0.5, "step"),
                )
                .figure(
                    Bode::new("Response", "um/V")
                        .response(Role::Measured, "measured", &f, &m, &p, Some(&m))
                        .response(Role::Model, "model", &f, &m, &p, None),
                )
                .figure(
                    Spectrum::new("Density", Axis::new("density", "um/√Hz"))
                        .density(Role::Residual, "error", &e, 1e-3)
                        .limit(1e-3, "noise"),
                ),
        )
        .section(Section::new("Tables").table(long))
}

#[test]
fn ten_long_signals_stay_below_a_megabyte() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    ten_signals().write_html(folder.path().join("ten-signals.html")).expect("a page");
    gallery().write_html(folder.path().join("gallery.html")).expect("a page");
    let facts = check(browser, folder.path(), &["ten-signals.html", "gallery.html"]);
    let of = |page: usize, name: &str| facts[page][name].as_f64().expect("a number");
    assert!(of(0, "bytes") <= 1e6, "{} bytes", of(0, "bytes"));
    assert_eq!((of(0, "figures"), of(1, "figures")), (1.0, 4.0));
    // How soon is measured, not judged: the machine does other things too.
    println!("ten long signals: usable after {} ms (aim: 1000)", of(0, "usable"));
    assert!(of(0, "usable").is_finite());
}

/// A log of a stage in a folder, and a plant and a controller identified from it.
fn stage(folder: &Path) {
    let log = root().join("examples/01_log_to_loop/stage.csv");
    let text = fs::read_to_string(log).expect("the log of example 01");
    // Every fourth part of it is enough for a page.
    let rows: Vec<&str> = text.lines().take(6001).collect();
    fs::write(folder.join("stage.csv"), rows.join("\n") + "\n").expect("a log");
    let identify = "identify --log stage.csv --input u --output y --model prandtl-ishlinskii --plays 8 \
                    -o plant.toml --report identify.html --report identify.json --quiet";
    succeed(&words(identify), folder);
    succeed(&words("invert plant.toml --period 1e-4 -o controller.toml --quiet"), folder);
    succeed(&words("pack plant.toml --step 1e-4 -o plant.fmu --quiet"), folder);
    succeed(&words("pack controller.toml --fmi 3 -o controller.fmu --quiet"), folder);
}

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

fn reference(folder: &Path) {
    let mut text = String::from("time,reference[1]\n");
    for k in 0..2001 {
        let t = f64::from(k) * 1e-4;
        text += &format!("{t},{}\n", 1.0 - (std::f64::consts::TAU * 20.0 * t).cos());
    }
    fs::write(folder.join("reference.csv"), text).expect("a log");
}

/// A run of half a second next to an emulated machine, and a campaign of faults.
fn bench_pages(at: &Path) {
    let plan = "rate = 200\nsettle = 0.05\napproach = 0.1\npatience = 20\n\
                [[axis]]\ncommand_limits = [-2, 12]\nsafe_rate = 100\n\
                command_unit = \"V\"\nposition_unit = \"um\"\n[watch]\nhold = 150\nmax_age = 100\n";
    let rests =
        [5, 8, 3].map(|at| format!("[[sequence]]\nkind = \"rest\"\nseconds = 0.2\nat = [{at}]\n"));
    fs::write(at.join("bench-plan.toml"), plan.to_owned() + &rests.concat()).expect("a plan");
    let port = 23_000 + 2 * (std::process::id() % 4000);
    let gateway = format!("udp://127.0.0.1:{port}");
    let emulate = ["bench", "emulate", "p1", "--gateway", &gateway, "--rate", "200"];
    let mut machine = Command::new(env!("CARGO_BIN_EXE_piezoloop"))
        .args(emulate)
        .args(["--timing", "commands"])
        .current_dir(at)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("the machine starts");
    let mut first = String::new();
    let out = machine.stdout.take().expect("a pipe");
    std::io::BufRead::read_line(&mut std::io::BufReader::new(out), &mut first).expect("it speaks");
    let run = ["bench", "run", "--plan", "bench-plan.toml", "--gateway", &gateway, "--quiet"];
    let message = piezoloop(&[&run[..], &["--report", "bench.html"]].concat(), at);
    machine.kill().expect("it ends");
    machine.wait().expect("it ends");
    let errors = String::from_utf8_lossy(&message.stderr);
    assert!(message.status.code().is_some_and(|code| code < 2), "{errors}");
    let left = fs::read_dir(at).expect("a folder").flatten();
    let journals = left.filter(|e| e.path().extension().is_some_and(|e| e == "journal")).count();
    assert_eq!(journals, 0, "the page's own journal is gone");

    let campaign = "plan = \"bench-plan.toml\"\nplant = \"p1\"\nheartbeat = 20\n[[case]]\nname = \"no sample\"\n\
                    at = [30]\nexpect = { state = \"safe\", reason = \"sample-lost\", within = 400 }\n\
                    [[case.fault]]\nkind = \"loss\"\nprobability = 1\n";
    fs::write(at.join("faults.toml"), campaign).expect("a campaign");
    let message =
        piezoloop(&words("bench campaign faults.toml --report campaign.html --quiet"), at);
    let errors = String::from_utf8_lossy(&message.stderr);
    assert!(message.status.code().is_some_and(|code| code < 2), "{errors}");
}

/// Four coordinates of two motions with a little noise.
fn calibration_page(at: &Path) {
    let mut text = String::from("time [s],theta1,theta2,x [um],y [um]\n");
    for k in 0..400 {
        let turn = std::f64::consts::TAU * f64::from(k) / 400.0;
        let theta = [0.5 - 0.4 * (3.0 * turn).cos(), 0.5 - 0.4 * (5.0 * turn).cos()];
        let x = 7.0 + 500.0 * theta[0] + 0.1 * (91.0 * turn).sin();
        let y = 3.0 + 14.0 * theta[0] - 515.0 * theta[1] + 0.1 * (83.0 * turn).sin();
        text += &format!("{},{},{},{x},{y}\n", 0.005 * f64::from(k), theta[0], theta[1]);
    }
    fs::write(at.join("motion.csv"), text).expect("a log");
    let line = "calibrate motion.csv --motion theta1 --motion theta2 --position x --position y \
                --report calibrate.html --quiet";
    succeed(&words(line), at);
}

#[test]
fn pages_of_the_commands_hold_in_a_browser() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    stage(at);
    reference(at);
    bench_pages(at);
    calibration_page(at);
    let system = "step = 1e-4\n[fmus]\ncontroller = \"controller.fmu\"\nplant = \"plant.fmu\"\n\
                  [connections]\n\"plant.command[1]\" = \"controller.command[1]\"\n\
                  \"controller.measured[1]\" = \"plant.position[1]\"\n\
                  [inputs]\n\"controller.reference[1]\" = \"reference[1]\"\n\
                  [record]\ncommand = \"plant.command[1]\"\nposition = \"plant.position[1]\"\n";
    fs::write(at.join("loop.toml"), system).expect("a system");
    for line in [
        "simulate plant.fmu --log stage.csv --map command[1]=u --map position[1]=y --report simulate.html --quiet",
        "simulate --loop plant.toml controller.toml --reference reference.csv --report loop.html --quiet",
        "tune plant.fmu --period 1e-3 --middle 50 --amplitude 5 --report tune.html --quiet",
        "invert plant.toml -o inverted.toml --report invert.html --quiet",
        "diagnose --model plant.toml --log stage.csv --map command[1]=u --map position[1]=y --max-effects 1 --report diagnose.html --quiet",
        "gap-bench --short --cases 1 -o bench --quiet",
        "system loop.toml --input reference.csv --report system.html --quiet",
    ] {
        let message = piezoloop(&words(line), at);
        let errors = String::from_utf8_lossy(&message.stderr);
        assert!(message.status.code().is_some_and(|code| code < 2), "{line}: {errors}");
    }
    for (fmu, page) in [("plant.fmu", "plant-doc.html"), ("controller.fmu", "controller-doc.html")]
    {
        let package = modeldescription::Package::open(at.join(fmu)).expect("an FMU");
        fs::copy(package.folder().join("documentation/index.html"), at.join(page)).expect("a page");
    }
    fs::rename(at.join("bench/index.html"), at.join("gap-bench.html")).expect("a page");
    let pages = [
        "identify.html",
        "simulate.html",
        "loop.html",
        "tune.html",
        "invert.html",
        "diagnose.html",
        "gap-bench.html",
        "bench.html",
        "campaign.html",
        "calibrate.html",
        "system.html",
        "plant-doc.html",
        "controller-doc.html",
    ];
    for facts in check(browser, at, &pages) {
        let bytes = facts["bytes"].as_f64().expect("a number");
        assert!(bytes <= 1e6, "{facts}");
    }
    // The same context as JSON gives the same page.
    let json = fs::read_to_string(at.join("identify.json")).expect("a file");
    let again = Report::from_json(&json).expect("a report").to_html().expect("a page");
    let page = fs::read_to_string(at.join("identify.html")).expect("a page");
    assert!(again == page, "the page of the JSON is another one");
}

/// A folder with an opener that writes down what it is given, and ends with this code.
fn opener(folder: &Path, code: i32) -> PathBuf {
    use std::os::unix::fs::PermissionsExt as _;
    let bin = folder.join("bin");
    fs::create_dir_all(&bin).expect("a folder");
    let script =
        format!("#!/bin/sh\nprintf '%s\\n' \"$@\" > '{}/opened'\nexit {code}\n", folder.display());
    let file = bin.join("xdg-open");
    fs::write(&file, script).expect("a script");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).expect("it can be run");
    bin
}

#[test]
fn plot_opens_the_page_with_the_systems_opener() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    succeed(&["pack", "evc", "-o", "evc.fmu", "--quiet"], at);
    fs::write(at.join("log.csv"), "time,command[1],command[2]\n0,0,0\n0.001,10,20\n0.002,20,10\n")
        .expect("a log");
    let run = |bin: &Path, more: &[&str]| {
        let path = std::env::join_paths([bin.to_path_buf()]).expect("a path");
        Command::new(env!("CARGO_BIN_EXE_piezoloop"))
            .args(["simulate", "evc.fmu", "--log", "log.csv", "--plot"])
            .args(more)
            .env("PATH", path)
            .env("TMPDIR", at)
            .current_dir(at)
            .output()
            .expect("the tool starts")
    };
    // With a name of its own.
    let bin = opener(at, 0);
    let output = run(&bin, &["--report", "run.html"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read_to_string(at.join("opened")).expect("it was opened").trim(), "run.html");
    assert!(fs::read_to_string(at.join("run.html")).expect("a page").contains("<!DOCTYPE html>"));
    // Without one, and with JSON alone: in the folder for temporary files.
    for more in [&[][..], &["--report", "run.json"]] {
        fs::remove_file(at.join("opened")).expect("it is there");
        assert!(run(&bin, more).status.success());
        let opened = fs::read_to_string(at.join("opened")).expect("it was opened");
        let page = Path::new(opened.trim());
        assert!(page.starts_with(at) && page.extension().is_some_and(|e| e == "html"), "{opened}");
        assert!(fs::read_to_string(page).expect("a page").contains("Signals over time"));
    }
    // An opener that fails, and none at all: an error that says where the page is.
    opener(at, 3);
    for bin in [bin.as_path(), Path::new("/nowhere")] {
        let output = run(bin, &["--report", "run.html"]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("xdg-open") && message.contains("run.html"), "{message}");
    }
    // A page is not written over what is read.
    let message = refuse(&["simulate", "evc.fmu", "--log", "log.csv", "--report", "log.csv"], at);
    assert!(message.contains("log.csv"), "{message}");
}
