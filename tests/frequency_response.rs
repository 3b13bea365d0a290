//! `piezoloop frequency-response`: modes, coherence and distortion of machines that are known.

use crate::common;

use std::fs;
use std::path::Path;

use common::random::Random;
use common::{json, piezoloop, refuse, succeed};

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

#[test]
fn a_plant_of_one_axis_is_diagnosed_as_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let noise = "\n[[axis.component]]\ntype = \"sensor-noise\"\nrms = 0.01\nseed = 1\n";
    fs::write(at.join("truth.toml"), plant(0.0) + noise).expect("a file");
    let signal =
        ["signal", "multisine-odd-random", "--set", "highest_frequency=600", "-o", "u.csv"];
    succeed(&signal, at);
    let run =
        ["simulate", "truth.toml", "--log", "u.csv", "--map", "command[1]=u", "-o", "log.csv"];
    succeed(&run, at);
    let more = ["--period", "4000", "--skip", "0.4", "--modes", "2", "--plant", "found.toml"];
    succeed(&[&COLUMNS[..], &more].concat(), at);
    let found = fs::read_to_string(at.join("found.toml")).expect("a plant");
    assert!(found.contains("[[coupling]]") && found.contains("modal-matrix"), "{found}");

    // An identified plant is not exact to the noise, which is a twentieth of a percent of the range.
    let call = [
        "diagnose",
        "--model",
        "found.toml",
        "--log",
        "log.csv",
        "--drop",
        "0.1",
        "--accuracy",
        "1e-3",
    ];
    let gap = json(&[&call[..], &["--fail-above", "0.01"]].concat(), at);
    assert_eq!(gap["verdict"], "adequate", "{gap}");
    let warnings = gap["warnings"].to_string();
    assert!(!warnings.contains("couples its axes") && !warnings.contains("FMU"), "{warnings}");
    let fails = piezoloop(&[&call[..], &["--fail-above", "1e-5"]].concat(), at);
    let message = String::from_utf8_lossy(&fails.stderr);
    assert_eq!(fails.status.code(), Some(1), "{message}");
    assert!(!message.contains("couples its axes"), "{message}");
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
    let mut random = Random::new(5);
    let mut phase = || random.between(0.0, std::f64::consts::TAU);
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
    assert!(
        error.contains("mirror.csv") && error.contains("this command already uses the file"),
        "{error}"
    );
}

/// A mode that softens with the square root of the amplitude, moved by one multisine at these amplitudes.
fn measure_softening(at: &Path, amplitudes: &[f64]) {
    let text = "piezoloop = 1\nkind = \"plant\"\nname = \"soft\"\nstep = 1e-3\n\n[[axis]]\nname = \"x\"\n\
                command = { name = \"u\", unit = \"V\" }\nposition = { name = \"x\", unit = \"um\" }\n\n\
                [[axis.component]]\ntype = \"actuator-gain\"\ngain = -2\n\n[[coupling]]\ntype = \
                \"softening-modes\"\naxes = [\"x\"]\ndirect = [[0.1]]\nfrequency = [90, 210]\ndamping = \
                [0.02, 0.05]\nfrequency_shift = [-0.04, -0.02]\ndamping_growth = [0.5, 0.0]\nresidue = [[0.6], \
                [0.3]]\nrate_residue = [[0.0], [0.1]]\namplitude = [4]\nexponent = 0.5\ntime_constant = 0.2\n";
    fs::write(at.join("soft-truth.toml"), text).expect("a file");
    const PERIOD: usize = 1000;
    let sine = |n: usize, k: usize| {
        let angle = std::f64::consts::TAU * ((n * k) % PERIOD) as f64 / PERIOD as f64;
        (angle + (k * k % 997) as f64).cos()
    };
    let signal: Vec<f64> =
        (0..PERIOD).map(|n| (1..450).map(|k| sine(n, k)).sum::<f64>() / 15.0).collect();
    let mut rows = String::from("record,time,u\n");
    for (record, amplitude) in amplitudes.iter().enumerate() {
        for n in 0..6 * PERIOD {
            rows += &format!("{record},{},{}\n", n as f64 * 1e-3, amplitude * signal[n % PERIOD]);
        }
    }
    fs::write(at.join("u.csv"), rows).expect("a log");
    let run = ["simulate", "soft-truth.toml", "--log", "u.csv", "--map", "command[1]=u"];
    succeed(&[&run[..], &["-o", "soft.csv"]].concat(), at);
}

