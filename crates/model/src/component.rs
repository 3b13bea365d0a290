//! A component: one physical effect or one control law.

use alloc::string::String;
use alloc::sync::Arc;
use core::fmt;
use core::ops::Deref;

use crate::{Declaration, Fit, Missing, Role, Table, Wiring};

/// What a component may lack that another component has beside all that the first one does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extension {
    /// An actuator: plays.
    Plays,
    /// An actuator: loops that are wider at one end of the range.
    Skew,
    /// An actuator: a bent characteristic behind its plays.
    Bend,
    /// A mode: a stiffness that grows with the deflection.
    Hardening,
    /// A mode: a stiffness that changes over the position.
    PositionStiffness,
    /// A mode: friction with a pre-sliding distance.
    Friction,
    /// A mode: damping that changes with the velocity.
    NonlinearDamping,
}

/// How a component is undone in front of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Undoing {
    /// Exactly, by an equation.
    ClosedForm,
    /// By a bounded search over the forward model at each step.
    Iteration,
    /// The forward model itself runs beside the machine; nothing is turned round.
    InverseFree,
    /// A table is learned from what the forward model answers.
    Learned,
}

impl Undoing {
    /// For reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ClosedForm => "closed form",
            Self::Iteration => "iteration with a bound",
            Self::InverseFree => "inverse-free",
            Self::Learned => "learned",
        }
    }
}

/// A component of a controller that undoes another one. Its parameters are those of the same names;
/// `command_min` and `command_max` are the bounds of the command where the other stands; a `gain` in command
/// per position is the reciprocal of one in position per command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inverse {
    /// The inverse's type.
    pub kind: &'static str,
    /// How it does that.
    pub undoing: Undoing,
}

impl Inverse {
    /// Exactly, by an equation.
    #[must_use]
    pub const fn closed_form(kind: &'static str) -> Self {
        Self { kind, undoing: Undoing::ClosedForm }
    }

    /// By a bounded search at each step.
    #[must_use]
    pub const fn iteration(kind: &'static str) -> Self {
        Self { kind, undoing: Undoing::Iteration }
    }
}

/// One way through a coupling, from one of its paths to another: a component with one input and one output.
#[cfg(not(target_family = "wasm"))]
#[derive(Clone)]
pub struct TransferPath {
    /// The component.
    pub component: &'static dyn Component,
    /// The component's structure.
    pub structure: alloc::vec::Vec<f64>,
    /// For each of its values the number of the coupling's value that it is.
    pub takes: alloc::vec::Vec<usize>,
}

#[cfg(not(target_family = "wasm"))]
impl TransferPath {
    /// A component of this structure whose values are these of the coupling.
    #[must_use]
    pub fn new(
        component: &'static dyn Component,
        structure: &[f64],
        takes: impl Iterator<Item = usize>,
    ) -> Self {
        Self { component, structure: structure.to_vec(), takes: takes.collect() }
    }
}

/// Room that an instance needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// Numbers computed from the parameters.
    pub coefficients: usize,
    /// Numbers that change at every step.
    pub states: usize,
}

/// One hit of the internal grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Number of the hit since the start (the first step's is 1).
    pub index: u64,
    /// Time of the hit, start + index · period, in s.
    pub time: f64,
    /// Period in s.
    pub period: f64,
}

/// A rule that a set of parameters breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// Name of the quantity.
    pub quantity: &'static str,
    /// Index in it, from 0, for an array.
    pub index: Option<usize>,
    /// The value, in SI.
    pub value: f64,
    /// The rule, and the way out.
    pub rule: &'static str,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.index {
            Some(i) => write!(f, "{}[{}]", self.quantity, i + 1)?,
            None => write!(f, "{}", self.quantity)?,
        }
        write!(f, " = {} (SI): {}", self.value, self.rule)
    }
}

/// Values by name.
pub type Example = &'static [(&'static str, &'static [f64])];

