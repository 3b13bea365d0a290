//! Operators of plays in the place of plain ones. The component itself steps, so that what a diagnosis finds, the
//! blueprint that it writes and the repaired FMU are the same numbers.

use std::fmt;

use components::hysteresis::OPERATORS;
use components::hysteresis::play::Plays;
use model::{Component, Missing, Role, Tick};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::kernel::{Kernel, Law, Signals, Wires, WrongCount, each};
use crate::span::Memory;
use crate::state::State;

/// A component that a diagnosis tries in the place of plain plays; in a file, its kind.
#[derive(Clone, Copy)]
pub struct Operator {
    component: &'static dyn Component,
    missing: &'static Missing,
}

impl Operator {
    /// All that declare how they are tried.
    pub fn all() -> impl Iterator<Item = Self> {
        OPERATORS.iter().filter_map(|component| Self::of(*component))
    }

    /// Of a component that declares how it is tried.
    #[must_use]
    pub fn of(component: &'static dyn Component) -> Option<Self> {
        component.missing().map(|missing| Self { component, missing })
    }

    /// The component.
    #[must_use]
    pub fn component(self) -> &'static dyn Component {
        self.component
    }

    /// How it is tried.
    #[must_use]
    pub fn missing(self) -> &'static Missing {
        self.missing
    }

    /// `x + C[v] − Σ w·P_r[v]` with these plays and values of its free parameters.
    pub(crate) fn kernel(self, memory: &Memory, p: &[f64], dt: f64) -> Result<Kernel, WrongCount> {
        let p = each(p, self.missing.free.len())?;
        let mut plays = memory.plays();
        plays.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        // Equal thresholds are one play.
        plays.dedup_by(|(r, w), (kept, sum)| {
            let is_same = r == kept;
            *sum += if is_same { *w } else { 0.0 };
            is_same
        });
        // A component takes weights of zero and above: plays with those below are a second one that is subtracted.
        let of_sign = |sign: f64| -> Vec<(f64, f64)> {
            let own = plays.iter().filter(|(_, w)| sign * w > 0.0);
            own.map(|(r, w)| (*r, sign * w)).collect()
        };
        let halves = [1.0, -1.0].map(|sign| (sign, of_sign(sign)));
        let halves = halves.iter().filter(|(_, plays)| !plays.is_empty());
        let halves = halves.map(|(sign, plays)| self.part(*sign, plays, p)).collect();
        let (r, w) = plays.into_iter().unzip();
        Ok(Kernel::new(Replacing { component: self.component, halves, r, w, dt }, dt))
    }

    fn part(self, sign: f64, plays: &[(f64, f64)], p: &[f64]) -> Part {
        let mut parameters = Vec::new();
        for quantity in self.component.declaration().parameters {
            let free = self.missing.free.iter().position(|free| free.quantity == quantity.name);
            match (quantity.role, free) {
                (Some(Role::Threshold), _) => parameters.extend(plays.iter().map(|(r, _)| r)),
                (Some(Role::Weight), _) => parameters.extend(plays.iter().map(|(_, w)| w)),
                (_, Some(at)) => parameters.push(p[at]),
                _ => parameters.push(quantity.start.unwrap_or(0.0)),
            }
        }
        let structure = [plays.len() as f64];
        Part { sign, structure, parameters, coefficients: Vec::new(), states: 0, is_taken: false }
    }
}

/// A component with plays of one sign.
#[derive(Clone)]
struct Part {
    sign: f64,
    structure: [f64; 1],
    /// In SI, in the order of the declaration.
    parameters: Vec<f64>,
    coefficients: Vec<f64>,
    states: usize,
    /// Whether the component takes the parameters.
    is_taken: bool,
}

/// `x + Σ sign·C[v] − Σ w·P_r[v]`; no number where the component does not take the parameters. State: those of the
/// components, and one number per plain play.
#[derive(Clone)]
struct Replacing {
    component: &'static dyn Component,
    halves: Vec<Part>,
    r: Vec<f64>,
    w: Vec<f64>,
    dt: f64,
}

impl Replacing {
    /// The output, from what each component gives.
    #[inline]
    fn at(
        &self,
        w: Wires,
        z: &mut [f64],
        mut each: impl FnMut(&Part, &[f64], &mut [f64], &mut [f64]),
    ) -> f64 {
        let (mut sum, mut rest) = (0.0, z);
        for part in &self.halves {
            let (own, behind) = rest.split_at_mut(part.states);
            rest = behind;
            let mut y = [f64::NAN];
            if part.is_taken {
                each(part, &[w.drive], own, &mut y);
            }
            sum += part.sign * y[0];
        }
        w.x + (sum - Plays { r: &self.r, w: &self.w }.step(w.drive, rest))
    }

