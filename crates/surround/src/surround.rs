//! Effects around one instance of the original.

use crate::kernel::{Kernel, Wires};
use crate::last_step::Last;
use crate::port_variable::{PortVariable, port_variables};
use crate::repair::{Error, Piece, Port, Repair, Side};
use crate::state::State;

/// Why one of the repair's own variables is not set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unset {
    /// A value outside the bounds, or no number.
    #[error("{name} = {value} is not within [{min}, {max}]")]
    Bounds {
        /// Variable.
        name: String,
        /// Value.
        value: f64,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
    },
    /// The variable is fixed once the initialization mode is left.
    #[error(
        "{name} is fixed once the initialization mode is left; reset the instance to change it"
    )]
    Fixed {
        /// Variable.
        name: String,
    },
}

/// One of the repair's own variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Own {
    /// `<effect>.enabled`.
    Enabled(usize),
    /// `<effect>.<parameter>`.
    Parameter(usize, usize),
    /// An input that the original does not have, by its place in the variables.
    Input(usize),
}

/// A block with what it needs at hand.
#[derive(Clone, Debug)]
struct Link {
    effect: usize,
    piece: Piece,
    kernel: Kernel,
}

/// The effects around one instance, with all that changes.
#[derive(Clone, Debug)]
pub struct Surround {
    pub(crate) repair: Repair,
    own: Vec<(u32, Own)>,
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) enabled: Vec<bool>,
    pub(crate) inputs: Vec<PortVariable>,
    pub(crate) outputs: Vec<PortVariable>,
    pub(crate) changed: Vec<PortVariable>,
    /// Blocks of enabled effects in the order of the path; inputs' first.
    links: Vec<Link>,
    pub(crate) states: Vec<State>,
    /// The last step, or rest.
    pub(crate) last: Last,
    /// Signals at the ports in SI: before the blocks, and as the original gets them.
    drives: Vec<f64>,
    /// Room for signals of inputs and outputs.
    scratch: [Vec<f64>; 3],
    is_running: bool,
    /// Time since the start in s.
    pub(crate) time: f64,
}

impl Surround {
    /// The effects at their start values.
    ///
    /// # Errors
    /// What [`Repair::check`] says.
    pub fn new(repair: Repair) -> Result<Self, Error> {
        repair.check()?;
        let inputs = port_variables(&repair.inputs);
        let mut own: Vec<(u32, Own)> = Vec::new();
        for (e, effect) in repair.effects.iter().enumerate() {
            own.push((effect.reference, Own::Enabled(e)));
            let parameters = effect.parameters.iter().enumerate();
            own.extend(parameters.map(|(k, p)| (p.reference, Own::Parameter(e, k))));
        }
        let added = inputs.iter().enumerate().filter(|(_, v)| v.own);
        own.extend(added.map(|(k, v)| (v.reference, Own::Input(k))));
        own.sort_by_key(|(reference, _)| *reference);
        let mut changed: Vec<PortVariable> = Vec::new();
        for change in &repair.changes {
            if changed.iter().all(|w| w.reference != change.variable.reference) {
                changed.push(PortVariable::new(
                    change.variable.reference,
                    &change.variable.start,
                    false,
                ));
            }
        }
        let outputs = port_variables(&repair.outputs);
        let mut surround = Self {
            own,
            inputs,
            outputs,
            changed,
            values: Vec::new(),
            enabled: Vec::new(),
            links: Vec::new(),
            states: Vec::new(),
            last: Last::default(),
            drives: vec![0.0; repair.inputs.len()],
            scratch: Default::default(),
            is_running: false,
            time: 0.0,
            repair,
        };
        surround.reset();
        Ok(surround)
    }

    /// What the surround was made from.
    #[must_use]
    pub fn repair(&self) -> &Repair {
        &self.repair
    }

    /// Back to the start values.
    pub fn reset(&mut self) {
        let effects = &self.repair.effects;
        self.values =
            effects.iter().map(|e| e.parameters.iter().map(|p| p.start).collect()).collect();
        self.enabled = effects.iter().map(|e| e.enabled).collect();
        let all = self.inputs.iter_mut().chain(&mut self.outputs).chain(&mut self.changed);
        for variable in all {
            variable.shown.clone_from(&variable.start);
            variable.inner.clone_from(&variable.start);
        }
        self.links.clear();
        self.states.clear();
        self.last = Last::default();
        self.is_running = false;
        self.time = 0.0;
    }

