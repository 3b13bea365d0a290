//! `piezoloop frequency-response`: modes, coherence and distortion of machines that are known.
#![allow(clippy::print_stdout)]

mod common;

use std::fs;
use std::path::Path;

use common::{json, refuse, succeed};

/// A mode at 200 Hz with damping 0.1, and a sensor that is curved by this part of its half range.
fn plant(quadratic: f64) -> String {
    format!(
        r#"piezoloop = 1
kind = "plant"
name = "known"
step = 1e-4

[[axis]]
name = "x"
command = {{ name = "u", unit = "V", min = 0, max = 100, start = 50 }}
position = {{ name = "y", unit = "um" }}

[[axis.component]]
type = "actuator-gain"
gain = 0.2

[[axis.component]]
type = "mode"
frequency = 200
damping = 0.1

[[axis.component]]
type = "sensor-polynomial"
quadratic = {quadratic}
centre = 10
half_range = 10
"#
    )
}

/// Plays 3 periods of an odd random-phase multisine on a plant, as `log.csv`; 30 of its lines lie within the
/// half-power width of the mode.
fn measure(at: &Path, quadratic: f64) {
    fs::write(at.join("plant.toml"), plant(quadratic)).expect("a file");
    let signal = [
        "signal",
        "multisine-odd-random",
        "--set",
        "periods=3",
        "--set",
        "samples_per_period=16000",
        "--set",
        "highest_frequency=600",
        "-o",
        "u.csv",
    ];
    succeed(&signal, at);
    let run =
        ["simulate", "plant.toml", "--log", "u.csv", "--map", "command[1]=u", "-o", "log.csv"];
    succeed(&run, at);
}

const COLUMNS: [&str; 6] =
    ["frequency-response", "log.csv", "--input", "command[1]", "--output", "position[1]"];

#[test]
fn a_known_mode_and_a_known_curvature_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut even = Vec::new();
    for quadratic in [0.0, 0.02] {
        measure(at, quadratic);
        let more = ["--skip", "1.6", "--modes", "2", "-o", "response.csv", "--report", "page.html"];
        let answer = json(&[&COLUMNS[..], &more].concat(), at);
        assert_eq!(answer["period_samples"], 16000, "{answer}");
        assert_eq!(answer["periods"], 2, "{answer}");
        let levels = &answer["levels"][0];
        println!("curvature {quadratic}: {levels} {}", answer["fit"]);
        even.push((levels["even"].as_f64().expect("even"), levels["odd"].as_f64().expect("odd")));
        let modes = answer["fit"]["modes"].as_array().expect("modes");
        let found = |name: &str| {
            let values = modes.iter().map(|mode| mode[name].as_f64().expect("a number"));
            values.collect::<Vec<f64>>()
        };
        let nearest = found("frequency").iter().position(|f| (f / 200.0 - 1.0).abs() < 5e-5);
        let at_mode = nearest.unwrap_or_else(|| panic!("no mode at 200 Hz: {modes:?}"));
        assert!((found("damping")[at_mode] / 0.1 - 1.0).abs() < 1e-4, "{modes:?}");
        let gain = answer["fit"]["static_gain"][0][0].as_f64().expect("a gain");
        assert!((gain / 0.2 - 1.0).abs() < 1e-4, "{gain}");
    }
    // A square makes lines at sums and differences of odd ones: even ones. The linear machine makes none.
    let [(linear, _), (curved, odd)] = even[..] else { panic!("two machines") };
    assert!(curved > 1000.0 * linear && curved > 100.0 * odd, "{even:?}");

    // The table holds the response: ten lines beside the closed form of the mode and the hold.
    let mut table = csv::Reader::from_path(at.join("response.csv")).expect("a table");
    let head: Vec<String> = table.headers().expect("a head").iter().map(str::to_owned).collect();
    assert_eq!(head[1], "magnitude position[1]/command[1] [um/V]", "{head:?}");
    let mut compared = 0;
    for row in table.records() {
        let row = row.expect("a row");
        let number = |k: usize| -> f64 { row[k].parse().expect("a number") };
        let (f, magnitude) = (number(0), number(1));
        let r = f / 200.0;
        let exact = 0.2 / (1.0 - r * r).hypot(0.2 * r);
        // The hold takes sinc(f·T): 0.6 % at 600 Hz.
        if f < 600.0 {
            assert!((magnitude / exact - 1.0).abs() < 0.01, "{f} Hz: {magnitude} for {exact}");
            compared += 1;
        }
    }
    assert!(compared > 50, "{compared} lines");
    let page = fs::read_to_string(at.join("page.html")).expect("a page");
    assert!(page.contains("Fitted modes") && page.contains("even lines"));
}