    fn at_rest(&self, w: Wires, z: &mut [f64]) -> f64 {
        z.fill(0.0);
        self.at(w, z, |part, u, state, y| self.component.rest(&part.coefficients, u, state, y))
    }

    #[inline]
    fn after(&self, w: Wires, tick: Tick, z: &mut [f64]) -> f64 {
        self.at(w, z, |part, u, state, y| {
            self.component.step(&part.coefficients, state, tick, u, y);
        })
    }
}

impl Law for Replacing {
    fn set_step(&mut self, dt: f64) {
        self.dt = dt;
        for part in &mut self.halves {
            let sizes = self.component.sizes(&part.structure, dt);
            part.coefficients.resize(sizes.coefficients, 0.0);
            part.states = sizes.states;
            let (values, coefficients) = (&part.parameters, &mut part.coefficients);
            part.is_taken =
                self.component.prepare(&part.structure, values, dt, coefficients).is_ok();
        }
    }

    fn rest(&self, w: Wires, state: &mut State) -> f64 {
        state.z.resize(self.states(), 0.0);
        self.at_rest(w, &mut state.z)
    }

    fn step(&self, w: Wires, t: f64, state: &mut State) -> f64 {
        let tick = Tick { index: (t / self.dt).round() as u64, time: t, period: self.dt };
        self.after(w, tick, &mut state.z)
    }

    fn run(&self, signals: Signals<'_>, dt: f64, out: &mut [f64]) {
        let mut z = vec![0.0; self.states()];
        let mut time = 0.0;
        for (n, (y, w)) in out.iter_mut().zip(signals.wires()).enumerate() {
            if n == 0 {
                *y = self.at_rest(w, &mut z);
                continue;
            }
            time += dt;
            *y = self.after(w, Tick { index: n as u64, time, period: dt }, &mut z);
        }
    }

    fn states(&self) -> usize {
        self.r.len() + self.halves.iter().map(|part| part.states).sum::<usize>()
    }

    fn boxed(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}

impl PartialEq for Operator {
    fn eq(&self, other: &Self) -> bool {
        self.component.declaration().kind == other.component.declaration().kind
    }
}

impl fmt::Debug for Operator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.component.declaration().kind)
    }
}

impl Serialize for Operator {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.component.declaration().kind)
    }
}

impl<'de> Deserialize<'de> for Operator {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let kind = String::deserialize(deserializer)?;
        let mut all = Self::all();
        all.find(|operator| operator.component.declaration().kind == kind).ok_or_else(|| {
            D::Error::custom(format!("{kind} is no operator of plays that an effect can be"))
        })
    }
}

#[cfg(test)]
mod tests {
    use model::Shape;

    use super::*;

    /// What [`Operator::kernel`] takes for granted.
    #[test]
    fn an_operator_that_is_tried_has_plays_and_scalars_with_a_start() {
        for operator in Operator::all() {
            let declaration = operator.component.declaration();
            let kind = declaration.kind;
            assert!(declaration.effect.is_some(), "{kind} stands for no effect");
            assert_eq!(declaration.structure.len(), 1, "{kind}: more than the number of plays");
            let has = |role| declaration.parameters.iter().any(|q| q.role == Some(role));
            assert!(has(Role::Threshold) && has(Role::Weight), "{kind} has no plays");
            for free in operator.missing.free {
                let own = declaration.parameters.iter().find(|q| q.name == free.quantity);
                let is_scalar = own.is_some_and(|q| matches!(q.shape, Shape::Scalar));
                assert!(is_scalar, "{kind} has no scalar {}", free.quantity);
            }
            let is_free = |name| operator.missing.free.iter().any(|free| free.quantity == name);
            let others = declaration.parameters.iter().filter(|q| {
                !matches!(q.role, Some(Role::Threshold | Role::Weight)) && !is_free(q.name)
            });
            for quantity in others {
                let is_scalar = matches!(quantity.shape, Shape::Scalar);
                assert!(
                    is_scalar && quantity.start.is_some(),
                    "{kind}.{} has no start",
                    quantity.name
                );
            }
        }
    }

    #[test]
    fn values_that_a_component_refuses_give_no_number() {
        let memory = Memory { r: vec![0.2, 0.7], w: vec![0.3, 0.1] };
        let lag = Operator::all().find(|o| o.missing.name == "plays that lag").unwrap();
        let mut out = [0.0; 3];
        let signals = Signals::path(&[0.0, 1.0, 2.0]);
        lag.kernel(&memory, &[50.0], 1e-3).unwrap().run(signals, &mut out);
        assert!(out.iter().all(|y| y.is_finite()), "{out:?}");
        lag.kernel(&memory, &[-1.0], 1e-3).unwrap().run(signals, &mut out);
        assert!(out.iter().all(|y| y.is_nan()), "{out:?}");
    }
}
