//! The scorer on outcomes made by hand.

use super::*;
use crate::answer::{Leftover, Shrink};
use crate::judge::tests::{answer, label, truth};

fn outcome(label: Label, answer: Answer) -> Outcome {
    let (failure, realised) = (None, None);
    let after_experiments = Vec::new();
    Outcome {
        label: Some(label),
        answer: Some(answer),
        failure,
        seconds: 2.0,
        realised,
        after_experiments,
    }
}

fn sized(family: &str, effect: &str, size: f64) -> Label {
    let mut all = label(family, &[effect]);
    all.effects[0].wanted_size = size;
    all
}

fn figure<'a>(scores: &'a Scores, begin: &str) -> &'a Figure {
    scores.figures.iter().find(|f| f.name.starts_with(begin)).expect(begin)
}

fn counts(rate: Rate) -> (usize, usize) {
    (rate.hits, rate.of)
}

#[test]
fn single_effects_are_counted_by_size() {
    let scores = Scores::of(&[
        outcome(sized("single", "creep", 20.0), answer(&[("creep", &["creep"])])),
        outcome(
            sized("single", "backlash", 6.0),
            answer(&[("friction", &["friction", "backlash"])]),
        ),
        outcome(
            sized("single", "delay", 2.0),
            answer(&[("delay", &["delay", "sensor_bandwidth"])]),
        ),
        outcome(sized("single", "duffing", 2.0), answer(&[])),
        // Another family does not count towards the headline.
        outcome(sized("closed-loop", "duffing", 20.0), answer(&[])),
    ]);
    assert_eq!(counts(figure(&scores, "single effect of 6").rate.unwrap()), (1, 2));
    assert_eq!(counts(figure(&scores, "single effect of 2 σ, truth").rate.unwrap()), (1, 2));
    // The empty answer has no set.
    assert_eq!(figure(&scores, "single effect of 2 σ, mean").value, Some(2.0));
    let row = scores.singles.iter().find(|r| r.family == "single" && r.size == 6.0).unwrap();
    assert_eq!((counts(row.right), counts(row.in_set)), ((0, 1), (1, 1)));
    assert!(scores.singles.iter().any(|r| r.family == "closed-loop"));
    let backlash = scores.confusion.iter().find(|c| c.truth == "backlash").unwrap();
    assert_eq!(backlash.answers, [("friction".to_owned(), 1)]);
}

#[test]
fn alarms_are_names_and_unknowns_where_nothing_is() {
    let verdict = |verdict: &str| Answer { verdict: verdict.into(), ..answer(&[]) };
    let clean = || label("none", &[]);
    let scores = Scores::of(&[
        outcome(clean(), verdict("adequate")),
        outcome(clean(), verdict("retune")),
        outcome(clean(), verdict("insufficient_excitation")),
        outcome(clean(), verdict("unknown")),
        outcome(label("none-two-axes", &[]), answer(&[("creep", &["creep"])])),
        // A wrong baseline is something: no alarm is false there.
        outcome(
            label("wrong-hysteresis", &["hysteresis"]),
            answer(&[("hysteresis", &["hysteresis"])]),
        ),
    ]);
    assert_eq!(counts(figure(&scores, "no effect").rate.unwrap()), (2, 5));
}

#[test]
fn a_removed_candidate_wants_silence_or_a_neighbour() {
    let removed = |effect: &str, answer| outcome(sized("removed", effect, 6.0), answer);
    let flagged = |answer: Answer| Answer { leftover: Leftover { present: true }, ..answer };
    let unknown = Answer { verdict: "unknown".into(), ..answer(&[]) };
    let scores = Scores::of(&[
        removed("delay", unknown),
        removed("delay", flagged(answer(&[("sensor_bandwidth", &["sensor_bandwidth"])]))),
        removed("delay", answer(&[("extra_mode", &["extra_mode"])])),
        // The second name is outside too.
        removed(
            "creep",
            answer(&[("thermal_drift", &["thermal_drift"]), ("duffing", &["duffing"])]),
        ),
        removed("creep", answer(&[])),
    ]);
    let r = &scores.removed;
    assert_eq!(
        [r.abstained, r.overlooked, r.neighbour, r.outside, r.flagged].map(counts),
        [(1, 5), (1, 5), (1, 5), (2, 5), (1, 3)]
    );
    assert_eq!(
        r.stand_ins,
        [("creep".into(), "duffing".into(), 1), ("delay".into(), "extra_mode".into(), 1)]
    );
}

#[test]
fn pairs_must_be_complete_and_alone() {
    let pair = |is_other: bool, named: &[(&str, &[&str])]| {
        let mut label = label("pair", &["creep", "backlash"]);
        label.effects.iter_mut().for_each(|e| e.is_other_formula = is_other);
        outcome(label, answer(named))
    };
    let creep: (&str, &[&str]) = ("creep", &["creep"]);
    let backlash: (&str, &[&str]) = ("backlash", &["backlash"]);
    let scores = Scores::of(&[
        pair(false, &[creep, backlash]),
        pair(false, &[creep]),
        pair(false, &[creep, backlash, ("duffing", &["duffing"])]),
        pair(true, &[backlash, creep]),
    ]);
    assert_eq!(counts(figure(&scores, "pair of textbook").rate.unwrap()), (1, 3));
    assert_eq!(counts(figure(&scores, "pair of other").rate.unwrap()), (1, 1));
}