    /// Number of values of a Float64 variable.
    #[must_use]
    pub fn size(&self, reference: u32) -> usize {
        let known = self.repair.sizes.iter().find(|(r, _)| *r == reference);
        known.map_or(1, |(_, size)| *size)
    }

    /// Whether values of the variable do not simply go through to the original.
    #[must_use]
    pub fn is_ours(&self, reference: u32) -> bool {
        self.find(reference).is_some()
            || [&self.inputs, &self.outputs, &self.changed]
                .into_iter()
                .any(|all| all.iter().any(|v| v.reference == reference))
    }

    /// Whether the original does not have the variable.
    #[must_use]
    pub fn is_own(&self, reference: u32) -> bool {
        self.find(reference).is_some()
    }

    /// Whether the variable is a Boolean of the repair.
    #[must_use]
    pub fn is_flag(&self, reference: u32) -> bool {
        matches!(self.find(reference), Some(Own::Enabled(_)))
    }

    pub(crate) fn find(&self, reference: u32) -> Option<Own> {
        let at = self.own.binary_search_by_key(&reference, |(r, _)| *r).ok()?;
        Some(self.own[at].1)
    }

    /// The value of one of the repair's own variables; a Boolean is 0 or 1.
    #[must_use]
    pub fn get(&self, reference: u32) -> Option<f64> {
        Some(match self.find(reference)? {
            Own::Enabled(e) => f64::from(u8::from(self.enabled[e])),
            Own::Parameter(e, k) => self.values[e][k],
            Own::Input(k) => self.inputs[k].shown[0],
        })
    }

