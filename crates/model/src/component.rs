//! A component: one physical effect or one control law.

use alloc::string::String;
use core::fmt;

use crate::{ComponentRef, Effect, Quantity, Role, Structural, Table, Wiring};

/// Most input ports of one component.
pub const MAX_PORTS: usize = 64;

/// The list of all component types.
pub type Registry = &'static [&'static dyn Component];

/// Where on the signal path a component sits; the order is the order of the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Quantisation, delay, clock.
    Timing,
    /// Amplifier.
    Amplifier,
    /// Actuator: hysteresis, creep, polarisation, temperature.
    Actuator,
    /// Modes, load, backlash, friction, disturbance force.
    Mechanics,
    /// Cross-coupling between axes.
    Coupling,
    /// Thermal drift, floor.
    Environment,
    /// Sensor.
    Sensor,
    /// Control law (controllers only).
    Control,
}

impl Stage {
    /// The identifier used in files and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Timing => "timing",
            Self::Amplifier => "amplifier",
            Self::Actuator => "actuator",
            Self::Mechanics => "mechanics",
            Self::Coupling => "coupling",
            Self::Environment => "environment",
            Self::Sensor => "sensor",
            Self::Control => "control",
        }
    }
}

/// What a component does to the kind of signal on the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conversion {
    /// What goes in comes out: volts stay volts, metres stay metres.
    None,
    /// Command (V) in, position (m, rad, 1) out: actuators.
    CommandToPosition,
    /// Position in, command out: inverse models.
    PositionToCommand,
    /// Takes the path's command signal and external ones, gives a command: control laws. Where the
    /// path still carries a position, the port reads zero.
    Control,
    /// Motion of the coupled axes in, positions in the axes' own unit out: optics (couplings). In
    /// the units of its quantities `{command}` stands for the unit of the motion.
    MotionToPosition,
    /// The inverse, in front of control laws: references and measured positions of the coupled axes
    /// in, in the axes' own unit; motions that are wanted and measured out; units as for
    /// [`MotionToPosition`](Self::MotionToPosition).
    PositionToMotion,
}

/// Where an input port reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The signal path: the output of the component before, or the axis' input.
    Path,
    /// A signal of the axis by name.
    ///
    /// Controllers: `reference`, `measured`. Plants: `command`; `voltage` (the path where it is turned
    /// into a position), `displacement` (the path behind the mechanics), `position` (what the sensor
    /// reads); and the inputs of [`DEMANDED_INPUTS`], which a model has only where one of its
    /// components reads them. A signal that is computed later on the path has the value of the
    /// previous hit.
    Axis(&'static str),
    /// An input of the whole system by name (`enable`; for plants those of [`DEMANDED_INPUTS`]).
    System(&'static str),
    /// Couplings: the signal path of every coupled axis, one port after the other. A component with
    /// such a port is a coupling: its first output stands for the paths behind it.
    EachPath,
    /// Couplings: a signal of every coupled axis by name, as in [`Axis`](Self::Axis).
    Each(&'static str),
}

/// An input that a plant has only where a component reads it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DemandedInput {
    /// Name: `force` is `force[1]`, `force[2]`, …
    pub name: &'static str,
    /// Unit where the blueprint gives none, with `{position}` for the axis' own.
    pub unit: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// Start where the blueprint gives none, in [`unit`](Self::unit).
    pub start: f64,
    /// Whether each axis has its own; else there is one for the whole plant.
    pub per_axis: bool,
}

/// All inputs that plants have on demand, in the order of the variables.
pub const DEMANDED_INPUTS: [DemandedInput; 4] = [
    DemandedInput {
        name: "force",
        unit: "N",
        description: "Load force, positive towards greater positions",
        start: 0.0,
        per_axis: true,
    },
    DemandedInput {
        name: "disturbance",
        unit: "{position}",
        description: "Disturbance of the position",
        start: 0.0,
        per_axis: true,
    },
    DemandedInput {
        name: "temperature",
        unit: "degC",
        description: "Temperature of the surroundings",
        start: 20.0,
        per_axis: false,
    },
    DemandedInput {
        name: "actuator_temperature",
        unit: "K",
        description: "Temperature of the actuator",
        start: 293.15,
        per_axis: true,
    },
];

/// An input port.
#[derive(Clone, Copy, Debug)]
pub struct Input {
    /// Name in the equations.
    pub name: &'static str,
    /// Where it reads.
    pub source: Source,
    /// Whether the outputs at rest depend on it ([`Component::rest`]).
    pub at_rest: bool,
}

/// An output port. The first one is the signal path. In a controller, one that is not published and has
/// the name of a signal of the axis (`reference`, `measured`) takes its place for the components behind.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// Name in the equations.
    pub name: &'static str,
    /// Published as an output `name[i]` of the axis, with this unit and sentence.
    pub published: Option<Published>,
}

