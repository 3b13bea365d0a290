//! Kuhnen's modified Prandtl–Ishlinskii hysteresis: plays followed by one-sided dead zones.
//!
//! `y = offset + S(Σ w_i P_{r_i}[u])`, S as in [`DeadZones`]
//!
//! * r, w as in `prandtl-ishlinskii`.
//! * edge_j in position, increasing and not 0; slope_j the change of the slope beyond it, outwards.
//! * State: one number per play.
//!
//! Limits: independent of rate. It describes loops whose branches are not symmetric about a point;
//! all minor loops between the same commands are still images of each other under S.
//!
//! Source: K. Kuhnen, European Journal of Control 9 (2003) 407–418.

use model::{
    Component, Conversion, Declaration, Inverse, Quantity, Sizes, Stage, Structural, Tick,
    Violation,
};

use super::dead_zone::DeadZones;
use super::play::{Plays, invert};
use super::prandtl_ishlinskii::{OFFSET, PLAYS, R, W, check_invertible, check_plays};
use crate::rules::{WRONG_LENGTH, kept};
use crate::{effects, phenomena};

/// The component `modified-prandtl-ishlinskii`.
pub struct ModifiedPrandtlIshlinskii;

/// The component `inverse-modified-prandtl-ishlinskii`:
/// `u = H⁻¹[S⁻¹(y − offset)]` in closed form, given by the forward model's parameters. It needs
/// r_1 = 0 and w_1 > 0.
pub struct InverseModifiedPrandtlIshlinskii;

const STRUCTURE: &[Structural] =
    &[PLAYS, Structural::count("zones", "Number of one-sided dead zones", 1, 256)];
const PARAMETERS: &[Quantity] = &[
    R,
    W,
    Quantity::new("edge", "{position}", "Edge of each dead zone, increasing, not 0").per(1),
    Quantity::new("slope", "1", "Change of the slope beyond each edge, away from 0")
        .per(1)
        .fitted(),
    OFFSET,
];

static DECLARATION: Declaration = Declaration {
    kind: "modified-prandtl-ishlinskii",
    name: "hysteresis",
    summary: "Asymmetric hysteresis, independent of rate: plays followed by one-sided dead zones",
    equation: "y = offset + x + sum(slope[j]*z[j](x)); x = sum(w[i]*P[i]); z[j] = max(x - \
               edge[j], 0) for edge[j] > 0, else min(x - edge[j], 0)",
    reference: "K. Kuhnen, European Journal of Control 9 (2003) 407-418",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::ASYMMETRY),
    phenomena: &[&phenomena::ASYMMETRIC_HYSTERESIS],
    structure: STRUCTURE,
    parameters: PARAMETERS,
    ..Declaration::PATH
};

static INVERSE: Declaration = Declaration {
    kind: "inverse-modified-prandtl-ishlinskii",
    name: "feedforward",
    summary: "Exact inverse of a modified Prandtl-Ishlinskii model, given by its parameters",
    equation: "u = inverse plays of S^-1(y - offset); S^-1 is piecewise linear with the edges \
               S(edge[j]) and the reciprocal slopes",
    reference: "K. Kuhnen, European Journal of Control 9 (2003) 407-418",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: STRUCTURE,
    parameters: PARAMETERS,
    ..Declaration::PATH
};

/// Coefficients and parameters are laid out alike: `r | w | edge | slope | offset`.
fn parts(values: &[f64], plays: usize) -> Option<(Plays<'_>, DeadZones<'_>, f64)> {
    let (&offset, arrays) = values.split_last()?;
    let (r, rest) = arrays.split_at_checked(plays)?;
    let (w, zones) = rest.split_at_checked(plays)?;
    let (edges, slopes) = zones.split_at(zones.len() / 2);
    Some((Plays { r, w }, DeadZones { edges, slopes }, offset))
}

fn sizes(structure: &[f64]) -> Sizes {
    let plays = DECLARATION.length(0, structure);
    Sizes { coefficients: DECLARATION.parameter_count(structure), states: plays }
}

