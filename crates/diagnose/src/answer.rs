//! From the outcomes of all outputs to the answer.

mod cautions;
mod leftover;
mod sensor;
mod shared;

use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;

use self::cautions::cautions;
use self::leftover::leftover;
use self::sensor::{noisier, stepped};
use crate::base::compose::GAIN;
use crate::belief;
use crate::candidate::{Candidate, RankedFamily, Why};
use crate::experiment;
use crate::gap::{
    Estimate, Gap, ModelKind, NamedEffect, OutputGap, Partial, Provenance, Retuned, SCHEMA, Shrink,
    Tried, Verdict,
};
use crate::new_record;
use crate::outcome::Outcome;
use crate::own_course;
use crate::parameter::Parameter;
use crate::place::Maps;
use crate::request::{Model, Request};
use crate::score::{Judged, explained};
use crate::shrink::Evidence;
use crate::thresholds::base;

/// Puts the answer together.
pub(crate) fn gap(request: &Request, outcomes: &[Outcome], simulations: u64) -> Gap {
    let size = |o: &Outcome| o.before().held_out;
    let main = (0..outcomes.len())
        .max_by(|a, b| size(&outcomes[*a]).total_cmp(&size(&outcomes[*b])).then(b.cmp(a)))
        .unwrap_or(0);
    let mut outputs: Vec<OutputGap> = outcomes.iter().map(|o| output(o, request.seed)).collect();
    let effects: Vec<NamedEffect> = outcomes.iter().flat_map(named).collect();
    let effects = shared::moving(effects, outcomes);
    let mut effects = shared::once(effects, outcomes, &outcomes[main].task.output);
    effects.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    for (own, o) in outputs.iter_mut().zip(outcomes).filter(|(_, o)| !o.moved_by.is_empty()) {
        let moving = effects.iter().filter(|e| e.also.contains(&o.task.output));
        own.effects.extend(moving.map(|e| e.effect.clone()));
        own.effects.sort();
        own.effects.dedup();
    }
    let outcome = &outcomes[main];
    let maps = maps(outcome);
    let stage = effects.iter().find(|e| e.output == outcome.task.output).map(|e| e.stage.clone());
    let place = maps.place(&outcome.task.output, &outcome.task.input, stage.as_deref());
    let mut warnings: Vec<String> = outcomes.iter().flat_map(|o| o.task.warnings.clone()).collect();
    warnings.extend(outcomes.iter().flat_map(cautions));
    let warnings = joined(warnings, outcomes);
    let mut gap = Gap {
        schema: SCHEMA.to_owned(),
        sentence: String::new(),
        verdict: worst(outcomes),
        effects,
        partial: outcomes.iter().filter_map(partial).collect(),
        place,
        shrink: outputs[main].shrink.clone(),
        retuned: outcomes.iter().flat_map(|o| retuned(o, outcomes.len() > 1)).collect(),
        leftover: leftover(outcome, &maps),
        next_experiment: experiment::next(outcome),
        candidates: outcomes.iter().flat_map(tried).collect(),
        outputs,
        provenance: provenance(request, simulations),
        baseline: Vec::new(),
        warnings,
    };
    gap.sentence = crate::sentence::of(&gap);
    gap
}

/// Each warning once; what is the same of several outputs names them together.
fn joined(warnings: Vec<String>, outcomes: &[Outcome]) -> Vec<String> {
    let mut all: Vec<(Vec<&str>, String)> = Vec::new();
    for warning in warnings {
        let of = |o: &Outcome| {
            warning.strip_prefix(&o.task.output)?.strip_prefix(": ").map(str::to_owned)
        };
        let own = outcomes.iter().find_map(|o| Some((o.task.output.as_str(), of(o)?)));
        let (output, text) =
            own.map_or((None, warning.clone()), |(output, text)| (Some(output), text));
        match all
            .iter_mut()
            .find(|(outputs, other)| *other == text && outputs.is_empty() == output.is_none())
        {
            Some((outputs, _)) => outputs.extend(output.filter(|name| !outputs.contains(name))),
            None => all.push((output.into_iter().collect(), text)),
        }
    }
    let described = |(outputs, text): (Vec<&str>, String)| match outputs.as_slice() {
        [] => text,
        several => format!("{}: {text}", several.join(", ")),
    };
    all.into_iter().map(described).collect()
}

