//! Axes that a coupling joins, looked at together: what is missing in front of it in one axis moves the readings of all.
//!
//! First each reading is diagnosed with the other axes as the model has them. Of what was found in front of the coupling,
//! the axis is taken over that explains most of the *other* readings; these are diagnosed again with it, and so on, until
//! no axis explains more. Then what one reading shows of the coupling itself is where the search in the others starts.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;

use surround::Block;

use super::{cost, effective, left, shown};
use crate::base::{Base, Hint};
use crate::candidate::{Candidate, carried, has_gap};
use crate::chain::{self, Chain, Front};
use crate::course;
use crate::error::Error;
use crate::formula::Formula;
use crate::gap::Verdict;
use crate::outcome::{Original, Outcome};
use crate::request::Request;
use crate::task::Task;
use crate::thresholds::search::Thresholds;

/// Looks at the readings of coupled axes together; `fresh` are their tasks before any was diagnosed.
///
/// # Errors
/// [`Error::Model`]: a model that cannot be simulated over the logs.
pub(crate) fn together(
    outcomes: &mut [Outcome],
    fresh: &[Option<Task>],
    request: &Request,
    count: &AtomicU64,
) -> Result<(), Error> {
    let coupling = |o: &Outcome| o.task.base.joint().map(|joint| joint.coupling);
    let mut couplings: Vec<usize> = outcomes.iter().filter_map(coupling).collect();
    couplings.sort_unstable();
    couplings.dedup();
    for number in couplings {
        let members: Vec<usize> =
            (0..outcomes.len()).filter(|k| coupling(&outcomes[*k]) == Some(number)).collect();
        let (fronts, searched, moved_by) = Default::default();
        let mut axes =
            Axes { outcomes, fresh, members, fronts, searched, moved_by, request, count };
        axes.in_front()?;
        axes.of_the_coupling()?;
        axes.with_all_fronts()?;
        axes.keep_originals();
    }
    Ok(())
}

/// Readings that one coupling joins.
struct Axes<'a> {
    outcomes: &'a mut [Outcome],
    fresh: &'a [Option<Task>],
    members: Vec<usize>,
    /// What was taken over, by axis.
    fronts: BTreeMap<usize, Front>,
    /// With which values of them each member was searched last; none: with the model as it came.
    searched: BTreeMap<usize, BTreeMap<usize, Vec<f64>>>,
    /// What the first diagnosis of each member had for its model, and the axes that moved it since.
    moved_by: BTreeMap<usize, (Original, Vec<usize>)>,
    request: &'a Request,
    count: &'a AtomicU64,
}

/// What an axis would explain of the other readings.
struct Share {
    member: usize,
    front: Front,
    /// Fall of twice the negative logarithm of the likelihood.
    gain: f64,
    /// The members whose gap it moves.
    moves: Vec<usize>,
}

