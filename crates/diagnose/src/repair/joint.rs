//! Couplings of several axes with other values of their own, and with further modes.

use data::{Blueprint, Value};
use model::{CouplingSpec, Role};

use crate::chain;
use crate::outcome::Outcome;
use crate::thresholds::answer::Thresholds;

/// A change of one value of a coupling that one reading shows, in SI.
struct Change {
    coupling: usize,
    index: usize,
    by: f64,
    std: Option<f64>,
}

/// A further mode as one reading sees it.
struct Mode {
    coupling: usize,
    frequency: f64,
    damping: f64,
    /// The weight of each axis of the coupling in each of its readings.
    weights: Vec<(usize, Vec<f64>)>,
}

/// Writes what the readings show of the couplings that join their axes; where several show the same, the mean.
pub(crate) fn write(outcomes: &[Outcome], blueprint: &mut Blueprint) {
    let Ok(checked) = blueprint.clone().check(components::COMPONENTS) else { return };
    let changes: Vec<Change> = outcomes.iter().flat_map(changes).collect();
    let mut modes: Vec<Mode> = Vec::new();
    for mode in outcomes.iter().filter_map(|o| mode(o, &checked.spec().connections.couplings)) {
        match modes.iter_mut().find(|known| known.is(&mode)) {
            Some(known) => known.join(mode),
            None => modes.push(mode),
        }
    }
    for (number, coupling) in checked.spec().connections.couplings.iter().enumerate() {
        let own: Vec<&Change> = changes.iter().filter(|c| c.coupling == number).collect();
        let modes: Vec<&Mode> = modes.iter().filter(|m| m.coupling == number).collect();
        let Some(target) = blueprint.couplings.get_mut(number) else { continue };
        if own.is_empty() && modes.is_empty() {
            continue;
        }
        let (node, declaration) = (&coupling.node, coupling.node.component.declaration());
        let mut at = 0;
        for (k, quantity) in declaration.parameters.iter().enumerate() {
            let length = declaration.length(k, &node.structure);
            let mut values = node.values[at..at + length].to_vec();
            for (value, index) in values.iter_mut().zip(at..) {
                *value += mean(own.iter().filter(|c| c.index == index));
            }
            for mode in &modes {
                mode.append(quantity.role, quantity.name, coupling.axes.len(), &mut values);
            }
            target.component.set(quantity.name, Value::from(values));
            at += length;
        }
    }
}

/// The mean of changes, weighted by their accuracy where all have one.
fn mean<'a>(changes: impl Iterator<Item = &'a &'a Change> + Clone) -> f64 {
    let is_known = changes.clone().all(|c| c.std.is_some_and(|s| s > 0.0));
    let weight = |c: &Change| c.std.filter(|_| is_known).map_or(1.0, |s| s.powi(-2));
    let sum: f64 = changes.clone().map(|c| weight(c)).sum();
    if sum > 0.0 { changes.map(|c| weight(c) * c.by).sum::<f64>() / sum } else { 0.0 }
}

/// What one reading shows of the values of its coupling.
fn changes(o: &Outcome) -> Vec<Change> {
    let (base, last) = (&o.task.base, &o.found.last);
    let Some((node, joint)) = chain::joint(&base.nodes) else { return Vec::new() };
    let mut all = Vec::new();
    for p in base.parameters.iter().filter(|p| p.node == node) {
        let Some(at) = last.chain.own(&p.name) else { continue };
        let (theta, std) = (last.fit.theta[at], last.fit.deviations[at]);
        all.extend(p.indices.iter().map(|(index, deviation)| Change {
            coupling: joint.coupling,
            index: joint.takes[*index],
            by: deviation * theta,
            std: std.map(|s| (s * deviation).abs()),
        }));
    }
    all
}

/// The further mode that one reading shows.
fn mode(o: &Outcome, couplings: &[CouplingSpec]) -> Option<Mode> {
    let last = &o.found.last;
    let (_, joint) = chain::joint(&last.chain.nodes)?;
    let values = joint.mode_values(&last.chain.parameters, &last.fit.theta);
    let (weights, &[frequency, damping]) = values.split_last_chunk()?;
    let axes = &couplings.get(joint.coupling)?.axes;
    let place = |axis: usize| axes.iter().position(|own| *own == axis);
    let own = place(o.task.axis - 1)?;
    let mut row = vec![0.0; axes.len()];
    row[own] = weights[0];
    for (other, weight) in joint.other_axes().zip(&weights[1..]) {
        row[place(other)?] = *weight;
    }
    Some(Mode { coupling: joint.coupling, frequency, damping, weights: vec![(own, row)] })
}

impl Mode {
    /// Whether another reading shows the same.
    fn is(&self, other: &Self) -> bool {
        self.coupling == other.coupling
            && (self.frequency / other.frequency - 1.0).abs() <= Thresholds::SAME_FREQUENCY
    }

    fn join(&mut self, other: Self) {
        let (own, count) = (self.weights.len() as f64, other.weights.len() as f64);
        let mean = |a: f64, b: f64| (own * a + count * b) / (own + count);
        self.frequency = mean(self.frequency, other.frequency);
        self.damping = mean(self.damping, other.damping);
        self.weights.extend(other.weights);
    }

    /// Appends it to the values of a quantity.
    fn append(&self, role: Option<Role>, name: &str, axes: usize, values: &mut Vec<f64>) {
        match (role, name) {
            (Some(Role::Frequency), _) => values.push(self.frequency),
            (Some(Role::Damping), _) => values.push(self.damping),
            (_, "residue") => {
                let first = values.len();
                values.resize(first + axes * axes, 0.0);
                for (row, weights) in &self.weights {
                    values[first + row * axes..][..axes].copy_from_slice(weights);
                }
            }
            (_, "rate_residue") => values.resize(values.len() + axes * axes, 0.0),
            _ => {}
        }
    }
}
