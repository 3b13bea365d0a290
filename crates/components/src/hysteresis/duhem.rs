//! Duhem hysteresis of Coleman and Hodgdon, with a straight centre line, solved exactly.
//!
//! ```text
//! y′ = decay·|u′|·(offset + slope·u − y) + initial·u′
//! ```
//!
//! * slope in position per command: of the centre line; initial: slope right after a reversal,
//!   below `slope` for a loop that lags; decay in 1/command: how fast the branch joins the major
//!   loop, which lies (slope − initial)/decay below and above the centre line.
//! * The command moves monotonically over a step, so that the equation is linear over the command
//!   and its solution exact: e = y − offset − slope·u tends to ∓(slope − initial)/decay.
//! * State: e, and the last command. At rest: the virgin state (e = 0 at command 0) moved
//!   monotonically to the command.
//!
//! Limits: independent of rate; no return-point memory: minor loops drift towards the centre line.
//!
//! Source: B. D. Coleman, M. L. Hodgdon, International Journal of Engineering Science 24 (1986)
//! 897–919.

use libm::{exp, fabs};
use model::{Component, Conversion, Declaration, Inverse, Quantity, Sizes, Stage, Tick, Violation};

use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `duhem`.
pub struct Duhem;

static DECLARATION: Declaration = Declaration {
    kind: "duhem",
    name: "hysteresis",
    summary: "Duhem hysteresis (Coleman-Hodgdon) with a straight centre line, exact over each step",
    equation: "y' = decay*|u'|*(offset + slope*u - y) + initial*u'",
    reference: "B. D. Coleman, M. L. Hodgdon, Int. J. Eng. Sci. 24 (1986) 897-919",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::HYSTERESIS),
    phenomena: &[&phenomena::HYSTERESIS],
    parameters: &PARAMETERS,
    ..Declaration::PATH
};

/// Parameters of the Duhem model.
pub(super) const PARAMETERS: [Quantity; 4] = [
    Quantity::new("slope", "{position}/{command}", "Slope of the centre line").fitted(),
    Quantity::new("initial", "{position}/{command}", "Slope right after a reversal").fitted(),
    Quantity::new(
        "decay",
        "1/{command}",
        "Rate at which a branch approaches the major loop, per unit of command",
    )
    .min(0.0)
    .fitted(),
    Quantity::new("offset", "{position}", "Position at zero command in the virgin state")
        .start(0.0)
        .fitted(),
];

/// The law of Duhem and Dahl by its coefficients: the deviation e from a straight centre line tends
/// to `−half` when rising and to `half` when falling.
pub(super) struct Law {
    pub(super) slope: f64,
    half: f64,
    decay: f64,
    pub(super) offset: f64,
}

impl Law {
    #[inline]
    pub(super) fn of(coefficients: &[f64]) -> Option<Self> {
        let &[slope, half, decay, offset] = coefficients else { return None };
        Some(Self { slope, half, decay, offset })
    }

    /// Deviation after the command moved monotonically by `change`.
    #[inline]
    pub(super) fn advance(&self, e: f64, change: f64) -> f64 {
        if change == 0.0 {
            return e;
        }
        let target = if change > 0.0 { -self.half } else { self.half };
        target + (e - target) * exp(-self.decay * fabs(change))
    }

    /// Position after a step to `u`; the state stays.
    pub(super) fn frozen(&self, state: &[f64], u: f64) -> f64 {
        let &[e, last] = state else { return 0.0 };
        self.offset + self.slope * u + self.advance(e, u - last)
    }

    /// Least slope of a branch: on the major loop, right after a reversal.
    pub(super) fn least_slope(&self) -> f64 {
        self.slope - self.decay * (self.half + fabs(self.half))
    }
}

impl Component for Duhem {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("slope", &[0.06]), ("initial", &[0.04]), ("decay", &[0.05]), ("offset", &[0.3])]
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-duhem")] }
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 4, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[slope, initial, decay, offset], [k, half, rate, zero]) = (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        require(decay > 0.0, "decay", decay, "must be above zero; use actuator-gain for no loop")?;
        (*k, *half, *rate, *zero) = (slope, (slope - initial) / decay, decay, offset);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some(law), &[u], [e, last], [y]) = (Law::of(coefficients), inputs, state, outputs)
        else {
            return;
        };
        (*e, *last) = (law.advance(0.0, u), u);
        *y = law.offset + law.slope * u + *e;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(law), &[u], [e, last], [y]) = (Law::of(coefficients), inputs, state, outputs)
        else {
            return;
        };
        (*e, *last) = (law.advance(*e, u - *last), u);
        *y = law.offset + law.slope * u + *e;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random, triangle};

    const P: [f64; 4] = [0.06, 0.04, 0.05, 0.3];

    #[test]
    fn at_rest_it_stays_where_the_command_has_led_it_from_0() {
        for u in [-40.0, 0.0, 25.0] {
            let mut moved = Instance::new(&Duhem, &[], &P, 1e-3).unwrap();
            moved.rest(&[0.0]);
            let there = moved.step(&[u]);
            let mut model = Instance::new(&Duhem, &[], &P, 1e-3).unwrap();
            assert!((model.rest(&[u]) - there).abs() < 1e-12);
            assert!((model.step(&[u]) - there).abs() < 1e-12);
        }
    }

    #[test]
    fn follows_the_differential_equation() {
        let mut model = Instance::new(&Duhem, &[], &P, 1e-3).unwrap();
        let (mut y, mut last) = (model.rest(&[0.0]), 0.0);
        for u in Random::new(3).signal(-60.0, 120.0, 100) {
            let d = (u - last) / 20_000.0;
            for k in 0..20_000 {
                // Midpoint rule.
                let f = |u: f64, y: f64| P[2] * d.signum() * (P[3] + P[0] * u - y) + P[1];
                let at = last + d * f64::from(k);
                let middle = y + 0.5 * d * f(at, y);
                y += d * f(at + 0.5 * d, middle);
            }
            last = u;
            let found = model.step(&[u]);
            assert!((found - y).abs() < 1e-6, "{found} {y}");
            y = found;
        }
    }

    #[test]
    fn the_major_loop_lies_half_its_height_off_the_centre_line() {
        let mut model = Instance::new(&Duhem, &[], &P, 1e-3).unwrap();
        let half = (P[0] - P[1]) / P[2];
        let signal = triangle(-500.0, 500.0, 100, 2);
        let output = model.response(0.0, &signal);
        assert!((output[250] - (P[3] + P[0] * signal[250] - half)).abs() < 1e-5);
        assert!((output[350] - (P[3] + P[0] * signal[350] + half)).abs() < 1e-5);
    }
}
