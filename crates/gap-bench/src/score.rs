//! All outcomes of a benchmark, as figures.

mod figures;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::answer::Answer;
use crate::case::SIZES;
use crate::families::FAMILIES;
use crate::judge::{first, is_first, is_in_set, is_outside, is_right, wrong_names};
use crate::label::{Label, TrueEffect};
use crate::run::{Outcome, Realised};
use crate::statistics::{Calibration, Rate, quantile};
use crate::target::Figure;

/// All figures of a benchmark.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// Cases with an answer.
    pub answered: usize,
    /// What the tool failed on: the diagnosis, or only the repair.
    pub failed: Vec<Failure>,
    /// Cases that no machine could be drawn for, with the reason.
    pub not_drawn: Vec<String>,
    /// The figures that have a goal.
    pub figures: Vec<Figure>,
    /// Single effects per family and size.
    pub singles: Vec<Single>,
    /// Single effects of the family `single` by effect and size.
    pub effects: Vec<OfEffect>,
    /// What is named first by what is there; single effects, all sizes.
    pub confusion: Vec<Confusion>,
    /// Verdicts per family.
    pub verdicts: Vec<Verdicts>,
    /// What is answered where the effect's own candidate is removed.
    pub removed: Removed,
    /// Probabilities against how often names are right, all families but those counted apart.
    pub calibration: Calibration,
    /// Predicted against realised shrink, case by case.
    pub shrinks: Vec<ShrinkPair>,
    /// How long one diagnosis takes.
    pub times: Times,
}

/// One complaint of the tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// What the failure said.
    pub message: String,
    /// Of which cases.
    pub cases: Vec<String>,
}

/// Single effects of one family at one size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Single {
    /// Family.
    pub family: String,
    /// Size over the noise.
    pub size: f64,
    /// Right by the rule: the set within the group, else the first name.
    pub right: Rate,
    /// The truth is the first name.
    pub is_first: Rate,
    /// The truth is in a set.
    pub in_set: Rate,
    /// Right and nothing wrong beside it.
    pub exactly: Rate,
    /// Mean size of the first set where one is given.
    pub mean_set: Option<f64>,
}

/// One effect at one size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OfEffect {
    /// Effect.
    pub effect: String,
    /// Size over the noise.
    pub size: f64,
    /// Right by the rule, formula of the textbook.
    pub standard: Rate,
    /// Right by the rule, other formula.
    pub other: Rate,
    /// The truth is in a set.
    pub in_set: Rate,
}

/// What is named first where one effect is there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Confusion {
    /// The truth.
    pub truth: String,
    /// Answers with their counts, the most frequent first.
    pub answers: Vec<(String, usize)>,
}

/// Verdicts of one family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdicts {
    /// Family.
    pub family: String,
    /// Verdicts with their counts.
    pub verdicts: BTreeMap<String, usize>,
    /// Median of the diagnosis' time in s.
    pub seconds: Option<f64>,
}

/// Answers where the effect's own candidate is removed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Removed {
    /// `unknown`.
    pub abstained: Rate,
    /// Another verdict without a name: overlooked.
    pub overlooked: Rate,
    /// A name within the effect's group.
    pub neighbour: Rate,
    /// A name outside it.
    pub outside: Rate,
    /// Of the names, those that say that something is left.
    pub flagged: Rate,
    /// Which names stand for which, with counts; outside the group only.
    pub stand_ins: Vec<(String, String, usize)>,
}

/// Predicted and realised shrink of one case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShrinkPair {
    /// Case.
    pub case: String,
    /// Family.
    pub family: String,
    /// Predicted.
    pub predicted: f64,
    /// The shrink pair's interval.
    pub ci95: [f64; 2],
    /// On records that the diagnosis never saw.
    pub realised: f64,
}

/// How long one diagnosis takes, in s.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Median, one thread, native models.
    pub native: Option<f64>,
    /// Ninety per cent take at most this long.
    pub native_p90: Option<f64>,
    /// Median, one thread, FMUs.
    pub fmu: Option<f64>,
    /// Ninety per cent take at most this long.
    pub fmu_p90: Option<f64>,
    /// The longest with 25 s of log at 10 kHz and two threads.
    pub long: Option<f64>,
}

/// A case with truth and answer.
pub(crate) struct Judged<'a> {
    pub(crate) label: &'a Label,
    pub(crate) answer: &'a Answer,
    pub(crate) seconds: f64,
    pub(crate) realised: Option<Realised>,
    pub(crate) after_experiments: &'a [Answer],
}

