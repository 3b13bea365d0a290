//! What is named from the readings themselves: their noise and their steps.

use crate::gap::Estimate;
use crate::gap::NamedEffect;
use crate::outcome::Outcome;
use crate::thresholds::answer::Thresholds;
use components::effects;
use std::collections::BTreeMap;

/// Noise beside the one that was stated, as an effect of the sensor.
pub(super) fn noisier(o: &Outcome) -> Option<NamedEffect> {
    let factor = o.noise_ratio?;
    let effect = &effects::SENSOR_NOISE;
    let value = o.sigma / o.task.factor * (factor * factor - 1.0).max(0.0).sqrt();
    let unit = o.task.unit.clone();
    let beside = Estimate { value, std: None, unit };
    Some(NamedEffect {
        effect: effect.name.to_owned(),
        output: o.task.output.clone(),
        also: Vec::new(),
        stage: effect.stage.name().to_owned(),
        probability: Thresholds::SURE_OF_NOISE,
        set: vec![effect.name.to_owned()],
        group: None,
        parameters: BTreeMap::from([(format!("{}.standard_deviation", effect.name), beside)]),
        explained: 1.0,
    })
}

/// The steps of the reading that its values show.
pub(super) fn stepped(o: &Outcome) -> Option<NamedEffect> {
    let steps = o.task.steps?;
    let effect = &effects::SENSOR_QUANTISATION;
    let of = |value: f64, unit: &str| Estimate { value, std: None, unit: unit.to_owned() };
    let parameters = BTreeMap::from([
        (format!("{}.step", effect.name), of(steps.size / o.task.factor, &o.task.unit)),
        (format!("{}.phase", effect.name), of(steps.phase, "1")),
    ]);
    Some(NamedEffect {
        effect: effect.name.to_owned(),
        output: o.task.output.clone(),
        also: Vec::new(),
        stage: effect.stage.name().to_owned(),
        probability: Thresholds::SURE_OF_STEPS,
        set: vec![effect.name.to_owned()],
        group: None,
        parameters,
        explained: steps.share(&o.found.last.judged, o.sigma),
    })
}
