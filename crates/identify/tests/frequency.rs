//! Frequency responses and rational fits of known systems, and of the measured mirror.
#![allow(clippy::print_stdout, reason = "figures and skipped parts are shown with --nocapture")]

use std::path::Path;

use identify::frequency::{
    Complex, Domain, Experiment, MeasureSettings, Rational, RationalSettings, choose,
    fit_with_delay, measure,
};
use nalgebra::DMatrix;
use numerics::random::SplitMix64;

const PERIOD: f64 = 1e-3;
const COUNT: usize = 8192;

/// One period of a multisine of rms 1 with random phases at these lines.
fn multisine(lines: impl Iterator<Item = usize>, seed: u64) -> Vec<f64> {
    let mut random = SplitMix64::new(seed);
    let lines: Vec<(usize, f64)> =
        lines.map(|k| (k, core::f64::consts::TAU * random.uniform())).collect();
    let scale = (2.0 / lines.len() as f64).sqrt();
    (0..COUNT)
        .map(|n| {
            let angle = |k: usize| core::f64::consts::TAU * (k * n % COUNT) as f64 / COUNT as f64;
            scale * lines.iter().map(|(k, phase)| (angle(*k) + phase).cos()).sum::<f64>()
        })
        .collect()
}

fn repeated(u: &[f64], periods: usize) -> Vec<f64> {
    u.iter().copied().cycle().take(periods * u.len()).collect()
}

/// Two inputs, two outputs, modes at 60 and 170 Hz, three samples late.
fn machine() -> Rational {
    let pole = |frequency: f64, damping: f64| {
        let omega = core::f64::consts::TAU * frequency;
        (Complex::new(-damping * omega, omega * (1.0 - damping * damping).sqrt()) * PERIOD).exp()
    };
    let residue = |scale: f64, shape: [f64; 4]| {
        DMatrix::from_fn(2, 2, |o, i| {
            Complex::new(0.02 * shape[2 * o + i], -scale * shape[2 * o + i])
        })
    };
    Rational {
        domain: Domain::Discrete(PERIOD),
        poles: vec![pole(60.0, 0.06), pole(170.0, 0.05)],
        residues: vec![residue(0.1, [1.0, 0.4, 0.4, 0.16]), residue(0.2, [0.5, -0.8, -0.8, 1.28])],
        direct: DMatrix::from_row_slice(2, 2, &[0.05, 0.0, 0.0, 0.03]),
        delay: 3.0 * PERIOD,
    }
}

fn experiments(machine: &Rational, noise: f64) -> Vec<Experiment> {
    let mut random = SplitMix64::new(7);
    (0..2)
        .map(|e| {
            // The second input turned over in the second experiment: the two are orthogonal at every line.
            let sign = if e == 0 { 1.0 } else { -1.0 };
            let input = |i: u64| repeated(&multisine(1..3200, i), 4);
            let inputs = vec![input(1), input(2).iter().map(|u| sign * u).collect::<Vec<f64>>()];
            let mut outputs = machine.simulate(&inputs, true).expect("a discrete model");
            // Uniform noise of this deviation.
            outputs
                .iter_mut()
                .flatten()
                .for_each(|y| *y += noise * 12_f64.sqrt() * (random.uniform() - 0.5));
            Experiment { name: format!("experiment {e}"), inputs, outputs }
        })
        .collect()
}

