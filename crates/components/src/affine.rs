//! Gain and offset: one component with several declarations.

use model::{Component, Conversion, Declaration, Extension, Inverse, Sizes, Violation};

use crate::rules::WRONG_LENGTH;

/// `y = gain·u + offset`; no state.
pub struct Affine {
    pub(crate) declaration: &'static Declaration,
}

impl Component for Affine {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn extended(&self, by: Extension) -> Option<&'static dyn Component> {
        match self.declaration.conversion {
            Conversion::CommandToPosition => crate::hysteresis::extended(by),
            _ => None,
        }
    }

    fn inverses(&self) -> &'static [Inverse] {
        match self.declaration.conversion {
            Conversion::CommandToPosition => const { &[Inverse::closed_form("feedforward-gain")] },
            _ => &[],
        }
    }

    fn is_affine(&self) -> bool {
        true
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 2, states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        if parameters.len() != coefficients.len() {
            return Err(WRONG_LENGTH);
        }
        coefficients.copy_from_slice(parameters);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[gain, offset], &[u], [y]) = (coefficients, inputs, outputs) else { return };
        *y = gain * u + offset;
    }
}
