//! The exact inverse of a Prandtl–Ishlinskii model, for feedforward.
//!
//! `u = Σ w'_i P_{r'_i}[y − offset]` with r', w' in closed form from the forward model's r and w
//! ([`invert`](super::play::invert)). Its parameters are the forward model's, so that an identified
//! model is inverted by copying it.
//!
//! * It needs r_1 = 0 and w_1 + … + w_k > 0 for all k: only then does every position belong to one command.
//! * State: one number per play. At rest it is the virgin state moved monotonically to the
//!   position, which is the image of the forward model's state at rest: a machine and its inverse
//!   that are both at rest agree from the first step.
//!
//! Limits: those of the forward model; the command is not limited.
//!
//! Source: K. Kuhnen, European Journal of Control 9 (2003) 407–418; P. Krejčí, K. Kuhnen, IEE Proceedings Control Theory and
//! Applications 148 (2001) 185–192.

use model::{Component, Conversion, Declaration, Sizes, Stage, Tick, Violation};

use super::play::invert;
use super::prandtl_ishlinskii::{
    LOADING_W, OFFSET, R, STRUCTURE, check_invertible, check_loading, plays,
};
use crate::rules::{WRONG_LENGTH, require_at};

/// The component `inverse-prandtl-ishlinskii`.
pub struct InversePrandtlIshlinskii;

static DECLARATION: Declaration = Declaration {
    kind: "inverse-prandtl-ishlinskii",
    name: "feedforward",
    summary: "Exact inverse of a Prandtl-Ishlinskii model, given by the forward model's parameters",
    equation: "u = sum(w'[i]*P[i]); P[i] = max(y - offset - r'[i], min(y - offset + r'[i], \
               P[i])); w'[1] = 1/w[1]; w'[i] = -w[i]/(sum(w[1..i])*sum(w[1..i-1])); r'[i] = \
               sum(w[j]*(r[i] - r[j]), j = 1..i)",
    reference: "K. Kuhnen, European Journal of Control 9 (2003) 407-418",
    stage: Stage::Control,
    conversion: Conversion::PositionToCommand,
    structure: STRUCTURE,
    parameters: &[R, LOADING_W, OFFSET],
    ..Declaration::PATH
};

impl Component for InversePrandtlIshlinskii {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("r", &[0.0, 8.0, 20.0]), ("w", &[0.05, 0.02, 0.01]), ("offset", &[0.3])]
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
        let (forward, offset) = plays(parameters);
        check_loading(forward)?;
        check_invertible(forward)?;
        let mut slope = 0.0;
        for (index, weight) in forward.w.iter().enumerate() {
            slope += weight;
            let rule = "the weights up to here add up to 0, so that the position stands still: there is no inverse";
            require_at(slope > 0.0, "w", index, *weight, rule)?;
        }
        let Some((inverse_offset, arrays)) = coefficients.split_last_mut() else {
            return Err(WRONG_LENGTH);
        };
        let (inverse_r, inverse_w) = arrays.split_at_mut(arrays.len() / 2);
        invert(forward.r, forward.w, inverse_r, inverse_w);
        *inverse_offset = offset;
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[y], [u]) = (inputs, outputs) else { return };
        let (plays, offset) = plays(coefficients);
        *u = plays.rest(y - offset, state);
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
        let (plays, offset) = plays(coefficients);
        *u = plays.step(y - offset, state);
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::super::PrandtlIshlinskii;
    use super::*;
    use crate::testing::{Instance, Random};

    /// Tables 2 and 3 of the EVC paper, in SI.
    const Y: [f64; 10] = [0.01354, 0.02790, 0.0, 0.004014, 0.007765, 0.0, 0.0, 0.0, 0.0, 0.0];
    const Z: [f64; 10] = [0.02523, 0.04579, 0.0, 0.004541, 0.001636, 0.0, 0.0, 0.0, 0.0, 0.0];

    fn parameters(w: &[f64], offset: f64) -> Vec<f64> {
        let r = (0..w.len()).map(|i| 6.0 * i as f64);
        r.chain(w.iter().map(|w| w * 1e-6)).chain([offset]).collect()
    }

    fn both_ways(parameters: &[f64], seed: u64) {
        let plays = [(parameters.len() / 2) as f64];
        let mut forward = Instance::new(&PrandtlIshlinskii, &plays, parameters, 1e-4).unwrap();
        let mut inverse =
            Instance::new(&InversePrandtlIshlinskii, &plays, parameters, 1e-4).unwrap();
        let mut random = Random::new(seed);
        let stroke = forward.rest(&[120.0]) - forward.rest(&[0.0]);
        for _ in 0..20 {
            let mut u = random.between(-120.0, 120.0);
            let y = forward.rest(&[u]);
            assert!((inverse.rest(&[y]) - u).abs() < 1e-9 * 120.0, "at rest at {u} V");
            for _ in 0..500 {
                u = random.between(-120.0, 120.0);
                let back = inverse.step(&[forward.step(&[u])]);
                assert!((back - u).abs() < 1e-9 * 120.0, "inverse of forward: {back} for {u}");
            }
            let mut y = random.between(-stroke, stroke);
            forward.rest(&[inverse.rest(&[y])]);
            for _ in 0..500 {
                y = random.between(-stroke, stroke);
                let back = forward.step(&[inverse.step(&[y])]);
                assert!((back - y).abs() < 1e-9 * stroke, "forward of inverse: {back} for {y}");
            }
        }
    }

    #[test]
    fn inverse_and_forward_are_the_identity_in_both_orders_and_from_rest() {
        both_ways(&parameters(&Y, 0.0), 1);
        // A friction over a way: what springs that slip have given is taken back.
        both_ways(&parameters(&[0.05, -0.02, 0.01, -0.03], 0.1), 4);
        both_ways(&parameters(&Z, 2.5e-6), 2);
        both_ways(&parameters(&[0.05], -1e-6), 3);
        let mut random = Random::new(4);
        for seed in 0..20 {
            both_ways(&parameters(&random.signal(0.001, 0.1, 30), 1e-6), 100 + seed);
        }
    }

    #[test]
    fn refuses_what_cannot_be_inverted() {
        let refused = |p: &[f64]| {
            let plays = [(p.len() / 2) as f64];
            Instance::new(&InversePrandtlIshlinskii, &plays, p, 1e-4).err().map(|v| v.quantity)
        };
        assert_eq!(refused(&[1.0, 2.0, 1.0, 1.0, 0.0]), Some("r"));
        assert_eq!(refused(&[0.0, 2.0, 0.0, 1.0, 0.0]), Some("w"));
        assert_eq!(refused(&[0.0, 2.0, 1.0, 0.0, 0.0]), None);
    }
}