/// One kind of component. Implementations are stateless unit types; an instance is a set of slices.
///
/// Contract of the calls: [`prepare`](Self::prepare) once before anything else and again after a
/// tunable parameter changed; [`rest`](Self::rest) once at the start; then [`step`](Self::step) at
/// each hit. No call allocates or panics.
pub trait Component: Send + Sync {
    /// What is declared about it.
    fn declaration(&self) -> &'static Declaration;

    /// Calls `each` with threshold and weight of every play about the middle of its range, in SI; not
    /// at all for a component without plays.
    fn plays(&self, structure: &[f64], parameters: &[f64], each: &mut dyn FnMut(f64, f64)) {
        let declaration = self.declaration();
        let of = |role| declaration.values_of(role, structure, parameters).unwrap_or_default();
        for (r, w) in of(Role::Threshold).iter().zip(of(Role::Weight)) {
            each(*r, *w);
        }
    }

    /// The component that does the same as this one and has an extension too: it has this one's
    /// quantities by their roles.
    fn extended(&self, by: Extension) -> Option<&'static dyn Component> {
        let _ = by;
        None
    }

    /// The components that undo it in front of the machine, the best first. None: it is linear or without
    /// memory and needs none of its own, or only feedback acts against it.
    fn inverses(&self) -> &'static [Inverse] {
        &[]
    }

    /// Values of an example by name, in the declared units on an axis in V and um; structural settings that no
    /// length of a list gives, too. Empty: its strength in `rigs/effects.toml` is the example.
    fn example(&self) -> Example {
        &[]
    }

    /// How an identification fits it; none where it has a method of its own, or cannot be fitted.
    fn fit(&self) -> Option<&'static Fit> {
        None
    }

    /// How a diagnosis finds that a machine has it where the model has plain plays; none where it is not tried.
    fn missing(&self) -> Option<&'static Missing> {
        None
    }

    /// Whether a step is `y = gain·u + offset` with its two coefficients, `gain` and `offset`, one input and one
    /// output, and nothing else. A chain of nothing else computes them in place, without calls.
    fn is_affine(&self) -> bool {
        false
    }

    /// The way from path number `from` to path number `to` of a coupling with this structure, where each of its
    /// outputs is the sum of such ways, without further terms; none where it is not.
    #[cfg(not(target_family = "wasm"))]
    fn way(&self, structure: &[f64], to: usize, from: usize) -> Option<TransferPath> {
        let (_, _, _) = (structure, to, from);
        None
    }

    /// Part number `number` of a linear component with one input and one output, whose values are among its own: where
    /// one value alone changes, the output of the first part that takes it changes as that of the component does. None
    /// behind the last, and of one that is no sum.
    #[cfg(not(target_family = "wasm"))]
    fn part(&self, structure: &[f64], number: usize) -> Option<TransferPath> {
        let (_, _) = (structure, number);
        None
    }

    /// Whether it runs a learned table (the blueprint's key `table`).
    fn takes_table(&self) -> bool {
        false
    }

    /// The table that it runs.
    fn table(&self) -> Option<&Table> {
        None
    }

    /// The component of this declaration and structure that runs `table`.
    ///
    /// # Errors
    /// Why the table does not fit, and the way out.
    fn with_table(&self, structure: &[f64], table: &Table) -> Result<ComponentRef, String> {
        let (_, _) = (structure, table);
        Err(alloc::format!("{} takes no table; leave it out", self.declaration().kind))
    }

    /// Room for an instance with this structure at this period (s).
    fn sizes(&self, structure: &[f64], period: f64) -> Sizes;

    /// Checks the parameters as a set and computes the coefficients.
    ///
    /// `parameters` holds the values in SI, in the order of the declaration, arrays spread out;
    /// `period` is the internal step in s.
    ///
    /// # Errors
    /// The first [`Violation`] of a rule that spans several values (bounds of single values were
    /// checked before).
    fn prepare(
        &self,
        structure: &[f64],
        parameters: &[f64],
        period: f64,
        coefficients: &mut [f64],
    ) -> Result<(), Violation>;

    /// Sets the state that an instance has when its inputs have been held forever, and the outputs
    /// that belong to it.
    fn rest(&self, coefficients: &[f64], inputs: &[f64], state: &mut [f64], outputs: &mut [f64]);

    /// Advances by one period with the inputs held over it, and writes the outputs at its end. A component
    /// without memory gives what it gives at rest.
    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    ) {
        let _ = tick;
        self.rest(coefficients, inputs, state, outputs);
    }

    /// [`step`](Self::step) on the cells of a system. It stands here so that each component has a
    /// copy of it, compiled together with its own step: one call per hit, whose slices stay in
    /// registers.
    #[cfg(not(target_family = "wasm"))]
    #[doc(hidden)]
    fn step_within(&self, wiring: &Wiring, cells: &mut [f64], tick: &Tick) {
        wiring.apply(cells, |coefficients, state, inputs, outputs| {
            self.step(coefficients, state, *tick, inputs, outputs);
        });
    }

    /// [`step`](Self::step) on the cells of a system, of an instance with one input, whose signal is
    /// given, and one output, whose signal is returned.
    #[cfg(not(target_family = "wasm"))]
    #[doc(hidden)]
    fn step_straight(&self, wiring: &Wiring, cells: &mut [f64], tick: &Tick, input: f64) -> f64 {
        wiring.apply_straight(cells, input, |coefficients, state, inputs, outputs| {
            self.step(coefficients, state, *tick, inputs, outputs);
        })
    }

    /// [`step`](Self::step) of records side by side over `hits`, with a copy for each component like
    /// [`step_within`](Self::step_within): a step waits for the one before it in its record, and a
    /// processor goes on with the other records meanwhile. The first output is kept.
    #[cfg(feature = "records")]
    #[doc(hidden)]
    fn step_records(
        &self,
        coefficients: &[f64],
        period: f64,
        hits: core::ops::Range<usize>,
        records: &mut [Record<'_>],
        outputs: &mut [f64],
    ) {
        for n in hits {
            let tick = Tick { index: n as u64, time: n as f64 * period, period };
            for Record { inputs: [x, command], count, out, state } in &mut *records {
                let inputs = &[x[n], command[n]][..*count];
                self.step(coefficients, state, tick, inputs, outputs);
                out[n] = outputs[0];
            }
        }
    }
}

