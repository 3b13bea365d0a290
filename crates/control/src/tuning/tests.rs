use super::*;

const T: f64 = 1e-3;

/// A lag of 10 samples behind `delay` samples, gain 0.5, with its own state.
fn lag(delay: usize) -> impl FnMut(f64) -> Result<f64, Error> {
    let keep = (-0.1_f64).exp();
    let mut x = 0.0;
    let mut pipe = std::collections::VecDeque::from(vec![0.0; delay]);
    move |u| {
        pipe.push_back(u);
        let late = pipe.pop_front().unwrap_or(u);
        x = keep * x + (1.0 - keep) * 0.5 * late;
        Ok(x)
    }
}

/// K_u and T_u of that loop, from its phase.
fn exact(delay: f64) -> (f64, f64) {
    let keep = (-0.1_f64).exp();
    let response = |angle: f64| {
        let back = Complex::from_polar(1.0, -angle);
        back.powf(delay) * back * (1.0 - keep) * 0.5 / (Complex::new(1.0, 0.0) - back * keep)
    };
    let (mut low, mut high) = (1e-3, PI / (delay + 1.0));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if response(middle).im < 0.0 { low = middle } else { high = middle }
    }
    (1.0 / response(low).norm(), TAU * T / low)
}

#[test]
fn the_paper_s_gains_follow_from_its_ultimate_gain() {
    let gains = ziegler_nichols(&Ultimate { gain: 58.33, period: 0.0979, amplitude: 1.0 });
    assert!((gains.kp - 35.0).abs() < 0.01 && (gains.ki - 715.0).abs() < 0.2, "{gains:?}");
    assert!((gains.kd - 0.43).abs() < 0.002, "{gains:?}");
}

#[test]
fn relay_and_gain_find_the_ultimate_gain_of_a_lag_with_delay() {
    let (gain, period) = exact(8.0);
    let found = relay(&mut lag(8), T, [3.0, 1.0], 20).unwrap();
    // The relay sees the first harmonic only, and switches on whole samples.
    assert!((found.gain / gain - 1.0).abs() < 0.15, "{found:?} {gain}");
    assert!((found.period / period - 1.0).abs() < 0.08, "{found:?} {period}");
    let found = ultimate_by_gain(&mut lag(8), T, [3.0, 1.0]).unwrap();
    assert!((found.gain / gain - 1.0).abs() < 0.05, "{found:?} {gain}");
    assert!((found.period / period - 1.0).abs() < 0.03, "{found:?} {period}");
}

#[test]
fn the_verdict_knows_the_limit_of_stability() {
    let impulse = impulse_of(&mut lag(8), [3.0, 1.0], 150, 1).unwrap();
    assert!((impulse.iter().sum::<f64>() - 0.5).abs() < 1e-4);
    let (gain, _) = exact(8.0);
    for (factor, stable) in [(0.9, true), (1.1, false)] {
        let gains = Gains { kp: factor * gain, ..Gains::default() };
        let verdict = judge_loop(&impulse, T, &gains, false, &[1.0]);
        assert_eq!(verdict.stable, stable, "{verdict:?}");
        assert!((verdict.gain_margin * factor - 1.0).abs() < 0.03, "{verdict:?}");
    }
}

#[test]
fn robust_gains_keep_their_sensitivity_and_reject_slow_disturbances() {
    let impulse = impulse_of(&mut lag(8), [3.0, 1.0], 150, 1).unwrap();
    let gains = robust(&impulse, T, 1.5, 10.0).unwrap();
    let verdict = judge_loop(&impulse, T, &gains, true, &[0.2, 2.0]);
    assert!(verdict.stable && verdict.sensitivity < 1.505, "{verdict:?} {gains:?}");
    assert!(verdict.gain_margin >= 2.95 && verdict.phase_margin > 38.0, "{verdict:?}");
    // 1/(1 + L) is near s/(ki·g) far below the crossing.
    let near = TAU * 0.2 / (gains.ki * 0.5);
    assert!((verdict.disturbance[0].1 / near - 1.0).abs() < 0.1, "{verdict:?} {near}");
}

#[test]
fn a_machine_that_does_not_move_is_reported() {
    let text = relay(&mut |_| Ok(1.0), T, [0.0, 1.0], 5).unwrap_err().to_string();
    assert!(text.contains("no more than its noise"), "{text}");
}
