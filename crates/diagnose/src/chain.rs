//! A model as a chain of nodes over whole signals.
//!
//! A change of a parameter only runs the nodes from its own on; what comes before is kept. This makes
//! the sensitivities, of which a diagnosis needs thousands, cheap.

mod component_node;
mod joint;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use components::forced::ForcedMode;
use model::ComponentRef;
pub(crate) use surround::Force;
use surround::{Block, Signals, forced_mode, forced_rest};

pub(crate) use self::joint::{Front, FurtherMode, Joint, OtherWay};
use crate::black_box::BlackBox;
use crate::data_set::{DataSet, RecordData};
use crate::error::Failed;
use crate::parameter::{Link, Parameter};
use crate::path_block::PathBlock;
use crate::thresholds::fit::Thresholds;

/// A component of the blueprint.
#[derive(Clone)]
pub(crate) struct ComponentNode {
    pub(crate) component: ComponentRef,
    pub(crate) structure: Vec<f64>,
    /// Parameters in SI.
    pub(crate) values: Vec<f64>,
    pub(crate) links: Vec<Link>,
    /// Whether it reads the command of the axis beside its path.
    pub(crate) reads_command: bool,
}

/// A force on a mode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Acting {
    pub(crate) force: Force,
    /// Number of the first parameter of the force.
    pub(crate) first: usize,
    /// The far end of the range.
    pub(crate) far: f64,
}

/// The path's own command as the auxiliary signal of a block.
pub(crate) const OWN_COMMAND: usize = usize::MAX;

/// One node of a chain.
#[derive(Clone)]
pub(crate) enum Node {
    /// A component of the model.
    Component(ComponentNode),
    /// What has to enter this mode for its input to come out.
    BeforeMode(ComponentNode),
    /// A mode of the model with other forces on it.
    Forced { mode: ComponentNode, forces: Vec<Acting> },
    /// A block of an effect; its parameters begin at `first`. Its drive is that of the actuator, or the command.
    Block { block: PathBlock, takes: Vec<usize>, aux: usize, of_command: bool },
    /// The gain of the output: 1 + deviation·coordinate.
    Gain { parameter: usize, deviation: f64 },
    /// A coupling of several axes, as one reading sees it.
    Joint(Joint),
    /// An FMU.
    BlackBox(BlackBox),
}

impl Node {
    /// The node over other records: an FMU knows their times.
    pub(crate) fn over(&self, data: &DataSet) -> Self {
        match self {
            Self::BlackBox(fmu) => Self::BlackBox(fmu.over(data.hit_times().collect())),
            other => other.clone(),
        }
    }

    /// The coupling of several axes that it is.
    pub(crate) fn joint(&self) -> Option<&Joint> {
        match self {
            Node::Joint(joint) => Some(joint),
            _ => None,
        }
    }
}

/// The coupling of several axes among nodes, with its place.
pub(crate) fn joint(nodes: &[Node]) -> Option<(usize, &Joint)> {
    nodes.iter().enumerate().find_map(|(k, node)| Some((k, node.joint()?)))
}

/// A chain with its parameters.
#[derive(Clone)]
pub(crate) struct Chain {
    pub(crate) nodes: Vec<Node>,
    pub(crate) parameters: Vec<Parameter>,
    /// Edge that drives the actuator (edge k is the input of node k).
    pub(crate) drive: usize,
    /// Parameters of each nuisance term, see [`crate::nuisance`].
    pub(crate) nuisances: Vec<crate::nuisance::Nuisance>,
}

impl Chain {
    /// The chain over other records.
    pub(crate) fn over(&self, data: &DataSet) -> Self {
        let nodes = self.nodes.iter().map(|node| node.over(data)).collect();
        Self { nodes, ..self.clone() }
    }

