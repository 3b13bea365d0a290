//! What the page of a controller shows, against the figures that the design gives.

#![allow(clippy::print_stdout, reason = "figures are shown with --nocapture")]

use control::{
    AxisResponses, CommandActs, ControlSettings, Damping, Feedback, Inversion, invert, responses,
};
use data::CheckedBlueprint;
use identify::Silent;
use nalgebra::Complex;

fn rig(name: &str) -> CheckedBlueprint {
    let rig = rigs::find(name).expect("a rig");
    let blueprint = data::Blueprint::parse(rig.blueprint, name).unwrap_or_else(|e| panic!("{e}"));
    blueprint.check(learned::COMPONENTS).unwrap_or_else(|e| panic!("{e}"))
}

fn of(name: &str, settings: &ControlSettings) -> (Inversion, Vec<AxisResponses>) {
    let plant = rig(name);
    let found = invert(&plant, settings, &mut Silent).unwrap_or_else(|e| panic!("{e}"));
    let shown = responses(&plant, &found.controller, &found.axes, settings.acts);
    (found, shown.unwrap_or_else(|e| panic!("{e}")))
}

fn settings(period: f64) -> ControlSettings {
    ControlSettings { period: Some(period), ..ControlSettings::default() }
}

/// The design and the curves share the plant's response, and nothing of the law: one takes its gains, the other
/// the written component.
#[test]
fn the_written_controller_has_the_sensitivity_and_the_margins_that_were_designed() {
    let damped =
        ControlSettings { damping: Damping::NonMinimumPhase, sensitivity: 2.0, ..settings(2e-5) };
    let at_once = ControlSettings { acts: CommandActs::AtOnce, ..settings(1e-4) };
    let cases =
        [("evc", settings(2e-5)), ("p0", settings(5e-3)), ("p2", at_once), ("p4-machine", damped)];
    for (name, settings) in cases {
        let (found, shown) = of(name, &settings);
        for (figures, shown) in found.axes.iter().zip(&shown) {
            let curves = shown.curves.as_ref().expect("feedback");
            let worst = curves.worst.iter().copied().fold(0.0, f64::max);
            let place = format!("{name}, axis {}", figures.axis);
            println!("{place}: max |S| {worst}, designed {}", figures.sensitivity);
            assert!(
                (worst / figures.sensitivity - 1.0).abs() < 2e-3,
                "{place}: {worst} {figures:?}"
            );
            let one = Complex::new(1.0, 0.0);
            for (k, l) in curves.open.iter().enumerate() {
                assert!(1.0 / (one + l).norm() <= curves.worst[k] * (1.0 + 1e-9), "{place}: {k}");
            }
            // Frequencies rise; T is 1 where the integral acts, and |L| crosses 1 at the bandwidth.
            assert!((curves.closed[0] - one).norm() < 0.05, "{place}: {}", curves.closed[0]);
            let crossing = curves.open.iter().position(|l| l.norm() <= 1.0).expect("crosses");
            if figures.damping.is_none() {
                let at = curves.frequency[crossing];
                assert!((at / figures.bandwidth - 1.0).abs() < 0.05, "{place}: {at}");
            }
        }
    }
}

#[test]
fn steps_end_at_their_reference_and_waves_err_as_the_checks_say() {
    let (found, shown) = of("evc", &settings(2e-5));
    for (figures, shown) in found.axes.iter().zip(&shown) {
        assert!(shown.notes.is_empty(), "{:?}", shown.notes);
        let [step, waves @ ..] = &shown.runs[..] else { panic!("a step first") };
        let reach = figures.reach.1 - figures.reach.0;
        let jump = step.reference.last().unwrap() - step.reference[0];
        assert!((jump / reach - 0.1).abs() < 1e-9, "{jump}");
        for position in [&step.complete.0, &step.feedback] {
            let left = (position.last().unwrap() - step.reference.last().unwrap()).abs();
            assert!(left < 0.05 * jump, "{left}");
        }
        assert_eq!(waves.len(), figures.checks.len());
        for (wave, check) in waves.iter().zip(&figures.checks) {
            let rms = |position: &[f64]| {
                let squares = wave.reference.iter().zip(position).map(|(r, y)| (r - y).powi(2));
                (squares.sum::<f64>() / position.len() as f64).sqrt() / reach
            };
            assert_eq!(wave.wave, Some(check.frequency));
            assert!((rms(&wave.complete.0) - check.closed_loop).abs() < 1e-12);
            assert!((rms(&wave.feedback) - check.feedback).abs() < 1e-12);
            let alone = wave.feedforward.as_ref().map(|position| rms(position));
            let both = alone.zip(check.feedforward);
            assert!(both.is_some_and(|(a, b)| (a - b).abs() < 1e-12), "{both:?}");
        }
    }
}

#[test]
fn without_feedback_there_is_no_loop_to_show() {
    let forward = ControlSettings { feedback: Feedback::None, ..settings(5e-3) };
    let (_, shown) = of("p0", &forward);
    assert!(shown.iter().all(|axis| axis.curves.is_none() && axis.runs.len() > 1));
}
