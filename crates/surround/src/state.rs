//! What a block remembers.

use std::collections::VecDeque;

/// State of one block. Everything that changes is in here, so that saving is copying.
#[derive(Debug, Default, PartialEq)]
pub struct State {
    /// Numbers, as many as the block wants.
    pub(crate) z: Vec<f64>,
    /// Time since the start in s and value, oldest first; of delays only.
    pub(crate) past: VecDeque<(f64, f64)>,
}

impl Clone for State {
    fn clone(&self) -> Self {
        Self { z: self.z.clone(), past: self.past.clone() }
    }

    // Keeps its room: a state is copied in each step.
    fn clone_from(&mut self, source: &Self) {
        self.z.clone_from(&source.z);
        self.past.clone_from(&source.past);
    }
}

impl State {
    /// Writes all numbers, for a saved state.
    pub fn save(&self, into: &mut Vec<f64>) {
        into.push(self.z.len() as f64);
        into.extend(&self.z);
        into.push(self.past.len() as f64);
        into.extend(self.past.iter().flat_map(|(t, v)| [*t, *v]));
    }

    /// Reads what [`save`](Self::save) wrote; `None` where it is something else.
    pub fn load(from: &mut impl Iterator<Item = f64>) -> Option<Self> {
        let z = (0..count(from)?).map(|_| from.next()).collect::<Option<_>>()?;
        let past =
            (0..count(from)?).map(|_| Some((from.next()?, from.next()?))).collect::<Option<_>>()?;
        Some(Self { z, past })
    }
}

/// A number of elements; absurd ones are none.
fn count(from: &mut impl Iterator<Item = f64>) -> Option<usize> {
    let n = from.next()?;
    (n >= 0.0 && n.fract() == 0.0 && n < 1e8).then_some(n as usize)
}

/// The value at a time, straight lines between; what is older than that is forgotten.
pub(crate) fn past(time: f64, state: &mut State) -> f64 {
    while state.past.get(1).is_some_and(|(t, _)| *t <= time) {
        state.past.pop_front();
    }
    match (state.past.front(), state.past.get(1)) {
        (Some((a, va)), Some((b, vb))) if time > *a => va + (time - a) / (b - a) * (vb - va),
        (Some((_, v)), _) => *v,
        _ => 0.0,
    }
}
