//! From a specification to a built system: variables, wires, arenas.

mod chains;
mod inputs;
mod parameters;
mod ports;
mod status;
mod variables;

use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use self::variables::{Units, output_variable};
use super::{
    ALWAYS_ON, AxisSpec, BuildError, Kind, Node, NodeSpec, Plan, System, SystemSpec, Wire,
};
use crate::wiring::{FEW_PORTS, Wiring};
use crate::{Context, DataType, Declaration, Output, Source, Unit, Variable, VariableTable};

/// Signal 0 is always zero: ports that have nothing to read read it.
const ZERO: usize = 0;

/// What kind of signal the path carries.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Domain {
    Command,
    Position,
}

pub(super) fn build(spec: &SystemSpec) -> Result<System, Vec<BuildError>> {
    let mut builder = Builder::new(spec);
    builder.check_frame();
    builder.check_ports();
    builder.declare_inputs();
    builder.chains();
    builder.status();
    builder.connect_back();
    builder.finish()
}

/// What can be read of one axis by name.
#[derive(Clone, Default)]
struct Ends {
    /// Inputs, and points of the path as far as it is built.
    signals: Vec<(&'static str, usize)>,
}

/// Points of a plant's path that a component may read before they are computed.
const POINTS: [&str; 3] = ["voltage", "displacement", "position"];

/// Where a node stands.
struct Site<'a> {
    /// The site's axes, as indices.
    axes: &'a [usize],
    /// The signal path on each of them.
    paths: &'a [usize],
    units: Units<'a>,
    /// Least and greatest command there.
    commands: (f64, f64),
}

/// A port that reads a point of the path behind it.
struct ReadBack {
    node: usize,
    slot: usize,
    axis: usize,
    name: &'static str,
}

