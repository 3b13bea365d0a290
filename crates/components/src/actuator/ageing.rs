//! Ageing of the actuator: its gain falls with the logarithm of time.
//!
//! `y = x·[1 − per_decade·lg(1 + t/age)]`
//!
//! * per_decade: relative loss of the gain per decade of time (0.01–0.05 after poling or for
//!   driving against the poling direction, next to nothing otherwise); age in s: time since poling
//!   at the start of the run: after nine times as long again, a decade has gone by. t is the time
//!   since the start.
//! * No state; a function of time. At rest (t = 0) y = x.
//!
//! Limits: until the gain has fallen to nothing; it scales the whole path, as sensor data cannot
//! tell it from a sensor's gain. Within one run it shows only where the run is not short against
//! the age; between runs it is a different `actuator-gain`.
//!
//! Source: IEEE Std 176, Standard on Piezoelectricity (ageing rates per decade); B. Jaffe, W. R.
//! Cook, H. Jaffe, Piezoelectric Ceramics, Academic Press 1971, ch. 2.

use core::f64::consts::LOG10_E;

use libm::{fmax, log1p};
use model::{Component, Declaration, Quantity, Sizes, Stage, Tick, Violation};

use crate::rules::{WRONG_LENGTH, require};
use crate::{effects, phenomena};

/// The component `actuator-ageing`.
pub struct ActuatorAgeing;

static DECLARATION: Declaration = Declaration {
    kind: "actuator-ageing",
    name: "ageing",
    summary: "Ageing of the actuator: its gain falls with the logarithm of time",
    equation: "y = x*(1 - per_decade*lg(1 + t/age))",
    reference: "B. Jaffe, W. R. Cook, H. Jaffe, Piezoelectric Ceramics, Academic Press 1971, ch. 2",
    stage: Stage::Actuator,
    effect: Some(&effects::ACTUATOR_GAIN),
    phenomena: &[&phenomena::AGEING],
    parameters: &[
        Quantity::new("per_decade", "1", "Relative loss of the gain per decade of time").fitted(),
        Quantity::new("age", "s", "Time since poling at the start of the run")
            .start(86_400.0)
            .min(0.0),
    ],
    ..Declaration::PATH
};

impl Component for ActuatorAgeing {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 2, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[per_decade, age], [loss, per_step]) = (parameters, coefficients) else {
            return Err(WRONG_LENGTH);
        };
        let rule = "must be above zero: the loss per decade counts from it; give the time since \
                    poling";
        require(age > 0.0, "age", age, rule)?;
        (*loss, *per_step) = (per_decade * LOG10_E, period / age);
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[x], [y]) = (inputs, outputs) else { return };
        *y = x;
    }

    fn step(
        &self,
        coefficients: &[f64],
        _state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[loss, per_step], &[x], [y]) = (coefficients, inputs, outputs) else { return };
        *y = x * fmax(1.0 - loss * log1p(per_step * tick.index as f64), 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn a_decade_takes_the_loss_per_decade() {
        let mut ageing = Instance::new(&ActuatorAgeing, &[], &[0.03, 10.0], 0.1).unwrap();
        assert_eq!(ageing.rest(&[5.0]), 5.0);
        let gains: std::vec::Vec<f64> = (0..9900).map(|_| ageing.step(&[1.0])).collect();
        // t = 90 s and 990 s: one and two decades after 10 s.
        assert!((gains[899] - 0.97).abs() < 1e-12 && (gains[9899] - 0.94).abs() < 1e-12);
        assert!(gains.windows(2).all(|pair| pair[1] < pair[0]));
    }

    #[test]
    fn no_more_than_all_of_the_gain_is_lost() {
        let mut ageing = Instance::new(&ActuatorAgeing, &[], &[0.9, 1e-9], 1.0).unwrap();
        assert_eq!(ageing.step(&[5.0]), 0.0);
        assert!(Instance::new(&ActuatorAgeing, &[], &[0.9, 0.0], 1.0).is_err());
    }
}
