//! A coupling with dynamics, as the reading of one axis sees it.
//!
//! The reading of axis i is `y_i = Σ_j W_ij(x_j)` with the path x_j of each axis in front of the coupling and the
//! linear way W_ij from there. The own path is a part of the chain that is fitted; what the others add,
//! `Σ_{j≠i} W_ij(x_j)`, is a signal that changes only with the coupling's own parameters, and is kept.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, PoisonError};

use surround::Span;

use super::{Bench, Chain, ComponentNode, Horizon};
use crate::data_set::DataSet;
use crate::error::Failed;
use crate::parameter::{Link, Parameter};
use crate::thresholds::base::Thresholds;

/// The way of the own path through a coupling, and what the others add.
#[derive(Clone)]
pub(crate) struct Joint {
    /// The way of the own path.
    pub(crate) own: ComponentNode,
    /// For each of its values the number of the coupling's value that it is.
    pub(crate) takes: Vec<usize>,
    /// The coupling's number in the blueprint.
    pub(crate) coupling: usize,
    others: Arc<Others>,
    /// A further mode, where a candidate has one.
    pub(crate) mode: Option<FurtherMode>,
}

/// A further mode of a coupling, with a weight for each path, frequency and damping as parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FurtherMode {
    /// The first of them.
    pub(crate) first: usize,
    /// Whether the own path moves it: then the first weight is that one's.
    pub(crate) by_own: bool,
}

/// What the paths of the other axes add to a reading.
struct Others {
    ways: Vec<OtherWay>,
    /// For each value of a way whether it is the same value of the coupling in all of them.
    is_shared: Vec<bool>,
    kept: Mutex<Vec<Kept>>,
}

/// The way of another axis.
#[derive(Clone)]
pub(crate) struct OtherWay {
    pub(crate) axis: usize,
    /// Number of the axis among the other inputs of the data.
    pub(crate) place: usize,
    pub(crate) front: Front,
    pub(crate) way: ComponentNode,
}

/// The model of an axis up to the coupling.
#[derive(Clone)]
pub(crate) struct Front {
    chain: Chain,
    theta: Vec<f64>,
}

/// The path of each other axis.
type Paths = Arc<Vec<Vec<f64>>>;

/// Signals that were worked out for one set of commands.
struct Kept {
    /// The first of these commands.
    data: Arc<Vec<f64>>,
    paths: Paths,
    sums: Vec<Sum>,
}

/// What the paths of the other axes add.
#[derive(Clone)]
struct Sum {
    /// Values of the first way.
    values: Vec<f64>,
    signal: Arc<Vec<f64>>,
    /// Whether it is worked out anew, and not from another one.
    is_first: bool,
}

impl Joint {
    /// The coupling of this number by the way of the own path and those of the other axes, each with the numbers of the
    /// coupling's values that it takes.
    pub(crate) fn of(
        coupling: usize,
        (own, takes): (ComponentNode, Vec<usize>),
        others: Vec<(OtherWay, Vec<usize>)>,
    ) -> Self {
        let is_shared = |k: usize| {
            others.iter().all(|(_, of_other)| of_other.get(k).is_none_or(|own| *own == takes[k]))
        };
        let is_shared = (0..takes.len()).map(is_shared).collect();
        let ways = others.into_iter().map(|(way, _)| way).collect();
        let others = Arc::new(Others { ways, is_shared, kept: Mutex::default() });
        Self { own, takes, coupling, others, mode: None }
    }

    /// The coupling with other fronts of some of the other axes.
    pub(crate) fn with_fronts(&self, fronts: &BTreeMap<usize, Front>) -> Self {
        let of = |way: &OtherWay| match fronts.get(&way.axis) {
            Some(front) => OtherWay { front: front.clone(), ..way.clone() },
            None => way.clone(),
        };
        let ways = self.others.ways.iter().map(of).collect();
        let is_shared = self.others.is_shared.clone();
        let others = Arc::new(Others { ways, is_shared, kept: Mutex::default() });
        Self { others, ..self.clone() }
    }

