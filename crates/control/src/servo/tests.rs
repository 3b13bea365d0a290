use super::*;

const T: f64 = 1e-4;
const MODE: f64 = 300.0;
const DAMPING: f64 = 0.02;

/// ω₀²/(s² + 2ζω₀s + ω₀²), continuous.
fn mode(frequency: f64) -> Complex<f64> {
    let x = frequency / MODE;
    Complex::new(1.0, 0.0) / Complex::new(1.0 - x * x, 2.0 * DAMPING * x)
}

fn plant() -> ServoPlant {
    let lines: Vec<_> = (1..4500).map(f64::from).map(|f| (f, mode(f))).collect();
    ServoPlant::new(&lines, &[], 1.0, T)
}

fn rejections(frequency: f64) -> (usize, Vec<NotchFilter>) {
    (2, [0.02, 0.05, 0.1, 0.2].map(|zeros| [frequency, zeros, 1.0]).to_vec())
}

const REFERENCE: [(f64, f64); 2] = [(5.0, 1.0), (15.0, 0.01)];

#[test]
fn an_integrator_on_a_mode_has_its_known_limit() {
    // At the resonance L = ki·(1/jω)·(1/2ζj): for |1 + L| >= 2/3 there ki <= 2ζω/3, without the hold's lag.
    let plant = plant();
    let no_filter = |_: f64| (0, Vec::new());
    let limits = ServoLimits { sensitivity: 1.5, noise: 10.0 };
    let (law, verdict) = plant.design(&REFERENCE, limits, no_filter).unwrap();
    assert!(verdict.sensitivity <= 1.505, "{verdict:?}");
    let integral = ServoLaw { ki: 2.0 * DAMPING * TAU * MODE, ..ServoLaw::default() };
    assert!(plant.judge(&integral, &REFERENCE).sensitivity > 5.0, "the limit of stability");
    assert!(law.ki > 0.5 * DAMPING * TAU * MODE, "{law:?}");
}

#[test]
fn a_filter_at_the_mode_makes_the_error_many_times_smaller() {
    let plant = plant();
    let limits = ServoLimits { sensitivity: 1.5, noise: 10.0 };
    let resonances = plant.resonances();
    assert!((resonances[0] / MODE - 1.0).abs() < 0.01, "{resonances:?}");
    let (_, without) = plant.design(&REFERENCE, limits, |_| (0, Vec::new())).unwrap();
    let (law, with) = plant.design(&REFERENCE, limits, rejections).unwrap();
    assert!(with.rms_error < without.rms_error / 5.0, "{law:?} {with:?} {without:?}");
    assert!(with.gain_margin > 2.5 && with.phase_margin > 35.0, "{with:?}");
}

#[test]
fn the_predicted_error_is_that_of_the_loop_in_time() {
    // Exact sampled mode by its own recursion, a law with a filter, a sine of 20 Hz.
    let plant = plant();
    let law = ServoLaw { kp: 0.01, ki: 60.0, kd: 1e-6, notches: vec![[MODE, 0.05, 1.0]] };
    let reference = [(20.0, 0.5)];
    let w = TAU * MODE;
    let (decay, turn) = ((-DAMPING * w * T).exp(), w * (1.0 - DAMPING * DAMPING).sqrt());
    let (c, s) = ((turn * T).cos(), (turn * T).sin());
    let (mut x, mut v, mut sum, mut last) = (0.0, 0.0, 0.0, 0.0);
    let mut outputs: Vec<f64> = Vec::new();
    let mut square = 0.0;
    let (run, count) = (40_000, 50_000);
    for k in 0..count {
        let error = (TAU * 20.0 * k as f64 * T).sin() - x;
        sum += law.ki * T * error;
        outputs.push(law.kp * error + sum + law.kd * (error - last) / T);
        last = error;
        // The filter from its definition, over what there is of the signal.
        let u = {
            let from = outputs.len().saturating_sub(400);
            let mut tail = outputs[from..].to_vec();
            filter(&mut tail, law.notches[0], T);
            *tail.last().unwrap()
        };
        let (dx, dv) = (x - u, v);
        x = u + decay * (dx * (c + DAMPING * w / turn * s) + dv * s / turn);
        v = decay * (dv * (c - DAMPING * w / turn * s) - dx * w * w / turn * s);
        if k >= run {
            square += error * error;
        }
    }
    let rms = (square / f64::from(count - run)).sqrt();
    let predicted = plant.judge(&law, &reference).rms_error;
    assert!((predicted / rms - 1.0).abs() < 0.02, "{predicted} {rms}");
}

