//! The next experiment: what several names leave open, one record more decides.

#![allow(clippy::print_stderr, reason = "what a failed run was")]

use crate::common::diagnose_machine;
use crate::common::machine::{Machine, RATE};
use crate::common::truth::Effect;
use data::Log;

/// The command of a log.
fn command(log: &Log) -> &[f64] {
    &log.column("u").unwrap().values
}

/// Triangles of this frequency between 10 and 110 V.
fn triangle(hz: f64, rows: usize) -> Vec<f64> {
    let wave = |k: usize| 4.0 * ((k as f64 / RATE * hz + 0.75).fract() - 0.5).abs() - 1.0;
    (0..rows).map(|k| 60.0 + 50.0 * wave(k)).collect()
}

/// A predicted gain in noise variances that separates two names in logs of some ten thousand rows.
const SURE: f64 = 500.0;

/// Steepest change per row.
fn steepest(u: &[f64]) -> f64 {
    u.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max)
}

#[test]
fn a_rival_that_an_experiment_separates_is_gone_after_it() {
    let mut separated = 0;
    for (seed, effect, name) in [
        (51, Effect::AmplifierBandwidth, "amplifier_bandwidth"),
        (54, Effect::SensorBandwidth, "sensor_bandwidth"),
    ] {
        eprintln!("seed {seed}, {name}");
        let machine = Machine::new(seed, 0.5).with(effect, 12.0);
        let first = triangle(20.0, 1600);
        let mut logs = vec![machine.log(0, &first)];
        let mut gap = diagnose_machine(&machine, logs.clone(), &[]);
        eprintln!("  {}", gap.sentence);
        for number in 1..=2 {
            let Some(next) = gap.next_experiment.clone() else { break };
            eprintln!("  {}", next.sentence);
            let u = &next.columns["u"];
            let is_within = u.iter().all(|u| (10.0 - 1e-9..=110.0 + 1e-9).contains(u));
            assert!(is_within, "within the range of the logs");
            let times = steepest(u) / logs.iter().map(|l| steepest(command(l))).fold(0.0, f64::max);
            let is_stated = next.sentence.contains(&format!("up to {times:.1} times as steep"));
            assert!(
                times < 1.005 || (is_stated && times <= 10.0 + 1e-9),
                "{times}: {}",
                next.sentence
            );
            logs.push(machine.log(number, u));
            gap = diagnose_machine(&machine, logs.clone(), &[]);
            eprintln!("  {}", gap.sentence);
            if next.predicted_gain > Some(SURE) {
                separated += 1;
                let set = &gap.effects[0].set;
                let has_both = next.separates.iter().all(|name| set.contains(name));
                assert!(!has_both, "{set:?} after {:?}", next.separates);
            }
        }
        assert!(gap.effects[0].set.iter().any(|other| other == name), "{}", gap.sentence);
    }
    assert!(separated >= 2, "{separated}");
}

#[test]
fn a_resonance_far_from_where_it_was_is_found_under_a_strong_harmonic() {
    // The third harmonic of the triangle lies above the mode of the model, the machine's mode below it.
    let machine = Machine { frequency: 281.0, ..Machine::new(55, 0.5) };
    let u = triangle(97.0, 6400);
    let gap = diagnose_machine(&machine, vec![machine.log(0, &u)], &[]);
    assert_eq!(gap.effects[0].effect, "resonance_shift", "{}", gap.sentence);
}

#[test]
fn a_resonance_far_from_the_models_is_no_further_mode() {
    for frequency in [0.5, 0.7, 1.6] {
        let own = Machine::new(56, 0.5).frequency;
        let machine = Machine { frequency: frequency * own, ..Machine::new(56, 0.5) };
        let gap = diagnose_machine(&machine, vec![machine.log(0, &triangle(17.0, 6400))], &[]);
        let names: Vec<&str> = gap.effects.iter().map(|e| e.effect.as_str()).collect();
        assert_eq!(names, ["resonance_shift"], "{frequency}: {}", gap.sentence);
    }
}