/// A component: one of the registry, or one that runs a table and is shared by the systems that were
/// built from it.
#[derive(Clone)]
pub enum ComponentRef {
    /// One of the registry.
    Static(&'static dyn Component),
    /// One with its own table.
    Shared(Arc<dyn Component>),
}

impl ComponentRef {
    /// A component with its own table.
    #[must_use]
    pub fn shared(component: impl Component + 'static) -> Self {
        Self::Shared(Arc::new(component))
    }
}

impl From<&'static dyn Component> for ComponentRef {
    fn from(component: &'static dyn Component) -> Self {
        Self::Static(component)
    }
}

impl Deref for ComponentRef {
    type Target = dyn Component;

    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        match self {
            Self::Static(component) => *component,
            Self::Shared(component) => &**component,
        }
    }
}

/// Signals of one record on its way through a component, one value per hit.
#[cfg(feature = "records")]
#[doc(hidden)]
#[derive(Debug)]
pub struct Record<'a> {
    /// The path, and the command of the axis.
    pub inputs: [&'a [f64]; 2],
    /// How many of the two the component reads.
    pub count: usize,
    /// What comes out.
    pub out: &'a mut [f64],
    /// The state of the instance.
    pub state: alloc::vec::Vec<f64>,
}

/// Steps on the cells of a system, once for all components: in a source-code FMU each copy is C that is compiled.
#[cfg(target_family = "wasm")]
impl dyn Component {
    pub(crate) fn step_within(&self, wiring: &Wiring, cells: &mut [f64], tick: &Tick) {
        wiring.apply(cells, |coefficients, state, inputs, outputs| {
            self.step(coefficients, state, *tick, inputs, outputs);
        });
    }

    pub(crate) fn step_straight(
        &self,
        wiring: &Wiring,
        cells: &mut [f64],
        tick: &Tick,
        input: f64,
    ) -> f64 {
        wiring.apply_straight(cells, input, |coefficients, state, inputs, outputs| {
            self.step(coefficients, state, *tick, inputs, outputs);
        })
    }
}