#[test]
fn a_multisine_measures_the_response_of_a_mode() {
    let (points, lines) = (2000, 800);
    let wave = multisine(points, lines, 0);
    let rms = (wave.iter().map(|x| x * x).sum::<f64>() / points as f64).sqrt();
    assert!(rms > 0.4, "crest factor {}", 1.0 / rms);
    let input: Vec<f64> = wave.iter().cycle().take(6 * points).copied().collect();
    let w = TAU * MODE;
    let (decay, turn) = ((-DAMPING * w * T).exp(), w * (1.0 - DAMPING * DAMPING).sqrt());
    let (c, s) = ((turn * T).cos(), (turn * T).sin());
    let (mut x, mut v) = (0.0, 0.0);
    let mut output = Vec::new();
    for u in &input {
        output.push(x);
        let (dx, dv) = (x - u, v);
        x = u + decay * (dx * (c + DAMPING * w / turn * s) + dv * s / turn);
        v = decay * (dv * (c - DAMPING * w / turn * s) - dx * w * w / turn * s);
    }
    let last = [&input[4 * points..], &output[4 * points..]];
    let found = periodic_response(last, points, lines, T);
    for (f, response) in found.iter().filter(|(f, _)| *f < 1000.0) {
        // A mode between the samples is not quite held: a few parts in a thousand at a kHz.
        let wanted = mode(*f);
        assert!((response - wanted).norm() < 0.02 * wanted.norm(), "{f} Hz: {response} {wanted}");
    }
}

#[test]
fn lines_that_the_realizations_do_not_agree_about_are_left_out() {
    let line = |f: f64, re: f64| (f, Complex::new(re, 0.0));
    let found = mean_response(&[
        vec![line(1.0, 2.0), line(2.0, 2.1), line(3.0, 9.0), line(4.0, 0.05)],
        vec![line(1.0, 2.0), line(2.0, 1.9), line(3.0, -4.0), line(4.0, -0.05)],
    ]);
    let lines: Vec<f64> = found.iter().map(|(f, _)| *f).collect();
    // The last one is small whatever it is.
    assert_eq!(lines, [1.0, 2.0, 4.0]);
    assert!((found[1].1.re - 2.0).abs() < 1e-12);
    assert_ne!(multisine(64, 20, 0), multisine(64, 20, 1));
}

#[test]
fn the_law_is_found_in_a_record_and_another_is_not() {
    let law = ServoLaw { kp: 0.2, ki: 30.0, kd: 2e-5, notches: vec![[250.0, 0.05, 1.0]] };
    let error: Vec<f64> = (0..3000)
        .map(|k| (0.003 * f64::from(k)).sin() + (0.11 * f64::from(k * k % 97)).cos())
        .collect();
    let mut sum = 0.0;
    let mut last = error[0];
    let mut voltage: Vec<f64> = error
        .iter()
        .map(|e| {
            sum += law.ki * T * e;
            let out = law.kp * e + sum + law.kd * (e - last) / T;
            last = *e;
            7.0 * out + 40.0
        })
        .collect();
    filter(&mut voltage, law.notches[0], T);
    let (scale, share) = law_in_record(&law, [&error, &voltage], T);
    assert!((scale - 7.0).abs() < 1e-6 && share > 0.999_999, "{scale} {share}");
    let other = ServoLaw { ki: 0.0, kd: 0.0, notches: Vec::new(), ..law };
    assert!(law_in_record(&other, [&error, &voltage], T).1 < 0.9);
}
