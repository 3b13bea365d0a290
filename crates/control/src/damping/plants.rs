//! The plants of the grid, and the search of the gains on them.

use core::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2, TAU};

use nalgebra::Complex;
use numerics::fft::Fft;

use super::gains::Gains;
use super::{BEYOND, DampedPlant, Damping, slopes};
use crate::design::CommandActs;
use crate::linearised::LIGHT;
use crate::loop_shape::{Limits, transfers};
use crate::nyquist::Round;
use crate::search::evolve;

/// Greatest |G·S| over the gain at rest: an eighth of critical damping.
const PEAK: f64 = 4.0;
/// Part of a step within which the position has settled.
const BAND: f64 = 0.02;
/// Swings of the resonance for which a step is looked at, and the highest frequency over the resonance.
const SWINGS: (f64, f64) = (40.0, 16.0);
/// Sets of gains per gain that is sought, and rounds.
const SEARCH: (usize, usize) = (10, 60);

/// A cost from which on a law breaks a limit; below it, from [`SHORT`] on, its bandwidth is too small.
pub(super) const UNFIT: f64 = 20.0;
const SHORT: f64 = 10.0;

/// A set of gains.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) law: Damping,
    pub(super) gains: Gains,
    pub(super) cost: f64,
}

/// All plants of the grid, of slope 1 at their steepest.
pub(super) struct Plants {
    pub(super) period: f64,
    /// The resonance in rad per sample.
    pub(super) first: f64,
    pub(super) slope: f64,
    /// Slopes over the steepest: mean, least, steepest.
    pub(super) slopes: [f64; 3],
    pub(super) angles: Vec<f64>,
    /// z⁻¹ at the angles.
    pub(super) back: Vec<Complex<f64>>,
    /// Each plant at the angles; the first ones are the plant as given, for each time at which a command acts.
    pub(super) values: Vec<Vec<Complex<f64>>>,
    /// How many these are.
    pub(super) given: usize,
    /// z⁻¹ and the plant as given (the later of the commands) at even frequencies, and the time between the values of a
    /// step response that they tell.
    even: (Vec<Complex<f64>>, Vec<Complex<f64>>, f64),
    inverse: Fft,
}

impl Plants {
    pub(super) fn of(axis_plant: &DampedPlant<'_>, acts: CommandActs) -> Result<Self, String> {
        let (period, slope) = (axis_plant.period, axis_plant.slopes.0);
        let light = || axis_plant.modes.iter().filter(|(_, damping)| *damping < LIGHT);
        let first = light().map(|(frequency, _)| *frequency).fold(f64::INFINITY, f64::min);
        if first.is_infinite() {
            return Err(format!(
                "has no mode with a damping ratio below {LIGHT} that could be damped; leave --damping out"
            ));
        }
        let first = TAU * first * period;
        if first > 0.25 * PI {
            return Err(format!(
                "its resonance of {:.4} Hz needs a controller with at least 8 samples of it; give a --period of at most \
                 {:.3e} s",
                first / (TAU * period),
                period * 0.25 * PI / first
            ));
        }
        let modes: Vec<(f64, f64)> =
            light().map(|(f, damping)| (TAU * f * period, *damping)).collect();
        let angles = angles(first, &modes);
        let back: Vec<Complex<f64>> =
            angles.iter().map(|angle| Complex::from_polar(1.0, -angle)).collect();
        let (at_once, later) = match acts {
            CommandActs::Either => (true, true),
            CommandActs::AtOnce => (true, false),
            CommandActs::NextPeriod => (false, true),
        };
        let mut values = Vec::new();
        for impulse in axis_plant.impulses {
            let own: Vec<Complex<f64>> =
                transfers(impulse, &angles).into_iter().map(|value| value / slope).collect();
            if at_once {
                values.push(own.iter().zip(&back).map(|(value, back)| value / back).collect());
            }
            if later {
                values.push(own);
            }
        }
        let slopes = slopes(slope, axis_plant.slopes.1);
        let nominal = axis_plant.impulses.first().ok_or("it has no response")?;
        let even = even(nominal, first, slope, later, period);
        let inverse = Fft::inverse(2 * (even.0.len() - 1));
        let given = usize::from(at_once) + usize::from(later);
        Ok(Self { period, first, slope, slopes, angles, back, values, given, even, inverse })
    }

