//! Hysteresis whose derivatives the tests know in closed form.

use model::{
    Component, Connections, Conversion, Declaration, Kind, Quantity, Sizes, Stage, System,
    SystemSpec, Tick, Violation,
};

use super::components::{PERIOD, axis, node};

/// Two play operators and a staircase: `y = u + w*(P_1[u] + P_2[u]) + step*floor(u/step)`.
pub struct Plays;

static PLAYS: Declaration = Declaration {
    kind: "plays",
    name: "plays",
    summary: "Hysteresis with a staircase",
    equation: "y = u + w*(P_1[u] + P_2[u]) + step*floor(u/step)",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    parameters: &[
        Quantity::new("w", "{position}/{command}", "Weight").min(0.0),
        Quantity::new("step", "{command}", "Step of the staircase, 0 for none").min(0.0),
    ],
    ..Declaration::PATH
};

impl Component for Plays {
    fn declaration(&self) -> &'static Declaration {
        &PLAYS
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 2, states: 2 }
    }

    fn prepare(
        &self,
        _: &[f64],
        parameters: &[f64],
        _: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        coefficients.copy_from_slice(parameters);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        state.fill(0.0);
        plays(coefficients, inputs[0], state, outputs);
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        plays(coefficients, inputs[0], state, outputs);
    }
}

fn plays(coefficients: &[f64], u: f64, state: &mut [f64], outputs: &mut [f64]) {
    for (r, play) in [1.0, 2.0].into_iter().zip(state.iter_mut()) {
        *play = play.clamp(u - r, u + r);
    }
    let step = coefficients[1];
    let stairs = if step > 0.0 { step * (u / step).floor() } else { 0.0 };
    // Units: gain 1 um/V.
    outputs[0] = 1e-6 * (u + stairs) + coefficients[0] * (state[0] + state[1]);
}

/// A plant of one axis with play operators of the weight 0.25 um/V and a staircase of this step.
pub fn plays_plant(step: f64) -> System {
    let axes = vec![axis("Y", vec![node(&Plays, &[0.25, step], true)])];
    let (name, connections) = ("plays".into(), Connections::default());
    let spec = SystemSpec { name, kind: Kind::Plant, period: PERIOD, axes, connections };
    System::new(&spec).unwrap()
}
