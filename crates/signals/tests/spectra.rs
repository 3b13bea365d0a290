//! Spectra: lines are excited where they should be, and nowhere else.

use numerics::fft::Fft;
use signals::find;

/// Amplitudes of the lines 0 … N/2 of a record of N values.
fn amplitudes(values: &[f64]) -> Vec<f64> {
    let lines = Fft::forward(values.len()).of_real(values);
    let scale = 2.0 / values.len() as f64;
    lines.iter().take(values.len() / 2 + 1).map(|line| scale * line.norm()).collect()
}

fn channel(name: &str, index: usize, settings: &[(&str, f64)]) -> Vec<f64> {
    let kind = find(name).unwrap_or_else(|| panic!("{name} is not in the registry"));
    kind.generate(settings).unwrap_or_else(|e| panic!("{e}")).channels[index].values.clone()
}

/// Lines above 1e-9 of the greatest, without the mean.
fn excited(values: &[f64]) -> Vec<usize> {
    let lines = amplitudes(values);
    let greatest = lines[1..].iter().copied().fold(0.0, f64::max);
    (1..lines.len()).filter(|&k| lines[k] > 1e-9 * greatest).collect()
}

#[test]
fn sines_have_one_line_of_half_their_range() {
    for (name, settings, line, amplitude) in [
        ("sine", [("frequency", 7.0), ("duration", 1.0)], 7, 50.0),
        ("p3-sine", [("frequency", 900.0), ("duration", 0.1)], 90, 15.0),
        ("p4-loop-100hz", [("top", 100.0), ("duration", 0.03)], 3, 50.0),
        ("p1-b", [("sample_time", 2e-3), ("duration", 1.0)], 10, 2.5),
        ("p2-control", [("sample_time", 4e-3), ("duration", 2.0)], 4, 68.0),
    ] {
        let values = channel(name, 0, &settings);
        assert_eq!(excited(&values), [line], "{name}");
        assert!((amplitudes(&values)[line] - amplitude).abs() < 1e-9, "{name}");
    }
}

#[test]
fn tones_of_p3_are_the_printed_ones() {
    for (name, tones) in [
        ("p3-two-tone", &[(120.0, 7.5), (180.0, 7.5)][..]),
        ("p3-four-tone", &[(100.0, 6.0), (150.0, 3.0), (200.0, 3.0), (250.0, 6.0)]),
    ] {
        let values = channel(name, 0, &[]);
        let lines: Vec<usize> = tones.iter().map(|(f, _)| (f * 0.1f64).round() as usize).collect();
        assert_eq!(excited(&values), lines, "{name}");
        let amplitudes = amplitudes(&values);
        for (line, (_, amplitude)) in lines.iter().zip(tones) {
            assert!((amplitudes[*line] - amplitude).abs() < 1e-9);
        }
        assert!((amplitudes[0] / 2.0 - 22.5).abs() < 1e-9);
    }
}

#[test]
fn calibration_axes_have_a_line_each() {
    for (index, line) in [3, 4, 5, 7].into_iter().enumerate() {
        assert_eq!(excited(&channel("p0-calibration", index, &[])), [line]);
    }
}

#[test]
fn trajectories_of_p0_stay_below_the_frequencies_that_its_models_were_trained_with() {
    for (name, pass) in [("p0-trajectory-1", 2.0), ("p0-trajectory-2", 1.0)] {
        for index in 0..4 {
            let settings = [("approach", 0.0), ("settle", 0.0)];
            let values = channel(name, index, &settings);
            assert_eq!(values.len(), (pass / 5e-3) as usize);
            assert_eq!(excited(&values), [1, 2], "{name}: one and two waves a pass");
        }
    }
}

/// Settings of a short multisine: 1000 samples of 1 ms, lines of 1 Hz.
const SHORT: [(&str, f64); 5] = [
    ("samples_per_period", 1000.0),
    ("periods", 1.0),
    ("sample_time", 1e-3),
    ("lowest_frequency", 10.0),
    ("highest_frequency", 300.0),
];

