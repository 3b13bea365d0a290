//! A mode with LuGre friction (guides, stick-slip).
//!
//! ```text
//! x″ + 2ζω x′ + ω²·(x + coulomb·z/presliding) = ω²·u
//! z′ = x′ − |x′|·z/g(x′),   g(v) = presliding·[1 + (stiction/coulomb − 1)·exp(−(v/stribeck)²)]
//! ```
//!
//! * Forces are given by the position that they cost (force over the mode's stiffness): coulomb,
//!   stiction ≥ coulomb; presliding in position: bristle deflection at the Coulomb force; stribeck
//!   in position per second. Viscous friction is in the damping.
//! * State: x, x′, z. Each period is cut into at most 64 sub-steps of 0.1 rad of the mode, each by
//!   the implicit Euler rule for all three equations together, as one equation for the velocity
//!   that is solved in a bracket: stable at any step, and z never leaves its bounds.
//! * At rest x = u and z = 0.
//!
//! Limits: first order in the sub-step: a step that is not short against the mode damps it more
//! than ζ.
//!
//! Source: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, IEEE Transactions on
//! Automatic Control 40 (1995) 419–425.

use core::f64::consts::TAU;

use libm::{ceil, copysign, exp, fabs, fmax};
use model::{
    Component, Conversion, Declaration, Input, Output, Quantity, Sizes, Stage, Tick, Violation,
};

use crate::effects;
use crate::rules::{WRONG_LENGTH, require, second_order};
use crate::solve::newton;

/// The component `friction`.
pub struct Friction;

static DECLARATION: Declaration = Declaration {
    kind: "friction",
    name: "friction",
    summary: "Mode with LuGre friction",
    equation: "x'' + 2*damping*w*x' + w^2*(x + coulomb*z/presliding) = w^2*u; z' = x' - |x'|*z/g; \
               g = presliding*(1 + (stiction/coulomb - 1)*exp(-(x'/stribeck)^2))",
    reference: "C. Canudas de Wit et al., IEEE Trans. Automatic Control 40 (1995) 419-425",
    stage: Stage::Mechanics,
    conversion: Conversion::None,
    effect: Some(&effects::FRICTION),
    inputs: &[Input::PATH],
    outputs: &[Output::PATH],
    structure: &[],
    parameters: &[
        Quantity::new("frequency", "Hz", "Undamped natural frequency").min(0.0).fitted(),
        Quantity::new("damping", "1", "Damping ratio").min(0.0).fitted(),
        Quantity::new("coulomb", "{position}", "Coulomb friction over stiffness").min(0.0).fitted(),
        Quantity::new("stiction", "{position}", "Static friction over stiffness").min(0.0).fitted(),
        Quantity::new("presliding", "{position}", "Bristle deflection at the Coulomb force")
            .min(0.0)
            .fitted(),
        Quantity::new(
            "stribeck",
            "{position}/s",
            "Velocity at which static friction has fallen to 37 %",
        )
        .min(0.0)
        .fitted(),
    ],
};

struct Law {
    omega: f64,
    damping: f64,
    coulomb: f64,
    /// stiction/coulomb − 1.
    excess: f64,
    presliding: f64,
    stribeck: f64,
    /// Sub-step in s.
    h: f64,
}

impl Law {
    /// Bristle deflection after an implicit step at this velocity, and its slope over the velocity.
    #[inline]
    fn bristle(&self, z: f64, v: f64) -> [f64; 2] {
        let ratio = v / self.stribeck;
        let bell = self.presliding * self.excess * exp(-ratio * ratio);
        let g = self.presliding + bell;
        let (rate, growth) = (self.h / g, 2.0 * ratio / self.stribeck * bell / g);
        let below = 1.0 + rate * fabs(v);
        let deflection = (z + self.h * v) / below;
        let slope = (self.h - deflection * rate * (copysign(1.0, v) + fabs(v) * growth)) / below;
        [deflection, slope]
    }

