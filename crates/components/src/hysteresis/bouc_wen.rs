//! Bouc–Wen hysteresis, symmetric or asymmetric, solved exactly over each step.
//!
//! ```text
//! y = offset + gain·u − h
//! dh/du = alpha·gain − (gamma + beta·sgn(u′ h) + delta·sgn(u′))·|h|·|h/h_s|^(exponent − 1)
//! ```
//!
//! For exponent 1 this is `h′ = alpha·gain·u′ − beta·|u′|·h − gamma·u′·|h| − delta·|u′|·|h|`.
//!
//! * gain in position per command; alpha without unit; beta, gamma, delta in
//!   1/command. h_s = alpha·gain/(beta + gamma) is the level that h tends to in the symmetric
//!   model; relating |h| to it keeps the units of beta and gamma the same for every exponent.
//! * delta ≠ 0 makes the loop asymmetric: h tends to alpha·gain/(beta + gamma ± delta) on the
//!   rising (+) and the falling (−) branch.
//! * The command moves monotonically over a step, so the equation is integrated over the command
//!   and not over time: closed form for exponent 1, else exponential (Rosenbrock) sub-steps, stable
//!   for any step and limited by the level that h cannot pass. Hence independent of rate and step.
//! * State: h, and the last command. At rest: h of the virgin state (0 at command 0) moved
//!   monotonically to the command.
//!
//! Limits: beta ≥ |delta| and beta + gamma > |delta|, so that h stays bounded.
//!
//! Source: F. Ikhouane, J. Rodellar, Systems with Hysteresis, Wiley 2007; asymmetric term: J. Song,
//! A. Der Kiureghian, Journal of Engineering Mechanics 132 (2006) 610–618.

use libm::{ceil, expm1, fabs, log1p, pow};
use model::{
    Component, Conversion, Declaration, Inverse, Quantity, Sizes, Stage, Tick, Undoing, Violation,
};

use super::numeric_inverse::{Forward, Rates};
use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `bouc-wen`.
pub struct BoucWen;

pub(super) const PARAMETERS: [Quantity; 7] = [
    Quantity::new("gain", "{position}/{command}", "Position per command without hysteresis")
        .min(0.0)
        .fitted(),
    Quantity::new("alpha", "1", "Share of the gain that the hysteresis removes after a reversal")
        .min(0.0)
        .fitted(),
    Quantity::new("beta", "1/{command}", "Decay of h towards zero on both branches")
        .min(0.0)
        .fitted(),
    Quantity::new("gamma", "1/{command}", "Decay of h that depends on the direction").fitted(),
    Quantity::new("delta", "1/{command}", "Asymmetry between rising and falling branch")
        .start(0.0)
        .fitted(),
    Quantity::new("exponent", "1", "Sharpness of the bend towards saturation")
        .start(1.0)
        .min(1.0)
        .max(20.0)
        .fitted(),
    Quantity::new("offset", "{position}", "Position at zero command in the virgin state")
        .start(0.0)
        .fitted(),
];

static DECLARATION: Declaration = Declaration {
    kind: "bouc-wen",
    name: "hysteresis",
    summary: "Bouc-Wen hysteresis, symmetric or asymmetric, exact over each step",
    equation: "y = offset + gain*u - h; dh/du = alpha*gain - (gamma + beta*sgn(u'*h) + \
               delta*sgn(u'))*|h|*|h/hs|^(exponent - 1); hs = alpha*gain/(beta + gamma)",
    reference: "F. Ikhouane, J. Rodellar, Systems with Hysteresis, Wiley 2007; J. Song, A. Der \
                Kiureghian, J. Eng. Mech. 132 (2006) 610-618",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::HYSTERESIS),
    phenomena: &[&phenomena::HYSTERESIS, &phenomena::ASYMMETRIC_HYSTERESIS],
    parameters: &PARAMETERS,
    ..Declaration::PATH
};

/// The differential equation of h over the command.
struct Law {
    /// alpha·gain, the slope of h after a reversal.
    slope: f64,
    beta: f64,
    gamma: f64,
    delta: f64,
    exponent: f64,
    level: f64,
}

