//! Control beyond the first resonance: a damping law in an inner loop and a PID law around it, designed together.
//!
//! With the machine G(z) (hold, delays and all), the tracking law C(z) and the damping law D(z) in positive feedback,
//!
//! ```text
//! L = (C − D)·G,   S = 1/(1 + L),   T = C·G/(1 + L)   (reference to position, without feedforward)
//! C = kp + ki·T/(1 − z⁻¹) + kd·(1 − z⁻¹)/T·(1 − f)/(1 − f·z⁻¹)
//! D = gain·F(z),   F as in the components, F(1) = 1
//! ```
//!
//! Of all laws with
//!
//! ```text
//! stable loop and |S| ≤ M            for each plant of the grid
//! |G·S| ≤ 4·G(1)                     the same: the resonance is damped, and not hidden behind a zero of the law
//! gain·G(1) ≤ 0.9, 1 − D·G stable    the inner loop is stable alone (negative imaginary systems: gain·G(1) < 1)
//! noise from sensor to command ≤ its limit
//! ```
//!
//! the one is taken that settles first (2 % of a step, mean over the slopes) among those whose |T| stays within 3 dB up
//! to 1.15 times the resonance, or, where there is none of these, the one whose |T| does so the furthest. The grid: the
//! modes' frequencies 10 and 5 % lower and higher, their damping halved and doubled, the slope of the hysteresis least,
//! mean and steepest, the command acting at once and one period later. A loop is stable where the curve of
//! (1 − z⁻¹)(1 + L) on the upper half of the unit circle does not go round zero (L is stable but for its integrator).
//! The search is differential evolution over the logarithms of all gains, the same at every run.
//!
//! Sources: as of the component; R. Storn, K. Price, Journal of Global Optimization 11 (1997) 341–359 (the search).

use core::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2, TAU};

use data::ComponentBlueprint;
use nalgebra::Complex;
use numerics::fft::Fft;
use serde::Serialize;

use crate::design::CommandActs;
use crate::linearised::LIGHT;
use crate::loop_shape::{Limits, Shape, Shaped, transfer};
use crate::random::Uniform;

/// Factors of the modes' frequencies and dampings that the loop is made for; the first are the plant as given.
pub(crate) const FREQUENCIES: [f64; 5] = [1.0, 0.9, 0.95, 1.05, 1.1];
pub(crate) const DAMPINGS: [f64; 3] = [1.0, 0.5, 2.0];
/// The bandwidth that is wanted, over the resonance.
const BEYOND: f64 = 1.15;
/// Greatest |G·S| over the gain at rest: an eighth of critical damping.
const PEAK: f64 = 4.0;
/// Greatest gain of the inner loop at rest.
const INNER: f64 = 0.9;
/// Part of a step within which the position has settled.
const BAND: f64 = 0.02;
/// Swings of the resonance for which a step is looked at, and the highest frequency over the resonance.
const SWINGS: (f64, f64) = (40.0, 16.0);
/// Sets of gains per gain that is sought, rounds, and the part of the gains that is exchanged.
const SEARCH: (usize, usize, f64) = (10, 60, 0.7);

/// How the first resonance is damped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Damping {
    /// Not at all.
    #[default]
    None,
    /// The law of the three that settles first.
    Automatic,
    /// Integral resonant control.
    IntegralResonant,
    /// Positive position feedback.
    PositivePosition,
    /// Non-minimum-phase damping.
    NonMinimumPhase,
    /// PI with a notch: nothing is damped, the resonance is left out.
    Notch,
}

