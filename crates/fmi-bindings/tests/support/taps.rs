//! A component with an array parameter.

use model::{
    Component, Connections, Conversion, Declaration, Kind, NodeSpec, Quantity, Sizes, Stage,
    Structural, System, SystemSpec, Tick, Violation,
};

use super::components::{PERIOD, axis, node};

/// A gain that is a sum: `y = (w_1 + w_2 + …)*u`.
pub struct Taps;

static TAPS: Declaration = Declaration {
    kind: "taps",
    name: "taps",
    summary: "Sum of gains",
    equation: "y = sum(w)*u",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    structure: &[Structural::count("taps", "Number of gains", 1, 9)],
    parameters: &[Quantity::new("w", "{position}/{command}", "Gains").per(0)],
    ..Declaration::PATH
};

impl Component for Taps {
    fn declaration(&self) -> &'static Declaration {
        &TAPS
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 1, states: 0 }
    }

    fn prepare(&self, _: &[f64], w: &[f64], _: f64, sum: &mut [f64]) -> Result<(), Violation> {
        sum[0] = w.iter().sum();
        Ok(())
    }

    fn rest(&self, sum: &[f64], inputs: &[f64], _: &mut [f64], outputs: &mut [f64]) {
        outputs[0] = sum[0] * inputs[0];
    }

    fn step(&self, sum: &[f64], _: &mut [f64], _: Tick, inputs: &[f64], outputs: &mut [f64]) {
        outputs[0] = sum[0] * inputs[0];
    }
}

/// A plant of two axes with the gains 1, 2, 3 and 4, 5, 6 um/V.
pub fn taps_plant() -> System {
    let taps = |w: &[f64]| NodeSpec { structure: vec![3.0], ..node(&Taps, w, true) };
    let axes =
        vec![axis("Y", vec![taps(&[1.0, 2.0, 3.0])]), axis("Z", vec![taps(&[4.0, 5.0, 6.0])])];
    let (name, connections) = ("taps".into(), Connections::default());
    let spec = SystemSpec { name, kind: Kind::Plant, period: PERIOD, axes, connections };
    System::new(&spec).unwrap()
}
