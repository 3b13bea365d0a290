//! Dahl hysteresis: a spring that yields, solved exactly.
//!
//! ```text
//! y = offset + gain·u − h,   dh/du = (height/length)·(1 − sgn(u′)·h/height)
//! ```
//!
//! * gain in position per command; height in position: half the height of the major loop; length
//!   in command: how far the command moves until the branch has closed 63 % of the way.
//! * State: h, and the last command. At rest: the virgin state (h = 0 at command 0) moved
//!   monotonically to the command.
//!
//! Limits: independent of rate; no return-point memory. It is the Duhem model with
//! decay = 1/length and initial = gain − height/length.
//!
//! Source: P. R. Dahl, A solid friction model, The Aerospace Corporation TOR-0158(3107-18)-1, 1968.

use model::{Component, Conversion, Declaration, Inverse, Quantity, Sizes, Stage, Tick, Violation};

use super::duhem::Law;
use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `dahl`.
pub struct Dahl;

static DECLARATION: Declaration = Declaration {
    kind: "dahl",
    name: "hysteresis",
    summary: "Dahl hysteresis: a spring that yields, exact over each step",
    equation: "y = offset + gain*u - h; dh/du = height/length*(1 - sgn(u')*h/height)",
    reference: "P. R. Dahl, A solid friction model, Aerospace Corp. TOR-0158(3107-18)-1, 1968",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    effect: Some(&effects::HYSTERESIS),
    phenomena: &[&phenomena::HYSTERESIS],
    parameters: &PARAMETERS,
    ..Declaration::PATH
};

/// Parameters of the Dahl model.
pub(super) const PARAMETERS: [Quantity; 4] = [
    Quantity::new("gain", "{position}/{command}", "Slope of the centre line").fitted(),
    Quantity::new("height", "{position}", "Half height of the major loop").min(0.0).fitted(),
    Quantity::new(
        "length",
        "{command}",
        "Change of the command over which a branch covers 63 % of its distance to the major loop",
    )
    .min(0.0)
    .fitted(),
    Quantity::new("offset", "{position}", "Position at zero command in the virgin state")
        .start(0.0)
        .fitted(),
];

impl Component for Dahl {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("gain", &[0.06]), ("height", &[0.4]), ("length", &[20.0]), ("offset", &[0.3])]
    }

    fn inverses(&self) -> &'static [Inverse] {
        const { &[Inverse::iteration("inverse-dahl")] }
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
        let (&[gain, height, length, offset], [k, half, rate, zero]) = (parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        require(length > 0.0, "length", length, "must be above zero; use a play for a sharp bend")?;
        (*k, *half, *rate, *zero) = (gain, height, 1.0 / length, offset);
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
    use super::super::Duhem;
    use super::*;
    use crate::testing::{Instance, Random};

    #[test]
    fn is_the_duhem_model_in_other_words() {
        let signal = Random::new(9).signal(-60.0, 120.0, 500);
        let dahl = Instance::new(&Dahl, &[], &[0.06, 0.4, 20.0, 0.3], 1e-3);
        let duhem = Instance::new(&Duhem, &[], &[0.06, 0.04, 0.05, 0.3], 1e-3);
        let (dahl, duhem) =
            (dahl.unwrap().response(7.0, &signal), duhem.unwrap().response(7.0, &signal));
        for (a, b) in dahl.iter().zip(&duhem) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn a_long_rise_lags_by_the_height() {
        let mut dahl = Instance::new(&Dahl, &[], &[0.06, 0.4, 20.0, 0.0], 1e-3).unwrap();
        assert!((dahl.rest(&[1000.0]) - (60.0 - 0.4)).abs() < 1e-12);
        // A way of one length closes 1 − 1/e of the distance 0.8 to the falling branch.
        let expected = 0.06 * 980.0 + 0.4 - 0.8 / core::f64::consts::E;
        assert!((dahl.step(&[980.0]) - expected).abs() < 1e-12);
    }
}
