//! Around an FMU as in a blueprint: a reading that is taken a part of a row after its command is no mode of the machine.
#![cfg(target_os = "linux")]

use crate::common;

use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;

use common::{json, succeed};

const SEED: u64 = 11;
/// Rows per second.
const RATE: f64 = 2000.0;
/// Steps of the machine from row to row.
const FINE: usize = 100;
const MODEL: &str = r#"piezoloop = 1
kind = "plant"
name = "stage"
step = 125e-6
[[axis]]
name = "X"
command = { name = "u", unit = "V", min = 0, max = 150, start = 50 }
position = { name = "y", unit = "um" }
[[axis.component]]
type = "actuator-gain"
gain = 0.505
tolerance = { gain = 0.02 }
[[axis.component]]
type = "mode"
name = "mechanics"
frequency = 179
damping = 0.052
tolerance = { frequency = 0.02, damping = 0.1 }
"#;

/// A log of a mode at 180 Hz under a held command, each reading so many hundredths of a row after the command of its row acts.
fn log(hundredths: usize) -> String {
    let mut random = numerics::random::SplitMix64::new(SEED);
    let lines: Vec<(f64, f64)> = (0..32)
        .map(|k| (0.5 * 160_f64.powf(f64::from(k) / 31.0), TAU * random.uniform()))
        .collect();
    let (w, h) = (TAU * 180.0, 1.0 / (RATE * FINE as f64));
    let (mut x, mut v) = (25.0, 0.0);
    let mut text = "time [s],u [V],y [um]\n".to_owned();
    for row in 0..6000 {
        let t = f64::from(row) / RATE;
        let sum: f64 = lines.iter().map(|(f, phase)| (TAU * f * t + phase).sin()).sum();
        let u = 50.0 + 3.5 * sum * (t / 0.3).min(1.0);
        for n in 0..FINE {
            if n == hundredths {
                let y = x + 1e-3 * random.normal();
                writeln!(text, "{t},{u},{y}").expect("text");
            }
            // Runge and Kutta's method: 1e-10 of the range off.
            let force = |x: f64, v: f64| w * w * (0.5 * u - x) - 0.1 * w * v;
            let a = (v, force(x, v));
            let b = (v + 0.5 * h * a.1, force(x + 0.5 * h * a.0, v + 0.5 * h * a.1));
            let c = (v + 0.5 * h * b.1, force(x + 0.5 * h * b.0, v + 0.5 * h * b.1));
            let d = (v + h * c.1, force(x + h * c.0, v + h * c.1));
            x += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
            v += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
        }
    }
    text
}

#[test]
fn readings_within_the_rows_are_found_around_an_fmu() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("model.toml"), MODEL).expect("written");
    succeed(&["pack", "model.toml", "-o", "model.fmu"], folder.path());
    for hundredths in [0, 8, 30] {
        fs::write(folder.path().join("log.csv"), log(hundredths)).expect("written");
        let asked = ["diagnose", "--model", "model.fmu", "--log", "log.csv", "--noise", "1e-3"];
        let gap = json(&asked, folder.path());
        assert_eq!(gap["verdict"], "retune", "seed {SEED}, {hundredths}: {}", gap["sentence"]);
        let late = gap["outputs"][0]["reading_late"].as_f64().unwrap_or(0.0);
        // Names and tolerances are those of the blueprint that the FMU carries.
        let reported = gap["warnings"].to_string();
        for words in ["whose tolerances hold for axis[1].gain.gain", "column y is position[1]"] {
            assert!(reported.contains(words), "{reported}");
        }
        let part = 100.0 * late * RATE;
        assert!((part - hundredths as f64).abs() < 0.5, "seed {SEED}, {hundredths}: {part}");
    }
}