fn worst(outcomes: &[Outcome]) -> Verdict {
    let order = [
        Verdict::Effects,
        Verdict::Unknown,
        Verdict::Retune,
        Verdict::InsufficientExcitation,
        Verdict::Adequate,
    ];
    let has = |v: &&Verdict| outcomes.iter().any(|o| o.verdict == **v);
    order.iter().find(has).copied().unwrap_or(Verdict::Adequate)
}

fn maps(outcome: &Outcome) -> Maps<'_> {
    Maps {
        data: &outcome.task.data,
        before: &outcome.robust,
        after: &outcome.with_effects().residual,
        sigma: outcome.sigma / outcome.task.factor,
    }
}

/// Says of the shrinks what the models do that are handed back, one per outcome where it can be told.
pub(crate) fn hand_back(gap: &mut Gap, outcomes: &[Outcome], after: &[Option<Judged>]) {
    let is_main = |output: &str| *output == gap.place.output;
    let mut of_main = None;
    for (o, after) in outcomes.iter().zip(after) {
        // Of a course that no model predicts nothing is written.
        let is_written = o.is_explained() && o.predicted.is_none();
        let Some(after) = after.as_ref().filter(|_| is_written) else { continue };
        let Some(own) = gap.outputs.iter_mut().find(|own| own.output == o.task.output) else {
            continue;
        };
        let as_found = own.shrink.fraction;
        own.shrink = Shrink { as_found, ..shrink(o, after, gap.provenance.seed) };
        if is_main(&own.output) {
            of_main = Some(own.shrink.clone());
        }
    }
    if let Some(shrink) = of_main {
        gap.shrink = shrink;
        gap.sentence = crate::sentence::of(gap);
    }
}

fn output(o: &Outcome, seed: u64) -> OutputGap {
    let last = &o.found.last.judged;
    let mut shrink = shrink(o, o.with_effects(), seed);
    if o.predicted.is_some() {
        shrink.own_course = crate::shrink::fraction(o.before().held_out, last.held_out);
    }
    OutputGap {
        output: o.task.output.clone(),
        verdict: o.verdict,
        effects: named(o).into_iter().map(|e| e.effect).collect(),
        shrink,
        noise: o.task.noise.clone(),
        between: o.task.course.between,
        reading: o.task.course.reading,
        reading_late: o.found.last.late(),
    }
}

fn shrink(o: &Outcome, after: &Judged, seed: u64) -> Shrink {
    let range = 2.0 * o.task.data.output_span.half / o.task.factor;
    let stages = o.against_noise([o.as_given(), o.before(), after]);
    let sigma = o.task.steps.map_or(o.sigma, |steps| steps.beside);
    let [given, before, after] = match &stages {
        Some([given, before, after]) => [given, before, after],
        None => [o.as_given(), o.before(), after],
    };
    let evidence = Evidence {
        data: &o.task.data,
        judge: &o.judge,
        given,
        before,
        after,
        sigma: sigma / o.task.factor,
        unit: &o.task.unit,
        range,
        seed,
        on_new_records: o.on_new_records.get_or_init(|| new_record::left(o, seed)),
    };
    let factor = o.task.factor;
    Shrink {
        second_opinion: o.second.clone(),
        offset: o.offset.map(|offset| offset.shared / factor).filter(|shared| *shared != 0.0),
        rms_as_it_stands: o.offset.map(|offset| {
            let (before, after) = offset.as_it_stands;
            [before / factor, after / factor]
        }),
        ..evidence.shrink(o.is_explained() || stages.is_some())
    }
}

/// A value of a parameter in the unit of reports.
pub(crate) fn estimate(o: &Outcome, p: &Parameter, q: f64, deviation: Option<f64>) -> Estimate {
    let value = p.value(q);
    let deviation = deviation.map(|d| if p.log { value * d } else { d });
    let scale = scale_of(o, &p.unit);
    let unit = model::unit_on_axis(&p.unit, &o.task.command_unit, &o.task.unit);
    let finite = |v: f64| v.is_finite().then_some(v);
    Estimate {
        value: finite(value / scale).unwrap_or(0.0),
        std: deviation.and_then(|d| finite(d / scale)),
        unit,
    }
}

/// SI per unit of a formula's parameter, which is kept in SI.
pub(crate) fn scale_of(o: &Outcome, unit: &str) -> f64 {
    let (u, y) = (o.task.command_factor, o.task.factor);
    match unit {
        "{command}" | "{command}/s" => u,
        "{position}" => y,
        "{position}/{command}" | "{position}.s/{command}" => y / u,
        _ => 1.0,
    }
}