    /// The best gains of a law.
    pub(super) fn search(&self, law: Damping, derivative: bool, limits: Limits) -> Found {
        let bounds = law.bounds(derivative);
        let logs: Vec<(f64, f64)> = bounds.iter().map(|(a, b)| (a.ln(), b.ln())).collect();
        let cost = |x: &[f64]| {
            let values: Vec<f64> = x.iter().map(|x| x.exp()).collect();
            self.cost(&Gains::of(law, &values, self.first), limits)
        };
        let (x, cost) = evolve(&logs, SEARCH, cost);
        let values: Vec<f64> = x.iter().map(|x| x.exp()).collect();
        Found { law, gains: Gains::of(law, &values, self.first), cost }
    }

    /// C and D at all angles.
    pub(super) fn laws(&self, gains: &Gains) -> Vec<(Complex<f64>, Complex<f64>)> {
        self.back.iter().map(|back| gains.at(*back)).collect()
    }

    pub(super) fn cost(&self, gains: &Gains, limits: Limits) -> f64 {
        let noise = gains.noise();
        if noise > limits.noise {
            return 4.0 * UNFIT + (noise / limits.noise).min(100.0);
        }
        let laws = self.laws(gains);
        let is_notch = gains.law == Damping::Notch;
        let (mut worst, mut peak, mut unstable) = (0.0_f64, 0.0_f64, 0);
        for plant in &self.values {
            for slope in self.slopes {
                match self.sensitivity(&laws, plant, slope) {
                    Some(found) => (worst, peak) = (worst.max(found.0), peak.max(found.1)),
                    None => unstable += 1,
                }
            }
        }
        if unstable > 0 {
            return 3.0 * UNFIT + f64::from(unstable) / 1e3;
        }
        // A notch damps nothing.
        let peak = if is_notch { 0.0 } else { peak / PEAK };
        let excess = (worst / limits.sensitivity).max(peak);
        if excess > 1.0 {
            return UNFIT + (excess - 1.0).min(10.0);
        }
        let wanted = if is_notch { 0.0 } else { BEYOND };
        let width = self.bandwidth(&laws) / self.first;
        if width < wanted {
            return SHORT + wanted - width;
        }
        if !is_notch && !self.inner_is_stable(&laws) {
            return 2.0 * UNFIT;
        }
        let each = self.slopes.iter().map(|slope| self.settling(gains, *slope));
        let mean = each.sum::<f64>() / self.slopes.len() as f64 * self.first / (TAU * self.period);
        0.9 * SHORT * mean / (mean + 4.0)
    }

    /// Greatest |S| and |G·S|; `None` where the loop is not stable.
    pub(super) fn sensitivity(
        &self,
        laws: &[(Complex<f64>, Complex<f64>)],
        plant: &[Complex<f64>],
        slope: f64,
    ) -> Option<(f64, f64)> {
        let mut round = Round::default();
        let (mut least, mut peak) = (f64::INFINITY, 0.0_f64);
        for (((outer, inner), plant), back) in laws.iter().zip(plant).zip(&self.back) {
            let one_plus = 1.0 + (outer - inner) * plant * slope;
            let size = one_plus.norm_sqr();
            // What is not finite is not stable either.
            least = if size >= least { least } else { size };
            peak = peak.max(plant.norm_sqr() / size);
            round.go(one_plus * (1.0 - back));
        }
        (round.is_none() && least > 0.0).then(|| (1.0 / least.sqrt(), slope * peak.sqrt()))
    }

    /// Whether the inner loop is stable by itself on all plants.
    pub(super) fn inner_is_stable(&self, laws: &[(Complex<f64>, Complex<f64>)]) -> bool {
        self.values.iter().all(|plant| {
            self.slopes.iter().all(|slope| {
                let mut round = Round::default();
                for ((_, inner), plant) in laws.iter().zip(plant) {
                    round.go(1.0 - inner * plant * *slope);
                }
                round.is_none()
            })
        })
    }