#[test]
fn two_modes_of_a_machine_with_two_inputs_are_found_with_their_delay() {
    let machine = machine();
    let measured = measure(&experiments(&machine, 0.0), &MeasureSettings::new(PERIOD)).unwrap();
    assert_eq!((measured.period, measured.periods), (Some(COUNT), 4));
    for line in measured.lines.iter().filter(|line| line.frequency > 5.0) {
        let truth = machine.response(line.frequency);
        let error = (&line.response - &truth).norm();
        assert!(error < 0.02 * truth.norm(), "{} Hz: {error} of {}", line.frequency, truth.norm());
        assert!(line.coherence.iter().all(|c| *c > 0.999), "{line:?}");
    }
    let settings = RationalSettings {
        pairs: 2,
        longest_delay: 6.0 * PERIOD,
        by_deviation: false,
        ..RationalSettings::default()
    };
    let fit = fit_with_delay(&measured, Domain::Discrete(PERIOD), &settings).unwrap();
    assert_eq!(fit.model.delay, 3.0 * PERIOD);
    for (mode, (frequency, damping)) in fit.model.modes().iter().zip([(60.0, 0.06), (170.0, 0.05)])
    {
        assert!((mode.frequency / frequency - 1.0).abs() < 1e-3, "{mode:?}");
        assert!((mode.damping / damping - 1.0).abs() < 0.02, "{mode:?}");
    }
    // With noise, more pairs than there are modes do not shorten the description.
    let measured = measure(&experiments(&machine, 0.02), &MeasureSettings::new(PERIOD)).unwrap();
    let settings = RationalSettings { by_deviation: true, ..settings };
    let (tried, best) = choose(&measured, Domain::Discrete(PERIOD), &settings, 3).unwrap();
    assert_eq!(tried[best].0, 2);
}

#[test]
fn noise_is_separated_from_distortion() {
    const NOISE: f64 = 0.02;
    let measured = measure(&experiments(&machine(), NOISE), &MeasureSettings::new(PERIOD)).unwrap();
    // Amplitude of a line of the mean of four periods.
    let expected = 2.0 * NOISE / (COUNT as f64 * 4.0).sqrt();
    for output in 0..2 {
        let levels = measured.levels(output);
        let noise = levels.noise.unwrap();
        assert!((noise / expected - 1.0).abs() < 0.1, "{noise} {expected}");
        assert!(levels.distortion.unwrap() < 0.6 * noise, "{levels:?}");
    }
}

#[test]
fn squares_show_at_even_lines_and_cubes_at_odd_ones() {
    // Odd lines, every fourth of them left out.
    let lines = (0..400).map(|k| 2 * k + 1).filter(|k| k % 8 != 5);
    let u = repeated(&multisine(lines, 3), 2);
    let levels = |f: &dyn Fn(f64) -> f64| {
        let outputs = vec![u.iter().map(|u| f(*u)).collect()];
        let one = Experiment { name: "one".into(), inputs: vec![u.clone()], outputs };
        measure(&[one], &MeasureSettings::new(PERIOD)).unwrap().levels(0)
    };
    let square = levels(&|u| u + 0.1 * u * u);
    assert!(square.odd.unwrap() < 1e-9 && square.even.unwrap() > 1e-3, "{square:?}");
    assert!(square.distortion.unwrap() < 1e-9, "{square:?}");
    let cube = levels(&|u| u + 0.1 * u * u * u);
    assert!(cube.even.unwrap() < 1e-9 && cube.odd.unwrap() > 1e-3, "{cube:?}");
    // What the detection lines show is what disturbs the excited ones.
    let ratio = cube.distortion.unwrap() / cube.odd.unwrap();
    assert!((0.7..1.4).contains(&ratio), "{cube:?}");
}

#[test]
fn a_swept_sine_gives_the_response_without_periods() {
    let truth = Rational {
        residues: vec![DMatrix::from_element(1, 1, Complex::new(0.0, -0.1))],
        poles: vec![machine().poles[0]],
        direct: DMatrix::zeros(1, 1),
        ..machine()
    };
    let count = 20_000;
    let sweep = |n: usize| {
        let t = n as f64 * PERIOD;
        (core::f64::consts::TAU * (2.0 * t + 0.5 * 200.0 / 20.0 * t * t)).sin()
    };
    let inputs = vec![(0..count).map(sweep).collect::<Vec<f64>>()];
    let outputs = truth.simulate(&inputs, false).expect("a discrete model");
    let one = Experiment { name: "sweep".into(), inputs, outputs };
    let measured = measure(&[one], &MeasureSettings::new(PERIOD)).unwrap();
    assert_eq!(measured.period, None);
    for line in measured.lines.iter().filter(|l| (10.0..190.0).contains(&l.frequency)) {
        let (g, t) = (line.response[(0, 0)], truth.response(line.frequency)[(0, 0)]);
        assert!((g - t).norm() < 0.02 * t.norm(), "{} Hz: {g} {t}", line.frequency);
    }
}

