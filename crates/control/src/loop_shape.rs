//! Gains of a PID controller from the frequency response of the sampled plant.
//!
//! The open loop is L = C(z) · z⁻¹ · G(z), with G the plant's exact response under the controller's
//! hold at its steepest slope, one period for computing (and for masters that exchange signals once
//! per period), and
//!
//! ```text
//! C(z) = ki·T/(1 − z⁻¹) · …   of the shape   ki·(1 + a s + b s²)/s
//! ```
//!
//! Shapes that are tried: a = b = 0 (integral); a = Σ lag time constants + Σ 2ζ/ω (a proportional part
//! that cancels the lags); for the lowest mode a = 2ζ/ω, b = 1/ω² (its inverse); and zeros below the
//! mode, whose derivative part damps it whatever its exact frequency. For each, ki is
//! raised from zero to the largest value with
//!
//! ```text
//! max |1/(1 + L)| ≤ M    for every ki below it, and with the modes' frequencies as given and 10 % off
//! slope · ki · √(c² + d²) ≤ noise limit
//! c = a + T + (1 − f)·b/T,   d = (1 − f)·b/T·√((1 − f)/(1 + f)),   f = exp(−T/filter)
//! ```
//!
//! the second being the direct way of white sensor noise to the command, as a position.
//!
//! From a stable plant at ki = 0 on, the loop cannot become unstable without |1/(1 + L)| passing
//! through infinity, so every such loop is stable; and since a smaller slope of the hysteresis acts
//! as a smaller ki, the bound holds for every slope from zero to the steepest. It implies a
//! gain margin of at least M/(M−1) and a phase margin of at least 2·asin(1/2M). The shape with the
//! largest ki is taken: slow disturbances, creep and the hysteresis that the feedforward leaves are
//! attenuated by it.
//!
//! Source: K. J. Åström, T. Hägglund, Advanced PID Control, ISA 2006, ch. 7 (largest integral gain
//! under a constraint on the sensitivity).

use core::f64::consts::{PI, TAU};

use nalgebra::Complex;

/// Frequencies per decade, from the lowest to half the sample rate.
const DENSITY: usize = 150;
/// Decades below half the sample rate.
const DECADES: usize = 5;
/// Additional frequencies near each mode.
const NEAR_MODE: usize = 200;
/// Width of the part around a mode, relative to its frequency.
const MODE_WIDTH: f64 = 0.25;
/// Factors between the gains that are tried: coarsely up to the limit, then finely below it.
const GAIN_FACTORS: [f64; 2] = [1.1, 1.005];
/// Most gains that are tried: from the least by a factor of 10⁸.
const GAIN_STEPS: usize = 194;

/// Shape of the controller: ki·(1 + a s + b s²/(1 + filter·s))/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    /// What the shape does, for reports.
    pub(crate) name: &'static str,
    /// In s.
    pub(crate) a: f64,
    /// In s².
    pub(crate) b: f64,
    /// Time constant of the derivative's filter in s; 0 for none.
    pub(crate) filter: f64,
}

impl Shape {
    /// Standard deviation of the command per ki and per standard deviation of white sensor noise,
    /// without the loop's answer; the integral's sum of past noise is left out.
    pub(crate) fn noise(&self, period: f64) -> f64 {
        let keep = self.keep(period);
        let derivative = (1.0 - keep) * self.b / period;
        let tail = derivative * ((1.0 - keep) / (1.0 + keep)).sqrt();
        (self.a + period + derivative).hypot(tail)
    }

    /// The shape's response for ki = 1 where z⁻¹ is `back`.
    pub(crate) fn at(&self, back: Complex<f64>, period: f64) -> Complex<f64> {
        let one = Complex::new(1.0, 0.0);
        let keep = self.keep(period);
        let difference = one - back;
        let filtered = difference * (1.0 - keep) / (one - back * keep);
        Complex::new(period, 0.0) / difference + self.a + filtered * (self.b / period)
    }

