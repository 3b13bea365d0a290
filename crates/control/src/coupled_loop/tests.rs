use super::*;

/// Impulse responses of two axes with a delay of `late` periods, gains 2 and −4, and a coupling `across` of the first
/// to the second's motion.
fn delayed(late: usize, across: f64) -> Vec<Vec<Vec<f64>>> {
    let one = |gain: f64| {
        let mut response = vec![0.0; late + 1];
        response[late] = gain;
        response
    };
    vec![vec![one(2.0), one(2.0 * across)], vec![one(0.0), one(-4.0)]]
}

fn found(responses: &[Vec<Vec<Vec<f64>>>], law: Feedback, first: Option<f64>) -> CoupledLoop {
    let integral = Shape { name: "integral", a: 0.0, b: 0.0, filter: 0.0 };
    let coupled_plants = CoupledPlants { responses, slopes: &[2.0, -4.0], first, period: 1e-3 };
    let limits = Limits { sensitivity: 1.5, noise: 100.0 };
    coupled(&coupled_plants, &[integral; 2], law, CommandActs::AtOnce, limits).expect("gains")
}

/// The gain k·T of an integral around `late + 1` periods of delay at which the sensitivity is 1.5, by bisection on
/// |1 + k·T·z⁻⁽ˡᵃᵗᵉ⁺¹⁾/(1 − z⁻¹)|.
fn exact(late: usize) -> f64 {
    let holds = |k: f64| {
        (1..20_000).all(|at| {
            let back = Complex::from_polar(1.0, -PI * f64::from(at) / 20_000.0);
            (1.0 + back.powu(late as u32 + 1) * k / (1.0 - back)).norm() >= 1.0 / 1.5
        })
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

#[test]
fn axes_that_do_not_act_on_each_other_get_the_gains_of_single_axes() {
    for late in [0, 3] {
        let found = found(&[delayed(late, 0.0)], Feedback::Integral, None);
        let wanted = exact(late) / 1e-3;
        for (axis, slope) in found.axes.iter().zip([2.0, -4.0]) {
            let ratio = axis.ki * slope / wanted;
            assert!((0.97..=1.0).contains(&ratio), "{late}: {axis:?} {wanted}");
        }
        assert!(found.figures.sensitivity <= 1.5 && found.figures.sensitivity > 1.47);
    }
    // |L| = k·T/2 at half the sample rate, where a single delay turns it by a half: unstable from k·T = 2 on.
    let found = found(&[delayed(0, 0.0)], Feedback::Integral, None);
    let limit = 2.0 / (found.axes[0].ki * 2.0 * 1e-3);
    assert!((found.figures.gain_margin / limit - 1.0).abs() < 0.03, "{:?} {limit}", found.figures);
}

#[test]
fn what_one_axis_does_to_another_costs_gain_though_each_loop_by_itself_would_allow_it() {
    let apart = found(&[delayed(2, 0.0)], Feedback::Integral, None);
    let across = found(&[delayed(2, 1.5)], Feedback::Integral, None);
    // Triangular: the eigenvalues of the loop, and the margins of each axis, are the same. The singular values are not.
    let product =
        |found: &CoupledLoop| found.axes.iter().map(|axis| axis.ki.abs()).product::<f64>();
    assert!(product(&across) < 0.8 * product(&apart), "{:?} {:?}", across.axes, apart.axes);
    assert!(across.figures.sensitivity <= 1.5);
}

#[test]
fn two_shared_modes_allow_more_gain_behind_notches() {
    // Modes at 120 and 170 Hz, quality 50, in both axes and across.
    let plants: Vec<_> = grid()
        .map(|(shift, damping)| {
            let mode = |frequency: f64, gain: f64| -> Vec<f64> {
                let (angle, zeta) = (TAU * frequency * shift * 1e-3, 0.01 * damping);
                let step =
                    |k: usize| 1.0 - (-zeta * angle * k as f64).exp() * (angle * k as f64).cos();
                (0..6000).map(|k| gain * (step(k + 1) - step(k))).collect()
            };
            let sum =
                |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).map(|(a, b)| a + b).collect::<Vec<_>>();
            let (low, high) = (|gain| mode(120.0, gain), |gain| mode(170.0, gain));
            vec![
                vec![sum(low(1.2), high(0.8)), sum(low(0.4), high(-0.4))],
                vec![sum(low(-0.6), high(0.6)), sum(low(-1.6), high(-2.4))],
            ]
        })
        .collect();
    let integral = found(&plants, Feedback::Integral, Some(120.0));
    let notched = found(&plants, Feedback::Pid, Some(120.0));
    assert_eq!(notched.figures.notches.len(), NOTCHES, "{:?}", notched.figures);
    assert_eq!(notched.figures.plants, 15);
    for (one, other) in notched.axes.iter().zip(&integral.axes) {
        assert!(one.ki / other.ki > 4.0, "{one:?} {other:?}");
    }
    assert!(notched.figures.sensitivity <= 1.5 && notched.figures.gain_margin >= 2.9);
}
