//! Truths that are known: simulated, disturbed by noise, identified.

#![allow(clippy::print_stdout, reason = "figures and seeds are shown with --nocapture")]

use crate::common::target;
use components::COMPONENTS;
use data::{AxisBlueprint, Blueprint, CheckedBlueprint, ComponentBlueprint};
use identify::{
    Columns, Dynamics, Identification, Record, Settings, Silent, Verdict, identify, simulate,
};
use model::Kind;
use numerics::random::SplitMix64;

const R: [f64; 10] = [0.0, 6.0, 12.0, 18.0, 24.0, 30.0, 36.0, 42.0, 48.0, 54.0];
const W: [f64; 10] = [0.01354, 0.0279, 0.002, 0.004014, 0.007765, 0.001, 0.0, 0.0015, 0.0, 0.0005];

fn truth(
    step: f64,
    delay: Option<f64>,
    parts: [Option<ComponentBlueprint>; 2],
) -> CheckedBlueprint {
    let [before, after] = parts;
    let mut axis = AxisBlueprint::new("Y", "V", "um");
    axis.components = delay
        .map(|d| ComponentBlueprint::new("delay").value("delay", d))
        .into_iter()
        .chain(before)
        .chain([ComponentBlueprint::new("prandtl-ishlinskii")
            .value("r", R)
            .value("w", W)
            .value("offset", -0.7)])
        .chain(after)
        .collect();
    let blueprint = Blueprint::new(Kind::Plant, "truth", step).axis(axis);
    blueprint.check(COMPONENTS).unwrap_or_else(|e| panic!("{e}"))
}

fn mode(frequency: f64, damping: f64) -> Option<ComponentBlueprint> {
    let mode = ComponentBlueprint::new("mode");
    Some(mode.value("frequency", frequency).value("damping", damping))
}

fn lag(bandwidth: f64) -> Option<ComponentBlueprint> {
    Some(ComponentBlueprint::new("amplifier-lag").value("bandwidth", bandwidth))
}

fn log(truth: &CheckedBlueprint, period: f64, input: &[f64], noise: f64, seed: u64) -> Record {
    let time: Vec<f64> = (0..input.len()).map(|k| k as f64 * period).collect();
    let clean = vec![0.0; input.len()];
    let columns = |output| Columns {
        name: "simulated",
        time: &time,
        input_name: "u",
        input,
        output_name: "y",
        output,
    };
    let record = Record::new(columns(&clean)).unwrap_or_else(|e| panic!("{e:?}"));
    let mut output = simulate(truth, &record).unwrap_or_else(|e| panic!("{e}"));
    let mut random = SplitMix64::new(seed);
    for y in &mut output {
        *y += noise * random.normal();
    }
    Record::new(columns(&output)).unwrap_or_else(|e| panic!("{e:?}"))
}

fn identified(record: Record, settings: &Settings) -> Identification {
    let found = identify(&[record], &target("found"), settings, &mut Silent);
    found.unwrap_or_else(|e| panic!("{e}"))
}

/// A slow wave through the whole range with shrinking inner loops.
fn slow(count: usize, seconds: f64, period: f64) -> Vec<f64> {
    (0..count)
        .map(|k| {
            let t = k as f64 * period / seconds;
            60.0 + 60.0 * (20.0 * t).sin() * (3.0 * t).cos()
        })
        .collect()
}

/// A slow wave of 80 V and a multisine from 20 to 900 Hz on top.
fn multisine(count: usize, period: f64, seed: u64) -> Vec<f64> {
    let mut random = SplitMix64::new(seed);
    let lines: Vec<(f64, f64)> = (1..=45)
        .map(|k| (20.0 * f64::from(k), core::f64::consts::TAU * random.uniform()))
        .collect();
    (0..count)
        .map(|k| {
            let t = k as f64 * period;
            let wave: f64 =
                lines.iter().map(|(f, phase)| (core::f64::consts::TAU * f * t + phase).sin()).sum();
            60.0 - 40.0 * (core::f64::consts::TAU * 5.0 * t).cos() + 2.0 * wave
        })
        .collect()
}

fn weights(found: &Identification) -> Vec<f64> {
    let name = |p: &&identify::Estimate| p.name.starts_with("hysteresis.w");
    found.parameters.iter().filter(name).map(|p| p.value).collect()
}

