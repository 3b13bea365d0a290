//! A diagnosis from logs alone, made again with other linear models where the first one may stand in the way.
//!
//! A linear model that is identified from the logs of a machine with an effect lacks dynamics that the effect hides, or has
//! dynamics that imitate it. Neither is missing in a machine. So the answer is sought with the gain alone, too, and with the
//! dynamics that the diagnosis found; one is taken that explains the logs with fewer effects.

use data::Blueprint;
use diagnose::{Diagnosis, Gap, Model, Observer, Request, Verdict};

use super::baseline::{self, Generated};
use super::thresholds::Thresholds;

/// The diagnosis, or one with another linear model that is better, with the model.
pub(super) fn better(
    first: Diagnosis,
    model: &mut Generated,
    request: &Request,
    observer: &mut dyn Observer,
) -> anyhow::Result<Diagnosis> {
    let mut best = first;
    let leaves_much =
        model.baselines.iter().any(|b| b.nrmse[1].is_some_and(|part| part > Thresholds::IMITATES));
    if is_doubtful(&best.gap) && leaves_much {
        let gains = baseline::gains_alone(&model.text.blueprint);
        let what = "the gain alone, as its dynamics imitate the effect";
        best = tried(best, gains, what, model, request, observer)?;
    }
    if is_doubtful(&best.gap) {
        let completed = best.linear_parts(&model.text.blueprint);
        let what = "the dynamics that the diagnosis found beside the effect";
        best = tried(best, completed, what, model, request, observer)?;
    }
    Ok(best)
}

/// The diagnosis, or the one with this linear model.
fn tried(
    best: Diagnosis,
    blueprint: Option<Blueprint>,
    what: &str,
    model: &mut Generated,
    request: &Request,
    observer: &mut dyn Observer,
) -> anyhow::Result<Diagnosis> {
    let Some(blueprint) = blueprint else { return Ok(best) };
    let other = model.with(blueprint, what)?;
    let checked = other.text.blueprint.clone().check(learned::COMPONENTS)?;
    let request = Request { model: Model::Blueprint(Box::new(checked)), ..request.clone() };
    match diagnose::examine(&request, observer) {
        Ok(diagnosis) if is_better(&diagnosis.gap, &best.gap) => {
            *model = other;
            Ok(diagnosis)
        }
        _ => Ok(best),
    }
}

/// Whether another linear model may give a better answer.
fn is_doubtful(gap: &Gap) -> bool {
    let is_linear = |effect: &diagnose::NamedEffect| diagnose::is_linear(&effect.effect);
    gap.verdict == Verdict::Unknown || gap.effects.len() > 1 || gap.effects.iter().any(is_linear)
}

fn is_better(other: &Gap, best: &Gap) -> bool {
    let after = |gap: &Gap| gap.shrink.rms_after;
    other.verdict.is_explained()
        && match best.verdict.is_explained() {
            true => {
                other.effects.len() < best.effects.len()
                    && after(other) <= Thresholds::AS_MUCH * after(best)
            }
            false => after(other) < after(best),
        }
}
