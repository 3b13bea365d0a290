use components::effects::{AMPLIFIER_BANDWIDTH, CLOCK_OFFSET, CREEP, DAC_QUANTISATION, DELAY};

use nalgebra::DMatrix;

use super::*;
use crate::chain::Chain;
use crate::fit::Fit;
use crate::score::Judged;

/// What is left over the noise on training and held-out rows, the rank, the coefficients.
fn candidate((training, held_out): (f64, f64), rank: f64, freedom: usize) -> Candidate {
    Candidate {
        picks: Vec::new(),
        chain: Chain { nodes: Vec::new(), parameters: Vec::new(), drive: 0, nuisances: Vec::new() },
        fit: Fit {
            theta: Vec::new(),
            mean_square: 1.0 + training,
            deviations: Vec::new(),
            information: DMatrix::zeros(0, 0),
        },
        judged: Judged {
            residual: Vec::new(),
            held_out: 1.0 + held_out,
            training: 1.0 + training,
            log_band: 0.0,
            blocks: Vec::new(),
            records: Vec::new(),
        },
        training: 1.0 + training,
        rank,
        freedom,
        against: f64::INFINITY,
    }
}

fn looked(family: usize, best: Option<Candidate>) -> RankedFamily {
    RankedFamily { family, screening: 0.0, best, why: None }
}

/// A large gap of the re-tuned model, of which nothing need be left.
fn sight(library: &[Family]) -> BeliefContext<'_> {
    BeliefContext { library, base_excess: 10.0, adequate: 1.1, fine: 0.0, caused: 0.0, noise: 1.0 }
}

/// Families of no group.
fn ungrouped() -> Vec<Family> {
    (0..8).map(|_| Family::new(&CLOCK_OFFSET, Vec::new())).collect()
}

fn all(looked: &[RankedFamily]) -> Vec<(usize, f64)> {
    let own = candidate((0.0, 0.0), 0.0, 1);
    let library = ungrouped();
    beliefs(&sight(&library), looked, &own).iter().map(|b| (b.family, b.probability)).collect()
}

fn close(is: f64, wanted: f64) {
    assert!((is - wanted).abs() < 1e-9 * wanted.abs().max(1e-3), "{is}, not {wanted}");
}

/// Odds of family `of` against family `to`.
fn odds(all: &[(usize, f64)], of: usize, to: usize) -> f64 {
    let find = |family| all.iter().find(|(f, _)| *f == family).unwrap().1;
    find(of) / find(to)
}

fn believe(all: &[(usize, f64)]) -> Vec<Belief> {
    all.iter()
        .map(|(family, probability)| Belief {
            family: *family,
            probability: *probability,
            left: 1.0,
        })
        .collect()
}

#[test]
fn what_was_not_fitted_has_no_probability() {
    assert!(all(&[]).is_empty());
    assert!(all(&[looked(3, None)]).is_empty());
    let found = all(&[looked(3, None), looked(5, Some(candidate((0.0, 0.0), 0.0, 1)))]);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].0, 5);
    close(found[0].1, Thresholds::LIBRARY);
}

#[test]
fn a_rival_that_leaves_twice_as_much_has_a_64th_of_the_odds() {
    // 0.09 and 0.19 left, and 0.01 that the right one may leave unseen: twice as much.
    let near = looked(0, Some(candidate((0.07, 0.11), 0.0, 1)));
    let far = looked(1, Some(candidate((0.25, 0.13), 1e3, 1)));
    let found = all(&[near.clone(), far]);
    close(odds(&found, 1, 0), 1.0 / 64.0);
    close(found[0].1 + found[1].1, Thresholds::LIBRARY);
    // Four times as much: 0.39.
    let farther = looked(1, Some(candidate((0.39, 0.39), 1e3, 1)));
    close(odds(&all(&[near, farther]), 1, 0), 1.0 / 4096.0);
}

