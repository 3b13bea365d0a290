//! Gains from experiments on a machine: the ultimate gain, Ziegler and Nichols' rules, and loop
//! shaping on a measured step response.
//!
//! A machine is a function: a command that is held over one period of the controller, and the position at
//! its end. All commands stay within ± `amplitude` of a working point, at which the machine has
//! settled.
//!
//! * [`relay`]: u = middle ± amplitude, by the sign of the error. The loop oscillates where its phase
//!   is −180°; the ratio of the first harmonics of command and position over whole periods is the
//!   ultimate gain K_u, their period T_u.
//! * [`ultimate_by_gain`]: proportional control after a small push; K_u is between the greatest gain whose
//!   oscillation decays and the least one whose does not, found by bisection.
//! * [`ziegler_nichols`]: kp = 0.6·K_u, ki = 1.2·K_u/T_u, kd = 0.075·K_u·T_u.
//! * [`robust`]: the gains of the largest integral part under a bound on the sensitivity (see
//!   `invert`), for the impulse response that a step shows.
//!
//! Source: J. G. Ziegler, N. B. Nichols, Trans. ASME 64 (1942) 759–768; K. J. Åström, T. Hägglund,
//! Automatica 20 (1984) 645–651 (relay).

use core::f64::consts::{PI, TAU};

use nalgebra::Complex;
use serde::Serialize;

use super::loop_shape::{Limits, Response, Shape, margins, sensitivity, shape};
use identify::Error;

/// The position at the end of one period with a command.
pub type Machine<'a> = dyn FnMut(f64) -> Result<f64, Error> + 'a;

/// Gains of a PID law (`pid`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Gains {
    /// Command per position.
    pub kp: f64,
    /// Command per position and second.
    pub ki: f64,
    /// Command-seconds per position.
    pub kd: f64,
    /// Time constant of the derivative's filter in s.
    pub derivative_filter: f64,
}

/// The limit of stability of a loop with proportional control.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ultimate {
    /// K_u in command per position.
    pub gain: f64,
    /// T_u in s.
    pub period: f64,
    /// Amplitude of the position's oscillation.
    pub amplitude: f64,
}

/// The linear response of the machine, and the open loop with given gains, over frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopCurves {
    /// In Hz, up to half the sample rate.
    pub frequency: Vec<f64>,
    /// Position per command, as the controller's samples see it.
    pub plant: Vec<Complex<f64>>,
    /// L.
    pub open: Vec<Complex<f64>>,
}

/// What a loop does for given gains, on the linear response of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopVerdict {
    /// Whether the loop settles.
    pub stable: bool,
    /// By how much the gain may grow.
    pub gain_margin: f64,
    /// In degrees.
    pub phase_margin: f64,
    /// Greatest |1/(1 + L)|.
    pub sensitivity: f64,
    /// Frequency up to which disturbances of the position are attenuated, |1/(1 + L)| < 1, in Hz.
    pub rejection_bandwidth: f64,
    /// Frequencies in Hz and |1/(1 + L)| there.
    pub disturbance: Vec<(f64, f64)>,
}

/// The classical rules for PID control.
#[must_use]
pub fn ziegler_nichols(ultimate: &Ultimate) -> Gains {
    let Ultimate { gain, period, .. } = *ultimate;
    Gains {
        kp: 0.6 * gain,
        ki: 1.2 * gain / period,
        kd: 0.075 * gain * period,
        derivative_filter: 0.0,
    }
}

fn refuse<T>(message: String) -> Result<T, Error> {
    Err(Error::Tuning { message })
}

/// Samples over which a machine settles, at most.
const SETTLE: usize = 20_000;

/// Holds `command` until the position of 50 samples moves by less than `band`; the position, and the
/// standard deviation of the last 50 samples.
fn settle(machine: &mut Machine<'_>, command: f64, band: f64) -> Result<(f64, f64), Error> {
    let mut before = f64::NAN;
    let mut spread = 0.0;
    for _ in 0..SETTLE / 50 {
        let block: Vec<f64> = (0..50).map(|_| machine(command)).collect::<Result<_, _>>()?;
        let mean = block.iter().sum::<f64>() / 50.0;
        spread = (block.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / 50.0).sqrt();
        let done = (mean - before).abs() <= band.max(3.0 * spread / 7.0);
        before = mean;
        if done {
            break;
        }
    }
    Ok((before, spread))
}

