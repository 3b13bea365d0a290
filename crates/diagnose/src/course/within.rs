//! Readings within the rows of a held command.
//!
//! A reading that is taken a part of a row after the command of its row acts, and a delay of a part of a row, are exact
//! within a row: there the command is held, and the motion is smooth. A model that takes one step from row to row knows
//! nothing of them, and what it then lacks looks like a mode near half the sample rate or a crosstalk.

use super::{Readings, leaves_less, mode_near_nyquist, names};
use crate::base::Base;
use crate::between::{Between, Course};
use crate::candidate::{Candidate, has_gap};
use crate::chain::{Chain, Node};
use crate::data_set::DataSet;
use crate::fit::{Fit, Fitter};
use crate::gap::Verdict;
use crate::outcome::Outcome;
use crate::parameter::Parameter;
use crate::path_block::RecordBlock;
use crate::sentence::together;
use crate::stages;
use crate::task::Task;
use crate::thresholds::base::Thresholds;

/// A reading of the logs within the rows of a held command.
pub(super) struct Instant {
    data: DataSet,
    course: Course,
    /// Seconds by which readings are later than the instants of their rows.
    later: f64,
    /// Whether the re-tuned model then leaves nothing.
    is_all: bool,
}

impl Instant {
    /// Whether a command that moves to the next row looks like it.
    pub(super) fn looks_moving(&self) -> bool {
        let (low, high) = Thresholds::LATE_AS_MOVING;
        (low..high).contains(&(self.later / self.data.sample_time))
    }

    /// Whether no effect is needed beside it.
    pub(super) fn is_all(&self) -> bool {
        self.is_all
    }
}

/// The answer with readings within the rows.
pub(super) struct Within {
    outcome: Outcome,
    /// Length of a row in s.
    row: f64,
}

impl Readings<'_> {
    /// The instant within a row with which the base or the best answer leaves clearly less.
    pub(super) fn instant(&self, outcome: &Outcome) -> Option<Instant> {
        let Task { course, base, coupled, .. } = &outcome.task;
        let is_alone = base.joint().is_none() && coupled.is_none();
        let is_held = course.between == Between::Zoh && is_alone;
        if !is_held || !has_gap(&outcome.found.base, outcome.adequate) {
            return None;
        }
        let data = self.fresh.data.played(*course).within_rows(Thresholds::WITHIN_ROW)?;
        let divides = |node: &Node| !matches!(node, Node::BlackBox(fmu) if !fmu.divides(data.step));
        if !base.nodes.iter().all(divides) {
            return None;
        }
        if !base.is_white && !self.shows_instant(outcome) {
            return None;
        }
        let both = [&outcome.found.base, outcome.best()];
        let [of_base, of_best] = both.map(|c| self.later(outcome, c, &data));
        let is_all = of_base.is_some_and(|(part, _)| {
            let judged = &outcome.found.base.judged;
            0.5 * part * (judged.training + judged.held_out) <= outcome.adequate
        });
        let later = [of_base, of_best].into_iter().flatten();
        let (part, later) = later.min_by(|a, b| a.0.total_cmp(&b.0))?;
        // When readings are taken may be given; a delay is none of them.
        let is_open = later <= 0.0 || self.request.reading.is_none();
        (part < Thresholds::READING_LESS && is_open).then_some(Instant {
            data,
            course: *course,
            later,
            is_all,
        })
    }

    /// Whether the first rows alone show that the base with readings at one instant leaves about as little as the answer, or
    /// that the best answer leaves clearly less with it: an FMU takes its time for all rows in parts.
    fn shows_instant(&self, o: &Outcome) -> bool {
        let begin = self.fresh.data.begin(Thresholds::WITHIN_SEEN);
        let Some(rows) = begin.map(|data| data.played(o.task.course)) else { return false };
        let Some(parts) = rows.within_rows(Thresholds::WITHIN_ROW) else { return false };
        let left = |c: &Candidate| {
            let chain = c.chain.over(&rows);
            let fitter = Fitter { data: &rows, sigma: o.sigma, count: self.count, weights: None };
            Some(fitter.fit_again(&chain, &c.fit.theta).ok()?.mean_square)
        };
        let with = |c: &Candidate| Some(self.fit_later(o, c, &parts)?.1.mean_square);
        let (base, best) = (&o.found.base, o.best());
        let is_all = || Some(with(base)? < Thresholds::READING_FOR_EFFECT * left(best)?);
        let is_less = || Some(with(best)? < Thresholds::READING_LESS * left(best)?);
        is_all() == Some(true) || (has_gap(best, o.adequate) && is_less() == Some(true))
    }

    /// The answer with readings that are late by a part of a row, or with delays that are exact within one.
    pub(super) fn within_rows(&self, outcome: &Outcome, instant: Instant) -> Option<Within> {
        let Instant { data, course, later, .. } = instant;
        let row = data.sample_time;
        let late = (later > 0.0).then_some((row, Thresholds::WITHIN_ROW));
        let nodes = outcome.task.base.nodes.iter().map(|node| node.over(&data)).collect();
        let base = Base { late, nodes, ..outcome.task.base.clone() };
        let task = Task { data, base, course, ..self.fresh.clone() };
        let outcome = stages::of(task, self.request, self.count).ok()?;
        Some(Within { outcome, row })
    }

    /// The part of its error power that a candidate leaves with readings at the best instant, and by how many seconds that is
    /// later than the instants of the rows.
    fn later(&self, o: &Outcome, c: &Candidate, data: &DataSet) -> Option<(f64, f64)> {
        let (chain, fit) = self.fit_later(o, c, data)?;
        let judged = o.judge.judge(&chain, &fit.theta, data, o.sigma, self.count).ok()?;
        let before = c.judged.training + c.judged.held_out;
        Some(((judged.training + judged.held_out) / before, fit.theta[c.chain.parameters.len()]))
    }

    /// A candidate with readings at the best instant.
    fn fit_later(&self, o: &Outcome, c: &Candidate, data: &DataSet) -> Option<(Chain, Fit)> {
        let mut chain = c.chain.over(data);
        let own = chain.parameters.len();
        let (low, high) = Thresholds::WITHIN_LATER;
        chain.parameters.push(Parameter {
            name: String::new(),
            unit: "s".to_owned(),
            low: low * data.sample_time,
            high: high * data.sample_time,
            log: false,
            step: 1e-2 * data.sample_time,
            jumps: false,
            prior: 0.0,
            node: chain.nodes.len(),
            is_base: false,
        });
        let block = RecordBlock::Instant { parts: Thresholds::WITHIN_ROW, is_late: true };
        let takes = vec![own];
        chain.nodes.push(Node::Block { block: block.into(), takes, aux: 0, of_command: false });
        let start = [&c.fit.theta[..], &[0.0]].concat();
        let fitter = Fitter { data, sigma: o.sigma, count: self.count, weights: None };
        let fit = fitter.fit_again(&chain, &start).ok()?;
        Some((chain, fit))
    }
}

