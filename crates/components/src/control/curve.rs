//! A monotone curve through points, without memory: what undoes a static nonlinearity of amplifier or sensor.
//!
//! ```text
//! y = v_i + (v_{i+1} − v_i)/(a_{i+1} − a_i)·(u − a_i),  a_i ≤ u < a_{i+1}
//! ```
//!
//! * Straight between the points, and beyond them as between the first two and the last two.
//! * at a and value v in position (`reference-curve`, in front of the inverse of the hysteresis) or in command
//!   (`command-curve`, behind it); a increasing. Two points are a gain and an offset.
//! * No state. A step looks for its interval by bisection.
//!
//! Limits: static.
//!
//! Source: inverse of a static nonlinearity by interpolation, e.g. G. Tao, P. V. Kokotović, Adaptive Control of
//! Systems with Actuator and Sensor Nonlinearities, Wiley 1996, ch. 2.

use model::{Component, Declaration, Quantity, Sizes, Stage, Structural, Violation};

use crate::rules::{WRONG_LENGTH, require_at};

/// A curve, in position or in command.
pub struct Curve {
    declaration: &'static Declaration,
}

/// The component `reference-curve`.
pub static REFERENCE_CURVE: Curve = Curve { declaration: &REFERENCE };

/// The component `command-curve`.
pub static COMMAND_CURVE: Curve = Curve { declaration: &COMMAND };

static REFERENCE: Declaration = Declaration {
    kind: "reference-curve",
    name: "sensor_curve",
    summary: "Curve through points before the feedforward, for a static nonlinearity of the sensor",
    equation: "y = value[i] + (value[i+1] - value[i])/(at[i+1] - at[i])*(u - at[i]); at[i] <= u < at[i+1], the \
               first and the last interval without end",
    reference: "G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor \
                Nonlinearities, Wiley 1996, ch. 2",
    stage: Stage::Control,
    structure: &[Structural::count("points", "Number of points", 2, 4096)],
    parameters: &[
        Quantity::new("at", "{position}", "Inputs of the points, increasing").per(0),
        Quantity::new("value", "{position}", "Output at each point").per(0),
    ],
    ..Declaration::PATH
};

static COMMAND: Declaration = Declaration {
    kind: "command-curve",
    name: "amplifier_curve",
    summary: "Curve through points behind the feedforward, for a static nonlinearity of the amplifier",
    parameters: &[
        Quantity::new("at", "{command}", "Inputs of the points, increasing").per(0),
        Quantity::new("value", "{command}", "Output at each point").per(0),
    ],
    ..REFERENCE
};

impl Component for Curve {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn sizes(&self, structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: self.declaration.parameter_count(structure), states: 0 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        _period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        if coefficients.len() != parameters.len() || parameters.len() < 4 {
            return Err(WRONG_LENGTH);
        }
        let (x, _) = parameters.split_at(parameters.len() / 2);
        for (index, pair) in x.windows(2).enumerate() {
            let rule = "must be above the value before it; give increasing points";
            require_at(pair[1] > pair[0], "at", index + 1, pair[1], rule)?;
        }
        coefficients.copy_from_slice(parameters);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], _state: &mut [f64], outputs: &mut [f64]) {
        let (&[u], [y]) = (inputs, outputs) else { return };
        *y = value(coefficients, u).unwrap_or(u);
    }
}

/// The curve at `u`.
fn value(points: &[f64], u: f64) -> Option<f64> {
    let (x, y) = points.split_at(points.len() / 2);
    let inner = x.get(1..x.len().checked_sub(1)?)?;
    let at = inner.partition_point(|x| *x <= u);
    let (&[x0, x1], &[y0, y1]) = (x.get(at..at + 2)?, y.get(at..at + 2)?) else { return None };
    Some(y0 + (y1 - y0) / (x1 - x0) * (u - x0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn it_goes_straight_through_its_points_and_on_beyond_them() {
        let p = [0.0, 1.0, 3.0, 5.0, 6.0, 10.0];
        let mut curve = Instance::new(&REFERENCE_CURVE, &[3.0], &p, 1e-3).unwrap();
        for (u, y) in [(0.0, 5.0), (1.0, 6.0), (3.0, 10.0), (2.0, 8.0), (-2.0, 3.0), (4.0, 12.0)] {
            assert_eq!((curve.rest(&[u]), curve.step(&[u])), (y, y));
        }
        let p = [1.0, 3.0, -4.0, 0.0];
        let mut gain = Instance::new(&COMMAND_CURVE, &[2.0], &p, 1e-3).unwrap();
        assert_eq!(gain.rest(&[5.0]), 4.0);
    }

    #[test]
    fn points_that_do_not_increase_are_refused() {
        let p = [0.0, 1.0, 1.0, 5.0, 6.0, 10.0];
        let error = Instance::new(&REFERENCE_CURVE, &[3.0], &p, 1e-3).err().unwrap();
        assert_eq!((error.quantity, error.index), ("at", Some(2)));
    }
}
