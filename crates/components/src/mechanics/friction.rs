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
//! * State: x, x′/ω, z. Each period is cut into at most 64 sub-steps, of 0.1 rad of the mode and 0.2 rad of
//!   the mode on its bristles where that suffices. In each the linear part is exact under the mean of the
//!   bristle force before and after, and the bristle follows its law exactly for a velocity that is
//!   constant: one equation for the way, solved in a bracket. Second order; z never leaves its bounds.
//! * At rest x = u and z = 0.
//!
//! Limits: where 64 sub-steps are not short against the bristles' motion, that is smeared.
//!
//! Source: C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, IEEE Transactions on
//! Automatic Control 40 (1995) 419–425.

use core::f64::consts::TAU;

use libm::{ceil, copysign, exp, fabs, fmax, sqrt};
use model::{Component, Declaration, Quantity, Role, Sizes, Stage, Tick, Violation};

use crate::linear::Transition;
use crate::rules::{WRONG_LENGTH, require, second_order};
use crate::solve::newton;
use crate::{effects, phenomena};

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
    effect: Some(&effects::FRICTION),
    phenomena: &[&phenomena::FRICTION],
    parameters: &[
        Quantity::new("frequency", "Hz", "Undamped natural frequency")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
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
    ..Declaration::PATH
};

struct Law {
    /// Over one sub-step.
    mode: Transition,
    /// coulomb/presliding: stiffness of the bristles over that of the mode.
    stiffness: f64,
    /// stiction/coulomb − 1.
    excess: f64,
    presliding: f64,
    stribeck: f64,
    /// Sub-step in s.
    h: f64,
}

impl Law {
    /// Bristle deflection after a way at constant velocity within one sub-step, and its slope over the way:
    /// z = g·s + (z₀ − g·s)·exp(−|way|/g), s the sign of the way.
    #[inline]
    fn bristle(&self, z: f64, way: f64) -> [f64; 2] {
        let sign = copysign(1.0, way);
        let ratio = way / (self.h * self.stribeck);
        let bell = self.presliding * self.excess * exp(-ratio * ratio);
        let g = self.presliding + bell;
        // Slope of g over the length of the way.
        let growth = -2.0 * fabs(ratio) / (self.h * self.stribeck) * bell;
        let part = fabs(way) / g;
        let decay = exp(-part);
        let from = z - g * sign;
        let slope =
            decay * (1.0 - z * sign / g) + growth * (1.0 - decay + sign * from * decay * part / g);
        [g * sign + from * decay, slope]
    }

    /// Goes on by one sub-step.
    #[inline]
    fn advance(&self, u: f64, [x, rate, z]: &mut [f64; 3]) {
        let goes = 1.0 - self.mode.same;
        let free = goes * (u - *x) + self.mode.cross * *rate;
        let half = 0.5 * goes * self.stiffness;
        // |z| stays below its present value or the largest g: bounds of the solution.
        let most = half * (fabs(*z) + fmax(fabs(*z), self.presliding * (1.0 + self.excess)));
        let old = *z;
        // A way of nothing leaves the bristle as it is: what rests stays at rest.
        let way = if free == 2.0 * half * old {
            0.0
        } else {
            newton([free - most, free + most], free, |way| {
                let [deflection, slope] = self.bristle(old, way);
                [way + half * (old + deflection) - free, 1.0 + half * slope]
            })
        };
        [*z, _] = self.bristle(old, way);
        let target = u - 0.5 * self.stiffness * (old + *z);
        let (deviation, turned) = self.mode.apply(*x - target, *rate);
        (*x, *rate) = (target + deviation, turned);
    }
}

impl Component for Friction {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 9, states: 3 }
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
            [same, cross, rate, k, s, p, v, h, n],
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
        *k = coulomb / presliding;
        let angle = TAU * frequency * period;
        *n = ceil(fmax(angle / 0.1, angle * sqrt(1.0 + *k) / 0.2)).clamp(1.0, 64.0);
        (*s, *p, *v, *h) = (stiction / coulomb - 1.0, presliding, stribeck, period / *n);
        let mode = Transition::new(frequency, damping, *h);
        (*same, *cross, *rate) = (mode.same, mode.cross, mode.rate);
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
            &[same, cross, rate, stiffness, excess, presliding, stribeck, h, count],
            &[u],
            Ok(state),
            [y],
        ) = (coefficients, inputs, <&mut [f64; 3]>::try_from(state), outputs)
        else {
            return;
        };
        let mode = Transition { same, cross, rate };
        let law = Law { mode, stiffness, excess, presliding, stribeck, h };
        for _ in 0..count as usize {
            law.advance(u, state);
        }
        *y = state[0];
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

    /// Ten rows per period: next to no friction leaves the mode its own damping.
    #[test]
    fn the_mode_keeps_its_damping_at_ten_rows_per_period() {
        let parameters = [400.0, 0.02, 1e-7, 1e-7, 1e-6, 1.0];
        let mut model = Instance::new(&Friction, &[], &parameters, 2.5e-4).unwrap();
        model.rest(&[1.0]);
        let mut mode = Instance::new(&crate::mechanics::MODE, &[], &[400.0, 0.02, 1.0], 2.5e-4);
        let mode = mode.as_mut().unwrap();
        mode.rest(&[1.0]);
        for n in 0..200 {
            let (own, plain) = (model.step(&[0.0]), mode.step(&[0.0]));
            assert!((own - plain).abs() < 1e-5, "row {n}: {own} and {plain}");
        }
    }

    #[test]
    fn rows_of_a_log_do_what_short_steps_do() {
        for parameters in
            [[400.0, 0.02, 0.05, 0.05, 0.1, 1e3], [400.0, 0.02, 0.1, 0.15, 0.02, 200.0]]
        {
            let run = |parts: usize| {
                let period = 2.5e-4 / parts as f64;
                let mut model = Instance::new(&Friction, &[], &parameters, period).unwrap();
                model.rest(&[0.0]);
                let rows = (0..300).map(|n| if n % 60 < 30 { 0.5 } else { -0.2 });
                let y: std::vec::Vec<f64> =
                    rows.map(|u| (0..parts).fold(0.0, |_, _| model.step(&[u]))).collect();
                y
            };
            let (complete, fine) = (run(1), run(40));
            let squares: f64 = complete.iter().zip(&fine).map(|(a, b)| (a - b).powi(2)).sum();
            let rms = (squares / 300.0).sqrt();
            assert!(rms < 1e-3, "{parameters:?}: {rms}");
        }
    }
}
