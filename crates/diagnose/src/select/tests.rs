use surround::Block;

use super::test_support::{Synthetic, adds, close, listed, names};
use super::*;
use crate::candidate::{Found, has_gap};
use crate::formula::{Free, Slot};
use crate::nuisance::Nuisance;

/// The first formula of a family fitted as the next effect beside those of `from`.
fn next(synthetic: &Synthetic, from: &Candidate, job: (usize, usize)) -> Candidate {
    let search = synthetic.search();
    let linear = search.fitter().linearise(&from.chain, &from.fit.theta).unwrap();
    let fixed = search.formulas(&from.picks);
    let (_, start) = search.screen(from, &fixed, job, &linear, &[]);
    search.fit_one(from, &fixed, (job, &start, true), &linear).unwrap()
}

/// Weights and times that nothing depends on, with these starts.
fn idle(starts: &[f64]) -> Formula {
    // A play without width follows its drive.
    let block = Block::Plays { r: vec![0.0; starts.len()], slope: false };
    let weight = |_| Free::linear("idle", "1", -1e3, 1e3);
    let free = starts.iter().map(weight).collect();
    Formula::new("idle").block(Slot::Reading, block, free).start(starts)
}

#[test]
fn the_rank_is_the_likelihood_with_the_prior_and_a_penalty_for_each_coefficient() {
    let mut synthetic = Synthetic::new(&[(3, 4.0)], &[&[(3, 1.0)], &[(5, 1.0)]]);
    synthetic.parameter("stiff", true);
    synthetic.parameter("released", false);
    synthetic.library[0].formulas[0].releases = vec![1];
    synthetic.library[1].formulas[0].nuisance = Some(Nuisance::Drift { order: 2 });
    let search = synthetic.search();
    let mut fitted = synthetic.families(&[0, 1]);
    let names: Vec<&str> = fitted.chain.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["stiff", "released", "output.gain", "weight", "weight"]);
    fitted.fit.theta = vec![1.5, 5.0, -0.5, 2.0, 1.0];
    fitted.fit.mean_square = 7.0;
    let Candidate { picks, chain, fit, .. } = fitted;
    let found = search.candidate(picks, chain, fit).unwrap();
    // 560 fitted rows count as 56. Of 4² of the tone 2² is left, and 1 is there that should not be.
    // Of white noise the two terms of each record take two rows' worth.
    let taken = 4.0 / 560.0;
    let (fitted, held_out) = (7.0 + taken, found.judged.held_out);
    close(found.training, fitted, 1e-12);
    close(held_out, 1.0 + 4.0 + 1.0, 0.6);
    // Two weights, a released parameter, and two terms for each of the two records.
    assert_eq!(found.freedom, 2 + 1 + 2 * 2);
    // The released parameter has no prior any more, and weights have none.
    let prior = 1.5 * 1.5 + 0.5 * 0.5;
    let wanted = 56.0 * 0.5 * (fitted.ln() + held_out.ln()) + prior + 7.0 * 56.0_f64.ln();
    close(found.rank, wanted, 1e-9);
    // A perfect fit has a rank, too.
    let perfect = Fit { mean_square: 0.0, ..found.fit.clone() };
    let found = search.candidate(found.picks, found.chain, perfect).unwrap();
    close(found.rank, wanted - 28.0 * (fitted / taken).ln(), 1e-9);
}

#[test]
fn the_model_is_retuned_within_its_tolerance() {
    // The command is a tone of 10, 5 % too small: five standard deviations q of the output's gain. Least is
    // 56·ln(1 + (0.5 − 0.1·q)²) + q².
    let synthetic = Synthetic::new(&[(19, 0.5)], &[]);
    let base = synthetic.retuned();
    assert!(base.picks.is_empty() && base.freedom == 0);
    close(base.fit.theta[0], 1.69, 0.3);
    let free = Synthetic::new(&[], &[]).retuned();
    close(free.fit.theta[0], 0.0, 0.3);
}

