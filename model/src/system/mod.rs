//! A built chain of components that steps on its own grid.

mod build;
mod cells;
mod derivative;
mod past;
mod spec;

use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use core::ops::Range;

pub use derivative::{DerivativeError, DerivativeRoom};
pub use past::Past;
pub use spec::{
    AxisSpec, BuildError, Connections, CouplingSpec, InputSpec, Kind, NodeSpec, SystemSpec,
};

use self::cells::{Cells, own_seed};
use crate::{
    Causality, Component, Context, ContextError, MAX_PORTS, SetError, Tick, Unit, VariableTable,
    Violation,
};

/// A system: an immutable plan and one [`Context`].
///
/// Time is `t_n = start + n·period` with an integer `n`. [`advance`](Self::advance) performs every
/// hit with `t_n ≤ time + 1e-9·period` (far from zero, where that is less than four units in the last
/// place of the time, with those instead); the outputs are those of the last hit. Hit `n` takes the
/// inputs as held over the period that ends at `t_n`.
#[derive(Clone, Debug)]
pub struct System {
    plan: Plan,
    context: Context,
    /// The context right after building, for [`reset`](Self::reset).
    pristine: Context,
}

/// What never changes.
#[derive(Clone)]
pub(crate) struct Plan {
    name: String,
    kind: Kind,
    period: f64,
    variables: VariableTable,
    nodes: Vec<Node>,
    /// Input variables and the signals that they feed.
    inputs: Vec<Wire>,
    /// Output variables and the signals that they show.
    outputs: Vec<Wire>,
    /// Where the blocks of the context's cells begin: coefficients, state, signals.
    blocks: [usize; 3],
    /// Most parameters of one node.
    widest: usize,
    /// A port reads a signal that is computed later on the path.
    reads_back: bool,
}

/// An instance of a component.
#[derive(Clone)]
struct Node {
    component: &'static dyn Component,
    /// `axis[1].hysteresis`, for messages.
    path: String,
    structure: Vec<f64>,
    /// Its parameters in the values.
    parameters: Range<usize>,
    /// Which of its parameters are seeds.
    seeds: Vec<usize>,
    /// Value that switches it on; `None`: always on.
    enabled: Option<usize>,
    coefficients: Range<usize>,
    state: Range<usize>,
    /// Signals read by its input ports.
    inputs: [usize; MAX_PORTS],
    input_count: usize,
    /// Signals written by its output ports.
    outputs: Range<usize>,
    /// Number of signal paths through it: the first inputs and the first outputs.
    paths: usize,
}

#[derive(Clone, Copy, Debug)]
struct Wire {
    variable: usize,
    signal: usize,
    unit: Unit,
}

/// Passes over the chain within which signals that are read back must settle at rest.
const MOST_PASSES: usize = 1000;

/// Why a step could not be done. The message names what and how to mend it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepError {
    /// The parameters of node number `node` break a rule.
    Parameters {
        /// Index of the component in the chain.
        node: usize,
        /// The rule.
        violation: Violation,
    },
    /// The signals that are read back settle at no state of rest.
    NoRest,
    /// An output is not a finite number.
    NotFinite {
        /// Value reference of the output.
        reference: u32,
        /// Its value.
        value: f64,
        /// Time in s.
        time: f64,
    },
}

impl System {
    /// Builds the chain that `spec` describes.
    ///
    /// # Errors
    /// Every [`BuildError`] that was found.
    pub fn new(spec: &SystemSpec) -> Result<Self, Vec<BuildError>> {
        build::build(spec)
    }

