//! Axes that couplings join, once each is diagnosed: whether the gap lies behind their coupling, and what moves several
//! of their readings.

mod same_box;
mod together;

use std::sync::atomic::AtomicU64;

use surround::Span;

pub(crate) use self::same_box::with_hints_of_others;
pub(crate) use self::together::together;
use crate::base::Hint;
use crate::candidate::has_gap;
use crate::chain::{Bench, Horizon};
use crate::data_set::Auxiliary;
use crate::error::Error;
use crate::fit::Fitter;
use crate::outcome::Outcome;
use crate::request::Request;
use crate::score::{Judged, mean_square};
use crate::stages;
use crate::task::Coupled;

/// Where something is left of the motions of a group, looks for it behind the couplings too: in the reading of each
/// axis under the positions that the model gives. The answers that leave less of all readings stay, for as many
/// parameters as they need.
///
/// # Errors
/// [`Error::Model`]: a model that cannot be simulated over the logs.
pub(crate) fn in_readings(
    outcomes: &mut Vec<Outcome>,
    request: &Request,
    count: &AtomicU64,
) -> Result<(), Error> {
    let mut first = 0;
    while first < outcomes.len() {
        let Some(coupled) = outcomes[first].task.coupled.clone() else {
            first += 1;
            continue;
        };
        let members = first..first + coupled.group.axes.len();
        first = members.end;
        let motions = &outcomes[members.clone()];
        if motions.iter().all(|o| !has_gap(&o.found.base, o.adequate)) {
            continue;
        }
        let mut readings = coupled.readings(motions, request, count)?;
        // Without a name there it is no better place to show what is left.
        let has_one = readings.iter().any(|o| !o.found.last.picks.is_empty());
        if has_one && cost_of_readings(&readings) < coupled.cost_of_motions(motions, &readings) {
            let known_warnings = motions.iter().flat_map(|o| o.task.warnings.clone());
            let couplings = coupled.group.couplings.join(", ");
            let why = format!(
                "the gap lies behind the coupling ({couplings}): changes of single readings explain all readings \
                 better than changes of the motions in front of it"
            );
            let known_warnings: Vec<String> = known_warnings.chain([why]).collect();
            readings[0].task.warnings.extend(known_warnings);
            outcomes.splice(members, readings);
        }
    }
    Ok(())
}

impl Coupled {
    /// The readings under the positions that the model as it came gives.
    fn readings(
        &self,
        motions: &[Outcome],
        request: &Request,
        count: &AtomicU64,
    ) -> Result<Vec<Outcome>, Error> {
        let moved = |o: &Outcome| {
            let chain = &o.found.base.chain;
            let mut bench = Bench::new(chain, &o.task.data, Horizon::All, count);
            let given = vec![0.0; chain.parameters.len()];
            bench.keep(&given).ok().map(<[f64]>::to_vec)
        };
        let Some(moved) = motions.iter().map(moved).collect::<Option<Vec<_>>>() else {
            return Ok(Vec::new());
        };
        let mut all = Vec::with_capacity(self.readings.len());
        for (i, reading) in self.readings.iter().enumerate() {
            let mut task = reading.clone();
            task.course = motions[i].task.course;
            let data = &mut task.data;
            for (hit, command) in data.command.iter_mut().enumerate() {
                let sum = moved.iter().enumerate().map(|(j, m)| self.group.matrix[(i, j)] * m[hit]);
                *command = self.group.at_zero[i] + sum.sum::<f64>();
            }
            data.command_span = Span::of(data.command.iter().copied());
            let others = moved.iter().enumerate().filter(|(j, _)| *j != i);
            data.aux = others
                .map(|(j, m)| Auxiliary {
                    name: motions[j].task.output.clone(),
                    is_command: true,
                    hits: m.clone(),
                    span: Span::of(m.iter().copied()),
                })
                .collect();
            task.input = format!("{} of the model", task.output);
            task.command_unit.clone_from(&task.unit);
            task.command_factor = task.factor;
            all.push(stages::of(task, request, count)?);
        }
        Ok(all)
    }

    /// What the answers of the motions leave of the readings and need for it, in twice the logarithm of a likelihood.
    fn cost_of_motions(&self, motions: &[Outcome], readings: &[Outcome]) -> f64 {
        let left = |(i, reading): (usize, &Outcome)| {
            let rows = reading.task.data.y.len();
            let at = |row: usize| {
                let own = motions.iter().enumerate();
                let sum = own.map(|(j, o)| {
                    self.group.matrix[(i, j)] * o.sigma * o.found.last.judged.residual[row]
                });
                (sum.sum::<f64>() / reading.sigma).powi(2)
            };
            let square = (0..rows).map(at).sum::<f64>() / rows.max(1) as f64;
            effective(reading) * square.max(1.0).ln()
        };
        readings.iter().enumerate().map(left).sum::<f64>() + motions.iter().map(needed).sum::<f64>()
    }
}

/// What the answers of the readings leave of them and need for it, in twice the logarithm of a likelihood.
fn cost_of_readings(readings: &[Outcome]) -> f64 {
    let left = |o: &Outcome| {
        let square = mean_square(&o.found.last.judged.residual);
        effective(o) * square.max(1.0).ln()
    };
    readings.iter().map(|o| left(o) + needed(o)).sum()
}

/// What an answer leaves and needs for it, in twice the negative logarithm of a likelihood.
fn cost(o: &Outcome) -> f64 {
    let left = left(&o.found.last.judged) * o.sigma.powi(2);
    effective(o) * left.ln() + needed(o)
}

/// Mean square over the noise's, on fitted and held-out rows alike.
fn left(judged: &Judged) -> f64 {
    (0.5 * (judged.training + judged.held_out)).max(1.0)
}

/// What a reading shows of the model: the parameters that its effects release, and this frequency of a mode; none where
/// it shows nothing.
fn shown(o: &Outcome, frequency: Option<f64>) -> Option<Hint> {
    let last = &o.found.last;
    let values = o.released(last).into_iter().filter_map(|k| {
        let name = &o.task.base.parameters[k].name;
        Some((name.clone(), last.fit.theta[last.chain.own(name)?]))
    });
    let hint = Hint { released: values.collect(), frequency };
    (!hint.released.is_empty() || hint.frequency.is_some()).then_some(hint)
}

fn effective(o: &Outcome) -> f64 {
    let count = AtomicU64::new(0);
    Fitter { data: &o.task.data, sigma: o.sigma, count: &count, weights: None }.effective()
}

/// What the parameters of an answer count.
fn needed(o: &Outcome) -> f64 {
    let records = o.task.data.records.len();
    let picks = o.found.last.picks.iter();
    let all = picks.map(|(family, k)| o.library[*family].formulas[*k].freedom(records));
    all.sum::<usize>() as f64 * effective(o).ln()
}
