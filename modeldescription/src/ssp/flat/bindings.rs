//! Parameter bindings, resolved to the variables of components.

use std::collections::HashSet;

use super::{FlatStart, Flattener, Linear, Node, joined};
use crate::description::Unit;
use crate::ssp::connector::Source;
use crate::ssp::problem::Format;
use crate::ssp::structure::*;

impl Flattener<'_> {
    /// Bindings of inner levels come first, so that those of outer levels replace them; in one
    /// list, a later binding replaces an earlier one.
    pub(super) fn bindings(&mut self) {
        let structure = self.structure;
        self.bindings_of(&structure.system, "");
        // The last value of a variable counts.
        let mut seen = HashSet::new();
        let starts = std::mem::take(&mut self.flat.starts).into_iter().rev();
        self.flat.starts = starts.filter(|start| seen.insert(start.to.clone())).collect();
        self.flat.starts.reverse();
    }

    fn bindings_of(&mut self, system: &System, path: &str) {
        for element in &system.elements {
            let inner = joined(path, element.name());
            match element {
                Element::System(system) => self.bindings_of(system, &inner),
                Element::Dictionary(_) => {}
                Element::Component(component) => {
                    for binding in &component.bindings {
                        self.apply(binding, &|_, name| vec![(inner.clone(), name.to_owned())]);
                    }
                }
            }
        }
        for binding in &system.bindings {
            self.apply(binding, &|this, name| this.resolve(system, path, name));
        }
    }

    /// The variables that a hierarchical name means: of an element by its name, or those that a
    /// connector of the system feeds.
    fn resolve(&self, system: &System, path: &str, name: &str) -> Vec<Node> {
        for element in &system.elements {
            let rest = name.strip_prefix(element.name()).and_then(|rest| rest.strip_prefix('.'));
            let Some(rest) = rest else { continue };
            let inner = joined(path, element.name());
            return match element {
                Element::Component(_) => vec![(inner, rest.to_owned())],
                Element::Dictionary(_) => Vec::new(),
                Element::System(system) => self.resolve(system, &inner, rest),
            };
        }
        let mut targets = Vec::new();
        self.fed_by(&(path.to_owned(), name.to_owned()), 0, &mut targets);
        targets.sort();
        targets
    }

    /// The component variables that a connector feeds, through any number of systems.
    fn fed_by(&self, node: &Node, depth: usize, targets: &mut Vec<Node>) {
        if depth > self.nodes.len() {
            return;
        }
        for (to, feed) in &self.sources {
            if feed.from != *node {
                continue;
            }
            match self.nodes.get(to) {
                Some(info) if info.is_component => targets.push(to.clone()),
                _ => self.fed_by(to, depth + 1, targets),
            }
        }
    }

    fn apply(&mut self, binding: &Binding, resolve: &dyn Fn(&Self, &str) -> Vec<Node>) {
        let set = binding.values.as_ref();
        let (format, file) = match &binding.source {
            Source::File(file) | Source::InComponent(file) => (Format::Values, file.clone()),
            Source::Inline => (Format::Structure, self.file.to_owned()),
        };
        self.unmatched(binding, &file);
        for Mapped { target, parameter, entry } in binding.mapped() {
            let place = format!("{file}:{}: parameter \"{}\"", parameter.line.0, parameter.name);
            let unit = parameter.unit.as_deref().and_then(|name| {
                let own = set.and_then(|set| set.units.iter().find(|unit| unit.name == name));
                own.cloned().or_else(|| self.unit_of(name, format, &file, parameter.line))
            });
            let enumerations = set.map(|set| set.enumerations.as_slice()).unwrap_or_default();
            let value = self.numbered(&parameter.value, enumerations);
            let (value, way) = way(value, unit, entry);
            let targets = resolve(self, &target);
            if targets.is_empty() {
                let mapped = entry.map_or(String::new(), |_| format!(", mapped to \"{target}\","));
                self.flat.notes.push(format!(
                    "{place}{mapped} is ignored: it reaches no variable of a component"
                ));
            }
            for to in targets {
                let (value, way, place) = (value.clone(), way.clone(), place.clone());
                self.flat.starts.push(FlatStart { to, value, way, place });
            }
        }
    }

    /// Notes what a mapping names that is not there, and parameters that it leaves out.
    fn unmatched(&mut self, binding: &Binding, file: &str) {
        let (Some(set), Some(of)) = (&binding.values, &binding.mapping) else { return };
        let Some(mapping) = &of.mapping else { return };
        let own = match &of.source {
            Source::File(file) | Source::InComponent(file) => file.as_str(),
            Source::Inline => self.file,
        };
        let name = |parameter: &Parameter| format!("{}{}", binding.prefix, parameter.name);
        for entry in &mapping.entries {
            if !set.parameters.iter().any(|parameter| name(parameter) == entry.source) {
                self.flat.notes.push(format!(
                    "{own}:{}: the mapping of \"{}\" is ignored: the parameter set has no such \
                     parameter",
                    entry.line.0, entry.source
                ));
            }
        }
        for parameter in &set.parameters {
            if !mapping.entries.iter().any(|entry| entry.source == name(parameter)) {
                self.flat.notes.push(format!(
                    "{file}:{}: parameter \"{}\" is ignored: the mapping does not name it",
                    parameter.line.0, parameter.name
                ));
            }
        }
    }

    /// Items of an enumeration that is defined here become their numbers.
    fn numbered(&self, value: &ParameterValue, enumerations: &[Enumeration]) -> ParameterValue {
        let ParameterValue::Enumeration(items, Some(name)) = value else { return value.clone() };
        let mut known = enumerations.iter().chain(&self.structure.enumerations);
        let number = |items: &[(String, i64)], item: &String| {
            items.iter().find(|(name, _)| name == item).map(|(_, number)| *number)
        };
        let found = known.find(|enumeration| enumeration.name == *name).and_then(|enumeration| {
            items.iter().map(|item| number(&enumeration.items, item)).collect::<Option<Vec<_>>>()
        });
        found.map_or_else(|| value.clone(), ParameterValue::Integer)
    }
}

/// What a mapping's entry does to a value: maps are applied, linear transformations are kept.
fn way(
    value: ParameterValue,
    unit: Option<Unit>,
    entry: Option<&MappingEntry>,
) -> (ParameterValue, Linear) {
    let mut way = Linear {
        from: unit,
        to: None,
        suppress_unit_conversion: entry.is_some_and(|entry| entry.suppress_unit_conversion),
        transformation: None,
    };
    let value = match (value, entry.and_then(|entry| entry.transformation.as_ref())) {
        (value, Some(Transformation::Linear { factor, offset })) => {
            way.transformation = Some((*factor, *offset));
            value
        }
        (ParameterValue::Boolean(values), Some(Transformation::Boolean(map))) => {
            ParameterValue::Boolean(values.into_iter().map(|value| mapped(value, map)).collect())
        }
        (ParameterValue::Integer(values), Some(Transformation::Integer(map))) => {
            ParameterValue::Integer(values.into_iter().map(|value| mapped(value, map)).collect())
        }
        (ParameterValue::Enumeration(items, name), Some(Transformation::Enumeration(map))) => {
            let items = items.into_iter().map(|item| mapped(item, map)).collect();
            ParameterValue::Enumeration(items, name)
        }
        (value, _) => value,
    };
    (value, way)
}

/// The target of a value; a value that the map does not name stays.
fn mapped<T: PartialEq + Clone>(value: T, map: &[(T, T)]) -> T {
    let found = map.iter().find(|(source, _)| *source == value);
    found.map_or(value, |(_, target)| target.clone())
}