impl Component for ModifiedPrandtlIshlinskii {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[
            ("r", &[0.0, 8.0, 20.0]),
            ("w", &[0.05, 0.02, 0.01]),
            ("edge", &[-1.0, 3.0]),
            ("slope", &[0.1, -0.2]),
            ("offset", &[0.3]),
        ]
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::closed_form("inverse-modified-prandtl-ishlinskii")] }
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        sizes(structure)
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let plays = DECLARATION.length(0, structure);
        let (forward, zones, _) = parts(parameters, plays).ok_or(WRONG_LENGTH)?;
        check_plays(forward)?;
        zones.check()?;
        kept(parameters, coefficients)
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        let Some((plays, zones, offset)) = parts(coefficients, state.len()) else { return };
        *y = offset + zones.map(plays.rest(u, state));
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
        let Some((plays, zones, offset)) = parts(coefficients, state.len()) else { return };
        *y = offset + zones.map(plays.step(u, state));
    }
}

impl Component for InverseModifiedPrandtlIshlinskii {
    fn declaration(&self) -> &'static Declaration {
        &INVERSE
    }

    fn example(&self) -> model::Example {
        ModifiedPrandtlIshlinskii.example()
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        sizes(structure)
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let count = DECLARATION.length(0, structure);
        let (forward, zones, offset) = parts(parameters, count).ok_or(WRONG_LENGTH)?;
        check_plays(forward)?;
        check_invertible(forward)?;
        zones.check()?;
        if coefficients.len() != parameters.len() {
            return Err(WRONG_LENGTH);
        }
        let (plays, rest) = coefficients.split_at_mut(2 * count);
        let (r, w) = plays.split_at_mut(count);
        invert(forward.r, forward.w, r, w);
        let Some((inverse_offset, rest)) = rest.split_last_mut() else { return Err(WRONG_LENGTH) };
        let (edges, slopes) = rest.split_at_mut(zones.edges.len());
        zones.invert(edges, slopes);
        *inverse_offset = offset;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[y], [u]) = (inputs, outputs) else { return };
        let Some((plays, zones, offset)) = parts(coefficients, state.len()) else { return };
        *u = plays.rest(zones.map(y - offset), state);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[y], [u]) = (inputs, outputs) else { return };
        let Some((plays, zones, offset)) = parts(coefficients, state.len()) else { return };
        *u = plays.step(zones.map(y - offset), state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Instance, Random};

    const PARAMETERS: [f64; 13] = [
        0.0, 10.0, 30.0, 60.0, // r
        0.02, 0.01, 0.005, 0.01, // w
        -1.0, 1.5, // edge
        0.2, -0.3, // slope
        0.5,  // offset
    ];

    fn both() -> (Instance, Instance) {
        let new = |component| Instance::new(component, &[4.0, 2.0], &PARAMETERS, 1e-4).unwrap();
        (new(&ModifiedPrandtlIshlinskii), new(&InverseModifiedPrandtlIshlinskii))
    }

    #[test]
    fn inverse_and_forward_are_the_identity_in_both_orders_and_from_rest() {
        let (mut forward, mut inverse) = both();
        let mut random = Random::new(8);
        for _ in 0..20 {
            let mut u = random.between(-100.0, 120.0);
            assert!((inverse.rest(&[forward.rest(&[u])]) - u).abs() < 1e-9 * 120.0);
            for _ in 0..300 {
                u = random.between(-100.0, 120.0);
                assert!((inverse.step(&[forward.step(&[u])]) - u).abs() < 1e-9 * 120.0);
            }
            forward.rest(&[inverse.rest(&[random.between(-2.0, 3.0)])]);
            for _ in 0..300 {
                let y = random.between(-2.0, 3.0);
                assert!((forward.step(&[inverse.step(&[y])]) - y).abs() < 1e-9 * 3.0);
            }
        }
    }

    #[test]
    fn without_slopes_it_is_the_symmetric_model() {
        let mut parameters = PARAMETERS;
        parameters[10..12].fill(0.0);
        let with = Instance::new(&ModifiedPrandtlIshlinskii, &[4.0, 2.0], &parameters, 1e-4);
        let plain: std::vec::Vec<f64> =
            parameters[..8].iter().chain(&parameters[12..]).copied().collect();
        let plain = Instance::new(&super::super::PrandtlIshlinskii, &[4.0], &plain, 1e-4);
        let signal = Random::new(3).signal(-100.0, 120.0, 500);
        let (with, plain) =
            (with.unwrap().response(5.0, &signal), plain.unwrap().response(5.0, &signal));
        assert_eq!(with, plain);
    }
}
