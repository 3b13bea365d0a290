//! What is believed, at the limits of each rule.

use super::*;
use crate::formula::{Formula, Free};
use crate::noise::Shape;
use crate::nuisance::Nuisance;
use crate::score::Judge;
use crate::select::refine::plainer;
use crate::select::test_support::Synthetic;

/// Two families, and the second one with a line in the spectrum as its second formula. No rows are held
/// out: the level of the bands then counts from 0, and every figure can be chosen.
struct Figures {
    synthetic: Synthetic,
    any: Candidate,
}

impl Figures {
    fn new() -> Self {
        let mut synthetic = Synthetic::new(&[], &[&[(3, 1.0)], &[(5, 1.0)], &[(7, 1.0)]]);
        synthetic.judge = Judge::new(&synthetic.data.without(|_| false), Shape::WHITE);
        let mut line = Formula::new("line").start(&[75.0]);
        line.parameters = vec![Free::log("frequency", "Hz", 70.0, 80.0)];
        line.nuisance = Some(Nuisance::Lines { parameter: 0, harmonics: 1 });
        synthetic.library[1].formulas.push(line);
        let any = synthetic.retuned();
        Self { synthetic, any }
    }

    /// A set of so many effects that takes this part of a gap of 10 powers of the noise, and this part of
    /// the levels of the bands; its rank falls with each effect.
    fn set(&self, effects: usize, power: f64, bands: f64) -> Candidate {
        let mut c = self.any.clone();
        c.picks = (0..effects).map(|family| (family, 0)).collect();
        c.judged.held_out = 1.0 + 10.0 * (1.0 - power);
        c.judged.training = c.judged.held_out;
        c.judged.log_band = 1.0 - bands;
        c.judged.blocks = vec![20.0; 10];
        c.rank = -100.0 * effects as f64;
        c.freedom = effects;
        c
    }

    fn base(&self) -> Candidate {
        self.set(0, 0.0, 0.0)
    }

    /// Whether the set is one more effect that is believed, where its blocks' losses are less than before
    /// by so many standard errors.
    fn is_worth_it(&self, before: &Candidate, mut after: Candidate, errors: f64) -> bool {
        // Differences of 0.1·errors ± 0.3 in turn: 0.3/√9 is the standard error of ten.
        for (k, block) in after.judged.blocks.iter_mut().enumerate() {
            let turn = if k % 2 == 0 { 0.3 } else { -0.3 };
            *block *= (turn - 0.1 * errors).exp();
        }
        self.synthetic.search().is_worth_it(&self.base(), before, &after)
    }

    fn is_first(&self, power: f64, bands: f64, errors: f64) -> bool {
        self.is_worth_it(&self.base(), self.set(1, power, bands), errors)
    }

    /// Whether a second effect is believed beside one that takes these parts.
    fn is_further(&self, before: (f64, f64), after: (f64, f64), errors: f64) -> bool {
        let before = self.set(1, before.0, before.1);
        self.is_worth_it(&before, self.set(2, after.0, after.1), errors)
    }

    /// The re-tuned model and one effect where the rows that are held out show no gap: what each leaves
    /// there and on the fitted rows.
    fn fitted(&self, before: (f64, f64), after: (f64, f64)) -> (Candidate, Candidate) {
        let figures = |effects, (held_out, training)| {
            let mut c = self.set(effects, 0.0, 0.0);
            (c.judged.held_out, c.judged.training) = (held_out, training);
            c
        };
        (figures(0, before), figures(1, after))
    }

    fn is_fitted_well(&self, before: (f64, f64), after: (f64, f64)) -> bool {
        let (before, after) = self.fitted(before, after);
        self.synthetic.search().is_fitted_well(&before, &after)
    }
}

#[test]
fn what_is_left_is_the_mean_over_fitted_and_held_out_rows_less_the_noise() {
    let figures = Figures::new();
    let left = |held_out, training| {
        let mut c = figures.base();
        (c.judged.held_out, c.judged.training) = (held_out, training);
        left(&c)
    };
    assert_eq!(left(3.0, 6.0), 3.5);
    assert_eq!(left(6.0, 3.0), 3.5);
    // Never less than what can be divided by.
    assert_eq!(left(0.8, 1.0), 1e-3);
}

