//! Two modes side by side, sharing the motion.
//!
//! `y = (1 − share)·x_1 + share·x_2`, `x_i″ + 2ζ_i·ω_i·x_i′ + ω_i²·x_i = ω_i²·u`
//!
//! * frequency, damping, second_frequency, second_damping: of the modes; share without unit: part
//!   of the static motion in the second one. A negative share puts no antiresonance between them.
//! * State: x_i and x_i′/ω_i. Exact at any period, as the input is held over a step.
//!
//! Limits: linear; static gain 1.

use model::{Component, Declaration, Quantity, Role, Sizes, Stage, Tick, Violation};

use crate::linear::Transition;
use crate::rules::{WRONG_LENGTH, positive_frequency, require, second_order};
use crate::{effects, phenomena};

/// The component `mode-pair`.
pub struct ModePair;

static DECLARATION: Declaration = Declaration {
    kind: "mode-pair",
    name: "modes",
    summary: "Two second-order modes side by side",
    equation: "y = (1 - share)*x1 + share*x2; x'' + 2*damping*w*x' + w^2*x = w^2*u for each",
    reference: "A. Preumont, Vibration Control of Active Structures, 3rd ed. 2011, ch. 2",
    stage: Stage::Mechanics,
    effect: Some(&effects::EXTRA_MODE),
    phenomena: &[&phenomena::SECOND_MODE],
    parameters: &[
        Quantity::new("frequency", "Hz", "Natural frequency of the first mode")
            .role(Role::Frequency)
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("damping", "1", "Damping ratio of the first mode")
            .role(Role::Damping)
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
        Quantity::new("second_frequency", "Hz", "Natural frequency of the second mode")
            .releases(&effects::RESONANCE_SHIFT)
            .min(0.0)
            .fitted(),
        Quantity::new("second_damping", "1", "Damping ratio of the second mode")
            .releases(&effects::DAMPING)
            .min(0.0)
            .fitted(),
        Quantity::new("share", "1", "Part of the static motion in the second mode").fitted(),
    ],
    ..Declaration::PATH
};

impl Component for ModePair {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 7, states: 4 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[frequency, damping, second, second_damping, part], [a, b, c, d, e, f, share]) =
            (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        second_order(frequency, damping, period)?;
        positive_frequency("second_frequency", second)?;
        let rule = "must be above zero: an undamped mode never comes to rest";
        require(second_damping > 0.0, "second_damping", second_damping, rule)?;
        let (one, two) = (
            Transition::new(frequency, damping, period),
            Transition::new(second, second_damping, period),
        );
        (*a, *b, *c) = (one.same, one.cross, one.rate);
        (*d, *e, *f, *share) = (two.same, two.cross, two.rate, part);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[.., share], &[u], [x, v, z, w], [y]) = (coefficients, inputs, state, outputs) else {
            return;
        };
        (*x, *v, *z, *w) = (u, 0.0, u, 0.0);
        *y = *x + share * (*z - *x);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[a, b, c, d, e, f, share], &[u], [x, v, z, w], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        let (first, first_rate) = Transition { same: a, cross: b, rate: c }.apply(*x - u, *v);
        let (second, second_rate) = Transition { same: d, cross: e, rate: f }.apply(*z - u, *w);
        (*x, *v, *z, *w) = (u + first, first_rate, u + second, second_rate);
        *y = *x + share * (*z - *x);
    }
}

#[cfg(test)]
mod tests {
    use super::super::MODE;
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn is_the_weighted_sum_of_two_modes() {
        let signal = Random::new(4).signal(-1.0, 1.0, 300);
        let run = |component: &'static dyn Component, p: &[f64]| {
            Instance::new(component, &[], p, 1e-4).unwrap().response(0.5, &signal)
        };
        let pair = run(&ModePair, &[300.0, 0.02, 700.0, 0.01, 0.2]);
        let (one, two) = (run(&MODE, &[300.0, 0.02, 1.0]), run(&MODE, &[700.0, 0.01, 1.0]));
        for ((y, a), b) in pair.iter().zip(&one).zip(&two) {
            assert!((y - 0.8 * a - 0.2 * b).abs() < 1e-13);
        }
    }
}