    /// What the derivative's filter keeps of its last value.
    fn keep(&self, period: f64) -> f64 {
        if self.filter > 0.0 { (-period / self.filter).exp() } else { 0.0 }
    }
}

/// What a loop must keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Greatest |1/(1 + L)|.
    pub(crate) sensitivity: f64,
    /// Greatest amplification of white sensor noise to the command, as a position.
    pub(crate) noise: f64,
}

/// What is known of a shaped loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shaped {
    pub(crate) shape: Shape,
    pub(crate) ki: f64,
    /// Greatest |1/(1 + L)| over all variants.
    pub(crate) sensitivity: f64,
    /// Least gain margin over all variants.
    pub(crate) gain_margin: f64,
    /// Least phase margin over all variants, in rad.
    pub(crate) phase_margin: f64,
    /// Lowest frequency at which |L| = 1 for the plant as given, in Hz.
    pub(crate) bandwidth: f64,
}

/// The frequency response of a plant at some frequencies.
#[derive(Clone, Debug)]
pub(crate) struct Response {
    /// Angular frequencies in rad per sample.
    pub(super) angles: Vec<f64>,
    /// Plant with one period of delay.
    pub(super) values: Vec<Complex<f64>>,
    period: f64,
}

impl Response {
    /// The response of the plant with this impulse response h_1, h_2, …; `modes` are frequencies (Hz)
    /// around which it is looked at more closely.
    pub(crate) fn new(impulse: &[f64], period: f64, modes: &[f64]) -> Self {
        let mut angles: Vec<f64> = (0..=DENSITY * DECADES)
            .map(|k| PI * 10f64.powf(-(k as f64) / DENSITY as f64))
            .collect();
        for mode in modes {
            let centre = TAU * mode * period;
            let offset = |k: usize| 2.0 * k as f64 / NEAR_MODE as f64 - 1.0;
            // Denser towards the mode.
            let near = (0..=NEAR_MODE).map(|k| centre * (1.0 + MODE_WIDTH * offset(k).powi(3)));
            angles.extend(near.filter(|angle| *angle < PI));
        }
        angles.sort_by(f64::total_cmp);
        let values = transfers(impulse, &angles);
        Self { angles, values, period }
    }

    /// A plant with another impulse response at the same frequencies.
    pub(crate) fn of(&self, impulse: &[f64]) -> Self {
        let values = transfers(impulse, &self.angles);
        Self { angles: self.angles.clone(), values, period: self.period }
    }

    /// The plant without the period of delay: the command acts at once.
    pub(super) fn at_once(&self) -> Self {
        let ahead = self.angles.iter().map(|angle| Complex::from_polar(1.0, *angle));
        let values = self.values.iter().zip(ahead).map(|(value, ahead)| value * ahead).collect();
        Self { angles: self.angles.clone(), values, period: self.period }
    }

    /// The open loop at each frequency for a gain ki of 1.
    fn loop_of(&self, shape: Shape) -> Vec<Complex<f64>> {
        let pairs = self.angles.iter().zip(&self.values);
        let back = |angle: &f64| Complex::from_polar(1.0, -angle);
        pairs.map(|(angle, plant)| shape.at(back(angle), self.period) * plant).collect()
    }
}

/// z⁻¹ · Σ h_k z⁻ᵏ at z = exp(i·angle), by Horner's rule.
pub(crate) fn transfer(impulse: &[f64], angle: f64) -> Complex<f64> {
    let [value] = together(impulse, [angle]);
    value
}

/// `transfer` at all angles, to the same bits.
pub(crate) fn transfers(impulse: &[f64], angles: &[f64]) -> Vec<Complex<f64>> {
    // Several rules at once do not wait for each other's products.
    const TOGETHER: usize = 8;
    let (many, rest) = angles.as_chunks::<TOGETHER>();
    let many = many.iter().flat_map(|angles| together(impulse, *angles));
    many.chain(rest.iter().map(|angle| transfer(impulse, *angle))).collect()
}

