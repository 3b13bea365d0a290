//! One instance of a component outside a system, for tests of its equation.

use std::vec;
use std::vec::Vec;

use model::{Component, Tick, Violation};
use numerics::random::SplitMix64;

/// A component with its own slices and clock.
pub(crate) struct Instance {
    component: &'static dyn Component,
    pub(crate) coefficients: Vec<f64>,
    pub(crate) state: Vec<f64>,
    pub(crate) outputs: Vec<f64>,
    period: f64,
    structure: Vec<f64>,
    index: u64,
}

impl Instance {
    /// A prepared instance with these parameters in SI.
    pub(crate) fn new(
        component: &'static dyn Component,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
    ) -> Result<Self, Violation> {
        let declaration = component.declaration();
        assert_eq!(declaration.structure.len(), structure.len(), "{}", declaration.kind);
        assert_eq!(declaration.parameter_count(structure), parameters.len());
        let sizes = component.sizes(structure, period);
        let mut instance = Self {
            component,
            coefficients: vec![0.0; sizes.coefficients],
            state: vec![0.0; sizes.states],
            outputs: vec![0.0; declaration.outputs.len()],
            period,
            structure: structure.to_vec(),
            index: 0,
        };
        instance.set(parameters)?;
        Ok(instance)
    }

    /// Takes other parameters.
    pub(crate) fn set(&mut self, parameters: &[f64]) -> Result<(), Violation> {
        let (s, p, h) = (&self.structure, parameters, self.period);
        self.component.prepare(s, p, h, &mut self.coefficients)
    }

    /// At rest under these inputs; returns the path's output.
    pub(crate) fn rest(&mut self, inputs: &[f64]) -> f64 {
        self.index = 0;
        self.component.rest(&self.coefficients, inputs, &mut self.state, &mut self.outputs);
        self.outputs[0]
    }

    /// One period with these inputs held over it; returns the path's output.
    pub(crate) fn step(&mut self, inputs: &[f64]) -> f64 {
        self.index += 1;
        let time = self.index as f64 * self.period;
        let tick = Tick { index: self.index, time, period: self.period };
        let (state, outputs) = (&mut self.state, &mut self.outputs);
        self.component.step(&self.coefficients, state, tick, inputs, outputs);
        self.outputs[0]
    }

    /// The path's outputs for a signal on the only input port, at rest under `initial` before.
    pub(crate) fn response(&mut self, initial: f64, signal: &[f64]) -> Vec<f64> {
        self.rest(&[initial]);
        signal.iter().map(|u| self.step(&[*u])).collect()
    }
}

/// The closed polygon's area by the shoelace formula.
pub(crate) fn loop_area(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len();
    let twice: f64 = (0..n).map(|i| x[i] * y[(i + 1) % n] - x[(i + 1) % n] * y[i]).sum();
    0.5 * twice.abs()
}

/// A triangle from `low` to `high` and back, `points` per flank, `periods` times, starting low.
pub(crate) fn triangle(low: f64, high: f64, points: usize, periods: usize) -> Vec<f64> {
    let at = |k: usize| low + (high - low) * k as f64 / points as f64;
    let one = (0..points).map(at).chain((1..=points).rev().map(at));
    one.collect::<Vec<_>>().repeat(periods)
}

/// Random numbers for signals whose distribution does not matter.
pub(crate) struct Random(SplitMix64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    /// Uniform from `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    pub(crate) fn signal(&mut self, low: f64, high: f64, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.between(low, high)).collect()
    }
}