fn value(found: &Identification, name: &str) -> (f64, f64) {
    let estimate = found.parameters.iter().find(|p| p.name == name);
    let estimate = estimate.unwrap_or_else(|| panic!("no {name}: {:?}", found.candidates));
    (estimate.value, estimate.deviation.unwrap_or(f64::NAN))
}

fn print(seed: u64, found: &Identification) {
    println!("seed {seed}");
    for c in &found.candidates {
        println!(
            "  {} {}: {:?} um, {}",
            if c.accepted { "*" } else { " " },
            c.structure,
            c.held_out_rmse,
            c.reason
        );
    }
    for p in &found.parameters {
        println!(
            "    {} = {:.6e} {} +- {:?} ({:?})",
            p.name, p.value, p.unit, p.deviation, p.verdict
        );
    }
}

fn with_thresholds() -> Settings {
    Settings { thresholds: Some(R.to_vec()), ..Settings::default() }
}

#[test]
fn weights_offset_and_delay_are_recovered_under_noise() {
    for seed in [11, 12, 13] {
        let truth = truth(1e-3, Some(2.6e-3), [None, None]);
        let record = log(&truth, 1e-3, &slow(6000, 1.0, 1e-3), 0.01, seed);
        let found = identified(record, &with_thresholds());
        print(seed, &found);
        for (w, truth) in weights(&found).iter().zip(W) {
            assert!((w - truth).abs() < 5e-4, "seed {seed}: {w} for {truth} um/V");
        }
        let (delay, deviation) = value(&found, "delay.delay");
        assert!(
            (delay - 2.6e-3).abs() < 4.0 * deviation.max(2e-6),
            "seed {seed}: {delay} {deviation}"
        );
        let offset = found.plant.parameter(1, "hysteresis", "offset").map(|o| o[0]);
        assert!((offset.unwrap_or(f64::NAN) + 0.7).abs() < 0.02, "seed {seed}: {offset:?}");
        let rmse = found.records[0].held_out.rmse;
        assert!(
            (rmse / 0.01 - 1.0).abs() < 0.1,
            "seed {seed}: the noise of 0.01 um is left: {rmse}"
        );
        let accepted: Vec<_> = found.candidates.iter().filter(|c| c.accepted).collect();
        assert_eq!(accepted.len(), 1);
        assert_eq!(accepted[0].structure, "delay, prandtl-ishlinskii", "seed {seed}");
    }
}

#[test]
fn without_noise_the_truth_comes_back_to_rounding() {
    let truth = truth(1e-3, Some(2e-3), [None, None]);
    let record = log(&truth, 1e-3, &slow(6000, 1.0, 1e-3), 0.0, 1);
    let found = identified(record, &with_thresholds());
    for (w, truth) in weights(&found).iter().zip(W) {
        assert!((w - truth).abs() < 1e-6, "{w} for {truth} um/V");
    }
    let (delay, _) = value(&found, "delay.delay");
    assert!((delay - 2e-3).abs() < 1e-6, "{delay}");
}

#[test]
fn a_mode_is_found_with_its_frequency_damping_and_the_weights() {
    for (seed, damping) in [(21, 0.02), (22, 0.05)] {
        let truth = truth(5e-5, Some(6e-5), [None, mode(482.6, damping)]);
        let record = log(&truth, 5e-5, &multisine(16_000, 5e-5, seed), 0.003, seed);
        let settings = Settings { drop: 0.05, ..with_thresholds() };
        let found = identified(record, &settings);
        print(seed, &found);
        let (frequency, _) = value(&found, "mode.frequency");
        assert!((frequency / 482.6 - 1.0).abs() < 1e-3, "seed {seed}: {frequency} Hz");
        let (zeta, _) = value(&found, "mode.damping");
        assert!((zeta / damping - 1.0).abs() < 0.02, "seed {seed}: damping {zeta}");
        for (w, truth) in weights(&found).iter().zip(W) {
            assert!((w - truth).abs() < 5e-4, "seed {seed}: {w} for {truth} um/V");
        }
        assert!(found.records[0].held_out.nrmse < 0.002, "seed {seed}");
        assert!(found.candidates.iter().any(|c| c.accepted && !c.structure.contains("lag")));
    }
}