#[test]
fn a_further_effect_starts_from_what_the_others_say() {
    let mut synthetic = Synthetic::new(&[], &[&[(3, 1.0)], &[(5, 1.0)]]);
    for (name, has_tolerance) in [("a", false), ("b", true), ("c", false)] {
        synthetic.parameter(name, has_tolerance);
    }
    synthetic.library[0].formulas[0].releases = vec![2];
    synthetic.library[1].formulas = vec![idle(&[0.0, 0.0])];
    synthetic.library[1].formulas[0].releases = vec![0];
    synthetic.library[1].formulas[0].parameters[1] = Free::log("time", "s", 1e-3, 10.0);
    let mut from = synthetic.families(&[0]);
    // b, c, the gain, the weight.
    from.fit.theta = vec![0.1, 0.2, 0.3, 0.4];
    let search = synthetic.search();
    let chain = synthetic.base.compose(&search.formulas(&[(0, 0), (1, 0)]));
    let start = search.carry(&from, &chain, &synthetic.library[1].formulas[0], &[0.5, 0.25]);
    // a is new and stays where it was.
    assert_eq!(start, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.25_f64.ln()]);
}

#[test]
fn an_effect_promises_the_part_of_the_power_that_it_would_take() {
    // 8² and 6² on the fitted rows: 64 and 36 of 100, and 1 of noise.
    let synthetic = Synthetic::new(&[(3, 8.0), (5, 6.0)], &[&[(3, 2.0)], &[(5, 1.0)], &[(7, 1.0)]]);
    let looked = synthetic.search().expand(&synthetic.retuned()).unwrap();
    assert_eq!(listed(&looked)[..2], [0, 1], "best first");
    for (family, part) in [(0, 0.64), (1, 0.36), (2, 0.0)] {
        let entry = looked.iter().find(|l| l.family == family).unwrap();
        close(entry.screening, part, 0.02);
    }
}

#[test]
fn a_formula_is_screened_from_each_of_its_starts_and_fitted_from_the_best() {
    let mut synthetic = Synthetic::new(&[(3, 8.0)], &[&[(3, 1.0)]]);
    // A lag of the reading: the tone of 25 Hz k is turned by a slow one only.
    let lag = Free::log("bandwidth", "Hz", 1.0, 1e4);
    let formula =
        Formula::new("lag").block(Slot::Reading, Block::Lag { order: 1 }, vec![lag]).screened(0);
    let base = synthetic.retuned();
    let search = synthetic.search();
    let linear = search.fitter().linearise(&base.chain, &base.fit.theta).unwrap();
    let promise = |synthetic: &Synthetic| {
        let search = synthetic.search();
        search.screen(&base, &[], (0, 0), &linear, &[])
    };
    // The command must not be lagged: the faster the better, wherever the fastest stands.
    let mut seen = Vec::new();
    for starts in [[10.0, 100.0, 5e3], [5e3, 10.0, 100.0], [10.0, 5e3, 100.0]] {
        synthetic.library[0].formulas[0] = formula.clone().starts(starts.map(|s| vec![s]));
        let (promise, start) = promise(&synthetic);
        assert_eq!(start, [5e3]);
        seen.push(promise);
    }
    assert!(seen.iter().all(|p| *p == seen[0] && *p < 1.0), "{seen:?}");
    // Of equals the first one.
    let block = Block::Auxiliary { scale: f64::INFINITY, zero: 0.0 };
    let mut same = adds(0).block(Slot::Reading, block, vec![Free::linear("idle", "1", -1e3, 1e3)]);
    same.starts = vec![vec![0.0, 1.0], vec![0.0, 2.0]];
    synthetic.library[0].formulas[0] = same;
    let (promise, start) = promise(&synthetic);
    assert!(promise > 0.9, "{promise}");
    assert_eq!(start, [0.0, 1.0]);
}

#[test]
fn the_families_of_the_effects_that_stand_are_not_looked_at_again() {
    let columns: [&[(usize, f64)]; 4] = [&[(3, 1.0)], &[(5, 1.0)], &[(7, 1.0)], &[(9, 1.0)]];
    let synthetic = Synthetic::new(&[(3, 8.0), (5, 6.0), (7, 4.0)], &columns);
    let from = synthetic.families(&[1]);
    let looked = synthetic.search().expand(&from).unwrap();
    assert_eq!(listed(&looked)[..2], [0, 2]);
    assert_eq!(looked.len(), 3);
    for entry in &looked {
        let best = entry.best.as_ref().unwrap();
        assert_eq!(names(best), [1, entry.family], "its own family, behind the others");
        assert!(best.rank.is_finite());
    }
}