/// The relay experiment about the command `middle`, over `periods` oscillations at most.
///
/// # Errors
/// [`Error::Tuning`] where the position does not answer, or does not oscillate.
pub fn relay(
    machine: &mut Machine<'_>,
    period: f64,
    [middle, amplitude]: [f64; 2],
    periods: usize,
) -> Result<Ultimate, Error> {
    let (low, _) = settle(machine, middle - amplitude, 0.0)?;
    let (high, _) = settle(machine, middle + amplitude, 0.0)?;
    let slope = (high - low) / (2.0 * amplitude);
    let (target, noise) = settle(machine, middle, 1e-4 * (high - low).abs())?;
    if !(slope.is_finite() && (high - low).abs() > 6.0 * noise) {
        return refuse(format!(
            "the position moves by {:.3e} for a command of {middle} ± {amplitude}, no more than its \
             noise ({noise:.3e}); give a larger amplitude, or another axis",
            high - low
        ));
    }
    // A little hysteresis keeps noise from switching.
    let band = 2.0 * noise;
    let sign = slope.signum();
    let (mut up, mut y) = (true, target);
    let (mut u, mut position, mut switches) = (Vec::new(), Vec::new(), Vec::new());
    while switches.len() < 2 * periods + 1 && u.len() < SETTLE {
        let error = sign * (target - y);
        if (up && error < -band) || (!up && error > band) {
            up = !up;
            if up {
                switches.push(u.len());
            }
        }
        let command = middle + if up { sign * amplitude } else { -sign * amplitude };
        y = machine(command)?;
        u.push(command);
        position.push(y);
    }
    // The first half is run-in.
    let Some((first, last)) = switches.get(switches.len() / 2).zip(switches.last()) else {
        return refuse("the loop with a relay does not oscillate; give a larger amplitude".into());
    };
    let cycles = switches.len() - 1 - switches.len() / 2;
    if cycles == 0 {
        return refuse(format!(
            "{} oscillations in {} samples are too few; give a larger amplitude or a shorter period",
            switches.len(),
            u.len()
        ));
    }
    let samples = last - first;
    // The position of a command is measured at the end of its period, which the next command answers.
    let harmonic = |values: &[f64], late: usize| -> Complex<f64> {
        (0..samples)
            .map(|k| {
                let angle = -TAU * cycles as f64 * (k + late) as f64 / samples as f64;
                Complex::from_polar(values[first + k], angle)
            })
            .sum()
    };
    let (drive, answer) = (harmonic(&u, 0).norm(), harmonic(&position, 1).norm());
    if answer.is_nan() || answer <= 0.0 {
        return refuse("the position does not follow the relay; give a larger amplitude".into());
    }
    Ok(Ultimate {
        gain: sign * drive / answer,
        period: samples as f64 * period / cycles as f64,
        amplitude: 2.0 * answer / samples as f64,
    })
}

/// The ultimate gain by proportional control about the command `middle`: bisection over the gain
/// between decay and growth of what a push of `amplitude` starts.
///
/// # Errors
/// [`Error::Tuning`] where no gain makes the loop oscillate.
pub fn ultimate_by_gain(
    machine: &mut Machine<'_>,
    period: f64,
    [middle, amplitude]: [f64; 2],
) -> Result<Ultimate, Error> {
    let (low, _) = settle(machine, middle - amplitude, 0.0)?;
    let (high, _) = settle(machine, middle + amplitude, 0.0)?;
    let slope = (high - low) / (2.0 * amplitude);
    if !(slope.is_finite() && slope != 0.0) {
        return refuse("the position does not answer the command; check the axis".into());
    }
    /// Samples of one trial.
    const TRIAL: usize = 400;
    let mut trial = |kp: f64| -> Result<(f64, f64, f64), Error> {
        let (target, _) = settle(machine, middle, 1e-4 * (high - low).abs())?;
        let mut y = machine(middle + amplitude)?;
        let mut errors = Vec::with_capacity(TRIAL);
        for _ in 0..TRIAL {
            let command = middle + (kp * (target - y)).clamp(-amplitude, amplitude);
            y = machine(command)?;
            errors.push(y - target);
        }
        let swing = |part: &[f64]| {
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            (part.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / part.len() as f64).sqrt()
        };
        let (early, late) = (&errors[TRIAL / 8..3 * TRIAL / 8], &errors[3 * TRIAL / 4..]);
        let mean = late.iter().sum::<f64>() / late.len() as f64;
        let ups = late.windows(2).enumerate().filter(|(_, w)| w[0] < mean && w[1] >= mean);
        // Interpolated, as few samples make an oscillation.
        let ups: Vec<f64> = ups.map(|(k, w)| k as f64 + (mean - w[0]) / (w[1] - w[0])).collect();
        let waves = (ups.len().max(2) - 1) as f64;
        let length = ups.last().zip(ups.first()).map_or(0.0, |(b, a)| (b - a) / waves);
        Ok((swing(late) / swing(early), length * period, 2.0_f64.sqrt() * swing(late)))
    };
    let grows =
        |found: (f64, f64, f64)| found.0 > 0.97 && found.2 > 0.05 * (slope * amplitude).abs();
    let (mut least, mut most) = (0.0, 0.25 / slope);
    let mut at_most = trial(most)?;
    while !grows(at_most) {
        least = most;
        most *= 2.0;
        if (most * slope).abs() > 1e6 {
            return refuse(
                "no proportional gain makes the loop oscillate; use --method shape".into(),
            );
        }
        at_most = trial(most)?;
    }
    for _ in 0..12 {
        let between = 0.5 * (least + most);
        let found = trial(between)?;
        if grows(found) {
            (most, at_most) = (between, found);
        } else {
            least = between;
        }
    }
    Ok(Ultimate { gain: 0.5 * (least + most), period: at_most.1, amplitude: at_most.2 })
}

