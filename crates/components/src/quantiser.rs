//! The converters' resolution: one component with two declarations.

use model::{Component, Declaration, Sizes, Violation};

use crate::linear::quantise;
use crate::rules::{WRONG_LENGTH, require};

/// `y = resolution·(round(x/resolution − phase) + phase)`, halves away from zero; no state.
pub struct Quantiser {
    pub(crate) declaration: &'static Declaration,
}

impl Component for Quantiser {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
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
        let &[resolution, _] = parameters else { return Err(WRONG_LENGTH) };
        let rule = "must be above zero; set enabled = false for no steps";
        require(resolution > 0.0, "resolution", resolution, rule)?;
        if coefficients.len() != parameters.len() {
            return Err(WRONG_LENGTH);
        }
        coefficients.copy_from_slice(parameters);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[resolution, phase], &[x], [y]) = (coefficients, inputs, outputs) else { return };
        *y = quantise(x, resolution, phase);
    }
}

#[cfg(test)]
mod tests {
    use crate::sensor::SENSOR_QUANTISATION;
    use crate::testing::{Instance, Random};

    #[test]
    fn rounds_to_the_nearest_step() {
        let mut converter = Instance::new(&SENSOR_QUANTISATION, &[], &[0.25, 0.0], 1e-3).unwrap();
        for (x, y) in [(0.0, 0.0), (0.12, 0.0), (0.13, 0.25), (-0.13, -0.25), (7.3, 7.25)] {
            assert_eq!(converter.step(&[x]), y);
        }
    }

    #[test]
    fn codes_lie_where_the_phase_puts_them() {
        let mut converter = Instance::new(&SENSOR_QUANTISATION, &[], &[0.25, 0.5], 1e-3).unwrap();
        for (x, y) in [(0.0, -0.125), (0.01, 0.125), (0.26, 0.375), (-0.2, -0.125), (7.3, 7.375)] {
            assert_eq!(converter.step(&[x]), y, "{x}");
        }
    }

    #[test]
    fn the_error_has_the_variance_of_a_uniform_distribution() {
        let mut converter = Instance::new(&SENSOR_QUANTISATION, &[], &[0.25, 0.0], 1e-3).unwrap();
        let signal = Random::new(3).signal(-9.0, 9.0, 20_000);
        let sum: f64 = signal.iter().map(|x| (converter.step(&[*x]) - x).powi(2)).sum();
        let ratio = sum / 20_000.0 / (0.25 * 0.25 / 12.0);
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    }

    #[test]
    fn values_beyond_all_steps_pass() {
        let mut converter = Instance::new(&SENSOR_QUANTISATION, &[], &[1e-300, 0.0], 1e-3).unwrap();
        assert_eq!(converter.step(&[1e9]), 1e9);
    }
}