#[test]
fn a_first_effect_needs_a_score_that_the_blocks_agree_upon() {
    let figures = Figures::new();
    assert!(figures.is_first(0.25, 0.25, 3.2));
    assert!(!figures.is_first(0.25, 0.25, 2.8), "the blocks do not agree");
    assert!(!figures.is_first(0.15, 0.15, 9.0), "the score is low");
    // The score is the mean of the power's part and the bands'.
    assert!(figures.is_first(0.41, 0.0, 3.2) && figures.is_first(0.0, 0.41, 3.2));
    assert!(!figures.is_first(0.39, 0.0, 3.2) && !figures.is_first(0.0, 0.39, 3.2));
    assert!(!figures.is_first(0.4, 0.0, 3.2), "0.2 is not above 0.2");
}

#[test]
fn a_first_effect_that_takes_most_of_the_power_needs_no_blocks() {
    let figures = Figures::new();
    assert!(figures.is_first(0.85, 0.40, 0.0));
    assert!(!figures.is_first(0.85, 0.30, 0.0), "the score is below 0.6");
    assert!(!figures.is_first(0.75, 0.60, 0.0), "the power is below 0.8");
    assert!(figures.is_first(0.8, 0.5, 0.0), "0.8 is enough");
}

#[test]
fn a_first_effect_that_only_the_fitted_rows_show_is_worth_it() {
    let figures = Figures::new();
    let (base, after) = figures.fitted((1.2, 11.0), (1.1, 1.5));
    assert!(figures.synthetic.search().is_worth_it(&base, &base, &after));
    let (base, after) = figures.fitted((1.2, 11.0), (1.1, 3.0));
    assert!(!figures.synthetic.search().is_worth_it(&base, &base, &after));
}

#[test]
fn an_effect_that_is_no_better_in_rank_is_not_worth_it() {
    let figures = Figures::new();
    let after = figures.set(1, 0.9, 0.9);
    let with_rank = |rank| Candidate { rank, ..after.clone() };
    assert!(figures.is_worth_it(&figures.base(), with_rank(-0.1), 9.0));
    assert!(!figures.is_worth_it(&figures.base(), with_rank(0.0), 9.0));
    assert!(!figures.is_worth_it(&figures.base(), with_rank(5.0), 9.0));
}

#[test]
fn a_further_effect_must_bring_a_part_of_the_gap_and_cut_what_is_left() {
    let figures = Figures::new();
    // 5 are left, then 3.
    assert!(figures.is_further((0.5, 0.5), (0.7, 0.5), 4.2));
    assert!(!figures.is_further((0.5, 0.5), (0.7, 0.5), 3.8), "the blocks do not agree");
    assert!(!figures.is_further((0.5, 0.5), (0.65, 0.5), 9.0), "3.5 are left of 5: not cut by 1.5");
    assert!(figures.is_further((0.5, 0.5), (0.67, 0.5), 9.0), "3.3 are left of 5");
    // 1 is left, then 0.5: a small part of the gap.
    assert!(!figures.is_further((0.90, 0.5), (0.95, 0.5), 9.0));
    assert!(!figures.is_further((0.84, 0.5), (0.915, 0.5), 9.0));
    assert!(figures.is_further((0.84, 0.5), (0.925, 0.5), 9.0));
    // The same where the bands say that much goes.
    assert!(figures.is_further((0.90, 0.5), (0.95, 0.77), 9.0));
    assert!(!figures.is_further((0.90, 0.5), (0.95, 0.73), 9.0));
}

#[test]
fn a_small_effect_is_believed_where_nothing_is_left_with_it() {
    let figures = Figures::new();
    // 0.8 are left, then 0.2, which may be noise: less than 0.3.
    assert!(figures.is_further((0.92, 0.5), (0.98, 0.5), 4.2));
    assert!(!figures.is_further((0.92, 0.5), (0.98, 0.5), 3.8));
    // Where the noise is known so well that 0.2 are a gap, something is left.
    let search = Search { adequate: 1.1, ..figures.synthetic.search() };
    let (before, after) = (figures.set(1, 0.92, 0.5), figures.set(2, 0.98, 0.5));
    let mut agreed = after.clone();
    agreed.judged.blocks = (0..10).map(|k| 5.0 + f64::from(k % 2)).collect();
    assert!(!search.is_worth_it(&figures.base(), &before, &agreed));
    assert!(figures.synthetic.search().is_worth_it(&figures.base(), &before, &agreed));
    // 0.5 to 0.2 is cut by less than 3.
    assert!(!figures.is_further((0.95, 0.5), (0.98, 0.5), 9.0));
    assert!(figures.is_further((0.938, 0.5), (0.98, 0.5), 9.0));
}

