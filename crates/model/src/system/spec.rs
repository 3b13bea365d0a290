//! What a system is built from, already checked for its words by the blueprint's reader.

use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

use crate::ComponentRef;

/// What a system stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A machine: `command[i]` in, `position[i]` out.
    Plant,
    /// A controller: `reference[i]` and `measured[i]` in, `command[i]` out.
    Controller,
}

/// One instance of a component.
#[derive(Clone)]
pub struct NodeSpec {
    /// The node spec's type.
    pub component: ComponentRef,
    /// The node spec's name on the axis.
    pub name: String,
    /// Structural settings, in the order of the declaration.
    pub structure: Vec<f64>,
    /// Parameters in the units of the declaration (with the axis' own units put in), in its order,
    /// arrays spread out.
    pub values: Vec<f64>,
    /// Whether it acts at the start.
    pub enabled: bool,
}

/// One axis: a chain in the order of the signal path.
#[derive(Clone)]
pub struct AxisSpec {
    /// The user's name, for descriptions.
    pub name: String,
    /// Unit of the command.
    pub command_unit: String,
    /// Unit of the position.
    pub position_unit: String,
    /// Least and greatest command, for the FMU's variables (not a saturation; the limits of a
    /// controller's laws are within it).
    pub command_range: (f64, f64),
    /// Least and greatest position that the axis is made for, for the FMU's variables.
    pub position_range: (f64, f64),
    /// Start values of the inputs: of `command` (plant) or of `reference` and `measured`.
    pub start: f64,
    /// Short names of the inputs and outputs in the order of the variables (`u`, `y`).
    pub aliases: Vec<Option<String>>,
    /// The components.
    pub components: Vec<NodeSpec>,
}

/// A whole plant or controller.
#[derive(Clone)]
pub struct SystemSpec {
    /// Name of the model.
    pub name: String,
    /// Plant or controller.
    pub kind: Kind,
    /// Internal step in s.
    pub period: f64,
    /// The axes.
    pub axes: Vec<AxisSpec>,
    /// What goes beyond chains side by side; the default is nothing.
    pub connections: Connections,
}

/// Couplings between axes, the units that they ask for, inputs on demand, and connected ports.
#[derive(Clone, Default)]
pub struct Connections {
    /// The couplings; those at the same place act in this order.
    pub couplings: Vec<CouplingSpec>,
    /// For each axis the unit of its motion in front of a coupling that converts it (optics); `None`
    /// or missing: the unit of the position.
    pub motion_units: Vec<Option<String>>,
    /// What is said about inputs on demand; one that no component reads is refused.
    pub inputs: Vec<InputSpec>,
    /// Ports that read another signal than the one of their own axis and name.
    pub ports: Vec<PortSpec>,
}

/// A port of a component that reads another signal than its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortSpec {
    /// Axis of the component, as an index from 0.
    pub axis: usize,
    /// Name of the component.
    pub component: String,
    /// Name of its port; not the signal path.
    pub port: String,
    /// Axis of the signal, as an index from 0.
    pub from: usize,
    /// The signal there: `command`, `voltage`, `displacement`, `position`, an input on demand, or an
    /// output that one of its components publishes. It must measure the same as what the port reads.
    pub signal: String,
}

/// One coupling: a component between axes.
#[derive(Clone)]
pub struct CouplingSpec {
    /// The component. Its first structural setting is the number of axes.
    pub node: NodeSpec,
    /// The axes, as indices from 0, in the order of its ports.
    pub axes: Vec<usize>,
    /// The component behind which it stands on every one of these axes; `None`: behind the last one
    /// of the stages up to the mechanics.
    pub after: Option<String>,
}

/// An input on demand ([`DEMANDED_INPUTS`](crate::DEMANDED_INPUTS)) as somebody wants it.
#[derive(Clone, Debug, PartialEq)]
pub struct InputSpec {
    /// Variable, as in `force[2]` or `temperature`.
    pub variable: String,
    /// Short name.
    pub alias: Option<String>,
    /// Unit, of the dimension of the demanded input's.
    pub unit: String,
    /// Start in this unit.
    pub start: f64,
}

/// Why a system cannot be built.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildError {
    /// Place, as in `axis[1].hysteresis.w[3]`.
    pub place: String,
    /// Value, rule and way out.
    pub message: String,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

impl core::error::Error for BuildError {}