/// Fitted parameters of effect number `slot`, named `effect.parameter`.
pub(crate) fn parameters(
    o: &Outcome,
    candidate: &Candidate,
    slot: usize,
) -> BTreeMap<String, Estimate> {
    let mut all = BTreeMap::new();
    let (family, formula) = candidate.picks[slot];
    let family = &o.library[family];
    for k in candidate.own(&o.library, slot) {
        let p = &candidate.chain.parameters[k];
        let value = estimate(o, p, candidate.fit.theta[k], candidate.fit.deviations[k]);
        all.insert(format!("{}.{}", family.effect.name, p.name.replace(' ', "_")), value);
    }
    for k in &family.formulas[formula].releases {
        let released = &o.task.base.parameters[*k];
        if let Some(at) = candidate.chain.own(&released.name) {
            let (q, d) = (candidate.fit.theta[at], candidate.fit.deviations[at]);
            let estimate = Estimate {
                value: released.value + released.deviation * q,
                std: d.map(|d| d * released.deviation),
                unit: released.unit.clone(),
            };
            all.insert(released.name.clone(), estimate);
        }
    }
    all
}

fn named(o: &Outcome) -> Vec<NamedEffect> {
    let last = &o.found.last;
    let picked = (0..last.picks.len()).map(|slot| {
        let rivals = o.found.rivals.get(slot).map_or(&[][..], |looked| &looked[..]);
        let explained = o.found.alone.get(slot).copied().unwrap_or(0.0);
        effect_of(o, (last, slot), rivals, explained)
    });
    noisier(o).into_iter().chain(stepped(o)).chain(picked).collect()
}

/// Effect number `slot` of a candidate beside its rivals.
fn effect_of(
    o: &Outcome,
    (candidate, slot): (&Candidate, usize),
    rivals: &[RankedFamily],
    explained: f64,
) -> NamedEffect {
    let family = candidate.picks[slot].0;
    let effect = o.library[family].effect;
    let sight = o.sight();
    // Rivals were looked at beside effects that may have been dropped since, its own formula before it was chosen.
    let mut rivals = rivals.to_vec();
    for own in rivals.iter_mut().filter(|l| l.family == family) {
        if own.best.as_ref().is_none_or(|best| candidate.rank < best.rank) {
            own.best = Some(candidate.clone());
        }
    }
    let beliefs = belief::beliefs(&sight, &rivals, candidate);
    let is_effect = match candidate.picks.len() {
        1 => 1.0,
        _ => belief::is_effect(&sight, candidate, explained),
    };
    let probability = is_effect
        * candidate.doubt(&o.library, slot)
        * beliefs.iter().find(|b| b.family == family).map_or(0.0, |b| b.probability);
    let mut set: Vec<String> =
        belief::set(&beliefs).into_iter().map(|f| o.library[f].effect.name.to_owned()).collect();
    if !set.iter().any(|name| name == effect.name) {
        set.insert(0, effect.name.to_owned());
    }
    // Nobody knows under which of the readings that explain the log it was taken.
    let probability = probability / (1 + o.otherwise.len()) as f64;
    for (_, name) in &o.otherwise {
        if !set.iter().any(|known| known == name) {
            set.push((*name).to_owned());
        }
    }
    NamedEffect {
        effect: effect.name.to_owned(),
        output: o.task.output.clone(),
        also: Vec::new(),
        stage: effect.stage.name().to_owned(),
        probability,
        set,
        group: effect.group.map(|g| group(g).to_owned()),
        parameters: parameters(o, candidate, slot),
        explained,
    }
}

/// What the best single effect would do where none is named: of those that help on held-out rows.
fn partial(o: &Outcome) -> Option<Partial> {
    if o.verdict != Verdict::Unknown {
        return None;
    }
    let before = &o.found.base.judged;
    let part = |c: &Candidate| explained(before, &c.judged);
    let fitted = o.found.first.iter().filter_map(|l| l.best.as_ref());
    let best = fitted.filter(|c| part(c) > 0.0).min_by(|a, b| a.rank.total_cmp(&b.rank))?;
    let rms = |judged: &Judged| o.sigma / o.task.factor * judged.held_out.max(0.0).sqrt();
    let count = AtomicU64::new(0);
    let predicted = own_course::left_out(best, &o.judge, &o.task.data, o.sigma, &count);
    Some(Partial {
        effect: effect_of(o, (best, 0), &o.found.first, part(best)),
        rms_before: rms(before),
        rms_after: rms(predicted.as_ref().unwrap_or(&best.judged)),
        unit: o.task.unit.clone(),
        own_course: predicted.is_some().then(|| part(best)),
    })
}

