//! Calibrations of Jacobians whose truth is known.

use super::*;
use numerics::random::SplitMix64;

fn tunable(start: f64, scale: f64) -> Tunable {
    Tunable { start, lower: f64::NEG_INFINITY, upper: f64::INFINITY, scale }
}

/// a e^(−b t) + c at 200 instants.
fn decay(p: &[f64]) -> Vec<f64> {
    (0..200).map(|k| p[0] * (-p[1] * 0.02 * f64::from(k)).exp() + p[2]).collect()
}

#[test]
fn the_truth_lies_in_19_of_20_intervals() {
    let truth = [2.0e3, 1.5, -300.0];
    let parameters = [tunable(1e3, 1e3), tunable(1.0, 1.0), tunable(0.0, 100.0)];
    let (mut inside, mut random) = (0, SplitMix64::new(7));
    let draws = 400;
    for _ in 0..draws {
        let measured: Vec<f64> = decay(&truth).iter().map(|y| y + 40.0 * random.normal()).collect();
        let residuals =
            |p: &[f64]| Some(decay(p).iter().zip(&measured).map(|(s, y)| s - y).collect());
        let found = calibrate(&parameters, &[], &[200], residuals).unwrap();
        for ((value, half), truth) in found.values.iter().zip(&found.half_width).zip(truth) {
            inside += usize::from((value - truth).abs() <= half.unwrap());
        }
        assert!(found.undetermined.is_empty());
    }
    let share = inside as f64 / (3 * draws) as f64;
    assert!((0.93..=0.97).contains(&share), "{share} (seed 7)");
}

#[test]
fn correlated_residuals_widen_the_intervals() {
    let (mut random, mut noise) = (SplitMix64::new(3), 0.0);
    let coloured: Vec<f64> = (0..4000)
        .map(|_| {
            noise = 0.9 * noise + random.normal();
            noise
        })
        .collect();
    // (1 + 0.9) / (1 − 0.9) of an autoregressive noise.
    let found = inflation(&coloured, &[4000]);
    assert!((12.0..26.0).contains(&found), "{found}");
    let white: Vec<f64> = (0..4000).map(|_| random.normal()).collect();
    assert_eq!(inflation(&white, &[2000, 2000]), 1.0);
}

#[test]
fn what_the_residuals_do_not_determine_is_named() {
    // Only the product of the first two acts, and the last not at all.
    let measured = decay(&[6.0, 1.5, 1.0]);
    let residuals = |p: &[f64]| {
        let model = decay(&[p[0] * p[1], p[2], 1.0]);
        let noisy = (0..200).map(|k| 0.01 * f64::from(k % 7 - 3));
        Some(model.iter().zip(&measured).zip(noisy).map(|((s, y), n)| s - y + n).collect())
    };
    let parameters = [tunable(1.0, 1.0), tunable(4.0, 1.0), tunable(1.0, 1.0), tunable(5.0, 1.0)];
    let found = calibrate(&parameters, &[], &[200], residuals).unwrap();
    assert_eq!(found.undetermined, [vec![3], vec![0, 1]]);
    assert!((found.values[0] * found.values[1] - 6.0).abs() < 0.1, "{found:?}");
    assert!(found.half_width[2].is_some() && found.half_width[0].is_none());
}

#[test]
fn a_bound_holds_and_a_model_without_answer_is_avoided() {
    let measured = decay(&[2.0, 1.5, 0.5]);
    let residuals = |p: &[f64]| {
        let answers = p[1] < 3.0;
        answers.then(|| decay(p).iter().zip(&measured).map(|(s, y)| s - y).collect())
    };
    let mut parameters = [tunable(1.0, 1.0), tunable(2.9, 1.0), tunable(0.0, 1.0)];
    let found = calibrate(&parameters, &[], &[200], residuals).unwrap();
    assert!((found.values[1] - 1.5).abs() < 1e-8, "{found:?}");
    parameters[2].upper = 0.25;
    let found = calibrate(&parameters, &[vec![3.0, 1.0, 0.1]], &[200], residuals).unwrap();
    assert!(found.at_bound[2] && found.values[2] == 0.25 && found.half_width[2].is_none());
    assert_eq!(found.starts.len(), 2);
    parameters[1].start = 5.0;
    assert!(calibrate(&parameters, &[], &[200], residuals).is_err());
}
