//! Remanence of an unknown past, which fades until the command has wiped it out.
//!
//! `y = x + remanence·max(0, 1 − w/reach)`,  `w = max |u(s) − u(0)|` over s ≤ t
//!
//! * remanence in position: how far off the start is (up to the loop's width); reach in command:
//!   after an excursion of this size nothing is left (the range, or twice the greatest play). u is
//!   the axis' command.
//! * A play that was left at another state goes back to the one of the model as soon as the command
//!   has moved by twice its threshold; with many plays of even weight the sum of what is left falls
//!   straight over the excursion.
//! * State: the command at the start and w. At rest w = 0.
//!
//! Limits: only the start; a loop that is run in has none.
//!
//! Source: I. D. Mayergoyz, Mathematical Models of Hysteresis and Their Applications, Elsevier
//! 2003, ch. 1 (wiping out).

use libm::{fabs, fmax};
use model::{Component, Declaration, Input, Quantity, Sizes, Stage, Tick, Violation};

use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `remanence`.
pub struct Remanence;

static DECLARATION: Declaration = Declaration {
    kind: "remanence",
    name: "remanence",
    summary: "Remanence of an unknown past, which fades until the command has wiped it out",
    equation: "y = x + remanence*max(0, 1 - w/reach); w = max |u(s) - u(0)|, s <= t",
    reference: "I. D. Mayergoyz, Mathematical Models of Hysteresis and Their Applications, 2003",
    stage: Stage::Actuator,
    effect: Some(&effects::INITIAL_STATE),
    phenomena: &[&phenomena::REMANENCE],
    inputs: &[Input::PATH, Input { at_rest: false, ..Input::axis("command") }],
    parameters: &[
        Quantity::new("remanence", "{position}", "Difference at the start").fitted(),
        Quantity::new("reach", "{command}", "Excursion of the command that wipes it out")
            .min(0.0)
            .fitted(),
    ],
    ..Declaration::PATH
};

impl Component for Remanence {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 2, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[remanence, reach], [start, per_command]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must be above zero; set enabled = false for no remanence";
        require(reach > 0.0, "reach", reach, rule)?;
        (*start, *per_command) = (remanence, 1.0 / reach);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[start, _], &[x, u], [first, excursion], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        (*first, *excursion) = (u, 0.0);
        *y = x + start;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[start, per_command], &[x, u], [first, excursion], [y]) =
            (coefficients, inputs, state, outputs)
        else {
            return;
        };
        *excursion = fmax(*excursion, fabs(u - *first));
        *y = x + start * fmax(1.0 - per_command * *excursion, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::hysteresis::PrandtlIshlinskii;
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn shrinks_with_the_greatest_excursion_and_never_returns() {
        let mut model = Instance::new(&Remanence, &[], &[0.8, 40.0], 1e-3).unwrap();
        assert_eq!(model.rest(&[5.0, 30.0]), 5.8);
        for (u, left) in [(30.0, 0.8), (40.0, 0.6), (35.0, 0.6), (10.0, 0.4), (30.0, 0.4)] {
            assert!((model.step(&[5.0, u]) - 5.0 - left).abs() < 1e-12, "{u}");
        }
        assert_eq!(model.step(&[5.0, 70.0]), 5.0);
        assert_eq!(model.step(&[5.0, 30.0]), 5.0);
    }

    /// Plays of even weights that were left at their upper ends.
    #[test]
    fn is_what_plays_with_another_past_show() {
        let (count, weight) = (400, 1e-3);
        let r = (0..count).map(|i| 20.0 * (f64::from(i) + 0.5) / f64::from(count));
        let p: std::vec::Vec<f64> = r.chain((0..count).map(|_| weight)).chain([0.0]).collect();
        let build = || Instance::new(&PrandtlIshlinskii, &[f64::from(count)], &p, 1e-3).unwrap();
        let (mut fresh, mut used) = (build(), build());
        // From far below and from far above to 0: plays at their lower and upper ends.
        fresh.rest(&[-100.0]);
        used.rest(&[100.0]);
        let start = used.step(&[0.0]) - fresh.step(&[0.0]);
        let mut model = Instance::new(&Remanence, &[], &[start, 40.0], 1e-3).unwrap();
        model.rest(&[0.0, 0.0]);
        // A one-sided excursion wipes a play of threshold r after 2r.
        for n in 1..=45 {
            let u = f64::from(n);
            let found = used.step(&[u]) - fresh.step(&[u]);
            let square = (1.0 - u / 40.0).max(0.0);
            assert!(found >= -1e-9 && found <= start * square + 1e-9, "{u}: {found}");
            assert!((model.step(&[0.0, u]) - start * square).abs() < 1e-12);
        }
        let mut random = Random::new(3);
        for _ in 0..50 {
            let u = random.between(-60.0, 60.0);
            assert!((used.step(&[u]) - fresh.step(&[u])).abs() < 1e-9);
            assert_eq!(model.step(&[0.0, u]), 0.0);
        }
    }
}
