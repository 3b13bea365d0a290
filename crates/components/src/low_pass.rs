//! A second-order low-pass: one component with several declarations.

use model::{Component, Declaration, Extension, Sizes, Tick, Violation};

use crate::linear::SecondOrder;
use crate::rules::{WRONG_LENGTH, second_order};

/// `x″ + 2ζω x′ + ω² x = ω²·gain·u`, exact while u is held over a step. Its state is x and x′/ω.
pub struct LowPass {
    pub(crate) declaration: &'static Declaration,
    /// What its parameters come to at a period in s.
    pub(crate) law: fn(&[f64], f64) -> Result<SecondOrder, Violation>,
    /// What it becomes with one thing more.
    pub(crate) extended: fn(Extension) -> Option<&'static dyn Component>,
}

/// Of the parameters frequency, damping and gain.
pub(crate) fn with_gain(parameters: &[f64], period: f64) -> Result<SecondOrder, Violation> {
    let &[frequency, damping, gain] = parameters else { return Err(WRONG_LENGTH) };
    second_order(frequency, damping, period)?;
    Ok(SecondOrder::new(frequency, damping, gain, period))
}

impl Component for LowPass {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn extended(&self, by: Extension) -> Option<&'static dyn Component> {
        (self.extended)(by)
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: SecondOrder::COEFFICIENTS, states: 2 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let Ok(values) = <&mut [f64; 4]>::try_from(coefficients) else { return Err(WRONG_LENGTH) };
        *values = (self.law)(parameters, period)?.to_array();
        Ok(())
    }

    #[cfg_attr(feature = "records", inline)]
    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let (&[a, b, c, d], &[u], Ok(state), [y]) =
            (coefficients, inputs, state.try_into(), outputs)
        else {
            return;
        };
        *y = SecondOrder::of([a, b, c, d]).rest(u, state);
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
        let (&[a, b, c, d], &[u], Ok(state), [y]) =
            (coefficients, inputs, state.try_into(), outputs)
        else {
            return;
        };
        *y = SecondOrder::of([a, b, c, d]).step(u, state);
    }
}
