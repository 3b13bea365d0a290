//! Current limit of the amplifier, as a limit of the voltage's slope.
//!
//! `v′ = min(max((u − v)/T, −rate), rate)`
//!
//! * rate in command per second: greatest current over capacitance.
//! * State: v. Over a step in which the input is held, v runs straight towards it and stops there,
//!   so the value at the end of the step is exact at any period.
//!
//! Limits: the same limit for charging and discharging; constant capacitance.

use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `amplifier-slew`.
pub struct AmplifierSlew;

static DECLARATION: Declaration = Declaration {
    kind: "amplifier-slew",
    name: "slew",
    summary: "Current limit of the amplifier, as a limit of the slope",
    equation: "v' = min(max((u - v)/T, -rate), rate)",
    reference: "A. J. Fleming, K. K. Leang, Design, Modeling and Control of Nanopositioning \
                Systems, Springer 2014, ch. 14",
    stage: Stage::Amplifier,
    effect: Some(&effects::AMPLIFIER_SLEW),
    phenomena: &[&phenomena::CURRENT_LIMIT],
    parameters: &[Quantity::new("rate", "{command}/s", "Greatest slope").min(0.0).fitted()],
    ..Declaration::PATH
};

/// v after a step towards u, by at most these ways down and up.
#[inline]
#[must_use]
pub fn slewed(v: f64, u: f64, [down, up]: [f64; 2]) -> f64 {
    let change = u - v;
    if change > up {
        v + up
    } else if change < -down {
        v - down
    } else {
        u
    }
}

impl Component for AmplifierSlew {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 1, states: 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[rate], [way]) = (parameters, coefficients) else { return Err(WRONG_LENGTH) };
        require(rate > 0.0, "rate", rate, "must be above zero; set enabled = false for no limit")?;
        *way = rate * period;
        Ok(())
    }

    #[cfg_attr(feature = "records", inline)]
    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [v], [y]) = (inputs, state, outputs) else { return };
        (*v, *y) = (u, u);
    }

    #[cfg_attr(feature = "records", inline)]
    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[way], &[u], [v], [y]) = (coefficients, inputs, state, outputs) else { return };
        *v = slewed(*v, u, [way; 2]);
        *y = *v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn follows_what_is_slow_to_the_bit_and_limits_what_is_fast() {
        let mut slew = Instance::new(&AmplifierSlew, &[], &[1000.0], 1e-3).unwrap();
        slew.rest(&[0.1]);
        assert_eq!(slew.step(&[0.7]), 0.7);
        assert_eq!(slew.step(&[3.2]), 1.7);
        assert_eq!(slew.step(&[3.2]), 2.7);
        assert_eq!(slew.step(&[3.2]), 3.2);
        assert_eq!(slew.step(&[-9.0]), 3.2 - 1.0);
    }
}
