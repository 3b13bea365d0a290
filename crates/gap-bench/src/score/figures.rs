//! The figures of a benchmark with their goals.

use super::{Judged, ShrinkPair, Times, mean, removed, set_size};
use crate::families::is_ambiguous;
use crate::judge::{is_alarm, is_exactly, is_in_set, is_right, truths_named, wrong_names};
use crate::statistics::{Calibration, Rate, quantile};
use crate::target::{Figure, Goal};

/// The figures, each with the goal that it has.
pub(super) fn figures(
    all: &[Judged<'_>],
    shrinks: &[ShrinkPair],
    calibration: &Calibration,
    times: &Times,
) -> Vec<Figure> {
    let singles = || all.iter().filter(|j| j.is_of("single") && j.truth().is_some());
    let right = |j: &Judged<'_>| j.truth().is_some_and(|truth| is_right(j.answer, truth));
    let size = |j: &Judged<'_>| j.truth().map_or(0.0, |truth| truth.wanted_size);
    let small = || singles().filter(|j| size(j) < 4.0);
    let in_set = |j: &Judged<'_>| j.truth().is_some_and(|truth| is_in_set(j.answer, truth));
    let clean = || all.iter().filter(|j| j.label.effects.is_empty());
    let unknown = all.iter().filter(|j| j.is_of("unknown"));
    let pairs = |is_other: bool| {
        let pairs = all.iter().filter(|j| j.is_of("pair"));
        pairs.filter(move |j| j.label.effects.iter().all(|e| e.is_other_formula == is_other))
    };
    let removed = removed(all);
    let ambiguous =
        || all.iter().filter(|j| is_ambiguous(&j.label.family) && j.answer.has_rivals());
    let inside = shrinks.iter().map(|s| (s.ci95[0]..=s.ci95[1]).contains(&s.realised));
    let against_oracle: Vec<f64> =
        all.iter().filter_map(|j| j.realised).filter_map(|r| Some(r.after / r.oracle?)).collect();
    let sets: Vec<f64> = small().filter_map(set_size).collect();
    let known = super::calibration(all, &|j| {
        !["apart", "removed", "unknown"].iter().any(|family| j.is_of(family))
    });
    vec![
        Figure::rate(
            "single effect of 6 σ and more, right",
            Rate::count(singles().filter(|j| size(j) > 4.0).map(right)),
            Goal::AtLeast(0.97),
        ),
        Figure::rate(
            "single effect of 2 σ, truth in the set",
            Rate::count(small().map(in_set)),
            Goal::AtLeast(0.95),
        ),
        Figure::value("single effect of 2 σ, mean set", mean(&sets), Goal::AtMost(1.4)),
        Figure::rate(
            "no effect, false alarm",
            Rate::count(clean().map(|j| is_alarm(j.answer))),
            Goal::AtMost(0.01),
        ),
        Figure::rate(
            "effect that is not in the library, \"unknown\"",
            Rate::count(unknown.map(|j| j.answer.verdict == "unknown")),
            Goal::AtLeast(0.90),
        ),
        Figure::rate(
            "own candidate removed, wrong name outside its group",
            removed.outside,
            Goal::AtMost(0.05),
        ),
        Figure::rate(
            "pair of textbook formulas, both right",
            Rate::count(pairs(false).map(both_right)),
            Goal::AtLeast(0.90),
        ),
        Figure::rate(
            "pair of other formulas, both right",
            Rate::count(pairs(true).map(both_right)),
            Goal::AtLeast(0.75),
        ),
        Figure::value("expected calibration error", calibration.error, Goal::AtMost(0.05)),
        Figure::value("expected calibration error, effect in the library", known.error, Goal::None),
        Figure::rate(
            "realised shrink within the predicted interval",
            Rate::count(inside),
            Goal::AtLeast(0.93),
        ),
        Figure::value(
            "error of the repaired model, relative to one fitted with the true effect, median",
            quantile(&against_oracle, 0.5),
            Goal::AtMost(1.15),
        ),
        Figure::rate(
            "repaired model within 1.15 of one fitted with the true effect",
            Rate::count(against_oracle.iter().map(|ratio| *ratio <= 1.15)),
            Goal::None,
        ),
        Figure::rate(
            "several names left, a single one after at most two experiments",
            Rate::count(ambiguous().map(|j| j.last().is_single())),
            Goal::AtLeast(0.95),
        ),
        Figure::rate(
            "of those, right",
            Rate::count(
                ambiguous()
                    .filter(|j| j.last().is_single())
                    .map(|j| j.truth().is_some_and(|truth| is_exactly(j.last(), truth))),
            ),
            Goal::AtLeast(0.97),
        ),
        Figure::value("25 s at 10 kHz, native model, longest, s", times.long, Goal::AtMost(10.0)),
    ]
}

/// Both truths named and nothing wrong beside them.
fn both_right(judged: &Judged<'_>) -> bool {
    truths_named(judged.answer, judged.label) == judged.label.effects.len()
        && wrong_names(judged.answer, judged.label).is_empty()
}