#[test]
fn a_further_effect_that_is_most_of_what_was_left_and_leaves_nothing_needs_no_blocks() {
    let figures = Figures::new();
    // 1 is left, then 0.18, which may be noise; or 0.22, with which less than 0.8 of it goes.
    assert!(figures.is_further((0.9, 0.5), (0.982, 0.5), 0.0));
    assert!(!figures.is_further((0.9, 0.5), (0.978, 0.5), 0.0));
    // 5 are left, then 0.4: something is left.
    assert!(!figures.is_further((0.5, 0.5), (0.96, 0.5), 0.0));
}

#[test]
fn a_further_effect_that_cuts_sharply_may_be_small_and_leave_something() {
    let figures = Figures::new();
    // Where the noise is known so well that 0.05 are a gap: 0.7 are left, then 0.06 or 0.08.
    let search = Search { adequate: 1.05, ..figures.synthetic.search() };
    let before = figures.set(1, 0.93, 0.5);
    let is_worth_it = |power, errors: f64| {
        let mut after = figures.set(2, power, 0.5);
        let turns = (0..10).map(|k| if k % 2 == 0 { 0.3 } else { -0.3 });
        after.judged.blocks = turns.map(|turn| 20.0 * f64::exp(turn - 0.1 * errors)).collect();
        search.is_worth_it(&figures.base(), &before, &after)
    };
    assert!(is_worth_it(0.994, 4.2));
    assert!(!is_worth_it(0.994, 3.8), "the blocks do not agree");
    assert!(!is_worth_it(0.992, 4.2), "0.08 are left of 0.7: cut by less than 10");
    // 20 are left, then 0.95 or 1.05, of a gap of 1000.
    let powers = |effects, power: f64| {
        let mut c = figures.set(effects, 0.5, 0.5);
        (c.judged.held_out, c.judged.training) = (1.0 + power, 1.0 + power);
        c
    };
    let sharply = |left: f64| {
        let mut after = powers(2, left);
        after.judged.blocks = (0..10).map(|k| 5.0 + f64::from(k % 2)).collect();
        search.is_worth_it(&powers(0, 1000.0), &powers(1, 20.0), &after)
    };
    assert!(sharply(0.95));
    assert!(!sharply(1.05), "as much as the noise is left");
}

#[test]
fn a_third_effect_that_takes_nearly_all_of_what_two_leave_may_leave_more_than_the_noise() {
    let figures = Figures::new();
    let search = Search { adequate: 1.05, ..figures.synthetic.search() };
    // Of a gap of 1000 little is left before and after; held out and fitted are told apart.
    let left = |effects, held_out: f64, training: f64| {
        let mut c = figures.set(effects, 0.5, 0.5);
        (c.judged.held_out, c.judged.training) = (1.0 + held_out, 1.0 + training);
        c
    };
    let is_worth_it = |before: Candidate, held_out: f64, training: f64| {
        let mut after = left(before.picks.len() + 1, held_out, training);
        after.judged.blocks = (0..10).map(|k| 5.0 + f64::from(k % 2)).collect();
        search.is_worth_it(&left(0, 1000.0, 1000.0), &before, &after)
    };
    assert!(is_worth_it(left(2, 20.0, 20.0), 1.9, 4.0));
    assert!(!is_worth_it(left(1, 20.0, 20.0), 1.9, 4.0), "a second one must leave less");
    assert!(!is_worth_it(left(2, 20.0, 20.0), 2.1, 2.1), "a tenth of it is left");
    assert!(!is_worth_it(left(2, 20.0, 20.0), 1.9, 12.0), "all rows together are not cut by 3");
}

#[test]
fn rows_that_are_held_out_without_a_gap_leave_it_to_the_fitted_ones() {
    let figures = Figures::new();
    // 9 of 10 powers of the noise must go.
    assert!(figures.is_fitted_well((1.2, 11.0), (1.1, 1.95)));
    assert!(!figures.is_fitted_well((1.2, 11.0), (1.1, 2.05)));
    // 1.3 is where a gap begins.
    assert!(figures.is_fitted_well((1.3, 11.0), (1.1, 1.5)));
    assert!(!figures.is_fitted_well((1.35, 11.0), (1.1, 1.5)), "the held-out rows show it");
    assert!(!figures.is_fitted_well((1.2, 1.3), (1.1, 0.9)), "no rows show it");
    assert!(figures.is_fitted_well((1.2, 1.31), (1.1, 0.9)));
    // Nothing may be lost on the others.
    assert!(figures.is_fitted_well((1.2, 11.0), (1.2, 1.5)));
    assert!(!figures.is_fitted_well((1.2, 11.0), (1.21, 1.5)));
}