impl Damping {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::None,
        Self::Automatic,
        Self::IntegralResonant,
        Self::PositivePosition,
        Self::NonMinimumPhase,
        Self::Notch,
    ];
    /// Those that damp.
    const LAWS: [Self; 3] = [Self::NonMinimumPhase, Self::IntegralResonant, Self::PositivePosition];

    /// Its name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Automatic => "automatic",
            Self::IntegralResonant => "irc",
            Self::PositivePosition => "ppf",
            Self::NonMinimumPhase => "nrc",
            Self::Notch => "notch",
        }
    }

    /// One sentence.
    #[must_use]
    pub const fn summary(self) -> &'static str {
        match self {
            Self::None => "no inner loop",
            Self::Automatic => "the one of irc, ppf and nrc that settles first",
            Self::IntegralResonant => "integral resonant control",
            Self::PositivePosition => "positive position feedback",
            Self::NonMinimumPhase => "non-minimum-phase resonant control",
            Self::Notch => "PI with a notch at the resonance, which stays undamped",
        }
    }

    /// What the loop is called.
    const fn loop_name(self) -> &'static str {
        match self {
            Self::IntegralResonant => "PID around integral resonant control",
            Self::PositivePosition => "PID around positive position feedback",
            Self::NonMinimumPhase => "PID around non-minimum-phase damping",
            _ => "PI with a notch",
        }
    }

    /// Its component.
    const fn kind(self) -> &'static str {
        match self {
            Self::IntegralResonant => "integral-resonant-control",
            Self::PositivePosition => "positive-position-feedback",
            Self::NonMinimumPhase => "non-minimum-phase-damping",
            _ => "notch",
        }
    }

    /// Bounds of the gains that are sought, over the plant's slope and the resonance: those of the law, then kp, ki,
    /// kd and the corner of the derivative's filter.
    fn bounds(self, derivative: bool) -> Vec<(f64, f64)> {
        let mut bounds = match self {
            Self::PositivePosition => vec![(0.05, INNER), (0.3, 10.0), (0.1, 2.0)],
            Self::Notch => vec![(1e-3, 1.0), (0.05, 2.0)],
            _ => vec![(0.05, INNER), (0.1, 10.0)],
        };
        bounds.extend([(1e-3, 3.0), (1e-2, 3.0)]);
        if derivative && self != Self::Notch {
            bounds.extend([(1e-3, 5.0), (0.5, 30.0)]);
        }
        bounds
    }
}

/// What is known of a loop with a damped resonance. All of it is computed with the feedback alone on the linear parts,
/// but for `with_feedforward`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DampingFigures {
    /// `irc`, `ppf`, `nrc` or `notch`.
    pub law: &'static str,
    /// Gain of the inner loop in command per position; 0 for a notch.
    pub gain: f64,
    /// Frequency of its filter in Hz.
    pub frequency: f64,
    /// Damping ratio of its filter, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter_damping: Option<f64>,
    /// The first resonance in Hz.
    pub resonance: f64,
    /// Up to where |T| stays within 3 dB, in Hz: plant as given, mean slope, the later of the commands.
    pub closed_loop_bandwidth: f64,
    /// The least of these over all plants of the grid.
    pub least_closed_loop_bandwidth: f64,
    /// The same from reference to position with the inverse feedforward, on the plant as given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth_with_feedforward: Option<f64>,
    /// Time in s after which a step stays within 2 %: plant as given, mean slope.
    pub settling: f64,
    /// The longest of these over the slopes of the hysteresis.
    pub longest_settling: f64,
    /// The same times of PI with a notch that keeps the same limits on the same plants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub notch_settling: Option<(f64, f64)>,
    /// Greatest response to a disturbance of the command, |G·S|, over that at rest at the steepest slope, all plants.
    pub peak: f64,
    /// The same without control.
    pub undamped_peak: f64,
    /// Standard deviation of the command, as a position, per standard deviation of white sensor noise.
    pub noise: f64,
    /// Number of plants that the loop is stable on and keeps its sensitivity.
    pub plants: usize,
}

/// Lag and inertia of two leads one behind the other, that of the lightly damped first mode, and of the rest of what
/// is to be made up for: `lag` and `inertia` of both. So the third order of their product is made up for as well.
pub(crate) fn leads((lag, inertia): (f64, f64), modes: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let light = modes.iter().filter(|(_, damping)| *damping < LIGHT);
    let Some((frequency, damping)) = light.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return vec![(lag.max(0.0), inertia.max(0.0))];
    };
    let omega = TAU * frequency;
    let own = (2.0 * damping / omega, 1.0 / (omega * omega));
    let rest = lag - own.0;
    let left = inertia - own.1 - rest * own.0;
    vec![own, (rest.max(0.0), left.max(0.0))]
}

/// A damped loop.
#[derive(Clone, Debug)]
pub(crate) struct Damped {
    pub(crate) law: Damping,
    pub(crate) shaped: Shaped,
    pub(crate) figures: DampingFigures,
    depth: f64,
}

impl Damped {
    /// That the loop does not reach beyond the resonance, where it does not.
    pub(crate) fn shortfall(&self) -> Option<String> {
        let figures = &self.figures;
        let reached = figures.closed_loop_bandwidth / figures.resonance;
        (self.law != Damping::Notch && reached < BEYOND).then(|| {
            format!(
                "the closed loop stays within 3 dB up to {reached:.2} times the resonance only; with a period for \
                 computing, a mode needs some 35 samples a swing and a hysteresis that leaves the slope alone; a shorter \
                 --period or a larger --sensitivity reaches further"
            )
        })
    }