#[test]
fn the_seven_that_promise_most_are_fitted_and_five_beside_an_effect() {
    let columns: Vec<Vec<(usize, f64)>> = (0..12).map(|k| vec![(k + 1, 1.0)]).collect();
    let columns: Vec<&[(usize, f64)]> = columns.iter().map(Vec::as_slice).collect();
    // Family k has the amplitude k + 1.
    let truth: Vec<(usize, f64)> = (0..12).map(|k| (k + 1, k as f64 + 1.0)).collect();
    let mut synthetic = Synthetic::new(&truth, &columns);
    synthetic.parameter("released", false);
    let fitted = |looked: &[RankedFamily]| {
        let mut all: Vec<usize> =
            looked.iter().filter(|l| l.best.is_some()).map(|l| l.family).collect();
        assert!(looked[..all.len()].iter().all(|l| l.best.is_some()), "fitted ones first");
        all.sort_unstable();
        all
    };
    let first = synthetic.search().expand(&synthetic.retuned()).unwrap();
    assert_eq!(fitted(&first), [5, 6, 7, 8, 9, 10, 11]);
    assert_eq!(listed(&first), [11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0], "then by promise");
    let second = synthetic.search().expand(&synthetic.families(&[11])).unwrap();
    assert_eq!(fitted(&second), [6, 7, 8, 9, 10]);
    // What takes its tolerance from the model's own parameters is fitted whatever it promises.
    synthetic.library[2].formulas[0].releases = vec![0];
    let first = synthetic.search().expand(&synthetic.retuned()).unwrap();
    assert_eq!(fitted(&first), [2, 5, 6, 7, 8, 9, 10, 11]);
}

#[test]
fn the_best_formula_stands_for_its_family() {
    let columns: [&[(usize, f64)]; 2] = [&[(3, 1.0), (5, 0.5)], &[(3, 1.0)]];
    let mut synthetic = Synthetic::new(&[(3, 8.0)], &columns);
    let best = |synthetic: &Synthetic| {
        let looked = synthetic.search().expand(&synthetic.retuned()).unwrap();
        looked[0].best.as_ref().unwrap().picks.clone()
    };
    synthetic.library.truncate(1);
    synthetic.library[0].formulas = vec![adds(0), adds(1)];
    assert_eq!(best(&synthetic), [(0, 1)]);
    synthetic.library[0].formulas = vec![adds(1), adds(0)];
    assert_eq!(best(&synthetic), [(0, 0)]);
    // Of equals the first one.
    synthetic.library[0].formulas = vec![adds(1), adds(1)];
    assert_eq!(best(&synthetic), [(0, 0)]);
    // What only stands in for others is none of them.
    synthetic.library[0].formulas = vec![adds(0), adds(1).stand_in()];
    assert_eq!(best(&synthetic), [(0, 0)]);
}

#[test]
fn refining_never_makes_worse() {
    let synthetic = Synthetic::new(&[(3, 8.0)], &[&[(3, 1.0)]]);
    let fitted = synthetic.families(&[0]);
    let search = synthetic.search();
    let base = synthetic.retuned();
    let linear = search.fitter().linearise(&base.chain, &base.fit.theta).unwrap();
    let entry =
        |best: Option<Candidate>| RankedFamily { family: 0, screening: 0.5, best, why: None };
    // A weight that is off is put right.
    let mut off = fitted.clone();
    off.fit.theta[1] = 3.0;
    off = search.candidate(off.picks, off.chain, off.fit).unwrap();
    let mut looked = entry(Some(off.clone()));
    search.refine(&mut looked, (&linear, f64::INFINITY));
    let refined = looked.best.unwrap();
    assert!(refined.rank < off.rank - 10.0);
    close(refined.fit.theta[1], 8.0, 0.2);
    assert_eq!(refined.picks, [(0, 0)]);
    // What was better stays.
    let better = Candidate { rank: fitted.rank - 5.0, ..fitted };
    let mut looked = entry(Some(better.clone()));
    search.refine(&mut looked, (&linear, f64::INFINITY));
    assert_eq!(looked.best.unwrap().rank, better.rank);
    let mut nothing = entry(None);
    search.refine(&mut nothing, (&linear, f64::INFINITY));
    assert!(nothing.best.is_none());
}

