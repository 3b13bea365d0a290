//! One cause that several outputs of a model show is named once.
//!
//! What belongs to the structure (a mode that is softer, damped more, or missing) moves every output that sees it.
//! Each output is diagnosed by itself; where they agree on frequency and damping, or on the model's own parameters,
//! it is one cause. Then a name must be in the sets of all of them.

use crate::formula::Slot;
use crate::gap::{Estimate, NamedEffect};
use crate::outcome::Outcome;
use crate::thresholds::answer::Thresholds;

/// The effects, those in front of a coupling with the readings of other axes that they move.
pub(super) fn moving(mut effects: Vec<NamedEffect>, outcomes: &[Outcome]) -> Vec<NamedEffect> {
    for effect in &mut effects {
        let Some(o) = outcomes.iter().find(|o| o.task.output == effect.output) else { continue };
        let last = &o.found.last;
        let own = last.picks.iter().zip(o.formulas(last));
        let is_in_front = own
            .filter(|((family, _), _)| o.library[*family].effect.name == effect.effect)
            .any(|(_, formula)| {
                formula.force.is_some()
                    || formula.pieces.iter().any(|piece| piece.slot < Slot::AfterMechanics)
            });
        let moved = outcomes.iter().filter(|other| other.moved_by.contains(&(o.task.axis - 1)));
        if is_in_front {
            effect.also.extend(moved.map(|other| other.task.output.clone()));
        }
    }
    effects
}

