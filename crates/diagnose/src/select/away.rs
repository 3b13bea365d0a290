//! Away from a fit that is only the best one nearby.

use components::effects;
use rayon::prelude::*;

use super::Search;
use super::memo::Part;
use crate::candidate::{Candidate, has_gap};
use crate::chain::Chain;
use crate::score::explained;
use crate::thresholds::{base, belief, search};

impl Search<'_> {
    /// A better fit of the last effect, where one of its times, rates or widths starts from elsewhere: plays whose
    /// thresholds move shift what they do from row to row, and such fits end on the way.
    pub(super) fn away(&self, base: &Candidate, best: Candidate) -> Candidate {
        let is_near = has_gap(&best, self.adequate)
            && explained(&base.judged, &best.judged) >= search::Thresholds::AWAY_NEAR;
        let moved = self.moved(&best);
        if !is_near
            || moved.is_empty()
            || best.fit.theta.len() > search::Thresholds::MOST_FITTED_ANEW
        {
            return best;
        }
        let moved_away = self.once_one(Part::Away, &best, || {
            let mut best = best.clone();
            for _ in 0..search::Thresholds::AWAY_ROUNDS {
                match self.elsewhere(&best, &moved) {
                    Some(other) if other.rank < best.rank - 1.0 => best = other,
                    _ => break,
                }
                if !has_gap(&best, self.adequate) {
                    break;
                }
            }
            Ok(best)
        });
        moved_away.unwrap_or(best)
    }

    /// A better fit where one that releases parameters of the model ended far above the mean square that it promised:
    /// a resonance under a strong harmonic has several best places nearby.
    pub(super) fn released_elsewhere(&self, fit: Candidate, promised: f64) -> Candidate {
        if !self.is_above(&fit, search::Thresholds::STUCK * promised.max(self.adequate)) {
            return fit;
        }
        let starts = released(&fit.chain).into_iter().flat_map(|(k, complete)| {
            search::Thresholds::RELEASED_SHIFTS.map(|by| (k, by * complete))
        });
        self.best_of_starts(fit, &starts.collect::<Vec<_>>())
    }

    /// The better one of a fit that releases parameters of the model and of those from where other readings of the same
    /// coupling put them.
    pub(super) fn as_hinted(&self, fit: Candidate) -> Candidate {
        let hinted = self.base.hints.iter().filter_map(|hint| {
            let mut theta = fit.fit.theta.clone();
            let mut any = false;
            for (k, p) in fit.chain.parameters.iter().enumerate() {
                let is_free = p.is_base && p.prior == 0.0;
                let own = hint.released.iter().find(|(name, _)| is_free && *name == p.name);
                if let Some((_, to)) = own {
                    (theta[k], any) = (*to, true);
                }
            }
            let again = any.then(|| self.fitter().fit_again(&fit.chain, &theta).ok())??;
            self.candidate(fit.picks.clone(), fit.chain.clone(), again).ok()
        });
        let best = hinted.min_by(|a, b| a.rank.total_cmp(&b.rank));
        best.filter(|other| other.rank < fit.rank).unwrap_or(fit)
    }

    /// Better fits of a resonance than those that ended far above what another family leaves: from the places along
    /// the whole range where the model, simulated with nothing fitted, leaves least, and from the best of them to the end.
    pub(super) fn resonance_elsewhere(&self, fitted: &mut [Option<Candidate>]) {
        let left = fitted.iter().flatten().map(|c| c.fit.mean_square);
        let least = left.fold(f64::INFINITY, f64::min);
        // It takes many simulations: where another family leaves so little that it would be named, or far less than the fit.
        let would_be_named = least <= search::Thresholds::STUCK * self.adequate;
        let times = match would_be_named {
            true => belief::Thresholds::ALIKE,
            false => search::Thresholds::RESONANCE_TIMES_OTHERS,
        };
        let is_resonance = |c: &Candidate| {
            let last = c.picks.last();
            last.is_some_and(|(f, _)| self.library[*f].effect.name == effects::RESONANCE_SHIFT.name)
        };
        let mut stuck: Vec<&mut Candidate> = fitted
            .iter_mut()
            .flatten()
            .filter(|c| is_resonance(c) && self.is_above(c, times * least))
            .collect();
        // Formulas of a resonance differ in what else they fit.
        let starts = stuck.first().map(|c| self.resonance_starts(c)).unwrap_or_default();
        if starts.is_empty() {
            return;
        }
        stuck.par_iter_mut().with_max_len(1).for_each(|c| {
            let other = self.best_of_starts(c.clone(), &starts);
            if other.rank < c.rank {
                let fit = self.fitter().fit(&other.chain, &other.fit.theta).ok();
                let end = fit.and_then(|fit| {
                    self.candidate(other.picks.clone(), other.chain.clone(), fit).ok()
                });
                **c = end.filter(|end| end.rank < other.rank).unwrap_or(other);
            }
        });
    }

    /// Places away from where the fit ended that leave little, as the number of the parameter and its coordinate.
    fn resonance_starts(&self, fit: &Candidate) -> Vec<(usize, f64)> {
        let released = released(&fit.chain).into_iter();
        let places = released.flat_map(|(k, complete)| {
            let (now, step) = (fit.fit.theta[k], search::Thresholds::RESONANCE_STEP - 1.0);
            search::Thresholds::resonance_places()
                .map(move |to| (k, (to - 1.0) * complete))
                .filter(move |(_, to)| (to - now).abs() > step * (complete + now).abs())
        });
        let places: Vec<(usize, f64)> = places.collect();
        let simulated = places.par_iter().with_max_len(1).filter_map(|(k, to)| {
            let mut theta = fit.fit.theta.clone();
            theta[*k] = *to;
            let judged = self.judge.judge(&fit.chain, &theta, self.data, self.sigma, self.count);
            Some((judged.ok()?.training, (*k, *to)))
        });
        let mut simulated: Vec<(f64, (usize, f64))> = simulated.collect();
        simulated
            .retain(|(left, _)| *left < search::Thresholds::RESONANCE_LEFT * fit.fit.mean_square);
        simulated.sort_by(|a, b| a.0.total_cmp(&b.0));
        simulated.truncate(search::Thresholds::RESONANCE_STARTS);
        simulated.into_iter().map(|(_, start)| start).collect()
    }

    /// Whether a fit that releases a few parameters of the model leaves more than this mean square.
    fn is_above(&self, fit: &Candidate, most: f64) -> bool {
        fit.fit.mean_square > most
            && !fit.chain.is_costly()
            && released(&fit.chain).len() <= search::Thresholds::AWAY_MOVED
    }

    /// The best of the fits where one parameter starts elsewhere, and of the fit as it is.
    fn best_of_starts(&self, fit: Candidate, starts: &[(usize, f64)]) -> Candidate {
        let tried = starts.par_iter().with_max_len(1).filter_map(|(k, to)| {
            let mut theta = fit.fit.theta.clone();
            theta[*k] = *to;
            let again = self.fitter().fit_again(&fit.chain, &theta).ok()?;
            self.candidate(fit.picks.clone(), fit.chain.clone(), again).ok()
        });
        let best = tried.min_by(|a, b| a.rank.total_cmp(&b.rank));
        best.filter(|other| other.rank < fit.rank).unwrap_or(fit)
    }

    /// Numbers of the parameters of the last effect that are fitted on a logarithmic scale and act in the simulation.
    fn moved(&self, best: &Candidate) -> Vec<usize> {
        let Some((family, number)) = best.picks.last() else { return Vec::new() };
        let formula = &self.library[*family].formulas[*number];
        if formula.nuisance.is_some() || formula.parameters.iter().any(|p| p.jumps) {
            return Vec::new();
        }
        let first = best.chain.parameters.len() - formula.parameters.len();
        let own = (first..best.chain.parameters.len()).filter(|k| best.chain.parameters[*k].log);
        let own: Vec<usize> = own.collect();
        if own.len() > search::Thresholds::AWAY_MOVED { Vec::new() } else { own }
    }

    fn elsewhere(&self, best: &Candidate, moved: &[usize]) -> Option<Candidate> {
        let starts: Vec<(usize, f64)> = moved
            .iter()
            .flat_map(|k| search::Thresholds::AWAY_FACTORS.map(|factor| (*k, factor.ln())))
            .collect();
        let tried: Vec<Option<Candidate>> = starts
            .par_iter()
            .with_max_len(1)
            .map(|(k, by)| {
                let mut theta = best.fit.theta.clone();
                theta[*k] += by;
                let fit = self.fitter().fit_again(&best.chain, &theta).ok()?;
                self.candidate(best.picks.clone(), best.chain.clone(), fit).ok()
            })
            .collect();
        tried.into_iter().flatten().min_by(|a, b| a.rank.total_cmp(&b.rank))
    }
}

