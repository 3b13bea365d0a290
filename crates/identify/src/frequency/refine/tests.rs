//! Fits of modes to responses whose truth is known.

use super::*;
use crate::frequency::Distortion;

const T: f64 = 1e-4;

/// Two axes that share two modes, and a slow pair of real poles.
fn truth(softening: Option<Softening>) -> HeldPlant {
    let matrix = |scale: f64, turn: f64| {
        DMatrix::from_fn(2, 2, |o, i| scale * (0.4 + 0.3 * o as f64 - turn * (o + 2 * i) as f64))
    };
    let mode = |frequency: f64, damping: f64, turn: f64| HeldMode {
        frequency,
        damping,
        residue: matrix(1.0, turn),
        rate_residue: matrix(0.1, -turn),
    };
    HeldPlant {
        period: T,
        direct: matrix(0.2, 0.3),
        modes: vec![mode(150.0, 1.6, 0.1), mode(420.0, 0.015, 0.4), mode(900.0, 0.02, 0.2)],
        delay: 2.0 * T,
        softening,
    }
}

fn level(plant: &HeldPlant, amplitude: f64, error: f64) -> Level {
    let model = plant.at_amplitude(amplitude).rational();
    let lines = (1..800)
        .map(|k| {
            let frequency = 2.0 * f64::from(k);
            let wobble = |place: usize| {
                error * ((f64::from(k) * 12.9 + place as f64 * 78.2 + amplitude).sin() * 43.7).sin()
            };
            let response = model.response(frequency);
            Line {
                frequency,
                response: DMatrix::from_fn(2, 2, |o, i| {
                    response[(o, i)] + Complex::new(wobble(o + 2 * i), wobble(7 + o + 2 * i))
                }),
                deviation: DMatrix::from_element(2, 2, error),
                coherence: vec![1.0; 2],
                amplitude: vec![1.0; 2],
                total: vec![0.1 * error; 2],
                noise: None,
                alone: None,
            }
        })
        .collect();
    let response = FrequencyResponse {
        lines,
        sample_time: T,
        period: None,
        experiments: 2,
        periods: 1,
        distortion: Distortion::default(),
    };
    Level { response, rms: vec![0.3 * amplitude, 0.2 * amplitude] }
}

/// The truth with its modes elsewhere.
fn astray() -> HeldPlant {
    let mut start = truth(None);
    for (mode, factor) in start.modes.iter_mut().zip([1.3, 0.995, 1.006]) {
        mode.frequency *= factor;
        mode.damping *= 1.4;
    }
    start
}

#[test]
fn modes_of_one_level_are_found_from_others_nearby() {
    let (truth, start) = (truth(None), astray());
    for error in [0.0, 1e-9] {
        let level = level(&truth, 1.0, error);
        let plant = refined(&level, &start).unwrap();
        for (own, expected) in plant.modes.iter().zip(&truth.modes) {
            assert!((own.frequency / expected.frequency - 1.0).abs() < 1e-4, "{own:?}");
            assert!((own.damping / expected.damping - 1.0).abs() < 1e-3, "{own:?}");
        }
        let misfit = |plant: &HeldPlant| level.response.misfit(&plant.rational());
        let (own, first) = (misfit(&plant), misfit(&start));
        assert!(own < 1e-6 * first && first.is_finite(), "{own} of {first}");
    }
}

#[test]
fn a_known_softening_is_found() {
    for exponent in EXPONENTS {
        let softening = Softening {
            shift: vec![0.0, -0.02, -0.01],
            growth: vec![0.0, 0.4, 0.1],
            exponent,
            rms: vec![0.3, 0.2],
        };
        let truth = truth(Some(softening.clone()));
        let levels: Vec<Level> = [0.3, 1.0, 0.6].iter().map(|a| level(&truth, *a, 1e-3)).collect();
        let plant = softened(&levels, &astray()).unwrap();
        let own = plant.softening.as_ref().unwrap();
        assert_eq!((own.exponent, &own.rms), (exponent, &softening.rms));
        for k in [1, 2] {
            let (mode, expected) = (&plant.modes[k], &truth.modes[k]);
            assert!((mode.frequency / expected.frequency - 1.0).abs() < 3e-4, "{mode:?}");
            assert!((own.shift[k] - softening.shift[k]).abs() < 5e-4, "{own:?}");
            assert!((mode.damping / expected.damping - 1.0).abs() < 0.02, "{mode:?}");
            assert!((own.growth[k] - softening.growth[k]).abs() < 0.03, "{own:?}");
        }
    }
}

#[test]
fn one_level_has_no_softening() {
    let truth = truth(None);
    assert!(softened(&[level(&truth, 1.0, 1e-3)], &astray()).is_err());
}