impl Law {
    /// h after the command moved monotonically by `change`.
    fn advance(&self, h: f64, change: f64) -> f64 {
        if change == 0.0 {
            return h;
        }
        // In the direction of motion the equation reads dg/ds = slope − c(sgn
        // g)·|g|·|g/level|^(n−1).
        let sign = if change > 0.0 { 1.0 } else { -1.0 };
        let with = self.gamma + self.beta + self.delta * sign;
        let against = self.gamma - self.beta + self.delta * sign;
        let (g, way) = (sign * h, fabs(change));
        let end = if self.exponent == 1.0 {
            self.linear(g, way, with, against)
        } else {
            self.stepwise(g, way, with, against)
        };
        sign * end
    }

    /// Exponent 1: linear on each side of g = 0.
    fn linear(&self, g: f64, way: f64, with: f64, against: f64) -> f64 {
        if g >= 0.0 {
            return relax(g, way, self.slope, with);
        }
        // dg/ds = slope − against·|g| = slope + against·g, until g = 0.
        let ratio = against * g / self.slope;
        // g = −slope/against is where the other direction saturates where beta = |delta|: h rests there,
        // and rounding must not bring it beyond, from where it would grow without bound.
        if ratio <= -1.0 {
            return g;
        }
        let to_zero = if against == 0.0 { -g / self.slope } else { log1p(ratio) / -against };
        if to_zero < way {
            relax(0.0, way - to_zero, self.slope, with)
        } else {
            relax(g, way, self.slope, -against)
        }
    }

    /// Any exponent: second-order exponential sub-steps, at most 64.
    fn stepwise(&self, start: f64, way: f64, with: f64, against: f64) -> f64 {
        let most = self.exponent * (self.beta + fabs(self.gamma) + fabs(self.delta));
        let count = ceil(way * most / 0.02).clamp(1.0, 64.0);
        // The level at which dg/ds = 0, which a solution below it never passes.
        let top = self.level * pow(self.slope / (with * self.level), 1.0 / self.exponent);
        let length = way / count;
        let mut g = start;
        for _ in 0..count as usize {
            let c = if g >= 0.0 { with } else { against };
            let bend = pow(fabs(g) / self.level, self.exponent - 1.0);
            let rate = self.slope - c * fabs(g) * bend;
            let decay = c * self.exponent * bend * if g >= 0.0 { 1.0 } else { -1.0 };
            let next = g + rate * span(length, decay);
            g = if g <= top { next.min(top) } else { next };
        }
        g
    }
}

/// ∫ exp(−decay·s) ds from 0 to `length`.
fn span(length: f64, decay: f64) -> f64 {
    if decay == 0.0 { length } else { -expm1(-decay * length) / decay }
}

/// Solution of dg/ds = slope − decay·g after `way`.
fn relax(g: f64, way: f64, slope: f64, decay: f64) -> f64 {
    g + (slope - decay * g) * span(way, decay)
}

fn split(coefficients: &[f64]) -> Option<(Law, f64, f64)> {
    let &[gain, slope, beta, gamma, delta, exponent, offset] = coefficients else { return None };
    let level = slope / (beta + gamma);
    Some((Law { slope, beta, gamma, delta, exponent, level }, gain, offset))
}

impl Component for BoucWen {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("gain", &[0.06]),
            ("alpha", &[0.2]),
            ("beta", &[0.02]),
            ("gamma", &[0.01]),
            ("delta", &[0.002]),
            ("exponent", &[1.3]),
            ("offset", &[0.3]),
        ]
    }

    fn inverses(&self) -> &'static [Inverse] {
        const {
            &[
                Inverse::iteration("inverse-bouc-wen"),
                Inverse { kind: "bouc-wen-feedforward", undoing: Undoing::InverseFree },
            ]
        }
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 7, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[gain, alpha, beta, gamma, delta, exponent, offset] = parameters else {
            return Err(WRONG_LENGTH);
        };
        require(gain > 0.0, "gain", gain, "must be above zero: nothing would move")?;
        require(alpha > 0.0, "alpha", alpha, "must be above zero; use actuator-gain for none")?;
        let rule = "must be at least |delta|, or h grows without bound; raise beta";
        require(beta >= fabs(delta), "beta", beta, rule)?;
        let rule = "beta + gamma must be above |delta|, or h grows without bound; raise gamma";
        require(beta + gamma > fabs(delta), "gamma", gamma, rule)?;
        if coefficients.len() != parameters.len() {
            return Err(WRONG_LENGTH);
        }
        let values = [gain, alpha * gain, beta, gamma, delta, exponent, offset];
        coefficients.copy_from_slice(&values);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [h, last], [y]) = (inputs, state, outputs) else { return };
        let Some((law, gain, offset)) = split(coefficients) else { return };
        (*h, *last) = (law.advance(0.0, u), u);
        *y = offset + gain * u - *h;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[u], [h, last], [y]) = (inputs, state, outputs) else { return };
        let Some((law, gain, offset)) = split(coefficients) else { return };
        (*h, *last) = (law.advance(*h, u - *last), u);
        *y = offset + gain * u - *h;
    }
}