/// All other lines of the record hold what leaks from that of the sine.
#[test]
fn a_sine_that_does_not_close_has_no_response_beside_its_line() {
    let omega = core::f64::consts::TAU * 7.3;
    let (keep, mut y, mut random) = (0.9, 0.0, SplitMix64::new(5));
    let input: Vec<f64> =
        (0..6000).map(|n| 5.0 - 5.0 * (omega * n as f64 * PERIOD).cos()).collect();
    let output = input.iter().map(|u| {
        y = keep * y + (1.0 - keep) * u;
        y + 1e-3 * (random.uniform() - 0.5)
    });
    let output = output.collect();
    let record = Experiment { name: "sine".into(), inputs: vec![input], outputs: vec![output] };
    let settings = MeasureSettings { band: 1e-6, ..MeasureSettings::new(PERIOD) };
    let lines = measure(&[record], &settings).map(|found| found.lines).unwrap_or_default();
    for line in &lines {
        let z = Complex::new(0.0, core::f64::consts::TAU * line.frequency * PERIOD).exp();
        let truth = (Complex::new(1.0 - keep, 0.0) / (Complex::new(1.0, 0.0) - keep / z)).norm();
        let found = line.response[(0, 0)].norm();
        println!("seed 5, {} Hz: {found} for {truth}", line.frequency);
        assert!(found < 20.0 * truth, "{} Hz: {found} for {truth}", line.frequency);
    }
}

#[test]
fn inputs_that_move_together_are_refused() {
    let u = repeated(&multisine(1..500, 1), 2);
    let both = Experiment {
        name: "both".into(),
        inputs: vec![u.clone(), u.iter().map(|u| 2.0 * u).collect()],
        outputs: vec![u],
    };
    let error = measure(&[both], &MeasureSettings::new(PERIOD)).unwrap_err().to_string();
    assert!(error.contains("independently"), "{error}");
}

/// Records of the mirror, mean over their two periods.
fn mirror(part: &str) -> Option<Vec<Experiment>> {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/fsm_cubespec_multisine");
    let file = folder.join(format!("fsm_300mV_{part}.csv"));
    if !file.exists() {
        println!("SKIPPED: {} is not there", file.display());
        return None;
    }
    let log = data::Log::read(&file, &data::ReadOptions::default()).expect("a log");
    let column = |name: &str, rows: &core::ops::Range<usize>| -> Vec<f64> {
        log.require(name).expect("a column").values[rows.clone()].to_vec()
    };
    let one = |record: &data::Record| Experiment {
        name: format!("{part} {}", record.id),
        inputs: ["u1", "u2", "u3"].map(|name| column(name, &record.rows)).to_vec(),
        outputs: ["y1", "y2", "y3"].map(|name| column(name, &record.rows)).to_vec(),
    };
    Some(log.records().iter().map(one).collect())
}

/// Held-out error of a linear model of 28 states on the mirror at 300 mV, relative to the rms of the
/// outputs: the authors of the data report 5.63 % for theirs.
#[test]
fn the_mirror_s_linear_model_is_as_good_as_its_authors() {
    let (Some(train), Some(test)) = (mirror("train"), mirror("test")) else { return };
    let period = 1.0 / 6400.0;
    let measured = measure(&train, &MeasureSettings::new(period)).unwrap();
    assert_eq!(measured.period, Some(8192));
    let settings = RationalSettings {
        pairs: 14,
        rounds: 20,
        by_deviation: false,
        ..RationalSettings::default()
    };
    let fit = fit_with_delay(&measured, Domain::Discrete(period), &settings).unwrap();
    assert_eq!(fit.model.order(), 28);
    let run = fit.model.simulate(&test[0].inputs, true).expect("a discrete model");
    let (mut error, mut power) = (0.0_f64, 0.0_f64);
    for (simulated, measured) in run.iter().zip(&test[0].outputs) {
        error += simulated.iter().zip(measured).map(|(s, y)| (s - y).powi(2)).sum::<f64>();
        power += measured.iter().map(|y| y * y).sum::<f64>();
    }
    let relative = (error / power).sqrt();
    println!("mirror, 300 mV, 28 states: {:.2} % of rms held out", 100.0 * relative);
    assert!(relative < 0.0563, "{relative}");
}