#[test]
fn unknown_effects_want_the_verdict_unknown() {
    let unknown = Answer { verdict: "unknown".into(), ..answer(&[]) };
    let scores = Scores::of(&[
        outcome(label("unknown", &["x_glitches"]), unknown),
        outcome(label("unknown", &["x_glitches"]), answer(&[("creep", &["creep"])])),
    ]);
    assert_eq!(counts(figure(&scores, "effect that is not in the library").rate.unwrap()), (1, 2));
    assert!(scores.singles.is_empty());
}

#[test]
fn probabilities_count_over_all_families_but_those_apart() {
    let named = |probability: f64, effect: &str| {
        let mut answer = answer(&[(effect, &["creep"])]);
        answer.effects[0].probability = probability;
        answer
    };
    let scores = Scores::of(&[
        outcome(label("single", &["creep"]), named(1.0, "creep")),
        outcome(label("none", &[]), named(0.6, "creep")),
        outcome(label("apart", &["sensor_noise"]), named(1.0, "creep")),
    ]);
    // One right at 1.0, one wrong at 0.6: 0.5·0 + 0.5·0.6.
    assert!((scores.calibration.error.unwrap() - 0.3).abs() < 1e-12);
}

#[test]
fn shrink_is_inside_or_outside_its_interval_and_ratios_are_to_the_oracle() {
    let repaired = |ci95, after, oracle| {
        let answer = Answer {
            shrink: Shrink { fraction: Some(0.9), ci95: Some(ci95), ..Shrink::default() },
            ..answer(&[("creep", &["creep"])])
        };
        let realised = Some(Realised { before: 0.1, after, oracle });
        Outcome { realised, ..outcome(label("single", &["creep"]), answer) }
    };
    let scores = Scores::of(&[
        // 1 − 0.03² / 0.1² = 0.91.
        repaired([0.85, 0.95], 0.03, Some(0.03)),
        repaired([0.92, 0.95], 0.03, Some(0.02)),
        repaired([0.92, 0.95], 0.03, None),
    ]);
    assert!((scores.shrinks[0].realised - 0.91).abs() < 1e-12);
    assert_eq!(counts(figure(&scores, "realised shrink").rate.unwrap()), (1, 3));
    assert_eq!(counts(figure(&scores, "repaired model within").rate.unwrap()), (1, 2));
}

#[test]
fn experiments_count_where_several_names_were_left() {
    let case = |first: Answer, after: Vec<Answer>| Outcome {
        after_experiments: after,
        ..outcome(label("ambiguous", &["delay"]), first)
    };
    let two = || answer(&[("delay", &["delay", "sensor_bandwidth"])]);
    let right = || answer(&[("delay", &["delay"])]);
    let scores = Scores::of(&[
        // One name from the start: not ambiguous.
        case(right(), vec![]),
        case(two(), vec![two(), right()]),
        case(two(), vec![answer(&[("sensor_bandwidth", &["sensor_bandwidth"])])]),
        case(two(), vec![two(), two()]),
        // Another name beside the right one is a wrong answer, no name is none.
        case(two(), vec![answer(&[("delay", &["delay"]), ("creep", &["creep"])])]),
        case(two(), vec![answer(&[])]),
        // No signal was proposed.
        case(two(), vec![]),
    ]);
    assert_eq!(counts(figure(&scores, "several names left").rate.unwrap()), (3, 6));
    assert_eq!(counts(figure(&scores, "of those, right").rate.unwrap()), (1, 3));
}

#[test]
fn failures_and_machines_that_could_not_be_drawn_are_listed_and_not_counted() {
    let failed = Outcome {
        answer: None,
        failure: Some("no such file".into()),
        ..outcome(label("single", &["creep"]), answer(&[]))
    };
    let not_drawn = Outcome { label: None, failure: Some("too large".into()), ..failed.clone() };
    let scores = Scores::of(&[failed, not_drawn]);
    assert_eq!(scores.answered, 0);
    let failure = Failure { message: "no such file".into(), cases: vec!["c".into()] };
    assert_eq!(scores.failed, [failure]);
    assert_eq!(scores.not_drawn, ["too large"]);
    assert!(scores.figures.iter().all(|f| f.is_met().is_none()));
}

#[test]
fn what_is_exactly_right_has_nothing_beside_it() {
    let mut other = label("single", &["creep"]);
    other.effects = vec![TrueEffect { is_other_formula: true, ..truth("creep") }];
    let scores = Scores::of(&[
        outcome(other, answer(&[("creep", &["creep"]), ("duffing", &["duffing"])])),
        outcome(label("single", &["creep"]), answer(&[("creep", &["creep"])])),
    ]);
    let row = &scores.singles[0];
    assert_eq!((counts(row.right), counts(row.exactly)), ((2, 2), (1, 2)));
    let effect = &scores.effects[0];
    assert_eq!((counts(effect.standard), counts(effect.other)), ((1, 1), (1, 1)));
}