#[test]
fn what_the_command_does_not_cause_is_noise_where_all_rows_have_it() {
    let library = ungrouped();
    let best = candidate((0.07, 0.11), 0.0, 1);
    let odds_of = |caused| {
        let rivals =
            [looked(0, Some(best.clone())), looked(1, Some(candidate((0.25, 0.13), 1e3, 1)))];
        let sight = sight(&library).with_left(&best, caused);
        let found = beliefs(&sight, &rivals, &best);
        odds(&found.iter().map(|b| (b.family, b.probability)).collect::<Vec<_>>(), 1, 0)
    };
    // 0.02 over the noise and 0.01 unseen: 0.10 more is 13/3 times as much.
    close(odds_of(Some(0.0)), (3.0_f64 / 13.0).powi(6));
    // What the command causes is none, nor is anything where nobody knows.
    close(odds_of(Some(0.09)), 1.0 / 64.0);
    close(odds_of(None), 1.0 / 64.0);
    // Not more than fitted rows have, and not more than is unknown of the noise: adequate is 1.1.
    let noise = |left| sight(&library).with_left(&candidate(left, 0.0, 1), Some(0.0)).noise;
    close(noise((0.0, 1.0)), 1.0);
    close(noise((1.0, 0.05)), 1.05);
    close(noise((0.5, 0.5)), 1.1);
}

#[test]
fn a_rival_that_all_rows_leave_open_keeps_odds() {
    let own = looked(0, Some(candidate((0.0, 0.0), 0.0, 1)));
    let rival = |against| looked(1, Some(Candidate { against, ..candidate((0.0, 5.0), 1e3, 1) }));
    // What it leaves on the held-out rows alone would exclude it.
    assert!(odds(&all(&[own.clone(), rival(f64::INFINITY)]), 1, 0) < 1e-12);
    close(odds(&all(&[own.clone(), rival(1.9)]), 1, 0), (-1.9_f64).exp());
    let found = all(&[own, rival(1.9)]);
    assert_eq!(set(&believe(&found)), [0, 1], "it stays in the set");
    // Twice as much on all rows; ranks that differ by 2.
    let (library, two) = (ungrouped(), 2.0_f64);
    close(against(&sight(&library), 1.19, 1.09, 1e3), 6.0 * two.ln());
    close(against(&sight(&library), 1.19, 1.09, 2.0), 1.0);
    close(against(&sight(&library), 1.05, 1.09, 1e3), 0.0);
}

#[test]
fn the_odds_fall_no_further_than_the_ranks_say() {
    // Twice as much would be odds of 1 : 64; ranks that differ by 2 say 1 : e.
    let near = looked(0, Some(candidate((0.09, 0.09), 7.0, 1)));
    let far = looked(1, Some(candidate((0.19, 0.19), 9.0, 1)));
    close(odds(&all(&[near, far]), 1, 0), (-1.0_f64).exp());
}

#[test]
fn the_best_is_that_of_the_least_rank() {
    // The second leaves less, but stands behind in rank: no better than its equal, no worse either.
    let first = looked(0, Some(candidate((0.19, 0.19), -4.0, 1)));
    let second = looked(1, Some(candidate((0.09, 0.09), 1e3, 1)));
    let third = looked(2, Some(candidate((0.39, 0.39), 1e3, 1)));
    let found = all(&[third, second, first]);
    close(odds(&found, 1, 0), 1.0);
    // 0.40 against 0.20, and not against the 0.10 of the second.
    close(odds(&found, 2, 0), 1.0 / 64.0);
}

#[test]
fn rivals_that_all_leave_less_than_the_noise_are_told_apart_by_the_difference() {
    // The noise may be smaller than it was taken for; it is the same for both: (0.01 + 0.01) / 0.01 to the sixth.
    let near = looked(1, Some(candidate((-0.10, -0.10), 0.0, 1)));
    let far = looked(0, Some(candidate((-0.09, -0.09), 1e3, 1)));
    let found = all(&[near, far]);
    close(odds(&found, 0, 1), 1.0 / 64.0);
    assert_eq!(found[0].0, 1, "and not in the order of the library");
}

