//! A small registry that uses everything a declaration can say.
#![allow(dead_code)] // each test file uses a part of it

use model::{
    Component, Conversion, Declaration, Effect, Group, Input, Quantity, Registry, Sizes, Stage,
    Structural, Tick, Violation,
};

pub(crate) static REGISTRY: Registry = &[&Plays, &Gain, &Lag, &Delay, &Law];

/// The text of a plant that has no problem.
pub(crate) const PLANT: &str = r#"piezoloop = 1
kind = "plant"
name = "stage"
description = "A stage"
source = "Bench, 2024"
step = "20 us"

[[axis]]
name = "Y"
command = { name = "u", unit = "V", min = 0, max = 120, start = "5000 mV" }
position = { name = "y", unit = "um" }

[[axis.component]]
type = "lag"
bandwidth = "2.1 kHz"

[[axis.component]]
type = "plays"
name = "hysteresis"
r = [0, "6000 mV", 12]
w = [0.01354, 0.0279, "0 nm/V"]
tolerance = { w = 0.05 }
note = "Table 2"

[[axis.component]]
type = "lag"
name = "sensor"
enabled = false
bandwidth = 5000
"#;

static EFFECT: Effect = Effect {
    name: "lag",
    stage: Stage::Amplifier,
    group: Some(Group::Lag),
    signature: "",
    confused_with: &[],
    experiment: "",
};

static PLAYS: Declaration = Declaration {
    kind: "plays",
    name: "plays",
    conversion: Conversion::CommandToPosition,
    structure: &[Structural::count("plays", "Number of plays", 1, 50)],
    parameters: &[
        Quantity::new("r", "{command}", "Thresholds").per(0).min(0.0),
        Quantity::new("w", "{position}/{command}", "Weights").per(0),
        Quantity::new("offset", "{position}", "Offset").start(0.0),
    ],
    ..Declaration::PATH
};
static GAIN: Declaration = Declaration {
    kind: "gain",
    name: "gain",
    conversion: Conversion::CommandToPosition,
    parameters: &[Quantity::new("gain", "{position}/{command}", "Gain").tunable()],
    ..Declaration::PATH
};
static LAG: Declaration = Declaration {
    kind: "lag",
    name: "lag",
    effect: Some(&EFFECT),
    parameters: &[Quantity::new("bandwidth", "Hz", "Bandwidth").min(1.0).max(1e6)],
    ..Declaration::PATH
};
static DELAY: Declaration = Declaration {
    kind: "delay",
    name: "delay",
    structure: &[Structural::real("longest", "s", "Longest delay", 1e-3, 0.0, 1e6)],
    parameters: &[Quantity::new("delay", "s", "Delay").start(0.0).min(0.0)],
    ..Declaration::PATH
};
static LAW: Declaration = Declaration {
    kind: "law",
    name: "law",
    stage: Stage::Control,
    conversion: Conversion::Control,
    inputs: &[Input::PATH, Input::axis("reference"), Input::axis("measured")],
    parameters: &[
        Quantity::new("kp", "{command}/{position}", "Proportional gain").tunable(),
        Quantity::new("output_min", "{command}", "Least output").start(f64::MIN),
        Quantity::new("output_max", "{command}", "Greatest output").start(f64::MAX),
        Quantity::new("park", "{command}", "Command at the end").start(0.0).a_command(),
    ],
    ..Declaration::PATH
};

/// Thresholds must grow; the output is the sum of the weights times the input.
struct Plays;
struct Gain;
struct Lag;
struct Delay;
struct Law;

macro_rules! component {
    ($name:ident, $declaration:ident, $states:expr, $prepare:expr) => {
        impl Component for $name {
            fn declaration(&self) -> &'static Declaration {
                &$declaration
            }
            fn sizes(&self, structure: &[f64], period: f64) -> Sizes {
                let states: fn(&[f64], f64) -> usize = $states;
                Sizes { coefficients: 1, states: states(structure, period) }
            }
            fn prepare(
                &self,
                structure: &[f64],
                parameters: &[f64],
                _: f64,
                coefficients: &mut [f64],
            ) -> Result<(), Violation> {
                let prepare: fn(&[f64], &[f64]) -> Result<f64, Violation> = $prepare;
                coefficients[0] = prepare(structure, parameters)?;
                Ok(())
            }
            fn rest(&self, c: &[f64], inputs: &[f64], _: &mut [f64], outputs: &mut [f64]) {
                outputs[0] = c[0] * inputs[0];
            }
            fn step(&self, c: &[f64], _: &mut [f64], _: Tick, inputs: &[f64], outputs: &mut [f64]) {
                outputs[0] = c[0] * inputs[0];
            }
        }
    };
}

component!(Plays, PLAYS, |_, _| 0, |structure, p| {
    let count = structure[0] as usize;
    for index in 1..count {
        if p[index] <= p[index - 1] {
            return Err(Violation {
                quantity: "r",
                index: Some(index),
                value: p[index],
                rule: "thresholds must grow; sort them",
            });
        }
    }
    Ok(p[count..2 * count].iter().sum())
});
component!(Gain, GAIN, |_, _| 0, |_, p| Ok(p[0]));
component!(Lag, LAG, |_, _| 0, |_, _| Ok(1.0));
component!(Delay, DELAY, |structure, period| (structure[0] / period) as usize, |_, _| Ok(1.0));
component!(Law, LAW, |_, _| 0, |_, p| {
    if p[1] > p[2] {
        return Err(Violation {
            quantity: "output_min",
            index: None,
            value: p[1],
            rule: "must not exceed output_max; exchange them",
        });
    }
    Ok(1.0)
});