#[test]
fn what_only_the_fitted_rows_show_takes_few_coefficients_and_no_terms_of_each_record() {
    let figures = Figures::new();
    let search = figures.synthetic.search();
    let (base, after) = figures.fitted((1.2, 11.0), (1.1, 1.5));
    let with = |freedom, picks: &[(usize, usize)]| {
        let set = Candidate { freedom, picks: picks.to_vec(), ..after.clone() };
        search.is_fitted_well(&base, &set)
    };
    assert!(with(4, &[(0, 0)]) && !with(5, &[(0, 0)]));
    assert!(with(8, &[(0, 0), (1, 0)]) && !with(9, &[(0, 0), (1, 0)]));
    assert!(!with(4, &[(1, 1)]));
}

#[test]
fn effects_are_named_where_they_explain_enough_together() {
    let figures = Figures::new();
    let search = figures.synthetic.search();
    let enough = |set: &Candidate| search.explains_enough(&figures.base(), set);
    let holds = |power: f64, bands: f64| enough(&figures.set(1, power, bands));
    // A score of 0.6 with half of the power.
    assert!(holds(0.55, 0.67) && !holds(0.55, 0.63));
    assert!(!holds(0.45, 0.90));
    // Or 0.9 of the power, and a score of 0.35.
    assert!(holds(0.92, -0.20) && !holds(0.92, -0.24));
    assert!(!holds(0.88, 0.30));
    // A line in the spectrum by itself takes 0.8 of the power.
    let line = |effects, power: f64| {
        let mut set = figures.set(effects, power, 0.9);
        set.picks[effects - 1] = (1, 1);
        set
    };
    assert!(enough(&line(1, 0.85)) && !enough(&line(1, 0.75)));
    assert!(enough(&line(2, 0.75)));
    // Or nearly all goes where only the fitted rows show it.
    let (base, after) = figures.fitted((1.2, 11.0), (1.1, 1.5));
    assert!(search.explains_enough(&base, &after));
    let (base, after) = figures.fitted((1.2, 11.0), (1.1, 3.0));
    assert!(!search.explains_enough(&base, &after));
}

#[test]
fn a_set_that_is_far_from_enough_is_hopeless() {
    let figures = Figures::new();
    let search = figures.synthetic.search();
    let hopeless =
        |power, bands| search.is_hopeless(&figures.base(), &figures.set(2, power, bands));
    assert!(hopeless(0.25, 0.50));
    assert!(!hopeless(0.25, 0.57), "a score of 0.4");
    assert!(!hopeless(0.32, 0.10), "a power of 0.3");
    let (base, after) = figures.fitted((1.2, 11.0), (1.2, 1.5));
    assert!(!search.is_hopeless(&base, &after), "the fitted rows show it alone");
    let (base, after) = figures.fitted((1.2, 11.0), (1.2, 3.0));
    assert!(search.is_hopeless(&base, &after));
}

/// Rivals of one slot that leave alike, with these families, ranks and coefficients.
fn alike(figures: &Figures, all: &[(usize, f64, usize)]) -> Vec<RankedFamily> {
    let entry = |&(family, rank, freedom): &(usize, f64, usize)| {
        let mut best = figures.set(1, 0.99, 0.99);
        best.picks = vec![(family, 0)];
        best.fit.mean_square = best.judged.training;
        (best.rank, best.freedom) = (rank, freedom);
        RankedFamily { family, screening: 0.0, best: Some(best), why: None }
    };
    all.iter().map(entry).collect()
}

#[test]
fn of_single_effects_that_leave_alike_the_one_with_fewer_coefficients_is_named() {
    let figures = Figures::new();
    let (search, base) = (figures.synthetic.search(), figures.base());
    let sight = search.sight(&base);
    let looked = alike(&figures, &[(0, -100.0, 9), (2, -98.0, 4), (1, -99.0, 1)]);
    let own = looked[0].best.clone().unwrap();
    let mut rivals = vec![looked];
    let named = search.most_probable(&sight, &mut rivals, own.clone());
    assert_eq!(named.picks, [(1, 0)]);
    assert_eq!(named.rank, -99.0);
    let again = search.most_probable(&sight, &mut rivals, named);
    assert_eq!(again.rank, -99.0, "itself, where it is the most probable");
}

