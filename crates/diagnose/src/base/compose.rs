//! Puts the model and effects together to one chain.

use super::{Base, BaseParameter};
use crate::chain::{Acting, Chain, FurtherMode, Node};
use crate::formula::{Formula, Slot, far_end};
use crate::parameter::{Link, Parameter};
use crate::path_block::RecordBlock;
use crate::thresholds::base::Thresholds;

/// Name of the factor of the output.
pub(crate) const GAIN: &str = "output.gain";
/// Name of the time by which each reading is late.
pub(crate) const LATE: &str = "reading.late";

impl BaseParameter {
    /// How far above its value it can go where an effect releases it, in its own unit.
    fn most_added(&self) -> f64 {
        let most = Thresholds::RELEASED_UP * self.value.abs();
        let reach = if self.effect == Some("damping") {
            most.max(Thresholds::RELEASED_DAMPING)
        } else {
            most
        };
        reach - self.value.abs()
    }
}

/// Puts a chain together.
pub(super) struct Composer<'a> {
    base: &'a Base,
    effects: &'a [&'a Formula],
    nodes: Vec<Node>,
    parameters: Vec<Parameter>,
    /// First parameter of each effect.
    first: Vec<usize>,
    /// Chain's parameter of each of the base's parameters.
    of_base: Vec<Option<usize>>,
    drive: usize,
}