    /// Name of the model.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.plan.name
    }

    /// Plant or controller.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.plan.kind
    }

    /// Internal step in s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.plan.period
    }

    /// The variables.
    #[must_use]
    pub fn variables(&self) -> &VariableTable {
        &self.plan.variables
    }

    /// Time of the last hit in s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.context.start + self.context.index as f64 * self.plan.period
    }

    /// The value of a variable in its own unit.
    #[must_use]
    pub fn get(&self, reference: u32) -> Option<f64> {
        let index = reference as usize;
        (index < self.plan.variables.len()).then(|| self.context.cells[index])
    }

    /// Sets an input or a parameter, in its own unit. A parameter takes effect at the next step.
    ///
    /// # Errors
    /// [`SetError`]; nothing is changed then.
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), SetError> {
        self.check(reference, value)?;
        let cell = &mut self.context.cells[reference as usize];
        let is_input =
            self.plan.variables.as_slice()[reference as usize].causality == Causality::Input;
        if !is_input && cell.to_bits() != value.to_bits() {
            self.context.dirty = true;
        }
        *cell = value;
        Ok(())
    }

    /// Whether [`set`](Self::set) would take this value.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn check(&self, reference: u32, value: f64) -> Result<(), SetError> {
        let count = self.plan.variables.len() as u32;
        let Some(variable) = self.plan.variables.get(reference) else {
            return Err(SetError::Unknown { reference, count });
        };
        if variable.causality == Causality::Output {
            return Err(SetError::NotSettable { reference });
        }
        if !value.is_finite() {
            return Err(SetError::NotFinite { reference, value });
        }
        let (min, max) = (variable.min, variable.max);
        if variable.causality != Causality::Input && !(min..=max).contains(&value) {
            return Err(SetError::OutOfRange { reference, value, min, max });
        }
        Ok(())
    }

    /// Puts the system at rest under its present inputs at time `start`: computes the coefficients,
    /// the state of a machine whose inputs were held forever, and the outputs. It may be called
    /// again with other inputs or parameters before the first step.
    ///
    /// # Errors
    /// [`StepError::Parameters`] where the parameters break a rule as a set.
    pub fn initialise(&mut self, start: f64) -> Result<(), StepError> {
        (self.context.start, self.context.index) = (start, 0);
        self.context.dirty = true;
        self.prepare()?;
        self.read_inputs();
        self.settle()?;
        self.write_outputs()
    }

    /// Puts every node at rest; where a signal is read back, until all signals stay as they are.
    fn settle(&mut self) -> Result<(), StepError> {
        let (plan, mut cells) = self.split();
        if !plan.reads_back {
            cells.rest(plan);
            return Ok(());
        }
        cells.forget_outputs(plan);
        let mut before = 0;
        for _ in 0..MOST_PASSES {
            cells.rest(plan);
            let now = cells.fingerprint();
            if now == before {
                return Ok(());
            }
            before = now;
        }
        Err(StepError::NoRest)
    }

    /// Performs every hit with `t_n ≤ time + 1e-9·period`, with the present inputs. Returns how many.
    ///
    /// # Errors
    /// [`StepError`]: parameters that break a rule, or an output that is not finite.
    pub fn advance(&mut self, time: f64) -> Result<u64, StepError> {
        self.hits(time, |_, _, _| ())
    }

    /// As [`advance`](Self::advance), with inputs that move on straight lines: at time `t` the input
    /// with value reference `i` is `u_i + slopes[i]·(t − from)`, `u_i` being the value that was set
    /// and the slope in its unit per second. Hit `n` takes the inputs as they are at `t_{n-1}`, as
    /// if they were set there. Inputs without a slope here are held.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    pub fn advance_along(
        &mut self,
        time: f64,
        from: f64,
        slopes: &[f64],
    ) -> Result<u64, StepError> {
        self.hits(time, |plan, cells, begin| {
            for wire in &plan.inputs {
                if let Some(slope) = slopes.get(wire.variable) {
                    let value = cells.values[wire.variable] + slope * (begin - from);
                    cells.signals[wire.signal] = wire.unit.to_si(value);
                }
            }
        })
    }

    /// Performs the hits up to `time`; `before` is called before each with its begin in s.
    fn hits(
        &mut self,
        time: f64,
        before: impl Fn(&Plan, &mut Cells<'_>, f64),
    ) -> Result<u64, StepError> {
        self.prepare()?;
        self.read_inputs();
        let (start, period) = (self.context.start, self.plan.period);
        // Far from zero, a billionth of a period is less than what adding up times loses.
        let limit = time + (1e-9 * period).max(4.0 * f64::EPSILON * time.abs());
        let first = self.context.index;
        let mut index = first;
        let (plan, mut cells) = self.split();
        loop {
            let time = start + (index + 1) as f64 * period;
            if time > limit || !limit.is_finite() {
                break;
            }
            before(plan, &mut cells, start + index as f64 * period);
            index += 1;
            let tick = Tick { index, time, period };
            for node in &plan.nodes {
                cells.step(node, tick);
            }
        }
        self.context.index = index;
        self.write_outputs()?;
        Ok(index - first)
    }

    /// Back to the state right after building.
    pub fn reset(&mut self) {
        self.context.copy_from(&self.pristine);
    }

    /// Everything that changes, for saving.
    #[must_use]
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Restores a saved context of this system.
    ///
    /// # Errors
    /// [`ContextError`] where it belongs to a system of another size; nothing is changed then.
    pub fn restore(&mut self, context: &Context) -> Result<(), ContextError> {
        if context.cells.len() != self.context.cells.len() {
            return Err(ContextError {
                expected: self.context.byte_len(),
                found: context.byte_len(),
            });
        }
        self.context.copy_from(context);
        Ok(())
    }

    /// The message of an error, with names instead of numbers.
    #[must_use]
    pub fn explain(&self, error: &StepError) -> String {
        let mut text = String::new();
        let _ = match error {
            StepError::Parameters { node, violation } => {
                let path = self.plan.nodes.get(*node).map_or("", |n| n.path.as_str());
                fmt::write(&mut text, format_args!("{path}.{violation}"))
            }
            StepError::NoRest => fmt::write(
                &mut text,
                format_args!(
                    "{}: the signals that components read back grow without end at rest; weaken them",
                    self.plan.name
                ),
            ),
            StepError::NotFinite { reference, value, time } => {
                let name = self.plan.variables.get(*reference).map_or("", |v| v.name.as_str());
                fmt::write(
                    &mut text,
                    format_args!(
                        "{name} = {value} at {time} s: the model has left its range; check inputs and \
                         parameters"
                    ),
                )
            }
        };
        text
    }

    /// The message of an error of [`set`](Self::set), with the variable's name.
    #[must_use]
    pub fn explain_set(&self, error: &SetError) -> String {
        let mut text = String::new();
        let (SetError::Unknown { reference, .. }
        | SetError::NotSettable { reference }
        | SetError::NotFinite { reference, .. }
        | SetError::OutOfRange { reference, .. }) = error;
        let _ = match self.plan.variables.get(*reference) {
            Some(v) => fmt::write(&mut text, format_args!("{}: {error}", v.name)),
            None => fmt::write(&mut text, format_args!("{error}")),
        };
        text
    }

    fn split(&mut self) -> (&Plan, Cells<'_>) {
        (&self.plan, Cells::of(&mut self.context.cells, self.plan.blocks))
    }

    /// Computes the coefficients again where a parameter changed.
    fn prepare(&mut self) -> Result<(), StepError> {
        if !self.context.dirty {
            return Ok(());
        }
        let blocks = self.plan.blocks;
        let (values, rest) = self.context.cells.split_at_mut(blocks[0]);
        let (coefficients, scratch) = rest.split_at_mut(blocks[1] - blocks[0]);
        // The last cells are scratch for the SI values of one node.
        let scratch_start = scratch.len() - self.plan.widest;
        let scratch = &mut scratch[scratch_start..];
        let variables = self.plan.variables.as_slice();
        for (number, node) in self.plan.nodes.iter().enumerate() {
            let range = node.parameters.clone();
            let si = &mut scratch[..range.len()];
            for ((si, value), variable) in
                si.iter_mut().zip(&values[range.clone()]).zip(&variables[range])
            {
                *si = variable.si.to_si(*value);
            }
            for seed in &node.seeds {
                si[*seed] = own_seed(si[*seed], &node.path);
            }
            let coefficients = &mut coefficients[node.coefficients.clone()];
            node.component
                .prepare(&node.structure, si, self.plan.period, coefficients)
                .map_err(|violation| StepError::Parameters { node: number, violation })?;
        }
        self.context.dirty = false;
        Ok(())
    }

    fn read_inputs(&mut self) {
        let signals = self.plan.blocks[2];
        for wire in &self.plan.inputs {
            let value = wire.unit.to_si(self.context.cells[wire.variable]);
            self.context.cells[signals + wire.signal] = value;
        }
    }

    fn write_outputs(&mut self) -> Result<(), StepError> {
        let signals = self.plan.blocks[2];
        for wire in &self.plan.outputs {
            let value = wire.unit.from_si(self.context.cells[signals + wire.signal]);
            self.context.cells[wire.variable] = value;
        }
        for wire in &self.plan.outputs {
            let value = self.context.cells[wire.variable];
            if !value.is_finite() {
                let reference = wire.variable as u32;
                return Err(StepError::NotFinite { reference, value, time: self.time() });
            }
        }
        Ok(())
    }
}

impl fmt::Debug for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Plan")
            .field("name", &self.name)
            .field("kind", &self.kind)
            .field("period", &self.period)
            .field("nodes", &self.nodes.iter().map(|n| &n.path).collect::<Vec<_>>())
            .finish_non_exhaustive()
    }
}