    /// The velocity that solves the implicit step.
    fn velocity(&self, [x, v, z]: [f64; 3], u: f64) -> f64 {
        let (w, h) = (self.omega, self.h);
        let stiffness = w * w * self.coulomb / self.presliding;
        // Everything but friction is linear: slope·velocity = drive − stiffness·bristle(velocity).
        let slope = 1.0 / h + 2.0 * self.damping * w + w * w * h;
        let drive = v / h + w * w * (u - x);
        if stiffness * z == drive {
            return 0.0;
        }
        // |z| stays below its present value or the largest g: bounds of the solution.
        let most = stiffness * fmax(fabs(z), self.presliding * (1.0 + self.excess));
        let bounds = [(drive - most) / slope, (drive + most) / slope];
        newton(bounds, v, |velocity| {
            let [deflection, grows] = self.bristle(z, velocity);
            [slope * velocity - drive + stiffness * deflection, slope + stiffness * grows]
        })
    }
}

impl Component for Friction {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 8, states: 3 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (
            &[frequency, damping, coulomb, stiction, presliding, stribeck],
            [w, z, c, s, p, v, h, n],
        ) = (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        second_order(frequency, damping, period)?;
        let rule = "must be above zero; set enabled = false for no friction";
        require(coulomb > 0.0, "coulomb", coulomb, rule)?;
        require(presliding > 0.0, "presliding", presliding, rule)?;
        require(stribeck > 0.0, "stribeck", stribeck, "must be above zero")?;
        let rule = "must be at least `coulomb`; equal for no Stribeck effect";
        require(stiction >= coulomb, "stiction", stiction, rule)?;
        *n = ceil(TAU * frequency * period / 0.1).clamp(1.0, 64.0);
        (*w, *z, *c, *p) = (TAU * frequency, damping, coulomb, presliding);
        (*s, *v, *h) = (stiction / coulomb - 1.0, stribeck, period / *n);
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [x, v, z], [y]) = (inputs, state, outputs) else { return };
        (*x, *v, *z) = (u, 0.0, 0.0);
        *y = u;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (
            &[omega, damping, coulomb, excess, presliding, stribeck, h, count],
            &[u],
            [x, v, z],
            [y],
        ) = (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let law = Law { omega, damping, coulomb, excess, presliding, stribeck, h };
        for _ in 0..count as usize {
            let velocity = law.velocity([*x, *v, *z], u);
            *x += h * velocity;
            [*z, _] = law.bristle(*z, velocity);
            *v = velocity;
        }
        *y = *x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random};

    const P: [f64; 6] = [100.0, 0.05, 0.2, 0.3, 0.01, 1.0];

    #[test]
    fn a_slow_ramp_lags_by_the_coulomb_force() {
        let mut model = Instance::new(&Friction, &[], &P, 1e-4).unwrap();
        model.rest(&[0.0]);
        // 10 units per second: far above the Stribeck velocity; steady sliding.
        let mut x = 0.0;
        for n in 1..=20_000 {
            x = model.step(&[1e-3 * f64::from(n)]);
        }
        let w = TAU * 100.0;
        let lag = 0.2 + 2.0 * 0.05 / w * 10.0;
        assert!((20.0 - x - lag).abs() < 5e-3, "{}", 20.0 - x);
    }

    #[test]
    fn a_small_command_is_held_by_a_spring() {
        let mut model = Instance::new(&Friction, &[], &P, 1e-4).unwrap();
        model.rest(&[0.0]);
        // Slowly: g stays at stiction, and the bristle bends as z = g·(1 − exp(−x/g)).
        for n in 1..=40_000 {
            model.step(&[0.1 * f64::from(n) / 40_000.0]);
        }
        let x = model.outputs[0];
        let force = x + 0.3 * (1.0 - (-x / 0.015).exp());
        assert!((force / 0.1 - 1.0).abs() < 0.01, "{x}: {force}");
    }

    #[test]
    fn bristles_stay_in_bounds_and_everything_finite_at_any_step() {
        for period in [1e-6, 1e-4, 1e-2, 1.0] {
            let mut model = Instance::new(&Friction, &[], &P, period).unwrap();
            model.rest(&[0.0]);
            for u in Random::new(5).signal(-1e3, 1e3, 500) {
                assert!(model.step(&[u]).is_finite());
                assert!(model.state[2].abs() <= 0.01 * 1.5 * (1.0 + 1e-12), "{}", model.state[2]);
            }
        }
    }

    #[test]
    fn at_rest_it_stays() {
        let mut model = Instance::new(&Friction, &[], &P, 1e-4).unwrap();
        model.rest(&[3.0]);
        assert!((0..100).all(|_| model.step(&[3.0]) == 3.0));
    }
}