#[test]
fn multisines_excite_their_lines_with_one_amplitude() {
    for (name, lines) in [
        ("multisine", (10..=300).collect::<Vec<usize>>()),
        ("multisine-odd", (11..=299).step_by(2).collect()),
    ] {
        let values = channel(name, 0, &SHORT);
        assert_eq!(excited(&values), lines, "{name}");
        let amplitudes = amplitudes(&values);
        let first = amplitudes[lines[0]];
        assert!(lines.iter().all(|&k| (amplitudes[k] - first).abs() < 1e-9 * first), "{name}");
        assert!((amplitudes[0] / 2.0 - 50.0).abs() < 1e-9, "{name}");
    }
}

#[test]
fn odd_random_multisines_leave_one_line_of_each_group_empty() {
    for seed in 0..20 {
        let mut settings = SHORT.to_vec();
        settings.push(("seed", f64::from(seed)));
        let lines = excited(&channel("multisine-odd-random", 0, &settings));
        assert!(lines.iter().all(|k| k % 2 == 1 && (10..=300).contains(k)));
        // 145 odd lines: 36 groups of four, and one line over that stays.
        assert_eq!(lines.len(), 145 - 36);
        let odd: Vec<usize> = (11..=299).step_by(2).collect();
        for group in odd.chunks_exact(4) {
            assert_eq!(group.iter().filter(|k| lines.contains(k)).count(), 3);
        }
    }
}

#[test]
fn the_seed_moves_phases_and_not_lines() {
    let with = |seed: f64| {
        let mut settings = SHORT.to_vec();
        settings.push(("seed", seed));
        channel("multisine", 0, &settings)
    };
    assert!(with(1.0) != with(2.0));
    assert_eq!(excited(&with(1.0)), excited(&with(2.0)));
}

#[test]
fn periods_of_a_multisine_are_equal_and_touch_a_limit() {
    let values = channel("multisine-odd", 0, &[]);
    assert!(values[..4000] == values[4000..8000]);
    assert!(values[..4000] == values[8000..]);
    assert!(values.iter().any(|v| *v == 0.0 || *v == 100.0));
}

#[test]
fn odd_multisines_change_their_sign_after_half_a_period() {
    for name in ["multisine-odd", "multisine-odd-random"] {
        let values = channel(name, 0, &[]);
        for n in 0..2000 {
            assert!((values[n] + values[n + 2000] - 100.0).abs() < 1e-9, "{name}");
        }
    }
}

#[test]
fn the_binary_sequence_is_white() {
    let settings = [("register", 9.0), ("periods", 1.0), ("low", -1.0), ("high", 1.0)];
    let lines = amplitudes(&channel("pseudo-random-binary", 0, &settings));
    let expected = 2.0 * (512.0f64).sqrt() / 511.0;
    assert!(lines[1..].iter().all(|a| (a - expected).abs() < 1e-9));
}

#[test]
fn triangles_have_odd_lines_that_fall_with_the_square() {
    let values = channel("p3-triangle", 0, &[("duration", 0.02), ("sample_time", 1e-6)]);
    let lines = amplitudes(&values);
    let first = 20.0 * 4.0 / (std::f64::consts::PI * std::f64::consts::PI);
    for (k, line) in lines.iter().enumerate().take(20).skip(1) {
        let expected = if k % 2 == 1 { first / (k * k) as f64 } else { 0.0 };
        assert!((line - expected).abs() < 1e-6, "line {k}: {line}");
    }
}

#[test]
fn chirps_stay_in_their_band() {
    // A sweep of 1000 waves: all but the edges' 2 % of the power lies between the ends.
    for name in ["chirp-linear", "chirp-logarithmic"] {
        let settings = [
            ("start_frequency", 20.0),
            ("end_frequency", 200.0),
            ("duration", 10.0),
            ("low", -1.0),
            ("high", 1.0),
        ];
        let lines = amplitudes(&channel(name, 0, &settings));
        let power = |from: usize, to: usize| lines[from..to].iter().map(|a| a * a).sum::<f64>();
        let share = power(200, 2001) / power(1, lines.len());
        assert!(share > 0.98, "{name}: {share}");
        // Equal time per hertz gives each band of equal width the same power; equal time per
        // octave each octave.
        let (first, second) = match name {
            "chirp-linear" => (power(400, 800), power(1200, 1600)),
            _ => (power(400, 800), power(800, 1600)),
        };
        assert!((first / second - 1.0).abs() < 0.05, "{name}: {}", first / second);
    }
}
