//! The interface of `piezoloop diagnose`: flags as they are documented, exit codes, the same bytes
//! for any number of threads, every answer valid by the schema, the page in a real browser.
#![cfg(target_os = "linux")]

use crate::common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::repaired::{measure, write_rest};
use common::{piezoloop, python, refuse, root, succeed};

const STAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/blueprints/stage.toml");
const LOGS: [&str; 4] = ["--log", "multisine.csv", "--log", "stairs.csv"];

fn diagnose<'a>(model: &'a str, further: &[&'a str]) -> Vec<&'a str> {
    [&["diagnose", "--model", model][..], &LOGS[..], further].concat()
}

/// Holds JSON files against the schema with a foreign validator, and looks for what is no number.
fn validate(files: &[&str], folder: &Path) {
    let schema = root().join("docs/gap.schema.json");
    let code = r#"
import json, sys
from jsonschema import Draft202012Validator
def no_constant(text):
    raise ValueError(text + " is no JSON")
schema = json.load(open(sys.argv[1]))
Draft202012Validator.check_schema(schema)
validator = Draft202012Validator(schema)
for name in sys.argv[2:]:
    gap = json.load(open(name), parse_constant=no_constant)
    problems = [f"{list(e.absolute_path)}: {e.message[:200]}" for e in validator.iter_errors(gap)]
    assert not problems, (name, problems)
    print(name, gap["verdict"])
"#;
    let mut arguments = vec![schema.to_str().expect("UTF-8")];
    arguments.extend(files);
    print!("{}", python::script(code, &arguments, folder));
}

#[test]
fn all_flags_work_as_documented_and_every_answer_is_valid() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    measure(at);
    write_rest(at);
    succeed(&["pack", STAGE, "-o", "stage.fmu"], at);
    let map = ["--map", "u=u", "--map", "x=x"];
    // A log that is fitted cannot judge, whatever it is called.
    let both = refuse(&diagnose(STAGE, &["--holdout", "./stairs.csv"]), at);
    assert!(both.contains("--holdout ./stairs.csv: is also a --log"), "{both}");
    fs::copy(at.join("stairs.csv"), at.join("more.csv")).expect("writable");
    // All at once, a file behind --json.
    let all = [
        "--holdout",
        "more.csv",
        "--unit",
        "u=V",
        "--outputs",
        "x",
        "--tune",
        "*.bandwidth=0.02",
        "--tune",
        "*.stiffnes=0.1",
        "--tune",
        "axis[1].mechanics.frequency=+-6",
        "--gain-tolerance",
        "0.02",
        "--noise",
        "x=0.002",
        "--max-effects",
        "2",
        "--without",
        "friction",
        "--without",
        "backlash",
        "--json",
        "white.json",
        "--report",
        "gap.html",
        "--repair",
        "repaired.toml",
        "--threads",
        "1",
        "--seed",
        "3",
        "--fail-above",
        "0.9",
        "--next-experiment",
        "next.csv",
    ];
    let messages = succeed(&diagnose(STAGE, &[&map[..], &all[..]].concat()), at);
    assert!(messages.contains("white.json: written"), "{messages}");
    for file in ["white.json", "gap.html", "repaired.toml"] {
        assert!(at.join(file).is_file(), "{file}");
    }
    let gap = fs::read_to_string(at.join("white.json")).expect("a file");
    let gap: serde_json::Value = serde_json::from_str(&gap).expect("JSON");
    assert_eq!(gap["provenance"]["seed"], 3);
    assert_eq!(gap["provenance"]["without"], serde_json::json!(["friction", "backlash"]));
    let warnings = gap["warnings"].to_string();
    assert!(warnings.contains("--tune *.stiffnes: no parameter of the model"), "{warnings}");
    // The other spelling, and other data: the same bytes whatever the number of threads.
    let black = ["--map", "command[1]=u", "--map", "position[1]=x"];
    for (threads, file) in [("1", "--json=one.json"), ("2", "--json=two.json")] {
        succeed(&diagnose("stage.fmu", &[&black[..], &[file, "--threads", threads]].concat()), at);
    }
    let read = |name: &str| fs::read(at.join(name)).expect("a file");
    assert!(read("one.json") == read("two.json"), "one thread and two give the same bytes");
    // A record at rest, and a log that says nothing.
    let rest = ["--rest", "rest.csv", "--json", "rest.json"];
    succeed(&diagnose("stage.fmu", &[&black[..], &rest[..]].concat()), at);
    let quiet = ["diagnose", "--model", "stage.fmu", "--log", "rest.csv", "--json", "quiet.json"];
    succeed(&[&quiet[..], &black[..], &["--noise", "0.002"]].concat(), at);
    validate(&["white.json", "one.json", "rest.json", "quiet.json"], at);
}