    /// The fronts of the other axes.
    pub(crate) fn fronts(&self) -> BTreeMap<usize, Front> {
        self.others.ways.iter().map(|way| (way.axis, way.front.clone())).collect()
    }

    /// Numbers of the other axes, in the order of the weights of a further mode.
    pub(crate) fn other_axes(&self) -> impl Iterator<Item = usize> + '_ {
        self.others.ways.iter().map(|way| way.axis)
    }

    /// Of a further mode the weight of each path, the own one first, then frequency and damping; nothing without one.
    pub(crate) fn mode_values(&self, parameters: &[Parameter], theta: &[f64]) -> Vec<f64> {
        let Some(FurtherMode { first, by_own }) = self.mode else { return Vec::new() };
        let count = usize::from(by_own) + self.others.ways.len() + 2;
        let own = (first..first + count).map(|k| parameters[k].value(theta[k]));
        std::iter::repeat_n(0.0, usize::from(!by_own)).chain(own).collect()
    }

    /// The signal behind the coupling at a point beside the kept one, where its own values alone differ: what changes is
    /// added to the kept signal. False where that is no less work.
    pub(crate) fn beside(
        &self,
        (kept_at, kept): (&[f64], &[f64]),
        (parameters, theta): (&[Parameter], &[f64]),
        (data, horizon): (&DataSet, Horizon),
        x: &[f64],
        out: &mut [f64],
    ) -> Result<bool, Failed> {
        out.copy_from_slice(kept);
        let both = (&self.own.values_at(kept_at)[..], &self.own.values_at(theta)[..]);
        if !self.own.add_change(both, (data, horizon), x, out)? {
            return Ok(false);
        }
        let (_, before) = self.others.of(data, &self.own.links, kept_at)?;
        let (paths, after) = self.others.of(data, &self.own.links, theta)?;
        if !Arc::ptr_eq(&before, &after) {
            let others = before.iter().zip(after.iter());
            out.iter_mut().zip(others).for_each(|(y, (before, after))| *y += after - before);
        }
        let further = [kept_at, theta].map(|theta| self.mode_values(parameters, theta));
        if further[0] != further[1] {
            for (values, sign) in further.iter().zip([-1.0, 1.0]) {
                self.add_mode((values, sign), (data, horizon), (x, &paths), out)?;
            }
        }
        Ok(true)
    }

    /// Adds to `out` what the others and a further mode give, where the own path is `x`.
    pub(crate) fn add(
        &self,
        (parameters, theta): (&[Parameter], &[f64]),
        (data, horizon): (&DataSet, Horizon),
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), Failed> {
        let (paths, sum) = self.others.of(data, &self.own.links, theta)?;
        out.iter_mut().zip(sum.iter()).for_each(|(y, other)| *y += other);
        let values = self.mode_values(parameters, theta);
        self.add_mode((&values, 1.0), (data, horizon), (x, &paths), out)
    }

    /// Adds a multiple of what a further mode of these values gives to `out`, where the paths are these; nothing without
    /// one.
    fn add_mode(
        &self,
        (values, factor): (&[f64], f64),
        (data, horizon): (&DataSet, Horizon),
        (x, others): (&[f64], &[Vec<f64>]),
        out: &mut [f64],
    ) -> Result<(), Failed> {
        let Some((weights, &[frequency, damping])) = values.split_last_chunk() else {
            return Ok(());
        };
        let mut moved: Vec<f64> = x.iter().map(|x| weights[0] * x).collect();
        for (path, weight) in others.iter().zip(&weights[1..]) {
            moved.iter_mut().zip(path).for_each(|(sum, x)| *sum += weight * x);
        }
        let mode = ComponentNode::mode(frequency, damping);
        let mut of_mode = vec![0.0; moved.len()];
        mode.run_records(&[], (data, horizon), &moved, &mut of_mode)?;
        out.iter_mut().zip(of_mode).for_each(|(y, mode)| *y += factor * mode);
        Ok(())
    }
}