/// Two axes that couple through their modes, moved by random-phase multisines of 3 periods in two records, as
/// `mirror.csv`.
fn measure_mirror(at: &Path) {
    let axis = |name: &str, gain: f64, frequency: f64, damping: f64| {
        format!(
            "[[axis]]\nname = \"{name}\"\ncommand = {{ name = \"u{name}\", unit = \"V\" }}\nposition = {{ \
             name = \"{name}\", unit = \"um\" }}\n\n[[axis.component]]\ntype = \"actuator-gain\"\ngain = {gain}\n\n\
             [[axis.component]]\ntype = \"mode\"\nfrequency = {frequency}\ndamping = {damping}\n\n"
        )
    };
    let text = format!(
        "piezoloop = 1\nkind = \"plant\"\nname = \"mirror\"\nstep = 1e-3\n\n{}{}[[coupling]]\ntype = \
         \"displacement-coupling\"\naxes = [\"x\", \"y\"]\nmatrix = [[0, 0.4], [-0.3, 0]]\n",
        axis("x", -2.0, 90.0, 0.02),
        axis("y", 3.0, 210.0, 0.05)
    );
    fs::write(at.join("mirror-truth.toml"), text).expect("a file");
    const PERIOD: usize = 1000;
    let mut state = 5u64;
    let mut phase = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        std::f64::consts::TAU * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut multisine = || -> Vec<f64> {
        let phases: Vec<f64> = (1..450).map(|_| phase()).collect();
        let at = |n: usize| {
            let angle =
                |k: usize| std::f64::consts::TAU * ((n * k) % PERIOD) as f64 / PERIOD as f64;
            (1..450).map(|k| (angle(k) + phases[k - 1]).cos()).sum::<f64>() / 15.0
        };
        (0..PERIOD).map(at).collect()
    };
    let mut rows = String::from("record,time,ux,uy\n");
    for record in 0..2 {
        let (x, y) = (multisine(), multisine());
        for n in 0..3 * PERIOD {
            rows += &format!("{record},{},{},{}\n", n as f64 * 1e-3, x[n % PERIOD], y[n % PERIOD]);
        }
    }
    fs::write(at.join("u.csv"), rows).expect("a log");
    let run = ["simulate", "mirror-truth.toml", "--log", "u.csv", "--map", "command[1]=ux"];
    succeed(&[&run[..], &["--map", "command[2]=uy", "-o", "mirror.csv"]].concat(), at);
}

#[test]
fn two_axes_that_couple_become_a_plant_that_moves_as_they_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    measure_mirror(at);
    let columns = [
        "frequency-response",
        "mirror.csv",
        "--input",
        "command[1]",
        "--input",
        "command[2]",
        "--output",
        "position[1]",
        "--output",
        "position[2]",
        "--modes",
        "4",
    ];
    let more = ["--skip", "1", "--plant", "found.toml", "--report", "page.html"];
    let answer = json(&[&columns[..], &more].concat(), at);
    println!("{}", answer["plant"]);
    let errors = answer["plant"]["errors"].as_array().expect("errors");
    assert_eq!(errors.len(), 4, "two records of two outputs");
    for error in errors {
        assert!(error["relative"].as_f64().expect("a number") < 1e-3, "{error}");
        assert_eq!(error["from_row"], 1001);
    }
    let modes: Vec<f64> = answer["fit"]["modes"]
        .as_array()
        .expect("modes")
        .iter()
        .map(|mode| mode["frequency"].as_f64().expect("a frequency"))
        .collect();
    for truth in [90.0, 210.0] {
        assert!(modes.iter().any(|f| (f / truth - 1.0).abs() < 1e-4), "{modes:?}");
    }
    // −2, 0.4·3; −0.3·(−2), 3
    for (i, row) in [[-2.0, 1.2], [0.6, 3.0]].iter().enumerate() {
        for (j, truth) in row.iter().enumerate() {
            let gain = answer["fit"]["static_gain"][i][j].as_f64().expect("a gain");
            assert!((gain / truth - 1.0).abs() < 1e-3, "{i} {j}: {gain}");
        }
    }
    // As any plant: packed, and moved by the log again.
    succeed(&["pack", "found.toml", "-o", "found.fmu"], at);
    let again = json(&["simulate", "found.fmu", "--log", "mirror.csv", "-o", "again.csv"], at);
    let fits = again["fits"].as_array().expect("fits");
    assert_eq!(fits.len(), 4, "{again}");
    for fit in fits {
        assert!(fit["nrmse_percent"].as_f64().expect("a number") < 0.01, "{fit}");
    }
    assert!(fs::read_to_string(at.join("page.html")).expect("a page").contains("The plant"));

    let error = refuse(&[&columns[..8], &["--plant", "other.toml"]].concat(), at);
    assert!(error.contains("2 inputs and 1 outputs") && !at.join("other.toml").exists(), "{error}");
    let error = refuse(&[&columns[..], &["--plant", "mirror.csv"]].concat(), at);
    assert!(error.contains("mirror.csv") && error.contains("named twice in this call"), "{error}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    measure(at, 0.0);
    let with = |more: &[&str], said: &[&str]| {
        let error = refuse(&[&COLUMNS[..], more].concat(), at);
        for part in said {
            assert!(error.contains(part), "{more:?}: {error}");
        }
    };
    with(&["--skip", "9"], &["--skip 9", "record 0", "s long"]);
    with(&["--skip", "-1"], &["'-1' for '--skip", "give 0 to"]);
    with(&["--output", "nothing"], &["log.csv", "nothing"]);
    with(&["-o", "log.csv"], &["log.csv", "named twice in this call"]);
    // Another sample time in a second log.
    let other = ["signal", "multisine-odd-random", "--set", "sample_time=2e-4", "-o", "other.csv"];
    succeed(&other, at);
    // Its units are of other columns.
    fs::remove_file(at.join("other.dataset.toml")).expect("a sidecar");
    let text = fs::read_to_string(at.join("other.csv")).expect("a log");
    let text = text.replacen("u", "command[1]", 1);
    let head = text.lines().next().expect("a head").to_owned() + ",position[1]";
    let rows = text.lines().skip(1).map(|row| format!("{row},0\n")).collect::<String>();
    fs::write(at.join("other.csv"), format!("{head}\n{rows}")).expect("a log");
    with(&["other.csv"], &["other.csv, record 0", "0.0002 s", "one sample time"]);
}
