use super::super::multisine;
use super::*;

const T: f64 = 1e-4;
const POINTS: usize = 4096;
const LINES: usize = 1800;

/// Exact samples of modes in parallel, each [gain, frequency, damping], under a held input, from rest.
fn modes(input: &[f64], modes: &[[f64; 3]]) -> Vec<f64> {
    let mut output = vec![0.0; input.len()];
    for [gain, frequency, damping] in modes {
        let w = TAU * frequency;
        let (decay, turn) = ((-damping * w * T).exp(), w * (1.0 - damping * damping).sqrt());
        let (c, s) = ((turn * T).cos(), (turn * T).sin());
        let (mut x, mut v) = (0.0, 0.0);
        for (u, y) in input.iter().zip(&mut output) {
            *y += gain * x;
            let (dx, dv) = (x - u, v);
            x = u + decay * (dx * (c + damping * w / turn * s) + dv * s / turn);
            v = decay * (dv * (c - damping * w / turn * s) - dx * w * w / turn * s);
        }
    }
    output
}

fn records(plant: &[[f64; 3]], noise: f64) -> Vec<[Vec<f64>; 2]> {
    let mut random = numerics::random::SplitMix64::from_state(7);
    (0..3)
        .map(|realization| {
            let wave = multisine(POINTS, LINES, realization);
            let input: Vec<f64> = wave.iter().cycle().take(2 * POINTS).copied().collect();
            let mut output = modes(&input, plant);
            output.iter_mut().for_each(|y| *y += noise * random.normal());
            [input, output]
        })
        .collect()
}

fn found(records: &[[Vec<f64>; 2]]) -> (Vec<Line>, Vec<NarrowMode>) {
    let all: Vec<[&[f64]; 2]> = records.iter().map(|[u, y]| [&u[..], y]).collect();
    measured_response(&all, POINTS, LINES, T)
}

/// The continuous response of modes in parallel.
fn exact(f: f64, modes: &[[f64; 3]]) -> Complex<f64> {
    let one = |[gain, frequency, damping]: &[f64; 3]| {
        let x = f / frequency;
        Complex::new(*gain, 0.0) / Complex::new(1.0 - x * x, 2.0 * damping * x)
    };
    modes.iter().map(one).sum()
}

#[test]
fn a_mode_between_the_lines_is_found_with_its_peak() {
    // Lines 2.44 Hz apart; the mode is 0.3 Hz wide, wherever it lies between them; another one is wide.
    for place in [0.0, 0.1, 0.3, 0.5, 0.8] {
        let f = (166.0 + place) / (POINTS as f64 * T);
        let plant = [[1.0, f, 3.6e-4], [0.3, 900.0, 0.02]];
        for noise in [0.0, 1e-3] {
            let (lines, narrow) = found(&records(&plant, noise));
            assert_eq!(narrow.len(), 1, "{place}: {narrow:?}");
            let tolerance = if noise > 0.0 { 0.02 } else { 1e-3 };
            assert!((narrow[0].frequency_hz / f - 1.0).abs() < 1e-5, "{place}: {narrow:?} {f}");
            assert!((narrow[0].damping / 3.6e-4 - 1.0).abs() < tolerance, "{place}: {narrow:?}");
            let peak = lines.iter().map(|(_, g)| g.norm()).fold(0.0, f64::max);
            let wanted = exact(f, &plant).norm();
            assert!((peak / wanted - 1.0).abs() < 2.0 * tolerance + 0.01, "{peak} {wanted}");
            // The whole circle, not only its top.
            for (f, g) in lines.iter().filter(|(f, _)| (300.0..600.0).contains(f)) {
                let wanted = exact(*f, &plant);
                let error = (g - wanted).norm() / wanted.norm();
                assert!(error < 0.05, "{place}, {f} Hz: {g} {wanted}");
            }
            assert!(lines.is_sorted_by(|a, b| a.0 < b.0));
        }
    }
}

#[test]
fn two_modes_between_the_lines_are_both_found() {
    let plant = [[1.0, 405.06, 3.6e-4], [0.2, 731.3, 5e-4]];
    let (_, mut narrow) = found(&records(&plant, 1e-4));
    narrow.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    assert_eq!(narrow.len(), 2, "{narrow:?}");
    for (mode, [_, f, damping]) in narrow.iter().zip(plant) {
        assert!((mode.frequency_hz - f).abs() < 0.01, "{mode:?}");
        assert!((mode.damping / damping - 1.0).abs() < 0.05, "{mode:?}");
    }
}

#[test]
fn where_nothing_rings_the_lines_are_those_of_the_multisine() {
    // A wide mode; noise; a tone that is not the plant's, between the lines.
    let mut all = records(&[[1.0, 300.0, 0.02]], 1e-3);
    let tone = |k: usize| 0.05 * (TAU * 50.7 * k as f64 * T).sin();
    all.iter_mut().for_each(|[_, y]| y.iter_mut().enumerate().for_each(|(k, y)| *y += tone(k)));
    let (lines, narrow) = found(&all);
    assert_eq!(narrow, []);
    assert!(lines.len() <= LINES, "{}", lines.len());
    let distance = 1.0 / (POINTS as f64 * T);
    let is_line = |f: f64| (f / distance - (f / distance).round()).abs() < 1e-9;
    assert!(lines.iter().all(|(f, _)| is_line(*f)));
}

#[test]
fn short_records_are_no_records() {
    let wave = vec![0.0; POINTS + 5];
    assert_eq!(measured_response(&[[&wave[..]; 2]], POINTS, LINES, T), (vec![], vec![]));
    assert_eq!(measured_response(&[[&wave[..]; 2]], 0, LINES, T), (vec![], vec![]));
}
