//! What is declared about a component once: everything that others print, check or ask by name.

use crate::{
    Effect, Input, MAX_PORTS, Output, Phenomenon, Quantity, Role, Shape, Source, Stage, Structural,
};

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
    /// What of the signal path it stands for: its rows in `docs/effects.md`.
    pub phenomena: &'static [&'static Phenomenon],
    /// Input ports.
    pub inputs: &'static [Input],
    /// Output ports; the first is the signal path.
    pub outputs: &'static [Output],
    /// Structural settings.
    pub structure: &'static [Structural],
    /// Parameters, in the order of the slices that [`Component::prepare`](crate::Component::prepare) sees.
    pub parameters: &'static [Quantity],
}

impl Declaration {
    /// The signal path in and out, and nothing else; a declaration takes from it (`..Declaration::PATH`)
    /// what it does not say itself. Texts and stage are each component's own.
    pub const PATH: Self = Self {
        kind: "",
        name: "",
        summary: "",
        equation: "",
        reference: "",
        stage: Stage::Actuator,
        conversion: Conversion::None,
        effect: None,
        phenomena: &[],
        inputs: &[Input::PATH],
        outputs: &[Output::PATH],
        structure: &[],
        parameters: &[],
    };

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
            Some(Shape::Scalar) => 1,
            Some(Shape::Array(by)) => structure.get(by).map_or(0, |n| *n as usize),
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