    /// Number of the model's own parameter of this name.
    pub(crate) fn own(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.is_base && p.name == name)
    }

    /// Values of the parameters at these coordinates.
    pub(crate) fn values(&self, theta: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(theta).map(|(p, q)| p.value(*q)).collect()
    }

    /// Whether an FMU is part of it.
    pub(crate) fn has_black_box(&self) -> bool {
        self.nodes.iter().any(|node| matches!(node, Node::BlackBox(_)))
    }

    /// Numbers of the parameters of its FMU.
    pub(crate) fn of_fmu(&self) -> Vec<usize> {
        let is_fmu = |p: &Parameter| matches!(self.nodes.get(p.node), Some(Node::BlackBox(_)));
        let all = self.parameters.iter().enumerate();
        all.filter(|(_, p)| p.is_base && is_fmu(p)).map(|(k, _)| k).collect()
    }

    /// Penalty of these coordinates by what is known of the parameters.
    pub(crate) fn prior(&self, theta: &[f64]) -> f64 {
        self.parameters.iter().zip(theta).map(|(p, q)| p.prior * q * q).sum()
    }

    /// Whether its FMU has many parameters: each sensitivity to one is a run over all records.
    pub(crate) fn is_costly(&self) -> bool {
        self.of_fmu().len() >= Thresholds::MANY_TUNED
    }

    /// For each parameter the number of the parameter of `from` that it continues: the model's own by
    /// name, those of effects in their order.
    pub(crate) fn origin(&self, from: &Self) -> Vec<Option<usize>> {
        let mut effects =
            from.parameters.iter().enumerate().filter(|(_, p)| !p.is_base).map(|(k, _)| k);
        self.parameters
            .iter()
            .map(|p| {
                if !p.is_base {
                    return effects.next();
                }
                from.own(&p.name)
            })
            .collect()
    }
}

/// How far records are simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Horizon {
    /// To the end of the rows that are fitted.
    Training,
    /// To the end.
    All,
}

/// Simulates one chain over all records and keeps the signals between the nodes.
pub(crate) struct Bench<'a> {
    pub(crate) chain: &'a Chain,
    pub(crate) data: &'a DataSet,
    horizon: Horizon,
    /// Signals behind each node at the kept point.
    edges: Arc<Vec<Vec<f64>>>,
    /// Signals behind each node at a point beside the kept one.
    aside: Vec<Vec<f64>>,
    at: Option<Vec<f64>>,
    count: &'a AtomicU64,
}

impl<'a> Bench<'a> {
    pub(crate) fn new(
        chain: &'a Chain,
        data: &'a DataSet,
        horizon: Horizon,
        count: &'a AtomicU64,
    ) -> Self {
        let signals = || vec![Vec::new(); chain.nodes.len()];
        let edges = Arc::new(signals());
        Self { chain, data, horizon, edges, aside: signals(), at: None, count }
    }

    /// A bench with the same kept point, for points beside it.
    pub(crate) fn at_kept_point(&self) -> Self {
        let aside = vec![Vec::new(); self.chain.nodes.len()];
        Self { edges: Arc::clone(&self.edges), aside, at: self.at.clone(), ..*self }
    }

    /// Simulates at `theta` and keeps the signals; the output signal over the grid.
    pub(crate) fn keep(&mut self, theta: &[f64]) -> Result<&[f64], Failed> {
        let first = match &self.at {
            Some(at) => self.first_changed(at, theta),
            None => 0,
        };
        self.at = None;
        for k in first..self.chain.nodes.len() {
            let mut out = std::mem::take(&mut Arc::make_mut(&mut self.edges)[k]);
            let done = self.run(k, theta, first, false, &mut out);
            Arc::make_mut(&mut self.edges)[k] = out;
            done?;
        }
        self.count.fetch_add(1, Ordering::Relaxed);
        self.at = Some(theta.to_vec());
        Ok(self.edges.last().map_or(&self.data.command, |edge| edge))
    }