impl Within {
    /// Whether it explains the logs, and nothing is left.
    pub(super) fn is_complete(&self) -> bool {
        let own = &self.outcome;
        own.verdict.is_explained() && !has_gap(&own.found.last, own.adequate)
    }

    /// Whether it is taken in place of another answer: it leaves clearly less, or about as much with fewer effects. With as
    /// many, it is taken where it names others, as it is the more exact model.
    pub(super) fn is_better(&self, other: &Outcome) -> bool {
        let own = &self.outcome;
        let count = |o: &Outcome| o.found.last.picks.len();
        // The other names none, and is no better.
        if other.verdict == Verdict::Unknown && !own.verdict.is_explained() {
            return leaves_less(own, other);
        }
        let ratio = own.left() / other.left();
        // A command that moves between rows is another reading of its own.
        if other.task.course.between != Between::Zoh && count(own) == count(other) {
            return own.verdict.is_explained() && leaves_less(own, other);
        }
        let has_others = mode_near_nyquist(own).is_none() && names(own) != names(other);
        let most = if has_others { Thresholds::READING_FOR_EFFECT } else { Thresholds::FINER_LESS };
        own.verdict.is_explained() && count(own) <= count(other) && ratio < most
    }

    /// The answer, and what to say of it in place of another.
    pub(super) fn in_place_of(self, other: &Outcome) -> Outcome {
        let Self { mut outcome, row } = self;
        let output = &outcome.task.output;
        let ratio = (other.left() / outcome.left()).sqrt();
        let instead = match names(other).as_slice() {
            [] => format!("the best answer would leave {ratio:.2} times as much"),
            all => format!(
                "the best answer, {}, would leave {ratio:.2} times as much",
                together(all.iter().copied())
            ),
        };
        let warning = match outcome.found.last.late() {
            Some(late) => format!(
                "{output}: each reading is taken {} s after its row ({:.1} % of a row): at its row {instead} (--reading before \
                 keeps them there)",
                report::format_number(late, 3),
                100.0 * late / row
            ),
            None => format!(
                "{output}: the model is simulated in steps of {} s, so that a delay is exact within a row: with its own, one \
                 from row to row, {instead}",
                outcome.task.data.step
            ),
        };
        outcome.task.warnings.push(warning);
        outcome
    }
}
