//! A built chain of components that steps on its own grid.

mod build;
mod cells;
mod derivative;
mod past;
mod spec;
mod step;
mod straight;

use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use core::ops::Range;

pub use derivative::{DerivativeError, DerivativeRoom};
pub use past::Past;
pub use spec::{
    AxisSpec, BuildError, Connections, CouplingSpec, InputSpec, Kind, NodeSpec, PortSpec,
    SystemSpec,
};
pub use straight::Quick;
use straight::{Affine, Straight};

use crate::{
    Causality, ComponentRef, Context, ContextError, SetError, Unit, VariableTable, Violation,
    Wiring,
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
    /// Input variables and the signals that they feed. The variables are the first of the table, in
    /// this order.
    inputs: Vec<Wire>,
    /// Output variables and the signals that they show. The variables follow the inputs, in this
    /// order.
    outputs: Vec<Wire>,
    /// Where the blocks of the context's cells begin: coefficients, state, signals.
    blocks: [usize; 3],
    /// Most parameters of one node.
    widest: usize,
    /// A port reads a signal that is computed later on the path.
    reads_back: bool,
    /// A billionth of the period, in s.
    near: f64,
    /// The plan's ends, if it is one chain.
    straight: Option<Straight>,
    /// The plan's components, if it is one chain of gains and offsets; else empty.
    affine: Vec<Affine>,
}

/// Where no value switches a node on.
const ALWAYS_ON: usize = usize::MAX;

/// An instance of a component.
#[derive(Clone)]
struct Node {
    component: ComponentRef,
    /// `axis[1].hysteresis`, for messages.
    path: String,
    structure: Vec<f64>,
    /// The node's parameters in the values.
    parameters: Range<usize>,
    /// Which of its parameters are seeds.
    seeds: Vec<usize>,
    /// Value that switches it on; [`ALWAYS_ON`], which no value is, where there is none.
    enabled: usize,
    wiring: Wiring,
    /// Number of signal paths through it: the first inputs and the first outputs.
    paths: usize,
}

#[derive(Clone, Copy, Debug)]
struct Wire {
    variable: usize,
    /// Cell of the signal.
    signal: usize,
    unit: Unit,
}

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
        /// The reference's value.
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
    #[inline]
    #[must_use]
    pub fn get(&self, reference: u32) -> Option<f64> {
        self.values().get(reference as usize).copied()
    }

    /// The values of all variables in their own units, by value reference.
    #[inline]
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.context.cells[..self.plan.blocks[0]]
    }

    /// Sets an input or a parameter, in its own unit. A parameter takes effect at the next hit.
    ///
    /// # Errors
    /// [`SetError`]; nothing is changed then.
    #[inline]
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), SetError> {
        self.check(reference, value)?;
        self.put(reference, value);
        Ok(())
    }

    /// Sets what [`check`](Self::check) has admitted.
    ///
    /// # Panics
    /// No variable has this value reference.
    #[inline]
    pub fn put(&mut self, reference: u32, value: f64) {
        let reference = reference as usize;
        let cell = &mut self.context.cells[..self.plan.blocks[0]][reference];
        // The inputs are the first variables.
        if reference >= self.plan.inputs.len() && cell.to_bits() != value.to_bits() {
            self.context.dirty = true;
        }
        *cell = value;
    }

    /// Sets an input to a finite number; nothing where the reference is none of an input.
    #[inline]
    pub fn put_input(&mut self, reference: u32, value: f64) {
        // The inputs are the first variables.
        let inputs = self.plan.inputs.len();
        let cells = self.context.cells.get_mut(..inputs);
        if let Some(cell) = cells.and_then(|cells| cells.get_mut(reference as usize)) {
            *cell = value;
        }
    }

    /// Why [`set`](Self::set) does not take this value.
    #[cold]
    fn not_settable(&self, reference: u32, value: f64) -> SetError {
        let count = self.plan.variables.len() as u32;
        let Some(variable) = self.plan.variables.get(reference) else {
            return SetError::Unknown { reference, count };
        };
        if variable.causality == Causality::Output {
            return SetError::NotSettable { reference };
        }
        if !value.is_finite() {
            return SetError::NotFinite { reference, value };
        }
        SetError::OutOfRange { reference, value, min: variable.min, max: variable.max }
    }

    /// Whether [`set`](Self::set) would take this value.
    ///
    /// # Errors
    /// [`SetError`]: why it would not.
    #[inline]
    pub fn check(&self, reference: u32, value: f64) -> Result<(), SetError> {
        match self.plan.variables.gate(reference) {
            Some(gate) if gate.takes(value) => Ok(()),
            _ => Err(self.not_settable(reference, value)),
        }
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