/// The impulse response h_1, h_2, … from command to position, one value per period, from `repeats`
/// steps up and down by `amplitude` about `middle`; the last value is that after `samples` periods.
///
/// # Errors
/// What the machine says.
pub fn impulse_of(
    machine: &mut Machine<'_>,
    [middle, amplitude]: [f64; 2],
    samples: usize,
    repeats: usize,
) -> Result<Vec<f64>, Error> {
    let mut step = vec![0.0; samples];
    for _ in 0..repeats.max(1) {
        for sign in [1.0, -1.0] {
            let from = middle - sign * amplitude;
            let (mut before, _) = (0.0, settle(machine, from, 0.0)?);
            for _ in 0..20 {
                before += machine(from)? / 20.0;
            }
            for value in &mut step {
                let y = machine(middle + sign * amplitude)?;
                *value += sign * (y - before) / (4.0 * amplitude * repeats.max(1) as f64);
            }
        }
    }
    let mut last = 0.0;
    Ok(step
        .iter()
        .map(|value| {
            let difference = value - last;
            last = *value;
            difference
        })
        .collect())
}

/// The gains with the largest integral part whose loop keeps max |1/(1 + L)| ≤ `most` and amplifies
/// white noise of the sensor at most `noise` times on its way to the command, as a position. The loop
/// keeps it with and without one period of computing: a light mode that a delay turns out of harm's way
/// may be in it without the delay.
///
/// # Errors
/// [`Error::Tuning`] where none does.
pub fn robust(impulse: &[f64], period: f64, most: f64, noise: f64) -> Result<Gains, Error> {
    let slope: f64 = impulse.iter().sum();
    // How long the response takes: the mean time of its impulse response.
    let mean = impulse.iter().zip(1..).map(|(h, k)| h * f64::from(k)).sum::<f64>() / slope;
    let lag = (mean.clamp(1.0, impulse.len() as f64) - 0.5) * period;
    let computing = Response::new(without_tail(impulse), period, &[]);
    let response = [computing.at_once(), computing];
    let limits = Limits { sensitivity: most, noise };
    let mut best = None;
    for a in [0.0, 0.15, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0].map(|x| x * lag) {
        for b in [0.0, 0.1, 0.25, 0.5].map(|x| x * a * a) {
            for filter in [0.0, 2.0 * period] {
                if b == 0.0 && filter > 0.0 {
                    continue;
                }
                let tried = Shape { name: "PID", a, b, filter };
                let Some(found) = shape(&response, tried, slope, limits) else { continue };
                if best.is_none_or(|(ki, _): (f64, Shape)| found.ki.abs() > ki.abs()) {
                    best = Some((found.ki, tried));
                }
            }
        }
    }
    let Some((ki, shape)) = best else {
        return refuse(format!(
            "no gains keep the sensitivity below {most}; allow more, or take a shorter period"
        ));
    };
    Ok(Gains { kp: ki * shape.a, ki, kd: ki * shape.b, derivative_filter: shape.filter })
}