fn together<const N: usize>(impulse: &[f64], angles: [f64; N]) -> [Complex<f64>; N] {
    let back = angles.map(|angle| Complex::from_polar(1.0, -angle));
    let mut sum = [Complex::new(0.0, 0.0); N];
    for h in impulse.iter().rev() {
        for (sum, back) in sum.iter_mut().zip(&back) {
            *sum = (*sum + h) * back;
        }
    }
    std::array::from_fn(|k| sum[k] * back[k])
}

/// The largest gain of `shape` that keeps the limits for all variants of the plant; the first is the
/// plant as given. `None` where no gain does.
pub(crate) fn shape(
    variants: &[Response],
    shape: Shape,
    slope: f64,
    limits: Limits,
) -> Option<Shaped> {
    let loops: Vec<Vec<Complex<f64>>> = variants.iter().map(|v| v.loop_of(shape)).collect();
    let period = variants.first()?.period;
    let allowed = |ki: f64| {
        let noise = (slope * ki).abs() * shape.noise(period);
        let worst = loops.iter().map(|l| sensitivity(l, ki)).fold(0.0, f64::max);
        (worst <= limits.sensitivity && noise <= limits.noise).then_some(worst)
    };
    // An integral gain of 1/(slope · period) reaches the reference in one sample.
    let least = 1e-6 / (slope * period);
    let mut best = allowed(least).map(|worst| (least, worst));
    for factor in GAIN_FACTORS {
        for _ in 0..GAIN_STEPS {
            let Some(next) = best.map(|(ki, _)| ki * factor) else { break };
            let Some(worst) = allowed(next) else { break };
            best = Some((next, worst));
        }
    }
    let (ki, sensitivity) = best?;
    let margins = loops.iter().map(|l| margins(l, ki, false));
    let (gain_margin, phase_margin) = margins
        .fold((f64::INFINITY, PI), |least, found| (least.0.min(found.0), least.1.min(found.1)));
    let nominal = loops.first()?;
    let crossing = nominal.iter().position(|l| ki.abs() * l.norm() <= 1.0)?;
    let bandwidth = variants.first()?.angles.get(crossing)? / (TAU * period);
    Some(Shaped { shape, ki, sensitivity, gain_margin, phase_margin, bandwidth })
}

pub(super) fn sensitivity(open: &[Complex<f64>], ki: f64) -> f64 {
    // A response that is not finite counts as infinitely sensitive.
    let least = open
        .iter()
        .map(|l| (1.0 + l * ki).norm_sqr())
        .fold(f64::INFINITY, |least, d| if d >= least { least } else { d });
    if least > 0.0 { 1.0 / least.sqrt() } else { f64::INFINITY }
}