/// The released parameters of the model: their numbers, and the coordinate by which one gains its own value.
fn released(chain: &Chain) -> Vec<(usize, f64)> {
    let all = chain.parameters.iter().enumerate();
    all.filter(|(_, p)| p.is_base && p.prior == 0.0)
        .map(|(k, p)| (k, p.low / -base::Thresholds::RELEASED_DOWN))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use components::effects;
    use surround::Block;

    use numerics::random::SplitMix64;

    use crate::data_set::{DataSet, RecordRows};
    use crate::formula::{Family, Formula, Free, Slot};
    use crate::noise::Shape;
    use crate::score::Judge;
    use crate::select::test_support::Synthetic;

    const SAMPLE: f64 = 1e-3;
    const SEED: u64 = 5;

    /// Two tones that are read six rows late, in noise of 0.1; a delay that starts from `start` in s.
    fn late(start: f64) -> Synthetic {
        let tone = |k: f64, row: f64| (TAU * k * row / 40.0).sin();
        let command = |row: f64| 10.0 * tone(11.0, row) + 2.0 * tone(3.0, row);
        let mut random = SplitMix64::new(SEED);
        let mut noise = || 0.1 * ((0..12).map(|_| random.uniform()).sum::<f64>() - 6.0);
        let rows = 600;
        let record = RecordRows {
            command: (0..rows).map(|k| command(f64::from(k))).collect(),
            y: (0..rows).map(|k| command(f64::from(k) - 7.0) + noise()).collect(),
            ..RecordRows::still(rows as usize, 0.7)
        };
        let mut synthetic = Synthetic::new(&[], &[]);
        synthetic.data = DataSet::new(vec![record], &[], None);
        synthetic.judge = Judge::new(&synthetic.data, Shape::WHITE);
        let delay = Free::log("delay", "s", 0.1 * SAMPLE, 30.0 * SAMPLE).step(0.01);
        let formula =
            Formula::new("delay").block(Slot::Reading, Block::Delay, vec![delay]).start(&[start]);
        synthetic.library = vec![Family::new(&effects::DELAY, vec![formula])];
        synthetic
    }

    #[test]
    fn a_fit_that_is_the_best_one_nearby_is_left_for_a_better_one() {
        let synthetic = late(9.7e-3);
        let (search, base, near) =
            (synthetic.search(), synthetic.retuned(), synthetic.families(&[0]));
        let delay = |c: &crate::select::Candidate| c.fit.theta.last().unwrap().exp() / SAMPLE;
        assert!((delay(&near) - 9.6).abs() < 0.4, "seed {SEED}: {}", delay(&near));
        let best = search.away(&base, near);
        assert!((delay(&best) - 6.0).abs() < 0.1, "seed {SEED}: {}", delay(&best));
    }

    #[test]
    fn what_leaves_nothing_stays_where_it_is() {
        let synthetic = late(6.1e-3);
        let (search, base, best) =
            (synthetic.search(), synthetic.retuned(), synthetic.families(&[0]));
        let before = synthetic.count.load(std::sync::atomic::Ordering::Relaxed);
        let theta = best.fit.theta.clone();
        assert_eq!(search.away(&base, best).fit.theta, theta);
        assert_eq!(
            synthetic.count.load(std::sync::atomic::Ordering::Relaxed),
            before,
            "no simulation"
        );
    }
}
