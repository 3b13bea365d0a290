//! Reference preview: the reference input runs ahead of the position that is wanted.
//!
//! `r(t) on the path`, `reference behind it = r(t − preview)`
//!
//! * Feedforward that differentiates or smooths its reference, or that makes up for a delay of the
//!   machine, needs to know it ahead of time. With a preview, the controller's input `reference` is the
//!   position that is wanted `preview` seconds later: feedforward gets it at once, the feedback law
//!   compares the measured position with the one of `preview` seconds before.
//! * Whoever drives the controller feeds r(t + preview), or accepts that the machine follows
//!   `preview` seconds late: by as much as a feedforward's own delay this is exact.
//! * preview in s, also by fractions of a period (interpolated); `longest` is structural.
//! * At rest both are r.
//!
//! Source: M. Tomizuka, On the design of digital tracking controllers, ASME J. Dyn. Syst. Meas.
//! Control 115 (1993) 412–418.

use model::{Component, Declaration, Output, Quantity, Sizes, Stage, Structural, Tick, Violation};

use crate::rules::WRONG_LENGTH;
use crate::timing::delay::{Ring, ring_size, steps_of};

/// The component `reference-preview`.
pub struct ReferencePreview;

static DECLARATION: Declaration = Declaration {
    kind: "reference-preview",
    name: "preview",
    summary: "Preview of the reference: feedforward uses it at once, feedback later",
    equation: "path = r(t); reference = r(t - preview)",
    reference: "M. Tomizuka, ASME J. Dyn. Syst. Meas. Control 115 (1993) 412-418",
    stage: Stage::Control,
    outputs: &[Output::PATH, Output { name: "reference", published: None }],
    structure: &[Structural::real(
        "longest",
        "s",
        "Longest preview that can be set",
        0.01,
        0.0,
        10.0,
    )],
    parameters: &[Quantity::new("preview", "s", "Time by which the reference input is ahead")
        .min(0.0)
        .at_most(0)
        .tunable()],
    ..Declaration::PATH
};

impl Component for ReferencePreview {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn example(&self) -> model::Example {
        &[("longest", &[0.01]), ("preview", &[2.35e-4])]
    }

    fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
        Sizes { coefficients: 2, states: ring_size(structure, period) }
    }

    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let (&[longest], &[preview], [integer, fraction]) = (structure, parameters, coefficients)
        else {
            return Err(WRONG_LENGTH);
        };
        (*integer, *fraction) = steps_of("preview", preview, longest, period)?;
        Ok(())
    }

    fn rest(&self, _coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        let &[r] = inputs else { return };
        Ring(state).rest(r);
        outputs.fill(r);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let (&[integer, fraction], &[r], [path, reference]) = (coefficients, inputs, outputs)
        else {
            return;
        };
        (*path, *reference) = (r, Ring(state).push(r, integer, fraction));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Instance;

    #[test]
    fn the_path_passes_and_the_reference_comes_later() {
        let mut preview = Instance::new(&ReferencePreview, &[0.01], &[2.5e-3], 1e-3).unwrap();
        preview.rest(&[0.0]);
        for n in 1..30 {
            assert_eq!(preview.step(&[f64::from(n)]), f64::from(n));
            let wanted = (f64::from(n) - 2.5).max(0.0);
            let near = (preview.outputs[1] - wanted).abs() < 1e-12 || n == 3;
            assert!(near, "{n}: {}", preview.outputs[1]);
        }
    }
}
