//! What the present outputs were computed with.

use crate::port_variable::PortVariable;
use crate::state::State;

/// The last step, or rest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Last {
    /// Length of the last part of the step in s; 0 at rest.
    pub(crate) dt: f64,
    /// In how many parts the step was done.
    pub(crate) parts: u32,
    /// The inputs as the host had set them.
    pub(crate) inputs: Vec<Vec<f64>>,
    /// States before it.
    pub(crate) states: Vec<State>,
}

impl Last {
    /// Notes with what a step, or rest, begins.
    pub(crate) fn note(&mut self, dt: f64, inputs: &[PortVariable], states: &[State]) {
        self.dt = dt;
        self.inputs.resize(inputs.len(), Vec::new());
        for (held, variable) in self.inputs.iter_mut().zip(inputs) {
            held.clone_from(&variable.shown);
        }
        self.states.resize(states.len(), State::default());
        self.states.iter_mut().zip(states).for_each(|(kept, state)| kept.clone_from(state));
    }

    /// As numbers, for saving.
    pub(crate) fn save(&self, all: &mut Vec<f64>) {
        all.extend([self.dt, f64::from(self.parts), f64::from(u8::from(!self.inputs.is_empty()))]);
        all.extend(self.inputs.iter().flatten());
        all.push(self.states.len() as f64);
        self.states.iter().for_each(|state| state.save(all));
    }

    /// From what [`save`](Self::save) wrote, for these inputs.
    pub(crate) fn load(
        inputs: &[PortVariable],
        from: &mut impl Iterator<Item = f64>,
    ) -> Option<Self> {
        let (dt, parts, is_noted) = (from.next()?, from.next()? as u32, from.next()? != 0.0);
        let mut held = Vec::new();
        for variable in inputs.iter().filter(|_| is_noted) {
            held.push(variable.shown.iter().map(|_| from.next()).collect::<Option<Vec<f64>>>()?);
        }
        let count = from.next()?;
        let states = (0..count as usize).map(|_| State::load(from)).collect::<Option<_>>()?;
        Some(Self { dt, parts, inputs: held, states })
    }
}
