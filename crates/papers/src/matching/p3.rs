//! P3, nanopositioning stage P66X30.

use anyhow::anyhow;
use data::CheckedBlueprint;
use model::System;

use super::baseline::{Baseline, error};
use super::{Figure, Response, command, driven, extremes, position, rest, rig, rms};
use crate::machines;

const RIG: &str = machines::P3;
/// Amplifier of the rig: the paper's volts are at the actuator.
const AMPLIFIER: f64 = 15.0;
/// Greatest command of the chirp, in V.
const TOP: f64 = 30.0 / AMPLIFIER;

/// Name, signal, its settings, NRMSE.
pub(crate) type Printed = (&'static str, &'static str, &'static [(&'static str, f64)], f64);

/// Table 1's column of the MPI model.
pub(crate) const MPI: &[Printed] = &[
    ("100 Hz", "p3-sine", &[("frequency", 100.0)], 0.6497),
    ("200 Hz", "p3-sine", &[("frequency", 200.0)], 1.1673),
    ("300 Hz", "p3-sine", &[("frequency", 300.0)], 2.9334),
    ("500 Hz", "p3-sine", &[("frequency", 500.0)], 3.2692),
    ("1 kHz", "p3-sine", &[("frequency", 1000.0)], 4.9547),
    ("120 + 180 Hz", "p3-two-tone", &[], 2.1251),
    ("four tones", "p3-four-tone", &[], 2.8872),
    ("50 Hz triangle", "p3-triangle", &[], 2.1725),
];

/// The paper's baseline, fitted to the chirp.
pub(crate) fn mpi(chirp: &Response) -> anyhow::Result<CheckedBlueprint> {
    let thresholds = (0..11).map(|i| f64::from(i) * 0.5 * TOP / 11.0).collect();
    Baseline { method: Some("mpi"), thresholds, levels: 2, dynamic: false }.fit(&[chirp])
}

/// P3: the loop closed by the printed PI alone, rms of the error in percent of the reference's range.
pub(super) fn figures() -> anyhow::Result<Vec<Figure>> {
    let mut system = rig(RIG)?;
    let (low, high) = (rest(&mut system, &[0.0])?[0], rest(&mut system, &[10.0])?[0]);
    let mut all = vec![
        Figure::new(RIG, "range, 0 to 150 V at the actuator", "um", 26.52, high - low).of_rig(),
    ];
    for (frequency, paper) in [(100.0, 1.10), (500.0, 5.39), (1000.0, 11.1)] {
        let error = pi_loop(&mut system, frequency)?;
        let what = format!("PI alone, sine of {frequency} Hz, rms of range");
        all.push(Figure::new(RIG, what, "%", paper, error));
    }
    let of = |name: &str, settings: &[(&str, f64)]| driven(RIG, name, settings, 1.0 / AMPLIFIER);
    let mpi = mpi(&of("p3-chirp", &[])?)?;
    for &(what, name, settings, paper) in MPI {
        let run = of(name, settings)?;
        let (low, high) = extremes(run.after());
        let error = 100.0 * error(&mpi, &run)? / (high - low);
        all.push(Figure::new(RIG, format!("MPI model, {what}, rms of range"), "%", paper, error));
    }
    Ok(all)
}

/// The printed PI (Kp = 0.3, Ki = 20000 1/s, 20 kHz) on a sine of 0 to 10 um; command and position
/// scaled equally, as the paper does it.
fn pi_loop(system: &mut System, frequency: f64) -> anyhow::Result<f64> {
    const PERIOD: f64 = 50e-6;
    const RANGE: f64 = 10.0;
    // V per um over the range of the references.
    let gain = {
        let low = rest(system, &[0.0])?[0];
        RANGE / ((rest(system, &[RANGE])?[0] - low).abs()).max(f64::MIN_POSITIVE)
    };
    system.reset();
    rest(system, &[0.0])?;
    let zero = position(system, 1)?;
    let (mut integral, mut errors) = (0.0, Vec::new());
    let periods = 20.0;
    let count = (periods / frequency / PERIOD).round() as usize;
    for n in 0..count {
        let t = n as f64 * PERIOD;
        let angle = std::f64::consts::TAU * frequency * t;
        let reference = 0.5 * RANGE * (1.0 - angle.cos());
        let error = reference - (position(system, 1)? - zero);
        if t > 0.5 * periods / frequency {
            errors.push(error);
        }
        integral += 20_000.0 * PERIOD * error;
        command(system, 1, gain * (0.3 * error + integral))?;
        let end = (n + 1) as f64 * PERIOD;
        system.advance(end).map_err(|error| anyhow!(system.explain(&error)))?;
    }
    Ok(100.0 * rms(errors.iter().copied()) / RANGE)
}