/// Margins of the loop with `gains`, around the machine with this impulse response. `computing` adds
/// one period of delay, as of a controller that needs it or a master that exchanges side by side.
#[must_use]
pub fn judge_loop(
    impulse: &[f64],
    period: f64,
    gains: &Gains,
    computing: bool,
    frequencies: &[f64],
) -> LoopVerdict {
    let LoopCurves { frequency, open, .. } = loop_curves(impulse, period, gains, computing);
    let (gain_margin, phase_margin) = margins(&open, 1.0, false);
    let one = Complex::new(1.0, 0.0);
    let gain_of = |l: &Complex<f64>| 1.0 / (one + l).norm();
    let crossing = open.iter().position(|l| gain_of(l) >= 1.0).unwrap_or(open.len() - 1);
    let at = |wanted: f64| {
        let near = frequency.partition_point(|f| *f < wanted).min(open.len() - 1);
        (wanted, gain_of(&open[near]))
    };
    LoopVerdict {
        stable: settles(impulse, period, gains, computing),
        gain_margin,
        phase_margin: phase_margin * 180.0 / PI,
        sensitivity: sensitivity(&open, 1.0),
        rejection_bandwidth: frequency[crossing],
        disturbance: frequencies.iter().map(|f| at(*f)).collect(),
    }
}

/// The open loop L of a PID law with these gains on a machine with this impulse response, sample by
/// sample of `period` s; `computing`: with one period more for computing.
#[must_use]
pub fn loop_curves(impulse: &[f64], period: f64, gains: &Gains, computing: bool) -> LoopCurves {
    let response = Response::new(without_tail(impulse), period, &[]);
    let keep =
        if gains.derivative_filter > 0.0 { (-period / gains.derivative_filter).exp() } else { 0.0 };
    let one = Complex::new(1.0, 0.0);
    let open_at = |angle: f64, plant: Complex<f64>| {
        let back = Complex::from_polar(1.0, -angle);
        let difference = one - back;
        let slope = difference * (1.0 - keep) / (one - back * keep);
        let law = Complex::new(gains.kp, 0.0)
            + gains.ki * period / difference
            + slope * (gains.kd / period);
        // The response holds one period of computing.
        law * if computing { plant } else { plant / back }
    };
    let pairs = || response.angles.iter().zip(&response.values);
    LoopCurves {
        frequency: response.angles.iter().map(|angle| angle / (TAU * period)).collect(),
        open: pairs().map(|(angle, plant)| open_at(*angle, *plant)).collect(),
        plant: pairs()
            .map(
                |(angle, plant)| {
                    if computing { *plant } else { plant / Complex::from_polar(1.0, -angle) }
                },
            )
            .collect(),
    }
}

/// An impulse response without its end, which adds up to less than 1e-12 of the whole.
fn without_tail(impulse: &[f64]) -> &[f64] {
    let mut rest = 1e-12 * impulse.iter().map(|h| h.abs()).sum::<f64>();
    let is_nothing = |h: &&f64| {
        rest -= h.abs();
        rest >= 0.0
    };
    &impulse[..impulse.len() - impulse.iter().rev().take_while(is_nothing).count()]
}

/// Whether a push dies away in the linear loop.
fn settles(impulse: &[f64], period: f64, gains: &Gains, computing: bool) -> bool {
    let steps = 12 * impulse.len().max(100);
    let impulse = without_tail(impulse);
    let length = impulse.len();
    let keep =
        if gains.derivative_filter > 0.0 { (-period / gains.derivative_filter).exp() } else { 0.0 };
    let (mut sum, mut last, mut slope) = (0.0, 0.0, 0.0);
    let mut commands = vec![0.0];
    let mut worst = [0.0_f64; 2];
    for k in 0..steps {
        let newest = commands.len() - usize::from(computing);
        let reach = newest.min(length);
        let answer: f64 = (0..reach).map(|i| impulse[i] * commands[newest - 1 - i]).sum();
        let push = if k == 0 { 1.0 } else { 0.0 };
        let error = -(answer + push);
        sum += gains.ki * period * error;
        slope = keep * slope + (1.0 - keep) * (error - last);
        last = error;
        commands.push(gains.kp * error + sum + gains.kd / period * slope);
        let part = 2 * k / steps;
        worst[part] = worst[part].max(error.abs());
        if !error.is_finite() || error.abs() > 1e6 {
            return false;
        }
    }
    worst[1] < 0.5 * worst[0]
}

#[cfg(test)]
mod tests;