impl<'a> Composer<'a> {
    pub(super) fn compose(base: &'a Base, effects: &'a [&'a Formula]) -> Chain {
        let mut composer = Self::new(base, effects);
        for k in 0..=base.nodes.len() {
            if k == base.nodes.len() {
                composer.late();
            }
            composer.insert(k);
            if let Some(node) = base.nodes.get(k) {
                composer.base_node(k, node);
            }
        }
        composer.finish()
    }

    fn new(base: &'a Base, effects: &'a [&'a Formula]) -> Self {
        let mut parameters = Vec::new();
        let mut of_base = Vec::new();
        let released = |k: usize| effects.iter().any(|e| e.releases.contains(&k));
        for (k, p) in base.parameters.iter().enumerate() {
            if !p.has_tolerance && !released(k) {
                of_base.push(None);
                continue;
            }
            of_base.push(Some(parameters.len()));
            let (low, high, prior) = if released(k) {
                (
                    -Thresholds::RELEASED_DOWN * p.value.abs() / p.deviation,
                    p.most_added() / p.deviation,
                    0.0,
                )
            } else {
                (-Thresholds::PRIOR_BOX, Thresholds::PRIOR_BOX, 1.0)
            };
            parameters.push(of_model(&p.name, &p.unit, (low, high), 0.2, prior));
        }
        let bounds = (-Thresholds::PRIOR_BOX, Thresholds::PRIOR_BOX);
        parameters.push(of_model(GAIN, "1", bounds, 0.2, 1.0));
        if let Some((row, _)) = base.late {
            // Not released, and as good as free: a second off would count as one standard deviation.
            parameters.push(of_model(LATE, "s", (0.0, row), 1e-2 * row, 1.0));
        }
        let mut first = Vec::new();
        for effect in effects {
            first.push(parameters.len());
            parameters.extend(effect.parameters.iter().map(|p| p.to_parameter()));
        }
        let nodes = Vec::new();
        Self { base, effects, nodes, parameters, first, of_base, drive: 0 }
    }

    /// The instant at which the reading of each row is taken.
    fn late(&mut self) {
        let own = self.parameters.iter().position(|p| p.is_base && p.name == LATE);
        if let (Some(own), Some((_, parts))) = (own, self.base.late) {
            self.touch(own, 1);
            let block = RecordBlock::Instant { parts, is_late: true };
            let takes = vec![own];
            self.nodes.push(Node::Block { block: block.into(), takes, aux: 0, of_command: false });
        }
    }

    /// Inserts the effects whose slot is before node `k` of the base.
    fn insert(&mut self, k: usize) {
        for slot in Slot::ALL {
            if self.base.slots.get(&slot) != Some(&k) {
                continue;
            }
            for (effect, first) in self.effects.iter().zip(self.first.clone()) {
                for (number, piece) in effect.pieces.iter().enumerate() {
                    if piece.slot != slot {
                        continue;
                    }
                    // Several pieces may share a parameter, which acts from the first of them on.
                    let earlier = &effect.pieces[..number];
                    for own in &piece.takes {
                        if !earlier.iter().any(|other| other.takes.contains(own)) {
                            self.touch(first + own, 1);
                        }
                    }
                    self.nodes.push(Node::Block {
                        block: piece.block.clone(),
                        takes: piece.takes.iter().map(|own| first + own).collect(),
                        aux: piece.aux,
                        of_command: piece.of_command,
                    });
                }
            }
            let has_force = self.effects.iter().any(|effect| effect.force.is_some());
            if slot == Slot::AfterActuator && self.base.is_white && has_force {
                self.gain();
            }
        }
    }

    /// The factor of the output: last of all, but before a force on the mode, as in the model that is handed back.
    /// Behind the force it would be another one.
    fn gain(&mut self) {
        let gain = self.parameters.iter().position(|p| p.name == GAIN).unwrap_or(0);
        self.touch(gain, 1);
        self.nodes.push(Node::Gain { parameter: gain, deviation: self.base.gain_tolerance });
    }

    /// Says that these parameters act from the node that comes next.
    fn touch(&mut self, first: usize, count: usize) {
        let node = self.nodes.len();
        for p in &mut self.parameters[first..first + count] {
            p.node = node;
        }
    }

    fn base_node(&mut self, k: usize, node: &Node) {
        if k == self.base.actuator {
            self.drive = self.nodes.len();
        }
        let here = self.nodes.len();
        let mut links = Vec::new();
        for (p, chain) in self.base.parameters.iter().zip(&self.of_base) {
            let Some(parameter) = *chain else { continue };
            let link = |index, deviation| Link { parameter, index, deviation };
            if p.node == k {
                self.parameters[parameter].node = here;
                links.extend(p.indices.iter().map(|(index, deviation)| link(*index, *deviation)));
            }
            let also = p.also.iter().filter(|(node, ..)| *node == k);
            links.extend(also.map(|(_, index, deviation)| link(*index, *deviation)));
        }
        let mut node = node.clone();
        match &mut node {
            Node::Component(component) | Node::BeforeMode(component) => component.links = links,
            Node::BlackBox(fmu) => fmu.links = links,
            Node::Joint(joint) => {
                joint.own.links = links;
                let all = self.effects.iter().zip(&self.first);
                let mut modes = all.filter_map(|(e, first)| Some((e, *first, e.joint_mode?)));
                if let Some((effect, first, by_own)) = modes.next() {
                    let count = effect.parameters.len();
                    joint.mode = Some(FurtherMode { first, by_own });
                    self.touch(first, count);
                }
            }
            _ => {}
        }
        let acting = |(effect, first): (&&Formula, &usize)| {
            let (force, centre, half) = effect.force?;
            Some(Acting { force, first: *first, far: far_end(centre, half) })
        };
        let forces: Vec<Acting> = self.effects.iter().zip(&self.first).filter_map(acting).collect();
        match node {
            Node::Component(mode) if self.base.mode == Some(k) && !forces.is_empty() => {
                forces.iter().for_each(|a| self.touch(a.first, a.force.count()));
                self.nodes.push(Node::Forced { mode, forces });
            }
            node => self.nodes.push(node),
        }
    }

    fn finish(mut self) -> Chain {
        if !self.nodes.iter().any(|node| matches!(node, Node::Gain { .. })) {
            self.gain();
        }
        let mut nuisances = Vec::new();
        for (effect, first) in self.effects.iter().zip(&self.first) {
            if let Some(nuisance) = &effect.nuisance {
                nuisances.push(nuisance.shifted(*first));
                let end = self.nodes.len();
                let taken = effect.pieces.iter().flat_map(|p| &p.takes);
                let own = taken.max().map_or(0, |last| last + 1);
                for p in &mut self.parameters[first + own..first + effect.parameters.len()] {
                    p.node = end;
                }
            }
        }
        Chain { nodes: self.nodes, parameters: self.parameters, drive: self.drive, nuisances }
    }
}

/// A parameter of the model, whose first node is found later.
fn of_model(name: &str, unit: &str, (low, high): (f64, f64), step: f64, prior: f64) -> Parameter {
    Parameter {
        name: name.to_owned(),
        unit: unit.to_owned(),
        low,
        high,
        log: false,
        step,
        prior,
        node: 0,
        jumps: false,
        is_base: true,
    }
}