    /// The component of the law; `feedforward`: the command of an inverse comes in front of it.
    pub(crate) fn component(&self, feedforward: bool) -> ComponentBlueprint {
        let component = ComponentBlueprint::new(self.law.kind());
        let component = component.value("frequency", self.figures.frequency);
        let component = match self.figures.filter_damping {
            Some(damping) => component.value("damping", damping),
            None => component,
        };
        if self.law == Damping::Notch {
            return component.value("depth", self.depth);
        }
        let weight = if feedforward { 1.0 } else { 0.0 };
        component.value("gain", self.figures.gain).value("setpoint_weight", weight)
    }
}

/// The plant of an axis.
pub(crate) struct Around<'a> {
    /// Impulse responses at the steepest slope: for each of [`FREQUENCIES`] each of [`DAMPINGS`].
    pub(crate) impulses: &'a [Vec<f64>],
    /// Modes in Hz with their damping.
    pub(crate) modes: &'a [(f64, f64)],
    /// Steepest and least slope of the hysteresis.
    pub(crate) slopes: (f64, f64),
    /// Lag and inertia of each lead in front of the feedforward.
    pub(crate) leads: &'a [(f64, f64)],
    pub(crate) period: f64,
}

/// The damped loop of an axis.
///
/// # Errors
/// Why there is none.
pub(crate) fn damped(
    around: &Around<'_>,
    damping: Damping,
    derivative: bool,
    acts: CommandActs,
    limits: Limits,
) -> Result<Damped, String> {
    let plants = Plants::of(around, acts)?;
    let laws: &[Damping] = match damping {
        Damping::Automatic => &Damping::LAWS,
        _ => std::slice::from_ref(&damping),
    };
    let found = laws.iter().map(|law| plants.search(*law, derivative, limits));
    let best = found.min_by(|a, b| a.cost.total_cmp(&b.cost)).ok_or("no damping law")?;
    if best.cost >= UNFIT {
        return Err(format!(
            "no gains of {} keep the sensitivity below {} and the noise below {} on all plants with the modes' \
             frequencies up to 10 % off and their damping halved or doubled; allow a larger --sensitivity, or take a \
             shorter --period",
            damping.name(),
            limits.sensitivity,
            limits.noise
        ));
    }
    let notch = (best.law != Damping::Notch).then(|| plants.search(Damping::Notch, false, limits));
    Ok(plants.finished(&best, notch.filter(|notch| notch.cost < UNFIT).as_ref(), around))
}

/// A cost from which on a law breaks a limit; below it, from [`SHORT`] on, its bandwidth is too small.
const UNFIT: f64 = 20.0;
const SHORT: f64 = 10.0;

/// A set of gains.
#[derive(Clone, Debug)]
struct Found {
    law: Damping,
    gains: Gains,
    cost: f64,
}

/// Gains over the steepest slope, frequencies in rad per sample.
#[derive(Clone, Copy, Debug)]
struct Gains {
    law: Damping,
    /// Gain of the inner loop, or depth of the notch.
    gain: f64,
    angle: f64,
    damping: f64,
    kp: f64,
    /// ki·T.
    ki: f64,
    /// kd/T.
    kd: f64,
    /// What the derivative's filter keeps of its last value.
    keep: f64,
}

impl Gains {
    /// From the values that are sought; `first`: the resonance in rad per sample.
    fn of(law: Damping, x: &[f64], first: f64) -> Self {
        let (own, outer) = x.split_at(if law == Damping::PositivePosition { 3 } else { 2 });
        let (angle, damping) = match law {
            Damping::Notch => (first, own[1]),
            _ => (own[1] * first, own.get(2).copied().unwrap_or(1.0)),
        };
        let (kd, keep) = match outer {
            [_, _, kd, corner] => (kd / first, (-corner * first).exp()),
            _ => (0.0, 0.0),
        };
        let angle = angle.min(0.8 * PI);
        Self { law, gain: own[0], angle, damping, kp: outer[0], ki: outer[1] * first, kd, keep }
    }

