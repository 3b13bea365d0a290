//! The ports of a component: where it reads, what it gives, and the inputs that a plant has on demand.

/// Most input ports of one component.
pub const MAX_PORTS: usize = 64;

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
    /// Whether the outputs at rest depend on it ([`Component::rest`](crate::Component::rest)).
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