#[test]
fn an_effect_beside_others_gives_way_to_what_is_more_probable_beside_the_same() {
    let figures = Figures::new();
    let (search, base) = (figures.synthetic.search(), figures.base());
    let sight = search.sight(&base);
    // The effects 0 and 1; in place of 0 there is 2, with fewer coefficients.
    let pair = figures.set(2, 0.99, 0.99);
    let beside = |with: (usize, usize)| {
        let mut all = alike(&figures, &[(0, -100.0, 9), (2, -99.0, 1)]);
        for candidate in all.iter_mut().filter_map(|l| l.best.as_mut()) {
            candidate.picks.insert(0, with);
        }
        all
    };
    let first = alike(&figures, &[(1, -100.0, 1)]);
    let mut rivals = vec![beside((1, 0)), first.clone()];
    let named = search.most_probable(&sight, &mut rivals, pair.clone());
    assert_eq!(named.picks, [(1, 0), (2, 0)]);
    let families = |looked: &[RankedFamily]| looked.iter().map(|l| l.family).collect::<Vec<_>>();
    assert_eq!(families(&rivals[1]), [0, 2], "the list goes with its effect");
    // Rivals that stand alone are no answer, nor are those beside another formula of the second.
    let alone = alike(&figures, &[(0, -100.0, 9), (2, -98.0, 4), (1, -99.0, 1)]);
    let kept = search.most_probable(&sight, &mut vec![alone.clone(), alone], pair.clone());
    assert_eq!(kept.picks, [(0, 0), (1, 0)]);
    let mut rivals = vec![beside((1, 1)), first];
    assert_eq!(search.most_probable(&sight, &mut rivals, pair).picks, [(0, 0), (1, 0)]);
}

#[test]
fn of_the_formulas_of_a_family_the_best_plainer_one_that_is_little_behind_is_fitted_to_its_end() {
    let figures = Figures::new();
    let entries = alike(
        &figures,
        &[
            (3, -100.0, 5),
            (3, -80.0, 5),
            (3, -75.0, 4),
            (3, -90.0, 3),
            (3, -69.0, 1),
            (4, -99.0, 1),
        ],
    );
    let others: Vec<Candidate> = entries.iter().filter_map(|entry| entry.best.clone()).collect();
    let found = plainer(&entries[0], &others[1..]).map(|c| (c.rank, c.freedom));
    assert_eq!(found, Some((-90.0, 3)));
    assert!(plainer(&entries[4], &others).is_none(), "it is the plainest");
    let far = alike(&figures, &[(3, -100.1, 5), (3, -70.0, 1)]);
    assert!(plainer(&far[0], &[far[1].best.clone().unwrap()]).is_none(), "too far behind");
}

#[test]
fn a_name_may_change_once_the_noise_is_known_better() {
    let figures = Figures::new();
    let looked = alike(&figures, &[(0, -100.0, 9), (1, -99.0, 1)]);
    let last = looked[0].best.clone().unwrap();
    let rivals = vec![looked.clone()];
    let found = Found { last, rivals, first: looked, ..Found::nothing(figures.base()) };
    let mut found = Found { alone: vec![0.5], ..found };
    figures.synthetic.search().name_again(&mut found);
    assert_eq!(found.last.picks, [(1, 0)]);
    assert!((found.alone[0] - 0.99).abs() < 1e-12);
}

#[test]
fn a_single_effect_that_three_names_have_alike_is_one_of_them() {
    let figures = Figures::new();
    let (search, base) = (figures.synthetic.search(), figures.base());
    let named = |all: &[(usize, f64, usize)]| {
        let looked = alike(&figures, all);
        let best = looked[0].best.clone().unwrap();
        search.believed(&base, best, &mut vec![looked]).picks
    };
    assert_eq!(named(&[(0, -100.0, 1)]), [(0, 0)]);
    assert_eq!(named(&[(0, -100.0, 1), (1, -40.0, 3)]), [(0, 0)]);
    // The set holds all three.
    let three = alike(&figures, &[(0, -100.0, 1), (1, -100.0, 1), (2, -100.0, 1)]);
    assert_eq!(named(&[(0, -100.0, 1), (1, -100.0, 1), (2, -100.0, 1)]), [(0, 0)]);
    let own = three[0].best.clone().unwrap();
    assert_eq!(belief::set(&belief::beliefs(&search.sight(&base), &three, &own)).len(), 3);
    // Nor is one that explains too little, be its name sure, or nothing.
    let explains = |bands: f64| {
        let mut one = figures.set(1, 0.88, bands);
        one.fit.mean_square = one.judged.training;
        let looked =
            vec![RankedFamily { family: 0, screening: 0.0, best: Some(one.clone()), why: None }];
        search.believed(&base, one, &mut vec![looked]).picks
    };
    assert_eq!(explains(0.4), [(0, 0)]);
    assert!(explains(0.2).is_empty(), "0.54 is below 0.6, and 0.88 below 0.9");
    assert!(search.believed(&base, base.clone(), &mut Vec::new()).picks.is_empty());
}