#[test]
fn modes_that_follow_the_amplitude_are_found_from_records_of_several_levels() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    measure_softening(at, &[0.5, 1.0, 2.0]);
    let call =
        ["frequency-response", "soft.csv", "--input", "command[1]", "--output", "position[1]"];
    let more = ["--skip", "2", "--modes", "3", "--plant", "found.toml", "--softening"];
    let answer = json(&[&call[..], &more].concat(), at);
    let softening = &answer["plant"]["softening"];
    println!("{softening}");
    assert_eq!(softening["exponent"], 0.5, "{softening}");
    let levels = softening["levels"].as_array().expect("levels");
    assert_eq!(levels.len(), 3, "{softening}");
    // The changes are those at the greatest level: 2 V of rms 1 by 2 um/V, relative to 4 um.
    let rms = levels[2]["rms"][0].as_f64().expect("an rms");
    let top = (2.0 * rms / 4.0).sqrt();
    let modes = softening["modes"].as_array().expect("modes");
    for (f, d, shift, growth) in [(90.0, 0.02, -0.04, 0.5), (210.0, 0.05, -0.02, 0.0)] {
        let near = |mode: &&serde_json::Value| {
            (mode["frequency"].as_f64().expect("a frequency") / f - 1.0).abs() < 2e-3
        };
        let mode = modes.iter().find(near).unwrap_or_else(|| panic!("{f}: {softening}"));
        let value = |name: &str| mode[name].as_f64().expect("a number");
        assert!((value("frequency_shift") / (shift * top) - 1.0).abs() < 0.05, "{mode}");
        assert!((value("damping") / d - 1.0).abs() < 0.05, "{mode}");
        assert!((value("damping_growth") - growth * top).abs() < 0.05, "{mode}");
    }
    for error in answer["plant"]["errors"].as_array().expect("errors") {
        assert!(error["relative"].as_f64().expect("a number") < 0.02, "{error}");
    }
    // A linear plant of all levels is far off.
    let linear = json(&[&call[..], &more[..4], &["--plant", "linear.toml"]].concat(), at);
    let worst = linear["plant"]["errors"].as_array().expect("errors").iter();
    let worst = worst.map(|e| e["relative"].as_f64().expect("a number")).fold(0.0, f64::max);
    assert!(worst > 0.1, "{worst}");

    succeed(&["pack", "found.toml", "-o", "found.fmu"], at);
    let again = json(&["simulate", "found.fmu", "--log", "soft.csv", "-o", "again.csv"], at);
    for fit in again["fits"].as_array().expect("fits") {
        assert!(fit["nrmse_percent"].as_f64().expect("a number") < 1.0, "{fit}");
    }

    measure_softening(at, &[1.0, 1.1]);
    let error = refuse(&[&call[..], &more].concat(), at);
    assert!(error.contains("--softening") && error.contains("20 %"), "{error}");
    let error = refuse(&[&call[..], &["--softening"]].concat(), at);
    assert!(error.contains("--plant"), "{error}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    measure(at, 0.0);
    let with = |more: &[&str], message: &[&str]| {
        let error = refuse(&[&COLUMNS[..], more].concat(), at);
        for part in message {
            assert!(error.contains(part), "{more:?}: {error}");
        }
    };
    with(&["--skip", "9"], &["--skip 9", "record 0", "s long"]);
    with(&["--skip", "-1"], &["'-1' for '--skip", "must be 0 to"]);
    with(&["--output", "nothing"], &["log.csv", "nothing"]);
    with(&["-o", "log.csv"], &["log.csv", "this command already uses the file"]);
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