    /// Sets one of the repair's own variables.
    ///
    /// # Errors
    /// [`Unset`].
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), Unset> {
        let Some(own) = self.find(reference) else { return Ok(()) };
        match own {
            Own::Input(k) => self.inputs[k].shown[0] = value,
            Own::Enabled(e) => {
                let name = || format!("{}.enabled", self.repair.effects[e].name);
                if self.is_running && self.enabled[e] != (value != 0.0) {
                    return Err(Unset::Fixed { name: name() });
                }
                self.enabled[e] = value != 0.0;
            }
            Own::Parameter(e, k) => {
                let effect = &self.repair.effects[e];
                let p = &effect.parameters[k];
                let name = || format!("{}.{}", effect.name, p.name);
                if self.is_running && self.values[e][k] != value {
                    return Err(Unset::Fixed { name: name() });
                }
                let min = p.min.unwrap_or(f64::NEG_INFINITY);
                let max = p.max.unwrap_or(f64::INFINITY);
                if !value.is_finite() || value < min || value > max {
                    return Err(Unset::Bounds { name: name(), value, min, max });
                }
                self.values[e][k] = value;
            }
        }
        Ok(())
    }

    /// The values that the host sees of an input, an output, or a changed parameter.
    #[must_use]
    pub fn shown(&self, reference: u32) -> Option<&[f64]> {
        let mut all = self.inputs.iter().chain(&self.outputs).chain(&self.changed);
        all.find(|v| v.reference == reference).map(|v| v.shown.as_slice())
    }

    /// Takes over values that the host sets of an input or a changed parameter; the answer is what
    /// the original gets now, if it gets any.
    pub fn take(&mut self, reference: u32, values: &[f64]) -> Option<&[f64]> {
        if let Some(at) = self.changed.iter().position(|v| v.reference == reference) {
            self.changed[at].shown.copy_from_slice(values);
            self.change(at);
            return Some(&self.changed[at].inner);
        }
        let at = self.inputs.iter().position(|v| v.reference == reference && !v.own)?;
        let running = self.is_running && self.is_active();
        let variable = &mut self.inputs[at];
        variable.shown.copy_from_slice(values);
        (!running).then_some(variable.shown.as_slice())
    }

    /// Puts the change of enabled effects on a parameter of the original.
    fn change(&mut self, at: usize) {
        let Self { changed, repair, values, enabled, .. } = self;
        let variable = &mut changed[at];
        variable.inner.clone_from(&variable.shown);
        for change in repair.changes.iter().filter(|c| c.variable.reference == variable.reference) {
            if enabled[change.effect] {
                variable.inner[change.element] += values[change.effect][change.parameter];
            }
        }
    }

    /// The changed parameters as the original gets them.
    pub fn changed(&mut self) -> &[PortVariable] {
        for at in 0..self.changed.len() {
            self.change(at);
        }
        &self.changed
    }

    /// Whether any effect is switched on; else everything goes through as it is.
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.enabled.iter().any(|is_on| *is_on)
    }

    /// Whether the initialization is over.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.is_running
    }

    /// The inputs, with what the original gets.
    #[must_use]
    pub fn inputs(&self) -> &[PortVariable] {
        &self.inputs
    }

    /// The outputs; what the original says goes into `inner`.
    pub fn outputs(&mut self) -> &mut [PortVariable] {
        &mut self.outputs
    }

    /// Computes what the original gets at rest.
    pub fn rest_inputs(&mut self) {
        self.time = 0.0;
        self.link();
        self.last.note(0.0, &self.inputs, &[]);
        self.before(0.0);
    }

    /// Computes the outputs at rest from what the original says.
    pub fn rest_outputs(&mut self) {
        self.behind(0.0);
    }

    /// The initialization is over.
    pub fn start(&mut self) {
        self.is_running = true;
    }

    /// Computes what the original gets in a step of this length in s.
    pub fn step_inputs(&mut self, dt: f64) {
        self.last.note(dt, &self.inputs, &self.states);
        self.time += dt;
        self.before(dt);
    }

    /// Computes the outputs at the end of the step from what the original says.
    pub fn step_outputs(&mut self, dt: f64) {
        self.behind(dt);
    }

    /// Takes back a step that the original did not do.
    pub fn undo(&mut self, dt: f64) {
        self.states.clone_from(&self.last.states);
        self.time -= dt;
    }

    /// Shows the original's outputs as they are.
    pub fn pass_outputs(&mut self) {
        for variable in &mut self.outputs {
            variable.shown.clone_from(&variable.inner);
        }
    }

    /// In how many parts a communication step of this length is done.
    #[must_use]
    pub fn parts(&self, step: f64) -> u32 {
        if !self.repair.divide {
            return 1;
        }
        (step / self.repair.step - 1e-6).ceil().clamp(1.0, 1e6) as u32
    }

    /// Everything that changes, as numbers.
    #[must_use]
    pub fn save(&self) -> Vec<f64> {
        let flag = |is: bool| f64::from(u8::from(is));
        let mut all = vec![flag(self.is_running), self.time];
        all.extend(self.enabled.iter().map(|e| flag(*e)));
        all.extend(self.values.iter().flatten());
        for variable in self.inputs.iter().chain(&self.outputs).chain(&self.changed) {
            all.extend(variable.shown.iter().chain(&variable.inner));
        }
        all.push(self.states.len() as f64);
        self.states.iter().for_each(|state| state.save(&mut all));
        self.last.save(&mut all);
        all
    }

    /// Goes back to what [`save`](Self::save) wrote; says whether that could be read, else nothing
    /// is changed.
    pub fn load(&mut self, numbers: &[f64]) -> bool {
        let mut copy = self.clone();
        let mut from = numbers.iter().copied();
        let done = copy.fill(&mut from).is_some() && from.next().is_none();
        if done {
            *self = copy;
        }
        done
    }

    fn fill(&mut self, from: &mut impl Iterator<Item = f64>) -> Option<()> {
        self.is_running = from.next()? != 0.0;
        self.time = from.next()?;
        for e in &mut self.enabled {
            *e = from.next()? != 0.0;
        }
        for v in self.values.iter_mut().flatten() {
            *v = from.next()?;
        }
        let all = self.inputs.iter_mut().chain(&mut self.outputs).chain(&mut self.changed);
        for variable in all {
            for v in variable.shown.iter_mut().chain(&mut variable.inner) {
                *v = from.next()?;
            }
        }
        self.link();
        let count = from.next()?;
        let states = (0..count as usize).map(|_| State::load(from)).collect::<Option<Vec<_>>>()?;
        let fit = self.links.iter().zip(&states).all(|(link, state)| link.kernel.fits(state));
        if !states.is_empty() && (states.len() != self.links.len() || !fit) {
            return None;
        }
        if !states.is_empty() {
            self.states = states;
        }
        self.last = Last::load(&self.inputs, from)?;
        Some(())
    }

    /// Puts the blocks of enabled effects in order, with their parameters in SI.
    fn link(&mut self) {
        self.links.clear();
        for (e, effect) in self.repair.effects.iter().enumerate().filter(|(e, _)| self.enabled[*e])
        {
            for piece in &effect.blocks {
                let p = piece.values(effect, |k| self.values[e][k]);
                let kernel = piece.block.prepare(&p, self.repair.step);
                let kernel = kernel.expect("the numbers of parameters are checked in `new`");
                self.links.push(Link { effect: e, piece: piece.clone(), kernel });
            }
        }
        self.links.sort_by_key(|l| (l.piece.side == Side::Output, l.piece.place, l.effect));
        self.states = vec![State::default(); self.links.len()];
    }

    /// Runs the blocks of the inputs; a `dt` of 0 is rest.
    fn before(&mut self, dt: f64) {
        for variable in &mut self.inputs {
            variable.inner.clone_from(&variable.shown);
        }
        let mut signals = std::mem::take(&mut self.scratch[0]);
        signals.clear();
        signals.extend((0..self.repair.inputs.len()).map(|k| self.input(k)));
        self.drives.clone_from(&signals);
        self.run(Side::Input, dt, &signals);
        for (k, port) in self.repair.inputs.iter().enumerate().filter(|(_, p)| !p.own) {
            // A path without blocks keeps the very bits of the host.
            if self.drives[k].to_bits() != signals[k].to_bits()
                && let Some(v) = self.inputs.iter_mut().find(|v| v.ports.contains(&k))
            {
                v.inner[port.element] = (self.drives[k] - port.offset) / port.factor;
            }
        }
        self.scratch[0] = signals;
    }

    /// The signal of an input in SI, as the host sets it.
    fn input(&self, port: usize) -> f64 {
        let described = &self.repair.inputs[port];
        let variable = self.inputs.iter().find(|v| v.ports.contains(&port));
        variable.map_or(0.0, |v| v.shown[described.element] * described.factor + described.offset)
    }

    /// Runs the blocks of the outputs; a `dt` of 0 is rest.
    fn behind(&mut self, dt: f64) {
        self.pass_outputs();
        let [mut auxiliary, mut signals, mut before] = std::mem::take(&mut self.scratch);
        auxiliary.clear();
        auxiliary.extend((0..self.repair.inputs.len()).map(|k| self.input(k)));
        let of = |p: usize, all: &[PortVariable], described: &Port| {
            let variable = all.iter().find(|v| v.ports.contains(&p));
            variable
                .map_or(0.0, |v| v.inner[described.element] * described.factor + described.offset)
        };
        let ports = self.repair.outputs.iter().enumerate();
        signals.clear();
        signals.extend(ports.map(|(k, described)| of(k, &self.outputs, described)));
        before.clone_from(&signals);
        let (t, drives) = (self.time, &self.drives);
        for (link, state) in self.links.iter_mut().zip(&mut self.states) {
            let piece = &link.piece;
            if piece.side != Side::Output {
                continue;
            }
            let aux = piece.auxiliary.map_or(0.0, |k| auxiliary[k]);
            let w = Wires { x: signals[piece.port], drive: drives[piece.drive], aux };
            signals[piece.port] = step(&mut link.kernel, w, (t, dt), state);
        }
        for (k, port) in self.repair.outputs.iter().enumerate() {
            if signals[k].to_bits() != before[k].to_bits()
                && let Some(v) = self.outputs.iter_mut().find(|v| v.ports.contains(&k))
            {
                v.shown[port.element] = (signals[k] - port.offset) / port.factor;
            }
        }
        self.scratch = [auxiliary, signals, before];
    }

    fn run(&mut self, side: Side, dt: f64, auxiliary: &[f64]) {
        for (link, state) in self.links.iter_mut().zip(&mut self.states) {
            let piece = &link.piece;
            if piece.side != side {
                continue;
            }
            let x = self.drives[piece.port];
            let aux = piece.auxiliary.map_or(0.0, |k| auxiliary[k]);
            let w = Wires { x, drive: self.drives[piece.drive], aux };
            self.drives[piece.port] = step(&mut link.kernel, w, (self.time, dt), state);
        }
    }
}

/// A step of `dt` s that ends at the time `t`; of no length, rest.
fn step(kernel: &mut Kernel, w: Wires, (t, dt): (f64, f64), state: &mut State) -> f64 {
    if dt > 0.0 {
        kernel.set_step(dt);
        kernel.step(w, t, state)
    } else {
        kernel.rest(w, state)
    }
}
