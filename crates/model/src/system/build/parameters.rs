//! The parameters of a node: their variables, bounds and seeds.

use alloc::format;
use alloc::vec::Vec;

use super::variables::{enabled_variable, parameter_variable};
use super::{Builder, Site};
use crate::{Declaration, NodeSpec, Quantity, Shape, Variable, Within};

impl Builder<'_> {
    /// The variables of a node's parameters with their values, its switch the last.
    pub(super) fn parameters_of(
        &mut self,
        node: &NodeSpec,
        place: &str,
        site: &Site<'_>,
    ) -> Vec<(Variable, f64)> {
        let units = &site.units;
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
            let bounds = quantity.bounds(&node.structure, site.commands);
            for (k, value) in (1..=length).zip(values.by_ref()) {
                let name = match quantity.shape {
                    Shape::Scalar => format!("{place}.{}", quantity.name),
                    Shape::Array(_) => format!("{place}.{}[{k}]", quantity.name),
                };
                self.check_value(&name, quantity, value, site);
                all.push((parameter_variable(name, quantity, value, units, bounds), value));
            }
        }
        if declaration.can_be_disabled() {
            let value = f64::from(u8::from(node.enabled));
            all.push((enabled_variable(place, declaration, value), value));
        } else if !node.enabled {
            let kind = declaration.kind;
            self.error(place, format!("enabled = false: {kind} cannot be switched off, the chain needs it; leave it out or enable it"));
        }
        all
    }

    /// Bounds that structural settings say are left to the component, which knows the way out.
    fn check_value(&mut self, name: &str, quantity: &Quantity, value: f64, site: &Site<'_>) {
        let unit = site.units.of(quantity.unit);
        let (min, max) = match quantity.within {
            Within::Commands => quantity.bounds(&[], site.commands),
            _ => (quantity.min, quantity.max),
        };
        if !value.is_finite() {
            self.error(name, format!("{value} is not a finite number; give one in {unit}"));
        } else if value < min || value > max {
            self.error(name, format!("{value} {unit} is outside {min} to {max} {unit}"));
        }
    }
}

/// Places of the seeds among the parameter values.
pub(super) fn seeds(declaration: &Declaration, structure: &[f64]) -> Vec<usize> {
    let mut at = 0;
    let mut found = Vec::new();
    for (index, quantity) in declaration.parameters.iter().enumerate() {
        let end = at + declaration.length(index, structure);
        if quantity.is_seed {
            found.extend(at..end);
        }
        at = end;
    }
    found
}