#[test]
fn exit_codes_tell_the_verdict_from_bad_input() {
    let folder = tempfile::tempdir().expect("a folder");
    measure(folder.path());
    let map = ["--map", "u=u", "--map", "x=x", "--max-effects", "1", "--noise", "0.002"];
    let fails = piezoloop(
        &diagnose(STAGE, &[&map[..], &["--fail-above", "0.001"]].concat()),
        folder.path(),
    );
    assert_eq!(fails.status.code(), Some(1), "{}", String::from_utf8_lossy(&fails.stdout));
    let messages = String::from_utf8_lossy(&fails.stdout);
    assert!(messages.contains("The model lacks"), "the answer is given all the same: {messages}");
    for bad in [
        &["--tune", "nonsense"][..],
        &["--without", "crep"],
        &["--noise", "-1"],
        &["--outputs", "z"],
        &["--holdout", "none.csv"],
        &["--repair", "repaired.zip"],
        &["--json", "multisine.csv"],
    ] {
        let message = refuse(&diagnose(STAGE, &[&map[..6], bad].concat()), folder.path());
        let output = piezoloop(&diagnose(STAGE, &[&map[..6], bad].concat()), folder.path());
        assert_eq!(output.status.code(), Some(2), "{bad:?}: {message}");
        println!("{}: {}", bad.join(" "), message.lines().next().unwrap_or_default());
    }
}

/// What a browser does with the page: counts errors and requests, and switches every curve off and
/// on again.
const PROBE: &str = r#"
<script>
window.problems = [];
// A browser without a screen shows nothing: each figure counts as seen at once.
window.IntersectionObserver = class {
  constructor(seen) { this.seen = seen; }
  observe(target) { this.seen([{ isIntersecting: true, target }]); }
  unobserve() {}
};
window.addEventListener("error", (e) => window.problems.push(String(e.message)));
const told = console.error;
console.error = (...all) => { window.problems.push(all.join(" ")); told(...all); };
window.addEventListener("load", () => setTimeout(() => {
  const figures = document.querySelectorAll("figure .live");
  let toggled = 0;
  for (const button of document.querySelectorAll("figure button")) {
    if (!button.hasAttribute("aria-pressed")) continue;
    const before = button.getAttribute("aria-pressed");
    button.click();
    if (button.getAttribute("aria-pressed") !== before) toggled += 1;
    button.click();
    if (button.getAttribute("aria-pressed") !== before) window.problems.push("a toggle does not come back");
  }
  const requests = performance.getEntriesByType("resource").length;
  document.title = `figures ${figures.length} toggled ${toggled} requests ${requests} problems ${window.problems.join("|")}`;
}, 1500));
</script>
"#;

