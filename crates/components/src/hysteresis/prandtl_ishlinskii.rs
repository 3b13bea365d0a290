//! Prandtl–Ishlinskii hysteresis: a weighted sum of plays.
//!
//! `y = offset + Σ w_i P_{r_i}[u]`, `P_r[u] ← max(u − r, min(u + r, P_r))`
//!
//! * r_i thresholds in units of the command, 0 ≤ r_1 < r_2 < …; r_1 = 0 gives the part without
//!   memory, and a model that can be inverted.
//! * w_i weights in position per command, of either sign, as long as the virgin curve does not fall: w_1 + … + w_k ≥ 0. A
//!   negative one takes back what springs that slip have given (a friction force over a way).
//! * State: one number per play. At rest it is the one after a monotonic move from the virgin state
//!   (all plays 0) to the command.
//!
//! Limits: symmetric (the rising and the falling branch are congruent), independent of rate,
//! symmetric about the virgin curve. Loop area of one play under ±a: 4 w r (a − r).
//!
//! Source: K. Kuhnen, European Journal of Control 9 (2003) 407–418; P. Krejčí, K. Kuhnen, IEE Proceedings Control Theory and
//! Applications 148 (2001) 185–192 (a rising virgin curve has an inverse).

use model::{
    Component, Conversion, Declaration, Extension, Inverse, Quantity, Role, Sizes, Stage,
    Structural, Tick, Violation,
};

use super::play::Plays;
use crate::rules::{WRONG_LENGTH, increasing, kept, require, require_at};
use crate::{effects, phenomena};

/// The component `prandtl-ishlinskii`.
pub struct PrandtlIshlinskii;

/// Settings that the model and its inverse share.
pub(super) const PLAYS: Structural =
    Structural::count("plays", "Number of play operators", 1, 4096);
pub(super) const STRUCTURE: &[Structural] = &[PLAYS];
pub(super) const R: Quantity =
    Quantity::new("r", "{command}", "Threshold of each play, increasing from 0")
        .role(Role::Threshold)
        .min(0.0)
        .per(0);
pub(super) const W: Quantity = Quantity::new("w", "{position}/{command}", "Weight of each play")
    .role(Role::Weight)
    .releases(&effects::HYSTERESIS)
    .min(0.0)
    .per(0)
    .fitted();
/// The weights of plays alone.
pub(super) const LOADING_W: Quantity = Quantity::new(
    "w",
    "{position}/{command}",
    "Weight of each play; the first k add up to 0 or more",
)
.role(Role::Weight)
.releases(&effects::HYSTERESIS)
.per(0)
.fitted();
pub(super) const OFFSET: Quantity =
    Quantity::new("offset", "{position}", "Position at zero command in the virgin state")
        .start(0.0)
        .fitted();

static DECLARATION: Declaration = Declaration {
    kind: "prandtl-ishlinskii",
    name: "hysteresis",
    summary: "Symmetric hysteresis, independent of rate: a weighted sum of play operators",
    equation: "y = offset + sum(w[i]*P[i]); P[i] = max(u - r[i], min(u + r[i], P[i]))",
    reference: "K. Kuhnen, European Journal of Control 9 (2003) 407-418",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::HYSTERESIS),
    phenomena: &[&phenomena::HYSTERESIS],
    structure: STRUCTURE,
    parameters: &[R, LOADING_W, OFFSET],
    ..Declaration::PATH
};

/// Checks thresholds and weights of plays alone: the virgin curve rises, or stands still.
pub(super) fn check_loading(plays: Plays<'_>) -> Result<(), Violation> {
    /// Part of the weights that is their rounding.
    const ROUNDING: f64 = 1e-12;
    check_thresholds(plays)?;
    let size: f64 = plays.w.iter().map(|w| w.abs()).sum();
    require(size > 0.0, "w", size, "the weights are zero: nothing would move; give one")?;
    let mut slope = 0.0;
    for (index, weight) in plays.w.iter().enumerate() {
        slope += weight;
        let rule = "the weights up to here add up to less than 0, so that the virgin curve would fall; make it larger";
        require_at(slope >= -ROUNDING * size, "w", index, *weight, rule)?;
    }
    Ok(())
}

fn check_thresholds(plays: Plays<'_>) -> Result<(), Violation> {
    increasing(
        "r",
        plays.r,
        "thresholds start at 0 or above and are strictly increasing; sort them, and add up the \
         weights of equal ones",
    )
}

/// Checks thresholds and weights.
pub(super) fn check_plays(plays: Plays<'_>) -> Result<(), Violation> {
    check_thresholds(plays)?;
    for (index, weight) in plays.w.iter().enumerate() {
        require_at(*weight >= 0.0, "w", index, *weight, "weights are zero or positive")?;
    }
    let sum: f64 = plays.w.iter().sum();
    require(sum > 0.0, "w", sum, "the sum of the weights is zero: nothing would move; give one")
}

