//! The model as it came, as a chain with places where effects go in.

pub(crate) mod compose;
pub(crate) mod coupling;

use std::collections::BTreeMap;

use data::CheckedBlueprint;
use model::{Conversion, Declaration, NodeSpec, Source, Stage, Unit, unit_on_axis};
use surround::Memory;

use self::compose::Composer;
use self::coupling::{couplings_of, motion_text};
use crate::black_box::BlackBox;
use crate::chain::{self, Chain, ComponentNode, Front, Joint, Node};
use crate::error::Error;
use crate::formula::{Formula, Slot};
use crate::request::{Deviation, Tolerance};
use crate::thresholds::base::Thresholds;

/// A parameter of the model that may be off.
#[derive(Clone, Debug)]
pub(crate) struct BaseParameter {
    pub(crate) name: String,
    pub(crate) unit: String,
    /// Node that it belongs to.
    pub(crate) node: usize,
    /// Indices in the node's values, with the deviation of each in SI.
    pub(crate) indices: Vec<(usize, f64)>,
    /// Nodes behind whose values move with it: node, index, deviation in SI.
    pub(crate) also: Vec<(usize, usize, f64)>,
    /// Value in its own unit (of an array's group: the first).
    pub(crate) value: f64,
    /// One standard deviation in its own unit.
    pub(crate) deviation: f64,
    /// Whether a tolerance says so; else it only moves where an effect releases it.
    pub(crate) has_tolerance: bool,
    /// The effect that stands for it beyond its tolerance.
    pub(crate) effect: Option<&'static str>,
}

/// Where a node stands in a blueprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Standing {
    /// Number of the axis' component; of a coupling: of the one behind it.
    pub(crate) place: usize,
    /// Number of the coupling, where the node is one.
    pub(crate) coupling: Option<usize>,
}

/// Which part of an axis a chain stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// From the command to the reading.
    Axis,
    /// From the command to the motion in front of couplings, which is worked out of the readings of several axes: no
    /// sensor is its own.
    Motion,
    /// From the command to the path in front of the coupling of this number.
    Front(usize),
    /// What a sensor makes of the position that the model gives it: components from this number on.
    Reading(usize),
}

/// What another reading shows of the model that both share.
#[derive(Clone, Debug)]
pub(crate) struct Hint {
    /// Coordinates of parameters of the model, by name.
    pub(crate) released: Vec<(String, f64)>,
    /// Frequency of a further mode in Hz.
    pub(crate) frequency: Option<f64>,
}

/// The model as it came.
#[derive(Clone)]
pub(crate) struct Base {
    pub(crate) nodes: Vec<Node>,
    pub(crate) parameters: Vec<BaseParameter>,
    /// Node before which each slot's effects go in.
    pub(crate) slots: BTreeMap<Slot, usize>,
    /// Node of the actuator: effects of the actuator read its input.
    pub(crate) actuator: usize,
    /// Node of the first mode.
    pub(crate) mode: Option<usize>,
    /// Where each node stands in the blueprint.
    pub(crate) components: Vec<Standing>,
    /// Plays of the model.
    pub(crate) memory: Option<Memory>,
    pub(crate) gain_tolerance: f64,
    pub(crate) is_white: bool,
    /// Length in s of a row, and the steps of the grid in it, where readings are late by a part of it.
    pub(crate) late: Option<(f64, usize)>,
    /// Which part of an axis it is.
    pub(crate) part: Part,
    /// What other readings of the same coupling show of it: where a search may start.
    pub(crate) hints: Vec<Hint>,
}

impl Base {
    /// A model of this part of an axis with nothing in it.
    pub(crate) fn empty(part: Part, gain_tolerance: f64) -> Self {
        Self {
            nodes: Vec::new(),
            parameters: Vec::new(),
            slots: BTreeMap::new(),
            actuator: 0,
            mode: None,
            components: Vec::new(),
            memory: None,
            gain_tolerance,
            is_white: false,
            late: None,
            part,
            hints: Vec::new(),
        }
    }

    /// The FMUs among the nodes.
    pub(crate) fn black_boxes(&self) -> Vec<BlackBox> {
        let boxes = self.nodes.iter().filter_map(|node| match node {
            Node::BlackBox(fmu) => Some(fmu.clone()),
            _ => None,
        });
        boxes.collect()
    }