struct Builder<'a> {
    spec: &'a SystemSpec,
    errors: Vec<BuildError>,
    variables: Vec<Variable>,
    ends: Vec<Ends>,
    system_inputs: Vec<(&'static str, usize)>,
    inputs: Vec<Wire>,
    /// Outputs, declared once all chains are known: axis, variable, signal.
    outputs: Vec<(Variable, usize)>,
    nodes: Vec<Node>,
    /// Parameters' variables of each node, moved behind the outputs at the end.
    parameters: Vec<Vec<(Variable, f64)>>,
    /// For each signal, the input variables that it depends on at rest.
    dependencies: Vec<BTreeSet<u32>>,
    /// For each node, which of its ports act on the outputs at rest.
    at_rest: Vec<Vec<bool>>,
    read_back: Vec<ReadBack>,
    /// Outputs of components by axis and name.
    published: Vec<(usize, &'static str, usize)>,
    coefficients: usize,
    states: usize,
}

impl<'a> Builder<'a> {
    fn new(spec: &'a SystemSpec) -> Self {
        Self {
            spec,
            errors: Vec::new(),
            variables: Vec::new(),
            ends: vec![Ends::default(); spec.axes.len()],
            system_inputs: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            nodes: Vec::new(),
            parameters: Vec::new(),
            dependencies: vec![BTreeSet::new()],
            at_rest: Vec::new(),
            read_back: Vec::new(),
            published: Vec::new(),
            coefficients: 0,
            states: 0,
        }
    }

    fn error(&mut self, place: impl Into<String>, message: impl Into<String>) {
        self.errors.push(BuildError { place: place.into(), message: message.into() });
    }

    fn check_frame(&mut self) {
        let spec = self.spec;
        if !(spec.period.is_finite() && spec.period > 0.0) {
            self.error(
                "step",
                format!("{} s is no internal step; give a positive one", spec.period),
            );
        }
        if spec.axes.is_empty() {
            self.error("axis", "a model has at least one axis; add an [[axis]] section");
        }
        for (axis, number) in spec.axes.iter().zip(1..) {
            let motion = spec.connections.motion_units.get(number - 1).and_then(Option::as_ref);
            let units = [
                ("command", Some(&axis.command_unit)),
                ("position", Some(&axis.position_unit)),
                ("motion", motion),
            ];
            for (key, unit) in units {
                let Some(unit) = unit else { continue };
                if let Err(error) = Unit::parse(unit) {
                    self.error(
                        format!("axis[{number}].{key}"),
                        format!("unit \"{unit}\": {error}"),
                    );
                }
            }
        }
    }

    fn signal(&mut self, depends_on: BTreeSet<u32>) -> usize {
        self.dependencies.push(depends_on);
        self.dependencies.len() - 1
    }

    fn axis_signal(&self, number: usize, name: &str) -> Option<usize> {
        let ends = self.ends.get(number - 1)?;
        ends.signals.iter().find(|(n, _)| *n == name).map(|(_, s)| *s)
    }

    /// Adds a node and returns the signal of its first output.
    fn node(&mut self, node: &NodeSpec, place: String, site: &Site<'_>) -> usize {
        let declaration = node.component.declaration();
        let (signals, at_rest) = self.ports(declaration, &place, site);
        let depends: BTreeSet<u32> = signals
            .iter()
            .zip(&at_rest)
            .filter(|(_, rests)| **rests)
            .flat_map(|(signal, _)| self.dependencies[*signal].iter().copied())
            .collect();
        let first = self.dependencies.len();
        let paths = if declaration.is_coupling() { site.axes.len() } else { 1 };
        for output in declaration.outputs {
            // A coupling has each output once per axis.
            for _ in 1..paths {
                self.signal(depends.clone());
            }
            let signal = self.signal(depends.clone());
            self.publish(output, signal, &place, site);
        }
        let outputs = first..self.dependencies.len();
        let parameters = self.parameters_of(node, &place, site);
        let sizes = node.component.sizes(&node.structure, self.spec.period);
        let coefficients = self.coefficients..self.coefficients + sizes.coefficients;
        let state = self.states..self.states + sizes.states;
        (self.coefficients, self.states) = (coefficients.end, state.end);
        self.parameters.push(parameters);
        self.at_rest.push(at_rest);
        let (input_count, mut inputs) = (signals.len(), [ZERO; FEW_PORTS]);
        inputs.iter_mut().zip(&signals).for_each(|(port, signal)| *port = *signal);
        let many_inputs = if input_count > FEW_PORTS { signals } else { Vec::new() };
        self.nodes.push(Node {
            component: node.component.clone(),
            path: place,
            structure: node.structure.clone(),
            parameters: 0..0,
            seeds: parameters::seeds(declaration, &node.structure),
            enabled: ALWAYS_ON,
            wiring: Wiring {
                coefficients: coefficients.into(),
                state: state.into(),
                inputs,
                many_inputs,
                input_count,
                outputs: outputs.into(),
            },
            paths,
        });
        first
    }

    /// The signals that the input ports of a node read, and which of them act at rest.
    fn ports(
        &mut self,
        declaration: &Declaration,
        place: &str,
        site: &Site<'_>,
    ) -> (Vec<usize>, Vec<bool>) {
        let (mut inputs, mut at_rest) = (Vec::new(), Vec::new());
        let mut add = |signal: usize, rests: bool| {
            inputs.push(signal);
            at_rest.push(rests);
            inputs.len()
        };
        for port in declaration.inputs {
            match port.source {
                Source::Path | Source::EachPath => {
                    for path in site.paths {
                        add(*path, port.at_rest);
                    }
                }
                Source::Axis(name) | Source::Each(name) => {
                    for axis in site.axes {
                        let (axis, name) =
                            self.redirected(place, *axis, port.name).unwrap_or((*axis, name));
                        let found = self.read(axis, name);
                        let slot = add(found.unwrap_or(ZERO), port.at_rest) - 1;
                        if found.is_none() {
                            self.later(declaration, place, axis, name, slot);
                        }
                    }
                }
                Source::System(_)
                    if let [axis] = site.axes
                        && let Some((axis, name)) = self.redirected(place, *axis, port.name) =>
                {
                    let found = self.read(axis, name);
                    let slot = add(found.unwrap_or(ZERO), port.at_rest) - 1;
                    if found.is_none() {
                        self.later(declaration, place, axis, name, slot);
                    }
                }
                Source::System(name) => {
                    let mut known = self.system_inputs.iter();
                    let found = known.find(|(n, _)| *n == name).map(|(_, signal)| *signal);
                    add(found.unwrap_or(ZERO), port.at_rest);
                    if found.is_none() {
                        self.unreadable(declaration, place, name);
                    }
                }
            }
        }
        (inputs, at_rest)
    }

    /// What a port of the component at `place` is connected to.
    fn redirected(&self, place: &str, axis: usize, port: &str) -> Option<(usize, &'static str)> {
        let component = place.strip_prefix(&format!("axis[{}].", axis + 1))?;
        self.connected(axis, component, port)
    }

    /// A signal that is there already: an input, a point of the path, a published output.
    fn read(&self, axis: usize, name: &str) -> Option<usize> {
        let published = || {
            let mut all = self.published.iter();
            all.find(|(at, known, _)| (*at, *known) == (axis, name)).map(|(_, _, signal)| *signal)
        };
        let system = || {
            let mut all = self.system_inputs.iter();
            all.find(|(known, _)| *known == name).map(|(_, signal)| *signal)
        };
        self.axis_signal(axis + 1, name).or_else(published).or_else(system)
    }

    /// Notes that a port of the node that comes next reads a point that is not built yet.
    fn later(
        &mut self,
        declaration: &Declaration,
        place: &str,
        axis: usize,
        name: &'static str,
        slot: usize,
    ) {
        let comes = POINTS.contains(&name) || self.publishes(axis, name);
        if self.spec.kind == Kind::Plant && comes {
            self.read_back.push(ReadBack { node: self.nodes.len(), slot, axis, name });
        } else {
            self.unreadable(declaration, place, name);
        }
    }

    fn unreadable(&mut self, declaration: &Declaration, place: &str, name: &str) {
        let (this, other) = match self.spec.kind {
            Kind::Plant => ("plant", "controller"),
            Kind::Controller => ("controller", "plant"),
        };
        let kind = declaration.kind;
        self.error(
            place,
            format!(
                "{kind} reads \"{name}\", which this kind of model does not have: a {this}; it belongs \
                 in a {other}"
            ),
        );
    }

    fn publish(&mut self, output: &Output, signal: usize, place: &str, site: &Site<'_>) {
        let (Some(published), [axis]) = (output.published, site.axes) else { return };
        let name = format!("{}[{}]", output.name, axis + 1);
        if self.outputs.iter().any(|(v, _)| v.name == name) {
            self.error(place, format!("{name} is published twice; keep one such component"));
        }
        self.published.push((*axis, output.name, signal));
        let unit = site.units.of(published.unit);
        let description = format!("{}, axis {}", published.description, self.spec.axes[*axis].name);
        let mut variable = output_variable(name, description, unit);
        if published.boolean {
            variable.data_type = DataType::Boolean;
            variable.discrete = true;
        }
        self.outputs.push((variable, signal));
    }

    /// Connects the ports that read points behind them, and completes what depends on what at rest.
    fn connect_back(&mut self) {
        for port in &self.read_back {
            // A path without a conversion has no voltage; its end has been refused.
            let found = self.read(port.axis, port.name);
            let ports = self.nodes[port.node].wiring.signals_mut();
            if let Some(slot) = ports.get_mut(port.slot) {
                *slot = found.unwrap_or(ZERO);
            }
        }
        let mut grows = !self.read_back.is_empty();
        while grows {
            grows = false;
            for (node, at_rest) in self.nodes.iter().zip(&self.at_rest) {
                let ports = node.wiring.signals().iter().zip(at_rest);
                let all: BTreeSet<u32> = ports
                    .filter(|(_, rests)| **rests)
                    .flat_map(|(signal, _)| self.dependencies[*signal].iter().copied())
                    .collect();
                for output in node.wiring.outputs.range() {
                    let before = self.dependencies[output].len();
                    self.dependencies[output].extend(&all);
                    grows |= self.dependencies[output].len() > before;
                }
            }
        }
    }

    fn exit(&mut self, axis: &AxisSpec, number: usize, path: usize) {
        let plant = self.spec.kind == Kind::Plant;
        let (name, unit, range, alias, sentence) = if plant {
            let sentence = "Position as the sensor reads it";
            ("position", &axis.position_unit, axis.position_range, 1, sentence)
        } else {
            ("command", &axis.command_unit, axis.command_range, 2, "Command to the amplifier")
        };
        let description = format!("{sentence}, axis {}", axis.name);
        let mut variable = output_variable(format!("{name}[{number}]"), description, unit.clone());
        variable.alias = axis.aliases.get(alias).cloned().flatten();
        (variable.min, variable.max) = range;
        // The main outputs come first, in the order of the axes.
        self.outputs.insert(number - 1, (variable, path));
    }

    fn finish(mut self) -> Result<System, Vec<BuildError>> {
        if !self.errors.is_empty() {
            return Err(self.errors);
        }
        let mut values: Vec<f64> = self.variables.iter().map(|v| v.start.unwrap_or(0.0)).collect();
        let mut outputs = Vec::new();
        for (mut variable, signal) in core::mem::take(&mut self.outputs) {
            variable.initial_dependencies =
                Some(self.dependencies[signal].iter().copied().collect());
            outputs.push(Wire { variable: self.variables.len(), signal, unit: variable.si });
            values.push(0.0);
            self.variables.push(variable);
        }
        let mut widest = 0;
        for (node, parameters) in self.nodes.iter_mut().zip(self.parameters) {
            let start = self.variables.len();
            let switch = node.component.declaration().can_be_disabled();
            let count = parameters.len() - usize::from(switch);
            for (variable, value) in parameters {
                self.variables.push(variable);
                values.push(value);
            }
            node.parameters = start..start + count;
            node.enabled = if switch { start + count } else { ALWAYS_ON };
            widest = widest.max(count);
        }
        let blocks = [
            values.len(),
            values.len() + self.coefficients,
            values.len() + self.coefficients + self.states,
        ];
        // Until here signals, state and coefficients counted from zero each.
        for node in &mut self.nodes {
            let Wiring { coefficients, state, inputs, many_inputs, outputs, .. } = &mut node.wiring;
            coefficients.start += blocks[0];
            state.start += blocks[1];
            outputs.start += blocks[2];
            inputs.iter_mut().chain(many_inputs).for_each(|signal| *signal += blocks[2]);
        }
        for wire in self.inputs.iter_mut().chain(&mut outputs) {
            wire.signal += blocks[2];
        }
        values.resize(blocks[2] + self.dependencies.len() + widest, 0.0);
        let context = Context { cells: values, start: 0.0, index: 0, dirty: true };
        let mut plan = Plan {
            name: self.spec.name.clone(),
            kind: self.spec.kind,
            period: self.spec.period,
            variables: VariableTable::new(self.variables),
            nodes: self.nodes,
            inputs: self.inputs,
            outputs,
            blocks,
            widest,
            reads_back: !self.read_back.is_empty(),
            near: 1e-9 * self.spec.period,
            straight: None,
            affine: Vec::new(),
        };
        plan.straight = plan.straight_chain();
        plan.affine = plan.affine_chain();
        let mut system = System { plan, pristine: context.clone(), context };
        if let Err(error) = system.initialise(0.0) {
            let message = system.explain(&error);
            return Err(vec![BuildError { place: system.plan.name.clone(), message }]);
        }
        system.pristine = system.context.clone();
        Ok(system)
    }
}