#[test]
fn a_family_must_leave_a_tenth_less_than_what_it_becomes_without_its_effect() {
    // The null takes one of two tones: 10² of 10² + 12² is left, and noise.
    let mut synthetic = Synthetic::new(&[(3, 10.0), (5, 12.0)], &[&[(3, 1.0)], &[(5, 1.0)]]);
    synthetic.library[0].nulls = vec![adds(1)];
    let base = synthetic.retuned();
    let null = next(&synthetic, &base, (1, 0));
    let left = 0.5 * (null.fit.mean_square + null.judged.held_out);
    close(left, 101.0, 5.0);
    let search = synthetic.search();
    let linear = search.fitter().linearise(&base.chain, &base.fit.theta).unwrap();
    let survives_beside = |own: f64, as_gain: f64| {
        let mut best = next(&synthetic, &base, (0, 0));
        // Of what it leaves more is on the rows that are held out.
        best.fit.mean_square = 0.6 * own;
        best.judged.held_out = 1.4 * own;
        let mut entry = RankedFamily { family: 0, screening: 0.5, best: Some(best), why: None };
        search.hold_against_nulls(&base, &[], &mut entry, &linear, as_gain);
        // Nothing goes unseen.
        assert_eq!(entry.why, entry.best.is_none().then_some(Why::AsNull));
        entry.best.is_some()
    };
    let survives = |own: f64| survives_beside(own, f64::INFINITY);
    assert!(survives(left / 1.15) && survives(left / 100.0));
    assert!(!survives(left / 1.05) && !survives(left));
    // Another gain is held against it alike.
    let own = left / 2.0;
    assert!(survives_beside(own, 1.15 * own) && !survives_beside(own, 1.05 * own));
    // A family that becomes nothing has nothing to beat.
    synthetic.library[0].nulls.clear();
    let looked = synthetic.search().expand(&base).unwrap();
    assert!(looked.iter().all(|l| l.best.is_some()));
    // One that becomes the truth is dropped, one that is the truth is not.
    synthetic.library[0].nulls = vec![adds(1)];
    synthetic.library[1].nulls = vec![adds(0)];
    let looked = synthetic.search().expand(&base).unwrap();
    assert_eq!(listed(&looked), [1, 0]);
    assert!(looked[0].best.is_some() && looked[1].best.is_none());
}

#[test]
fn a_set_without_one_of_its_effects_keeps_what_the_others_say() {
    let columns: [&[(usize, f64)]; 3] = [&[(3, 1.0)], &[(5, 1.0)], &[(7, 1.0)]];
    let mut synthetic = Synthetic::new(&[], &columns);
    synthetic.parameter("tight", true);
    synthetic.parameter("released", false);
    // What nothing depends on is fitted to where it starts.
    let own: [&[f64]; 3] = [&[0.11, 0.12, 0.13], &[0.21, 0.22], &[0.31]];
    for (family, starts) in own.iter().enumerate() {
        synthetic.library[family].formulas = vec![idle(starts)];
    }
    synthetic.library[0].formulas[0].releases = vec![1];
    let mut from = synthetic.families(&[0, 1, 2]);
    from.fit.theta[0] = 2.0;
    from.fit.theta[1] = 0.7;
    let effects = |c: &Candidate| {
        let first = c.chain.parameters.iter().position(|p| !p.is_base).unwrap();
        c.fit.theta[first..].to_vec()
    };
    assert_eq!(effects(&from), own.concat());
    let search = synthetic.search();
    let less = search.refit_without(&from, 1).unwrap();
    assert_eq!(less.picks, [(0, 0), (2, 0)]);
    assert_eq!(effects(&less), [own[0], own[2]].concat());
    let names: Vec<&str> = less.chain.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names[..3], ["tight", "released", "output.gain"]);
    assert_eq!(less.fit.theta[1], 0.7, "the model's own parameters, by name");
    close(less.fit.theta[0], 0.0, 1e-3);
    let less = search.refit_without(&from, 2).unwrap();
    assert_eq!(effects(&less), [own[0], own[1]].concat());
    // Without what released it the parameter is fixed again.
    let less = search.refit_without(&from, 0).unwrap();
    assert_eq!(effects(&less), [own[1], own[2]].concat());
    assert_eq!(less.chain.parameters.iter().filter(|p| p.is_base).count(), 2);
    // What is in no set cannot be taken over.
    assert!(search.refit(&less, vec![(0, 0)]).is_err());
}

