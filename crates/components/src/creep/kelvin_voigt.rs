//! Creep as a chain of Kelvin–Voigt elements.
//!
//! `y = u + Σ share_i·z_i`, `time_constant_i·z_i′ = u − z_i`
//!
//! * share_i without unit: the part of a step that element i adds in the end (2–8 % in sum);
//!   time_constant_i in s, spread over the decades of interest, in increasing order.
//! * State: z_i. Exact at any period, as the input is held over a step. At rest all elements have
//!   reached the input: the static gain is 1 + Σ share_i.
//!
//! Limits: linear. With few elements the response is curved over the logarithm of time.
//!
//! Source: H. Janocha, K. Kuhnen, Sensors and Actuators A 79 (2000) 83–89.

use model::{Component, Declaration, Inverse, Quantity, Sizes, Stage, Structural, Tick, Violation};

use super::elements::{Elements, coefficients, parts_mut};
use crate::linear::approach;
use crate::rules::{WRONG_LENGTH, increasing, require_at};
use crate::{effects, phenomena};

/// The component `kelvin-voigt-creep`.
pub struct KelvinVoigtCreep;

pub(super) static DECLARATION: Declaration = Declaration {
    kind: "kelvin-voigt-creep",
    name: "creep",
    summary: "Creep as a sum of first-order elements with given time constants",
    equation: "y = u + sum(share[i]*z[i]); time_constant[i]*z[i]' = u - z[i]",
    reference: "H. Janocha, K. Kuhnen, Sensors and Actuators A 79 (2000) 83-89",
    stage: Stage::Actuator,
    effect: Some(&effects::CREEP),
    phenomena: &[&phenomena::CREEP],
    structure: &[Structural::count("elements", "Number of elements", 1, 64)],
    parameters: &[
        Quantity::new("share", "1", "Final creep of each element, relative to the step")
            .releases(&effects::CREEP)
            .per(0)
            .fitted(),
        Quantity::new("time_constant", "s", "Time constant of each element, increasing")
            .min(0.0)
            .per(0)
            .fitted(),
    ],
    ..Declaration::PATH
};

impl Component for KelvinVoigtCreep {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::closed_form("inverse-kelvin-voigt-creep")] }
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        let elements = DECLARATION.length(0, structure);
        Sizes { coefficients: coefficients(elements), states: elements }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (share, time_constant) = parameters.split_at(parameters.len() / 2);
        let first = time_constant.first().copied().unwrap_or(0.0);
        let rule = "must be above zero; leave out an element that acts at once";
        require_at(first > 0.0, "time_constant", 0, first, rule)?;
        increasing(
            "time_constant",
            time_constant,
            "time constants are strictly increasing; sort the elements, and add up the shares of \
             equal ones",
        )?;
        let (direct, fractions, shares) = parts_mut(coefficients).ok_or(WRONG_LENGTH)?;
        if shares.len() != share.len() {
            return Err(WRONG_LENGTH);
        }
        *direct = 1.0;
        shares.copy_from_slice(share);
        for (f, tau) in fractions.iter_mut().zip(time_constant) {
            *f = approach(*tau, period);
        }
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (Some(e), &[u], [y]) = (Elements::new(coefficients), inputs, outputs) else { return };
        *y = e.rest(u, state);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (Some(e), &[u], [y]) = (Elements::new(coefficients), inputs, outputs) else { return };
        *y = e.step(u, state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn step_response_is_the_sum_of_exponentials_at_every_step_size() {
        let p = [0.02, 0.03, 0.5, 20.0];
        for period in [1e-3, 0.1, 7.0] {
            let mut creep = Instance::new(&KelvinVoigtCreep, &[2.0], &p, period).unwrap();
            assert_eq!(creep.rest(&[0.0]), 0.0);
            for n in 1..300 {
                let t = f64::from(n) * period;
                let exact = 1.0 - 0.02 * (-t / 0.5).exp_m1() - 0.03 * (-t / 20.0).exp_m1();
                assert!((creep.step(&[1.0]) - exact).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn at_rest_it_has_crept_to_the_end() {
        let mut creep = Instance::new(&KelvinVoigtCreep, &[1.0], &[0.25, 3.0], 1e-3).unwrap();
        assert_eq!(creep.rest(&[2.0]), 2.5);
        assert_eq!(creep.step(&[2.0]), 2.5);
    }

    #[test]
    fn unsorted_time_constants_are_refused() {
        let p = [0.02, 0.03, 20.0, 0.5];
        let error = Instance::new(&KelvinVoigtCreep, &[2.0], &p, 1e-3).err();
        assert_eq!(error.map(|v| (v.quantity, v.index)), Some(("time_constant", Some(1))));
    }
}