#[test]
fn the_page_lives_in_a_real_browser_without_errors_and_without_a_network() {
    let Some(browser) =
        ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
            .into_iter()
            .find(|path| Path::new(path).exists())
    else {
        println!("SKIPPED: no Chromium for the page (Debian: apt install chromium)");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    measure(folder.path());
    let further = ["--map", "u=u", "--map", "x=x", "--noise", "0.002", "--report", "gap.html"];
    succeed(&diagnose(STAGE, &further), folder.path());
    let page = fs::read_to_string(folder.path().join("gap.html")).expect("the page");
    for words in
        ["The model lacks", "Candidates", "What to do next", "The repaired model", "@media print"]
    {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"), "nothing from outside");
    // The probe must be allowed by the page's policy, which this copy goes without.
    let start = page.find("<meta http-equiv=\"Content-Security-Policy\"");
    let open = start.map_or(page.clone(), |at| {
        let end = at + page[at..].find('>').expect("the element ends") + 1;
        format!("{}{}", &page[..at], &page[end..])
    });
    let probed = open.replacen("</head>", &format!("{PROBE}</head>"), 1);
    fs::write(folder.path().join("probed.html"), probed).expect("the folder is writable");
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"])
        .args(["--virtual-time-budget=20000", "--timeout=60000", "--dump-dom"])
        .arg(format!("file://{}", folder.path().join("probed.html").display()))
        .output()
        .expect("the browser starts");
    let dom = String::from_utf8_lossy(&output.stdout);
    let title = dom.split_once("<title>").and_then(|(_, rest)| rest.split_once("</title>"));
    let title = title.map_or("", |(title, _)| title);
    println!("{title}");
    let number = |word: &str| -> u32 {
        let (_, rest) = title.split_once(word).unwrap_or_else(|| panic!("no {word} in {title:?}"));
        rest.split_whitespace().next().and_then(|n| n.parse().ok()).expect("a number")
    };
    assert!(number("figures ") >= 5, "{title}");
    assert!(number("toggled ") >= 5, "{title}");
    assert_eq!(number("requests "), 0, "{title}");
    assert!(title.trim().ends_with("problems"), "{title}");
}

/// White noise from −1 to 1.
fn white(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
}

/// A log of plays behind falling swings, then growing ones, with noise of ±3 nm; `kept` is the part of its last distance to the
/// plays that the reading keeps in a row, as behind a lag.
fn log_of_plays(kept: f64) -> String {
    let (rows, period) = (3000, 1e-3);
    let mut csv = String::from("time [s],drive [V],reading [um]\n");
    let (mut plays, mut noise, mut reading) = ([0.0_f64; 3], 7_u64, 0.0);
    for k in 0..rows {
        let t = period * f64::from(k);
        let size = if t < 1.5 { 45.0 - 24.0 * t } else { 9.0 + 24.0 * (t - 1.5) };
        let u = size * (std::f64::consts::TAU * 4.0 * t).sin();
        let off = 0.003 * white(&mut noise);
        csv.push_str(&format!("{t},{u},{}\n", reading + off));
        let moved = [3.0, 9.0, 20.0].iter().zip(&mut plays).map(|(r, z)| {
            *z = (u - r).max((u + r).min(*z));
            0.02 * *z
        });
        let target = 0.1 * u + moved.sum::<f64>();
        reading = target + kept * (reading - target);
    }
    csv
}

/// The linear model of a frequency response, in the forms in which others and we write one; the log's hysteresis is found
/// beside it.
#[test]
fn a_frequency_response_stands_for_the_model() {
    use std::f64::consts::{PI, TAU};
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let (period, corner) = (1e-3, 60.0);
    let csv = log_of_plays((-TAU * corner * period).exp());
    fs::write(at.join("a.csv"), csv).expect("a log");
    // The machine itself, in decibels and degrees, in parts, and as a sampled log shows it.
    let mut decibels = String::from("f [Hz],gain [dB],phase [deg]\n");
    let mut parts = String::from("omega,G.real,G.imag\n");
    let mut own = String::from(
        "frequency [Hz],magnitude reading/drive [um/V],phase reading/drive [rad],deviation reading/drive [um/V]\n",
    );
    for f in (1..=120).map(|k| 4.0 * f64::from(k)) {
        let (size, angle) = (0.13 / (f / corner).hypot(1.0), -(f / corner).atan());
        decibels.push_str(&format!("{f},{},{}\n", 20.0 * size.log10(), angle.to_degrees()));
        parts.push_str(&format!("{},{},{}\n", TAU * f, size * angle.cos(), size * angle.sin()));
        let half = PI * f * period;
        own.push_str(&format!("{f},{},{},1e-3\n", size * half.sin() / half, angle - half));
    }
    for (name, text) in [("decibels.csv", decibels), ("parts.csv", parts), ("own.csv", own)] {
        fs::write(at.join(name), text).expect("a table");
        let call = ["diagnose", "--log", "a.csv", "--input", "drive", "--output", "reading"];
        let more =
            ["--frequency-response", name, "--baseline", "linear.toml", "--json", "gap.json"];
        let messages = succeed(&[&call[..], &more[..]].concat(), at);
        validate(&["gap.json"], at);
        let gap: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(at.join("gap.json")).expect("gap.json"))
                .expect("JSON");
        assert_eq!(gap["effects"][0]["effect"], "hysteresis", "{name}: {messages}");
        let parameters = &gap["baseline"][0]["parameters"];
        let near = |key: &str, value: f64| {
            let found = parameters[key]["value"].as_f64().unwrap_or(f64::NAN);
            assert!((found / value - 1.0).abs() < 5e-3, "{name}: {key} = {found}; {messages}");
            assert!(parameters[key]["std"].as_f64().is_some(), "{name}: {parameters}");
        };
        near("axis[1].gain.gain", 0.13);
        near("axis[1].amplifier.bandwidth", corner);
        assert!(messages.contains("a linear one is fitted to"), "{messages}");
        let model = fs::read_to_string(at.join("linear.toml")).expect("the linear model");
        assert!(model.contains("tolerance") && !model.contains("modal-matrix"), "{model}");
    }
    let call = ["diagnose", "--log", "a.csv", "--input", "drive", "--output", "reading"];
    for (text, words) in [
        ("time,G.real,G.imag\n1,2,3\n2,3,4\n", "no column of frequencies"),
        ("f [Hz],gain [dB]\n1,2\n2,3\n", "magnitude and phase"),
        ("f [Hz],gain,phase [deg]\n1,2,3\n2,3,4\n", "at least 8"),
    ] {
        fs::write(at.join("bad.csv"), text).expect("a table");
        let message = refuse(&[&call[..], &["--frequency-response", "bad.csv"]].concat(), at);
        assert!(message.contains(words) && message.contains("bad.csv"), "{message}");
    }
    let message = refuse(
        &["diagnose", "--log", "a.csv", "--model", "p1", "--frequency-response", "own.csv"],
        at,
    );
    assert!(message.contains("--frequency-response"), "{message}");
}

/// Plays whose rows are read after their command: this is found with the linear model that is made of the log. The model is
/// shown, tolerances and all, and what it lacks is found.
#[test]
fn a_log_alone_is_diagnosed_against_a_linear_model_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    // Each reading a row earlier.
    let log = log_of_plays(0.0);
    let rows: Vec<&str> = log.lines().collect();
    let parts = |row: &str| row.rsplit_once(',').map(|(a, b)| (a.to_owned(), b.to_owned()));
    let later = rows[1..].windows(2).map(|two| parts(two[0]).zip(parts(two[1])).expect("two rows"));
    let later: Vec<String> = later.map(|(a, b)| format!("{},{}", a.0, b.1)).collect();
    fs::write(at.join("a.csv"), format!("{}\n{}\n", rows[0], later.join("\n"))).expect("a log");
    let columns = ["diagnose", "--log", "a.csv", "--input", "drive", "--output", "reading"];
    let files = ["--baseline", "linear.toml", "--repair", "repaired.toml", "--json", "gap.json"];
    let messages = succeed(&[&columns[..], &files[..]].concat(), at);
    validate(&["gap.json"], at);
    let gap: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(at.join("gap.json")).expect("gap.json"))
            .expect("JSON");
    assert_eq!(gap["effects"][0]["effect"], "hysteresis", "{messages}");
    let baseline = &gap["baseline"][0];
    assert_eq!(baseline["output"], "reading");
    let gain = &baseline["parameters"]["axis[1].gain.gain"];
    let value = gain["value"].as_f64().expect("a gain");
    assert!((0.1..0.16).contains(&value) && gain["std"].as_f64().is_some(), "{baseline}");
    assert!(
        messages.contains("a linear one is identified") && messages.contains("axis[1].gain.gain"),
        "{messages}"
    );
    // What was made is a model as any other, and so is what is handed back.
    let model = fs::read_to_string(at.join("linear.toml")).expect("the linear model");
    assert!(model.contains("tolerance") && !model.contains("prandtl"), "{model}");
    assert!(messages.contains("each reading after its command has acted"), "{messages}");
    assert_eq!(gap["outputs"][0]["reading"], "after");
    let simulate = |model: &str, reading: &str| {
        let further =
            ["--log", "a.csv", "--map", "command[1]=drive", "--map", "position[1]=reading"];
        let call = [&["simulate", model, "--reading", reading][..], &further[..]].concat();
        common::json(&call, at)["fits"][0]["rmse"].as_f64().expect("a figure")
    };
    let repaired = simulate("repaired.toml", "after");
    assert!(repaired < 0.1 * simulate("linear.toml", "after"), "{repaired}");
    assert!(repaired < 0.3 * simulate("repaired.toml", "before"), "{repaired}");
    let message = refuse(&["diagnose", "--log", "a.csv"], at);
    assert!(message.contains("--model"), "{message}");
    let message = refuse(&["diagnose", "--log", "a.csv", "--input", "drive"], at);
    assert!(message.contains("--output"), "{message}");
    let message =
        refuse(&["diagnose", "--log", "a.csv", "--input", "none", "--output", "reading"], at);
    assert!(message.contains("none") && message.contains("drive"), "{message}");
}

