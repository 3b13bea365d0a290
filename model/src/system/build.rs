//! From a specification to a built system: variables, wires, arenas.

use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;

use super::{AxisSpec, BuildError, Kind, Node, NodeSpec, Plan, System, SystemSpec, Wire};
use crate::{
    Causality, Context, Conversion, DataType, Declaration, MAX_PORTS, Quantity, Shape, Source,
    Unit, Variability, Variable, VariableTable,
};

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
    builder.declare_inputs();
    for (axis, number) in spec.axes.iter().zip(1..) {
        builder.chain(axis, number);
    }
    builder.finish()
}

/// The ends of one axis.
#[derive(Clone, Default)]
struct Ends {
    /// External inputs by name: signal and variable.
    inputs: Vec<(&'static str, usize)>,
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
            for (key, unit) in [("command", &axis.command_unit), ("position", &axis.position_unit)]
            {
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

    fn declare_inputs(&mut self) {
        let spec = self.spec;
        match spec.kind {
            Kind::Plant => {
                for axis in 0..spec.axes.len() {
                    self.axis_input(axis, "command", 0, "Command to the amplifier");
                }
            }
            Kind::Controller => {
                for axis in 0..spec.axes.len() {
                    self.axis_input(axis, "reference", 0, "Position that is wanted");
                }
                for axis in 0..spec.axes.len() {
                    self.axis_input(axis, "measured", 1, "Position that the sensor reads");
                }
                let signal = self.input(Variable {
                    name: "enable".to_string(),
                    alias: None,
                    description: "Closes the loop; switching it on is bumpless".to_string(),
                    data_type: DataType::Boolean,
                    unit: String::new(),
                    si: Unit::ONE,
                    causality: Causality::Input,
                    discrete: true,
                    start: Some(1.0),
                    min: 0.0,
                    max: 1.0,
                    fit: false,
                    initial_dependencies: None,
                });
                self.system_inputs.push(("enable", signal));
            }
        }
    }

    fn input(&mut self, variable: Variable) -> usize {
        let index = self.variables.len();
        let unit = variable.si;
        self.variables.push(variable);
        let signal = self.signal(BTreeSet::from([index as u32]));
        self.inputs.push(Wire { variable: index, signal, unit });
        signal
    }

    fn axis_input(&mut self, axis: usize, name: &'static str, alias: usize, description: &str) {
        let spec = &self.spec.axes[axis];
        let is_command = name == "command";
        let unit = if is_command { &spec.command_unit } else { &spec.position_unit };
        let (min, max) =
            if is_command { spec.command_range } else { (f64::NEG_INFINITY, f64::INFINITY) };
        let variable = Variable {
            name: format!("{name}[{}]", axis + 1),
            alias: spec.aliases.get(alias).cloned().flatten(),
            description: format!("{description}, axis {}", spec.name),
            data_type: DataType::Real,
            unit: unit.clone(),
            si: Unit::parse(unit).unwrap_or(Unit::ONE),
            causality: Causality::Input,
            discrete: false,
            start: Some(spec.start),
            min,
            max,
            fit: false,
            initial_dependencies: None,
        };
        let place = variable.name.clone();
        if !spec.start.is_finite() || spec.start < min || spec.start > max {
            self.error(place, format!("start {} is outside {min} to {max}", spec.start));
        }
        let signal = self.input(variable);
        self.ends[axis].inputs.push((name, signal));
    }

    fn chain(&mut self, axis: &AxisSpec, number: usize) {
        let plant = self.spec.kind == Kind::Plant;
        let entry = if plant { "command" } else { "reference" };
        let mut path = self.axis_signal(number, entry).unwrap_or(ZERO);
        let mut domain = if plant { Domain::Command } else { Domain::Position };
        for (at, node) in axis.components.iter().enumerate() {
            let place = format!("axis[{number}].{}", node.name);
            if axis.components[..at].iter().any(|other| other.name == node.name) {
                self.error(
                    &place,
                    "the name is used twice on this axis; give each component its own",
                );
            }
            domain = self.domain_after(domain, node.component.declaration(), &place, &mut path);
            path = self.node(axis, number, node, place, path);
        }
        let wanted = if plant { Domain::Position } else { Domain::Command };
        if domain != wanted {
            let way = if plant {
                "add a component that turns the command into a position (a hysteresis model or \
                 actuator-gain)"
            } else {
                "add a component that gives a command (an inverse model or pid)"
            };
            self.error(
                format!("axis[{number}]"),
                format!("the chain ends with the wrong signal: {way}"),
            );
        }
        self.exit(axis, number, path);
    }

    fn axis_signal(&self, number: usize, name: &str) -> Option<usize> {
        let ends = self.ends.get(number - 1)?;
        ends.inputs.iter().find(|(n, _)| *n == name).map(|(_, s)| *s)
    }

    fn domain_after(
        &mut self,
        domain: Domain,
        declaration: &Declaration,
        place: &str,
        path: &mut usize,
    ) -> Domain {
        match (declaration.conversion, domain) {
            (Conversion::None, _) => domain,
            (Conversion::CommandToPosition, Domain::Command) => Domain::Position,
            (Conversion::PositionToCommand, Domain::Position) => Domain::Command,
            (Conversion::Control, Domain::Position) => {
                *path = ZERO;
                Domain::Command
            }
            (Conversion::Control, Domain::Command) => Domain::Command,
            (Conversion::CommandToPosition, Domain::Position) => {
                let kind = declaration.kind;
                self.error(place, format!("{kind} takes a command, but the signal is a position here; an axis turns one into the other once"));
                domain
            }
            (Conversion::PositionToCommand, Domain::Command) => {
                let kind = declaration.kind;
                self.error(place, format!("{kind} takes a position, but the signal is a command here; an axis turns one into the other once"));
                domain
            }
        }
    }

    /// Adds a node and returns the signal of its first output.
    fn node(
        &mut self,
        axis: &AxisSpec,
        number: usize,
        node: &NodeSpec,
        place: String,
        path: usize,
    ) -> usize {
        let declaration = node.component.declaration();
        let mut inputs = [ZERO; MAX_PORTS];
        let mut depends = BTreeSet::new();
        for (slot, port) in inputs.iter_mut().zip(declaration.inputs) {
            let found = match port.source {
                Source::Path => Some(path),
                Source::Axis(name) => self.axis_signal(number, name),
                Source::System(name) => {
                    self.system_inputs.iter().find(|(n, _)| *n == name).map(|(_, s)| *s)
                }
            };
            match found {
                Some(signal) => {
                    *slot = signal;
                    if port.at_rest {
                        depends.extend(self.dependencies[signal].iter().copied());
                    }
                }
                None => self.error(
                    &place,
                    format!(
                        "{} reads \"{}\", which this kind of model does not have; it belongs in a \
                         controller",
                        declaration.kind, port.name
                    ),
                ),
            }
        }
        let first = self.dependencies.len();
        for output in declaration.outputs {
            let signal = self.signal(depends.clone());
            if let Some(published) = output.published {
                let name = format!("{}[{number}]", output.name);
                if self.outputs.iter().any(|(v, _)| v.name == name) {
                    self.error(
                        &place,
                        format!("{name} is published twice; keep one such component"),
                    );
                }
                let unit = axis_unit(published.unit, axis);
                let description = format!("{}, axis {}", published.description, axis.name);
                let mut variable = output_variable(name, description, unit);
                if published.boolean {
                    variable.data_type = DataType::Boolean;
                    variable.discrete = true;
                }
                self.outputs.push((variable, signal));
            }
        }
        let outputs = first..self.dependencies.len();
        let parameters = self.parameters_of(axis, number, node, &place);
        let sizes = node.component.sizes(&node.structure, self.spec.period);
        let coefficients = self.coefficients..self.coefficients + sizes.coefficients;
        let state = self.states..self.states + sizes.states;
        (self.coefficients, self.states) = (coefficients.end, state.end);
        self.parameters.push(parameters);
        self.nodes.push(Node {
            component: node.component,
            path: place,
            structure: node.structure.clone(),
            parameters: 0..0,
            enabled: None,
            coefficients,
            state,
            inputs,
            input_count: declaration.inputs.len().min(MAX_PORTS),
            outputs,
        });
        first
    }

    fn parameters_of(
        &mut self,
        axis: &AxisSpec,
        number: usize,
        node: &NodeSpec,
        place: &str,
    ) -> Vec<(Variable, f64)> {
        let declaration = node.component.declaration();
        let count = declaration.parameter_count(&node.structure);
        if count != node.values.len() {
            let given = node.values.len();
            self.error(place, format!("{count} parameter values are needed, {given} were given"));
            return Vec::new();
        }
        let mut values = node.values.iter().copied();
        let mut all = Vec::with_capacity(count + 1);
        for (index, quantity) in declaration.parameters.iter().enumerate() {
            let length = declaration.length(index, &node.structure);
            for (k, value) in (1..=length).zip(values.by_ref()) {
                let name = match quantity.shape {
                    Shape::Scalar => format!("{place}.{}", quantity.name),
                    Shape::Array(_) => format!("{place}.{}[{k}]", quantity.name),
                };
                self.check_value(&name, quantity, value, axis);
                all.push((parameter_variable(name, quantity, value, axis), value));
            }
        }
        if declaration.can_be_disabled() {
            let value = f64::from(u8::from(node.enabled));
            all.push((enabled_variable(place, declaration, value), value));
        } else if !node.enabled {
            let kind = declaration.kind;
            self.error(place, format!("enabled = false: {kind} cannot be switched off, the chain needs it; leave it out or enable it"));
        }
        let _ = number;
        all
    }

    fn check_value(&mut self, name: &str, quantity: &Quantity, value: f64, axis: &AxisSpec) {
        let unit = axis_unit(quantity.unit, axis);
        if !value.is_finite() {
            self.error(name, format!("{value} is not a finite number; give one in {unit}"));
        } else if value < quantity.min || value > quantity.max {
            let (min, max) = (quantity.min, quantity.max);
            self.error(name, format!("{value} {unit} is outside {min} to {max} {unit}"));
        }
    }

    fn exit(&mut self, axis: &AxisSpec, number: usize, path: usize) {
        let plant = self.spec.kind == Kind::Plant;
        let (name, unit, alias, sentence) = if plant {
            ("position", &axis.position_unit, 1, "Position as the sensor reads it")
        } else {
            ("command", &axis.command_unit, 2, "Command to the amplifier")
        };
        let description = format!("{sentence}, axis {}", axis.name);
        let mut variable = output_variable(format!("{name}[{number}]"), description, unit.clone());
        variable.alias = axis.aliases.get(alias).cloned().flatten();
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
            node.enabled = switch.then_some(start + count);
            widest = widest.max(count);
        }
        let blocks = [
            values.len(),
            values.len() + self.coefficients,
            values.len() + self.coefficients + self.states,
        ];
        let mut cells = values;
        cells.resize(blocks[2] + self.dependencies.len() + widest, 0.0);
        let context = Context { cells, start: 0.0, index: 0, dirty: true };
        let plan = Plan {
            name: self.spec.name.clone(),
            kind: self.spec.kind,
            period: self.spec.period,
            variables: VariableTable::new(self.variables),
            nodes: self.nodes,
            inputs: self.inputs,
            outputs,
            blocks,
            widest,
        };
        let mut system = System { plan, pristine: context.clone(), context };
        if let Err(error) = system.initialise(0.0) {
            let message = system.explain(&error);
            return Err(vec![BuildError { place: system.plan.name.clone(), message }]);
        }
        system.pristine = system.context.clone();
        Ok(system)
    }
}

fn output_variable(name: String, description: String, unit: String) -> Variable {
    let si = Unit::parse(&unit).unwrap_or(Unit::ONE);
    Variable {
        name,
        alias: None,
        description,
        data_type: DataType::Real,
        unit,
        si,
        causality: Causality::Output,
        discrete: false,
        start: None,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        fit: false,
        initial_dependencies: None,
    }
}

fn parameter_variable(name: String, quantity: &Quantity, value: f64, axis: &AxisSpec) -> Variable {
    let unit = axis_unit(quantity.unit, axis);
    Variable {
        si: Unit::parse(&unit).unwrap_or(Unit::ONE),
        name,
        alias: None,
        description: quantity.description.to_string(),
        data_type: DataType::Real,
        unit,
        causality: match quantity.variability {
            Variability::Fixed => Causality::FixedParameter,
            Variability::Tunable => Causality::TunableParameter,
        },
        discrete: false,
        start: Some(value),
        min: quantity.min,
        max: quantity.max,
        fit: quantity.fit,
        initial_dependencies: None,
    }
}

fn enabled_variable(place: &str, declaration: &Declaration, value: f64) -> Variable {
    Variable {
        name: format!("{place}.enabled"),
        alias: None,
        description: format!("Switches {} on", declaration.kind),
        data_type: DataType::Boolean,
        unit: String::new(),
        si: Unit::ONE,
        causality: Causality::FixedParameter,
        discrete: true,
        start: Some(value),
        min: 0.0,
        max: 1.0,
        fit: false,
        initial_dependencies: None,
    }
}

/// A quantity's unit on this axis: `{command}` and `{position}` replaced, `/1` dropped.
pub(crate) fn axis_unit(unit: &str, axis: &AxisSpec) -> String {
    crate::quantity::unit_on_axis(unit, &axis.command_unit, &axis.position_unit)
}