/// Gain margin and phase margin (rad) of the loop ki·open, from the crossings of its polar curve, which
/// ends at half the sample rate. There it is real and goes on as its mirror image.
///
/// `upward`: only by how much the gain may grow, as crossings beyond −1 belong to a loop that a smaller gain makes
/// unstable. A loop that is stable from gain zero on has none of these.
pub(crate) fn margins(open: &[Complex<f64>], ki: f64, upward: bool) -> (f64, f64) {
    let (mut gain, mut phase) = (f64::INFINITY, PI);
    let mut crosses = |size: f64| {
        if !upward || size < 1.0 {
            gain = gain.min(1.0 / size);
        }
    };
    if let Some(last) = open.last().map(|last| last * ki)
        && last.re < 0.0
    {
        crosses(last.norm());
    }
    for pair in open.windows(2) {
        let (now, next) = (pair[0] * ki, pair[1] * ki);
        if now.im * next.im <= 0.0 && now.re < 0.0 && next.re < 0.0 {
            crosses(now.norm().max(next.norm()));
        }
        if (now.norm() - 1.0) * (next.norm() - 1.0) <= 0.0 {
            phase = phase.min((PI - now.arg().abs()).min(PI - next.arg().abs()));
        }
    }
    (gain, phase)
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTEGRAL: Shape = Shape { name: "integral", a: 0.0, b: 0.0, filter: 0.0 };
    const LIMITS: Limits = Limits { sensitivity: 1.5, noise: 100.0 };

    #[test]
    fn an_integral_loop_over_one_sample_of_delay_meets_its_sensitivity_exactly() {
        // L = k z⁻²/(1 − z⁻¹), k = ki·T·g: the limit of stability is k = 1.
        let plant = Response::new(&[2.0], 0.01, &[]);
        let found = shape(&[plant], INTEGRAL, 2.0, LIMITS).expect("shaped");
        let k = found.ki * 0.01 * 2.0;
        assert!(found.sensitivity <= 1.5 && found.sensitivity > 1.49, "{found:?}");
        assert!((found.gain_margin * k - 1.0).abs() < 0.02, "{found:?}, k {k}");
        assert!(found.gain_margin >= 3.0, "{found:?}");
        assert!(found.phase_margin >= 2.0 * (1.0 / 3.0_f64).asin(), "{found:?}");
        // |L| = 1 where 2 sin(angle/2) = k.
        let exact = 2.0 * (0.5 * k).asin() / (TAU * 0.01);
        assert!((found.bandwidth / exact - 1.0).abs() < 0.03, "{found:?}, {exact} Hz");
    }

    #[test]
    fn responses_together_are_those_of_each_angle() {
        let impulse: Vec<f64> =
            (0..200).map(|k| (0.97_f64).powi(k) * (0.3 * f64::from(k)).cos()).collect();
        let angles: Vec<f64> = (0..19).map(|k| PI * 0.7_f64.powi(k)).collect();
        for (angle, value) in angles.iter().zip(transfers(&impulse, &angles)) {
            let back = Complex::from_polar(1.0, -angle);
            let sum = impulse.iter().rev().fold(Complex::new(0.0, 0.0), |sum, h| (sum + h) * back);
            assert_eq!(value, sum * back, "{angle}");
        }
    }

    #[test]
    fn the_noise_limit_holds() {
        let plant = Response::new(&[2.0], 0.01, &[]);
        let limits = Limits { noise: 0.01, ..LIMITS };
        let found = shape(&[plant], INTEGRAL, 2.0, limits).expect("shaped");
        let noise = 2.0 * found.ki * INTEGRAL.noise(0.01);
        assert!(noise <= 0.01 && noise > 0.0099, "{noise}");
    }

    #[test]
    fn a_negative_gain_of_the_plant_gives_a_negative_gain_of_the_controller() {
        let plant = Response::new(&[-2.0], 0.01, &[]);
        let found = shape(&[plant], INTEGRAL, -2.0, LIMITS).expect("shaped");
        assert!(found.ki < 0.0);
    }

    #[test]
    fn robust_gains_keep_the_sensitivity_of_a_light_mode_with_and_without_computing() {
        use super::super::tuning::{judge_loop, robust};
        // A mode at a fifth of the sample rate with a quality of about 16, and gain 1.
        let (keep, angle) = (0.98_f64.powi(2), 0.4 * PI);
        let (a1, a2) = (2.0 * keep.sqrt() * angle.cos(), -keep);
        let (mut last, mut before) = (0.0, 0.0);
        let step = |_| {
            let y = 1.0 - a1 - a2 + a1 * last + a2 * before;
            let impulse = y - last;
            (before, last) = (last, y);
            impulse
        };
        let impulse: Vec<f64> = (0..600).map(step).collect();
        let gains = robust(&impulse, 5e-5, 1.5, 20.0).expect("gains");
        for computing in [true, false] {
            let found = judge_loop(&impulse, 5e-5, &gains, computing, &[]);
            assert!(found.stable && found.sensitivity <= 1.51, "{computing}: {found:?}");
        }
    }
}
