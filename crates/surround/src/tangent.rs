//! Derivatives of the effects in a direction, for the chain rule around those of the original.

use crate::port_variable::PortVariable;
use crate::repair::Repair;
use crate::surround::{Own, Surround};

/// Directions of variables: value reference, and a number for each element.
pub type Directions = Vec<(u32, Vec<f64>)>;

/// A variable jumps, so that it has no derivative; its value reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Jump(pub u32);

/// Steps of the difference quotients, relative to the size of the knowns.
const STEPS: [f64; 4] = [
    1.0 / (1_u64 << 14) as f64,
    1.0 / (1_u64 << 20) as f64,
    1.0 / (1_u64 << 26) as f64,
    1.0 / (1_u64 << 32) as f64,
];
/// Neighbouring quotients that differ by less, relatively, belong to one smooth piece.
const SMOOTH: f64 = 1e-6;
/// Neighbouring quotients that differ by more at every step belong to no derivative.
const BROKEN: f64 = 1e-2;
/// Rounding error of a value, relative to it, that a quotient may contain.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Surround {
    /// In how many parts the last communication step was done; 0 before the first.
    #[must_use]
    pub fn last_parts(&self) -> u32 {
        self.last.parts
    }

    /// Notes in how many parts a communication step is done.
    pub fn note_parts(&mut self, parts: u32) {
        self.last.parts = parts;
    }

    /// In which directions what the original gets moves, inputs and changed parameters, where the
    /// host's inputs, changed parameters and the repair's own parameters move in those of `knowns`.
    /// It is about how the present outputs came about: the last step, or rest.
    ///
    /// # Errors
    /// [`Jump`].
    pub fn inner_directions(&self, knowns: &Directions) -> Result<Directions, Jump> {
        let inputs: Vec<&PortVariable> = self.inputs.iter().filter(|v| !v.own).collect();
        let read = |it: &Self| -> Vec<f64> {
            it.inputs.iter().filter(|v| !v.own).flat_map(|v| v.inner.iter().copied()).collect()
        };
        let slopes =
            self.slopes(knowns, &Directions::new(), read).map_err(|at| named(&inputs, at))?;
        let mut all = split(&inputs, &slopes);
        for variable in &self.changed {
            let direction = self.changed_direction(variable, knowns);
            all.push((variable.reference, direction));
        }
        Ok(all)
    }

    /// In which directions the outputs with effects move, if the original's move in those of `inner`.
    ///
    /// # Errors
    /// [`Jump`].
    pub fn output_directions(
        &self,
        knowns: &Directions,
        inner: &Directions,
    ) -> Result<Directions, Jump> {
        let outputs: Vec<&PortVariable> = self.outputs.iter().collect();
        let read = |it: &Self| -> Vec<f64> {
            it.outputs.iter().flat_map(|v| v.shown.iter().copied()).collect()
        };
        let slopes = self.slopes(knowns, inner, read).map_err(|at| named(&outputs, at))?;
        Ok(split(&outputs, &slopes))
    }

    /// A changed parameter moves with the host's value and with what effects add to it.
    fn changed_direction(&self, variable: &PortVariable, knowns: &Directions) -> Vec<f64> {
        let mut direction = vec![0.0; variable.inner.len()];
        for (reference, seed) in knowns {
            if *reference == variable.reference {
                direction.iter_mut().zip(seed).for_each(|(d, s)| *d += s);
            }
            if let Some(Own::Parameter(effect, parameter)) = self.find(*reference) {
                let Repair { changes, .. } = &self.repair;
                let here = changes.iter().filter(|c| {
                    c.variable.reference == variable.reference
                        && (c.effect, c.parameter) == (effect, parameter)
                        && self.enabled[effect]
                });
                here.for_each(|c| direction[c.element] += seed[0]);
            }
        }
        direction
    }

    /// How the values that `read` finds change along the directions; the place of one that jumps.
    fn slopes(
        &self,
        knowns: &Directions,
        inner: &Directions,
        read: impl Fn(&Self) -> Vec<f64>,
    ) -> Result<Vec<f64>, usize> {
        let at = |s: f64| read(&self.moved(s, knowns, inner));
        let (begin, unit) = (at(0.0), self.unit(knowns));
        let rows: Vec<(f64, Vec<f64>)> = STEPS
            .iter()
            .map(|step| {
                let s = step * unit;
                let (one, two) = (at(s), at(2.0 * s));
                let values = begin.iter().zip(&one).zip(&two);
                (s, values.map(|((a, b), c)| (4.0 * (b - a) - (c - a)) / (2.0 * s)).collect())
            })
            .collect();
        let slope = |at: usize| {
            let mut best = (f64::INFINITY, 0.0);
            for pair in rows.windows(2) {
                let (q, next, s) = (pair[0].1[at], pair[1].1[at], pair[1].0);
                let rounding = ROUNDING * begin[at].abs() / s;
                let difference = ((q - next).abs() - rounding).max(0.0);
                let size = q.abs().max(next.abs());
                let doubt = if difference == 0.0 { 0.0 } else { difference / size };
                if doubt < best.0 {
                    best = (doubt, q);
                }
                if doubt <= SMOOTH {
                    break;
                }
            }
            if best.0 <= BROKEN { Ok(best.1) } else { Err(at) }
        };
        (0..begin.len()).map(slope).collect()
    }

    /// The largest step along the directions that moves no known by more than its size.
    fn unit(&self, knowns: &Directions) -> f64 {
        let mut unit = f64::INFINITY;
        for (reference, seed) in knowns {
            let values: Vec<f64> = match (self.get(*reference), self.shown(*reference)) {
                (Some(value), _) => vec![value],
                (None, Some(values)) => values.to_vec(),
                (None, None) => continue,
            };
            for (value, seed) in values.iter().zip(seed).filter(|(_, seed)| **seed != 0.0) {
                let size = if *value == 0.0 { 1.0 } else { value.abs() };
                unit = unit.min(size / seed.abs());
            }
        }
        if unit.is_finite() { unit } else { 1.0 }
    }

    /// What the last step, or rest, would have made of other knowns and other outputs of the original.
    fn moved(&self, s: f64, knowns: &Directions, inner: &Directions) -> Self {
        let mut it = self.clone();
        let add = |values: &mut [f64], seed: &[f64]| {
            values.iter_mut().zip(seed).for_each(|(value, seed)| *value += s * seed);
        };
        for (variable, held) in it.inputs.iter_mut().zip(&self.last.inputs) {
            variable.shown.clone_from(held);
        }
        for (reference, seed) in knowns {
            if let Some(Own::Parameter(effect, parameter)) = self.find(*reference) {
                add(&mut it.values[effect][parameter..][..1], seed);
            } else if let Some(v) = it.inputs.iter_mut().find(|v| v.reference == *reference) {
                add(&mut v.shown, seed);
            }
        }
        for (reference, seed) in inner {
            if let Some(v) = it.outputs.iter_mut().find(|v| v.reference == *reference) {
                add(&mut v.inner, seed);
            }
        }
        let dt = self.last.dt;
        if dt > 0.0 {
            it.states.clone_from(&self.last.states);
            it.time -= dt;
            it.step_inputs(dt);
            it.step_outputs(dt);
        } else {
            it.rest_inputs();
            it.rest_outputs();
        }
        it
    }
}

/// Numbers one after the other, by variable.
fn split(variables: &[&PortVariable], numbers: &[f64]) -> Directions {
    let mut numbers = numbers.iter().copied();
    let of = |v: &&PortVariable| (v.reference, numbers.by_ref().take(v.inner.len()).collect());
    variables.iter().map(of).collect()
}

/// The variable to which the number at a place belongs.
fn named(variables: &[&PortVariable], at: usize) -> Jump {
    let mut end = 0;
    let found = variables.iter().find(|v| {
        end += v.inner.len();
        at < end
    });
    Jump(found.map_or(0, |v| v.reference))
}