    /// Simulates at a point beside the kept one; the output signal over the grid.
    pub(crate) fn beside(&mut self, theta: &[f64]) -> Result<&[f64], Failed> {
        let Some(at) = &self.at else { return Err(Failed) };
        let first = self.first_changed(at, theta);
        for k in first..self.chain.nodes.len() {
            let mut out = std::mem::take(&mut self.aside[k]);
            let done = self.run(k, theta, first, true, &mut out);
            self.aside[k] = out;
            done?;
        }
        self.count.fetch_add(1, Ordering::Relaxed);
        let edges = if first < self.chain.nodes.len() { &self.aside } else { &self.edges };
        Ok(edges.last().map_or(&self.data.command, |edge| edge))
    }

    fn first_changed(&self, at: &[f64], theta: &[f64]) -> usize {
        let changed = self.chain.parameters.iter().zip(at.iter().zip(theta));
        changed
            .filter(|(_, (a, b))| a.to_bits() != b.to_bits())
            .map(|(parameter, _)| parameter.node)
            .min()
            .unwrap_or(self.chain.nodes.len())
    }

    /// The signal on an edge as node `k` sees it.
    fn edge(&self, edge: usize, first: usize, aside: bool) -> &[f64] {
        match edge.checked_sub(1) {
            None => &self.data.command,
            Some(node) if aside && node >= first => &self.aside[node],
            Some(node) => &self.edges[node],
        }
    }

    fn run(
        &self,
        k: usize,
        theta: &[f64],
        first: usize,
        aside: bool,
        out: &mut Vec<f64>,
    ) -> Result<(), Failed> {
        let x = self.edge(k, first, aside);
        let drive = self.edge(self.chain.drive.min(k), first, aside);
        out.resize(self.data.command.len(), 0.0);
        let Some(node) = self.chain.nodes.get(k) else { return Err(Failed) };
        let (parameters, step) = (&self.chain.parameters, self.data.step);
        let records = (self.data, self.horizon);
        if let Node::Component(component) = node {
            return component.run_records(theta, records, x, out);
        }
        if let Node::Joint(joint) = node {
            if let (true, Some(at)) = (aside && first == k, &self.at)
                && joint.beside((at, &self.edges[k]), (parameters, theta), records, x, out)?
            {
                return self.ranges().try_for_each(|(_, range)| ends_finite(&out[range]));
            }
            joint.own.run_records(theta, records, x, out)?;
            joint.add((parameters, theta), records, x, out)?;
            return self.ranges().try_for_each(|(_, range)| ends_finite(&out[range]));
        }
        if let Node::Block { block, takes, aux, of_command } = node {
            let p: Vec<f64> = takes.iter().map(|k| parameters[*k].value(theta[*k])).collect();
            let block = block.prepare(&p, step).map_err(|_| Failed)?;
            let aux = match *aux {
                OWN_COMMAND => &self.data.command,
                aux => self.data.aux.get(aux).map_or(x, |a| &a.hits),
            };
            let drive = if *of_command { &self.data.command } else { drive };
            return self.ranges().try_for_each(|(_, range)| {
                let (x, drive) = (&x[range.clone()], &drive[range.clone()]);
                let (aux, out) = (&aux[range.clone()], &mut out[range]);
                block.run(Signals { x, drive, aux }, out);
                ends_finite(out)
            });
        }
        for (record, range) in self.ranges() {
            let (x, out) = (&x[range.clone()], &mut out[range.clone()]);
            match node {
                Node::Component(_) | Node::Joint(_) | Node::Block { .. } => {}
                Node::BeforeMode(mode) => {
                    let &[frequency, damping, _] = mode.values_at(theta).as_slice() else {
                        return Err(Failed);
                    };
                    let before = Block::BeforeMode { frequency, damping };
                    before.prepare(&[], step).map_err(|_| Failed)?.run(Signals::path(x), out);
                }
                Node::Forced { mode, forces } => {
                    let acting = |a: &Acting| {
                        let p = natural(parameters, theta, a.first, a.force.count());
                        a.force.acting(&p, a.far).map_err(|_| Failed)
                    };
                    let forces = forces.iter().map(acting).collect::<Result<Vec<_>, _>>()?;
                    forced(mode, &forces, theta, x, step, out)?;
                }
                Node::Gain { parameter, deviation } => {
                    let gain = 1.0 + deviation * theta.get(*parameter).copied().unwrap_or(0.0);
                    out.iter_mut().zip(x).for_each(|(y, x)| *y = gain * x);
                }
                Node::BlackBox(fmu) => fmu.run(theta, record, x, out)?,
            }
            ends_finite(out)?;
        }
        Ok(())
    }