/// The effects with each shared cause once: in the output `main`, or where it explains most, the others in `also`.
pub(super) fn once(
    effects: Vec<NamedEffect>,
    outcomes: &[Outcome],
    main: &str,
) -> Vec<NamedEffect> {
    // Axes of a blueprint that nothing couples share nothing.
    let is_joined = |o: &Outcome| !o.task.base.is_white || o.task.base.joint().is_some();
    let is_box = |output: &str| outcomes.iter().any(|o| o.task.output == output && is_joined(o));
    let mut rest = effects;
    let first = |e: &NamedEffect| (e.output == main, e.explained);
    rest.sort_by(|a, b| {
        let (a, b) = (first(a), first(b));
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    let mut all: Vec<NamedEffect> = Vec::new();
    for effect in rest {
        let same = all.iter_mut().find(|e| is_same(e, &effect));
        match same.filter(|_| is_box(&effect.output)) {
            Some(same) => join(same, effect),
            None => all.push(effect),
        }
    }
    all
}

/// Whether an effect of another output is the same cause.
fn is_same(a: &NamedEffect, b: &NamedEffect) -> bool {
    let is_elsewhere = a.output != b.output && !a.also.contains(&b.output);
    let (mut any, mut all) = (false, true);
    for (name, of_a) in common(a) {
        any = true;
        all &= b.parameters.get(name).is_some_and(|of_b| agree(of_a, of_b));
    }
    is_elsewhere && a.effect == b.effect && a.stage == "mechanics" && any && all
}

/// Parameters that outputs have in common: the model's own, and frequencies.
fn common(e: &NamedEffect) -> impl Iterator<Item = (&String, &Estimate)> {
    let of_formula = format!("{}.", e.effect);
    e.parameters
        .iter()
        .filter(move |(name, p)| p.unit == "Hz" || !name.starts_with(&of_formula))
        .filter(|(name, _)| !is_of_output(e, name))
}

/// Whether a parameter was taken over from another output.
fn is_of_output(e: &NamedEffect, name: &str) -> bool {
    e.also
        .iter()
        .any(|output| name.strip_prefix(output.as_str()).is_some_and(|n| n.starts_with('.')))
}

fn agree(a: &Estimate, b: &Estimate) -> bool {
    let relative =
        if a.unit == "Hz" { Thresholds::SAME_FREQUENCY } else { Thresholds::SAME_DAMPING };
    let deviation = a.std.unwrap_or(0.0).hypot(b.std.unwrap_or(0.0));
    let most = (relative * a.value.abs()).max(Thresholds::SAME_DEVIATIONS * deviation);
    (a.value - b.value).abs() <= most
}

/// Adds what another output says of the same cause.
fn join(own: &mut NamedEffect, other: NamedEffect) {
    let shared: Vec<String> = common(own).map(|(name, _)| name.clone()).collect();
    for (name, of_other) in other.parameters {
        if let Some(of_own) = own.parameters.get_mut(&name).filter(|_| shared.contains(&name)) {
            *of_own = mean(of_own, &of_other);
        } else {
            own.parameters.insert(format!("{}.{name}", other.output), of_other);
        }
    }
    own.probability = own.probability.max(other.probability);
    own.set.retain(|name| *name == own.effect || other.set.contains(name));
    own.also.push(other.output);
}

/// Mean of two estimates, weighted by their accuracy.
fn mean(a: &Estimate, b: &Estimate) -> Estimate {
    let known = |e: &Estimate| e.std.filter(|s| *s > 0.0);
    let (Some(of_a), Some(of_b)) = (known(a), known(b)) else { return a.clone() };
    let (wa, wb) = (of_a.powi(-2), of_b.powi(-2));
    Estimate {
        value: (wa * a.value + wb * b.value) / (wa + wb),
        std: Some((wa + wb).sqrt().recip()),
        unit: a.unit.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effect(name: &str, output: &str, parameters: &[(&str, f64, &str)]) -> NamedEffect {
        let estimate = |(name, value, unit): &(&str, f64, &str)| {
            let std = Some(0.001 * value);
            ((*name).to_owned(), Estimate { value: *value, std, unit: (*unit).to_owned() })
        };
        NamedEffect {
            effect: name.to_owned(),
            output: output.to_owned(),
            also: Vec::new(),
            stage: "mechanics".to_owned(),
            probability: 0.8,
            set: vec![name.to_owned(), format!("other of {output}")],
            group: None,
            parameters: parameters.iter().map(estimate).collect(),
            explained: 0.9,
        }
    }

    #[test]
    fn what_outputs_agree_on_is_one_cause_and_what_they_do_not_is_none() {
        let of = |output, frequency, weight| {
            effect(
                "extra_mode",
                output,
                &[("extra_mode.frequency", frequency, "Hz"), ("extra_mode.weight", weight, "1")],
            )
        };
        let (mut a, b) = (of("y1", 400.0, 0.02), of("y2", 401.0, -0.1));
        assert!(is_same(&a, &b), "a weight belongs to its output");
        assert!(!is_same(&a, &of("y2", 430.0, 0.02)) && !is_same(&a, &of("y1", 400.0, 0.02)));
        join(&mut a, b);
        assert_eq!(a.also, ["y2"]);
        assert_eq!(a.set, ["extra_mode"], "no rival is in both sets");
        let frequency = &a.parameters["extra_mode.frequency"];
        assert!((frequency.value - 400.5).abs() < 0.01 && frequency.std.unwrap() < 0.3);
        assert_eq!(a.parameters["y2.extra_mode.weight"].value, -0.1);
        // A third one is held against what all have in common.
        assert!(is_same(&a, &of("y3", 400.0, 0.5)));
        // The model's own parameters: each must agree.
        let own = |output, first, second| {
            effect(
                "damping",
                output,
                &[("modes.damping[1]", first, "1"), ("modes.damping[2]", second, "1")],
            )
        };
        assert!(is_same(&own("y1", 0.03, 0.06), &own("y2", 0.031, 0.06)));
        assert!(!is_same(&own("y1", 0.03, 0.06), &own("y2", 0.06, 0.03)));
        let mut elsewhere = of("y2", 400.0, 0.1);
        elsewhere.stage = "sensor".to_owned();
        assert!(!is_same(&elsewhere, &of("y1", 400.0, 0.1)), "each reading has its own sensor");
    }
}
