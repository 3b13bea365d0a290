use components::effects::{AMPLIFIER_BANDWIDTH, CLOCK_OFFSET, CREEP, DAC_QUANTISATION, DELAY};

use super::*;
use crate::chain::Chain;
use crate::fit::Fit;
use crate::score::Judged;

/// What is left over the noise on training and held-out rows, the rank, the coefficients.
fn candidate((training, held_out): (f64, f64), rank: f64, freedom: usize) -> Candidate {
    Candidate {
        picks: Vec::new(),
        chain: Chain { nodes: Vec::new(), parameters: Vec::new(), drive: 0, nuisances: Vec::new() },
        fit: Fit { theta: Vec::new(), mean_square: 1.0 + training, deviations: Vec::new() },
        judged: Judged {
            residual: Vec::new(),
            held_out: 1.0 + held_out,
            training: 1.0 + training,
            log_band: 0.0,
            blocks: Vec::new(),
        },
        rank,
        freedom,
    }
}

fn looked(family: usize, best: Option<Candidate>) -> Looked {
    Looked { family, screening: 0.0, best }
}

/// A large gap of the re-tuned model, of which nothing need be left.
const SIGHT: Sight = Sight { base_excess: 10.0, adequate: 1.1 };

fn all(looked: &[Looked]) -> Vec<(usize, f64)> {
    let own = candidate((0.0, 0.0), 0.0, 1);
    beliefs(&SIGHT, looked, &own).iter().map(|b| (b.family, b.probability)).collect()
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
        .map(|(family, probability)| Belief { family: *family, probability: *probability })
        .collect()
}

#[test]
fn what_was_not_fitted_has_no_probability() {
    assert!(all(&[]).is_empty());
    assert!(all(&[looked(3, None)]).is_empty());
    let found = all(&[looked(3, None), looked(5, Some(candidate((0.0, 0.0), 0.0, 1)))]);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].0, 5);
    close(found[0].1, LIBRARY);
}

#[test]
fn a_rival_that_leaves_twice_as_much_has_an_eighth_of_the_odds() {
    // 0.08 and 0.18 left, and 0.02 that is not told from nothing: twice as much.
    let near = looked(0, Some(candidate((0.06, 0.10), 0.0, 1)));
    let far = looked(1, Some(candidate((0.24, 0.12), 1e3, 1)));
    let found = all(&[near.clone(), far]);
    close(odds(&found, 1, 0), 1.0 / 8.0);
    close(found[0].1 + found[1].1, LIBRARY);
    // Four times as much: 0.38.
    let farther = looked(1, Some(candidate((0.38, 0.38), 1e3, 1)));
    close(odds(&all(&[near, farther]), 1, 0), 1.0 / 64.0);
}

#[test]
fn the_odds_fall_no_further_than_the_ranks_say() {
    // Twice as much would be odds of 1 : 8; ranks that differ by 2 say 1 : e.
    let near = looked(0, Some(candidate((0.08, 0.08), 7.0, 1)));
    let far = looked(1, Some(candidate((0.18, 0.18), 9.0, 1)));
    close(odds(&all(&[near, far]), 1, 0), (-1.0_f64).exp());
}

#[test]
fn the_best_is_that_of_the_least_rank() {
    // The second leaves less, but stands behind in rank: no better than its equal, no worse either.
    let first = looked(0, Some(candidate((0.18, 0.18), -4.0, 1)));
    let second = looked(1, Some(candidate((0.08, 0.08), 1e3, 1)));
    let third = looked(2, Some(candidate((0.38, 0.38), 1e3, 1)));
    let found = all(&[third, second, first]);
    close(odds(&found, 1, 0), 1.0);
    // 0.40 against 0.20, and not against the 0.10 of the second.
    close(odds(&found, 2, 0), 1.0 / 8.0);
}

#[test]
fn what_leaves_less_than_the_noise_leaves_nothing() {
    // Fitted too well: -0.5 counts as 0. Odds to 0.02 left: (0.04 / 0.02) cubed.
    let near = looked(0, Some(candidate((-0.5, -0.5), 0.0, 1)));
    let far = looked(1, Some(candidate((0.02, 0.02), 1e3, 1)));
    close(odds(&all(&[near, far]), 1, 0), 1.0 / 8.0);
}