impl Others {
    /// The paths of the others, and the sum of what they add.
    fn of(
        &self,
        data: &DataSet,
        links: &[Link],
        theta: &[f64],
    ) -> Result<(Paths, Arc<Vec<f64>>), Failed> {
        let Some(commands) = data.others.first() else { return Err(Failed) };
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let links: Vec<Link> = links.iter().filter(|l| self.is_shared[l.index]).cloned().collect();
        let moved = |way: &OtherWay| ComponentNode { links: links.clone(), ..way.way.clone() };
        let key = self.ways.first().map_or_else(Vec::new, |way| moved(way).values_at(theta));
        let known = lock().iter().find(|kept| Arc::ptr_eq(&kept.data, commands)).map(|kept| {
            let sum = kept.sums.iter().find(|sum| sum.values == key).cloned();
            let first = kept.sums.iter().rfind(|sum| sum.is_first).cloned();
            (Arc::clone(&kept.paths), sum, first)
        });
        let (paths, first) = match known {
            Some((paths, Some(sum), _)) => return Ok((paths, sum.signal)),
            Some((paths, None, first)) => (paths, first),
            None => {
                let all = self.ways.iter().map(|way| way.front.path(data, way.place));
                (Arc::new(all.collect::<Result<Vec<_>, _>>()?), None)
            }
        };
        let records = (data, Horizon::All);
        let mut signal = first.as_ref().map_or_else(Vec::new, |first| first.signal.to_vec());
        let mut is_first = first.is_none();
        if let Some(first) = first {
            for (way, path) in self.ways.iter().zip(paths.iter()) {
                let after = moved(way).values_at(theta);
                let mut before = after.clone();
                let values = before.iter_mut().zip(&first.values).zip(&self.is_shared);
                values.filter(|(_, shared)| **shared).for_each(|((own, value), _)| *own = *value);
                let change = (&before[..], &after[..]);
                is_first = !way.way.add_change(change, records, path, &mut signal)?;
                if is_first {
                    break;
                }
            }
        }
        if is_first {
            signal = vec![0.0; data.command.len()];
            let mut own = vec![0.0; data.command.len()];
            for (way, path) in self.ways.iter().zip(paths.iter()) {
                moved(way).run_records(theta, records, path, &mut own)?;
                signal.iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
            }
        }
        let signal = Arc::new(signal);
        let mut all = lock();
        let at = all.iter().position(|kept| Arc::ptr_eq(&kept.data, commands));
        let at = at.unwrap_or_else(|| {
            if all.len() >= Thresholds::COMMANDS_KEPT {
                all.remove(0);
            }
            let data = Arc::clone(commands);
            all.push(Kept { data, paths: Arc::clone(&paths), sums: Vec::new() });
            all.len() - 1
        });
        let sums = &mut all[at].sums;
        if sums.len() >= Thresholds::SUMS_KEPT {
            let oldest = sums.iter().position(|sum| sum.is_first == is_first);
            sums.remove(oldest.unwrap_or(0));
        }
        sums.push(Sum { values: key, signal: Arc::clone(&signal), is_first });
        Ok((paths, signal))
    }
}

impl Front {
    pub(crate) fn new(chain: Chain, theta: Vec<f64>) -> Self {
        Self { chain, theta }
    }

    /// The front of an axis whose chain, at these values, is this: what stands before its coupling.
    pub(crate) fn of(chain: &Chain, theta: &[f64]) -> Option<Self> {
        let (end, _) = super::joint(&chain.nodes)?;
        let nodes = chain.nodes[..end].to_vec();
        Some(Self { chain: Chain { nodes, ..chain.clone() }, theta: theta.to_vec() })
    }

    /// Values of the parameters of the chain.
    pub(crate) fn values(&self) -> &[f64] {
        &self.theta
    }

    /// The path in front of the coupling, under the command number `place` of the others.
    fn path(&self, data: &DataSet, place: usize) -> Result<Vec<f64>, Failed> {
        let command = data.others.get(place).ok_or(Failed)?.to_vec();
        let command_span = Span::of(command.iter().copied());
        let own = DataSet { command, command_span, others: Vec::new(), ..data.clone() };
        let count = AtomicU64::new(0);
        let mut bench = Bench::new(&self.chain, &own, Horizon::All, &count);
        bench.keep(&self.theta).map(<[f64]>::to_vec)
    }
}
