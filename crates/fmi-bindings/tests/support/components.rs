//! Small components whose behaviour the tests know in closed form.

use model::{
    AxisSpec, Component, Connections, Conversion, Declaration, Effect, Input, Kind, NodeSpec,
    Output, Quantity, Sizes, Stage, System, SystemSpec, Tick, Violation,
};

/// An actuator with a lag: `x += (gain·u − x)·period/time`; `fault` breaks it on purpose.
pub struct Lag;

static LAG: Declaration = Declaration {
    kind: "lag",
    name: "lag",
    summary: "Actuator with a lag",
    equation: "x += (gain*u - x)*period/time",
    stage: Stage::Actuator,
    conversion: Conversion::CommandToPosition,
    outputs: &[Output::PATH, Output::published("moving", "1", "Whether it moves", true)],
    parameters: &[
        Quantity::new("gain", "{position}/{command}", "Gain").start(2.0).tunable(),
        Quantity::new("ceiling", "{position}/{command}", "Greatest gain").start(100.0),
        Quantity::new("time", "s", "Time constant").start(0.01).min(1e-3).max(10.0),
        Quantity::new("fault", "1", "1: NaN, 2: panic").start(0.0).min(0.0).max(2.0).tunable(),
    ],
    ..Declaration::PATH
};

impl Component for Lag {
    fn declaration(&self) -> &'static Declaration {
        &LAG
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 3, states: 1 }
    }

    fn prepare(
        &self,
        _structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation> {
        let &[gain, ceiling, time, fault] = parameters else { unreachable!() };
        if gain > ceiling {
            let rule = "must not exceed the ceiling; lower it or raise the ceiling";
            return Err(Violation { quantity: "gain", index: None, value: gain, rule });
        }
        coefficients.copy_from_slice(&[gain, period / time, fault]);
        Ok(())
    }

    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]) {
        state[0] = coefficients[0] * inputs[0];
        outputs[0] = state[0];
        outputs[1] = 0.0;
    }

    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        _tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        assert!(coefficients[2] != 2.0, "a fault on 100% purpose");
        let change = (coefficients[0] * inputs[0] - state[0]) * coefficients[1];
        state[0] += change;
        outputs[0] = if coefficients[2] == 1.0 { f64::NAN } else { state[0] };
        outputs[1] = f64::from(u8::from(change != 0.0));
    }
}

/// An effect that can be switched off: doubles the path.
pub struct Double;

static DOUBLE_EFFECT: Effect = Effect {
    name: "double",
    stage: Stage::Sensor,
    group: None,
    signature: "",
    confused_with: &[],
    experiment: "",
};

static DOUBLE: Declaration = Declaration {
    kind: "double",
    name: "double",
    summary: "Doubles the path",
    equation: "y = 2*u",
    stage: Stage::Sensor,
    effect: Some(&DOUBLE_EFFECT),
    ..Declaration::PATH
};

impl Component for Double {
    fn declaration(&self) -> &'static Declaration {
        &DOUBLE
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes::default()
    }

    fn prepare(&self, _: &[f64], _: &[f64], _: f64, _: &mut [f64]) -> Result<(), Violation> {
        Ok(())
    }

    fn rest(&self, _: &[f64], inputs: &[f64], _: &mut [f64], outputs: &mut [f64]) {
        outputs[0] = 2.0 * inputs[0];
    }

    fn step(&self, _: &[f64], _: &mut [f64], _: Tick, inputs: &[f64], outputs: &mut [f64]) {
        outputs[0] = 2.0 * inputs[0];
    }
}

/// A proportional control law with a switch.
pub struct Proportional;

static PROPORTIONAL: Declaration = Declaration {
    kind: "proportional",
    name: "control",
    summary: "Proportional control",
    equation: "u = enable ? gain*(r - y) : 0",
    stage: Stage::Control,
    conversion: Conversion::Control,
    inputs: &[
        Input::PATH,
        Input::axis("reference"),
        Input::axis("measured"),
        Input::system("enable"),
    ],
    parameters: &[Quantity::new("gain", "{command}/{position}", "Gain").start(3.0).tunable()],
    ..Declaration::PATH
};

impl Component for Proportional {
    fn declaration(&self) -> &'static Declaration {
        &PROPORTIONAL
    }

    fn sizes(&self, _structure: &[f64], _period: f64) -> Sizes {
        Sizes { coefficients: 1, states: 0 }
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

    fn rest(&self, _: &[f64], _: &[f64], _: &mut [f64], outputs: &mut [f64]) {
        outputs[0] = 0.0;
    }

    fn step(
        &self,
        coefficients: &[f64],
        _: &mut [f64],
        _: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        outputs[0] = inputs[3] * coefficients[0] * (inputs[1] - inputs[2]);
    }
}

/// Internal step of the test models, in s.
pub const PERIOD: f64 = 1e-3;

pub(super) fn axis(name: &str, components: Vec<NodeSpec>) -> AxisSpec {
    AxisSpec {
        name: name.into(),
        command_unit: "V".into(),
        position_unit: "um".into(),
        command_range: (-10.0, 100.0),
        position_range: (f64::NEG_INFINITY, f64::INFINITY),
        start: 0.0,
        aliases: vec![],
        components,
    }
}

pub(super) fn node(component: &'static dyn Component, values: &[f64], enabled: bool) -> NodeSpec {
    let name = component.declaration().name.into();
    NodeSpec {
        component: component.into(),
        name,
        structure: vec![],
        values: values.to_vec(),
        enabled,
    }
}

fn plant_with(gain: f64) -> System {
    let chain = |gain| {
        let lag = node(&Lag, &[gain, 100.0, 0.01, 0.0], true);
        vec![lag, node(&Double, &[], false)]
    };
    let axes = vec![axis("Y", chain(gain)), axis("Z", chain(5.0))];
    let (name, connections) = ("stage".into(), Connections::default());
    let spec = SystemSpec { name, kind: Kind::Plant, period: PERIOD, axes, connections };
    System::new(&spec).unwrap()
}

/// A plant of two axes with a lag each, gains 2 and 5 um/V, and a doubling that is switched off.
pub fn plant() -> System {
    plant_with(2.0)
}

/// Another plant of the same shape: its fingerprint differs, its sizes do not.
pub fn other_plant() -> System {
    plant_with(2.5)
}

/// A controller of one axis with the input `enable`.
pub fn controller() -> System {
    let axes = vec![axis("Y", vec![node(&Proportional, &[3.0], true)])];
    let (name, connections) = ("p".into(), Connections::default());
    let spec = SystemSpec { name, kind: Kind::Controller, period: PERIOD, axes, connections };
    System::new(&spec).unwrap()
}