impl Axes<'_> {
    fn axis(&self, member: usize) -> usize {
        self.outcomes[member].task.axis - 1
    }

    /// What is missing in front of the coupling, axis after axis.
    fn in_front(&mut self) -> Result<(), Error> {
        let mut is_taken = vec![false; self.outcomes.len()];
        for _ in 0..Thresholds::ROUNDS_OF_AXES * self.members.len() {
            let open = |k: &&usize| {
                let o = &self.outcomes[**k];
                has_gap(&o.found.base, o.adequate)
            };
            if self.members.iter().filter(open).count() < 2 {
                break;
            }
            let shares = self.members.iter().filter(|k| !is_taken[**k]);
            let shares = shares.filter_map(|member| self.share(*member));
            let Some(share) = shares.max_by(|a, b| a.gain.total_cmp(&b.gain)) else { break };
            is_taken[share.member] = true;
            let axis = self.axis(share.member);
            self.fronts.insert(axis, share.front);
            for member in share.moves {
                if self.again(member, &[])? {
                    // What it shows of its own axis may be another.
                    is_taken[member] = false;
                    let original = self.moved_by.get_mut(&member);
                    if let Some((_, axes)) = original.filter(|(_, axes)| !axes.contains(&axis)) {
                        axes.push(axis);
                    }
                }
            }
        }
        Ok(())
    }

    /// What the best that was found in front of the coupling for one reading explains of the others; none where it
    /// explains nothing of any.
    fn share(&self, member: usize) -> Option<Share> {
        let front = front(&self.outcomes[member])?;
        let fronts = BTreeMap::from([(self.axis(member), front.clone())]);
        let mut share = Share { member, front, gain: 0.0, moves: Vec::new() };
        for other in self.members.iter().filter(|k| **k != member) {
            let o = &self.outcomes[*other];
            if !has_gap(&o.found.base, o.adequate) {
                continue;
            }
            let without = o.task.base.with_fronts(&self.fronts);
            let with = without.with_fronts(&fronts);
            let left_with = |base: &Base, now: &Candidate| {
                let (chain, theta) = of_its_own(o, base, now)?;
                let judged = o.judge.judge(&chain, &theta, &o.task.data, o.sigma, self.count);
                judged.ok().map(|judged| left(&judged))
            };
            let part = |now: &Candidate| match (left_with(&with, now), left_with(&without, now)) {
                (Some(with), Some(without)) => with / without,
                _ => 1.0,
            };
            // What the model leaves, or what is left beside what was found in the other's own axis.
            let part = part(&o.found.base).min(part(o.best()));
            share.gain -= effective(o) * part.ln();
            if part < Thresholds::MOVED_BY_AXIS {
                share.moves.push(*other);
            }
        }
        (share.gain > 0.0 && !share.moves.is_empty()).then_some(share)
    }

    /// The values of what was taken over of the axes beside a member's.
    fn beside(&self, member: usize) -> BTreeMap<usize, Vec<f64>> {
        let own = self.axis(member);
        let others = self.fronts.iter().filter(|(axis, _)| **axis != own);
        others.map(|(axis, front)| (*axis, front.values().to_vec())).collect()
    }

    /// Diagnoses a member again with what was taken over; whether that is better.
    fn again(&mut self, member: usize, hints: &[Hint]) -> Result<bool, Error> {
        let Some(task) = self.fresh.get(member).and_then(Option::as_ref) else { return Ok(false) };
        let mut task = task.clone();
        task.base = task.base.with_fronts(&self.fronts);
        self.searched.insert(member, self.beside(member));
        task.base.hints = hints.to_vec();
        let again = course::settled(task, self.request, self.count)?;
        let old = &mut self.outcomes[member];
        if cost(&again) >= cost(old) {
            return Ok(false);
        }
        let old = std::mem::replace(old, again);
        let Outcome { given, found, robust, sigma, .. } = old;
        let original = Original { given, before: found.base.judged, robust, sigma };
        self.moved_by.entry(member).or_insert_with(|| (original, Vec::new()));
        Ok(true)
    }

    /// What one reading shows of the coupling is where the search in the others starts.
    fn of_the_coupling(&mut self) -> Result<(), Error> {
        let hints: Vec<(usize, Hint)> =
            self.members.iter().filter_map(|k| Some((*k, hint(&self.outcomes[*k])?))).collect();
        for member in self.members.clone() {
            let o = &self.outcomes[member];
            let others = hints.iter().filter(|(owner, _)| *owner != member);
            let others: Vec<Hint> = others.map(|(_, hint)| hint.clone()).collect();
            if !others.is_empty() && has_gap(&o.found.last, o.adequate) {
                self.again(member, &others)?;
            }
        }
        Ok(())
    }

    /// Searches once more in the readings that something is left of and that were searched before the last was found.
    fn with_all_fronts(&mut self) -> Result<(), Error> {
        for member in self.members.clone() {
            let (o, axis) = (&self.outcomes[member], self.axis(member));
            let searched = self.searched.get(&member).cloned().unwrap_or_default();
            let is_old = searched != self.beside(member);
            if is_old
                && has_gap(&o.found.last, o.adequate)
                && self.again(member, &[])?
                && let Some(front) = front(&self.outcomes[member])
            {
                self.fronts.insert(axis, front);
            }
        }
        Ok(())
    }

    /// Judges by the model as it came what was diagnosed with parts of other axes in it.
    fn keep_originals(&mut self) {
        for (member, (original, axes)) in std::mem::take(&mut self.moved_by) {
            let o = &mut self.outcomes[member];
            if axes.is_empty() {
                continue;
            }
            o.moved_by = axes;
            let original = original.in_units_of(o);
            o.robust.clone_from(&original.robust);
            o.original = Some(original);
            if matches!(o.verdict, Verdict::Adequate | Verdict::Retune) {
                o.verdict = Verdict::Effects;
            }
        }
    }
}

/// A candidate's chain and values without what reads signals of other axes: that is what the fronts replace.
fn of_its_own(o: &Outcome, base: &Base, candidate: &Candidate) -> Option<(Chain, Vec<f64>)> {
    let reads_others = |formula: &Formula| {
        let mut blocks = formula.pieces.iter().filter_map(|piece| piece.block.effect());
        blocks.any(Block::reads_auxiliary) || formula.joint_mode == Some(false)
    };
    let picks = candidate.picks.iter().zip(o.formulas(candidate));
    let kept = picks.filter(|(_, formula)| !reads_others(formula)).map(|(pick, _)| *pick);
    carried((base, &o.library), candidate, &kept.collect::<Vec<_>>())
}

/// The model in front of the coupling with the best that was found there; none where nothing was.
fn front(o: &Outcome) -> Option<Front> {
    let (chain, theta) = of_its_own(o, &o.task.base, o.best())?;
    let place = |nodes| chain::joint(nodes).map(|(place, _)| place);
    let is_more = place(&chain.nodes)? > place(&o.task.base.nodes)?;
    is_more.then(|| Front::of(&chain, &theta)).flatten()
}

/// What one reading shows of the coupling itself.
fn hint(o: &Outcome) -> Option<Hint> {
    let last = &o.found.last;
    let (_, joint) = chain::joint(&last.chain.nodes)?;
    let mode = joint.mode_values(&last.chain.parameters, &last.fit.theta);
    shown(o, mode.iter().rev().nth(1).copied())
}