    /// C and D where z⁻¹ is `back`.
    fn at(&self, back: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
        let one = Complex::new(1.0, 0.0);
        let difference = one - back;
        let mut outer = Complex::new(self.kp, 0.0) + self.ki / difference;
        if self.kd > 0.0 {
            outer += difference * (self.kd * (1.0 - self.keep)) / (one - back * self.keep);
        }
        let w = (0.5 * self.angle).tan();
        let (square, broad) = (w * w, 2.0 * self.damping * w);
        let denominator = || {
            one * (1.0 + square + broad)
                + back * (2.0 * (square - 1.0))
                + back * back * (1.0 + square - broad)
        };
        let sum = one + back;
        let low = || sum * w / (one * (1.0 + w) - back * (1.0 - w));
        let inner = match self.law {
            Damping::IntegralResonant => low(),
            Damping::NonMinimumPhase => low() * 2.0 - one,
            Damping::PositivePosition => sum * sum * square / denominator(),
            _ => {
                let left = broad * self.gain;
                let numerator = one * (1.0 + square + left)
                    + back * (2.0 * (square - 1.0))
                    + back * back * (1.0 + square - left);
                return (outer * numerator / denominator(), Complex::new(0.0, 0.0));
            }
        };
        (outer, inner * self.gain)
    }

    /// Standard deviation of C − D behind white noise, without the integral's sum of it.
    fn noise(&self) -> f64 {
        const POINTS: usize = 64;
        let rest = Self { ki: 0.0, ..*self };
        let each = (0..POINTS).map(|k| {
            let angle = PI * (k as f64 + 0.5) / POINTS as f64;
            let (outer, inner) = rest.at(Complex::from_polar(1.0, -angle));
            (outer - inner).norm_sqr()
        });
        (each.sum::<f64>() / POINTS as f64).sqrt()
    }
}

/// All plants of the grid, of slope 1 at their steepest.
struct Plants {
    period: f64,
    /// The resonance in rad per sample.
    first: f64,
    slope: f64,
    /// Slopes over the steepest: mean, least, steepest.
    slopes: [f64; 3],
    angles: Vec<f64>,
    /// z⁻¹ at the angles.
    back: Vec<Complex<f64>>,
    /// Each plant at the angles; the first ones are the plant as given, for each time at which a command acts.
    values: Vec<Vec<Complex<f64>>>,
    /// How many these are.
    given: usize,
    /// z⁻¹ and the plant as given (the later of the commands) at even frequencies, and the time between the values of a
    /// step response that they tell.
    even: (Vec<Complex<f64>>, Vec<Complex<f64>>, f64),
    inverse: Fft,
}

impl Plants {
    fn of(around: &Around<'_>, acts: CommandActs) -> Result<Self, String> {
        let (period, slope) = (around.period, around.slopes.0);
        let light = || around.modes.iter().filter(|(_, damping)| *damping < LIGHT);
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
        for impulse in around.impulses {
            let own: Vec<Complex<f64>> =
                angles.iter().map(|angle| transfer(impulse, *angle) / slope).collect();
            if at_once {
                values.push(own.iter().zip(&back).map(|(value, back)| value / back).collect());
            }
            if later {
                values.push(own);
            }
        }
        let share = (around.slopes.1 / slope).clamp(0.2, 1.0);
        let slopes = [0.5 * (share + 1.0), share, 1.0];
        let nominal = around.impulses.first().ok_or("it has no response")?;
        let even = even(nominal, first, slope, later, period);
        let inverse = Fft::inverse(2 * (even.0.len() - 1));
        let given = usize::from(at_once) + usize::from(later);
        Ok(Self { period, first, slope, slopes, angles, back, values, given, even, inverse })
    }

    /// The best gains of a law.
    fn search(&self, law: Damping, derivative: bool, limits: Limits) -> Found {
        let bounds = law.bounds(derivative);
        let logs: Vec<(f64, f64)> = bounds.iter().map(|(a, b)| (a.ln(), b.ln())).collect();
        let cost = |x: &[f64]| {
            let values: Vec<f64> = x.iter().map(|x| x.exp()).collect();
            self.cost(&Gains::of(law, &values, self.first), limits)
        };
        let (x, cost) = evolve(&logs, cost);
        let values: Vec<f64> = x.iter().map(|x| x.exp()).collect();
        Found { law, gains: Gains::of(law, &values, self.first), cost }
    }

    /// C and D at all angles.
    fn laws(&self, gains: &Gains) -> Vec<(Complex<f64>, Complex<f64>)> {
        self.back.iter().map(|back| gains.at(*back)).collect()
    }