    /// The chain of one axis of a blueprint, with its number from 1: this part of it.
    pub(crate) fn white(
        blueprint: &CheckedBlueprint,
        (number, part): (usize, Part),
        tolerances: &[Tolerance],
        gain_tolerance: f64,
    ) -> Result<Self, Error> {
        let name = &blueprint.spec().name;
        let unknown = || Error::Model {
            model: name.clone(),
            message: format!("has no axis {number}; choose one of its outputs"),
        };
        let axis = blueprint.spec().axes.get(number - 1).ok_or_else(unknown)?;
        let given_axis = blueprint.blueprint().axes.get(number - 1).ok_or_else(unknown)?;
        let mut base = Self { is_white: true, ..Self::empty(part, gain_tolerance) };
        let mut series: Vec<(Standing, &NodeSpec, &data::ComponentBlueprint)> = Vec::new();
        for (place, (spec, messages)) in
            axis.components.iter().zip(&given_axis.components).enumerate()
        {
            series.push((Standing { place, coupling: None }, spec, messages));
        }
        series.extend(couplings_of(blueprint, (number, part)));
        match part {
            Part::Reading(from) => {
                series.retain(|(at, ..)| at.place >= from && at.coupling.is_none());
            }
            Part::Front(coupling) => {
                let coupling = &blueprint.spec().connections.couplings[coupling];
                let end = blueprint.before_coupling(coupling, number - 1);
                series.retain(|(at, ..)| at.place < end);
            }
            Part::Axis | Part::Motion => {}
        }
        // A coupling stands in front of the component of its number; the sort keeps its place.
        series.sort_by_key(|(at, ..)| (at.place, at.coupling.is_none()));
        let mut stages = Vec::new();
        for (standing, spec, messages) in series {
            let declaration = spec.component.declaration();
            if is_noise(declaration) || !spec.enabled {
                continue;
            }
            let couplings = &blueprint.spec().connections.couplings;
            let joint = standing.coupling.filter(|k| couplings[*k].axes.len() > 1);
            if !(declaration.inputs.len() == 1 || reads_command(declaration)) {
                let reason = format!(
                    "axis[{number}].{} ({}) reads other signals than its axis' own",
                    spec.name, declaration.kind
                );
                return Err(Error::Joined { model: name.clone(), reason });
            }
            if declaration.conversion == Conversion::CommandToPosition {
                base.actuator = base.nodes.len();
            }
            stages.push(declaration.stage);
            base.components.push(standing);
            let path = match standing.coupling {
                None => format!("axis[{number}].{}", spec.name),
                Some(_) => format!("coupling.{}", spec.name),
            };
            let position_unit = match part {
                Part::Motion => motion_text(blueprint, number - 1),
                _ => &axis.position_unit,
            };
            let units = (axis.command_unit.as_str(), position_unit);
            let values = in_si(units, spec);
            let joint =
                joint.map(|k| coupling::joint(blueprint, (k, number - 1), &values)).transpose()?;
            base.component(units, &path, (spec, &values), messages, tolerances, joint);
        }
        base.place_slots(&stages);
        Ok(base)
    }

    fn place_slots(&mut self, stages: &[Stage]) {
        let count = stages.len();
        let first = |is: &dyn Fn(Stage) -> bool| stages.iter().position(|s| is(*s));
        let actuator = self.actuator;
        let amplifier = first(&|s| s > Stage::Timing).unwrap_or(count).min(actuator);
        let mechanics = first(&|s| s > Stage::Actuator).unwrap_or(count).max(actuator + 1);
        let sensor = first(&|s| s >= Stage::Sensor).unwrap_or(count).max(mechanics);
        self.slots = BTreeMap::from([
            (Slot::Command, 0),
            (Slot::Amplifier, amplifier),
            (Slot::BeforeActuator, actuator),
            (Slot::AfterActuator, (actuator + 1).min(count)),
            (Slot::BeforeMechanics, mechanics.min(count)),
            (Slot::AfterMechanics, sensor.min(count)),
            (Slot::Reading, count),
        ]);
    }

