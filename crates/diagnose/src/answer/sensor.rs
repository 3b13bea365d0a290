//! What is named from the readings themselves: their noise and their steps.

use std::collections::BTreeMap;

use components::effects;
use model::Effect;

use crate::gap::{Estimate, NamedEffect};
use crate::outcome::Outcome;
use crate::thresholds::answer::Thresholds;

/// Noise beside the one that was stated, as an effect of the sensor.
pub(super) fn noisier(o: &Outcome) -> Option<NamedEffect> {
    let factor = o.noise_ratio?;
    let beside = o.sigma / o.task.factor * (factor * factor - 1.0).max(0.0).sqrt();
    let parameters = [("standard_deviation", beside, o.task.unit.as_str())];
    Some(shown(o, &effects::SENSOR_NOISE, &parameters, (Thresholds::SURE_OF_NOISE, 1.0)))
}

/// The steps of the reading that its values show.
pub(super) fn stepped(o: &Outcome) -> Option<NamedEffect> {
    let steps = o.task.steps?;
    let step = steps.size / o.task.factor;
    let parameters = [("step", step, o.task.unit.as_str()), ("phase", steps.phase, "1")];
    let share = steps.share(&o.found.last.judged, o.sigma);
    Some(shown(o, &effects::SENSOR_QUANTISATION, &parameters, (Thresholds::SURE_OF_STEPS, share)))
}

/// An effect with name, value and unit of its parameters, its probability and what it explains.
fn shown(
    o: &Outcome,
    effect: &Effect,
    parameters: &[(&str, f64, &str)],
    (probability, explained): (f64, f64),
) -> NamedEffect {
    let parameters = parameters.iter().map(|(name, value, unit)| {
        let estimate = Estimate { value: *value, std: None, unit: (*unit).to_owned() };
        (format!("{}.{name}", effect.name), estimate)
    });
    NamedEffect {
        effect: effect.name.to_owned(),
        output: o.task.output.clone(),
        also: Vec::new(),
        stage: effect.stage.name().to_owned(),
        probability,
        set: vec![effect.name.to_owned()],
        group: None,
        parameters: parameters.collect::<BTreeMap<_, _>>(),
        explained,
    }
}