/// Shrinking triangles of an elastic slip (a friction that follows the way for 3 mm), each reading a force.
fn log_of_friction() -> String {
    let (mut csv, mut slip, mut noise) =
        (String::from("time [s],way [mm],force [N]\n"), 0.0_f64, 7_u64);
    for k in 0..4000 {
        let t = 0.01 * f64::from(k);
        let phase = (0.25 * t + 0.25).fract();
        let way = (20.0 - 0.35 * t) * (4.0 * (phase - 0.5).abs() - 1.0);
        let off = 0.2 * white(&mut noise);
        slip = (way - 3.0).max((way + 3.0).min(slip));
        csv.push_str(&format!(
            "{t:.2},{way:.5},{:.5}\n",
            0.05 * way + 8.0 * (way - slip) / 3.0 + off
        ));
    }
    csv
}

/// The force of a friction over the way of a testing machine: nearly all of it is loop, whatever gain and dynamics a model has.
#[test]
fn a_force_that_is_nearly_all_friction_is_found_with_any_model_and_with_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("a.csv"), log_of_friction()).expect("a log");
    for gain in ["0.05", "0.5"] {
        let model = format!(
            "piezoloop = 1\nkind = \"plant\"\nname = \"spring\"\nstep = 0.01\n[[axis]]\nname = \"X\"\n\
             command = {{ name = \"way\", unit = \"mm\" }}\nposition = {{ name = \"force\", unit = \"N\" }}\n\
             [[axis.component]]\ntype = \"actuator-gain\"\nname = \"gain\"\ngain = {gain}\noffset = 0\n\
             tolerance = {{ gain = 0.9, offset = 1 }}\n"
        );
        fs::write(at.join("model.toml"), model).expect("a model");
        let call = ["diagnose", "--model", "model.toml", "--log", "a.csv", "--repair", "r.toml"];
        let gap = common::json(&call, at);
        assert_eq!(gap["effects"][0]["effect"], "hysteresis", "{gap:#}");
        // Of what is written.
        assert!(gap["shrink"]["fraction"].as_f64() > Some(0.95), "{gap:#}");
        let repaired = fs::read_to_string(at.join("r.toml")).expect("the repaired model");
        assert!(repaired.contains("prandtl-ishlinskii"), "{repaired}");
    }
    let alone = ["diagnose", "--log", "a.csv", "--input", "way", "--output", "force"];
    let gap = common::json(&alone, at);
    let names: Vec<_> = gap["effects"].as_array().expect("a list").iter().collect();
    assert!(names.len() == 1 && names[0]["effect"] == "hysteresis", "{gap:#}");
}