    fn cost(&self, gains: &Gains, limits: Limits) -> f64 {
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
    fn sensitivity(
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
    fn inner_is_stable(&self, laws: &[(Complex<f64>, Complex<f64>)]) -> bool {
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
    fn bandwidth(&self, laws: &[(Complex<f64>, Complex<f64>)]) -> f64 {
        let plants = self.values[..self.given].iter();
        plants.map(|plant| self.width(laws, plant, self.slopes[0])).fold(PI, f64::min)
    }

    fn width(
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
    fn within(&self, mut response: impl Iterator<Item = f64>) -> f64 {
        let leaves = |size: f64| !(FRAC_1_SQRT_2..=SQRT_2).contains(&size);
        response.position(leaves).map_or(PI, |at| self.angles[at])
    }

    /// Time after which a step of the reference stays within its band, with the later of the commands.
    fn settling(&self, gains: &Gains, slope: f64) -> f64 {
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

    /// What is known of a loop.
    fn finished(&self, best: &Found, notch: Option<&Found>, around: &Around<'_>) -> Damped {
        let Found { law, gains, .. } = best;
        let laws = self.laws(gains);
        let (mut worst, mut gain_margin, mut phase_margin) = (0.0_f64, f64::INFINITY, PI);
        let (mut peak, mut free) = (0.0_f64, 0.0_f64);
        let (mut width, mut plants) = (PI, 0);
        for plant in &self.values {
            free = plant.iter().map(|value| value.norm()).fold(free, f64::max);
            for slope in self.slopes {
                let found = self.sensitivity(&laws, plant, slope);
                plants += usize::from(found.is_some());
                let found = found.unwrap_or((f64::INFINITY, f64::INFINITY));
                (worst, peak) = (worst.max(found.0), peak.max(found.1));
                width = width.min(self.width(&laws, plant, slope));
                let open: Vec<Complex<f64>> = laws
                    .iter()
                    .zip(plant)
                    .map(|((outer, inner), plant)| (outer - inner) * plant * slope)
                    .collect();
                let (gain, phase) = margins(&open);
                (gain_margin, phase_margin) = (gain_margin.min(gain), phase_margin.min(phase));
            }
        }
        let in_hz = |angle: f64| angle / (TAU * self.period);
        let crossing = laws
            .iter()
            .zip(&self.values[self.given - 1])
            .position(|(law, plant)| ((law.0 - law.1) * plant * self.slopes[0]).norm() <= 1.0);
        let t = self.period;
        let ki = gains.ki / (t * self.slope);
        let filter = if gains.keep > 0.0 { -t / gains.keep.ln() } else { 0.0 };
        let (a, b) = (gains.kp / gains.ki * t, gains.kd / gains.ki * t * t);
        let shaped = Shaped {
            shape: Shape { name: law.loop_name(), a, b, filter },
            ki,
            sensitivity: worst,
            gain_margin,
            phase_margin,
            bandwidth: in_hz(crossing.map_or(PI, |at| self.angles[at])),
        };
        let settles = |gains: &Gains| {
            let each = self.slopes.map(|slope| self.settling(gains, slope));
            (each[0], each.into_iter().fold(0.0, f64::max))
        };
        let (settling, longest_settling) = settles(gains);
        let is_notch = *law == Damping::Notch;
        let has_damping = matches!(law, Damping::Notch | Damping::PositivePosition);
        let figures = DampingFigures {
            law: law.name(),
            gain: if is_notch { 0.0 } else { gains.gain / self.slope },
            frequency: in_hz(gains.angle),
            filter_damping: has_damping.then_some(gains.damping),
            resonance: in_hz(self.first),
            closed_loop_bandwidth: in_hz(self.bandwidth(&laws)),
            least_closed_loop_bandwidth: in_hz(width),
            bandwidth_with_feedforward: (!is_notch)
                .then(|| in_hz(self.with_feedforward(&laws, around.leads))),
            settling,
            longest_settling,
            notch_settling: notch.map(|notch| settles(&notch.gains)),
            peak,
            undamped_peak: free,
            noise: gains.noise(),
            plants,
        };
        Damped { law: *law, shaped, figures, depth: gains.gain }
    }

    /// Up to which angle the loop with the lead and an exact inverse of the slope in front stays within 3 dB.
    fn with_feedforward(&self, laws: &[(Complex<f64>, Complex<f64>)], leads: &[(f64, f64)]) -> f64 {
        let slope = self.slopes[0];
        let plants = self.values[..self.given].iter();
        let widths = plants.map(|plant| {
            let each = laws.iter().zip(plant).zip(&self.back);
            self.within(each.map(|(((outer, inner), plant), back)| {
                let t = self.period;
                let square = back * back;
                let once = (Complex::new(3.0, 0.0) - back * 4.0 + square) / (2.0 * t);
                let twice = (Complex::new(1.0, 0.0) - back * 2.0 + square) / (t * t);
                let lead = leads.iter().map(|(lag, inertia)| 1.0 + once * *lag + twice * *inertia);
                let forward = lead.product::<Complex<f64>>() / slope;
                let (plant, back) = (plant * slope, outer - inner);
                ((forward + back) * plant / (1.0 + back * plant)).norm()
            }))
        });
        widths.fold(PI, f64::min)
    }
}

/// How often a curve has gone round zero.
#[derive(Default)]
struct Round {
    last: Option<Complex<f64>>,
    crossings: i32,
    begins_wrong: bool,
}

impl Round {
    fn go(&mut self, now: Complex<f64>) {
        match self.last {
            None => self.begins_wrong = now.re <= 0.0 || now.re.is_nan(),
            Some(last) if (last.im >= 0.0) != (now.im >= 0.0) => {
                let at = last.re - last.im * (now.re - last.re) / (now.im - last.im);
                if at < 0.0 || at.is_nan() {
                    self.crossings += if now.im < last.im { 1 } else { -1 };
                }
            }
            Some(_) => {}
        }
        self.last = Some(now);
    }

    /// Whether it has not: it began on the right and ends, real, on the right, and its crossings cancel.
    fn is_none(&self) -> bool {
        !self.begins_wrong && self.crossings == 0 && self.last.is_some_and(|last| last.re > 0.0)
    }
}

/// By how much the gain may grow, and the phase margin in rad.
fn margins(open: &[Complex<f64>]) -> (f64, f64) {
    let (mut gain, mut phase) = (f64::INFINITY, PI);
    for pair in open.windows(2) {
        let (now, next) = (pair[0], pair[1]);
        if now.im * next.im <= 0.0 && now.re < 0.0 && next.re < 0.0 {
            let size = now.norm().max(next.norm());
            if size < 1.0 {
                gain = gain.min(1.0 / size);
            }
        }
        if (now.norm() - 1.0) * (next.norm() - 1.0) <= 0.0 {
            phase = phase.min((PI - now.arg().abs()).min(PI - next.arg().abs()));
        }
    }
    if let Some(last) = open.last().filter(|last| last.re < 0.0 && last.norm() < 1.0) {
        gain = gain.min(1.0 / last.norm());
    }
    (gain, phase)
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

/// The least of a function within bounds, and where it is.
fn evolve(bounds: &[(f64, f64)], cost: impl Fn(&[f64]) -> f64) -> (Vec<f64>, f64) {
    let mut random = Uniform::new(0x9e37_79b9_7f4a_7c15);
    let mut draw = move || random.next();
    let size = SEARCH.0 * bounds.len();
    let mut all: Vec<(Vec<f64>, f64)> = (0..size)
        .map(|_| {
            let x: Vec<f64> =
                bounds.iter().map(|(low, high)| low + draw() * (high - low)).collect();
            let value = cost(&x);
            (x, value)
        })
        .collect();
    let least = |all: &[(Vec<f64>, f64)]| {
        (0..all.len()).min_by(|a, b| all[*a].1.total_cmp(&all[*b].1)).unwrap_or(0)
    };
    for _ in 0..SEARCH.1 {
        let scale = 0.5 + 0.5 * draw();
        for at in 0..size {
            let best = least(&all);
            let mut other = || ((draw() * size as f64) as usize).min(size - 1);
            let (one, two) = (other(), other());
            let sure = (draw() * bounds.len() as f64) as usize;
            let x: Vec<f64> = bounds
                .iter()
                .enumerate()
                .map(|(k, (low, high))| {
                    if k != sure && draw() > SEARCH.2 {
                        return all[at].0[k];
                    }
                    let moved = all[best].0[k] + scale * (all[one].0[k] - all[two].0[k]);
                    if (*low..=*high).contains(&moved) {
                        moved
                    } else {
                        low + draw() * (high - low)
                    }
                })
                .collect();
            let value = cost(&x);
            if value <= all[at].1 {
                all[at] = (x, value);
            }
        }
    }
    all.swap_remove(least(&all))
}