#[test]
fn an_amplifier_lag_is_found_with_its_bandwidth() {
    let truth = truth(5e-5, None, [lag(270.0), None]);
    let record = log(&truth, 5e-5, &multisine(16_000, 5e-5, 31), 0.003, 31);
    let found = identified(record, &Settings { drop: 0.05, ..with_thresholds() });
    print(31, &found);
    let (bandwidth, _) = value(&found, "amplifier.bandwidth");
    assert!((bandwidth / 270.0 - 1.0).abs() < 0.01, "{bandwidth} Hz");
    assert!(found.candidates.iter().any(|c| c.accepted && !c.structure.contains("mode")));
}

#[test]
fn plays_beyond_the_range_of_the_record_are_named_as_not_excited() {
    let truth = truth(1e-3, None, [None, None]);
    let input: Vec<f64> = (0..4000).map(|k| 60.0 + 20.0 * (0.01 * f64::from(k)).sin()).collect();
    let record = log(&truth, 1e-3, &input, 0.002, 41);
    let settings = Settings { dynamics: Dynamics::Static, drop: 1.3, ..with_thresholds() };
    let found = identified(record, &settings);
    let silent: Vec<&str> = found
        .parameters
        .iter()
        .filter(|p| p.verdict == Verdict::NotExcited)
        .map(|p| p.name.as_str())
        .collect();
    assert_eq!(silent.first(), Some(&"hysteresis.w[5]"), "24 V is beyond a half range of 20 V");
    assert_eq!(silent.len(), 6);
}

#[test]
fn lag_and_mode_are_found_together_and_the_plant_agrees_with_the_fit() {
    let truth = truth(5e-5, Some(6e-5), [lag(900.0), mode(482.6, 0.05)]);
    let record = log(&truth, 5e-5, &multisine(16_000, 5e-5, 51), 0.001, 51);
    let found = identified(record, &Settings { drop: 0.02, ..with_thresholds() });
    print(51, &found);
    let (bandwidth, _) = value(&found, "amplifier.bandwidth");
    assert!((bandwidth / 900.0 - 1.0).abs() < 0.01, "{bandwidth} Hz");
    let (frequency, _) = value(&found, "mode.frequency");
    assert!((frequency / 482.6 - 1.0).abs() < 1e-3, "{frequency} Hz");
    let (delay, _) = value(&found, "delay.delay");
    assert!((delay - 6e-5).abs() < 2e-6, "{delay} s");
    // The offset of the plant is that of the rows fitted on: to rounding nothing is left of it.
    let fit = &found.records[0];
    assert!(fit.fitted.offset.abs() < 1e-9 * fit.fitted.range, "{:?}", fit.fitted);
    assert!((fit.held_out.rmse / 0.001 - 1.0).abs() < 0.1, "{:?}", fit.held_out);
}

fn refused(input: &[f64], output: &[f64], settings: &Settings) -> String {
    let time: Vec<f64> = (0..input.len()).map(|k| k as f64 * 1e-3).collect();
    let record = Record::new(Columns {
        name: "bad.csv",
        time: &time,
        input_name: "u",
        input,
        output_name: "y",
        output,
    });
    let record = record.unwrap_or_else(|e| panic!("{e:?}"));
    let found = identify(&[record], &target("found"), settings, &mut Silent);
    found.map(|_| ()).expect_err("refused").to_string()
}

#[test]
fn logs_that_cannot_be_identified_from_are_refused_with_the_way_out() {
    let wave: Vec<f64> = (0..1000).map(|k| (0.05 * f64::from(k)).sin()).collect();
    let settings = Settings::default();
    let text = refused(&[1.5; 1000], &wave, &settings);
    assert!(text.contains("\"u\" is 1.5") && text.contains("drive the axis"), "{text}");
    let falling: Vec<f64> = wave.iter().map(|u| -2.0 * u).collect();
    let text = refused(&wave, &falling, &settings);
    assert!(text.contains("change the sign"), "{text}");
    let text = refused(&wave[..200], &wave[..200], &settings);
    assert!(text.contains("100 samples to fit on, but 150 are needed"), "{text}");
    let late = Settings { drop: 5.0, hold_out: 1.0, plays: 0, ..Settings::default() };
    let text = refused(&wave, &wave, &late);
    assert!(text.contains("plays = 0") && text.contains("hold_out = 1"), "{text}");
    let text = refused(&wave, &wave, &Settings { drop: 5.0, ..Settings::default() });
    assert!(text.contains("0 samples to fit on") && text.contains("drop less"), "{text}");
}