impl Forward for BoucWen {
    fn frozen(&self, coefficients: &[f64], state: &[f64], _rates: Rates, u: f64) -> f64 {
        let (Some((law, gain, offset)), &[h, last]) = (split(coefficients), state) else {
            return 0.0;
        };
        offset + gain * u - law.advance(h, u - last)
    }

    fn mean_slope(&self, coefficients: &[f64], _limits: [f64; 2]) -> f64 {
        split(coefficients).map_or(1.0, |(_, gain, _)| gain)
    }

    fn check(&self, _structure: &[f64], parameters: &[f64], _: [f64; 2]) -> Result<(), Violation> {
        let &[_, alpha, beta, gamma, delta, ..] = parameters else { return Err(WRONG_LENGTH) };
        // The steepest h: just after a reversal in saturation.
        let most = alpha * (1.0 + (beta - gamma + fabs(delta)) / (beta + gamma - fabs(delta)));
        require(
            alpha < 1.0 && most < 1.0,
            "alpha",
            alpha,
            "the loop curls over at its ends, so a position has several commands and the model \
             no inverse: alpha*(1 + (beta - gamma + |delta|)/(beta + gamma - |delta|)) must be \
             below 1",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random, triangle};

    /// Runge–Kutta with many small steps, straight from the equation above.
    fn reference(p: &[f64; 7], h: f64, change: f64) -> f64 {
        let [gain, alpha, beta, gamma, delta, n, _] = *p;
        let (s, level) = (change.signum(), alpha * gain / (beta + gamma));
        let f = |h: f64| {
            let psi = gamma + beta * (s * h).signum() + delta * s;
            alpha * gain - psi * h.abs() * (h.abs() / level).powf(n - 1.0)
        };
        let (count, mut h) = (4000, h);
        let d = change / f64::from(count);
        for _ in 0..count {
            let k1 = f(h);
            let k2 = f(h + 0.5 * d * k1);
            let k3 = f(h + 0.5 * d * k2);
            let k4 = f(h + d * k3);
            h += d / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        }
        h
    }

    /// The bimorph's numbers, and others of every sign; the last has no restoring term against the motion.
    const SETS: [[f64; 7]; 6] = [
        [24.373, 0.1947, 3.3626, -2.8526, 0.0, 1.0, 0.0],
        [1.0, 0.3, 0.05, 0.01, 0.02, 1.0, 0.0],
        [1.0, 0.3, 0.05, 0.2, -0.03, 1.0, 0.0],
        [1.0, 0.3, 0.05, -0.02, 0.01, 2.0, 0.0],
        [1.0, 0.3, 0.05, 0.02, 0.0, 1.5, 0.0],
        [1.0, 0.3, 0.05, 0.05, 0.0, 1.0, 0.0],
    ];

    #[test]
    fn follows_the_differential_equation() {
        for p in SETS {
            let mut model = Instance::new(&BoucWen, &[], &p, 1e-3).unwrap();
            model.rest(&[0.0]);
            let level = p[0] * p[1] / (p[2] + p[3]);
            let reach = 3.0 / (p[2] + p[3]);
            let tolerance = if p[5] == 1.0 { 1e-7 } else { 2e-3 };
            let (mut h, mut last) = (0.0, 0.0);
            for u in Random::new(4).signal(-reach, reach, 60) {
                h = reference(&p, h, u - last);
                last = u;
                let found = p[0] * u - model.step(&[u]);
                assert!((found - h).abs() < tolerance * level, "{p:?} at {u}: {found} {h}");
                h = found;
            }
        }
    }

    #[test]
    fn moves_within_the_loop_are_accurate_with_any_exponent() {
        let mut worst = 0.0_f64;
        for p in SETS.iter().filter(|p| p[5] != 1.0) {
            let mut model = Instance::new(&BoucWen, &[], p, 1e-3).unwrap();
            model.rest(&[0.0]);
            let level = p[0] * p[1] / (p[2] + p[3]);
            let (mut h, mut last) = (0.0, 0.0);
            for u in Random::new(6).signal(-0.3 / p[2], 0.3 / p[2], 200) {
                h = reference(p, h, u - last);
                last = u;
                let found = p[0] * u - model.step(&[u]);
                worst = worst.max((found - h).abs() / level);
                h = found;
            }
        }
        assert!(worst < 4e-5, "{worst}");
    }

    #[test]
    fn a_long_way_ends_where_the_equation_has_no_slope() {
        for p in SETS.iter().filter(|p| p[5] != 1.0) {
            let level = p[0] * p[1] / (p[2] + p[3]);
            for sign in [-1.0, 1.0] {
                let mut model = Instance::new(&BoucWen, &[], p, 1e-3).unwrap();
                model.rest(&[0.0]);
                let u = sign * 1e4;
                let h = p[0] * u - model.step(&[u]);
                let part = (p[2] + p[3]) / (p[2] + p[3] + p[4] * sign);
                let expected = sign * level * part.powf(1.0 / p[5]);
                assert!((h / expected - 1.0).abs() < 1e-9, "{p:?}: {h} for {expected}");
            }
        }
    }

    #[test]
    fn does_not_depend_on_how_finely_the_command_moves() {
        for p in &SETS[..3] {
            let run = |points: usize| {
                let mut model = Instance::new(&BoucWen, &[], p, 1e-3).unwrap();
                let y = model.response(0.0, &triangle(0.0, 10.0, points, 3));
                (y[points], y[2 * points], y[5 * points])
            };
            let (coarse, fine) = (run(1), run(500));
            for (a, b) in [(coarse.0, fine.0), (coarse.1, fine.1), (coarse.2, fine.2)] {
                assert!((a - b).abs() < 1e-9, "{a} {b}");
            }
        }
    }

    #[test]
    fn h_stays_bounded_for_any_command() {
        for p in SETS {
            let mut model = Instance::new(&BoucWen, &[], &p, 1e-3).unwrap();
            model.rest(&[0.0]);
            let most = p[0] * p[1] / (p[2] + p[3] - p[4].abs());
            for u in Random::new(5).signal(-1e6, 1e6, 2000) {
                let h = p[0] * u - model.step(&[u]);
                assert!(h.abs() <= most * (1.0 + 1e-6) + 1e-6 * p[0], "{p:?}: {h} beyond {most}");
            }
        }
    }

    #[test]
    fn the_offset_is_added_at_rest_and_in_motion() {
        let p = SETS[1];
        let shifted = [p[0], p[1], p[2], p[3], p[4], p[5], 5.0];
        let mut model = Instance::new(&BoucWen, &[], &p, 1e-3).unwrap();
        let mut other = Instance::new(&BoucWen, &[], &shifted, 1e-3).unwrap();
        for u in [0.0, 10.0, -7.0] {
            assert!((other.rest(&[u]) - model.rest(&[u]) - 5.0).abs() < 1e-12);
            assert!((other.step(&[2.0 * u]) - model.step(&[2.0 * u]) - 5.0).abs() < 1e-12);
        }
    }

    #[test]
    fn unbounded_parameters_are_refused() {
        let refused =
            |p: [f64; 7]| Instance::new(&BoucWen, &[], &p, 1e-3).err().map(|v| v.quantity);
        assert_eq!(refused([1.0, 0.3, 0.05, -0.05, 0.0, 1.0, 0.0]), Some("gamma"));
        assert_eq!(refused([1.0, 0.3, 0.01, 0.05, 0.02, 1.0, 0.0]), Some("beta"));
    }

    #[test]
    fn at_rest_it_is_on_the_virgin_curve() {
        // Exponent 1, rising: h = slope/(beta + gamma + delta)*(1 - exp(-(beta + gamma + delta)*u)).
        let mut model = Instance::new(&BoucWen, &[], &SETS[1], 1e-3).unwrap();
        let wanted = 20.0 - 0.3 / 0.08 * (1.0 - (-0.08_f64 * 20.0).exp());
        assert!((model.rest(&[20.0]) - wanted).abs() < 1e-12);
    }
}
