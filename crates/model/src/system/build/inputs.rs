//! The inputs of a model: those of its kind, and those that its components ask for.

use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use super::variables::input_variable;
use super::{Builder, Wire};
use crate::quantity::unit_on_axis;
use crate::{
    Causality, DEMANDED_INPUTS, DataType, DemandedInput, Input, Kind, Source, Unit, Variable,
};

impl Builder<'_> {
    pub(super) fn declare_inputs(&mut self) {
        let axes = 0..self.spec.axes.len();
        match self.spec.kind {
            Kind::Plant => {
                for axis in axes {
                    self.axis_input(axis, "command", 0, "Command to the amplifier");
                }
                self.demanded_inputs();
            }
            Kind::Controller => {
                for axis in axes.clone() {
                    self.axis_input(axis, "reference", 0, "Reference position");
                }
                for axis in axes {
                    self.axis_input(axis, "measured", 1, "Position that the sensor reads");
                }
                self.enable_input();
            }
        }
        self.refuse_unread_inputs();
    }

    fn enable_input(&mut self) {
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
        let (min, max) = if is_command { spec.command_range } else { spec.position_range };
        let variable = Variable {
            alias: spec.aliases.get(alias).cloned().flatten(),
            min,
            max,
            ..input_variable(
                format!("{name}[{}]", axis + 1),
                format!("{description}, axis {}", spec.name),
                unit.clone(),
                spec.start,
            )
        };
        let place = variable.name.clone();
        if !spec.start.is_finite() || spec.start < min || spec.start > max {
            self.error(place, format!("start {} is outside {min} to {max}", spec.start));
        }
        let signal = self.input(variable);
        self.ends[axis].signals.push((name, signal));
    }

    /// Declares the inputs that some component reads.
    fn demanded_inputs(&mut self) {
        for demanded in &DEMANDED_INPUTS {
            if demanded.per_axis {
                for axis in 0..self.spec.axes.len() {
                    if self.axis_reads(axis, demanded.name) {
                        let name = format!("{}[{}]", demanded.name, axis + 1);
                        let who = format!(", axis {}", self.spec.axes[axis].name);
                        let signal = self.demanded(demanded, name, &who, Some(axis));
                        self.ends[axis].signals.push((demanded.name, signal));
                    }
                }
            } else if self.system_reads(demanded.name) {
                let signal = self.demanded(demanded, demanded.name.to_string(), "", None);
                self.system_inputs.push((demanded.name, signal));
            }
        }
    }

    fn demanded(
        &mut self,
        demanded: &DemandedInput,
        name: String,
        who: &str,
        axis: Option<usize>,
    ) -> usize {
        let position = axis.map_or("1", |axis| &*self.spec.axes[axis].position_unit);
        let own_text = unit_on_axis(demanded.unit, "1", position);
        let given = self.spec.connections.inputs.iter().find(|input| input.variable == name);
        let (unit, start, alias) = given.map_or_else(
            || (own_text.clone(), demanded.start, None),
            |input| (input.unit.clone(), input.start, input.alias.clone()),
        );
        let own = Unit::parse(&own_text).unwrap_or(Unit::ONE);
        match Unit::parse(&unit) {
            Err(error) => self.error(&name, format!("unit \"{unit}\": {error}")),
            Ok(parsed) if !parsed.is_compatible(&own) => self.error(
                &name,
                format!(
                    "the unit {unit} does not measure the same as {own_text}; give one that does"
                ),
            ),
            Ok(_) => {}
        }
        if !start.is_finite() {
            self.error(&name, format!("start {start} is not a finite number; give one in {unit}"));
        }
        let description = format!("{}{who}", demanded.description);
        self.input(Variable { alias, ..input_variable(name, description, unit, start) })
    }

    /// Whether a component on this axis, or a coupling of it, reads its signal `name`.
    fn axis_reads(&self, axis: usize, name: &str) -> bool {
        let mut own = self.spec.axes[axis].components.iter();
        let own = own.any(|node| {
            let mut inputs = node.component.declaration().inputs.iter();
            inputs.any(|port| {
                matches!(port.source, Source::Axis(n) if n == name)
                    && self.connected(axis, &node.name, port.name).is_none()
            })
        });
        let couplings = &self.spec.connections.couplings;
        let mut shared = couplings.iter().filter(|c| c.axes.contains(&axis)).map(|c| &c.node);
        let shared = shared.any(|node| {
            let mut inputs = node.component.declaration().inputs.iter();
            inputs.any(|port| matches!(port.source, Source::Axis(n) | Source::Each(n) if n == name))
        });
        own || shared || self.is_connected(axis, name)
    }

    /// Whether any component reads the system's input `name`.
    fn system_reads(&self, name: &str) -> bool {
        let reads = |port: &Input| matches!(port.source, Source::System(n) if n == name);
        let own = self.spec.axes.iter().zip(0..).any(|(axis, number)| {
            axis.components.iter().any(|node| {
                let mut inputs = node.component.declaration().inputs.iter();
                inputs.any(|port| {
                    reads(port) && self.connected(number, &node.name, port.name).is_none()
                })
            })
        });
        let mut couplings = self.spec.connections.couplings.iter();
        let shared = couplings.any(|c| c.node.component.declaration().inputs.iter().any(reads));
        own || shared || (0..self.spec.axes.len()).any(|axis| self.is_connected(axis, name))
    }

    fn refuse_unread_inputs(&mut self) {
        let known = |name: &str| self.variables.iter().any(|v| v.name == name);
        let unread = self.spec.connections.inputs.iter().filter(|i| !known(&i.variable));
        let names: Vec<_> = unread.map(|input| input.variable.clone()).collect();
        for name in names {
            self.error(name, "is read by no component; add one that reads it, or leave it out");
        }
    }
}