#[test]
fn of_those_that_leave_alike_the_one_with_fewer_coefficients_is_more_probable() {
    let alike =
        |family, freedom, rank| looked(family, Some(candidate((0.08, 0.08), rank, freedom)));
    let found = all(&[alike(0, 5, 0.0), alike(1, 3, 1e3)]);
    close(odds(&found, 0, 1), (-1.2_f64 * 2.0).exp());
    assert_eq!(found[0].0, 1, "most probable first");
    // 1.2 times as much is alike still: both the power of the factor and the coefficients count.
    let nearly = looked(2, Some(candidate((0.1, 0.1), 1e3, 4)));
    let found = all(&[alike(0, 3, 0.0), nearly]);
    close(odds(&found, 1 + 1, 0), 1.2_f64.powi(-3) * (-1.2_f64).exp());
    // Twice as much is not: its coefficients count neither against it nor against the others.
    let far = looked(3, Some(candidate((0.18, 0.18), 1e3, 1)));
    let found = all(&[alike(0, 5, 0.0), far]);
    close(odds(&found, 3, 0), 1.0 / 8.0);
    let far = looked(3, Some(candidate((0.18, 0.18), 1e3, 9)));
    let found = all(&[alike(0, 5, 0.0), far]);
    close(odds(&found, 3, 0), 1.0 / 8.0);
}

#[test]
fn equals_stand_in_the_order_of_the_library() {
    let same = |family| looked(family, Some(candidate((0.1, 0.1), 0.0, 1)));
    let order = |found: Vec<(usize, f64)>| found.iter().map(|(f, _)| *f).collect::<Vec<_>>();
    assert_eq!(order(all(&[same(4), same(2), same(3)])), [2, 3, 4]);
}

#[test]
fn the_more_is_left_the_less_is_the_cause_in_the_library() {
    let known = |left: f64, sight: &Sight| {
        let own = candidate((left, left), 0.0, 1);
        let found = beliefs(sight, &[looked(0, Some(own.clone()))], &own);
        found[0].probability
    };
    close(known(0.0, &SIGHT), LIBRARY);
    close(known(0.1, &SIGHT), LIBRARY);
    // 12 % of the gap over what may be left: as likely in the library as not.
    close(known(0.1 + 1.2, &SIGHT), LIBRARY / 2.0);
    close(known(0.1 + 2.4, &SIGHT), LIBRARY / (1.0 + 2.0_f64.powf(1.2)));
    // A smaller gap: the same is a larger part. One that is hardly there counts as a tenth of the noise.
    close(known(0.1 + 0.6, &Sight { base_excess: 5.0, adequate: 1.1 }), LIBRARY / 2.0);
    close(known(0.1 + 0.012, &Sight { base_excess: 0.01, adequate: 1.1 }), LIBRARY / 2.0);
    close(known(0.3 + 1.2, &Sight { base_excess: 10.0, adequate: 1.3 }), LIBRARY / 2.0);
}

#[test]
fn the_gap_is_what_the_retuned_model_leaves_over_the_noise() {
    let sight = Sight::new(&candidate((9.0, 4.0), 0.0, 0), 1.2);
    close(sight.base_excess, 4.0);
    close(sight.adequate, 1.2);
    assert_eq!(Sight::new(&candidate((9.0, -0.3), 0.0, 0), 1.2).base_excess, 0.0);
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
    close(trust(&library, &found, 0), 0.5 / 0.8);
    close(trust(&library, &found, 2), 0.5 / 0.8);
    close(trust(&library, &found, 1), 0.2 / 0.8);
    close(trust(&library, &found, 4), 0.04 / 0.8);
}

#[test]
fn no_name_is_trusted_where_the_cause_is_most_likely_not_in_the_library() {
    let library = library();
    assert_eq!(trust(&library, &believe(&[(0, 0.30), (1, 0.19)]), 0), 0.0);
    // At one half the library is as likely as not, and the name counts.
    close(trust(&library, &believe(&[(0, 0.25), (1, 0.25)]), 0), 0.5);
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