    /// Up to which angle |T| stays within 3 dB on the plant as given at its mean slope.
    pub(super) fn bandwidth(&self, laws: &[(Complex<f64>, Complex<f64>)]) -> f64 {
        let plants = self.values[..self.given].iter();
        plants.map(|plant| self.width(laws, plant, self.slopes[0])).fold(PI, f64::min)
    }

    pub(super) fn width(
        &self,
        laws: &[(Complex<f64>, Complex<f64>)],
        plant: &[Complex<f64>],
        slope: f64,
    ) -> f64 {
        let closed = laws.iter().zip(plant).map(|((outer, inner), plant)| {
            let plant = plant * slope;
            (outer * plant / (1.0 + (outer - inner) * plant)).norm()
        });
        self.within(closed)
    }

    /// The angle up to which a response stays within 3 dB.
    pub(super) fn within(&self, mut response: impl Iterator<Item = f64>) -> f64 {
        let leaves = |size: f64| !(FRAC_1_SQRT_2..=SQRT_2).contains(&size);
        response.position(leaves).map_or(PI, |at| self.angles[at])
    }

    /// Time after which a step of the reference stays within its band, with the later of the commands.
    pub(super) fn settling(&self, gains: &Gains, slope: f64) -> f64 {
        let (back, plant, step) = &self.even;
        let count = back.len() - 1;
        let mut lines = vec![Complex::new(0.0, 0.0); 2 * count];
        lines[0] = Complex::new(1.0, 0.0);
        for k in 1..=count {
            let (outer, inner) = gains.at(back[k]);
            let plant = plant[k] * slope;
            let closed = outer * plant / (1.0 + (outer - inner) * plant);
            lines[k] = if k == count { Complex::new(closed.re, 0.0) } else { closed };
            lines[2 * count - k] = lines[k].conj();
        }
        self.inverse.process(&mut lines);
        let (mut position, mut last) = (0.0, 0);
        // The end holds what is in front of the step of a response with an upper frequency.
        for (k, line) in lines.iter().take(lines.len() * 9 / 10).enumerate() {
            position += line.re / lines.len() as f64;
            let off = (position - 1.0).abs();
            if off > BAND || off.is_nan() {
                last = k + 1;
            }
        }
        last as f64 * step
    }
}

/// Angles from low ones up to half the sample rate: dense about the first resonance, denser at the modes.
fn angles(first: f64, modes: &[(f64, f64)]) -> Vec<f64> {
    let mut angles: Vec<f64> = (0..=160).map(|k| PI * 10f64.powf(-f64::from(k) / 40.0)).collect();
    angles.extend((0..=230).map(|k| 0.3 * first * 1.01_f64.powi(k)));
    for (centre, damping) in modes {
        // A third of the half-power width at half the damping.
        let count = (0.34 / (0.3 * damping)).clamp(80.0, 600.0).ceil();
        angles.extend((0..=count as usize).map(|k| centre * (0.83 + 0.34 * k as f64 / count)));
    }
    angles.retain(|angle| *angle <= PI);
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    angles
}

/// z⁻¹ and the plant at even frequencies from 0 on, by the Fourier transform of the impulse response over some swings of
/// the resonance, and the time between the values of a signal with these frequencies.
fn even(
    impulse: &[f64],
    first: f64,
    slope: f64,
    later: bool,
    period: f64,
) -> (Vec<Complex<f64>>, Vec<Complex<f64>>, f64) {
    let length = ((SWINGS.0 * TAU / first).ceil() as usize).next_multiple_of(64);
    let mut folded = vec![0.0; length];
    for (k, h) in (1 + usize::from(later)..).zip(impulse) {
        folded[k % length] += h / slope;
    }
    let lines = Fft::forward(length).of_real(&folded);
    let highest = (SWINGS.1 * first / TAU * length as f64).ceil() as usize;
    let count = highest.min(length / 2);
    let back = |k: usize| Complex::from_polar(1.0, -TAU * k as f64 / length as f64);
    let plant = lines[..=count].iter().map(|line| Complex::new(line.re, line.im)).collect();
    ((0..=count).map(back).collect(), plant, period * length as f64 / (2 * count) as f64)
}