#[test]
fn of_those_that_leave_alike_the_one_with_fewer_coefficients_is_more_probable() {
    let alike =
        |family, freedom, rank| looked(family, Some(candidate((0.09, 0.09), rank, freedom)));
    let found = all(&[alike(0, 5, 0.0), alike(1, 3, 1e3)]);
    close(odds(&found, 0, 1), (-1.6_f64 * 2.0).exp());
    assert_eq!(found[0].0, 1, "most probable first");
    // 1.2 times as much is alike still: both the power of the factor and the coefficients count.
    let nearly = looked(2, Some(candidate((0.11, 0.11), 1e3, 4)));
    let found = all(&[alike(0, 3, 0.0), nearly]);
    close(odds(&found, 1 + 1, 0), 1.2_f64.powi(-6) * (-1.6_f64).exp());
    // Twice as much is not: its coefficients count neither against it nor against the others.
    let far = looked(3, Some(candidate((0.19, 0.19), 1e3, 1)));
    let found = all(&[alike(0, 5, 0.0), far]);
    close(odds(&found, 3, 0), 1.0 / 64.0);
    let far = looked(3, Some(candidate((0.19, 0.19), 1e3, 9)));
    let found = all(&[alike(0, 5, 0.0), far]);
    close(odds(&found, 3, 0), 1.0 / 64.0);
}

#[test]
fn equals_stand_in_the_order_of_the_library() {
    let same = |family| looked(family, Some(candidate((0.1, 0.1), 0.0, 1)));
    let order = |found: Vec<(usize, f64)>| found.iter().map(|(f, _)| *f).collect::<Vec<_>>();
    assert_eq!(order(all(&[same(4), same(2), same(3)])), [2, 3, 4]);
}

#[test]
fn the_more_is_left_the_less_is_the_cause_in_the_library() {
    let library = ungrouped();
    let sight = sight(&library);
    let known = |left: f64, sight: &BeliefContext<'_>| {
        let own = candidate((left, left), 0.0, 1);
        let found = beliefs(sight, &[looked(0, Some(own.clone()))], &own);
        found[0].probability
    };
    close(known(0.0, &sight), Thresholds::LIBRARY);
    close(known(0.1, &sight), Thresholds::LIBRARY);
    // 12 % of the gap over what may be left: as likely in the library as not.
    close(known(0.1 + 1.2, &sight), Thresholds::LIBRARY / 2.0);
    close(known(0.1 + 2.4, &sight), Thresholds::LIBRARY / (1.0 + 2.0_f64.powf(1.2)));
    // A smaller gap: the same is a larger part. One that is hardly there counts as a tenth of the noise.
    close(
        known(0.1 + 0.6, &BeliefContext { base_excess: 5.0, ..sight }),
        Thresholds::LIBRARY / 2.0,
    );
    close(
        known(0.1 + 0.012, &BeliefContext { base_excess: 0.01, ..sight }),
        Thresholds::LIBRARY / 2.0,
    );
    close(known(0.3 + 1.2, &BeliefContext { adequate: 1.3, ..sight }), Thresholds::LIBRARY / 2.0);
}

#[test]
fn a_name_of_a_group_is_less_sure_as_what_is_in_no_library_looks_like_it_too() {
    let library = library();
    let sight = sight(&library);
    let own = candidate((0.0, 0.0), 0.0, 1);
    let believe = |rivals: &[(usize, f64)]| {
        let looked: Vec<RankedFamily> = rivals
            .iter()
            .map(|(family, left)| looked(*family, Some(candidate((*left, *left), 1e3 * left, 1))))
            .collect();
        beliefs(&sight, &looked, &own).iter().map(|b| b.probability).collect::<Vec<_>>()
    };
    close(believe(&[(0, 0.0)])[0], Thresholds::LIBRARY_OF_GROUPS);
    close(believe(&[(1, 0.0)])[0], Thresholds::LIBRARY);
    // Half of each: none of these is between, and the shares stay what they are.
    let even = believe(&[(0, 0.0), (1, 0.0)]);
    close(even[0], 0.25 * (Thresholds::LIBRARY + Thresholds::LIBRARY_OF_GROUPS));
    close(even[0], even[1]);
}

#[test]
fn what_takes_little_beside_others_may_only_repair_their_formulas() {
    let library = ungrouped();
    let sight = BeliefContext { base_excess: 100.0, ..sight(&library) };
    let is_effect = |alone, left| is_effect(&sight, &candidate((left, left), 0.0, 2), alone);
    // A hundredth of a gap of which a hundredth is left: a repair as likely as not, and a thirtieth of the
    // cut that none reaches.
    close(is_effect(0.01, 0.99), 1.0 - 1.0 / (2.0 + 30.0_f64.powf(-1.2)));
    assert!(is_effect(0.1, 1.0) > 0.93 && is_effect(0.002, 1.0) < 0.15);
    // As little, but a hundred times what is left at last.
    assert!(is_effect(0.01, 0.0) > 0.8, "{}", is_effect(0.01, 0.0));
    close(is_effect(0.0, 1.0), 0.0);
}