/// A limit of the amplifier before a mode, of which the linear model of the log knows nothing: the mode is no missing effect.
#[test]
fn dynamics_that_a_limit_hides_belong_to_the_linear_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut logs = Vec::new();
    for record in 0..3_u32 {
        let mut csv = String::from("time [s],u [V],y [um]\n");
        let command = |k: u32| {
            let line = |n: u32| {
                let n = f64::from(n);
                let phase = n * n * (1.0 + 0.37 * f64::from(record));
                (std::f64::consts::TAU * 1.7e-3 * n * f64::from(k) + phase).sin()
            };
            50.0 + 10.0 * (1..=20).map(line).sum::<f64>()
        };
        let target = |u: f64| 0.5 * u.min(72.0) - 25.0;
        let (mut place, mut rate, mut noise) =
            (target(command(0)), 0.0, 11_u64 + u64::from(record));
        let omega = std::f64::consts::TAU * 90.0;
        for k in 0..3000 {
            let (t, u) = (1e-3 * f64::from(k), command(k));
            let off = 0.01 * white(&mut noise);
            csv.push_str(&format!("{t},{u},{}\n", place + off));
            for _ in 0..50 {
                place += 1e-5 * rate;
                rate += 2e-5 * (omega * omega * (target(u) - place) - 0.08 * omega * rate);
                place += 1e-5 * rate;
            }
        }
        let name = format!("{record}.csv");
        fs::write(at.join(&name), csv).expect("a log");
        logs.extend(["--log".to_owned(), name]);
    }
    let mut call = vec!["diagnose", "--input", "u", "--output", "y"];
    call.extend(logs.iter().map(String::as_str));
    let gap = common::json(&call, at);
    let names: Vec<_> = gap["effects"].as_array().expect("a list").iter().collect();
    assert!(names.len() == 1 && names[0]["effect"] == "amplifier_saturation", "{gap:#}");
    assert!(gap["baseline"][0]["structure"].as_str().expect("parts").contains("mode"), "{gap:#}");
}