/// How an output port appears outside.
#[derive(Clone, Copy, Debug)]
pub struct Published {
    /// Unit, with `{command}` and `{position}` for the axis' own, `{si_position}` for that of SI.
    pub unit: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// A truth value, published as Boolean.
    pub boolean: bool,
}

impl Input {
    /// The signal path.
    pub const PATH: Self = Self { name: "u", source: Source::Path, at_rest: true };

    /// The signal paths of all coupled axes.
    pub const EACH_PATH: Self = Self { name: "x", source: Source::EachPath, at_rest: true };

    /// The load force of the axis, in N.
    pub const FORCE: Self = Self { name: "force", source: Source::Axis("force"), at_rest: true };

    /// The temperature of the surroundings, in K.
    pub const TEMPERATURE: Self =
        Self { name: "temperature", source: Source::System("temperature"), at_rest: true };

    /// A port that reads a signal of the axis, and acts on the outputs at rest as well.
    #[must_use]
    pub const fn axis_at_rest(name: &'static str) -> Self {
        Self { name, source: Source::Axis(name), at_rest: true }
    }

    /// Ports that read a signal of every coupled axis.
    #[must_use]
    pub const fn each(name: &'static str) -> Self {
        Self { name, source: Source::Each(name), at_rest: true }
    }

    /// A port that reads an input of the axis, and has no effect on the outputs at rest.
    #[must_use]
    pub const fn axis(name: &'static str) -> Self {
        Self { name, source: Source::Axis(name), at_rest: false }
    }

    /// A port that reads an input of the whole system, and has no effect on the outputs at rest.
    #[must_use]
    pub const fn system(name: &'static str) -> Self {
        Self { name, source: Source::System(name), at_rest: false }
    }
}

impl Output {
    /// The signal path.
    pub const PATH: Self = Self { name: "y", published: None };

    /// An output that is also an output of the FMU.
    #[must_use]
    pub const fn published(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        boolean: bool,
    ) -> Self {
        Self { name, published: Some(Published { unit, description, boolean }) }
    }
}

/// Everything that is said about a component once; variables, blueprint keys and checks, model
/// descriptions, fit bounds and docs come from it.
#[derive(Clone, Copy, Debug)]
pub struct Declaration {
    /// The blueprint's `type`, as in `prandtl-ishlinskii`.
    pub kind: &'static str,
    /// Instance name where the blueprint gives none, as in `hysteresis`.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// The declaration's governing equation in plain text.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub reference: &'static str,
    /// Stage on the signal path.
    pub stage: Stage,
    /// What the declaration does to the path's kind of signal.
    pub conversion: Conversion,
    /// The effect that it models; such a component can be switched off (`x.enabled`).
    pub effect: Option<&'static Effect>,
    /// Input ports.
    pub inputs: &'static [Input],
    /// Output ports; the first is the signal path.
    pub outputs: &'static [Output],
    /// Structural settings.
    pub structure: &'static [Structural],
    /// Parameters, in the order of the slices that [`Component::prepare`] sees.
    pub parameters: &'static [Quantity],
}