#[test]
fn the_gap_is_what_the_retuned_model_leaves_over_the_noise() {
    let sight = BeliefContext::new(&[], &candidate((9.0, 4.0), 0.0, 0), 1.2, 0.0);
    close(sight.base_excess, 4.0);
    close(sight.adequate, 1.2);
    assert_eq!(BeliefContext::new(&[], &candidate((9.0, -0.3), 0.0, 0), 1.2, 0.0).base_excess, 0.0);
}

fn library() -> Vec<Family> {
    let effects = [&DELAY, &CLOCK_OFFSET, &AMPLIFIER_BANDWIDTH, &DAC_QUANTISATION, &CREEP];
    effects.into_iter().map(|effect| Family::new(effect, Vec::new())).collect()
}

#[test]
fn a_name_is_trusted_with_its_group() {
    let library = library();
    // Delay and amplifier bandwidth are one group; clock offset and quantisation are in none.
    let found = believe(&[(0, 0.4), (1, 0.2), (2, 0.1), (3, 0.06), (4, 0.04)]);
    // What they would have at most, by their shares.
    let most = (0.54 * Thresholds::LIBRARY_OF_GROUPS + 0.26 * Thresholds::LIBRARY) / 0.8;
    close(trust(&library, &found, 0), 0.5 / most);
    close(trust(&library, &found, 2), 0.5 / most);
    close(trust(&library, &found, 1), 0.2 / most);
    close(trust(&library, &found, 4), 0.04 / most);
    // That more of a group is in no library says nothing against the one that was found.
    close(trust(&library, &believe(&[(0, 0.5 * Thresholds::LIBRARY_OF_GROUPS)]), 0), 0.5);
    close(trust(&library, &believe(&[(1, 0.5 * Thresholds::LIBRARY)]), 1), 0.5);
    assert_eq!(
        trust(&library, &[], 1).partial_cmp(&Thresholds::TRUSTED),
        Some(std::cmp::Ordering::Less)
    );
}

#[test]
fn the_set_is_the_smallest_that_reaches_95_per_cent_of_what_is_known() {
    assert_eq!(set(&believe(&[(7, 0.97), (1, 0.01)])), [7]);
    assert_eq!(set(&believe(&[(7, 0.90), (1, 0.07), (2, 0.01)])), [7, 1]);
    // Of what is known: 0.48 of 0.50.
    assert_eq!(set(&believe(&[(7, 0.40), (1, 0.08), (2, 0.02)])), [7, 1]);
    // Exactly 0.95 is enough.
    assert_eq!(set(&believe(&[(7, 0.95), (1, 0.05)])), [7]);
    assert!(set(&[]).is_empty());
}

#[test]
fn what_is_good_enough_tells_no_names_apart() {
    let library = ungrouped();
    let near = candidate((0.09, 0.09), 0.0, 1);
    let rivals = [looked(0, Some(near.clone())), looked(1, Some(candidate((0.19, 0.19), 1e3, 1)))];
    let odds_with = |fine: f64| {
        let sight = BeliefContext { fine, ..sight(&library) };
        let found = beliefs(&sight, &rivals, &near);
        found[1].probability / found[0].probability
    };
    close(odds_with(0.0), 1.0 / 64.0);
    close(odds_with(0.9), 1.1_f64.powi(-6));
}

#[test]
fn names_that_leave_alike_are_trusted_together() {
    let library = library();
    let of = |family, probability, left| Belief { family, probability, left };
    // Clock offset, quantisation and creep are of no group with each other.
    let found = [of(1, 0.2, 1.0), of(3, 0.2, 1.2), of(4, 0.2, 1.3)];
    let single = trust(&library, &found, 1);
    close(trust_of_alike(&library, &found, 1), 2.0 * single);
    close(trust_of_alike(&library, &found, 3), 3.0 * trust(&library, &found, 3));
}