#[test]
fn an_effect_is_written_with_another_of_its_formulas() {
    let mut synthetic =
        Synthetic::new(&[(3, 8.0), (5, 6.0)], &[&[(3, 1.0)], &[(5, 1.0)], &[(3, 0.5)]]);
    let other = synthetic.library.pop().unwrap().formulas.pop().unwrap();
    synthetic.library[0].formulas.push(other);
    let from = synthetic.families(&[0, 1]);
    let exchanged = synthetic.search().exchange(&from, 0, 1).unwrap();
    assert_eq!(exchanged.picks, [(1, 0), (0, 1)]);
    close(exchanged.fit.theta[1], 6.0, 0.2);
    close(exchanged.fit.theta[2], 16.0, 0.4);
    close(exchanged.rank, from.rank, 0.01);
}

#[test]
fn a_gap_is_what_is_over_the_limit_on_fitted_or_held_out_rows() {
    let synthetic = Synthetic::new(&[], &[]);
    let mut candidate = synthetic.retuned();
    let mut is_over = |held_out, training| {
        (candidate.judged.held_out, candidate.judged.training) = (held_out, training);
        has_gap(&candidate, 1.3)
    };
    assert!(is_over(1.31, 1.0) && is_over(1.0, 1.31) && is_over(9.0, 9.0));
    assert!(!is_over(1.29, 1.29) && !is_over(1.3, 1.3) && !is_over(0.9, 0.8));
    // One record shows it where slow noise cannot: three times as far above the noise. Beside an effect it does not count.
    candidate.judged.records = vec![1.0, 1.91];
    assert!(has_gap(&candidate, 1.3));
    candidate.judged.records = vec![1.0, 1.89];
    assert!(!has_gap(&candidate, 1.3));
    candidate.judged.records = vec![1.0, 9.0];
    candidate.picks = vec![(0, 0)];
    assert!(!has_gap(&candidate, 1.3));
}

#[test]
fn families_stand_by_rank_and_those_that_were_not_fitted_by_promise() {
    let synthetic = Synthetic::new(&[], &[]);
    let fitted = synthetic.retuned();
    let entry = |family, screening, rank: Option<f64>| RankedFamily {
        family,
        screening,
        best: rank.map(|rank| Candidate { rank, ..fitted.clone() }),
        why: None,
    };
    let mut looked = vec![
        entry(6, 0.1, None),
        entry(1, 0.1, Some(3.0)),
        entry(5, 0.2, None),
        entry(3, 0.2, None),
        entry(2, 0.9, Some(-4.0)),
        entry(0, 0.2, Some(3.0)),
        entry(4, 0.7, None),
    ];
    sort(&mut looked);
    assert_eq!(listed(&looked), [2, 0, 1, 4, 3, 5, 6]);
}

#[test]
fn a_change_reaches_every_candidate_that_was_fitted() {
    let synthetic = Synthetic::new(&[], &[]);
    let fitted = synthetic.retuned();
    let entry = |rank: f64| RankedFamily {
        family: 0,
        screening: 0.0,
        best: Some(Candidate { rank, ..fitted.clone() }),
        why: None,
    };
    let none = || RankedFamily { family: 0, screening: 0.0, best: None, why: None };
    let mut found = Found {
        base: Candidate { rank: 0.0, ..fitted.clone() },
        last: Candidate { rank: 1.0, ..fitted.clone() },
        rivals: vec![vec![entry(2.0), none()], vec![entry(3.0), entry(4.0)]],
        first: vec![none(), entry(5.0)],
        alone: Vec::new(),
        beyond: Some(Candidate { rank: 6.0, ..fitted.clone() }),
        faint: Vec::new(),
    };
    let mut seen = Vec::new();
    found.each(|c| {
        seen.push(c.rank);
        c.rank += 10.0;
    });
    assert_eq!(seen, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(found.base.rank, 10.0);
    assert_eq!(found.rivals[1][1].best.as_ref().unwrap().rank, 14.0);
    assert_eq!(found.first[1].best.as_ref().unwrap().rank, 15.0);
}