impl Judged<'_> {
    /// The answer after all experiments.
    fn last(&self) -> &Answer {
        self.after_experiments.last().unwrap_or(self.answer)
    }

    fn truth(&self) -> Option<&TrueEffect> {
        match &self.label.effects[..] {
            [truth] => Some(truth),
            _ => None,
        }
    }
    fn is_of(&self, family: &str) -> bool {
        self.label.family == family
    }
}

impl Scores {
    /// Scores outcomes.
    #[must_use]
    pub fn of(outcomes: &[Outcome]) -> Self {
        let mut all = Vec::new();
        let mut not_drawn = Vec::new();
        let mut failed: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for outcome in outcomes {
            let Outcome { label, answer, failure, seconds, realised, after_experiments } = outcome;
            let Some(label) = label else {
                not_drawn.push(failure.clone().unwrap_or_default());
                continue;
            };
            if let Some(message) = failure {
                failed.entry(message).or_default().push(label.case.clone());
            }
            if let Some(answer) = answer {
                all.push(Judged {
                    label,
                    answer,
                    seconds: *seconds,
                    realised: *realised,
                    after_experiments,
                });
            }
        }
        let failed: Vec<Failure> = failed
            .into_iter()
            .map(|(message, cases)| Failure { message: message.to_owned(), cases })
            .collect();
        let shrinks = shrinks(&all);
        let calibration = calibration(&all, &|j| !j.is_of("apart"));
        let times = times(&all);
        Self {
            answered: all.len(),
            failed,
            not_drawn,
            figures: figures::figures(&all, &shrinks, &calibration, &times),
            singles: singles(&all),
            effects: effects(&all),
            confusion: confusion(&all),
            verdicts: verdicts(&all),
            removed: removed(&all),
            calibration,
            shrinks,
            times,
        }
    }
}