/// Checks that every position belongs to one command.
pub(super) fn check_invertible(plays: Plays<'_>) -> Result<(), Violation> {
    let (Some(&r), Some(&w)) = (plays.r.first(), plays.w.first()) else {
        return Err(WRONG_LENGTH);
    };
    let rule = "a model whose first threshold is above 0 has no inverse; identify it with r[1] = 0";
    require_at(r == 0.0, "r", 0, r, rule)?;
    let rule = "a model whose first weight is 0 has no inverse; identify it with w[1] above 0";
    require_at(w > 0.0, "w", 0, w, rule)
}

/// `r | w | offset`, the layout of parameters and coefficients, as plays and offset.
#[inline]
pub(super) fn plays(coefficients: &[f64]) -> (Plays<'_>, f64) {
    let Some((&offset, arrays)) = coefficients.split_last() else {
        return (Plays { r: &[], w: &[] }, 0.0);
    };
    let (r, w) = arrays.split_at(arrays.len() / 2);
    (Plays { r, w }, offset)
}

impl Component for PrandtlIshlinskii {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("r", &[0.0, 8.0, 20.0]), ("w", &[0.05, 0.02, 0.01]), ("offset", &[0.3])]
    }

    fn extended(&self, by: Extension) -> Option<&'static dyn Component> {
        super::extended(by)
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::closed_form("inverse-prandtl-ishlinskii")] }
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let plays = DECLARATION.length(0, structure);
        Sizes { coefficients: 2 * plays + 1, states: plays }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        check_loading(plays(parameters).0)?;
        kept(parameters, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        let (plays, offset) = plays(coefficients);
        *y = offset + plays.rest(u, state);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        let (plays, offset) = plays(coefficients);
        *y = offset + plays.step(u, state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, loop_area, triangle};

    fn instance(parameters: &[f64]) -> Result<Instance, Violation> {
        let plays = (parameters.len() - 1) as f64 / 2.0;
        Instance::new(&PrandtlIshlinskii, &[plays], parameters, 1e-3)
    }

    #[test]
    fn loop_area_is_the_sum_over_the_plays() {
        let (r, w, a): ([f64; 4], [f64; 4], f64) =
            ([0.0, 0.25, 0.5, 1.5], [2.0, 1.0, 3.0, 4.0], 1.0);
        let mut model = instance(&[0.0, 0.25, 0.5, 1.5, 2.0, 1.0, 3.0, 4.0, 5.0]).unwrap();
        let signal = triangle(-a, a, 64, 2);
        let output = model.response(0.0, &signal);
        let area = loop_area(&signal[128..], &output[128..]);
        let expected: f64 = r.iter().zip(&w).map(|(r, w)| 4.0 * w * r * (a - r).max(0.0)).sum();
        assert!((area - expected).abs() < 1e-12, "{area} {expected}");
    }

    #[test]
    fn at_rest_it_is_on_the_virgin_curve() {
        let parameters = [0.0, 6.0, 12.0, 0.5, 0.25, 0.125, 3.0];
        let mut model = instance(&parameters).unwrap();
        assert_eq!(model.rest(&[10.0]), 3.0 + 0.5 * 10.0 + 0.25 * 4.0);
        assert_eq!(model.rest(&[-20.0]), 3.0 - 0.5 * 20.0 - 0.25 * 14.0 - 0.125 * 8.0);
        assert_eq!(model.step(&[-20.0]), model.rest(&[-20.0]));
    }

    #[test]
    fn refuses_sets_that_are_no_model_and_names_the_element() {
        let refused =
            |parameters: &[f64]| instance(parameters).err().map(|v| (v.quantity, v.index));
        assert_eq!(refused(&[0.0, 2.0, 1.0, 1.0, 1.0, 1.0, 0.0]), Some(("r", Some(2))));
        assert_eq!(refused(&[0.0, 0.0, 1.0, 1.0, 0.0]), Some(("r", Some(1))));
        assert_eq!(refused(&[-1.0, 0.0, 1.0, 1.0, 0.0]), Some(("r", Some(0))));
        assert_eq!(refused(&[0.0, 1.0, 1.0, -1.1, 0.0]), Some(("w", Some(1))));
        assert_eq!(refused(&[0.0, 1.0, 0.0, 0.0, 0.0]), Some(("w", None)));
        assert_eq!(refused(&[0.0, 1.0, 1.0, -0.9, 0.0]), None);
        // A friction alone, and numbers that add up to −6e-17.
        assert_eq!(refused(&[0.0, 1.0, 1.0, -1.0, 0.0]), None);
        assert_eq!(refused(&[0.0, 1.0, 2.0, 0.3, -0.2, -0.1 - 1e-16, 0.0]), None);
        assert_eq!(refused(&[0.0, 1.0, 1.0, 1.0, 0.0]), None);
    }
}