    fn component(
        &mut self,
        (command_unit, position_unit): (&str, &str),
        path: &str,
        (spec, values): (&NodeSpec, &[f64]),
        messages: &data::ComponentBlueprint,
        tolerances: &[Tolerance],
        joint: Option<Joint>,
    ) {
        let declaration = spec.component.declaration();
        let node = self.nodes.len();
        let takes = joint.as_ref().map(|joint| &joint.takes[..]);
        let mut at = 0;
        for (index, quantity) in declaration.parameters.iter().enumerate() {
            let text = unit_on_axis(quantity.unit, command_unit, position_unit);
            let unit = Unit::parse(&text).unwrap_or(Unit::ONE);
            let length = declaration.length(index, &spec.structure);
            let own = spec.values.get(at..at + length).unwrap_or_default();
            if quantity.fit {
                let path = format!("{path}.{}", quantity.name);
                let relative = messages.tolerance.get(quantity.name).copied();
                let effect = quantity.releases.map(|effect| effect.name);
                let place =
                    Place { node, path: &path, at, unit: &text, factor: unit.factor, takes };
                self.quantity(&place, own, relative, effect, tolerances);
            }
            at += length;
        }
        if declaration.is_mode() && self.mode.is_none() {
            self.mode = Some(node);
        }
        if declaration.conversion == Conversion::CommandToPosition {
            self.memory = memory_of(spec, values);
        }
        self.nodes.push(match joint {
            Some(joint) => Node::Joint(joint),
            None => {
                let (component, structure) = (spec.component.clone(), spec.structure.clone());
                let own = ComponentNode::new(component, structure, values.to_vec());
                let reads_command = reads_command(declaration);
                Node::Component(ComponentNode { reads_command, ..own })
            }
        });
    }

    /// One quantity: a scalar, or the elements of an array that are not zero.
    fn quantity(
        &mut self,
        place: &Place<'_>,
        own: &[f64],
        relative: Option<f64>,
        effect: Option<&'static str>,
        tolerances: &[Tolerance],
    ) {
        let is_live = |k: &usize| own[*k] != 0.0 && place.index(*k).is_some();
        let live: Vec<usize> = (0..own.len()).filter(is_live).collect();
        let groups = live.len().min(Thresholds::MOST_OF_ARRAY);
        for g in 0..groups {
            let members = &live[g * live.len() / groups..(g + 1) * live.len() / groups];
            let Some(&first) = members.first() else { continue };
            let name = if own.len() == 1 {
                place.path.to_owned()
            } else {
                format!("{}[{}]", place.path, first + 1)
            };
            let (tolerance, has_tolerance) = tolerance(&name, own[first], relative, tolerances);
            let deviation = |k: usize| tolerance * own[k] / own[first] * place.factor;
            let indices =
                members.iter().filter_map(|k| Some((place.index(*k)?, deviation(*k)))).collect();
            self.parameters.push(BaseParameter {
                name,
                unit: place.unit.to_owned(),
                node: place.node,
                indices,
                also: Vec::new(),
                value: own[first],
                deviation: tolerance,
                has_tolerance,
                effect,
            });
        }
    }

    /// Whether a component behind the first of an axis reads its command.
    pub(crate) fn reads_command(&self) -> bool {
        self.nodes.iter().any(|node| matches!(node, Node::Component(c) if c.reads_command))
    }

    /// What a sensor makes of the position that the model gives it, which takes the place of the command.
    /// Its axis has `from` components, which give that position.
    pub(crate) fn reading(from: usize, gain_tolerance: f64) -> Self {
        let slots = BTreeMap::from([(Slot::AfterMechanics, 0), (Slot::Reading, 0)]);
        Self { slots, ..Self::empty(Part::Reading(from), gain_tolerance) }
    }

    /// Whether inputs beside the command act on it as they are logged.
    pub(crate) fn has_other_inputs(&self) -> bool {
        (!self.is_white && self.part == Part::Axis) || self.joint().is_some()
    }

    /// The coupling of several axes behind its path.
    pub(crate) fn joint(&self) -> Option<&Joint> {
        chain::joint(&self.nodes).map(|(_, joint)| joint)
    }

    /// The model with other fronts of some of the other axes.
    pub(crate) fn with_fronts(&self, fronts: &BTreeMap<usize, Front>) -> Self {
        let mut base = self.clone();
        for node in &mut base.nodes {
            if let Node::Joint(joint) = node {
                *joint = joint.with_fronts(fronts);
            }
        }
        base
    }

    /// What is before the actuator, for a column that reads the command there.
    pub(crate) fn before_actuator(&self) -> Self {
        let end = self.actuator;
        Self {
            nodes: self.nodes[..end].to_vec(),
            parameters: self.parameters.iter().filter(|p| p.node < end).cloned().collect(),
            slots: self
                .slots
                .iter()
                .filter(|s| *s.0 < Slot::AfterActuator)
                .map(|(s, k)| (*s, *k))
                .collect(),
            actuator: end,
            mode: None,
            memory: None,
            // All components: what goes in last goes in before the actuator.
            ..self.clone()
        }
    }