fn set_size(judged: &Judged<'_>) -> Option<f64> {
    judged.answer.effects.first().map(|named| named.set.len() as f64)
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn singles(all: &[Judged<'_>]) -> Vec<Single> {
    let mut rows = Vec::new();
    for family in FAMILIES {
        for size in SIZES {
            let cases: Vec<(&Judged<'_>, &TrueEffect)> = all
                .iter()
                .filter(|j| j.is_of(family.name) && !j.is_of("unknown") && !j.is_of("removed"))
                .filter_map(|j| Some((j, j.truth()?)))
                .filter(|(_, truth)| truth.wanted_size == size)
                .collect();
            if cases.is_empty() {
                continue;
            }
            let rate = |hit: &dyn Fn(&Judged<'_>, &TrueEffect) -> bool| {
                Rate::count(cases.iter().map(|(j, truth)| hit(j, truth)))
            };
            let sets: Vec<f64> = cases.iter().filter_map(|(j, _)| set_size(j)).collect();
            rows.push(Single {
                family: family.name.to_owned(),
                size,
                right: rate(&|j, truth| is_right(j.answer, truth)),
                is_first: rate(&|j, truth| is_first(j.answer, truth)),
                in_set: rate(&|j, truth| is_in_set(j.answer, truth)),
                exactly: rate(&|j, truth| {
                    is_right(j.answer, truth) && wrong_names(j.answer, j.label).is_empty()
                }),
                mean_set: mean(&sets),
            });
        }
    }
    rows
}

fn effects(all: &[Judged<'_>]) -> Vec<OfEffect> {
    let mut groups: BTreeMap<(&str, u64), Vec<(&Judged<'_>, &TrueEffect)>> = BTreeMap::new();
    for judged in all.iter().filter(|j| j.is_of("single") || j.is_of("apart")) {
        let Some(truth) = judged.truth() else { continue };
        let key = (truth.effect.as_str(), truth.wanted_size as u64);
        groups.entry(key).or_default().push((judged, truth));
    }
    let row = |((effect, size), cases): (_, Vec<(&Judged<'_>, &TrueEffect)>)| {
        let right = |is_other: bool| {
            let of_formula = cases.iter().filter(|(_, t)| t.is_other_formula == is_other);
            Rate::count(of_formula.map(|(j, truth)| is_right(j.answer, truth)))
        };
        let effect: &str = effect;
        let size: u64 = size;
        OfEffect {
            effect: effect.to_owned(),
            size: size as f64,
            standard: right(false),
            other: right(true),
            in_set: Rate::count(cases.iter().map(|(j, truth)| is_in_set(j.answer, truth))),
        }
    };
    groups.into_iter().map(row).collect()
}

fn confusion(all: &[Judged<'_>]) -> Vec<Confusion> {
    let mut rows: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
    for judged in all.iter().filter(|j| j.is_of("single") || j.is_of("unknown") || j.is_of("apart"))
    {
        let Some(truth) = judged.truth() else { continue };
        let answers = rows.entry(&truth.effect).or_default();
        *answers.entry(first(judged.answer)).or_default() += 1;
    }
    let by_count = |counts: BTreeMap<&str, usize>| {
        let mut all: Vec<(String, usize)> =
            counts.into_iter().map(|(name, n)| (name.to_owned(), n)).collect();
        all.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        all
    };
    rows.into_iter()
        .map(|(truth, counts)| Confusion { truth: truth.to_owned(), answers: by_count(counts) })
        .collect()
}

fn verdicts(all: &[Judged<'_>]) -> Vec<Verdicts> {
    let of_family = |family: &str| {
        let cases: Vec<&Judged<'_>> = all.iter().filter(|j| j.is_of(family)).collect();
        let mut verdicts: BTreeMap<String, usize> = BTreeMap::new();
        for case in &cases {
            *verdicts.entry(case.answer.verdict.clone()).or_default() += 1;
        }
        let seconds: Vec<f64> = cases.iter().map(|j| j.seconds).collect();
        (!cases.is_empty()).then(|| Verdicts {
            family: family.to_owned(),
            verdicts,
            seconds: quantile(&seconds, 0.5),
        })
    };
    FAMILIES.iter().filter_map(|family| of_family(family.name)).collect()
}

fn removed(all: &[Judged<'_>]) -> Removed {
    let cases: Vec<(&Answer, &TrueEffect)> = all
        .iter()
        .filter(|j| j.is_of("removed"))
        .filter_map(|j| Some((j.answer, j.truth()?)))
        .collect();
    let rate = |hit: &dyn Fn(&Answer, &TrueEffect) -> bool| {
        Rate::count(cases.iter().map(|(answer, truth)| hit(answer, truth)))
    };
    let is_outside = |answer: &Answer, truth: &TrueEffect| {
        answer.effects.iter().any(|named| is_outside(&named.effect, truth))
    };
    let mut stand_ins: BTreeMap<(String, String), usize> = BTreeMap::new();
    for (answer, truth) in cases.iter().filter(|(answer, truth)| is_outside(answer, truth)) {
        let names = answer.effects.iter().map(|named| named.effect.clone());
        for name in names.filter(|name| crate::judge::is_outside(name, truth)) {
            *stand_ins.entry((truth.effect.clone(), name)).or_default() += 1;
        }
    }
    let named = cases.iter().filter(|(answer, _)| !answer.effects.is_empty());
    Removed {
        abstained: rate(&|answer, _| answer.verdict == "unknown"),
        overlooked: rate(&|answer, _| answer.effects.is_empty() && answer.verdict != "unknown"),
        neighbour: rate(&|answer, truth| !answer.effects.is_empty() && !is_outside(answer, truth)),
        outside: rate(&|answer, truth| is_outside(answer, truth)),
        flagged: Rate::count(named.map(|(answer, _)| answer.leftover.present)),
        stand_ins: stand_ins.into_iter().map(|((truth, name), n)| (truth, name, n)).collect(),
    }
}

fn calibration(all: &[Judged<'_>], keep: &dyn Fn(&Judged<'_>) -> bool) -> Calibration {
    let names = all.iter().filter(|j| keep(j)).flat_map(|judged| {
        let has = |effect: &str| judged.label.has(effect);
        judged.answer.effects.iter().map(move |named| (named.probability, has(&named.effect)))
    });
    Calibration::of(&names.collect::<Vec<_>>())
}

fn shrinks(all: &[Judged<'_>]) -> Vec<ShrinkPair> {
    let pair = |judged: &Judged<'_>| {
        let shrink = &judged.answer.shrink;
        Some(ShrinkPair {
            case: judged.label.case.clone(),
            family: judged.label.family.clone(),
            predicted: shrink.fraction?,
            ci95: shrink.ci95?,
            realised: judged.realised?.fraction(),
        })
    };
    all.iter().filter_map(pair).collect()
}

fn times(all: &[Judged<'_>]) -> Times {
    let of = |keep: &dyn Fn(&Judged<'_>) -> bool| -> Vec<f64> {
        all.iter().filter(|j| keep(j)).map(|j| j.seconds).collect()
    };
    let is_fmu = |j: &Judged<'_>| j.label.family.contains("black-box");
    let native = of(&|j| !is_fmu(j) && !j.is_of("long"));
    let fmu = of(&|j| is_fmu(j));
    Times {
        native: quantile(&native, 0.5),
        native_p90: quantile(&native, 0.9),
        fmu: quantile(&fmu, 0.5),
        fmu_p90: quantile(&fmu, 0.9),
        long: quantile(&of(&|j| j.is_of("long")), 1.0),
    }
}

#[cfg(test)]
#[path = "score_tests.rs"]
mod tests;