impl Declaration {
    /// Whether a blueprint or a start value may switch it off: it models an effect and leaves the
    /// kind of signal as it is.
    #[must_use]
    pub fn can_be_disabled(&self) -> bool {
        self.effect.is_some() && matches!(self.conversion, Conversion::None)
    }

    /// Whether it couples axes: it stands in a `[[coupling]]` section, not on an axis.
    #[must_use]
    pub fn is_coupling(&self) -> bool {
        self.inputs.iter().any(|port| matches!(port.source, Source::EachPath))
    }

    /// Fewest axes that it couples: two, where its first setting, the number of axes, says nothing else.
    #[must_use]
    pub fn least_axes(&self) -> usize {
        self.structure.first().map_or(2, |axes| axes.min as usize)
    }

    /// Most axes that it can couple: as many as its ports and its first setting, the number of axes,
    /// allow.
    #[must_use]
    pub fn most_axes(&self) -> usize {
        let each = |port: &&Input| matches!(port.source, Source::EachPath | Source::Each(_));
        let ports = MAX_PORTS / self.inputs.iter().filter(each).count().max(1);
        self.structure.first().map_or(ports, |axes| ports.min(axes.max as usize))
    }

    /// The length of parameter number `index` under this structure.
    #[must_use]
    pub fn length(&self, index: usize, structure: &[f64]) -> usize {
        match self.parameters.get(index).map(|q| q.shape) {
            Some(crate::Shape::Scalar) => 1,
            Some(crate::Shape::Array(by)) => structure.get(by).map_or(0, |n| *n as usize),
            None => 0,
        }
    }

    /// The values of the first quantity with this role among those of the whole component.
    #[must_use]
    pub fn values_of<'a>(
        &self,
        role: Role,
        structure: &[f64],
        parameters: &'a [f64],
    ) -> Option<&'a [f64]> {
        let index = self.parameters.iter().position(|q| q.role == Some(role))?;
        let first: usize = (0..index).map(|k| self.length(k, structure)).sum();
        parameters.get(first..first + self.length(index, structure))
    }

    /// Whether it is one linear mode: frequency, damping, gain and nothing else.
    #[must_use]
    pub fn is_mode(&self) -> bool {
        self.conversion == Conversion::None
            && matches!(self.parameters, [f, d, g]
                if [f.role, d.role, g.role]
                    == [Some(Role::Frequency), Some(Role::Damping), Some(Role::Gain)])
    }

    /// Number of parameter values under this structure.
    #[must_use]
    pub fn parameter_count(&self, structure: &[f64]) -> usize {
        (0..self.parameters.len()).map(|i| self.length(i, structure)).sum()
    }
}

/// What a component may lack that another component has beside all that the first one does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extension {
    /// An actuator: plays.
    Plays,
    /// An actuator: thresholds that grow with the command's rate.
    Rate,
    /// An actuator: memory that lags behind the command.
    Lag,
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

    /// Whether a step is `y = gain·u + offset` with its two coefficients, `gain` and `offset`, one input and one
    /// output, and nothing else. A chain of nothing else computes them in place, without calls.
    fn is_affine(&self) -> bool {
        false
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

    /// Advances by one period with the inputs held over it, and writes the outputs at its end.
    fn step(
        &self,
        coefficients: &[f64],
        state: &mut [f64],
        tick: Tick,
        inputs: &[f64],
        outputs: &mut [f64],
    );

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

    /// As [`step_within`](Self::step_within), for an instance with one input, whose signal is given,
    /// and one output, whose signal is returned.
    #[cfg(not(target_family = "wasm"))]
    #[doc(hidden)]
    fn step_straight(&self, wiring: &Wiring, cells: &mut [f64], tick: &Tick, input: f64) -> f64 {
        wiring.apply_straight(cells, input, |coefficients, state, inputs, outputs| {
            self.step(coefficients, state, *tick, inputs, outputs);
        })
    }
}

/// The same once for all components: in a source-code FMU each copy is C that is compiled.
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
