//! The plays of an actuator that is written anew.

use components::hysteresis::play::{Drive, Threshold, play};
use data::{ComponentBlueprint, Value};
use model::{Declaration, Extension, Role};
use numerics::least_squares::Reduced;

use super::number;
use crate::thresholds::repair::Thresholds;

/// Plays of an actuator: threshold and weight, in the axis' units.
pub(super) struct Plays {
    pub(super) pairs: Vec<(f64, f64)>,
}

impl Plays {
    pub(super) fn of(component: &ComponentBlueprint) -> Option<Self> {
        let kind = components::find(&component.kind)?;
        // What has no extension holds more than plays.
        kind.extended(Extension::Plays)?;
        let of = |role: Role| {
            let quantity = kind.declaration().parameters.iter().find(|q| q.role == Some(role))?;
            match component.get(quantity.name)? {
                Value::List(all) => all.iter().map(number).collect::<Option<Vec<f64>>>(),
                one => Some(vec![number(one)?]),
            }
        };
        let mut pairs: Vec<(f64, f64)> =
            of(Role::Slope).unwrap_or_default().into_iter().map(|w| (0.0, w)).collect();
        if let (Some(r), Some(w)) = (of(Role::Threshold), of(Role::Weight)) {
            pairs.extend(r.into_iter().zip(w));
        }
        (!pairs.is_empty()).then_some(Self { pairs })
    }

    /// A component of this declaration with these plays; the part without memory is a quantity of its own where
    /// there is one.
    pub(super) fn written(self, declaration: &'static Declaration) -> Option<ComponentBlueprint> {
        let name =
            |role| declaration.parameters.iter().find(|q| q.role == Some(role)).map(|q| q.name);
        let mut component = ComponentBlueprint::new(declaration.kind);
        let mut pairs = self.pairs;
        if let Some(slope) = name(Role::Slope) {
            let straight = pairs.iter().filter(|(r, _)| *r == 0.0).map(|(_, w)| w).sum::<f64>();
            component = component.value(slope, straight);
            pairs.retain(|(r, _)| *r != 0.0);
        }
        let (r, w): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        Some(component.value(name(Role::Threshold)?, r).value(name(Role::Weight)?, w))
    }

    pub(super) fn add(&mut self, r: f64, w: f64) {
        match self.pairs.binary_search_by(|(own, _)| own.total_cmp(&r)) {
            Ok(at) => self.pairs[at].1 += w,
            Err(at) => self.pairs.insert(at, (r, w)),
        }
    }
}

impl Plays {
    /// Where the virgin curve falls, which no component takes: the plays whose curve does not, and that come nearest under
    /// this command, by least squares over `Σ s_k·(P_k − P_{k+1})` with slopes `s_k = w_1 + … + w_k ≥ 0`.
    pub(super) fn rising(&mut self, command: &[f64]) {
        let slopes: Vec<f64> = self
            .pairs
            .iter()
            .scan(0.0, |slope, (_, w)| {
                *slope += w;
                Some(*slope)
            })
            .collect();
        if slopes.iter().all(|slope| *slope >= 0.0) {
            return;
        }
        let mut states = vec![0.0_f64; self.pairs.len()];
        let mut rows = Reduced::new(states.len());
        let stride = command.len().div_ceil(Thresholds::PLAYS_ROWS).max(1);
        for (k, u) in command.iter().enumerate() {
            for (state, (r, _)) in states.iter_mut().zip(&self.pairs) {
                *state = play(Drive(*u), Threshold(*r), *state);
            }
            if k % stride == 0 {
                let y: f64 = states.iter().zip(&self.pairs).map(|(p, (_, w))| p * w).sum();
                let next = states[1..].iter().chain([&0.0]);
                rows.push(states.iter().zip(next).map(|(p, next)| p - next).chain([y]));
            }
        }
        // The written axis is compared with the fitted formulas and tuned again where it is off.
        let nearest = || slopes.iter().map(|slope| slope.max(0.0)).collect();
        let slopes: Vec<f64> = rows.solve(0).map_or_else(|_| nearest(), |solution| solution.x);
        let mut before = 0.0;
        for (pair, slope) in self.pairs.iter_mut().zip(slopes) {
            pair.1 = slope - before;
            before = slope;
        }
        self.pairs.retain(|(r, w)| *w != 0.0 || *r == 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Root mean square of what plays with these weights leave of those with the others.
    fn left(pairs: &[(f64, f64)], others: &[(f64, f64)], command: &[f64]) -> f64 {
        let position = |pairs: &[(f64, f64)]| {
            let mut states = vec![0.0_f64; pairs.len()];
            let step = |u: &f64| -> f64 {
                let each = states.iter_mut().zip(pairs);
                each.map(|(state, (r, w))| {
                    *state = play(Drive(*u), Threshold(*r), *state);
                    w * *state
                })
                .sum()
            };
            command.iter().map(step).collect::<Vec<f64>>()
        };
        let pairs = position(pairs).into_iter().zip(position(others));
        (pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / command.len() as f64).sqrt()
    }

    #[test]
    fn a_curve_that_falls_becomes_the_nearest_that_a_component_takes() {
        let command: Vec<f64> = (0..2000)
            .map(|k| 50.0 - (50.0 - 0.02 * f64::from(k)) * (0.05 * f64::from(k)).cos())
            .collect();
        let fitted = [(0.0, 0.05), (8.0, -0.06), (20.0, 0.07), (35.0, 0.01)];
        let mut plays = Plays { pairs: fitted.to_vec() };
        plays.rising(&command);
        let mut slope = 0.0;
        for (_, w) in &plays.pairs {
            slope += w;
            assert!(slope >= 0.0, "{:?}", plays.pairs);
        }
        // Nearer than without the negative one, and near.
        let cut: Vec<(f64, f64)> = fitted.iter().map(|(r, w)| (*r, w.max(0.0))).collect();
        let (ours, without) =
            (left(&plays.pairs, &fitted, &command), left(&cut, &fitted, &command));
        assert!(ours < 0.2 * without, "{ours} {without}");
        // Weights that a component takes stay as they are.
        let mut allowed = Plays { pairs: cut.clone() };
        allowed.rising(&command);
        assert_eq!(allowed.pairs, cut);
    }
}