    /// The records that are simulated, with their hits.
    fn ranges(&self) -> impl Iterator<Item = (&'a RecordData, Range<usize>)> + use<'a> {
        ranges(self.data, self.horizon)
    }
}

/// The records of a data set that are simulated so far, with their hits.
fn ranges(
    data: &DataSet,
    horizon: Horizon,
) -> impl Iterator<Item = (&RecordData, Range<usize>)> + use<'_> {
    let range = move |record: &RecordData| match horizon {
        Horizon::All => record.hits.clone(),
        Horizon::Training => record.hits.start..record.training_hits_end,
    };
    data.records.iter().map(move |r| (r, range(r))).filter(|(_, range)| !range.is_empty())
}

/// A NaN or an infinity anywhere stays until the end in every recursive block.
fn ends_finite(out: &[f64]) -> Result<(), Failed> {
    match out.last() {
        Some(last) if last.is_finite() => Ok(()),
        _ => Err(Failed),
    }
}

/// Natural values of `count` parameters.
fn natural(parameters: &[Parameter], theta: &[f64], first: usize, count: usize) -> Vec<f64> {
    let range = first..first + count;
    parameters[range.clone()].iter().zip(&theta[range]).map(|(p, q)| p.value(*q)).collect()
}

/// A mode `x″ + 2ζω x′ + ω²·(x + Σ pull(x)) = ω²·gain·u` under forces.
pub(crate) fn forced(
    mode: &ComponentNode,
    forces: &[surround::Acting],
    theta: &[f64],
    u: &[f64],
    step: f64,
    out: &mut [f64],
) -> Result<(), Failed> {
    let &[frequency, damping, gain] = mode.values_at(theta).as_slice() else { return Err(Failed) };
    if !(frequency > 0.0 && damping > 0.0) {
        return Err(Failed);
    }
    let kinds = forces.iter().map(surround::Acting::force);
    let forced = forced_mode((frequency, damping), kinds, step);
    if let &[force] = forces {
        let mut slide = 0.0;
        under(&forced, (gain, u), |at, goes_on| force.pull(at, &mut slide, goes_on), out);
        return Ok(());
    }
    // States of the frictions.
    let mut slides = vec![0.0; forces.len()];
    let pull = |at, goes_on| -> f64 {
        let all = forces.iter().zip(&mut slides);
        all.map(|(force, slide)| force.pull(at, slide, goes_on)).sum()
    };
    under(&forced, (gain, u), pull, out);
    Ok(())
}

/// The motion of a mode under what pulls at it, driven by `gain` times the command from rest under the first one.
fn under(
    mode: &ForcedMode,
    (gain, u): (f64, &[f64]),
    mut pull: impl FnMut((f64, f64, f64), bool) -> f64,
    out: &mut [f64],
) {
    let Some(first) = u.first() else { return };
    let rest = forced_rest(gain * first, |at| pull(at, true));
    let mut state = [rest, 0.0, rest];
    for (n, (y, u)) in out.iter_mut().zip(u).enumerate() {
        *y = if n > 0 { mode.step(gain * u, &mut state, &mut pull) } else { rest };
    }
}