    /// The actuator and what is behind it, driven by what the column before it reads.
    pub(crate) fn behind_actuator(&self) -> Self {
        let first = self.actuator;
        let moved = |p: &BaseParameter| BaseParameter { node: p.node - first, ..p.clone() };
        Self {
            nodes: self.nodes[first..].to_vec(),
            parameters: self.parameters.iter().filter(|p| p.node >= first).map(moved).collect(),
            slots: self
                .slots
                .iter()
                .filter(|s| *s.0 >= Slot::BeforeActuator)
                .map(|(s, k)| (*s, *k - first))
                .collect(),
            actuator: 0,
            mode: self.mode.and_then(|k| k.checked_sub(first)),
            components: self.components[first..].to_vec(),
            ..self.clone()
        }
    }

    /// Frequency of the first mode in Hz.
    pub(crate) fn resonance(&self) -> Option<f64> {
        self.mode_values().map(|(frequency, _)| frequency)
    }

    /// Frequency in Hz and damping of the first mode.
    pub(crate) fn mode_values(&self) -> Option<(f64, f64)> {
        match self.nodes.get(self.mode?)? {
            Node::Component(mode) => Some((*mode.values.first()?, *mode.values.get(1)?)),
            _ => None,
        }
    }

    /// Frequency in Hz and damping of the first mode in a chain of this model, at these coordinates.
    pub(crate) fn mode_in(&self, chain: &Chain, theta: &[f64]) -> Option<(f64, f64)> {
        let (frequency, damping) = self.mode_values()?;
        let node = self.mode?;
        let mut at = [frequency, damping];
        for p in &self.parameters {
            let Some(q) = chain.own(&p.name).and_then(|k| theta.get(k)) else { continue };
            for (_, index, deviation) in p.also.iter().filter(|(k, ..)| *k == node) {
                at[*index] += deviation * q;
            }
        }
        Some((at[0], at[1]))
    }

    /// The chain with these effects in place.
    pub(crate) fn compose(&self, effects: &[&Formula]) -> Chain {
        Composer::compose(self, effects)
    }
}

/// Whether a component is noise, which the diagnosis does not simulate.
pub(crate) fn is_noise(declaration: &Declaration) -> bool {
    declaration.effect.is_some_and(|e| matches!(e.name, "sensor_noise" | "floor_vibration"))
}

/// Where a quantity is.
struct Place<'a> {
    node: usize,
    path: &'a str,
    at: usize,
    unit: &'a str,
    factor: f64,
    /// For each value of the node the number of the component's value that it is, where they are not the same.
    takes: Option<&'a [usize]>,
}

impl Place<'_> {
    /// Where the node has this element.
    fn index(&self, element: usize) -> Option<usize> {
        let own = self.at + element;
        self.takes.map_or(Some(own), |takes| takes.iter().position(|k| *k == own))
    }
}

/// A component's values in SI, on an axis with these units of the command and the position.
pub(crate) fn in_si((command, position): (&str, &str), node: &NodeSpec) -> Vec<f64> {
    let declaration = node.component.declaration();
    let mut values = Vec::with_capacity(node.values.len());
    for (index, quantity) in declaration.parameters.iter().enumerate() {
        let unit =
            Unit::parse(&unit_on_axis(quantity.unit, command, position)).unwrap_or(Unit::ONE);
        let own = values.len()..values.len() + declaration.length(index, &node.structure);
        values.extend(node.values.get(own).unwrap_or_default().iter().map(|v| unit.to_si(*v)));
    }
    values
}

/// One standard deviation in the parameter's unit, and whether anybody said so.
pub(crate) fn tolerance(
    name: &str,
    value: f64,
    relative: Option<f64>,
    tolerances: &[Tolerance],
) -> (f64, bool) {
    let asked = tolerances.iter().rev().find(|t| t.is_for(name)).map(|t| match t.deviation {
        Deviation::Relative(relative) => relative * value.abs(),
        Deviation::Absolute(absolute) => absolute,
    });
    match asked.or(relative.map(|r| r * value.abs())) {
        Some(deviation) if deviation > 0.0 => (deviation, true),
        _ => (Thresholds::FREE_DEVIATION * value.abs(), false),
    }
}

/// Whether a component reads its path and the command of its axis.
fn reads_command(declaration: &Declaration) -> bool {
    matches!(declaration.inputs, [path, other]
        if path.source == Source::Path && other.source == Source::Axis("command"))
}

/// Plays above zero of an actuator with these values in SI.
fn memory_of(spec: &NodeSpec, values: &[f64]) -> Option<Memory> {
    let (mut r, mut w) = (Vec::new(), Vec::new());
    spec.component.plays(&spec.structure, values, &mut |threshold, weight| {
        if threshold > 0.0 && weight > 0.0 {
            r.push(threshold);
            w.push(weight);
        }
    });
    (!r.is_empty()).then_some(Memory { r, w })
}