/// The name of a group in files.
pub(crate) fn group(group: model::Group) -> &'static str {
    match group {
        model::Group::Lag => "lag",
        model::Group::Gain => "gain",
        model::Group::Slow => "slow",
        model::Group::StaticMap => "static_map",
    }
}

fn retuned(o: &Outcome, many: bool) -> Vec<(String, Retuned)> {
    let last = &o.found.last;
    let released = o.released(last);
    let mut all = Vec::new();
    for (k, p) in o.task.base.parameters.iter().enumerate() {
        if released.contains(&k) {
            continue;
        }
        if let Some(at) = last.chain.own(&p.name) {
            let q = last.fit.theta[at];
            all.push((
                p.name.clone(),
                Retuned {
                    from: p.value,
                    to: p.value + p.deviation * q,
                    tolerance: p.deviation,
                    unit: p.unit.clone(),
                    at_limit: is_at_limit(q),
                },
            ));
        }
    }
    if let Some(at) = last.chain.own(GAIN) {
        let (q, tolerance) = (last.fit.theta[at], o.task.base.gain_tolerance);
        let name = if many { format!("{}.gain", o.task.output) } else { GAIN.into() };
        let at_limit = is_at_limit(q);
        let unit = "1".to_owned();
        all.push((name, Retuned { from: 1.0, to: 1.0 + tolerance * q, tolerance, unit, at_limit }));
    }
    all
}

/// Whether the coordinate of a parameter with a tolerance is at its bound.
fn is_at_limit(q: f64) -> bool {
    q.abs() >= base::Thresholds::PRIOR_BOX - 1e-9
}

fn tried(o: &Outcome) -> Vec<Tried> {
    let base = &o.found.base;
    let first = o.found.first.iter().find_map(|l| l.best.as_ref());
    let beliefs =
        first.map(|own| belief::beliefs(&o.sight(), &o.found.first, own)).unwrap_or_default();
    let finite = |v: f64| v.is_finite().then_some(v);
    o.found
        .first
        .iter()
        .map(|l| {
            let effect = o.library[l.family].effect.name;
            let best = l.best.as_ref();
            let formula = best.map_or("", |c| &*o.library[l.family].formulas[c.picks[0].1].name);
            let of_family = |b: &&belief::Belief| b.family == l.family;
            let doubt = best.map_or(1.0, |c| c.doubt(&o.library, 0));
            Tried {
                effect: effect.to_owned(),
                output: o.task.output.clone(),
                formula: formula.to_owned(),
                score: best.and_then(|c| finite(o.judge.score(&base.judged, &c.judged))),
                training: best.and_then(|c| finite(c.fit.mean_square)),
                holdout: best.and_then(|c| finite(c.judged.held_out)),
                screening: if l.screening.is_finite() { l.screening } else { 0.0 },
                probability: doubt * beliefs.iter().find(of_family).map_or(0.0, |b| b.probability),
                accepted: o.found.last.picks.iter().any(|(f, _)| *f == l.family),
                left_out: l
                    .why
                    .or((doubt < 1.0).then_some(Why::AtBound))
                    .map(|why| why.text().to_owned()),
                parameters: best.map(|c| parameters(o, c, 0)).unwrap_or_default(),
            }
        })
        .collect()
}

fn provenance(request: &Request, simulations: u64) -> Provenance {
    let (model, kind) = match &request.model {
        Model::Blueprint(blueprint) => (blueprint.spec().name.clone(), ModelKind::WhiteBox),
        Model::Fmu(path) => (path.display().to_string(), ModelKind::BlackBox),
    };
    let split = if request.holdout.is_empty() {
        format!(
            "the last {:.0} % of each record, simulated from the record's start",
            100.0 * base::Thresholds::HELD_OUT
        )
    } else {
        "the logs given for it".to_owned()
    };
    let split = match request.drop {
        None | Some(0.0) => split,
        Some(drop) => format!("{split}; the first {drop} s of each record are a run-in"),
    };
    let origins = |logs: &[data::Log]| logs.iter().map(|l| l.origin().to_owned()).collect();
    Provenance {
        tool: "piezoloop".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        model,
        kind,
        logs: origins(&request.logs),
        holdout: origins(&request.holdout),
        split,
        seed: request.seed,
        without: request.without.clone(),
        simulations,
    }
}
