//! A spring that hardens behind an actuator whose gain is off, in logs that begin while it moves: the equation of
//! motion in short steps, which nothing of the diagnosis shares.

use std::f64::consts::TAU;

use crate::common::machine::Normal;
use components::COMPONENTS;
use data::{Blueprint, Log};
use diagnose::{Model, Request, Silent, diagnose, examine};

const RATE: f64 = 1000.0;
const FREQUENCY: f64 = 60.0;
const DAMPING: f64 = 0.05;
/// Of the actuator, over the model's.
const GAIN: f64 = 1.02;
/// x″ + 2ζω x′ + ω²·x·(1 + CUBIC·x²) = ω²·GAIN·u.
const CUBIC: f64 = 0.08;
const SIGMA: f64 = 1e-3;
const SEED: u64 = 77;

/// Rows of a log that begins `skipped` rows after the machine did.
fn log(name: &str, seed: u64, (skipped, rows): (usize, usize)) -> Log {
    let mut random = Normal::new(seed);
    let (omega, parts) = (TAU * FREQUENCY, 50);
    let h = 1.0 / RATE / f64::from(parts);
    let (mut x, mut v, mut u) = (0.0_f64, 0.0_f64, 0.0);
    let (mut command, mut position) = (Vec::new(), Vec::new());
    for k in 0..skipped + rows {
        if k % 4 == 0 {
            u = if k < (skipped / 2).max(100) { 0.0 } else { 0.7 * u + 0.4 * random.draw() };
        }
        command.push(u);
        position.push(x + SIGMA * random.draw());
        let force = |x: f64, v: f64| {
            omega * omega * (GAIN * u - x * (1.0 + CUBIC * x * x)) - 2.0 * DAMPING * omega * v
        };
        for _ in 0..parts {
            // Störmer and Verlet, with the damping at the middle.
            let half = v + 0.5 * h * force(x, v);
            x += h * half;
            v = half + 0.5 * h * force(x, half);
        }
    }
    let time = (0..rows).map(|k| k as f64 / RATE).collect();
    let mut log = Log::new(name, time).unwrap();
    log.add_column("u", Some("V"), command.split_off(skipped)).unwrap();
    log.add_column("y", Some("um"), position.split_off(skipped)).unwrap();
    log
}

fn request(skipped: usize) -> Request {
    let text = format!(
        "piezoloop = 1\nkind = \"plant\"\nname = \"stage\"\nstep = {}\n[[axis]]\nname = \"X\"\n\
         command = {{ name = \"u\", unit = \"V\" }}\nposition = {{ name = \"y\", unit = \"um\" }}\n\
         [[axis.component]]\ntype = \"actuator-gain\"\ngain = 1\n\
         [[axis.component]]\ntype = \"mode\"\nname = \"mechanics\"\nfrequency = 60.3\ndamping = 0.052\n\
         tolerance = {{ frequency = 0.02, damping = 0.2 }}\n",
        1.0 / RATE
    );
    let blueprint = Blueprint::parse(&text, "stage.toml").unwrap().check(COMPONENTS).unwrap();
    let log = |name, seed| log(name, seed, (skipped, 6000));
    let mut request = Request::new(
        Model::Blueprint(Box::new(blueprint)),
        vec![log("a.csv", SEED), log("b.csv", SEED + 1)],
    );
    request.holdout = vec![log("c.csv", SEED + 2)];
    request
}

fn number(text: &str, name: &str) -> f64 {
    let rest = text.split_once(&format!("{name} = ")).expect("it is in the blueprint").1;
    rest.lines().next().unwrap().parse().unwrap()
}

#[test]
fn a_hardening_spring_is_handed_back_as_it_is() {
    let request = request(2000);
    let mut found = examine(&request, &mut Silent).unwrap();
    let gap = &found.gap;
    assert_eq!(gap.effects.len(), 1, "seed {SEED}: {}", gap.sentence);
    assert_eq!(gap.effects[0].effect, "duffing", "seed {SEED}: {}", gap.sentence);
    assert!(
        gap.warnings.iter().any(|w| w.contains("begins during a motion")),
        "{:?}",
        gap.warnings
    );
    assert!(gap.provenance.split.contains("run-in"), "{}", gap.provenance.split);
    let Model::Blueprint(given) = &request.model else { unreachable!() };
    let (repaired, _) = found.repair(given.blueprint());
    let shrink = &found.gap.shrink;
    assert!(
        shrink.rms_after < 1.1 * SIGMA,
        "seed {SEED}: {} of {}",
        shrink.rms_after,
        shrink.rms_before
    );
    let (as_found, as_written) = (shrink.as_found.unwrap(), shrink.fraction.unwrap());
    assert!((as_found - as_written).abs() < 1e-3, "seed {SEED}: {as_found} and {as_written}");
    let text = repaired.to_toml();
    assert!((number(&text, "gain") / GAIN - 1.0).abs() < 2e-3, "seed {SEED}: {text}");
    let cubic = match text.contains("hardening = ") {
        true => number(&text, "hardening") / number(&text, "reference").powi(2),
        false => number(&text, "quadratic") / number(&text, "half_range").powi(2),
    };
    assert!((cubic / CUBIC - 1.0).abs() < 0.02, "seed {SEED}: {cubic}: {text}");
}

#[test]
fn a_run_in_of_zero_uses_all_rows() {
    let mut request = request(2000);
    request.drop = Some(0.0);
    let gap = diagnose(&request, &mut Silent).unwrap();
    assert!(!gap.warnings.iter().any(|w| w.contains("motion")), "seed {SEED}: {:?}", gap.warnings);
    assert_eq!(gap.shrink.holdout[0].rows[0], 1, "seed {SEED}");
}

#[test]
fn a_log_that_begins_at_rest_has_no_run_in() {
    let gap = diagnose(&request(0), &mut Silent).unwrap();
    assert_eq!(gap.effects[0].effect, "duffing", "seed {SEED}: {}", gap.sentence);
    assert!(!gap.provenance.split.contains("run-in"), "seed {SEED}: {}", gap.provenance.split);
}
